/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots with flexible links agree with their oracle: accelerations, Lambda^-1, kinematics.
 *
 * The bounds are relative errors in the 2-norm over one state's answer, those of rigid robots
 * (laws.c). Accelerations of base, joints and modes are one vector.
 */
#include "support/flexible_robot.h"
#include "test.h"

#define STATES 2 /* at most */
#define WRENCHES 3

enum { F64, REFINED, F128, F64_F128, F32, F32_F64, COLUMNS };
static const struct {
    const char *name;
    tfa_precision factors;
    tfa_residual residual;
    uint32_t refine;
} columns[COLUMNS] = {
    {"", TFA_F64, TFA_RESIDUAL_SAME, 0},
    {", refined", TFA_F64, TFA_RESIDUAL_SAME, 1},
    {", f128", TFA_F128, TFA_RESIDUAL_SAME, 0},
    {", residual f128", TFA_F64, TFA_RESIDUAL_F128, TFA_REFINE_DEFAULT},
    {", f32", TFA_F32, TFA_RESIDUAL_SAME, 0},
    {", f32, residual f64", TFA_F32, TFA_RESIDUAL_F64, TFA_REFINE_DEFAULT},
};

/* One method, and what it may lose in each column; 0: not asked */
struct way {
    tfa_method method;
    double bound[COLUMNS], worst[COLUMNS];
};

static struct way forward_ways[] = {
    {TFA_METHOD_ABA, {2e-12, 5e-14, 1e-14, 1e-14, 7e-4, 5e-14}, {0}},
    {TFA_METHOD_SCAN, {2e-12, 5e-14, 1e-14, 1e-14}, {0}},
    {TFA_METHOD_SCAN_TWO_PASS, {2e-12, 5e-14, 1e-14, 1e-14}, {0}},
    {TFA_METHOD_DCA, {1e-10, 5e-14, 1e-14, 1e-14}, {0}},
    {TFA_METHOD_AUTO, {2e-12, 5e-14, 1e-14, 1e-14}, {0}},
};
static struct way lambda_ways[] = {
    {TFA_METHOD_PROPAGATION, {2e-12, 0, 2e-14}, {0}},
    {TFA_METHOD_ABA, {2e-12, 3e-14, 2e-14}, {0}},
    {TFA_METHOD_SCAN, {2e-12, 3e-14, 2e-14}, {0}},
    {TFA_METHOD_SCAN_TWO_PASS, {2e-12, 3e-14, 2e-14}, {0}},
    {TFA_METHOD_DCA, {4e-10, 3e-14, 2e-14}, {0}},
    {TFA_METHOD_AUTO, {2e-12, 0, 2e-14}, {0}},
};
#define WAYS(ways) (sizeof(ways) / sizeof *(ways))

static void print_worst(const struct way *ways, size_t count)
{
    for (const struct way *way = ways; way < ways + count; way++)
        for (int c = 0; c < COLUMNS; c++)
            if (way->bound[c] > 0)
                print_message("  %s%s: worst %.2g, bound %g\n", tfa_method_name(way->method),
                              columns[c].name, way->worst[c], way->bound[c]);
}

