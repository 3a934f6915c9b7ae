/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random robots and random states, the same on every machine for the same seed.
 */
#ifndef TESTS_SUPPORT_RANDOM_ROBOT_H
#define TESTS_SUPPORT_RANDOM_ROBOT_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/description.h>

#include "oracle.h"

/** splitmix64: any seed is a good seed. */
typedef struct random_source {
    uint64_t state;
} random_source;

uint64_t random_bits(random_source *s);
/** 0 .. n - 1 */
uint32_t random_below(random_source *s, uint32_t n);
double random_uniform(random_source *s, double low, double high);
/** Uniform over all rotations; x y z w. */
void random_quaternion(random_source *s, double quat[4]);
/** Coordinates of one joint: angles in any winding, quaternions with a norm off by up to 1e-6.
 * Returns how many it wrote. */
uint32_t random_coordinates(random_source *s, tfa_joint_type type, double *q);

typedef enum random_shape {
    RANDOM_CHAIN,     /**< each link hangs from the one before */
    RANDOM_STAR,      /**< branches of equal length on the root */
    RANDOM_BRANCHING, /**< each link hangs from any earlier one */
} random_shape;

typedef struct random_robot_options {
    random_shape shape;
    uint32_t joints;        /**< moving joints */
    bool all_types;         /**< all types of joints; otherwise revolute joints only */
    double fixed_fraction;  /**< chance that a fixed joint is put before a moving one */
    double armature_chance; /**< chance that a moving joint has armature */
    bool shuffled;          /**< links and joints declared in any order */
} random_robot_options;

/** Physically valid inertias, masses 0.1 .. 10 kg; half of the links on fixed joints have none. */
tfa_description *random_robot_create(uint64_t seed, const random_robot_options *options);
void random_robot_free(tfa_description *description);
/** The link that hangs from none */
uint32_t description_root(const tfa_description *description);

/** Takes mass and inertia away from links, each with this chance, but from none without which
 * a moving joint would move nothing with mass, not from those next to a joint of several freedoms,
 * and not from the root. */
void random_robot_empty_links(random_source *s, tfa_description *description, double chance);

/** Makes joints with one freedom follow others, each with this chance: leaders stand before or
 * behind them, and may follow others in turn. Multipliers and offsets are multiples of 1/256. */
void random_robot_add_mimics(random_source *s, tfa_description *description, double chance);

/** A box of 0.1 to 3 kg near the link's origin, as in a request. */
void random_payload(random_source *s, double payload[TFA_PAYLOAD_NUMBERS]);

/** `count` states of a robot, everything that a request can hold. */
typedef struct random_states {
    uint32_t count, wrench_count;
    double gravity[3];
    uint32_t wrench_links[TFA_MAX_WRENCHES];
    double *q, *v, *tau, *qdd;
    double *base_pose, *base_twist, *base_wrench, *base_acceleration, *wrenches;
    double *memory;
} random_states;

random_states *random_states_create(uint64_t seed, const tfa_description *description,
                                    const oracle *o, uint32_t count, uint32_t wrench_count);
void random_states_free(random_states *states);

#endif
