/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle's tied freedoms and payloads against other routes to the same: joints made fixed by
 * hand, rotors too heavy to be moved, Lagrange's multipliers, a gear by its formula.
 */
#include "support/oracle.h"
#include "support/quad.h"
#include "support/random_robot.h"
#include "support/small_robot.h"
#include "test.h"

#define MOST 80 /* freedoms */

static double worst;

static void assert_same(uint64_t seed, const char *what, const double *x, const double *y, size_t n)
{
    double difference = 0, size = 0;
    for (size_t k = 0; k < n; k++) {
        difference += (x[k] - y[k]) * (x[k] - y[k]);
        size += y[k] * y[k];
    }
    double error = sqrt(size > 0 ? difference / size : difference);
    worst = fmax(worst, error);
    if (!(error <= 1e-13))
        fail_msg("seed %u, %s: %g", (unsigned)seed, what, error);
}

/* A robot, its oracle, one state with two wrenches, and which of its joints are locked. */
struct test_case {
    uint64_t seed;
    tfa_base base;
    tfa_description *d;
    oracle *o;
    random_states *x;
    tfa_request r;
    uint32_t n, nv;
    oracle_tie tie[MOST];
    uint32_t row[MOST], rows; /* freedoms that are left, joints only */
};

static void point_request(struct test_case *t)
{
    const random_states *x = t->x;
    t->r = (tfa_request){.count = 1,
                         .q = x->q,
                         .v = x->v,
                         .base_pose = x->base_pose,
                         .base_twist = x->base_twist,
                         .gravity = x->gravity,
                         .wrench_count = 2,
                         .wrench_frames = {x->wrench_links[0], x->wrench_links[1]},
                         .wrenches = x->wrenches};
}

static void test_case_open(struct test_case *t, uint64_t seed)
{
    const random_robot_options options = {.shape = (random_shape)(seed % 3),
                                          .joints = 8,
                                          .all_types = true,
                                          .fixed_fraction = 0.3,
                                          .armature_chance = 0.5,
                                          .shuffled = seed % 2 == 1};
    memset(t, 0, sizeof *t);
    t->seed = seed;
    t->base = seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
    t->d = random_robot_create(seed, &options);
    t->o = oracle_create(t->d, t->base);
    t->x = random_states_create(seed, t->d, t->o, 1, 2);
    t->n = oracle_freedoms(t->o);
    t->nv = oracle_v_count(t->o);
    assert_true(t->n <= MOST);
    point_request(t);
}

static void test_case_close(struct test_case *t)
{
    random_states_free(t->x);
    oracle_free(t->o);
    random_robot_free(t->d);
}

/* Locks every joint with an odd number, at rest, and ties the freedoms accordingly. */
static void lock_odd_joints(struct test_case *t)
{
    const uint32_t base = t->n - t->nv;
    for (uint32_t k = 0; k < base; k++)
        t->tie[k] = (oracle_tie){k, 1};
    for (uint32_t k = 0, within; k < t->nv; k++) {
        t->tie[base + k] = (oracle_tie){ORACLE_STILL, 0};
        if (oracle_joint_of_freedom(t->o, k, &within) % 2 == 1) {
            t->x->v[k] = 0;
            continue;
        }
        t->tie[base + k] = (oracle_tie){base + t->rows, 1};
        t->row[t->rows++] = k;
    }
}

struct answer {
    double qdd[MOST], base[6], tau[MOST], base_wrench[6], M[MOST * MOST], lambda[144];
};

/* Every answer of the state set last; tau and qdd as given, both `rows` of joints long. */
static void ask(const struct test_case *t, oracle *o, const double *tau, const double *qdd,
                struct answer *a)
{
    const uint32_t tips[2] = {(uint32_t)t->d->link_count - 1, (uint32_t)t->d->link_count / 2};
    memset(a, 0, sizeof *a);
    oracle_forward(o, tau, t->x->base_wrench, a->qdd, a->base);
    oracle_inverse(o, qdd, t->x->base_acceleration, a->tau, a->base_wrench);
    oracle_mass_matrix(o, a->M);
    oracle_lambda_inv(o, tips, 2, t->seed % 2 ? TFA_FRAME_LOCAL : TFA_FRAME_WORLD, a->lambda);
}

