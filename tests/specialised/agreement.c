/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Specialised kernels beside the generic kernel and beside quadruple precision, at random states of
 * every robot that has one in TFA_TEST_KERNELS.
 *
 * Differences and errors are relative to the largest number of an answer. Both kernels round, each
 * in its order: in these states, which are well-conditioned, they differ by no more than AGREEMENT;
 * and the errors of a kernel are on the whole no larger than those of the generic one, up to LOSS.
 * So in double, and in float with states that floats hold. There is no generic Lambda^-1 in float:
 * its errors are compared with those in double times the ratio of the roundings.
 */
#include "fixture.h"
#include "interface/specialised_abi.h"
#include "kernels.h"
#include "model/model.h"
#include "models.h"
#include "same_bits.h"
#include "test.h"

#define STATES 200
#define FREEDOMS 64 /* of a robot, at most */
#define WRENCHES 3
/* By aba, by crba, and by what was chosen. Eliminating M loses more than articulated inertias
 * do where M is worse conditioned than its joints, and no product is fused with a sum here. Answers
 * of arm7 by crba have up to 10.3 times the error; those of iiwa14, where it was chosen, 3.1 times
 * (gcc 12, clang 14, AVX2, 2026-11-26). */
#define AGREEMENT (by("aba") ? 2e-14 : 3e-14)
/* Of derivatives, M^-1 times forces at qdd: 6.0e-13 for arm7 (clang 14, AVX2, 2026-11-28) */
#define DERIVATIVES_AGREEMENT 2e-12
#define LOSS (by("crba") ? 14.0 : by("aba") && t->precision == TFA_F64 ? 2.0 : 4.0)
#define ULP 1e-16           /* no error is smaller than that of rounding the answer */
#define ROUNDING_F32 0x1p29 /* of floats over that of doubles */

/* Whether the folder's name, kernels_ALGORITHM, is of this algorithm */
static int by(const char *algorithm)
{
    const char *folder = getenv("TFA_TEST_KERNELS"), *end = folder ? strrchr(folder, '_') : NULL;
    return end && strcmp(end + 1, algorithm) == 0;
}

struct answer {
    double x[STATES * FREEDOMS], base[STATES * 6], lambda[STATES * 36];
    double mass[STATES * FREEDOMS * FREEDOMS];
    double derivatives[3][STATES * FREEDOMS * FREEDOMS]; /* by q, v and tau */
};

/* What was found about one robot: the largest of each */
struct result {
    double difference, derivatives, loss;
    uint32_t questions, tips;
};

struct comparison {
    test_robot *robot;
    random_states *states;
    tfa_precision precision;
    tfa_workspace *specialised;       /* that of the fixture, which has the kernel */
    tfa_workspace *generic, *doubles; /* without, of this precision and of doubles */
    struct result result;
    struct answer by_specialised, by_generic, exact;
};

static uint32_t robots, kernels_found;

/* ---- what is compared ---- */

/* One state's numbers that are compared together, in two arrays */
struct result_array {
    size_t at[2], n[2]; /* in struct answer, from its start; how many */
};

static const double *array(const struct answer *a, const struct result_array *p, int part)
{
    return (const double *)(const void *)((const char *)a + p->at[part]);
}

static double largest_of(const struct answer *a, const struct result_array *p, uint32_t k)
{
    double most = 0;
    for (int part = 0; part < 2; part++)
        for (size_t e = k * p->n[part]; e < (k + 1) * p->n[part]; e++)
            most = fmax(most, fabs(array(a, p, part)[e]));
    return most;
}

/* Infinite where a number is none */
static double distance(const struct answer *a, const struct answer *b, const struct result_array *p,
                       uint32_t k)
{
    double most = 0;
    for (int part = 0; part < 2; part++)
        for (size_t e = k * p->n[part]; e < (k + 1) * p->n[part]; e++) {
            const double d = fabs(array(a, p, part)[e] - array(b, p, part)[e]);
            most = d <= INFINITY ? fmax(most, d) : INFINITY;
        }
    return most;
}

