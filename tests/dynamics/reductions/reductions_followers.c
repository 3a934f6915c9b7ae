/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Followers without which the robot could not be computed: telescopes whose stages have no mass,
 * fingers that weigh nothing. M of all joints is singular, T^T M T is not. Whoever answers must be
 * right; auto and crba must answer.
 */
#include "models.h"
#include "support/oracle.h"
#include "support/random_robot.h"
#include "test.h"

#include <totalforce/totalforce.h>

#define BOUND 1e-13
#define SEEDS 40
#define LINKS 16

struct robot {
    tfa_link links[LINKS];
    tfa_joint joints[LINKS];
    char names[2 * LINKS][8];
    tfa_description d;
};

static void begin(struct robot *r)
{
    memset(r, 0, sizeof *r);
    r->d = (tfa_description){
        .name = "robot", .links = r->links, .link_count = 1, .joints = r->joints, .joint_count = 0};
    r->links[0].name = "root";
    r->links[0].quat[3] = 1;
    r->links[0].mass = 3;
    r->links[0].inertia[0] = r->links[0].inertia[3] = r->links[0].inertia[5] = 0.1;
}

/* A link at the end, on a joint of its own; massless unless given a mass. */
static tfa_joint *add(struct robot *r, uint32_t parent, tfa_joint_type type, double mass)
{
    uint32_t k = (uint32_t)r->d.link_count++, j = (uint32_t)r->d.joint_count++;
    assert_true(k < LINKS);
    snprintf(r->names[k], sizeof *r->names, "l%u", (unsigned)k);
    snprintf(r->names[LINKS + j], sizeof *r->names, "j%u", (unsigned)j);
    r->links[k] = (tfa_link){.name = r->names[k], .mass = mass, .quat = {0, 0, 0, 1}};
    r->links[k].com[1] = mass > 0 ? 0.1 : 0;
    r->links[k].inertia[0] = 0.02 * mass;
    r->links[k].inertia[3] = 0.01 * mass;
    r->links[k].inertia[5] = 0.015 * mass;
    r->joints[j] = (tfa_joint){.name = r->names[LINKS + j],
                               .type = type,
                               .parent = parent,
                               .child = k,
                               .quat = {0, 0, 0, 1},
                               .axis = {0, 0, 1},
                               .mimic = -1};
    return &r->joints[j];
}

static void rotate(const double q[4], const double a[3], int back, double out[3])
{
    double t[3], w = back ? -q[3] : q[3];
    for (int i = 0; i < 3; i++)
        t[i] = 2 * (q[(i + 1) % 3] * a[(i + 2) % 3] - q[(i + 2) % 3] * a[(i + 1) % 3]);
    for (int i = 0; i < 3; i++)
        out[i] =
            a[i] + w * t[i] + q[(i + 1) % 3] * t[(i + 2) % 3] - q[(i + 2) % 3] * t[(i + 1) % 3];
}

static void follow(tfa_joint *j, int32_t leader, double multiplier)
{
    j->mimic = leader;
    j->multiplier = multiplier;
    j->offset = 0.0625;
}

/* A shoulder, then stages that slide along one line, each link's frame turned at random: no two
 * axes have the same numbers, rounding makes them almost parallel. */
static void telescope(struct robot *r, random_source *s)
{
    double axis[3] = {0.6, 0, 0.8};
    const uint32_t stages = 2 + random_below(s, 3);
    begin(r);
    add(r, 0, TFA_JOINT_REVOLUTE, 1.5)->xyz[2] = 0.3;
    int32_t leader = (int32_t)r->d.joint_count;
    for (uint32_t k = 0; k < stages; k++) {
        tfa_joint *j =
            add(r, (uint32_t)r->d.link_count - 1, TFA_JOINT_PRISMATIC, k + 1 == stages ? 2 : 0);
        random_quaternion(s, j->quat);
        rotate(j->quat, axis, 1, j->axis);
        memcpy(axis, j->axis, sizeof axis);
        j->xyz[0] = 0.05;
        if (k > 0)
            follow(j, leader + (random_below(s, 2) ? 0 : (int32_t)k - 1), 0.5 + 0.25 * k);
    }
    tfa_joint *wrist = add(r, (uint32_t)r->d.link_count - 1, TFA_JOINT_REVOLUTE, 1);
    wrist->axis[0] = 0.8;
    wrist->axis[2] = 0.6;
    wrist->xyz[1] = 0.2;
}

/* A hand whose fingers weigh nothing but for the leading one. */
static void compute_by_hand(struct robot *r, random_source *s)
{
    begin(r);
    add(r, 0, TFA_JOINT_REVOLUTE, 1.5);
    tfa_joint *palm = add(r, 1, TFA_JOINT_REVOLUTE, 1);
    palm->axis[1] = 1;
    palm->axis[2] = 0;
    palm->xyz[0] = 0.3;
    int32_t leader = (int32_t)r->d.joint_count;
    const uint32_t fingers = 2 + random_below(s, 4);
    for (uint32_t k = 0; k < fingers; k++) {
        tfa_joint *j = add(r, 2, k % 2 ? TFA_JOINT_REVOLUTE : TFA_JOINT_PRISMATIC, k ? 0 : 0.2);
        random_quaternion(s, j->quat);
        j->xyz[1] = 0.1 * k;
        if (k > 0)
            follow(j, leader, random_below(s, 2) ? 1 : -1);
    }
}

/* Freedoms of all joints tied to the public ones; q of all joints from q of those. */
struct tied {
    oracle_tie tie[LINKS + 6];
    double q[LINKS], v[LINKS], own_q[LINKS], own_v[LINKS];
    uint32_t rows, base;
};

