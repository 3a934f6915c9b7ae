/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Galilei: a linear velocity V of a root body, of the floating base or on a floating joint of the
 * world, changes no acceleration of a joint and no force; its own linear acceleration, the
 * derivative of components in axes that turn with w, is less by w x V. Every answer at V is held
 * against that at rest, for every method, number type and way through the library.
 *
 * w and V have few bits: w x V is exact, and the data of both requests are the same ones.
 * Errors are relative to the answer at rest, where the frame adds something to the sum of both.
 */
#include "support/fixture.h"
#include "test.h"

#define STATES 5 /* the first does not turn */
#define ROOTS 16
#define FREEDOMS 512

static const double speeds[] = {250, 8000, 1e5}; /* m/s: an aircraft, an orbit, a comet */
#define SPEEDS (sizeof speeds / sizeof *speeds)

enum { F64, F32, F128, F32_F64, F64_F128, PRECISIONS };
static const double bounds[PRECISIONS] = {1e-15, 5e-7, 1e-15, 1e-15, 1e-15};

/* A robot with its states: x[0] at rest, x[1] at speed; v: base first, then the joints */
struct galilei {
    test_robot *robot;
    random_states *states;
    tfa_workspace *w[PRECISIONS];
    uint32_t root[ROOTS], roots, six; /* first freedom of each root body, base first */
    double *twist[2], *v[2];
    double V[STATES][ROOTS][3], rate[STATES][ROOTS][3]; /* w x V */
    size_t speed;
};

/* ---- robots and states ---- */

static bool hangs_on_world(const tfa_description *d, uint32_t joint)
{
    uint32_t link = d->joints[joint].parent;
    for (size_t steps = 0; steps <= d->joint_count; steps++)
        for (size_t j = 0; j < d->joint_count; j++)
            if (d->joints[j].child == link) {
                if (d->joints[j].type != TFA_JOINT_FIXED)
                    return false;
                link = d->joints[j].parent;
            }
    return true;
}

static void find_roots(struct galilei *g)
{
    const test_robot *robot = g->robot;
    g->six = robot->n - robot->nv;
    if (g->six)
        g->root[g->roots++] = 0;
    for (uint32_t k = 0, within; !g->six && k < robot->nv && g->roots < ROOTS; k++) {
        const uint32_t j = oracle_joint_of_freedom(robot->o, k, &within);
        const tfa_joint *joint = &robot->description->joints[j];
        if (within == 0 && joint->type == TFA_JOINT_FLOATING && joint->armature == 0 &&
            hangs_on_world(robot->description, j))
            g->root[g->roots++] = k;
    }
}

/* Six freedoms of root t of state k in two arrays */
static double *six_of(const struct galilei *g, double *base, double *joints, uint32_t k, uint32_t t)
{
    return g->six ? base + 6 * (size_t)k : joints + (size_t)g->robot->nv * k + g->root[t];
}

static void cross(const double *a, const double *b, double out[3])
{
    for (int e = 0; e < 3; e++)
        out[e] = a[(e + 1) % 3] * b[(e + 2) % 3] - a[(e + 2) % 3] * b[(e + 1) % 3];
}

/* Multiples of 1/64: products of two are exact, in float each of them. */
static void coarse_vector(random_source *s, double reach, double out[3])
{
    for (int e = 0; e < 3; e++)
        out[e] = round(random_uniform(s, -reach, reach) * 64) / 64;
}

static void set_speed(struct galilei *g, size_t speed)
{
    random_source s = {g->robot->seed + speed};
    const size_t nv = (size_t)STATES * g->robot->nv;
    g->speed = speed;
    for (int side = 0; side < 2; side++) {
        memcpy(g->twist[side], g->states->base_twist, 6 * STATES * sizeof(double));
        memcpy(g->v[side], g->states->v, nv * sizeof(double));
    }
    for (uint32_t k = 0; k < STATES; k++)
        for (uint32_t t = 0; t < g->roots; t++) {
            double w[3];
            coarse_vector(&s, k ? 4 : 0, w);
            coarse_vector(&s, speeds[speed], g->V[k][t]);
            cross(w, g->V[k][t], g->rate[k][t]);
            for (int side = 0; side < 2; side++) {
                double *x = six_of(g, g->twist[side], g->v[side], k, t);
                for (int e = 0; e < 3; e++) {
                    x[e] = side ? g->V[k][t][e] : 0;
                    x[3 + e] = w[e];
                }
            }
        }
}

