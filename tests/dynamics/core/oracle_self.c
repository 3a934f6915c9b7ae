/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle against closed forms and laws of mechanics, without the library.
 */
#include "support/oracle.h"
#include "support/random_robot.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

static void assert_close(double got, double want, double bound, const char *what)
{
    if (!(fabs(got - want) <= bound))
        fail_msg("%s: %.17g, expected %.17g within %g", what, got, want, bound);
}

/* Request that points at the states. */
static tfa_request request_of(const random_states *x)
{
    return (tfa_request){.count = x->count,
                         .q = x->q,
                         .v = x->v,
                         .base_pose = x->base_pose,
                         .base_twist = x->base_twist,
                         .gravity = x->gravity};
}

/* Two links that swing about y in the plane x, z; angles from straight down. The textbook's
 * equations: m1 at c1, m2 at c2 of links with length l1, moments of inertia i1, i2. */
TEST(double_pendulum)
{
    const double m1 = 2, m2 = 3, l1 = 0.7, c1 = 0.3, c2 = 0.45, i1 = 0.05, i2 = 0.08, g = 9.81;
    small_robot r;
    small_robot_begin(&r);
    for (uint32_t k = 0; k < 2; k++)
        small_robot_add(&r, k, TFA_JOINT_REVOLUTE, 0, 1, 0)->armature = 0.01 * (k + 1);
    small_robot_load(&r, 1, m1, 0, i1, 0);
    small_robot_load(&r, 2, m2, 0, i2, 0);
    r.link[1].com[2] = -c1;
    r.link[2].com[2] = -c2;
    r.joint[1].xyz[2] = -l1;
    oracle *o = oracle_create(&r.d, TFA_BASE_FIXED);
    assert_non_null(o);

    const double q[2] = {0.6, -1.1}, v[2] = {1.3, 0.4}, gravity[3] = {0, 0, -g};
    double c = cos(q[1]), s = sin(q[1]), M[4], h[2];
    double coupling = m2 * l1 * c2, own = i2 + m2 * c2 * c2;
    double want_M[4] = {i1 + m1 * c1 * c1 + m2 * l1 * l1 + 2 * coupling * c + own + 0.01,
                        coupling * c + own, coupling * c + own, own + 0.02};
    double fall2 = m2 * g * c2 * sin(q[0] + q[1]);
    double want_h[2] = {-coupling * s * (2 * v[0] * v[1] + v[1] * v[1]) +
                            (m1 * c1 + m2 * l1) * g * sin(q[0]) + fall2,
                        coupling * s * v[0] * v[0] + fall2};
    oracle_set_state(o, &(tfa_request){.q = q, .v = v, .gravity = gravity}, 0);
    oracle_mass_matrix(o, M);
    oracle_inverse(o, NULL, NULL, h, NULL);
    for (int k = 0; k < 4; k++)
        assert_close(M[k], want_M[k], 1e-14, "M");
    for (int k = 0; k < 2; k++)
        assert_close(h[k], want_h[k], 1e-14, "h");
    oracle_free(o);
}

static tfa_description *robot(uint64_t seed, uint32_t joints, bool all_types)
{
    random_robot_options options = {.shape = (random_shape)(seed % 3),
                                    .joints = joints,
                                    .all_types = all_types,
                                    .fixed_fraction = 0.3,
                                    .armature_chance = 0.3,
                                    .shuffled = seed % 2 == 1};
    return random_robot_create(seed, &options);
}

