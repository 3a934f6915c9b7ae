/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Six-axis arms beside the singularities of wrist, elbow and shoulder: Lambda and p err by a few
 * roundings times the condition of B, at any distance, and say so; torques of a task are continuous
 * and bounded along paths through the singularity; and neither the unit of length nor the frame of
 * the tip changes them.
 */
#include "models.h"
#include "spectral.h"
#include "support/small_robot.h"
#include "test.h"

#include <float.h>

#define ARMS 20
#define JOINTS 6
#define TOOL (JOINTS + 1)

enum { SHOULDER, ELBOW = 2, WRIST = 4 }; /* joint whose angle is the distance */

struct arm {
    small_robot robot;
    tfa_model *model;
    tfa_workspace *w;
};

/* Axes z y y x y x; with the elbow at 0 upper and lower arm are in line, with the fifth joint at 0
 * axes 4 and 6 are. `unit`: lengths are in so many metres. */
static void describe(struct arm *a, uint64_t seed, double unit)
{
    static const double axes[JOINTS][3] = {{0, 0, 1}, {0, 1, 0}, {0, 1, 0},
                                           {1, 0, 0}, {0, 1, 0}, {1, 0, 0}};
    random_source s = {seed};
    small_robot_begin(&a->robot);
    for (uint32_t k = 0; k <= JOINTS; k++) {
        const double *axis = axes[k < JOINTS ? k : 0];
        tfa_joint *j =
            small_robot_add(&a->robot, k, k < JOINTS ? TFA_JOINT_CONTINUOUS : TFA_JOINT_FIXED,
                            axis[0], axis[1], axis[2]);
        const double along = k == 0 ? 0 : k == JOINTS ? 0.1 : random_uniform(&s, 0.2, 0.5);
        if (k != 4 && k != 5) /* a spherical wrist */
            j->xyz[0] = (k == 1 ? 0.1 : along) / unit;
    }
    for (uint32_t k = 0; k < JOINTS + 2; k++) {
        const double mass = random_uniform(&s, 0.5, 8) / (1 + k), size = 0.05 / unit;
        const double I = mass * size * size;
        small_robot_load(&a->robot, k, mass, I * random_uniform(&s, 1, 1.4),
                         I * random_uniform(&s, 1, 1.4), I * random_uniform(&s, 1, 1.4));
        for (int e = 0; e < 3; e++)
            a->robot.link[k].com[e] = random_uniform(&s, -0.05, 0.05) / unit;
    }
    a->model = compiled(&a->robot.d, NULL);
    a->w = workspace_for(a->model, NULL);
}

static void release(struct arm *a)
{
    tfa_workspace_free(a->w);
    tfa_model_free(a->model);
}

/* Away from all singularities but that one, from which it is x away */
static void pose(uint64_t seed, int singularity, double x, double q[JOINTS])
{
    static const double away[JOINTS] = {0.2, -0.7, 1.1, 0.35, 0.9, -0.15};
    random_source s = {seed + 100};
    for (int k = 0; k < JOINTS; k++)
        q[k] = away[k] + random_uniform(&s, -0.1, 0.1);
    q[singularity] = x;
}

/* ---- accuracy ---- */

struct worst {
    double lambda, in_roundings, p, condition, inverted; /* inverted: of lambda_inv's inverse */
};

/* A <- A^-1 of a symmetric 6 x 6 A by Gauss and Jordan, in double */
static void invert(double *A)
{
    for (int k = 0; k < 6; k++) {
        const double pivot = A[7 * k];
        A[7 * k] = 1;
        for (int j = 0; j < 6; j++)
            A[6 * k + j] /= pivot;
        for (int i = 0; i < 6; i++) {
            const double factor = A[6 * i + k];
            if (i == k)
                continue;
            A[6 * i + k] = 0;
            for (int j = 0; j < 6; j++)
                A[6 * i + j] -= factor * A[6 * k + j];
        }
    }
}