static tfa_request request(const struct galilei *g, tfa_op op, int side)
{
    tfa_request r = fixture_request(g->robot, g->states);
    r.op = op;
    r.v = g->v[side];
    r.base_twist = g->six ? g->twist[side] : NULL;
    return r;
}

/* ---- comparison ---- */

static double worst[PRECISIONS][SPEEDS];

/* Fails unless y = x - rate at the roots, and x elsewhere; vectors of n freedoms, base first. */
static void compare(const struct galilei *g, const char *what, int precision, uint32_t k,
                    const double *x, const double *y, uint32_t n)
{
    double joints = 0, size = norm2(x, n);
    for (uint32_t j = 0; j < n; j++) {
        uint32_t t = 0;
        while (t < g->roots && !(j >= g->root[t] && j < g->root[t] + 3))
            t++;
        const double rate = t < g->roots ? g->rate[k][t][j - g->root[t]] : 0;
        const double sum = size + (t < g->roots ? norm2(g->rate[k][t], 3) : 0);
        joints = fmax(joints, sum > 0 ? fabs(y[j] - (x[j] - rate)) / sum : fabs(y[j]));
    }
    assert_within(g->robot, what, joints, bounds[precision], &worst[precision][g->speed]);
}

static void join(const struct galilei *g, const double *base, const double *joints, uint32_t k,
                 double *out)
{
    memcpy(out, base + 6 * (size_t)k, g->six * sizeof *out);
    memcpy(out + g->six, joints + (size_t)g->robot->nv * k, g->robot->nv * sizeof *out);
}

/* |y - x| <= bound (|x| + size) */
static void same(const struct galilei *g, const char *what, const double *x, const double *y,
                 size_t n, double size, double bound)
{
    double difference = 0;
    for (size_t e = 0; e < n; e++)
        difference = fmax(difference, fabs(y[e] - x[e]));
    assert_within(g->robot, what, difference, bound * (norm2(x, n) + size), NULL);
}

/* ---- forward dynamics, by every way ---- */

static const struct way {
    int precision;
    tfa_method method;
    tfa_estimate estimate;
} ways[] = {
    {F64, TFA_METHOD_AUTO, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_ABA, TFA_ESTIMATE_ALWAYS},
    {F64, TFA_METHOD_CRBA, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_CRBA, TFA_ESTIMATE_ALWAYS},
    {F64, TFA_METHOD_TFA, TFA_ESTIMATE_NEVER},
    {F64, TFA_METHOD_TFA, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_TFA_CR, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_CFA, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_CFA_CR, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_DCA, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_HESSENBERG, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_SCAN, TFA_ESTIMATE_DEFAULT},
    {F64, TFA_METHOD_SCAN_TWO_PASS, TFA_ESTIMATE_ALWAYS},
    {F32, TFA_METHOD_ABA, TFA_ESTIMATE_DEFAULT},
    {F32, TFA_METHOD_CRBA, TFA_ESTIMATE_DEFAULT},
    {F128, TFA_METHOD_ABA, TFA_ESTIMATE_DEFAULT},
    {F128, TFA_METHOD_TFA, TFA_ESTIMATE_DEFAULT},
    {F32_F64, TFA_METHOD_ABA, TFA_ESTIMATE_DEFAULT},
    {F32_F64, TFA_METHOD_TFA, TFA_ESTIMATE_DEFAULT},
    {F64_F128, TFA_METHOD_CRBA, TFA_ESTIMATE_DEFAULT},
};