static void compare(const struct test_case *t, const struct answer *a, const struct answer *b)
{
    const size_t rows = t->n - t->nv + t->rows;
    assert_same(t->seed, "qdd", a->qdd, b->qdd, t->rows);
    assert_same(t->seed, "base_acceleration", a->base, b->base, 6);
    assert_same(t->seed, "tau", a->tau, b->tau, t->rows);
    assert_same(t->seed, "base_wrench", a->base_wrench, b->base_wrench, 6);
    assert_same(t->seed, "M", a->M, b->M, rows * rows);
    assert_same(t->seed, "lambda_inv", a->lambda, b->lambda, 144);
}

/* The numbers of the joints that are left, in front of each other. */
static void gather(const struct test_case *t, const double *all, double *left)
{
    for (uint32_t k = 0; k < t->rows; k++)
        left[k] = all[t->row[k]];
}

/* Route 1: the joint is a fixed one whose frame stands where the joint stood. The oracle itself
 * tells that place: it is the child's pose in the parent's. */
static void freeze(const struct test_case *t, uint32_t joint, tfa_joint *j)
{
    double p[3], R[9], at[3], P[9];
    const struct {
        int i, k;
    } off[3] = {{2, 1}, {0, 2}, {1, 0}};
    oracle_pose(t->o, t->d->joints[joint].parent, at, P);
    oracle_pose(t->o, t->d->joints[joint].child, p, R);
    double E[9] = {0}, trace = 0;
    for (int i = 0; i < 3; i++) {
        j->xyz[i] = 0;
        for (int k = 0; k < 3; k++) {
            j->xyz[i] += P[3 * k + i] * (p[k] - at[k]);
            for (int l = 0; l < 3; l++)
                E[3 * i + k] += P[3 * l + i] * R[3 * l + k];
        }
        trace += E[4 * i];
    }
    /* exact to rounding unless the turn is by 180 degrees, where w is 0 */
    double w = sqrt(fmax(0, 1 + trace)) / 2;
    assert_true(w > 1e-3);
    j->quat[3] = w;
    for (int i = 0; i < 3; i++)
        j->quat[i] = (E[3 * off[i].i + off[i].k] - E[3 * off[i].k + off[i].i]) / (4 * w);
    memset(j->quat_low, 0, sizeof j->quat_low);
    j->type = TFA_JOINT_FIXED;
    j->armature = 0;
}

TEST(locked_is_fixed)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        static struct answer tied, fixed;
        struct test_case t;
        double tau[MOST], qdd[MOST], q[2 * MOST], v[MOST];
        test_case_open(&t, seed);
        lock_odd_joints(&t);
        gather(&t, t.x->tau, tau);
        gather(&t, t.x->qdd, qdd);
        gather(&t, t.x->v, v);
        oracle_tie_freedoms(t.o, t.tie, t.n - t.nv + t.rows);
        oracle_set_state(t.o, &t.r, 0);
        ask(&t, t.o, tau, qdd, &tied);
        uint32_t left = 0, at = 0, within;
        for (uint32_t k = 0; k < t.nv; k++) { /* coordinates of the joints that are left */
            uint32_t j = oracle_joint_of_freedom(t.o, k, &within);
            uint32_t wide = within ? 0 : 1;
            if (within == 0 && t.d->joints[j].type == TFA_JOINT_PLANAR)
                wide = 3;
            if (within == 0 && t.d->joints[j].type == TFA_JOINT_FLOATING)
                wide = 7;
            for (uint32_t i = 0; i < wide; i++, at++)
                if (j % 2 == 0)
                    q[left++] = t.x->q[at];
        }
        for (uint32_t j = 1; j < t.d->joint_count; j += 2)
            freeze(&t, j, &t.d->joints[j]);
        oracle *o = oracle_create(t.d, t.base);
        assert_int_equal(oracle_q_count(o), left);
        t.r.q = q;
        t.r.v = v;
        oracle_set_state(o, &t.r, 0);
        ask(&t, o, tau, qdd, &fixed);
        compare(&t, &tied, &fixed);
        oracle_free(o);
        test_case_close(&t);
    }
    print_message("  worst difference %.2g\n", worst);
}