/* `rounding`: that of the specialised answers over that of the generic ones */
static void compare_states(struct comparison *t, const char *what, const struct result_array *p,
                           double rounding)
{
    const double ratio = t->precision == TFA_F32 ? ROUNDING_F32 : 1;
    const bool derivatives = p->at[0] >= offsetof(struct answer, derivatives);
    double *const differs = derivatives ? &t->result.derivatives : &t->result.difference;
    double specialised = 0, generic = 0, most = 0;
    for (uint32_t k = 0; k < STATES; k++) {
        const double size = largest_of(&t->exact, p, k);
        const double specialised_error = distance(&t->by_specialised, &t->exact, p, k) / size;
        const double generic_error = distance(&t->by_generic, &t->exact, p, k) / size;
        most = fmax(most, distance(&t->by_specialised, &t->by_generic, p, k) / size);
        specialised += specialised_error * specialised_error;
        generic += generic_error * generic_error;
    }
    specialised = sqrt(specialised / STATES);
    generic = fmax(rounding * sqrt(generic / STATES), ratio * ULP);
    assert_within(t->robot, what, most, derivatives ? DERIVATIVES_AGREEMENT : ratio * AGREEMENT,
                  differs);
    if (!(specialised <= LOSS * generic))
        fail_msg("%s: %s: errors of %.2g, of the generic kernel %.2g", t->robot->name, what,
                 specialised, generic);
    t->result.loss = fmax(t->result.loss, specialised / generic);
}

/* ---- asking ---- */

/* State k of a request without tips, alone */
static tfa_request single(const struct comparison *t, const tfa_request *all, uint32_t k)
{
    const size_t nq = t->robot->nq, nv = t->robot->nv;
    tfa_request r = *all;
    r.count = 1;
    r.q += nq * k;
    r.v += nv * k;
    r.tau += nv * k;
    r.qdd += nv * k;
    r.wrenches += (size_t)6 * r.wrench_count * k;
    if (r.base_pose) {
        r.base_pose += (size_t)7 * k;
        r.base_twist += (size_t)6 * k;
        r.base_wrench += (size_t)6 * k;
        r.base_acceleration += (size_t)6 * k;
    }
    return r;
}

/* Writes what was asked of state k, and behind it. */
static void compute(const struct comparison *t, tfa_workspace *w, const tfa_request *r, uint32_t k,
                    struct answer *a)
{
    const int forces = r->op == TFA_OP_INVERSE_DYNAMICS;
    const size_t entries = (size_t)t->robot->n * t->robot->n * k;
    tfa_reply reply = {.lambda_inv = a->lambda + (size_t)36 * k,
                       .mass_matrix = a->mass + entries,
                       .dqdd_dq = a->derivatives[0] + entries,
                       .dqdd_dv = a->derivatives[1] + entries,
                       .dqdd_dtau = a->derivatives[2] + entries,
                       .dtau_dq = a->derivatives[0] + entries,
                       .dtau_dv = a->derivatives[1] + entries};
    *(forces ? &reply.tau : &reply.qdd) = a->x + (size_t)t->robot->nv * k;
    *(forces ? &reply.base_wrench : &reply.base_acceleration) = a->base + (size_t)6 * k;
    compute_ok(t->robot, w, r, &reply);
}

/* Asks the kernel, for all states at once or for one after the other. Does it answer? If so, then
 * all of them: compare_states needs a computed answer. */
static bool ask_specialised(struct comparison *t, const tfa_request *r, bool one_by_one)
{
    const uint64_t before = kernels_answered();
    memset(&t->by_specialised, 0xff, sizeof t->by_specialised);
    for (uint32_t k = 0; one_by_one && k < STATES; k++) {
        const tfa_request one = single(t, r, k);
        compute(t, t->specialised, &one, k, &t->by_specialised);
    }
    if (!one_by_one)
        compute(t, t->specialised, r, 0, &t->by_specialised);
    if (kernels_answered() == before)
        return false;
    assert_int_equal(kernels_answered() - before, STATES);
    t->result.questions++;
    return true;
}

/* Accelerations of this precision; with tips floats become doubles. */
static void ask_others(struct comparison *t, const tfa_request *r)
{
    tfa_request motion = *r;
    motion.tip_count = 0;
    if (r->tip_count)
        compute(t, t->doubles, r, 0, &t->by_generic);
    if (r->op != TFA_OP_OPERATIONAL_INERTIA)
        compute(t, t->generic, &motion, 0, &t->by_generic);
    compute(t, t->robot->f128, r, 0, &t->exact);
}

static void compare_accelerations(struct comparison *t, const char *what)
{
    const struct result_array p = {{offsetof(struct answer, x), offsetof(struct answer, base)},
                                   {t->robot->nv, t->robot->n - t->robot->nv}};
    compare_states(t, what, &p, 1);
}

static void compare_lambda(struct comparison *t, const char *what)
{
    compare_states(t, what, &(struct result_array){{offsetof(struct answer, lambda)}, {36}},
                   t->precision == TFA_F32 ? ROUNDING_F32 : 1);
}

/* An entry and its mirror image are the same number. */
static void compare_mass(struct comparison *t, const char *what)
{
    const size_t n = t->robot->n;
    for (size_t k = 0; k < STATES; k++)
        for (size_t e = 0; e < n * n; e++)
            assert_memory_equal(&t->by_specialised.mass[n * n * k + e],
                                &t->by_specialised.mass[n * n * k + e % n * n + e / n],
                                sizeof(double));
    compare_states(t, what, &(struct result_array){{offsetof(struct answer, mass)}, {n * n}}, 1);
}