static void forward_dynamics(struct galilei *g)
{
    double *qdd[2], base[2][6 * STATES], all[2][FREEDOMS];
    for (int side = 0; side < 2; side++)
        qdd[side] = calloc((size_t)STATES * g->robot->nv + 1, sizeof(double));
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++)
        for (uint32_t count = 1; count <= STATES; count += STATES - 1) {
            if (fixture_refuses(g->robot, ways[w].method))
                continue;
            for (int side = 0; side < 2; side++) {
                tfa_request r = request(g, TFA_OP_FORWARD_DYNAMICS, side);
                tfa_reply reply = {.qdd = qdd[side], .base_acceleration = base[side]};
                r.method = ways[w].method;
                r.estimate = ways[w].estimate;
                r.count = count;
                compute_ok(g->robot, g->w[ways[w].precision], &r, &reply);
            }
            for (uint32_t k = 0; k < count; k++) {
                for (int side = 0; side < 2; side++)
                    join(g, base[side], qdd[side], k, all[side]);
                compare(g, tfa_method_name(ways[w].method), ways[w].precision, k, all[0], all[1],
                        g->robot->n);
            }
        }
    free(qdd[1]);
    free(qdd[0]);
}

/* ---- inverse dynamics, bias ---- */

/* Accelerations at rest, and those of the same motion at speed */
static void accelerate(const struct galilei *g, double *qdd[2], double acceleration[2][6 * STATES])
{
    const size_t nv = (size_t)STATES * g->robot->nv;
    for (int side = 0; side < 2; side++) {
        qdd[side] = calloc(nv + 1, sizeof(double));
        for (size_t e = 0; e < nv; e++)
            qdd[side][e] = ldexp(round(ldexp(g->states->qdd[e], 20)), -20);
        for (size_t e = 0; e < 6 * STATES; e++)
            acceleration[side][e] = ldexp(round(ldexp(g->states->base_acceleration[e], 20)), -20);
    }
    for (uint32_t k = 0; k < STATES; k++)
        for (uint32_t t = 0; t < g->roots; t++)
            for (int e = 0; e < 3; e++)
                six_of(g, acceleration[1], qdd[1], k, t)[e] -= g->rate[k][t][e];
}

/* Forces of both are the same. */
static void inverse_dynamics(struct galilei *g)
{
    const size_t nv = (size_t)STATES * g->robot->nv;
    double *qdd[2], *tau[2], acceleration[2][6 * STATES], wrench[2][6 * STATES];
    accelerate(g, qdd, acceleration);
    for (int side = 0; side < 2; side++)
        tau[side] = calloc(nv + 1, sizeof(double));
    for (int precision = 0; precision <= F128; precision++) {
        for (int side = 0; side < 2; side++) {
            tfa_request r = request(g, TFA_OP_INVERSE_DYNAMICS, side);
            tfa_reply reply = {.tau = tau[side], .base_wrench = wrench[side]};
            r.qdd = qdd[side];
            r.base_acceleration = g->six ? acceleration[side] : NULL;
            compute_ok(g->robot, g->w[precision], &r, &reply);
        }
        if (precision == F32) /* whose qdd - w x V are rounded */
            continue;
        same(g, "inverse dynamics", tau[0], tau[1], nv, g->six ? norm2(wrench[0], 6 * STATES) : 0,
             bounds[precision]);
        same(g, "base wrench", wrench[0], wrench[1], g->six ? 6 * STATES : 0, 0, bounds[precision]);
    }
    for (int side = 0; side < 2; side++) {
        free(tau[side]);
        free(qdd[side]);
    }
}

/* h is larger by M times w x V. */
static void bias(struct galilei *g)
{
    const size_t n = g->robot->n;
    double *h[2] = {calloc(n * STATES, sizeof(double)), calloc(n * STATES, sizeof(double))};
    double *M = calloc(n * n * STATES, sizeof *M);
    tfa_request r = request(g, TFA_OP_MASS_MATRIX, 0);
    compute_ok(g->robot, g->robot->f64, &r, &(tfa_reply){.mass_matrix = M});
    for (int side = 0; side < 2; side++) {
        r = request(g, TFA_OP_BIAS, side);
        compute_ok(g->robot, g->robot->f64, &r, &(tfa_reply){.velocity_force = h[side]});
    }
    for (size_t k = 0; k < STATES; k++) {
        double most = 0;
        for (size_t i = 0; i < n; i++)
            for (uint32_t t = 0; t < g->roots; t++)
                for (size_t e = 0; e < 3; e++) {
                    const double more = M[n * (n * k + i) + g->root[t] + e] * g->rate[k][t][e];
                    h[0][n * k + i] += more;
                    most = fmax(most, fabs(more));
                }
        same(g, "bias", h[0] + n * k, h[1] + n * k, n, 10 * most, 1e-15);
    }
    free(M);
    free(h[1]);
    free(h[0]);
}