/* Route 2: rotors of 1e18 on the locked joints, whose velocity is whatever it is. */
TEST(locked_is_heavy)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        static struct answer tied, heavy;
        struct test_case t;
        double tau[MOST], v[MOST];
        test_case_open(&t, seed);
        memcpy(v, t.x->v, t.nv * sizeof *v);
        lock_odd_joints(&t);
        memcpy(t.x->v, v, t.nv * sizeof *v);
        gather(&t, t.x->tau, tau);
        oracle_tie_freedoms(t.o, t.tie, t.n - t.nv + t.rows);
        oracle_set_state(t.o, &t.r, 0);
        ask(&t, t.o, tau, NULL, &tied);
        oracle_tie_freedoms(t.o, NULL, 0);
        for (uint32_t j = 1; j < t.d->joint_count; j += 2)
            t.d->joints[j].armature = 1e18;
        oracle_set_state(t.o, &t.r, 0);
        ask(&t, t.o, t.x->tau, NULL, &heavy);
        gather(&t, heavy.qdd, heavy.qdd);
        assert_same(seed, "qdd", tied.qdd, heavy.qdd, t.rows);
        assert_same(seed, "base_acceleration", tied.base, heavy.base, 6);
        assert_same(seed, "lambda_inv", tied.lambda, heavy.lambda, 144);
        test_case_close(&t);
    }
    print_message("  worst difference %.2g\n", worst);
}

/* Solves A x = b in place by Gauss' elimination with row exchanges. */
static void gauss(quad *A, quad *b, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++) {
        uint32_t best = k;
        for (uint32_t i = k + 1; i < n; i++)
            if (fabs((double)A[i * n + k]) > fabs((double)A[best * n + k]))
                best = i;
        for (uint32_t j = 0; j < n; j++) {
            quad t = A[k * n + j];
            A[k * n + j] = A[best * n + j];
            A[best * n + j] = t;
        }
        quad t = b[k];
        b[k] = b[best];
        b[best] = t;
        for (uint32_t i = k + 1; i < n; i++) {
            quad l = A[i * n + k] / A[k * n + k];
            for (uint32_t j = k; j < n; j++)
                A[i * n + j] -= l * A[k * n + j];
            b[i] -= l * b[k];
        }
    }
    for (uint32_t k = n; k-- > 0;) {
        for (uint32_t j = k + 1; j < n; j++)
            b[k] -= A[k * n + j] * b[j];
        b[k] /= A[k * n + k];
    }
}

/* Every second freedom of the joints follows the one before it. The equations of all freedoms with
 * one multiplier for each tie: M qdd + h = tau + G^T lambda, G qdd = 0. */
TEST(tied_has_multipliers)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 24; seed++) {
        static double M[MOST * MOST], h[MOST], base_h[6], qdd[MOST], base[6], want[MOST];
        struct test_case t;
        random_source s = {seed};
        test_case_open(&t, seed);
        const uint32_t b = t.n - t.nv, ties = t.nv / 2, all = t.n + ties;
        quad *A = calloc((size_t)all * all, sizeof *A), *x = calloc(all, sizeof *x);
        double ratio[MOST];
        oracle_set_state(t.o, &t.r, 0);
        oracle_mass_matrix(t.o, M);
        oracle_inverse(t.o, NULL, NULL, h, base_h);
        for (uint32_t i = 0; i < t.n; i++) {
            x[i] = i < b ? (quad)t.x->base_wrench[i] - base_h[i] : (quad)t.x->tau[i - b] - h[i - b];
            for (uint32_t k = 0; k < t.n; k++)
                A[i * all + k] = M[i * t.n + k];
            t.tie[i] = (oracle_tie){i < b ? i : b + (i - b) / 2, 1};
        }
        for (uint32_t k = 0; k < ties; k++) {
            uint32_t leader = b + 2 * k, follower = leader + 1;
            ratio[k] = random_uniform(&s, -2, 2);
            t.tie[follower].multiplier = ratio[k];
            A[(t.n + k) * all + follower] = A[follower * all + t.n + k] = 1;
            A[(t.n + k) * all + leader] = A[leader * all + t.n + k] = -ratio[k];
        }
        gauss(A, x, all);
        double tau[MOST];
        uint32_t rows = (t.nv + 1) / 2;
        for (uint32_t k = 0; k < rows; k++) {
            tau[k] = t.x->tau[2 * k];
            tau[k] += k < ties ? ratio[k] * t.x->tau[2 * k + 1] : 0;
            want[k] = (double)x[b + 2 * k];
        }
        oracle_tie_freedoms(t.o, t.tie, b + rows);
        oracle_set_state(t.o, &t.r, 0);
        oracle_forward(t.o, tau, t.x->base_wrench, qdd, base);
        assert_same(seed, "qdd", qdd, want, rows);
        for (uint32_t k = 0; k < b; k++)
            want[k] = (double)x[k];
        assert_same(seed, "base_acceleration", base, want, b);
        free(x);
        free(A);
        test_case_close(&t);
    }
    print_message("  worst difference %.2g\n", worst);
}

