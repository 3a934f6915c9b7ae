/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Self-test of a kernel: compares its answers at random states with those of the generic kernel.
 * Differences are relative to the largest number of an answer. A kernel gets requests of every kind
 * that it supports.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "interface/traits.h"
#include "specialised/self_test.h"

/* Largest difference, or so many times the generic answer's error estimate. Answers in float whose
 * sentinel did not trip have lost at most 1e-3 (SENTINEL_LIMIT) in a joint. */
#define RELATIVE_ERROR_MAX 1e-10
#define RELATIVE_ERROR_MAX_F32 1e-2
#define ESTIMATE_FACTOR 100
#define ROUNDING_F32 0x1p29 /* that of floats over that of doubles */

/* How states are computed: one at a time or as a batch, doubles or floats */
enum way { ALONE, BATCH, BATCH_F32, WAYS };
static const char *const way_names[WAYS] = {"", ", several at a time",
                                            ", several at a time, in float"};

static uint32_t lanes_of(const struct tfa_specialised_kernel *kernel, enum way way)
{
    return way == ALONE ? 1 : way == BATCH ? kernel->lanes : kernel->lanes_f32;
}

/* ---- requests ---- */

#define FORWARD TFA_OP_FORWARD_DYNAMICS
#define INVERSE TFA_OP_INVERSE_DYNAMICS
#define MASS TFA_OP_MASS_MATRIX
#define LAMBDA TFA_OP_OPERATIONAL_INERTIA
#define ALIGNED TFA_FRAME_LOCAL_WORLD_ALIGNED

static const struct self_test_case cases[] = {
    {"forward dynamics", FORWARD, 0, ALIGNED, 0, 0},
    {"forward dynamics at rest", FORWARD, 0, ALIGNED, 0, SELF_TEST_AT_REST},
    {"forward dynamics with a gravity", FORWARD, 0, ALIGNED, 0, SELF_TEST_GRAVITY},
    {"forward dynamics with a payload", FORWARD, 0, ALIGNED, 0, SELF_TEST_PAYLOAD},
    {"forward dynamics with a wrench", FORWARD, 0, TFA_FRAME_LOCAL, 0, SELF_TEST_WRENCH},
    {"forward dynamics with a wrench in the world's frame", FORWARD, 0, TFA_FRAME_WORLD, 0,
     SELF_TEST_WRENCH},
    {"forward dynamics with a wrench and a payload", FORWARD, 0, ALIGNED, 0,
     SELF_TEST_WRENCH | SELF_TEST_PAYLOAD},
    {"forward dynamics with a locked joint", FORWARD, 0, ALIGNED, 0, SELF_TEST_LOCKED},
    {"inverse dynamics", INVERSE, 0, ALIGNED, 0, 0},
    {"inverse dynamics at rest", INVERSE, 0, ALIGNED, 0, SELF_TEST_AT_REST},
    {"inverse dynamics with a gravity", INVERSE, 0, ALIGNED, 0, SELF_TEST_GRAVITY},
    {"inverse dynamics with a payload", INVERSE, 0, ALIGNED, 0, SELF_TEST_PAYLOAD},
    {"inverse dynamics with a wrench", INVERSE, 0, ALIGNED, 0, SELF_TEST_WRENCH},
    {"derivatives", TFA_OP_DERIVATIVES, 0, ALIGNED, 0, 0},
    {"derivatives at rest", TFA_OP_DERIVATIVES, 0, ALIGNED, 0, SELF_TEST_AT_REST},
    {"derivatives with a gravity", TFA_OP_DERIVATIVES, 0, ALIGNED, 0, SELF_TEST_GRAVITY},
    {"derivatives of inverse dynamics", TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, 0, ALIGNED, 0, 0},
    {"mass matrix", MASS, 0, ALIGNED, 0, 0},
    {"mass matrix with a payload", MASS, 0, ALIGNED, 0, SELF_TEST_PAYLOAD},
    {"mass matrix with a locked joint", MASS, 0, ALIGNED, 0, SELF_TEST_LOCKED},
    {"lambda_inv", LAMBDA, 1, ALIGNED, 0, 0},
    {"lambda_inv in the link's frame", LAMBDA, 1, TFA_FRAME_LOCAL, 0, 0},
    {"lambda_inv in the world's frame", LAMBDA, 1, TFA_FRAME_WORLD, 0, 0},
    {"lambda_inv of two tips", LAMBDA, 2, ALIGNED, 0, 0},
    {"lambda_inv with a payload", LAMBDA, 1, ALIGNED, 0, SELF_TEST_PAYLOAD},
    {"lambda_inv with a locked joint", LAMBDA, 1, ALIGNED, 0, SELF_TEST_LOCKED},
    {"lambda_inv and poses", LAMBDA, 1, ALIGNED, TFA_WANT_POSES, 0},
    {"forward dynamics and lambda_inv", FORWARD, 1, ALIGNED, 0, 0},
    {"forward dynamics and lambda_inv with a wrench", FORWARD, 1, ALIGNED, 0, SELF_TEST_WRENCH},
    {"forward dynamics and lambda_inv of two tips", FORWARD, 2, ALIGNED, 0, 0},
    {"forward dynamics, lambda_inv and poses", FORWARD, 1, ALIGNED, TFA_WANT_POSES, 0},
};