/* ---- kinematics ---- */

struct motion {
    double twist[6 * STATES], bias[6 * STATES], momentum[6 * STATES], energy[2 * STATES],
        com_velocity[3 * STATES], mass[STATES], *J;
};

static void ask_motion(const struct galilei *g, tfa_reference_frame frame, int side,
                       struct motion *m)
{
    tfa_request r = request(g, TFA_OP_KINEMATICS, side);
    tfa_reply reply = {.twists = m->twist,
                       .bias_acceleration = m->bias,
                       .momentum = m->momentum,
                       .energy = m->energy,
                       .com_velocity = m->com_velocity,
                       .mass = m->mass,
                       .jacobian = m->J};
    r.flags = TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_MOMENTUM |
              TFA_WANT_ENERGY | TFA_WANT_COM;
    r.frame = frame;
    r.tip_count = 1;
    r.tips[0] = g->robot->description->joints[g->robot->description->joint_count - 1].child;
    compute_ok(g->robot, g->robot->f64, &r, &reply);
}

/* A point's acceleration is J (w x V) more; of a spatial one the frame passes by, - w_tip x V. */
static void tip_moves(const struct galilei *g, tfa_reference_frame frame, size_t k,
                      struct motion m[2])
{
    double V[3], passing[3], size = 0, *x = m[0].bias + 6 * k;
    for (size_t e = 0; e < 3; e++)
        V[e] = m[1].twist[6 * k + e] - m[0].twist[6 * k + e];
    cross(m[0].twist + 6 * k + 3, V, passing);
    same(g, "w of a tip", m[0].twist + 6 * k + 3, m[1].twist + 6 * k + 3, 3, 0, 0);
    for (size_t e = 0; e < 6; e++) {
        const double *row = m[0].J + (6 * k + e) * g->robot->n;
        for (uint32_t t = 0; t < g->roots; t++)
            for (size_t d = 0; d < 3; d++) {
                x[e] += row[g->root[t] + d] * g->rate[k][t][d];
                size = fmax(size, fabs(g->rate[k][t][d]));
            }
        if (frame != TFA_FRAME_LOCAL_WORLD_ALIGNED && e < 3)
            x[e] -= passing[e];
    }
    if (frame != TFA_FRAME_LOCAL_WORLD_ALIGNED)
        size += norm2(V, 3) * norm2(m[0].twist + 6 * k + 3, 3);
    same(g, "J-dot v", x, m[1].bias + 6 * k, 6, 3 * size, 1e-15);
}

/* Of a floating base: everything moves with V = com_velocity less that at rest. */
static void whole_moves(const struct galilei *g, size_t k, struct motion m[2])
{
    const double mass = m[0].mass[k];
    double V[3], T = m[0].energy[2 * k], size;
    for (size_t e = 0; e < 3; e++) {
        V[e] = m[1].com_velocity[3 * k + e] - m[0].com_velocity[3 * k + e];
        T += (m[0].momentum[6 * k + e] + mass * V[e] / 2) * V[e];
        m[0].momentum[6 * k + e] += mass * V[e];
    }
    size = mass * norm2(V, 3);
    assert_within(g->robot, "V", fabs(norm2(V, 3) / norm2(g->V[k][0], 3) - 1), 1e-14, NULL);
    same(g, "momentum", m[0].momentum + 6 * k, m[1].momentum + 6 * k, 6, 10 * size, 1e-14);
    same(g, "energy", &T, m[1].energy + 2 * k, 1, 0, 1e-13);
    same(g, "potential energy", m[0].energy + 2 * k + 1, m[1].energy + 2 * k + 1, 1, 0, 0);
}

