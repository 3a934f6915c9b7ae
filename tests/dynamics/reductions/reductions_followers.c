/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Followers without which the robot could not be computed: telescopes whose stages have no mass,
 * fingers that weigh nothing. M of all joints is singular, T^T M T is not. Whoever answers must be
 * right; auto and crba must answer.
 */
#include "reductions.h"
#include "test.h"

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

static void check(struct robot *r, tfa_base base, uint64_t seed)
{
    static const reduction_bounds bounds = {1e-13, 0, 1e-13, 1e-13};
    const tfa_model_options options = {.base = base, .mimic = TFA_MIMIC_PROJECT};
    reduction reduced;
    question a;
    char name[40];
    snprintf(name, sizeof name, "seed %u, base %d", (unsigned)seed, (int)base);
    assert_true(reduction_open_robot(&reduced, name, &r->d, &options));
    assert_true(question_open(&a, &reduced, seed, 1, 2));
    tfa_request whole, one = question_state(&a, &reduced, 0, &whole);
    one.tip_count = whole.tip_count = 1;
    one.tips[0] = whole.tips[0] = (uint32_t)r->d.link_count - 1;
    reduction_check_forward(&reduced, &one, &whole, reduced.tie, &bounds);
    reduction_check_lambda(&reduced, &one, &whole, reduced.tie, &bounds, 1);
    question_close(&a);
    reduction_close(&reduced);
}

static void for_seeds(void (*make)(struct robot *r, random_source *s))
{
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct robot r;
        random_source s = {seed};
        make(&r, &s);
        check(&r, seed % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED, seed);
    }
    reduction_print();
}

TEST(stages_without_mass)
{
    for_seeds(telescope);
}

TEST(fingers_without_mass)
{
    for_seeds(compute_by_hand);
}