/* A NaN that no computation yields */
static const uint64_t unwritten = 0x7ff8dead0000beefull;

static void poison(struct self_test *t)
{
    for (size_t k = 0; k < t->outputs_count; k++)
        memcpy(&t->outputs[k], &unwritten, sizeof unwritten);
}

static int guard_intact(const double *at)
{
    for (int k = 0; k < SELF_TEST_GUARD; k++)
        if (memcmp(&at[k], &unwritten, sizeof unwritten) != 0)
            return 0;
    return 1;
}

static int guards_intact(const struct self_test *t)
{
    const size_t v = (size_t)SELF_TEST_STATES * t->model->v_count, n = SELF_TEST_STATES;
    const tfa_reply *r = &t->tested.reply;
    return guard_intact(r->qdd + v) && guard_intact(r->tau + v) &&
           guard_intact(r->base_acceleration + 6 * n) && guard_intact(r->base_wrench + 6 * n) &&
           guard_intact(r->lambda_inv + 144 * n) && guard_intact(r->poses + 14 * n) &&
           guard_intact(r->mass_matrix + self_test_mass(t->model) * n) &&
           guard_intact(r->dqdd_dq + self_test_derivatives(t->model) * n) &&
           guard_intact(r->dqdd_dv + self_test_derivatives(t->model) * n) &&
           guard_intact(r->dqdd_dtau + self_test_derivatives(t->model) * n);
}

/* ---- comparison ---- */

/* One array of an answer */
struct result_array {
    const char *name;
    const double *tested, *reference;
    size_t n; /* numbers of a state */
};

#define RESULT_ARRAYS 4 /* of one answer, at most */

/* Derivatives of state k; those of tau are where those of qdd are. Returns how many. */
static uint32_t derivative_arrays(const struct self_test *t, uint32_t k, struct result_array *p)
{
    const tfa_reply *a = &t->tested.reply, *b = &t->reference.reply;
    const size_t entries = self_test_derivatives(t->model), at = entries * k;
    p[0] = (struct result_array){"dq", a->dqdd_dq + at, b->dqdd_dq + at, entries};
    p[1] = (struct result_array){"dv", a->dqdd_dv + at, b->dqdd_dv + at, entries};
    p[2] = (struct result_array){"dqdd_dtau", a->dqdd_dtau + at, b->dqdd_dtau + at, entries};
    return t->request.op == TFA_OP_DERIVATIVES ? 3 : 2;
}

/* Arrays of state k; accelerations of base and joints are compared together. */
static uint32_t result_arrays(const struct self_test *t, uint32_t k,
                              struct result_array p[RESULT_ARRAYS])
{
    const tfa_request *r = &t->request;
    const tfa_reply *a = &t->tested.reply, *b = &t->reference.reply;
    const size_t nv = t->model->v_count, n = (size_t)36 * r->tip_count * r->tip_count;
    const size_t poses = (size_t)7 * r->tip_count;
    const size_t base = t->model->base_freedoms;
    uint32_t count = 0;
    if (r->op == TFA_OP_FORWARD_DYNAMICS) {
        p[count++] = (struct result_array){"qdd", a->qdd + nv * k, b->qdd + nv * k, nv};
        p[count++] = (struct result_array){"base_acceleration", a->base_acceleration + base * k,
                                           b->base_acceleration + base * k, base};
    } else if (r->op == TFA_OP_INVERSE_DYNAMICS) {
        p[count++] = (struct result_array){"tau", a->tau + nv * k, b->tau + nv * k, nv};
        p[count++] = (struct result_array){"base_wrench", a->base_wrench + base * k,
                                           b->base_wrench + base * k, base};
    }
    if (TFA_OP_BIT(r->op) & TRAITS_DERIVATIVES)
        count += derivative_arrays(t, k, p + count);
    if (r->op == TFA_OP_MASS_MATRIX) {
        const size_t entries = self_test_mass(t->model);
        p[count++] = (struct result_array){"mass_matrix", a->mass_matrix + entries * k,
                                           b->mass_matrix + entries * k, entries};
    }
    if (r->tip_count)
        p[count++] =
            (struct result_array){"lambda_inv", a->lambda_inv + n * k, b->lambda_inv + n * k, n};
    if (r->flags & TFA_WANT_POSES)
        p[count++] =
            (struct result_array){"poses", a->poses + poses * k, b->poses + poses * k, poses};
    return count;
}