/* Two flywheels on one shaft through a gear: (J1 + r^2 J2) qdd = tau, J with the rotors. */
TEST(gear)
{
    const double r = -2.5;
    small_robot wheels;
    small_robot_begin(&wheels);
    for (uint32_t k = 0; k < 2; k++) {
        small_robot_add(&wheels, 0, TFA_JOINT_REVOLUTE, 0, 0, 1)->armature = 0.125 * (k + 1);
        small_robot_load(&wheels, 1 + k, 2 + k, 0, 0, 0.25 * (k + 1));
    }
    oracle *o = oracle_create(&wheels.d, TFA_BASE_FIXED);
    const double q[2] = {0.3, r * 0.3}, v[2] = {1, r}, tau = 7;
    double qdd, M, moved = 1, still = 0;
    oracle_tie_freedoms(o, (const oracle_tie[2]){{0, 1}, {0, r}}, 1);
    oracle_set_state(o, &(tfa_request){.q = q, .v = v}, 0);
    oracle_mass_matrix(o, &M);
    oracle_forward(o, &tau, NULL, &qdd, NULL);
    assert_true(M == 0.375 + r * r * 0.75);
    assert_true(fabs(qdd * M - tau) < 1e-15);
    assert_true(fabs(oracle_energy_norm(o, &moved, NULL, &still, NULL) - sqrt(M)) < 1e-15);
    assert_true(fabs(oracle_energy_norm(o, &moved, NULL, NULL, NULL) - sqrt(M)) < 1e-15);
    oracle_free(o);
}

/* A payload is a link on a fixed joint at the same place, in every answer and in the mass. */
TEST(payload_is_a_link)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 16; seed++) {
        static struct answer loaded, linked;
        struct test_case t;
        random_source s = {seed};
        double payload[2 * TFA_PAYLOAD_NUMBERS], at[2][4];
        test_case_open(&t, seed);
        t.rows = t.nv;
        const uint32_t links = (uint32_t)t.d->link_count, joints = (uint32_t)t.d->joint_count;
        random_payload(&s, payload);
        random_payload(&s, payload + TFA_PAYLOAD_NUMBERS);
        t.r.payload_count = 2;
        t.r.payloads = payload;
        t.r.payload_frames[0] = random_below(&s, links);
        t.r.payload_frames[1] = random_below(&s, links);
        oracle_set_state(t.o, &t.r, 0);
        ask(&t, t.o, t.x->tau, t.x->qdd, &loaded);
        oracle_mass(t.o, &at[0][0], &at[0][1]);

        tfa_link *more_links = calloc(links + 2, sizeof *more_links);
        tfa_joint *more_joints = calloc(joints + 2, sizeof *more_joints);
        memcpy(more_links, t.d->links, links * sizeof *more_links);
        memcpy(more_joints, t.d->joints, joints * sizeof *more_joints);
        for (uint32_t k = 0; k < 2; k++) {
            const double *x = payload + k * TFA_PAYLOAD_NUMBERS;
            more_links[links + k] = (tfa_link){.name = "load", .mass = x[0], .quat = {0, 0, 0, 1}};
            memcpy(more_links[links + k].com, x + 1, 3 * sizeof *x);
            memcpy(more_links[links + k].inertia, x + 4, 6 * sizeof *x);
            more_joints[joints + k] = (tfa_joint){.name = "hook",
                                                  .type = TFA_JOINT_FIXED,
                                                  .parent = t.r.payload_frames[k],
                                                  .child = links + k,
                                                  .quat = {0, 0, 0, 1},
                                                  .mimic = -1};
        }
        tfa_description d = {.name = "linked",
                             .links = more_links,
                             .link_count = links + 2,
                             .joints = more_joints,
                             .joint_count = joints + 2};
        oracle *o = oracle_create(&d, t.base);
        t.r.payload_count = 0;
        oracle_set_state(o, &t.r, 0);
        ask(&t, o, t.x->tau, t.x->qdd, &linked);
        oracle_mass(o, &at[1][0], &at[1][1]);
        compare(&t, &loaded, &linked);
        assert_same(seed, "mass and centre", at[0], at[1], 4);
        oracle_free(o);
        free(more_joints);
        free(more_links);
        test_case_close(&t);
    }
    print_message("  worst difference %.2g\n", worst);
}
