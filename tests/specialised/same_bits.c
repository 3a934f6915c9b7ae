/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See same_bits.h.
 */
#include "same_bits.h"

#include "bench.h"
#include "model/model.h"
#include "models.h"
#include "test.h"

#include <stdbool.h>

#define STATES 30
#define FAILED 11 /* has no finite answer where speed or place of the base counts */
#define FREEDOMS 64

/* Every array that a request can have written, of all states */
struct answers {
    double qdd[STATES * FREEDOMS], tau[STATES * FREEDOMS], base[STATES * 6], wrench[STATES * 6];
    double lambda[STATES * 36], mass[STATES * FREEDOMS * FREEDOMS];
    double derivatives[3][STATES * FREEDOMS * FREEDOMS]; /* by q, v and tau */
    tfa_answer each[STATES];
};

struct subject {
    const tfa_model *model;
    tfa_workspace *workspace;
    tfa_batch_pool *pool[2]; /* of one thread, of two */
    double q[STATES * FREEDOMS], v[STATES * FREEDOMS], x[STATES * FREEDOMS];
    double pose[STATES * 7], six[STATES * 6], wrenches[STATES * 6];
    struct answers alone, tested;
    uint32_t answered, not_computed, flagged; /* states of all requests */
};

/* A kind of request. Payloads: a mass that some states carry safely and others do not, by the
 * sentinel; found by decades. */
static const struct kind {
    const char *name;
    tfa_op op;
    int tip, wrench;
    double payload; /* kg, or 0 */
} kinds[] = {
    {"qdd", TFA_OP_FORWARD_DYNAMICS, 0, 0, 0},
    {"qdd with a wrench", TFA_OP_FORWARD_DYNAMICS, 0, 1, 0},
    {"qdd with a payload", TFA_OP_FORWARD_DYNAMICS, 0, 1, 3},
    {"qdd with 2e4 kg", TFA_OP_FORWARD_DYNAMICS, 0, 0, 2e4},
    {"qdd with 2e5 kg", TFA_OP_FORWARD_DYNAMICS, 0, 0, 2e5},
    {"qdd with 2e6 kg", TFA_OP_FORWARD_DYNAMICS, 0, 0, 2e6},
    {"tau", TFA_OP_INVERSE_DYNAMICS, 0, 0, 0},
    {"tau with a wrench", TFA_OP_INVERSE_DYNAMICS, 0, 1, 0},
    {"tau with a payload", TFA_OP_INVERSE_DYNAMICS, 0, 1, 3},
    {"derivatives", TFA_OP_DERIVATIVES, 0, 0, 0},
    {"derivatives of tau", TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, 0, 0, 0},
    {"mass_matrix", TFA_OP_MASS_MATRIX, 0, 0, 0},
    {"mass_matrix with a payload", TFA_OP_MASS_MATRIX, 0, 0, 3},
    {"lambda_inv", TFA_OP_OPERATIONAL_INERTIA, 1, 0, 0},
    {"qdd and lambda_inv", TFA_OP_FORWARD_DYNAMICS, 1, 1, 0},
};

static size_t mass_entries(const struct subject *s)
{
    const size_t n = tfa_model_v_count(s->model) + tfa_model_base_freedoms(s->model);
    return n * n;
}

static tfa_reply reply_to(const struct subject *s, struct answers *a, uint32_t k)
{
    const size_t nv = tfa_model_v_count(s->model);
    return (tfa_reply){.qdd = a->qdd + nv * k,
                       .tau = a->tau + nv * k,
                       .base_acceleration = a->base + (size_t)6 * k,
                       .base_wrench = a->wrench + (size_t)6 * k,
                       .lambda_inv = a->lambda + (size_t)36 * k,
                       .mass_matrix = a->mass + mass_entries(s) * k,
                       .dqdd_dq = a->derivatives[0] + mass_entries(s) * k,
                       .dqdd_dv = a->derivatives[1] + mass_entries(s) * k,
                       .dqdd_dtau = a->derivatives[2] + mass_entries(s) * k,
                       .dtau_dq = a->derivatives[0] + mass_entries(s) * k,
                       .dtau_dv = a->derivatives[1] + mass_entries(s) * k,
                       .answers = a->each + k};
}

