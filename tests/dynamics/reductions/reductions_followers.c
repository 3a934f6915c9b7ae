/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Followers without which the robot could not be computed: telescopes whose stages have no mass,
 * fingers that weigh nothing. M of all joints is singular, T^T M T is not. Whoever answers must be
 * right; auto and crba must answer.
 */
#include "reductions.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

#define SEEDS 40

/* A link at the end, on a joint about z; massless unless given a mass. */
static tfa_joint *add(small_robot *r, uint32_t parent, tfa_joint_type type, double mass)
{
    tfa_joint *j = small_robot_add(r, parent, type, 0, 0, 1);
    small_robot_load(r, j->child, mass, 0.02 * mass, 0.01 * mass, 0.015 * mass);
    r->link[j->child].com[1] = mass > 0 ? 0.1 : 0;
    return j;
}

static void follow(tfa_joint *j, int32_t leader, double multiplier)
{
    j->mimic = leader;
    j->multiplier = multiplier;
    j->offset = 0.0625;
}

/* A shoulder, then stages that slide along one line, each link's frame turned at random: no two
 * axes have the same numbers, rounding makes them almost parallel. */
static void telescope(small_robot *r, random_source *s)
{
    double axis[3] = {0.6, 0, 0.8};
    const uint32_t stages = 2 + random_below(s, 3);
    small_robot_begin(r);
    small_robot_load(r, 0, 3, 0.1, 0.1, 0.1);
    add(r, 0, TFA_JOINT_REVOLUTE, 1.5)->xyz[2] = 0.3;
    int32_t leader = (int32_t)r->d.joint_count;
    for (uint32_t k = 0; k < stages; k++) {
        tfa_joint *j =
            add(r, (uint32_t)r->d.link_count - 1, TFA_JOINT_PRISMATIC, k + 1 == stages ? 2 : 0);
        random_quaternion(s, j->quat);
        const double back[4] = {-j->quat[0], -j->quat[1], -j->quat[2], j->quat[3]};
        rotate_vector(back, axis, j->axis);
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
static void compute_by_hand(small_robot *r, random_source *s)
{
    small_robot_begin(r);
    small_robot_load(r, 0, 3, 0.1, 0.1, 0.1);
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

static void check(small_robot *r, tfa_base base, uint64_t seed)
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

static void for_seeds(void (*make)(small_robot *r, random_source *s))
{
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        small_robot r;
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
