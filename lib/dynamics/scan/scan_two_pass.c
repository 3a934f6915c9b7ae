/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan with two passes: every segment's factors know the inertia outboard of them, so
 * that they are those of the articulated-body algorithm wherever the chain is cut.
 */
#include "dynamics/scan/scan.h"

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return TFA_V(scan_factor)(s, chain, rows, -1); /* every cut */
}

CHAIN_METHOD(scan_two_pass) = {.bytes = TFA_V(scan_bytes),
                               .factor = factor,
                               .solve = TFA_V(scan_solve),
                               .osim = TFA_V(scan_lambda)};