static void tie(const struct robot *r, tfa_base base, random_source *s, struct tied *t)
{
    memset(t, 0, sizeof *t);
    t->base = t->rows = base == TFA_BASE_FLOATING ? 6 : 0;
    for (uint32_t k = 0; k < t->base; k++)
        t->tie[k] = (oracle_tie){k, 1};
    for (uint32_t j = 0; j < r->d.joint_count; j++) { /* leaders stand before their followers */
        const int32_t up = r->joints[j].mimic;
        const double m = r->joints[j].multiplier;
        oracle_tie *row = &t->tie[t->base + j];
        if (up < 0) {
            t->q[j] = t->own_q[t->rows - t->base] = random_uniform(s, -1, 1);
            t->v[j] = t->own_v[t->rows - t->base] = random_uniform(s, -1, 1);
            *row = (oracle_tie){t->rows++, 1};
            continue;
        }
        *row = t->tie[t->base + (uint32_t)up];
        row->multiplier *= m;
        t->q[j] = m * t->q[up] + r->joints[j].offset;
        t->v[j] = m * t->v[up];
    }
}

static double difference(const double *x, const double *y, size_t n)
{
    double d = 0, size = 0;
    for (size_t k = 0; k < n; k++) {
        d += (x[k] - y[k]) * (x[k] - y[k]);
        size += y[k] * y[k];
    }
    return sqrt(d / size);
}

static unsigned answered, refused;
static double worst;

/* An answer is right, or there is none. */
static void check_answer(int status, const tfa_request *q, tfa_base base, uint64_t seed,
                         const double *x, const double *want, size_t n)
{
    const char *name = tfa_method_name((uint32_t)q->method);
    bool must = q->method == TFA_METHOD_AUTO || q->method == TFA_METHOD_CRBA;
    if (status != TFA_OK) {
        refused++;
        if (must)
            fail_msg("seed %u, base %d, op %d, %s: %s", (unsigned)seed, (int)base, (int)q->op, name,
                     tfa_status_text(status));
        return;
    }
    double error = difference(x, want, n);
    answered++;
    worst = fmax(worst, error);
    if (!(error <= BOUND))
        fail_msg("seed %u, base %d, op %d, %s: error %g", (unsigned)seed, (int)base, (int)q->op,
                 name, error);
}

static void check(const struct robot *r, tfa_base base, uint64_t seed)
{
    static const tfa_method methods[] = {
        TFA_METHOD_AUTO,       TFA_METHOD_CRBA,        TFA_METHOD_ABA,           TFA_METHOD_TFA,
        TFA_METHOD_TFA_CR,     TFA_METHOD_CFA,         TFA_METHOD_CFA_CR,        TFA_METHOD_DCA,
        TFA_METHOD_HESSENBERG, TFA_METHOD_PROPAGATION, TFA_METHOD_TFA_ONE_SIDED, TFA_METHOD_EFPA,
        TFA_METHOD_PV_OSIMR};
    const size_t count = sizeof methods / sizeof *methods, lambda_only = 4; /* at the end */
    const double pose[7] = {0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5}, twist[6] = {1, 0, 2, 0.3, 0.5, 1};
    random_source s = {seed};
    struct tied t;
    double tau[LINKS], x[LINKS + 6], want[LINKS + 6], L[36], want_L[36];
    tie(r, base, &s, &t);
    for (int k = 0; k < LINKS; k++)
        tau[k] = random_uniform(&s, -5, 5);
    const tfa_model_options options = {.base = base, .mimic = TFA_MIMIC_PROJECT};
    tfa_model *model = NULL;
    int status = tfa_model_create(&r->d, &options, NULL, &model);
    if (status != TFA_OK)
        fail_msg("seed %u: %s", (unsigned)seed, tfa_status_text(status));
    tfa_workspace *w = workspace_for(model, NULL);
    oracle *o = oracle_create(&r->d, base);
    tfa_request q = {.refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .q = t.own_q,
                     .v = t.own_v,
                     .tau = tau,
                     .tip_count = 1};
    q.base_pose = base == TFA_BASE_FLOATING ? pose : NULL;
    q.base_twist = base == TFA_BASE_FLOATING ? twist : NULL;
    tfa_request whole = q;
    whole.q = t.q;
    whole.v = t.v;
    oracle_tie_freedoms(o, t.tie, t.rows);
    oracle_set_state(o, &whole, 0);
    oracle_forward(o, tau, NULL, want + t.base, want);
    q.tips[0] = (uint32_t)r->d.link_count - 1;
    oracle_lambda_inv(o, q.tips, 1, TFA_FRAME_LOCAL_WORLD_ALIGNED, want_L);
    for (size_t m = 0; m < count; m++) {
        tfa_reply reply = {.qdd = x + t.base, .base_acceleration = x, .lambda_inv = L};
        q.method = methods[m];
        q.op = TFA_OP_OPERATIONAL_INERTIA;
        check_answer(tfa_compute(w, &q, &reply), &q, base, seed, L, want_L, 36);
        q.op = TFA_OP_FORWARD_DYNAMICS;
        if (m < count - lambda_only)
            check_answer(tfa_compute(w, &q, &reply), &q, base, seed, x, want, t.rows);
    }
    oracle_free(o);
    tfa_workspace_free(w);
    tfa_model_free(model);
}

static void for_seeds(void (*make)(struct robot *r, random_source *s))
{
    answered = refused = 0;
    worst = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct robot r;
        random_source s = {seed};
        make(&r, &s);
        check(&r, seed % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED, seed);
    }
    print_message("  %u answers, worst error %.1e; %u refused\n", answered, worst, refused);
}

TEST(stages_without_mass)
{
    for_seeds(telescope);
}

TEST(fingers_without_mass)
{
    for_seeds(compute_by_hand);
}
