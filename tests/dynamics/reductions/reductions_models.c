/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reduced models against other models of the library: the unreduced one in quadruple precision, the
 * same without armature, the same with its payloads compiled in.
 */
#include "models.h"
#include "reductions.h"
#include "support/fixture.h"
#include "test.h"

#define BOUND 1e-13
#define SEEDS 60

static double worst;
static unsigned compared, left_out;

static void within(const reduction *r, const char *what, double error)
{
    worst = fmax(worst, error);
    compared++;
    if (!(error <= BOUND))
        fail_msg("%s: %s: error %.3g, bound %g", r->name, what, error, BOUND);
}

static void *zeros(size_t n)
{
    void *memory = calloc(n + 1, sizeof(double));
    assert_non_null(memory);
    return memory;
}

static void for_seeds(void (*law)(reduction *r, uint64_t seed))
{
    worst = 0;
    compared = left_out = 0;
    reduction_for_seeds(1001, 1000 + SEEDS, law);
    print_message("  worst %.1e of %u, %u robots left out\n", worst, compared, left_out);
    assert_true(compared > SEEDS);
}

/* ---- the library's own unreduced model ---- */

/* Solves A x = b in place, A symmetric positive definite, in extended precision. */
static void solve(long double *A, long double *b, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = k + 1; i < n; i++) {
            long double l = A[i * n + k] / A[k * n + k];
            for (uint32_t j = k; j < n; j++)
                A[i * n + j] -= l * A[k * n + j];
            b[i] -= l * b[k];
        }
    for (uint32_t k = n; k-- > 0;) {
        for (uint32_t j = k + 1; j < n; j++)
            b[k] -= A[k * n + j] * b[j];
        b[k] /= A[k * n + k];
    }
}

/* T^T M T x = tau - T^T h from M and h of all joints. */
static void reduced_forward(const reduction *r, const double *M, const double *h,
                            const tfa_request *q, double *x)
{
    const uint32_t n = r->n, base = r->n - r->nv, all = base + r->whole_nv;
    long double *A = calloc((size_t)n * n + 1, sizeof *A), *b = calloc(n + 1, sizeof *b);
    assert_true(A && b);
    for (uint32_t i = 0; i < n; i++)
        b[i] = i < base ? q->base_wrench[i] : q->tau[i - base];
    for (uint32_t i = 0; i < all; i++) {
        const oracle_tie *t = &r->tie[i];
        if (t->to == ORACLE_STILL)
            continue;
        b[t->to] -= t->multiplier * (long double)h[i];
        for (uint32_t k = 0; k < all; k++)
            if (r->tie[k].to != ORACLE_STILL)
                A[t->to * n + r->tie[k].to] +=
                    t->multiplier * r->tie[k].multiplier * (long double)M[(size_t)i * all + k];
    }
    solve(A, b, n);
    for (uint32_t i = 0; i < n; i++)
        x[i] = (double)b[i];
    free(b);
    free(A);
}

/* All joints move in `model`, nothing is merged but what fixed joints join. */
static void compare_unreduced(reduction *r, const tfa_model *model, question *a)
{
    const uint32_t base = r->n - r->nv, all = base + r->whole_nv;
    assert_int_equal(tfa_model_v_count(model), r->whole_nv);
    tfa_workspace *w = fixture_workspace(model, TFA_F128);
    tfa_request whole, one = question_state(a, r, 0, &whole);
    double *M = zeros((size_t)all * all), *h = zeros(all), *x = zeros(r->n + 6),
           *want = zeros(r->n);
    tfa_reply reply = {.mass_matrix = M, .tau = h + base, .base_wrench = h};
    whole.op = TFA_OP_MASS_MATRIX;
    for (uint32_t k = 0; k < whole.wrench_count; k++)
        whole.wrench_frames[k] =
            (uint32_t)tfa_model_find_frame(model, r->whole->links[whole.wrench_frames[k]].name);
    for (uint32_t k = 0; k < whole.payload_count; k++)
        whole.payload_frames[k] =
            (uint32_t)tfa_model_find_frame(model, r->whole->links[whole.payload_frames[k]].name);
    whole.qdd = whole.base_acceleration = NULL;
    reduction_ask(r, w, &whole, &reply);
    whole.op = TFA_OP_INVERSE_DYNAMICS;
    reduction_ask(r, w, &whole, &reply);
    reduced_forward(r, M, h, &one, want);
    reply = (tfa_reply){.qdd = x + base, .base_acceleration = x};
    reduction_ask(r, r->f64, &one, &reply);
    within(r, "f64 against the unreduced model in f128", relative_error(x, want, r->n));
    reduction_ask(r, r->f128, &one, &reply);
    within(r, "f128 against the unreduced model in f128", relative_error(x, want, r->n));
    free(want);
    free(x);
    free(h);
    free(M);
    tfa_workspace_free(w);
}

