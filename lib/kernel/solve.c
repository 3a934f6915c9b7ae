/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every method as a pair: factors, which depend on q only, and solves with kept factors.
 */
#include "kernel/chain.h"
#include "kernel/kernel.h"
#include "kernel/lock.h"

int TFA_V(factor)(struct state *s, tfa_method method)
{
    const struct chain_method *chain =
        method == TFA_METHOD_ABA ? NULL : TFA_V(chain_method)(method);
    if (chain)
        return TFA_V(chain_factor)(s, chain);
    if (method == TFA_METHOD_CRBA && !(s->have & HAVE_LTDL)) {
        TFA_V(crba)(s);
        TFA_V(ltdl_factor)(s);
    } else if (method != TFA_METHOD_CRBA && s->locked) {
        TFA_V(lock_factor)(s);
    } else if (method != TFA_METHOD_CRBA) {
        TFA_V(aba_factor)(s);
    }
    return TFA_OK;
}

void TFA_V(solve_free)(struct state *s, tfa_method method, const num *rhs, num *x)
{
    const struct chain_method *chain = TFA_V(chain_method)(method);
    if (chain)
        TFA_V(chain_solve)(s, chain, rhs, x, 0);
    else if (s->locked)
        TFA_V(lock_solve)(s, rhs, x);
    else
        TFA_V(aba_solve)(s, rhs, x);
}

void TFA_V(solve)(struct state *s, tfa_method method, const num *rhs, num *x)
{
    if (method == TFA_METHOD_CRBA) {
        for (uint32_t j = 0; j < s->m->freedoms; j++)
            x[j] = rhs[j];
        TFA_V(ltdl_solve)(s, x);
        return;
    }
    TFA_V(solve_free)(s, method, rhs, x);
    TFA_V(follow)(s, method, x);
}