static void check_distance(struct arm *a, oracle *o, const double *q, struct worst *worst)
{
    static spectral s;
    double lambda[36], lambda_inv[36], p[6];
    quad J[36], A[36], h[6], x[6];
    tfa_rank rank;
    tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA,
                     .flags = TFA_WANT_LAMBDA | TFA_WANT_P,
                     .estimate = TFA_ESTIMATE_ALWAYS,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .tip_count = 1,
                     .tips = {TOOL},
                     .q = q};
    tfa_reply reply = {.lambda = lambda, .lambda_inv = lambda_inv, .p = p, .rank = &rank};
    const oracle_tips tips = {r.tips, 1, 6, r.frame};
    assert_int_equal(tfa_compute(a->w, &r, &reply), TFA_OK);
    const spectral_metric metric = {.tips = 1, .rows = 6, .length = rank.length};
    oracle_set_state(o, &r, 0);
    oracle_jacobian(o, &tips, J);
    for (int i = 18; i < 36; i++)
        J[i] *= (quad)rank.length;
    oracle_inverse_of_rows(o, J, 6, A);
    spectral_of(&s, A, 6, TFA_RANK_TRUNCATE, TFA_RANK_THRESHOLD(6));
    assert_int_equal(rank.rank, 6);
    assert_int_equal(s.rank, 6);
    oracle_bias_force(o, h);
    oracle_accelerate(o, h);
    for (int i = 0; i < 6; i++) {
        x[i] = 0;
        for (int j = 0; j < 6; j++)
            x[i] += J[6 * i + j] * h[j];
    }
    const double relative = spectral_error(&s, &metric, lambda), root = sqrt((double)s.condition);
    double size;
    const double of_p = spectral_product_error(&s, &metric, x, p, &size) / size;
    assert_true(rank.error_estimate >= relative / 30 && rank.error_estimate >= of_p / 30);
    invert(lambda_inv);
    worst->inverted = fmax(worst->inverted, spectral_error(&s, &metric, lambda_inv));
    worst->lambda = fmax(worst->lambda, relative);
    worst->p = fmax(worst->p, of_p);
    worst->condition = fmax(worst->condition, root);
    worst->in_roundings = fmax(worst->in_roundings, relative / root / DBL_EPSILON);
}