static void unreduced(reduction *r, uint64_t seed)
{
    const tfa_model_options options = {.base = r->base,
                                       .gravity = r->gravity,
                                       .damping = r->options.damping,
                                       .friction = r->options.friction,
                                       .friction_velocity = r->options.friction_velocity};
    tfa_model *model = reduction_compile(r, r->whole, &options);
    question a;
    /* bodies are fused without being asked to: such a model is not an unreduced one */
    if (tfa_model_summarise(model).fused == 0 && question_open(&a, r, seed, 1, 2)) {
        compare_unreduced(r, model, &a);
        question_close(&a);
    } else {
        left_out++;
    }
    tfa_model_free(model);
}

TEST(unreduced_in_f128_agrees)
{
    for_seeds(unreduced);
}

/* ---- armature ---- */

/* M without armature is smaller by T^T R T, and by nothing else. */
static void armature(reduction *r, uint64_t seed)
{
    const uint32_t n = r->n, base = n - r->nv;
    question a;
    if (!question_open(&a, r, seed, 1, 0)) {
        left_out++;
        return;
    }
    double *with = zeros((size_t)n * n), *without = zeros((size_t)n * n), *R = zeros((size_t)n * n);
    tfa_reply reply = {.mass_matrix = with};
    a.r.op = TFA_OP_MASS_MATRIX;
    reduction_ask(r, r->f64, &a.r, &reply);
    for (size_t j = 0; j < r->file->joint_count; j++)
        r->file->joints[j].armature = r->file->joints[j].rotor = 0;
    r->scene.payloads = r->scene_payloads;
    r->scene.payload_count = r->payload_count;
    tfa_model *model = reduction_compile(r, r->file, &r->options);
    tfa_workspace *w = fixture_workspace(model, TFA_F64);
    reply.mass_matrix = without;
    reduction_ask(r, w, &a.r, &reply);
    double size = 0;
    for (uint32_t i = 0; i < r->whole_nv; i++) {
        uint32_t inside, j = oracle_joint_of_freedom(r->o, i, &inside);
        const oracle_tie *t = &r->tie[base + i];
        if (t->to != ORACLE_STILL)
            R[t->to * n + t->to] += t->multiplier * t->multiplier * r->whole->joints[j].armature;
    }
    for (size_t e = 0; e < (size_t)n * n; e++) {
        size += with[e] * with[e];
        with[e] -= without[e] + R[e];
    }
    for (size_t e = 0; e < (size_t)n * n; e++)
        within(r, "armature", fabs(with[e]) / sqrt(size));
    tfa_workspace_free(w);
    tfa_model_free(model);
    free(R);
    free(without);
    free(with);
    question_close(&a);
}

TEST(armature_is_all_there)
{
    for_seeds(armature);
}

/* ---- payloads given later ---- */

/* A derived model is the one that would have been compiled: same hash, same answers. */
static void derived(reduction *r, uint64_t seed)
{
    question a;
    if (!r->undivided || r->payload_count == 0 || !question_open(&a, r, seed, 1, 2)) {
        left_out++;
        return;
    }
    r->options.gravity = r->gravity;
    r->scene.payloads = r->scene_payloads;
    r->scene.payload_count = r->payload_count;
    tfa_model *model = reduction_compile(r, r->file, &r->options);
    assert_string_equal(tfa_model_hash_text(model), tfa_model_hash_text(r->model));
    assert_true(tfa_model_tag(model) == tfa_model_tag(r->model));
    assert_true(tfa_model_tag(r->undivided) != tfa_model_tag(r->model));
    tfa_workspace *w = fixture_workspace(model, TFA_F64);
    double *x = zeros(r->n + 6), *y = zeros(r->n + 6);
    tfa_reply reply = {.qdd = x + r->n - r->nv, .base_acceleration = x};
    reduction_ask(r, r->f64, &a.r, &reply);
    assert_true(reply.model == tfa_model_tag(r->model));
    reply = (tfa_reply){.qdd = y + r->n - r->nv, .base_acceleration = y};
    reduction_ask(r, w, &a.r, &reply);
    assert_memory_equal(x, y, r->n * sizeof *x);
    tfa_model_summary s = tfa_model_summarise(model), t = tfa_model_summarise(r->model);
    assert_memory_equal(&s, &t, sizeof s);
    compared += 5;
    free(y);
    free(x);
    tfa_workspace_free(w);
    tfa_model_free(model);
    question_close(&a);
}

TEST(derived_is_compiled)
{
    for_seeds(derived);
}
