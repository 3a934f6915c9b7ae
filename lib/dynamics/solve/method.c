/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of methods, and factor and solve for every row.
 */
#include "dynamics/solve/method.h"

#include "dynamics/core/lock.h"
#include "dynamics/core/recursions.h"
#include "dynamics/core/sentinel.h"
#include "dynamics/osim/lambda.h"

/* ---- articulated bodies ---- */

static void articulated_factor(struct state *s)
{
    if (s->locked)
        TFA_V(lock_factor)(s);
    else
        TFA_V(aba_factor)(s);
}

static void articulated_solve(struct state *s, const num *rhs, num *x)
{
    if (s->locked)
        TFA_V(lock_solve)(s, rhs, x);
    else
        TFA_V(aba_solve)(s, rhs, x);
}

static void articulated_forward(struct state *s)
{
    if (s->locked)
        TFA_V(lock)(s, s->tau, s->qdd);
    else
        TFA_V(aba)(s, s->tau, s->keeps_force ? NULL : s->qdd);
}

/* ---- the mass matrix ---- */

static void mass_factor(struct state *s)
{
    if (s->have & HAVE_LTDL)
        return;
    TFA_V(crba)(s);
    TFA_V(ltdl_factor)(s);
    s->mass_margin = TFA_V(sentinel_margin_mass)(s);
}

static num mass_margin(const struct state *s)
{
    return s->mass_margin;
}

static void mass_solve(struct state *s, const num *rhs, num *x)
{
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        x[j] = rhs[j];
    TFA_V(ltdl_solve)(s, x);
}

/* qdd = M^-1 (tau - h) */
static void mass_forward(struct state *s)
{
    const uint32_t n = s->m->freedoms;
    mass_factor(s);
    for (uint32_t j = 0; j < n; j++)
        s->dx[j] = num_of(0);
    TFA_V(rnea)(s, s->dx, s->res, 1);
    for (uint32_t j = 0; j < n; j++)
        s->qdd[j] = s->tau[j] - s->res[j];
    TFA_V(ltdl_solve)(s, s->qdd);
}

/* ---- the table ---- */

#define ARTICULATED                                                                                \
    .factor = articulated_factor, .solve = articulated_solve, .forward = articulated_forward
#define CHAIN(name) .chain = &TFA_V(name##_method)
extern const struct chain_method TFA_V(tfa_method), TFA_V(tfa_cr_method), TFA_V(hessenberg_method),
    TFA_V(cfa_method), TFA_V(cfa_cr_method), TFA_V(dca_method), TFA_V(scan_method),
    TFA_V(scan_two_pass_method), TFA_V(hybrid_method), TFA_V(segments_method);

#if NUM_LANES > 1 /* batches have neither these nor tips */
#define SINGLE(...)                                                                                \
    {                                                                                              \
        0                                                                                          \
    }
#define OSIM(name) NULL
#define SEGMENTS
#else
#define SINGLE(...)                                                                                \
    {                                                                                              \
        __VA_ARGS__                                                                                \
    }
#define OSIM(name) TFA_V(name)
#define SEGMENTS , .chain_of_segments = &TFA_V(segments_method)
#endif

/* In the order of TFA_METHOD_LIST; zeros: no solves, or not in this kernel */
static const struct method rows[] = {
    [TFA_METHOD_AUTO] = {0},
    [TFA_METHOD_RNEA] = {0},
    [TFA_METHOD_CRBA] = {.factor = mass_factor,
                         .solve = mass_solve,
                         .forward = mass_forward,
                         .obeys_mimics = 1,
                         .margin = mass_margin},
    [TFA_METHOD_ABA] = {ARTICULATED, .osim = OSIM(lambda_propagation)},
    [TFA_METHOD_TFA] = {CHAIN(tfa)},
    [TFA_METHOD_TFA_ONE_SIDED] = SINGLE(.osim_elimination = TFA_V(lambda_one_sided)),
    [TFA_METHOD_PROPAGATION] = SINGLE(.osim = TFA_V(lambda_propagation)),
    [TFA_METHOD_TFA_CR] = {CHAIN(tfa_cr) SEGMENTS},
    [TFA_METHOD_HESSENBERG] = SINGLE(CHAIN(hessenberg)),
    [TFA_METHOD_CFA] = {CHAIN(cfa)},
    [TFA_METHOD_CFA_CR] = {CHAIN(cfa_cr) SEGMENTS},
    [TFA_METHOD_DCA] = {CHAIN(dca)},
    [TFA_METHOD_SCAN] =
        SINGLE(CHAIN(scan), .margin = TFA_V(sentinel_margin_articulated), .is_scan = 1),
    [TFA_METHOD_SCAN_TWO_PASS] =
        SINGLE(CHAIN(scan_two_pass), .margin = TFA_V(sentinel_margin_articulated), .is_scan = 1),
    [TFA_METHOD_EFPA] = SINGLE(.osim = TFA_V(lambda_efpa)),
    [TFA_METHOD_PV_OSIMR] = SINGLE(.osim = TFA_V(lambda_pv)),
    [TFA_METHOD_HYBRID] = SINGLE(CHAIN(hybrid), .margin = TFA_V(sentinel_margin_articulated)),
};
#define ROWS (sizeof rows / sizeof *rows)

