/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one state: alone, or with the factors that forward dynamics left.
 */
#include <math.h>

#include "dynamics/osim/lambda.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"

static inline void store_vec6(double *out, const vec6 *x)
{
    if (sizeof(num) == sizeof(double))
        vec6_store((num *)(void *)out, x);
    else
        for (int e = 0; e < 6; e++)
            out[e] = (double)vec6_lane(x, e);
}

static inline void mirror(double *A, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            A[i * n + j] = A[j * n + i];
}

/* The rows of points: the first three of every six. Returns 1 when all of it is finite. */
static int unload_points(const struct state *s, double *out)
{
    const size_t n = (size_t)3 * s->tips;
    int finite = 1;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i; j < n; j++) {
            const size_t row = i / 3 * 6 + i % 3, column = j / 3 * 6 + j % 3;
            const double x = (double)s->lambda[row * 6 * s->tips + column];
            finite &= isfinite(x) != 0;
            if (out)
                out[i * n + j] = out[j * n + i] = x;
        }
    return finite;
}

/* Lambda^-1 from its upper triangle, six numbers at a time as they were written: a load of more
 * waits until all of them have left the processor. Returns 1 when all of it is finite: x - x is 0
 * or not a number; as a double, too. */
static int unload_lambda(const struct state *s, double *out)
{
    if (s->tip_rows != 6)
        return unload_points(s, out);
    const size_t count = (size_t)36 * s->tips * s->tips;
    vec6 sum = vec6_zero();
    num rest = num_of(0);
    for (size_t e = 0; e < count; e += 6) {
        const vec6 x = vec6_load(s->lambda + e);
        sum = vec6_add_scaled(sum, num_of(1), vec6_sub_scaled(x, num_of(1), x));
        if (out)
            store_vec6(out + e, &x);
    }
    for (int k = 0; k < 6; k++)
        rest += vec6_lane(&sum, k);
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
    const struct method *row = TFA_V(method)(method);
    const struct chain_method *chain = TFA_V(chain_of)(s, method);
    if (row->osim && refine == 0 && !s->m->mimics)
        row->osim(s, frame);
    else if (chain && chain->osim && refine == 0 && chain->osim(s, frame))
        return;
    else if (chain && chain->forces_6rhs && !s->m->mimics)
        TFA_V(lambda_chain)(s, frame, chain, refine);
    else if (chain || refine > 0 || s->m->mimics)
        TFA_V(lambda_columns)(s, frame, method, refine);
    else
        TFA_V(lambda_crba)(s, frame);
}

static double *lambda_of_state(const struct state *s, uint32_t k, const tfa_reply *reply)
{
    const size_t n = (size_t)s->tip_rows * s->tips;
    return reply->lambda_inv ? reply->lambda_inv + n * n * k : NULL;
}

int TFA_V(lambda_after)(struct state *s, const tfa_request *r, uint32_t k, tfa_method method,
                        uint32_t refine, tfa_reply *reply)
{
    /* another way of propagation has the same factors */
    const int propagates = TFA_V(method)(method)->osim && TFA_V(method)(s->by.osim)->osim &&
                           refine == 0 && !s->m->mimics;
    lambda_kept(s, r->frame, propagates ? s->by.osim : method, refine);
    return unload_lambda(s, lambda_of_state(s, k, reply));
}

/* The answer of auto's method where the other's is no good. Returns whose factors it used. */
static tfa_method fallback_lambda(struct state *s, tfa_reference_frame frame, tfa_answer *out)
{
    const tfa_method last = TFA_V(last_resort)(s);
    out->flags |= TFA_ANSWER_FALLBACK;
    (void)TFA_V(factor)(s, last);
    lambda_kept(s, frame, last, 0);
    return last;
}

/* Forward elimination of the tips needs no factors of the whole robot, its estimate does. */
static int one_sided(struct state *s, const tfa_request *r, tfa_method *factors, tfa_answer *out)
{
    const tfa_method method = s->by.method;
    int status = TFA_V(method)(method)->osim_elimination(s, r->frame);
    *factors = METHOD_OF_ESTIMATES;
    out->method = (uint16_t)method;
    if (status == TFA_E_UNSUPPORTED) {
        *factors = fallback_lambda(s, r->frame, out);
        out->method = (uint16_t)TFA_V(osim_name)(*factors);
        return TFA_OK;
    }
    if (status == TFA_OK && TFA_V(wants_estimate)(r, method))
        status = TFA_V(factor)(s, *factors);
    return status;
}

static int by_factors(struct state *s, const tfa_request *r, uint32_t steps, tfa_method factors,
                      tfa_answer *out)
{
    const tfa_method way = s->by.method;
    const struct method *row = TFA_V(method)(way);
    const int plain = steps == 0 && !s->m->mimics;
    out->method = (uint16_t)TFA_V(osim_name)(way);
    if (plain && row->osim == TFA_V(lambda_propagation) && s->tips == 1 && !s->locked &&
        !HAS_MODES(s) && !(s->have & HAVE_ABA)) {
        TFA_V(lambda_while_factoring)(s, r->frame);
        return TFA_OK;
    }
    const int status = TFA_V(factor)(s, factors);
    if (status == TFA_OK)
        lambda_kept(s, r->frame, plain && row->osim ? way : factors, steps);
    return status;
}

/* Error estimate, and the answer of auto's method where it is too large. Returns 0 if it is
 * above 1 then. */
static int estimate(struct state *s, const tfa_request *r, tfa_method factors, uint32_t steps,
                    tfa_answer *out)
{
    const tfa_reference_frame frame = r->frame;
    const tfa_method last = TFA_V(last_resort)(s);
    num_doubles error = TFA_V(lambda_error)(s, frame, factors, steps);
    TFA_V(store_estimate)(s, r, &error, out);
    const uint16_t fallback_reason = TFA_V(needs_fallback)(&error, 1);
    if (TFA_V(osim_is_last)(s, (tfa_method)out->method) || !fallback_reason)
        return TFA_V(estimate_is_valid)(s, r, factors, &error); /* by the same factors */
    out->flags |= fallback_reason;
    (void)fallback_lambda(s, frame, out);
    out->method = (uint16_t)TFA_V(osim_name)(last);
    error = TFA_V(lambda_error)(s, frame, last, 0);
    TFA_V(store_estimate)(s, r, &error, out);
    return TFA_V(estimate_is_valid)(s, r, last, &error);
}

/* Once more with an estimate, which needs all bodies where the answer needed those of the tips'
 * trees. */
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
    const uint32_t steps = TFA_V(refine_steps)(s, r, s->by.method);
    tfa_method factors = method_factors(s->by.method);
    const int status = TFA_V(method)(s->by.method)->osim_elimination && steps == 0
                           ? one_sided(s, r, &factors, out)
                           : by_factors(s, r, steps, factors, out);
    if (status != TFA_OK)
        return status;
    const int with_estimate = TFA_V(wants_estimate)(r, (tfa_method)out->method);
    if (!with_estimate && TFA_V(sentinel_asks_estimate)(s, r, factors, out))
        return answer_estimated(s, r, k, reply, out);
    const int valid = !with_estimate || estimate(s, r, factors, steps, out);
    if (unload_lambda(s, lambda_of_state(s, k, reply)) && valid)
        return TFA_OK;
    TFA_V(report_singular_body)(s, reply);
    return TFA_E_NOT_COMPUTED;
}
