/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constraint force algorithm.
 */
#include "kernel/chain.h"

static size_t bytes(size_t length)
{
    (void)length;
    return 0;
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    (void)s;
    (void)chain;
    (void)rows;
    return TFA_E_UNSUPPORTED;
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    (void)s;
    (void)chain;
    (void)rows;
    (void)tau;
    (void)qdd;
    (void)bias;
}

const struct chain_method TFA_V(cfa_method) = {TFA_METHOD_CFA, 1, bytes, factor, solve};
