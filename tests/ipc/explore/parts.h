/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The parts of the test; each prints a table. @return number of failures
 */
#ifndef TFA_EXPLORER_PARTS_H
#define TFA_EXPLORER_PARTS_H

#include "explorer.h"

int litmus_run(void);
int scenarios_run(void);
int mutations_run(void);

/** First scenario, in the order of the table, with a finding; NULL: none has one. `finding`: which.
 *  A finding in the scenarios tried last is found at once: `hint` is tried first. */
const char *scenarios_find(const char **finding, int *hint);

#endif