static void compare_derivatives(struct comparison *t, tfa_op op)
{
    static const char *const names[] = {"derivative by q", "derivative by v", "derivative by tau"};
    const size_t entries = (size_t)t->robot->n * t->robot->n;
    for (size_t by = 0; by < (op == TFA_OP_DERIVATIVES ? 3 : 2); by++)
        compare_states(
            t, names[by],
            &(struct result_array){{offsetof(struct answer, derivatives[by])}, {entries}}, 1);
}

/* Without wrenches */
static tfa_request request_of(const struct comparison *t, tfa_op op)
{
    tfa_request r = fixture_request(t->robot, t->states);
    r.op = op;
    r.wrench_count = 0;
    if (t->precision == TFA_F32) /* or the sentinel leaves some states of humanoids to double */
        r.estimate = TFA_ESTIMATE_NEVER;
    return r;
}

/* Kernels have other code for one state than for several. `alone`: they have some for one. */
static void compare_motion(struct comparison *t, const tfa_request *r, bool alone, const char *what)
{
    ask_others(t, r);
    for (int one_by_one = 0; one_by_one < 2; one_by_one++) {
        if (ask_specialised(t, r, one_by_one)) {
            if (r->op == TFA_OP_DERIVATIVES || r->op == TFA_OP_INVERSE_DYNAMICS_DERIVATIVES)
                compare_derivatives(t, r->op);
            else
                (r->op == TFA_OP_MASS_MATRIX ? compare_mass : compare_accelerations)(t, what);
        } else if (alone || !one_by_one)
            fail_msg("%s: the kernel leaves %s to the generic one", t->robot->name, what);
    }
}

static void compare_motions(struct comparison *t)
{
    const tfa_request forward = request_of(t, TFA_OP_FORWARD_DYNAMICS);
    const tfa_request inverse = request_of(t, TFA_OP_INVERSE_DYNAMICS);
    compare_motion(t, &forward, true, "qdd");
    const tfa_request mass = request_of(t, TFA_OP_MASS_MATRIX);
    compare_motion(t, &inverse, true, "tau");
    compare_motion(t, &mass, true, "mass_matrix");
    if (t->robot->base == TFA_BASE_FLOATING || t->robot->n > TFA_SPECIALISED_DERIVATIVES_MAX ||
        t->precision != TFA_F64)
        return;
    const tfa_request derivatives = request_of(t, TFA_OP_DERIVATIVES);
    const tfa_request of_tau = request_of(t, TFA_OP_INVERSE_DYNAMICS_DERIVATIVES);
    compare_motion(t, &derivatives, true, "derivatives of qdd");
    compare_motion(t, &of_tau, true, "derivatives of tau");
}

static void add_payloads(const struct comparison *t, tfa_request *r)
{
    static const double payloads[2 * TFA_PAYLOAD_NUMBERS] = {
        0.7, 0.02, -0.03, 0.05, 0.004, 0.001, 0.002, 0.005, 0,    0.006,
        1.5, 0,    0.1,   0,    0.02,  0,     0,     3e-3,  1e-3, 0.02};
    const uint32_t frames = t->robot->model->frames;
    r->payload_count = 2;
    r->payloads = payloads;
    r->payload_frames[0] = frames - 1;
    r->payload_frames[1] = frames / 2;
}

/* Wrenches in each of the three frames, then payloads, too. Large robots have no code for qdd with
 * payloads, and none in double for one state's tau with wrenches (ROBOT_HAS_INVERSE_WRENCHES). */
static void compare_loads(struct comparison *t)
{
    const bool small = t->robot->n <= 40;
    for (uint32_t k = 0; k < 6; k++) {
        tfa_request r = request_of(t, TFA_OP_FORWARD_DYNAMICS);
        r.wrench_count = k < 5 ? WRENCHES : 0;
        r.frame = (tfa_reference_frame)(k % 3);
        if (k >= 3)
            add_payloads(t, &r);
        if (k < 3 || small)
            compare_motion(t, &r, true, "qdd with loads");
        r.op = TFA_OP_INVERSE_DYNAMICS;
        compare_motion(t, &r, small || t->precision == TFA_F32, "tau with loads");
        r.op = TFA_OP_MASS_MATRIX;
        compare_motion(t, &r, true, "mass_matrix with loads");
    }
}

/* Has a later frame the same body? It is tried, then: the first stands at the joint. */
static bool comes_again(const struct tfa_model *m, uint32_t f)
{
    for (uint32_t later = f + 1; later < m->frames; later++)
        if (m->frame[later].body == m->frame[f].body)
            return true;
    return false;
}

