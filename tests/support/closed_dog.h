/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The quadruped with constraints, in C and as a scene of a daemon's robot: a foot on the ground and
 * a rod between two others.
 */
#ifndef TESTS_SUPPORT_CLOSED_DOG_H
#define TESTS_SUPPORT_CLOSED_DOG_H

#include <totalforce/model.h>

static const tfa_constraint closed_dog_constraints[] = {
    {.name = "stand", .link = {NULL, "FL_foot"}, .rows = TFA_CONSTRAINT_POINT, .unilateral = 1},
    {.name = "rod", .link = {"FR_foot", "RL_foot"}, .rows = TFA_CONSTRAINT_HINGE},
};
static const char *const closed_dog_motors[] = {
    "FL_hip_joint",  "FL_thigh_joint", "FL_calf_joint",  "FR_hip_joint",  "FR_thigh_joint",
    "FR_calf_joint", "RL_hip_joint",   "RL_thigh_joint", "RL_calf_joint", "RR_calf_joint"};
static const tfa_scene closed_dog_scene = {.constraints = closed_dog_constraints,
                                           .constraint_count = 2,
                                           .actuated = closed_dog_motors,
                                           .actuated_count = 10};
static const tfa_model_options closed_dog = {.base = TFA_BASE_FLOATING, .scene = &closed_dog_scene};

/* Scene `closed` of a robot */
#define CLOSED_DOG_YAML                                                                            \
    "    scenes:\n"                                                                                \
    "      - name: closed\n"                                                                       \
    "        constraints:\n"                                                                       \
    "          - {name: stand, second: {link: FL_foot}, hold: point, unilateral: true}\n"          \
    "          - {name: rod, first: {link: FR_foot}, second: {link: RL_foot}, hold: hinge}\n"      \
    "        actuated: [FL_hip_joint, FL_thigh_joint, FL_calf_joint, FR_hip_joint,\n"              \
    "          FR_thigh_joint, FR_calf_joint, RL_hip_joint, RL_thigh_joint, RL_calf_joint,\n"      \
    "          RR_calf_joint]\n"

#endif