/* The oracle: M is symmetric, T = v^T M v / 2, and twists of all links are J v. */
static void oracle_itself(flexible_robot *f)
{
    const uint32_t n = f->n, six = f->robot.n - f->robot.nv;
    flexible_states s = flexible_states_make(f, 1, 1, 0);
    const tfa_request r = flexible_request(f, &s);
    quad *v = calloc(n, sizeof *v), *J = calloc((size_t)6 * n, sizeof *J), T = 0;
    oracle_modes_set_state(f->o, &r, 0);
    const quad *M = oracle_modes_mass_matrix(f->o), kinetic = oracle_modes_sums_of(f->o).kinetic;
    for (uint32_t k = 0; k < n; k++)
        v[k] = k < six          ? s.x->base_twist[k]
               : k < f->robot.n ? s.x->v[k - six]
                                : s.rates[k - f->robot.n];
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++) {
            T += v[i] * M[i * n + k] * v[k] / 2;
            assert_true(fabs((double)(M[i * n + k] - M[k * n + i])) < 1e-28);
        }
    assert_true(fabs((double)(T - kinetic)) < 1e-28 * (double)T);
    for (uint32_t link = 0; link < f->robot.description->link_count; link++) {
        const oracle_modes_tip tip = oracle_modes_tip_of(f->o, link, TFA_FRAME_WORLD);
        memset(J, 0, (size_t)6 * n * sizeof *J);
        oracle_modes_jacobian(f->o, link, TFA_FRAME_WORLD, J);
        for (uint32_t i = 0; i < 6; i++) {
            quad sum = -tip.twist[i];
            for (uint32_t k = 0; k < n; k++)
                sum += J[i * n + k] * v[k];
            assert_true(fabs((double)sum) < 1e-28);
        }
    }
    free(J);
    free(v);
    flexible_states_free(&s);
}

EVERY_FLEXIBLE_ROBOT(oracle_is_consistent, oracle_itself)

/* Asks one state in every way; `size` numbers that the oracle knows. */
static void by_every_way(const flexible_robot *f, tfa_request r, struct way *ways, size_t count,
                         const double *want, size_t size)
{
    tfa_workspace *w[COLUMNS];
    for (int c = 0; c < COLUMNS; c++)
        w[c] = fixture_mixed(f->robot.model, columns[c].factors, columns[c].residual);
    double *got = calloc(size, sizeof *got);
    tfa_reply reply = {.lambda_inv = got};
    for (struct way *way = ways; way < ways + count; way++)
        for (int c = 0; c < COLUMNS; c++) {
            char what[80];
            tfa_answer answer = {0};
            if (way->bound[c] == 0 || fixture_refuses(&f->robot, way->method))
                continue;
            snprintf(what, sizeof what, "%s%s, %u tips", tfa_method_name(way->method),
                     columns[c].name, (unsigned)r.tip_count);
            r.method = way->method;
            r.refine = columns[c].refine;
            reply.answers = &answer;
            if (r.op == TFA_OP_FORWARD_DYNAMICS)
                flexible_forward(f, w[c], &r, got, &answer);
            else
                compute_ok(&f->robot, w[c], &r, &reply);
            assert_within(&f->robot, what, relative_error(got, want, size), way->bound[c],
                          &way->worst[c]);
            if (r.op == TFA_OP_FORWARD_DYNAMICS && way->method != TFA_METHOD_AUTO && c <= F128)
                assert_int_equal(answer.method, way->method);
        }
    free(got);
    for (int c = 0; c < COLUMNS; c++)
        tfa_workspace_free(w[c]);
}

/* State k of a request, as a request of one state */
static tfa_request one_state(const flexible_robot *f, const tfa_request *r, uint32_t k)
{
    tfa_request one = *r;
    const size_t six = 6 * (size_t)k;
    one.count = 1;
    one.q += (size_t)k * f->robot.nq;
    one.v += r->v ? (size_t)k * f->robot.nv : 0;
    one.tau += r->tau ? (size_t)k * f->robot.nv : 0;
    one.base_pose += r->base_pose ? 7 * (size_t)k : 0;
    one.base_twist += r->base_twist ? six : 0;
    one.base_wrench += r->base_wrench ? six : 0;
    one.wrenches += r->wrenches ? six * r->wrench_count : 0;
    one.modes += r->modes ? (size_t)k * f->mode_count : 0;
    one.mode_velocities += r->mode_velocities ? (size_t)k * f->mode_count : 0;
    return one;
}