int TFA_V(sentinel_of)(struct state *s, tfa_method method)
{
    const struct method *row = TFA_V(method)(method);
    const num margin = row->margin ? row->margin(s) : s->margin;
    return !num_all(margin >= 0);
}

const struct method *TFA_V(method)(tfa_method method)
{
    static const struct method none;
    return (size_t)method < ROWS ? &rows[method] : &none;
}

const struct chain_method *TFA_V(chain_of)(const struct state *s, tfa_method method)
{
    const struct method *row = TFA_V(method)(method);
    return s->in_segments && row->chain_of_segments ? row->chain_of_segments : row->chain;
}

static size_t most_bytes(const struct method *row, size_t length)
{
    const size_t bytes = row->chain->bytes(length),
                 segments = row->chain_of_segments ? row->chain_of_segments->bytes(length) : 0;
    return bytes > segments ? bytes : segments;
}

/* Memory for the method that keeps most. Trees share it, one behind the other. */
size_t TFA_V(chain_bytes)(const struct tfa_model *m, uint32_t wanted)
{
    size_t most = 0;
    for (size_t k = 0; k < ROWS; k++) {
        size_t sum = 0;
        if (!rows[k].chain || !reserves_method(wanted, (tfa_method)k))
            continue;
        for (uint32_t t = 0; t < m->trees; t++)
            sum += most_bytes(&rows[k], m->chain[t].length);
        most = sum > most ? sum : most;
    }
    return most;
}

/* ---- fallbacks ---- */

tfa_method TFA_V(last_resort)(const struct state *s)
{
    const int projects = s->m->mimics && !s->locked && reserves_method(s->methods, TFA_METHOD_CRBA);
    return projects ? TFA_METHOD_CRBA : TFA_METHOD_ABA;
}

/* From this length of a main chain on the segment scan is asked first where another method failed:
 * it is as accurate as aba, and its segments go in parallel. */
#define FALLBACK_SCAN_LENGTH 128

tfa_method TFA_V(fallback)(const struct state *s, tfa_method failed)
{
    const tfa_method last = TFA_V(last_resort)(s);
    if (NUM_LANES > 1 || TFA_V(method)(failed)->is_scan || TFA_V(method)(last)->obeys_mimics ||
        s->locked)
        return last;
    for (uint32_t t = 0; t < s->m->trees; t++)
        if (s->m->chain[t].length >= FALLBACK_SCAN_LENGTH)
            return TFA_METHOD_SCAN_TWO_PASS;
    return last;
}

tfa_method TFA_V(osim_name)(tfa_method factors)
{
    return factors == TFA_METHOD_ABA ? TFA_METHOD_PROPAGATION : factors;
}

int TFA_V(osim_is_last)(const struct state *s, tfa_method method)
{
    return method == TFA_METHOD_PV_OSIMR || method == TFA_V(osim_name)(TFA_V(last_resort)(s));
}

/* ---- factors and solves ---- */

int TFA_V(factor)(struct state *s, tfa_method method)
{
    const struct method *row = TFA_V(method)(method);
    if (row->chain)
        return TFA_V(chain_factor)(s, TFA_V(chain_of)(s, method));
    row->factor(s);
    return TFA_OK;
}

void TFA_V(solve_free)(struct state *s, tfa_method method, const num *rhs, num *x)
{
    const struct method *row = TFA_V(method)(method);
    if (row->chain)
        TFA_V(chain_solve)(s, TFA_V(chain_of)(s, method), rhs, x, 0);
    else
        row->solve(s, rhs, x);
}

void TFA_V(solve)(struct state *s, tfa_method method, const num *rhs, num *x)
{
    TFA_V(solve_free)(s, method, rhs, x);
    if (!TFA_V(method)(method)->obeys_mimics)
        TFA_V(impose_mimics)(s, method, x);
}

int TFA_V(forward_dynamics)(struct state *s, tfa_method method)
{
    const struct method *row = TFA_V(method)(method);
    s->stalled = 0;
    if (row->chain) {
        const int status = TFA_V(chain_factor)(s, TFA_V(chain_of)(s, method));
        if (status != TFA_OK)
            return status;
        TFA_V(chain_solve)(s, TFA_V(chain_of)(s, method), s->tau, s->qdd, 1);
    } else {
        row->forward(s);
    }
    if (!row->obeys_mimics)
        TFA_V(impose_mimics)(s, method, s->qdd);
    return TFA_OK;
}