static double largest(const double *x, size_t n)
{
    double most = 0;
    for (size_t e = 0; e < n; e++)
        most = fmax(most, fabs(x[e]));
    return most;
}

/* Largest difference; NaN if a number is NaN. */
static double difference(const struct result_array *p)
{
    double most = 0;
    for (size_t e = 0; e < p->n; e++) {
        const double d = fabs(p->tested[e] - p->reference[e]);
        if (!(d <= most))
            most = d;
        if (isnan(d))
            return d;
    }
    return most;
}

/* Compares state k and updates *error. Returns the name of the wrong array, or NULL. */
static const char *compare_state(const struct self_test *t, uint32_t k, enum way way, double *wrong,
                                 double *error)
{
    struct result_array p[RESULT_ARRAYS];
    const uint32_t count = result_arrays(t, k, p);
    const double least = way == BATCH_F32 ? RELATIVE_ERROR_MAX_F32 : RELATIVE_ERROR_MAX;
    const double estimate = t->reference.answers[k].error_estimate * ESTIMATE_FACTOR *
                            (way == BATCH_F32 ? ROUNDING_F32 : 1);
    const double bound = estimate > least ? estimate : least; /* also without an estimate */
    const int motion = (TFA_OP_BIT(t->request.op) & (TRAIT_FD | TRAIT_ID)) != 0;
    const double motion_size =
        motion ? fmax(largest(p[0].reference, p[0].n), largest(p[1].reference, p[1].n)) : 0;
    for (uint32_t i = 0; i < count; i++) {
        const double size = motion && i < 2 ? motion_size : largest(p[i].reference, p[i].n);
        const double relative = size > 0 ? difference(&p[i]) / size : difference(&p[i]);
        if (!(relative <= bound)) {
            *wrong = relative;
            return p[i].name;
        }
        if (bound <= least)
            *error = fmax(*error, relative);
    }
    return NULL;
}

/* ---- asking it ---- */

/* Runs the kernel on all states; done[k]: it answered. */
static void run_kernel(struct self_test *t, const struct tfa_specialised_kernel *kernel,
                       enum way way, uint8_t done[SELF_TEST_STATES])
{
    const uint32_t count = t->request.count, lanes = lanes_of(kernel, way);
    for (uint32_t k = 0; k < count;) {
        const uint32_t some = count - k < lanes ? count - k : lanes;
        tfa_reply reply = t->tested.reply;
        reply.answers = NULL;
        const uint32_t answered =
            way == ALONE ? kernel->solve(&t->host, &t->request, k, &reply)
                         : (way == BATCH ? kernel->solve_batch : kernel->solve_batch_f32)(
                               &t->host, &t->request, k, some, &reply);
        for (uint32_t l = 0; l < some; l++)
            done[k + l] = answered >> l & 1;
        k += some;
    }
}

static int report_difference(struct error_text *err, const char *path, const char *question,
                             enum way way, const char *result_array, uint32_t k, double wrong)
{
    char size[48] = "has numbers that were not written, or are none";
    if (!isnan(wrong))
        snprintf(size, sizeof size, "is off by %.2g of its size", wrong);
    return refuse(err, TFA_E_NOT_COMPUTED, "'%s' is refused: %s%s: %s of state %u %s", path,
                  question, way_names[way], result_array, k, size);
}