static void forward_dynamics(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 0, STATES, WRENCHES);
    tfa_request r = flexible_request(f, &s);
    double *want = calloc(f->n, sizeof *want);
    const uint32_t states = test_extent(1, STATES);
    r.estimate = TFA_ESTIMATE_NEVER;
    for (int pass = 0; pass < 5; pass++) { /* wrenches in three frames, at rest, not deformed */
        r.frame = (tfa_reference_frame)(pass % 3);
        if (pass == 3) {
            r.v = r.base_twist = NULL;
            r.mode_velocities = NULL;
        }
        if (pass == 4)
            r.modes = NULL;
        for (uint32_t k = 0; k < states; k++) {
            const tfa_request one = one_state(f, &r, k);
            oracle_modes_set_state(f->o, &one, 0);
            oracle_modes_forward(f->o, one.tau, one.base_wrench, want);
            by_every_way(f, one, forward_ways, WAYS(forward_ways), want, f->n);
        }
    }
    free(want);
    flexible_states_free(&s);
}

TEST(every_method_gives_the_acceleration)
{
    for_every_flexible_robot(forward_dynamics);
    print_worst(forward_ways, WAYS(forward_ways));
}

static void lambda_inv(flexible_robot *f)
{
    random_source source = {f->robot.seed};
    flexible_states s = flexible_states_make(f, 9, 1, 0);
    tfa_request r = flexible_request(f, &s);
    double *want = calloc((size_t)36 * TFA_DEFAULT_TIPS * TFA_DEFAULT_TIPS, sizeof *want);
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.estimate = TFA_ESTIMATE_NEVER;
    r.v = r.tau = r.base_twist = r.base_wrench = r.mode_velocities = NULL;
    oracle_modes_set_state(f->o, &r, 0);
    for (uint32_t tips = 1; tips <= TFA_DEFAULT_TIPS; tips += tips < 3 ? 1 : 5) {
        r.tip_count = tips;
        r.frame = (tfa_reference_frame)(tips % 3);
        for (uint32_t t = 0; t < tips; t++)
            r.tips[t] = random_below(&source, (uint32_t)f->robot.description->link_count);
        oracle_modes_lambda_inv(f->o, r.tips, tips, r.frame, want);
        by_every_way(f, r, lambda_ways, WAYS(lambda_ways), want, (size_t)36 * tips * tips);
    }
    free(want);
    flexible_states_free(&s);
}

TEST(every_method_gives_lambda_inv)
{
    for_every_flexible_robot(lambda_inv);
    print_worst(lambda_ways, WAYS(lambda_ways));
}

/* ---- kinematics ---- */

static double worst_kinematics;

/* |got - want| within so much of their size, or of 1 */
static void assert_numbers(const flexible_robot *f, const char *what, const double *got,
                           const quad *want, size_t count)
{
    double difference = 0, size = 1;
    for (size_t k = 0; k < count; k++) {
        difference = hypot(difference, got[k] - (double)want[k]);
        size = hypot(size, (double)want[k]);
    }
    assert_within(&f->robot, what, difference / size, 1e-13, &worst_kinematics);
}

static void assert_pose(const flexible_robot *f, const char *what, const double *pose,
                        const oracle_modes_tip *tip)
{
    const mat3 R = mat_from_quaternion(pose + 3);
    double axes[9];
    for (int k = 0; k < 9; k++)
        axes[k] = (double)R.col[k / 3].x[k % 3];
    assert_true(pose[6] >= 0);
    assert_numbers(f, what, pose, tip->p.x, 3);
    assert_numbers(f, what, axes, tip->R.col[0].x, 9);
}