static void kinematics(struct galilei *g)
{
    struct motion m[2];
    for (int side = 0; side < 2; side++)
        m[side].J = calloc((size_t)6 * STATES * g->robot->n, sizeof(double));
    for (int frame = 0; frame < 3; frame++) {
        for (int side = 0; side < 2; side++)
            ask_motion(g, (tfa_reference_frame)frame, side, &m[side]);
        for (size_t k = 0; k < STATES; k++) {
            tip_moves(g, (tfa_reference_frame)frame, k, m);
            if (g->six)
                whole_moves(g, k, m);
        }
    }
    free(m[1].J);
    free(m[0].J);
}

/* ---- derivatives ---- */

/* - w x V by w */
static void add_derivative(const struct galilei *g, size_t k, double *D)
{
    const size_t n = g->robot->n;
    for (uint32_t t = 0; t < g->roots; t++)
        for (size_t e = 0; e < 3; e++) {
            double *row = D + n * (g->root[t] + e) + g->root[t] + 3;
            row[(e + 1) % 3] -= g->V[k][t][(e + 2) % 3];
            row[(e + 2) % 3] += g->V[k][t][(e + 1) % 3];
        }
}

static void derivatives(struct galilei *g)
{
    const size_t n = g->robot->n, all = n * n;
    double *by_q[2], *by_v[2];
    for (int side = 0; side < 2; side++) {
        by_q[side] = calloc(all * STATES, sizeof(double));
        by_v[side] = calloc(all * STATES, sizeof(double));
        tfa_request r = request(g, TFA_OP_DERIVATIVES, side);
        compute_ok(g->robot, g->robot->f64, &r,
                   &(tfa_reply){.dqdd_dq = by_q[side], .dqdd_dv = by_v[side]});
    }
    for (size_t k = 0; k < STATES; k++) {
        add_derivative(g, k, by_v[0] + all * k);
        same(g, "dqdd_dq", by_q[0] + all * k, by_q[1] + all * k, all, 0, 1e-15);
        same(g, "dqdd_dv", by_v[0] + all * k, by_v[1] + all * k, all, 0, 1e-15);
    }
    for (int side = 0; side < 2; side++) {
        free(by_v[side]);
        free(by_q[side]);
    }
}

/* By w they differ by that of M times w x V. */
static void inverse_derivatives(struct galilei *g)
{
    const size_t n = g->robot->n, all = n * n;
    double *qdd[2], acceleration[2][6 * STATES], *by_q[2], *by_v[2];
    double *M = calloc(all * STATES, sizeof *M), *rate = calloc(all, sizeof *rate);
    accelerate(g, qdd, acceleration);
    for (int side = 0; side < 2; side++) {
        by_q[side] = calloc(all * STATES, sizeof(double));
        by_v[side] = calloc(all * STATES, sizeof(double));
        tfa_request r = request(g, TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, side);
        r.qdd = qdd[side];
        r.base_acceleration = g->six ? acceleration[side] : NULL;
        compute_ok(g->robot, g->robot->f64, &r,
                   &(tfa_reply){.dtau_dq = by_q[side], .dtau_dv = by_v[side]});
    }
    tfa_request r = request(g, TFA_OP_MASS_MATRIX, 0);
    compute_ok(g->robot, g->robot->f64, &r, &(tfa_reply){.mass_matrix = M});
    for (size_t k = 0; k < STATES; k++) {
        memset(rate, 0, all * sizeof *rate);
        add_derivative(g, k, rate);
        for (size_t e = 0; e < all; e++)
            for (size_t l = 0; l < n; l++)
                by_v[0][all * k + e] -= M[all * k + e / n * n + l] * rate[n * l + e % n];
        same(g, "dtau_dq", by_q[0] + all * k, by_q[1] + all * k, all, 0, 1e-15);
        same(g, "dtau_dv", by_v[0] + all * k, by_v[1] + all * k, all, 0, 1e-15);
    }
    for (int side = 0; side < 2; side++) {
        free(by_v[side]);
        free(by_q[side]);
        free(qdd[side]);
    }
    free(rate);
    free(M);
}