/* Kernels of large robots take some tips only. */
static void compare_tips(struct comparison *t)
{
    tfa_request r = request_of(t, TFA_OP_FORWARD_DYNAMICS);
    r.tip_count = 1;
    r.wrench_count = WRENCHES;
    for (uint32_t f = 0; f < t->robot->model->frames; f++) {
        if (comes_again(t->robot->model, f))
            continue;
        r.op = TFA_OP_FORWARD_DYNAMICS;
        r.tips[0] = f;
        r.frame = (tfa_reference_frame)(f % 3);
        const bool taken = ask_specialised(t, &r, false);
        if (taken) {
            ask_others(t, &r);
            compare_accelerations(t, "qdd with lambda_inv");
            compare_lambda(t, "lambda_inv with qdd");
        }
        r.op = TFA_OP_OPERATIONAL_INERTIA;
        const bool single = ask_specialised(
            t, &r, false); /* more of them than with qdd (ROBOT_TWO_PASS_BODIES_MAX) */
        assert_true(single || !taken);
        if (single) {
            ask_others(t, &r);
            compare_lambda(t, "lambda_inv");
        }
        t->result.tips += single;
    }
    if (!t->result.tips)
        fail_msg("%s: the kernel leaves all tips to the generic one", t->robot->name);
}

/* ---- robots ---- */

static bool is_ours(const test_robot *robot)
{
    static const char *const names[] = {"arm7.urdf", "quadruped.urdf", "humanoid.urdf"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (strncmp(robot->name, names[k], strlen(names[k])) == 0)
            return true;
    return false;
}

static void round_to_float(double *x, size_t n)
{
    for (size_t k = 0; x && k < n; k++)
        x[k] = (float)x[k];
}

static void round_states(const test_robot *robot, random_states *x)
{
    round_to_float(x->q, (size_t)STATES * robot->nq);
    round_to_float(x->v, (size_t)STATES * robot->nv);
    round_to_float(x->tau, (size_t)STATES * robot->nv);
    round_to_float(x->qdd, (size_t)STATES * robot->nv);
    round_to_float(x->wrenches, (size_t)STATES * WRENCHES * 6);
    round_to_float(x->base_pose, (size_t)STATES * 7);
    round_to_float(x->base_twist, (size_t)STATES * 6);
    round_to_float(x->base_wrench, (size_t)STATES * 6);
    round_to_float(x->base_acceleration, (size_t)STATES * 6);
}

static void try_robot_in(test_robot *robot, tfa_precision precision)
{
    const tfa_workspace_options options = {.precision = precision};
    assert_true(robot->n <= FREEDOMS);
    struct comparison *t = calloc(1, sizeof *t);
    assert_non_null(t);
    t->robot = robot;
    t->precision = precision;
    t->specialised = precision == TFA_F32 ? robot->f32 : robot->f64;
    t->generic = workspace_for(robot->model, &options);
    t->doubles = workspace_for(robot->model, NULL);
    t->states = fixture_states(robot, 0, STATES, WRENCHES);
    if (precision == TFA_F32)
        round_states(robot, t->states);
    compare_motions(t);
    compare_loads(t);
    compare_tips(t);
    print_message("  %-40s %s %4u questions, %2u tips: differs by up to %.1e, derivatives by %.1e, "
                  "errors %.2f times those of the generic kernel\n",
                  robot->name, precision == TFA_F32 ? "f32" : "f64", (unsigned)t->result.questions,
                  (unsigned)t->result.tips, t->result.difference, t->result.derivatives,
                  t->result.loss);
    random_states_free(t->states);
    tfa_workspace_free(t->generic);
    tfa_workspace_free(t->doubles);
    free(t);
}

static void try_robot(test_robot *robot)
{
    try_robot_in(robot, TFA_F64);
    try_robot_in(robot, TFA_F32);
    assert_same_bits(robot->model, kernels_find(robot->model));
    robots++;
    kernels_found += is_ours(robot);
}

TEST(kernels_agree_with_the_generic_one)
{
    if (!getenv("TFA_TEST_KERNELS"))
        fail_msg("TFA_TEST_KERNELS must name the folder that test_make_kernels filled");
    for_every_robot(try_robot, false);
    const uint32_t wanted = by("aba") ? 5 : by("crba") ? 2 : 1; /* make_kernels.c */
    if (kernels_found != wanted)
        fail_msg("%u kernels of arm7, quadruped and humanoid instead of %u", kernels_found, wanted);
    if (robots == kernels_found)
        print_message("SKIP: no kernels of robots in ../shared/robots\n");
}
