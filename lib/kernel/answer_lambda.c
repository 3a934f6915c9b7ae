/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one state: alone, or with the factors that forward dynamics left.
 */
#include <math.h>

#include "kernel/answer.h"
#include "kernel/chain.h"
#include "kernel/kernel.h"
#include "kernel/lambda.h"
#include "kernel/load.h"

static inline void give_six(double *out, const six *x)
{
    if (sizeof(num) == sizeof(double))
        six_store((num *)(void *)out, x);
    else
        for (int e = 0; e < 6; e++)
            out[e] = (double)six_lane(x, e);
}

static inline void mirror(double *A, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            A[i * n + j] = A[j * n + i];
}

/* Lambda^-1 from its upper triangle, six numbers at a time as they were written: a load of more waits
 * until all of them have left the processor. Returns 1 when all of it is finite: x - x is 0 or not a number; as a
 * double, too. */
static int unload_lambda(const struct state *s, double *out)
{
    const size_t count = (size_t)36 * s->tips * s->tips;
    six sum = six_zero();
    num rest = num_of(0);
    for (size_t e = 0; e < count; e += 6) {
        const six x = six_load(s->lambda + e);
        sum = six_add(sum, num_of(1), six_sub(x, num_of(1), x));
        if (out)
            give_six(out + e, &x);
    }
    for (int k = 0; k < 6; k++)
        rest += six_lane(&sum, k);
    int finite = num_all(rest == num_of(0));
    for (size_t e = 0; NUM_EPSILON < 0x1p-60 && e < count; e++)
        finite &= isfinite((double)s->lambda[e]) != 0;
    if (out && s->tips == 1)
        mirror(out, 6); /* unrolled */
    else if (out)
        mirror(out, (size_t)6 * s->tips);
    return finite;
}

/* Lambda^-1 with the factors that the method left */
static void lambda_kept(struct state *s, tfa_reference_frame frame, tfa_method method,
                        uint32_t refine)
{
    if (method == TFA_METHOD_ABA && refine == 0 && !s->m->mimics) {
        TFA_V(lambda_propagation)(s, frame);
        return;
    }
    const int scan = method == TFA_METHOD_SCAN || method == TFA_METHOD_SCAN_TWO_PASS;
    if (scan && refine == 0 && TFA_V(scan_lambda)(s, frame))
        return;
    const struct chain_method *chain = TFA_V(chain_method)(method);
    if (chain && chain->six_forces && !s->m->mimics)
        TFA_V(lambda_chain)(s, frame, chain, refine);
    else if (chain || refine > 0 || s->m->mimics)
        TFA_V(lambda_columns)(s, frame, method, refine);
    else
        TFA_V(lambda_crba)(s, frame);
}

static double *place_of(const struct state *s, uint32_t k, const tfa_reply *reply)
{
    const size_t n = 6 * s->tips;
    return reply->lambda_inv ? reply->lambda_inv + n * n * k : NULL;
}

/* The way to Lambda^-1 that a request takes when it is to be neither refined nor projected: where
 * several tips share bodies, composed propagators are never slower (docs/methods.md). */
static tfa_method way_of(const struct state *s, const tfa_request *r)
{
    return r->method == TFA_METHOD_AUTO && s->tips > 1 ? TFA_METHOD_PV_OSIMR : r->method;
}

/* The ways that have the articulated-body factors in common; 0: this is none of them. */
static int by_wrenches(struct state *s, tfa_reference_frame frame, tfa_method way)
{
    if (way == TFA_METHOD_EFPA)
        TFA_V(lambda_efpa)(s, frame);
    else if (way == TFA_METHOD_PV_OSIMR)
        TFA_V(lambda_pv)(s, frame);
    else
        return 0;
    return 1;
}

int TFA_V(lambda_after)(struct state *s, const tfa_request *r, uint32_t k, tfa_method method,
                        uint32_t refine, tfa_reply *reply)
{
    const int plain = method == TFA_METHOD_ABA && refine == 0 && !s->m->mimics;
    if (!(plain && by_wrenches(s, r->frame, way_of(s, r))))
        lambda_kept(s, r->frame, method, refine);
    return unload_lambda(s, place_of(s, k, reply));
}

/* The answer of auto's method where the other's is no good. Returns whose factors it used. */
static tfa_method fall_back(struct state *s, tfa_reference_frame frame, tfa_answer *out)
{
    const tfa_method last = TFA_V(auto_method)(s);
    out->flags |= TFA_ANSWER_FALLBACK;
    (void)TFA_V(factor)(s, last);
    lambda_kept(s, frame, last, 0);
    return last;
}

/* Lambda^-1 by the factors of aba is called force propagation. */
static tfa_method named(tfa_method factors)
{
    return factors == TFA_METHOD_ABA ? TFA_METHOD_PROPAGATION : factors;
}

