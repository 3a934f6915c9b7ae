/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of forward and inverse dynamics by central differences, on the robots of
 * operational.h: projected mimics, fused joints, payloads of model and request, damping, locked
 * joints, wrenches in three frames. dqdd/dtau by the oracle's mass matrix, and symmetric.
 */
#include "differences.h"
#include "dynamics/operational/operational.h"
#include "model/model.h"
#include "support/sanitized.h"
#include "test.h"

#ifdef SANITIZED
#define FREEDOMS 12
#else
#define FREEDOMS 60 /* larger robots take minutes */
#endif
#define SQUARE (OP_FREEDOMS * OP_FREEDOMS)

/* Relative to the largest entry of the matrix; of dqdd/dtau of the oracle, of the column. */
enum { BY_DIFFERENCES, F64 = BY_ALL, ORACLE = 2 * BY_ALL, ORACLE_F64, SYMMETRY, KINDS };
static op_bound bounds[KINDS] = {
    {"dqdd/dq, differences", {1e-9}, {0}},      {"dqdd/dv, differences", {1e-9}, {0}},
    {"dqdd/dtau, differences", {1e-9}, {0}},    {"dtau/dq, differences", {1e-9}, {0}},
    {"dtau/dv, differences", {1e-9}, {0}},      {"dqdd/dq, f64 - f128", {1e-11}, {0}},
    {"dqdd/dv, f64 - f128", {1e-11}, {0}},      {"dqdd/dtau, f64 - f128", {1e-11}, {0}},
    {"dtau/dq, f64 - f128", {1e-12}, {0}},      {"dtau/dv, f64 - f128", {1e-12}, {0}},
    {"dqdd/dtau, oracle", {1e-12}, {0}},        {"dqdd/dtau, oracle, f64", {1e-9}, {0}},
    {"dqdd/dtau, symmetry, f64", {1e-12}, {0}},
};
static uint32_t cases, locked_cases, mimic_cases, fused_cases, damped_cases, payload_cases,
    inside_cases, overflows;

static difference_robot quad_of(const op_case *c)
{
    return (difference_robot){c->name, c->model, c->f128, c->n, c->six, c->nq, c->nv};
}

static tfa_request ask(const op_case *c, uint32_t k)
{
    tfa_request r = op_state(c, k);
    r.estimate = TFA_ESTIMATE_NEVER;
    return r;
}

static tfa_reply reply_into(double *const out[])
{
    return (tfa_reply){.dqdd_dq = out[BY_Q],
                       .dqdd_dv = out[BY_V],
                       .dqdd_dtau = out[BY_TAU],
                       .dtau_dq = out[ID_BY_Q],
                       .dtau_dv = out[ID_BY_V]};
}

/* By both ops, each of which leaves the other's matrices alone */
static void derive(const op_case *c, tfa_workspace *w, const tfa_request *r, double *const out[])
{
    static const tfa_op ops[] = {TFA_OP_DERIVATIVES, TFA_OP_INVERSE_DYNAMICS_DERIVATIVES};
    tfa_reply reply = reply_into(out);
    for (int by = 0; by < BY_ALL; by++)
        for (size_t e = 0; out[by] && e < (size_t)c->n * c->n * r->count; e++)
            out[by][e] = NAN;
    for (int k = 0; k < 2; k++) {
        tfa_request one = *r;
        one.op = ops[k];
        const int status = tfa_compute(w, &one, &reply);
        if (status != TFA_OK)
            fail_msg("%s: op %d: %s (%s %u)", c->name, (int)one.op, tfa_status_text(status),
                     tfa_field_name(reply.field), (unsigned)reply.index);
    }
}

/* ---- values ---- */

static void compare(const op_case *c, const double *x, const double *want, size_t n, double size,
                    op_bound *bound)
{
    static double difference[SQUARE];
    for (size_t e = 0; e < n; e++)
        difference[e] = x[e] - want[e];
    op_within(c, bound, difference_largest(difference, n) / size);
}

static void compare_with_oracle(op_case *c, uint32_t k, const double *f128, const double *f64)
{
    const uint32_t n = c->n;
    static quad column[OP_FREEDOMS];
    double got[2][OP_FREEDOMS];
    op_set_state_locked(c, k);
    for (uint32_t j = 0; j < n; j++) {
        for (uint32_t i = 0; i < n; i++) {
            column[i] = i == j;
            got[0][i] = f128[(size_t)n * i + j];
            got[1][i] = f64[(size_t)n * i + j];
        }
        oracle_accelerate(c->o, column);
        op_within(c, &bounds[ORACLE], op_error(got[0], column, n, 0));
        op_within(c, &bounds[ORACLE_F64], op_error(got[1], column, n, 0));
    }
}

/* Some of the matrices asked for: the same bits */
static void compare_with_parts(const op_case *c, const tfa_request *r, double *const whole[])
{
    static double memory[BY_ALL][SQUARE];
    for (unsigned parts = 1; parts + 1 < 1u << BY_ALL; parts++) {
        double *out[BY_ALL];
        for (int by = 0; by < BY_ALL; by++)
            out[by] = parts >> by & 1 ? memory[by] : NULL;
        derive(c, c->f64, r, out);
        for (int by = 0; by < BY_ALL; by++)
            if (out[by] && memcmp(out[by], whole[by], sizeof(double) * c->n * c->n) != 0)
                fail_msg("%s: matrix %d has other bits among parts %u", c->name, by, parts);
    }
}