/* tau = M qdd + h returns the tau that forward dynamics was given; M is symmetric. */
TEST(solves_its_own_equations)
{
    for (uint64_t seed = 1; seed <= 12; seed++) {
        tfa_description *d = robot(seed, 9, true);
        oracle *o = oracle_create(d, seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
        assert_non_null(o);
        random_states *x = random_states_create(seed, d, o, 1, 2);
        tfa_request r = request_of(x);
        r.wrench_count = 2;
        r.wrench_frames[0] = x->wrench_links[0];
        r.wrench_frames[1] = x->wrench_links[1];
        r.wrenches = x->wrenches;
        uint32_t n = oracle_freedoms(o), nv = oracle_v_count(o);
        double *qdd = calloc(nv, sizeof *qdd), *tau = calloc(nv, sizeof *tau);
        double *M = calloc((size_t)n * n, sizeof *M), base[6] = {0}, wrench[6];
        oracle_set_state(o, &r, 0);
        oracle_forward(o, x->tau, x->base_wrench, qdd, base);
        oracle_inverse(o, qdd, base, tau, wrench);
        for (uint32_t k = 0; k < nv; k++)
            assert_close(tau[k], x->tau[k], 1e-9, "tau"); /* qdd was rounded to double */
        for (uint32_t k = 0; k < n - nv; k++)
            assert_close(wrench[k], x->base_wrench[k], 1e-9, "base_wrench");
        oracle_mass_matrix(o, M);
        for (uint32_t i = 0; i < n * n; i++)
            assert_close(M[i], M[i % n * n + i / n], 1e-15 * (1 + fabs(M[i])), "symmetry");
        free(M);
        free(tau);
        free(qdd);
        random_states_free(x);
        oracle_free(o);
        random_robot_free(d);
    }
}

static double energy(oracle *o, const random_states *x)
{
    tfa_request r = request_of(x);
    double kinetic, potential;
    oracle_set_state(o, &r, 0);
    oracle_energy(o, &kinetic, &potential);
    return kinetic + potential;
}

/* d/dt (kinetic + potential) = tau . v, by a central difference along the motion. */
TEST(work_becomes_energy)
{
    const double dt = 1e-5;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        tfa_description *d = robot(seed, 7, true);
        oracle *o = oracle_create(d, seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
        random_states *x = random_states_create(seed, d, o, 1, 0);
        random_states *y = random_states_create(seed, d, o, 1, 0);
        uint32_t nv = oracle_v_count(o);
        double *qdd = calloc(nv, sizeof *qdd), base[6] = {0}, power = 0, e[2];
        tfa_request r = request_of(x);
        oracle_set_state(o, &r, 0);
        oracle_forward(o, x->tau, x->base_wrench, qdd, base);
        for (int side = 0; side < 2; side++) {
            step_state(d, o, x, qdd, base, side ? dt : -dt, y);
            e[side] = energy(o, y);
        }
        for (uint32_t k = 0; k < nv; k++)
            power += x->tau[k] * x->v[k];
        for (uint32_t k = 0; k < oracle_freedoms(o) - nv; k++)
            power += x->base_wrench[k] * x->base_twist[k];
        assert_close((e[1] - e[0]) / (2 * dt), power, 1e-4 * (1 + fabs(power)), "power");
        free(qdd);
        random_states_free(y);
        random_states_free(x);
        oracle_free(o);
        random_robot_free(d);
    }
}

/* Without gravity h_k = sum_ij (dM_kj/dq_i - dM_ij/dq_k / 2) v_i v_j where v = dq/dt: Lagrange's
 * route to the velocity products, which needs nothing but M. */
TEST(bias_is_lagranges)
{
    const double dt = 1e-5;
    enum { N = 6 };
    for (uint64_t seed = 1; seed <= 12; seed++) {
        tfa_description *d = robot(seed, N, false);
        for (size_t j = 0; j < d->joint_count; j++)
            if (d->joints[j].type == TFA_JOINT_REVOLUTE && j % 3 == 0)
                d->joints[j].type = TFA_JOINT_PRISMATIC;
        oracle *o = oracle_create(d, TFA_BASE_FIXED);
        random_states *x = random_states_create(seed, d, o, 1, 0);
        double h[N], want[N] = {0}, M[2][N * N], q[N];
        tfa_request r = request_of(x);
        r.gravity = (const double[3]){0, 0, 0};
        oracle_set_state(o, &r, 0);
        oracle_inverse(o, NULL, NULL, h, NULL);
        r.q = q;
        for (int i = 0; i < N; i++) {
            for (int side = 0; side < 2; side++) {
                for (int k = 0; k < N; k++)
                    q[k] = x->q[k] + (k == i ? (side ? dt : -dt) : 0);
                oracle_set_state(o, &r, 0);
                oracle_mass_matrix(o, M[side]);
            }
            for (int k = 0; k < N * N; k++) {
                double slope = (M[1][k] - M[0][k]) / (2 * dt);
                want[k / N] += slope * x->v[i] * x->v[k % N];
                want[i] -= slope * x->v[k / N] * x->v[k % N] / 2;
            }
        }
        for (int k = 0; k < N; k++)
            assert_close(h[k], want[k], 1e-6 * (1 + fabs(want[k])), "h");
        random_states_free(x);
        oracle_free(o);
        random_robot_free(d);
    }
}

/* Momentum of all links, linear first, about the world's origin and in its axes. The base's rows
 * of M v are the momentum about the root link's origin, in its axes. */
static void momentum(oracle *o, const random_states *x, uint32_t root, double p[6])
{
    const uint32_t n = oracle_freedoms(o);
    double *M = calloc((size_t)n * n, sizeof *M), local[6] = {0}, at[3], R[9];
    tfa_request r = request_of(x);
    oracle_set_state(o, &r, 0);
    oracle_mass_matrix(o, M);
    for (uint32_t i = 0; i < 6; i++)
        for (uint32_t k = 0; k < n; k++)
            local[i] += M[i * n + k] * (k < 6 ? x->base_twist[k] : x->v[k - 6]);
    oracle_pose(o, root, at, R);
    for (int i = 0; i < 6; i++) {
        const double *row = R + 3 * (i % 3), *in = local + i / 3 * 3;
        p[i] = row[0] * in[0] + row[1] * in[1] + row[2] * in[2];
    }
    for (int i = 0; i < 3; i++) {
        int b = (i + 1) % 3, c = (i + 2) % 3;
        p[3 + i] += at[b] * p[c] - at[c] * p[b];
    }
    free(M);
}

/* A free robot without gravity and outer forces keeps its momentum although its joints push. */
TEST(free_robot_keeps_momentum)
{
    const double dt = 1e-5, zero[3] = {0, 0, 0};
    for (uint64_t seed = 1; seed <= 8; seed++) {
        tfa_description *d = robot(seed, 6, true);
        for (size_t j = 0; j < d->joint_count; j++)
            d->joints[j].armature = 0; /* rotors have no momentum in this model */
        oracle *o = oracle_create(d, TFA_BASE_FLOATING);
        random_states *x = random_states_create(seed, d, o, 1, 0);
        random_states *y = random_states_create(seed, d, o, 1, 0);
        double *qdd = calloc(oracle_v_count(o), sizeof *qdd), base[6], p[2][6];
        tfa_request r = request_of(x);
        r.gravity = zero;
        oracle_set_state(o, &r, 0);
        oracle_forward(o, x->tau, NULL, qdd, base);
        for (int side = 0; side < 2; side++) {
            step_state(d, o, x, qdd, base, side ? dt : -dt, y);
            momentum(o, y, description_root(d), p[side]);
        }
        for (int i = 0; i < 6; i++)
            assert_close((p[1][i] - p[0][i]) / (2 * dt), 0, 1e-5, "momentum");
        free(qdd);
        random_states_free(y);
        random_states_free(x);
        oracle_free(o);
        random_robot_free(d);
    }
}