static void check_tip(const flexible_robot *f, const tfa_request *r, const tfa_reply *reply,
                      uint32_t t)
{
    const oracle_modes_tip tip = oracle_modes_tip_of(f->o, r->tips[t], r->frame);
    const uint32_t n = f->robot.n;
    quad *J = calloc((size_t)6 * f->n, sizeof *J), *joints = calloc((size_t)6 * n, sizeof *J);
    oracle_modes_jacobian(f->o, r->tips[t], r->frame, J);
    for (uint32_t k = 0; k < 6 * n; k++)
        joints[k] = J[k / n * f->n + k % n];
    assert_pose(f, "pose", reply->poses + 7 * (size_t)t, &tip);
    assert_numbers(f, "twist", reply->twists + 6 * (size_t)t, tip.twist, 6);
    assert_numbers(f, "bias acceleration", reply->bias_acceleration + 6 * (size_t)t, tip.bias, 6);
    assert_numbers(f, "jacobian", reply->jacobian + 6 * (size_t)t * n, joints, 6 * (size_t)n);
    free(joints);
    free(J);
}

static void check_sums(const flexible_robot *f, const tfa_reply *reply)
{
    const oracle_modes_sums s = oracle_modes_sums_of(f->o);
    const vec3 velocity = vec_scale(1 / s.mass, s.momentum);
    assert_numbers(f, "mass", reply->mass, &s.mass, 1);
    assert_numbers(f, "com", reply->com, s.com.x, 3);
    assert_numbers(f, "com velocity", reply->com_velocity, velocity.x, 3);
    assert_numbers(f, "momentum", reply->momentum, s.momentum.x, 3);
    assert_numbers(f, "angular momentum", reply->momentum + 3, s.angular.x, 3);
    assert_numbers(f, "kinetic energy", reply->energy, &s.kinetic, 1);
    assert_numbers(f, "potential energy", reply->energy + 1, &s.potential, 1);
}

static void kinematics(flexible_robot *f)
{
    enum { TIPS = 4 };
    random_source source = {f->robot.seed};
    flexible_states s = flexible_states_make(f, 11, 1, 0);
    tfa_request r = flexible_request(f, &s);
    const size_t frames = f->robot.description->link_count;
    double poses[7 * TIPS], twists[6 * TIPS], bias[6 * TIPS], com[3], velocity[3], mass;
    double momentum[6], energy[2], *frame_poses = calloc(7 * frames, sizeof(double));
    double *J = calloc((size_t)6 * TIPS * f->robot.n, sizeof *J);
    tfa_reply reply = {.poses = poses,
                       .twists = twists,
                       .bias_acceleration = bias,
                       .jacobian = J,
                       .frame_poses = frame_poses,
                       .com = com,
                       .com_velocity = velocity,
                       .mass = &mass,
                       .momentum = momentum,
                       .energy = energy};
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_POSES | TFA_WANT_FRAME_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |
              TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY;
    r.tip_count = TIPS;
    oracle_modes_set_state(f->o, &r, 0);
    for (int frame = 0; frame < 3; frame++) {
        r.frame = (tfa_reference_frame)frame;
        for (uint32_t t = 0; t < TIPS; t++)
            r.tips[t] = random_below(&source, (uint32_t)frames);
        compute_ok(&f->robot, f->robot.f64, &r, &reply);
        for (uint32_t t = 0; t < TIPS; t++)
            check_tip(f, &r, &reply, t);
        check_sums(f, &reply);
        for (uint32_t k = 0; k < frames; k++) {
            const oracle_modes_tip tip = oracle_modes_tip_of(f->o, k, r.frame);
            assert_pose(f, "frame pose", frame_poses + 7 * (size_t)k, &tip);
        }
    }
    free(J);
    free(frame_poses);
    flexible_states_free(&s);
}

TEST(kinematics_are_those_of_the_deformed_robot)
{
    for_every_flexible_robot(kinematics);
    print_message("  worst %.2g\n", worst_kinematics);
}

/* ---- a long chain ---- */

/* 32 bodies with 4 modes each, 128 in the long form; errors grow with the condition of M. */
TEST(long_chain)
{
    flexible_robot f;
    flexible_open_chain(&f, test_extent(32, 128), 1, true);
    forward_dynamics(&f);
    flexible_close(&f);
    print_worst(forward_ways, WAYS(forward_ways));
}