static void check_values(op_case *c, uint32_t k)
{
    static double memory[2 * BY_ALL][SQUARE];
    double *f128[BY_ALL], *f64[BY_ALL];
    const difference_robot robot = quad_of(c);
    const tfa_request r = ask(c, k);
    const uint32_t n = c->n;
    double column[DIFFERENCE_MAX], got[DIFFERENCE_MAX];
    for (int by = 0; by < BY_ALL; by++) {
        f128[by] = memory[by];
        f64[by] = memory[BY_ALL + by];
    }
    derive(c, c->f128, &r, f128);
    derive(c, c->f64, &r, f64);
    compare_with_parts(c, &r, f64);
    for (int by = 0; by < BY_ALL; by++) {
        const double size = difference_size(&robot, &r, (difference_by)by, f128[by]);
        const uint32_t step = c->file ? n / 5 + 1 : 1; /* every column, or some of files */
        for (uint32_t j = random_below(&c->s, step); j < n; j += step) {
            difference_column(&robot, &r, (difference_by)by, j, column);
            for (uint32_t i = 0; i < n; i++)
                got[i] = f128[by][(size_t)n * i + j];
            compare(c, got, column, n, size, &bounds[BY_DIFFERENCES + by]);
        }
        compare(c, f64[by], f128[by], (size_t)n * n, size, &bounds[F64 + by]);
    }
    compare_with_oracle(c, k, f128[BY_TAU], f64[BY_TAU]);
    const double size = difference_size(&robot, &r, BY_TAU, f64[BY_TAU]);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < i; j++)
            op_within(c, &bounds[SYMMETRY],
                      fabs(f64[BY_TAU][n * i + j] - f64[BY_TAU][n * j + i]) / size);
}

/* A wrench moves to a link inside a fused joint. */
static void push_inside(op_case *c)
{
    for (uint32_t f = 0; f < c->link_count; f++)
        if (c->model->frame[f].part) {
            c->r.wrench_frames[0] = f;
            c->whole_r.wrench_frames[0] = c->link[f];
            inside_cases++;
            return;
        }
}

static void count(const op_case *c)
{
    const tfa_model_summary summary = tfa_model_summarise(c->model);
    cases++;
    mimic_cases += summary.mimics > 0;
    fused_cases += summary.fused > 0;
    damped_cases += c->damped;
    payload_cases += c->r.payload_count > 0;
}

static void values(op_case *c)
{
    if (c->n > FREEDOMS)
        return;
    count(c);
    push_inside(c);
    for (uint32_t k = 0; k < (c->n > 40 ? 1 : test_extent(1, OP_STATES)); k++) {
        c->r.frame = c->whole_r.frame = (tfa_reference_frame)k;
        check_values(c, k);
    }
    if (!c->file && op_lock(c)) {
        locked_cases++;
        check_values(c, 0);
    }
    op_unlock(c);
}

TEST(limits_of_differences_and_inverse_of_m)
{
    op_for_each(OP_FIXTURE | OP_REDUCED, values);
    op_print(bounds, KINDS);
    print_message("  %u robots: %u with mimics, %u with fused joints, %u with a wrench inside one, "
                  "%u damped, %u with payloads, %u locked\n",
                  cases, mimic_cases, fused_cases, inside_cases, damped_cases, payload_cases,
                  locked_cases);
    assert_true(mimic_cases > 4 && fused_cases > 4 && inside_cases > 4 && damped_cases > 4 &&
                payload_cases > 4 && locked_cases > 4);
}

/* Velocities whose squares leave the range of doubles, not that of quadruple precision */
static void overflow(op_case *c, tfa_workspace *w, tfa_op op)
{
    static double memory[BY_ALL][SQUARE], v[OP_FREEDOMS], twist[6];
    tfa_request r = ask(c, 0);
    double *out[BY_ALL];
    for (int by = 0; by < BY_ALL; by++)
        out[by] = memory[by];
    tfa_reply reply = reply_into(out);
    for (uint32_t j = 0; j < OP_FREEDOMS; j++)
        v[j] = 1e160;
    for (int e = 0; e < 6; e++)
        twist[e] = 1e160;
    r.op = op;
    r.v = v;
    r.base_twist = twist;
    memset(memory, 0, sizeof memory);
    const int status = tfa_compute(w, &r, &reply);
    bool finite = true;
    for (int by = 0; by < BY_ALL; by++)
        for (size_t e = 0; e < (size_t)c->n * c->n; e++)
            finite = finite && isfinite(memory[by][e]);
    assert_int_equal(status, finite ? TFA_OK : TFA_E_NOT_COMPUTED);
    overflows += !finite;
}

static void overflows_of(op_case *c)
{
    tfa_workspace *const workspaces[] = {c->f64, c->f32, c->f128};
    for (int k = 0; k < 3; k++) {
        overflow(c, workspaces[k], TFA_OP_DERIVATIVES);
        overflow(c, workspaces[k], TFA_OP_INVERSE_DYNAMICS_DERIVATIVES);
    }
}

TEST(no_overflow_is_ok)
{
    op_for_each(OP_FIXTURE, overflows_of);
    print_message("  %u answers overflow\n", overflows);
    assert_true(overflows > 50);
}