TEST(errors_grow_with_the_condition)
{
    static const double distances[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
    struct worst worst[6] = {{0}};
    for (uint64_t seed = 1; seed <= ARMS; seed++) {
        static struct arm a;
        describe(&a, seed, 1);
        oracle *o = oracle_create(&a.robot.d, TFA_BASE_FIXED);
        for (int k = 0; k < 6; k++) {
            double q[JOINTS];
            pose(seed, WRIST, distances[k], q);
            check_distance(&a, o, q, &worst[k]);
        }
        oracle_free(o);
        release(&a);
    }
    for (int k = 0; k < 6; k++) {
        print_message(
            "  %.0e rad: condition of B %.0e, lambda %.0e (%.2g roundings), p %.0e; inverse "
            "of lambda_inv %.0e\n",
            distances[k], worst[k].condition, worst[k].lambda, worst[k].in_roundings, worst[k].p,
            worst[k].inverted);
        assert_true(worst[k].in_roundings <= 30);
    }
}

/* ---- torques along a path ---- */

static void torques(struct arm *a, const double *q, const double *desired, double *tau,
                    tfa_rank *rank, double *lost)
{
    tfa_request r = {.op = TFA_OP_TASK_TORQUES,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .tip_count = 1,
                     .tips = {TOOL},
                     .q = q,
                     .task_acceleration = desired};
    tfa_answer answer;
    tfa_reply reply = {.tau = tau, .rank = rank, .lost = lost, .answers = &answer};
    assert_int_equal(tfa_compute(a->w, &r, &reply), TFA_OK);
    assert_int_equal((answer.flags & TFA_ANSWER_RANK_LOSS) != 0, rank->lost > 0);
}

static double distance(const double *x, const double *y)
{
    double sum = 0;
    for (int k = 0; k < JOINTS; k++)
        sum += (x[k] - y[k]) * (x[k] - y[k]);
    return sqrt(sum);
}

struct path {
    double peak, width, steepest; /* N m; rad; N m per rad */
};

/* Torques at x = 1e-9 .. 0.3 on either side, and a millionth of a radian further */
static struct path walk(struct arm *a, uint64_t seed, int singularity, const double *desired)
{
    const double zero[JOINTS] = {0}, step = 1e-6;
    struct path path = {.width = 1};
    for (int k = 0; k < 400; k++) {
        const double x = (k % 2 ? 1 : -1) * 1e-9 * pow(3e8, k / 399.0);
        double q[JOINTS], here[JOINTS], there[JOINTS], lost[TFA_LOST_MAX * 8];
        tfa_rank rank;
        pose(seed, singularity, x, q);
        torques(a, q, desired, here, &rank, lost);
        if (rank.lost == 0)
            path.width = fmin(path.width, fabs(x));
        else
            assert_true(lost[0] * lost[0] <= rank.threshold * (1 + 1e-9));
        q[singularity] += step;
        torques(a, q, desired, there, &rank, lost);
        path.peak = fmax(path.peak, distance(here, zero));
        path.steepest = fmax(path.steepest, distance(here, there) / step);
    }
    return path;
}

TEST(torques_are_continuous)
{
    static const double desired[6] = {0.3, -0.2, 1, 0.5, -1, 0.7};
    double steepest = 0, peak = 0;
    uint32_t crossed = 0;
    for (uint64_t seed = 1; seed <= ARMS / 2; seed++)
        for (int singularity = ELBOW; singularity <= WRIST; singularity += 2) {
            static struct arm a;
            describe(&a, seed, 1);
            const struct path path = walk(&a, seed, singularity, desired);
            crossed += path.width > 1e-8;
            if (path.steepest > 4 * path.peak / path.width + 1e-3)
                fail_msg("arm %u, joint %d: %g N m a radian, peak %g, ramp %g", (unsigned)seed,
                         singularity, path.steepest, path.peak, path.width);
            steepest = fmax(steepest, path.steepest * path.width / path.peak);
            peak = fmax(peak, path.peak);
            release(&a);
        }
    print_message("  peak %.3g N m, steepest %.2g peak / ramp, %u ramps\n", peak, steepest,
                  crossed);
    assert_true(crossed >= ARMS / 2 && peak < 2000);
}

/* ---- units and frames ---- */

TEST(units_and_frames_change_nothing)
{
    static const double distances[] = {1, 1e-2, 1e-4, 1e-7};
    static const double gravity[3] = {0, 0, -9.80665}, in_mm[3] = {0, 0, -9806.65};
    double worst = 0;
    for (uint64_t seed = 1; seed <= ARMS; seed++) {
        static struct arm a, b;
        describe(&a, seed, 1);
        describe(&b, seed, 1e-3);
        for (int k = 0; k < 4; k++) {
            static const tfa_reference_frame frames[] = {TFA_FRAME_LOCAL_WORLD_ALIGNED,
                                                         TFA_FRAME_WORLD};
            double q[JOINTS], tau[3][JOINTS], pose7[7], desired[6] = {0.3, -0.2, 1, 0.5, -1, 0.7};
            tfa_rank rank[3];
            pose(seed, WRIST, distances[k], q);
            for (int way = 0; way < 3; way++) { /* aligned, world, aligned in millimetres */
                double x[6];
                memcpy(x, desired, sizeof x);
                for (int e = 0; way == 1 && e < 3; e++) /* of the world's origin, at rest */
                    x[e] += -(desired[3 + (e + 1) % 3] * pose7[(e + 2) % 3] -
                              desired[3 + (e + 2) % 3] * pose7[(e + 1) % 3]);
                for (int e = 0; way == 2 && e < 3; e++)
                    x[e] *= 1000;
                tfa_request r = {.op = TFA_OP_TASK_TORQUES,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .flags = TFA_WANT_POSES,
                                 .count = 1,
                                 .tip_count = 1,
                                 .tips = {TOOL},
                                 .frame = frames[way % 2],
                                 .q = q,
                                 .gravity = way == 2 ? in_mm : gravity,
                                 .task_acceleration = x};
                tfa_reply reply = {.tau = tau[way], .rank = &rank[way], .poses = pose7};
                assert_int_equal(tfa_compute(way == 2 ? b.w : a.w, &r, &reply), TFA_OK);
                for (int j = 0; way == 2 && j < JOINTS; j++)
                    tau[way][j] *= 1e-6; /* kg mm^2 / s^2 */
            }
            const double zero[JOINTS] = {0}, size = distance(tau[0], zero);
            for (int way = 1; way < 3; way++) {
                assert_int_equal(rank[way].rank, rank[0].rank);
                assert_true(fabs(rank[way].threshold / rank[0].threshold - 1) < 1e-12);
                worst = fmax(worst, distance(tau[way], tau[0]) / size);
            }
        }
        release(&b);
        release(&a);
    }
    print_message("  worst %.2g\n", worst);
    assert_true(worst < 1e-10);
}