/* ---- operational space, of a point ---- */

static void task(struct galilei *g)
{
    const size_t nv = (size_t)STATES * g->robot->nv;
    static const double desired[3 * STATES] = {1, -2, 3, 0, 4, 1, -1};
    double *tau[2], wrench[2][6 * STATES], mu[2][3 * STATES], lambda[9 * STATES];
    for (int side = 0; side < 2; side++) {
        tau[side] = calloc(nv + 1, sizeof(double));
        tfa_request r = request(g, TFA_OP_TASK_TORQUES, side);
        tfa_reply reply = {
            .tau = tau[side], .base_wrench = wrench[side], .mu = mu[side], .lambda = lambda};
        r.tip_count = 1;
        r.tips[0] = g->robot->description->joints[g->robot->description->joint_count - 1].child;
        r.rows = TFA_ROWS_POINT;
        r.flags = TFA_WANT_MU | TFA_WANT_LAMBDA;
        r.task_acceleration = desired;
        compute_ok(g->robot, g->robot->f64, &r, &reply);
    }
    same(g, "task torques", tau[0], tau[1], nv, 0, 1e-15);
    same(g, "task base wrench", wrench[0], wrench[1], g->six ? 6 * STATES : 0, 0, 1e-15);
    same(g, "mu", mu[0], mu[1], 3 * STATES, 0, 1e-15);
    free(tau[1]);
    free(tau[0]);
}

/* ---- the law ---- */

static uint32_t robots, trees;

static void galilei(test_robot *robot)
{
    struct galilei g = {.robot = robot, .states = fixture_states(robot, 0, STATES, 2)};
    find_roots(&g);
    if (g.roots == 0 || robot->n > FREEDOMS) {
        random_states_free(g.states);
        return;
    }
    for (int side = 0; side < 2; side++) {
        g.v[side] = calloc((size_t)STATES * robot->nv + 1, sizeof(double));
        g.twist[side] = calloc(6 * STATES, sizeof(double));
    }
    g.w[F64] = robot->f64;
    g.w[F32] = robot->f32;
    g.w[F128] = robot->f128;
    g.w[F32_F64] = fixture_mixed(robot->model, TFA_F32, TFA_RESIDUAL_F64);
    g.w[F64_F128] = fixture_mixed(robot->model, TFA_F64, TFA_RESIDUAL_F128);
    for (size_t speed = 0; speed < SPEEDS; speed++) {
        set_speed(&g, speed);
        forward_dynamics(&g);
        inverse_dynamics(&g);
        bias(&g);
        kinematics(&g);
        derivatives(&g);
        inverse_derivatives(&g);
        task(&g);
    }
    robots++;
    trees += g.roots;
    tfa_workspace_free(g.w[F64_F128]);
    tfa_workspace_free(g.w[F32_F64]);
    for (int side = 0; side < 2; side++) {
        free(g.twist[side]);
        free(g.v[side]);
    }
    random_states_free(g.states);
}

TEST(a_uniform_velocity_changes_nothing)
{
    static const char *const names[PRECISIONS] = {"f64", "f32", "f128", "f32 + f64", "f64 + f128"};
    for_every_robot(galilei, false);
    for (uint64_t seed = 1; seed <= test_extent(3, 20); seed++) {
        test_robot robot;
        fixture_open_trees(seed, &robot);
        galilei(&robot);
        fixture_close(&robot);
    }
    print_message("  %u robots, %u trees\n", (unsigned)robots, (unsigned)trees);
    assert_true(trees > robots); /* several on one world among them */
    for (int p = 0; p < PRECISIONS; p++)
        print_message("  %-10s worst %.2g at 250 m/s, %.2g at 8 km/s, %.2g at 100 km/s\n", names[p],
                      worst[p][0], worst[p][1], worst[p][2]);
}