static tfa_request request_of(const struct subject *s, const struct kind *kind, uint32_t frame,
                              uint32_t mode)
{
    static double payload[TFA_PAYLOAD_NUMBERS];
    const int floating = tfa_model_base_freedoms(s->model) != 0;
    payload[0] = kind->payload;
    tfa_request r = {.op = kind->op,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = STATES,
                     .frame = (tfa_reference_frame)mode,
                     .q = s->q,
                     .v = s->v,
                     .tau = s->x,
                     .qdd = s->x,
                     .tip_count = (uint32_t)kind->tip,
                     .tips = {frame},
                     .wrench_count = (uint32_t)kind->wrench,
                     .wrench_frames = {frame},
                     .wrenches = s->wrenches,
                     .payload_count = kind->payload > 0,
                     .payload_frames = {frame},
                     .payloads = payload};
    r.base_pose = floating ? s->pose : NULL;
    r.base_twist = r.base_wrench = r.base_acceleration = floating ? s->six : NULL;
    return r;
}

/* State k in a request of its own */
static tfa_request single(const struct subject *s, const tfa_request *all, uint32_t k)
{
    const size_t nq = tfa_model_q_count(s->model), nv = tfa_model_v_count(s->model);
    tfa_request r = *all;
    r.count = 1;
    r.q += nq * k;
    r.v += nv * k;
    r.tau = r.qdd = s->x + nv * k;
    r.wrenches += (size_t)6 * k;
    r.base_pose = all->base_pose ? s->pose + (size_t)7 * k : NULL;
    r.base_twist = r.base_wrench = r.base_acceleration =
        all->base_pose ? s->six + (size_t)6 * k : NULL;
    return r;
}

/* Every state by itself: what the law compares with */
static void ask_alone(struct subject *s, const tfa_request *all)
{
    memset(&s->alone, 0, sizeof s->alone);
    for (uint32_t k = 0; k < STATES; k++) {
        const tfa_request r = single(s, all, k);
        tfa_reply reply = reply_to(s, &s->alone, k);
        (void)tfa_compute(s->workspace, &r, &reply);
        s->answered++;
        s->not_computed += s->alone.each[k].status == TFA_E_NOT_COMPUTED;
        s->flagged += (s->alone.each[k].flags & TFA_ANSWER_SENTINEL) != 0;
    }
}

static bool derivatives_differ(const struct subject *s, uint32_t k)
{
    const size_t entries = mass_entries(s), at = entries * k;
    for (int by = 0; by < 3; by++)
        if (memcmp(s->alone.derivatives[by] + at, s->tested.derivatives[by] + at,
                   entries * sizeof(double)))
            return true;
    return false;
}

static void compare(const struct subject *s, const char *what, uint32_t frame, const char *how,
                    uint32_t cut)
{
    const size_t nv = tfa_model_v_count(s->model), entries = mass_entries(s);
    const struct answers *a = &s->alone, *b = &s->tested;
    for (uint32_t k = 0; k < STATES; k++)
        if (memcmp(a->qdd + nv * k, b->qdd + nv * k, nv * sizeof *a->qdd) ||
            memcmp(a->tau + nv * k, b->tau + nv * k, nv * sizeof *a->tau) ||
            memcmp(a->base + 6 * k, b->base + 6 * k, 6 * sizeof *a->base) ||
            memcmp(a->wrench + 6 * k, b->wrench + 6 * k, 6 * sizeof *a->wrench) ||
            memcmp(a->lambda + 36 * k, b->lambda + 36 * k, 36 * sizeof *a->lambda) ||
            memcmp(a->mass + entries * k, b->mass + entries * k, entries * sizeof *a->mass) ||
            derivatives_differ(s, k) || memcmp(&a->each[k], &b->each[k], sizeof *a->each))
            fail_msg("%s, %s base: %s at frame %u: state %u has other bits alone than %s %u",
                     tfa_model_name(s->model),
                     tfa_model_base_freedoms(s->model) ? "floating" : "fixed", what, frame, k, how,
                     cut);
}

