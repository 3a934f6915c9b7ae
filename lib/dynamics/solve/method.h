/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of methods: one row for each, the behaviour of the method in a kernel. Names, ops,
 * costs and refusals are in TFA_METHOD_LIST (totalforce/dynamics.h).
 *
 * A forward-dynamics method is a pair: factor (depends on q only) and solve (any right-hand side
 * with kept factors), so that refinement and Lambda^-1 reuse the factors.
 */
#ifndef TFA_DYNAMICS_SOLVE_METHOD_H
#define TFA_DYNAMICS_SOLVE_METHOD_H

#include "dynamics/chain/chain.h"

struct method {
    /* A method along chains has these three by chain.c. Others: factors, unless they are there; x =
     * M^-1 rhs with kept factors, x may be rhs; s->qdd of s->tau, leaving the factors. */
    const struct chain_method *chain;
    /* The same for chains that are computed in segments (tfa_cut_segments); NULL: no other */
    const struct chain_method *chain_of_segments;
    void (*factor)(struct state *s);
    void (*solve)(struct state *s, const num *rhs, num *x);
    void (*forward)(struct state *s);
    /* Its solutions obey the mimics; all others are projected (mimic.c). */
    int obeys_mimics;
    /* Lambda^-1 with the articulated-body factors of the tips' trees, without mimics; NULL: none */
    void (*osim)(struct state *s, tfa_reference_frame frame);
    /* Lambda^-1 without factors of the whole robot: TFA_OK, TFA_E_SINGULAR with s->bad_body, or
     * TFA_E_UNSUPPORTED for these tips; NULL: none */
    int (*osim_elimination)(struct state *s, tfa_reference_frame frame);
    /* The sentinel's margin of its factors; NULL: that of aba, which looks while factoring */
    num (*margin)(const struct state *s);
    /* It is the segment scan, with which another scan is not to be replaced. */
    int is_scan;
};

/* The row of a method; of one that a batch does not have, a row of zeros */
const struct method *TFA_V(method)(tfa_method method);

/* How it goes along the chains of a robot; NULL: not along chains */
const struct chain_method *TFA_V(chain_of)(const struct state *s, tfa_method method);

/* Factors from inverse inertias may have lost a direction for good, and then see nothing of it.
 * This method's factors estimate the errors of those that invert, for no more than one of their
 * solves. */
#define METHOD_OF_ESTIMATES TFA_METHOD_ABA

static inline tfa_method method_of_estimates(tfa_method method)
{
    return method_inverts(method) ? METHOD_OF_ESTIMATES : method;
}

/* Whether its factors are those of the articulated-body algorithm */
static inline int has_articulated_factors(tfa_method method)
{
    return method_factors(method) == TFA_METHOD_ABA;
}

/* ---- fallbacks ---- */

/* Method of last resort: aba; with mimics crba, because T^T M T can be inverted wherever the
 * robot can move, and M cannot where followers weigh nothing or slide along their leaders. */
tfa_method TFA_V(last_resort)(const struct state *s);

/* Fallback of a method that failed: the scan, then the last resort. */
tfa_method TFA_V(fallback)(const struct state *s, tfa_method failed);

/* The name of Lambda^-1 by the factors of a method: force propagation by those of aba */
tfa_method TFA_V(osim_name)(tfa_method factors);

/* Whether Lambda^-1 by this method has no better fallback */
int TFA_V(osim_is_last)(const struct state *s, tfa_method method);

/* ---- factors and solves ---- */

/* qdd = M^-1 (tau - h), leaving the method's factors. TFA may refuse: TFA_E_SINGULAR,
 * s->bad_body. */
int TFA_V(forward_dynamics)(struct state *s, tfa_method method);
/* Factors of a method, unless they are there. TFA may refuse as before. */
int TFA_V(factor)(struct state *s, tfa_method method);
/* x = M^-1 rhs with kept factors of the method; x may be rhs. */
void TFA_V(solve)(struct state *s, tfa_method method, const num *rhs, num *x);
/* The same without regard to mimics. */
void TFA_V(solve_free)(struct state *s, tfa_method method, const num *rhs, num *x);
/* x, an acceleration that a method found without regard to mimics, becomes the one with. */
void TFA_V(impose_mimics)(struct state *s, tfa_method method, num *x);

/* ---- the sentinel over the factors of a method (core/sentinel.h) ---- */

/* Whether the sentinel trips for the factors that the method left */
int TFA_V(sentinel_of)(struct state *s, tfa_method method);

#endif