/* Whose factors a method uses; forward elimination of the tips goes by block solves when refined,
 * what has the articulated-body factors by columns. */
static tfa_method factors_of(const struct state *s, tfa_method method)
{
    switch (method) {
    case TFA_METHOD_AUTO:
        return TFA_V(auto_method)(s);
    case TFA_METHOD_PROPAGATION:
    case TFA_METHOD_EFPA:
    case TFA_METHOD_PV_OSIMR:
        return TFA_METHOD_ABA;
    case TFA_METHOD_TFA_ONE_SIDED:
        return TFA_METHOD_TFA;
    default:
        return method;
    }
}

/* Forward elimination of the tips needs no factors of the whole robot, its estimate does. */
static int one_sided(struct state *s, const tfa_request *r, tfa_method *factors, tfa_answer *out)
{
    int status = TFA_V(lambda_one_sided)(s, r->frame);
    *factors = TFA_METHOD_ABA;
    out->method = TFA_METHOD_TFA_ONE_SIDED;
    if (status == TFA_E_UNSUPPORTED) {
        *factors = fall_back(s, r->frame, out);
        out->method = (uint16_t)named(*factors);
        return TFA_OK;
    }
    if (status == TFA_OK && TFA_V(wants_estimate)(r, TFA_METHOD_TFA_ONE_SIDED))
        status = TFA_V(factor)(s, *factors);
    return status;
}

static int by_factors(struct state *s, const tfa_request *r, uint32_t steps, tfa_method factors,
                      tfa_answer *out)
{
    const int plain = steps == 0 && !s->m->mimics;
    const tfa_method way = plain ? way_of(s, r) : r->method;
    const int own_name =
        way == TFA_METHOD_TFA_ONE_SIDED || way == TFA_METHOD_EFPA || way == TFA_METHOD_PV_OSIMR;
    out->method = (uint16_t)(own_name ? way : named(factors));
    if (plain && !own_name && factors == TFA_METHOD_ABA && s->tips == 1 && !s->locked &&
        !(s->have & HAVE_ABA)) {
        TFA_V(lambda_fold)(s, r->frame);
        return TFA_OK;
    }
    const int status = TFA_V(factor)(s, factors);
    if (status == TFA_OK && !(plain && by_wrenches(s, r->frame, way)))
        lambda_kept(s, r->frame, factors, steps);
    return status;
}

/* Error estimate, and the answer of auto's method where it is too large. Returns 0 if it is above 1 then. */
static int estimate(struct state *s, const tfa_request *r, tfa_method factors, uint32_t steps,
                    tfa_answer *out)
{
    const tfa_reference_frame frame = r->frame;
    const tfa_method last = TFA_V(auto_method)(s);
    num_doubles error = TFA_V(lambda_error)(s, frame, factors, steps);
    TFA_V(tell_estimate)(s, r, &error, out);
    const uint16_t doubt = TFA_V(doubt)(&error, 1);
    if (out->method == (uint16_t)named(last) || out->method == TFA_METHOD_PV_OSIMR || !doubt)
        return TFA_V(is_answer)(s, r, factors, &error); /* by the same factors */
    out->flags |= doubt;
    (void)fall_back(s, frame, out);
    out->method = (uint16_t)named(last);
    error = TFA_V(lambda_error)(s, frame, last, 0);
    TFA_V(tell_estimate)(s, r, &error, out);
    return TFA_V(is_answer)(s, r, last, &error);
}

/* Once more with an estimate, which needs all bodies where the answer needed those of the tips' trees. */
static int answer_estimated(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                            tfa_answer *out)
{
    tfa_request whole = *r;
    whole.estimate = TFA_ESTIMATE_ALWAYS;
    TFA_V(load)(s, &whole, k, 1);
    return TFA_V(answer_lambda)(s, &whole, k, reply, out);
}

int TFA_V(answer_lambda)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *out)
{
    const uint32_t steps = TFA_V(refine_steps)(s, r, r->method);
    tfa_method factors = factors_of(s, r->method);
    const int status = r->method == TFA_METHOD_TFA_ONE_SIDED && steps == 0
                           ? one_sided(s, r, &factors, out)
                           : by_factors(s, r, steps, factors, out);
    if (status != TFA_OK)
        return status;
    const int certified = TFA_V(wants_estimate)(r, (tfa_method)out->method);
    if (!certified && TFA_V(alarmed)(s, r, factors, out))
        return answer_estimated(s, r, k, reply, out);
    const int sound = !certified || estimate(s, r, factors, steps, out);
    if (unload_lambda(s, place_of(s, k, reply)) && sound)
        return TFA_OK;
    TFA_V(blame)(s, reply);
    return TFA_E_NOT_COMPUTED;
}
