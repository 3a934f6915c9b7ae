/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The order S of the seq_cst operations of one execution, kept as its constraints: S exists while
 * they have no cycle. Fixing S to the order of execution would miss executions in which S
 * contradicts a relaxed read.
 */
#ifndef TFA_EXPLORER_SC_ORDER_H
#define TFA_EXPLORER_SC_ORDER_H

#include <stdbool.h>

/** A set of seq_cst operations */
__extension__ typedef unsigned __int128 sc_set;
#define SC_OPERATIONS 128
#define SC_BIT(k) ((sc_set)1 << (k))

void sc_reset(void);

/** Adds an operation that follows the operations of `before` and precedes those of `after`.
 *  @return its number; -1: there are too many */
int sc_add(sc_set before, sc_set after);

/** Whether such an operation could be added without a cycle. */
bool sc_possible(sc_set before, sc_set after);

#endif