/* In two batches with every cut between them, then on one thread and on two */
static void ask_kind(struct subject *s, const struct kind *kind, uint32_t frame, uint32_t mode)
{
    const tfa_request r = request_of(s, kind, frame, mode);
    tfa_reply checked = {0};
    assert_int_equal(tfa_request_check(s->model, &r, &checked), TFA_OK);
    ask_alone(s, &r);
    for (uint32_t cut = 0; cut < STATES; cut++) {
        memset(&s->tested, 0, sizeof s->tested);
        tfa_reply first = reply_to(s, &s->tested, 0), second = first;
        (void)tfa_compute_states(s->workspace, &r, cut, STATES - cut, &second);
        if (cut)
            (void)tfa_compute_states(s->workspace, &r, 0, cut, &first);
        compare(s, kind->name, frame, "in a batch cut at", cut);
    }
    for (uint32_t p = 0; p < 2; p++) {
        memset(&s->tested, 0, sizeof s->tested);
        tfa_reply reply = reply_to(s, &s->tested, 0);
        (void)tfa_batch_pool_compute(s->pool[p], &r, &reply);
        compare(s, kind->name, frame, "on threads:", p + 1);
    }
}

static void fill(struct subject *s)
{
    for (size_t k = 0; k < STATES * FREEDOMS; k++) {
        s->q[k] = 2.5 * bench_number(k);
        s->v[k] = 2 * bench_number(k + 7001);
        s->x[k] = 9 * bench_number(k + 31337);
    }
    for (size_t k = 0; k < STATES * 6; k++) {
        s->six[k] = bench_number(k + 99);
        s->wrenches[k] = 20 * bench_number(k + 777);
    }
    for (size_t k = 0; k < STATES; k++)
        bench_pose(k, &s->pose[7 * k]);
    s->v[FAILED * tfa_model_v_count(s->model)] = 1e160; /* its square is not finite */
    s->pose[7 * FAILED] = 1e200;
}

static void ask_everything(struct subject *s)
{
    const uint32_t frames = tfa_model_frame_count(s->model);
    for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++)
        for (uint32_t mode = 0; mode < 3; mode++) {
            ask_kind(s, &kinds[n], frames - 1, mode);
            if (kinds[n].tip)
                ask_kind(s, &kinds[n], frames / 2, mode);
        }
}

void assert_same_bits(const tfa_model *model, const tfa_specialised *kernel)
{
    struct subject *s = calloc(1, sizeof *s);
    s->model = model;
    fill(s);
    for (tfa_precision precision = TFA_F64; precision <= TFA_F32; precision++) {
        if (precision == TFA_F128)
            continue;
        const tfa_workspace_options options = {.precision = precision, .specialised = kernel};
        s->workspace = workspace_for(model, &options);
        for (uint32_t p = 0; p < 2; p++) {
            const tfa_batch_pool_options o = {
                .threads = p + 1, .precision = precision, .specialised = kernel};
            assert_int_equal(tfa_batch_pool_create(model, &o, &s->pool[p]), TFA_OK);
        }
        ask_everything(s);
        tfa_workspace_free(s->workspace);
        for (uint32_t p = 0; p < 2; p++)
            tfa_batch_pool_free(s->pool[p]);
    }
    print_message("  %s: %u states alone, %u without an answer, %u flagged by the sentinel\n",
                  tfa_model_name(model), s->answered, s->not_computed, s->flagged);
    assert_true(s->not_computed > 0 && s->flagged > 0 && 3 * s->flagged < s->answered);
    free(s);
}