static int run_case(struct self_test *t, const struct tfa_specialised_kernel *kernel,
                    const char *path, const struct self_test_case *test_case, enum way way,
                    double *error, struct error_text *err)
{
    uint8_t done[SELF_TEST_STATES] = {0};
    double wrong = 0;
    poison(t);
    tfa_request r = t->request;
    if (TFA_OP_BIT(test_case->op) & (TRAIT_FD | TRAIT_OSIM | TRAIT_DERIVATIVES))
        r.estimate = TFA_ESTIMATE_ALWAYS;
    (void)tfa_compute(t->generic, &r, &t->reference.reply);
    run_kernel(t, kernel, way, done);
    if (!guards_intact(t))
        return refuse(err, TFA_E_NOT_COMPUTED,
                      "'%s' is refused: %s: it writes behind the end of an answer", path,
                      test_case->name);
    for (uint32_t k = 0; k < r.count; k++) {
        if (t->reference.answers[k].status != TFA_OK)
            continue;
        t->compared++;
        t->unanswered += !done[k];
        const char *result_array = done[k] ? compare_state(t, k, way, &wrong, error) : NULL;
        if (result_array)
            return report_difference(err, path, test_case->name, way, result_array, k, wrong);
    }
    return TFA_OK;
}

/* In all ways in which the kernel answers the request */
static int run_case_in_all_ways(struct self_test *t, tfa_specialised *s, const char *path,
                                const struct self_test_case *test_case, struct error_text *err)
{
    const struct tfa_specialised_kernel *kernel = s->kernel;
    const int doubles = kernel->supports(&t->host, &t->request);
    const int floats = kernel->lanes_f32 && kernel->supports_f32(&t->host, &t->request);
    int status = TFA_OK;
    for (enum way way = ALONE; status == TFA_OK && way < WAYS; way++)
        if (lanes_of(kernel, way) && (way == BATCH_F32 ? floats : doubles))
            status = run_case(t, kernel, path, test_case, way,
                              way == BATCH_F32 ? &s->error_f32 : &s->error, err);
    return status;
}

/* Sets t->request, with the next tip from *tip on with which it is valid; 0: there is none. */
static int next_request(struct self_test *t, const struct self_test_case *test_case, uint32_t *tip)
{
    tfa_reply checked;
    for (; *tip < t->model->bodies; ++*tip) {
        if (!test_case->tips)
            *tip = t->model->bodies - 1;
        self_test_request(t, test_case, *tip);
        if (tfa_request_check(t->model, &t->request, &checked) == TFA_OK)
            return 1;
    }
    return 0;
}

static int run_case_on_tips(struct self_test *t, tfa_specialised *s, const char *path,
                            const struct self_test_case *test_case, struct error_text *err)
{
    int status = TFA_OK;
    for (uint32_t tip = 0; status == TFA_OK && next_request(t, test_case, &tip); tip++)
        status = run_case_in_all_ways(t, s, path, test_case, err);
    return status;
}

int specialised_self_test(const char *path, const tfa_model *model, tfa_specialised *s,
                          struct error_text *err)
{
    struct self_test t;
    s->error = s->error_f32 = 0;
    int status = self_test_open(&t, model);
    for (size_t i = 0; status == TFA_OK && i < sizeof cases / sizeof *cases; i++)
        status = run_case_on_tips(&t, s, path, &cases[i], err);
    if (status == TFA_OK && 2 * t.unanswered >= t.compared)
        status = refuse(err, TFA_E_NOT_COMPUTED,
                        "'%s' is refused: it left %u of %u states to the generic kernel", path,
                        t.unanswered, t.compared);
    self_test_close(&t);
    return status;
}

/* ---- one state and states in lanes ---- */

/* 1: the states of the request have the same bits alone and in lanes */
static int has_same_bits(struct self_test *t, const struct tfa_specialised_kernel *kernel)
{
    uint8_t alone[SELF_TEST_STATES] = {0}, batch[SELF_TEST_STATES] = {0};
    const struct self_test_reply other = t->reference;
    struct result_array p[RESULT_ARRAYS];
    int same = 1;
    run_kernel(t, kernel, ALONE, alone);
    t->reference = t->tested;
    t->tested = other;
    run_kernel(t, kernel, BATCH, batch);
    for (uint32_t k = 0; k < t->request.count; k++)
        for (uint32_t i = alone[k] && batch[k] ? result_arrays(t, k, p) : 0; i-- > 0;)
            same &= memcmp(p[i].tested, p[i].reference, p[i].n * sizeof(double)) == 0;
    return same;
}

int self_test_same_bits(const tfa_model *model, const struct tfa_specialised_kernel *kernel)
{
    struct self_test t;
    int same = self_test_open(&t, model) == TFA_OK;
    if (kernel->lanes)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
            for (uint32_t tip = 0; same && next_request(&t, &cases[i], &tip); tip++)
                same = !kernel->supports(&t.host, &t.request) || has_same_bits(&t, kernel);
    self_test_close(&t);
    return same;
}
