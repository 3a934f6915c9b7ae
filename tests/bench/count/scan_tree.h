/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan with its segments joined by a tree, as many processors would: the library's
 * one thread joins them one after the other, which is less work.
 */
#ifndef TFA_COUNT_SCAN_TREE_H
#define TFA_COUNT_SCAN_TREE_H

#include "dynamics/scan/scan.h"

/* qdd of the chain by the library's segments, one pass, and two sweeps over a tree of elements. */
void scan_tree(state *s, const tfa_chain *chain, void *rows, const num *tau, num *qdd);

#endif
