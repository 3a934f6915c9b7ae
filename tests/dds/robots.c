/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two robots for the DDS tests: chains with a side branch, so that the methods have work to do.
 */
#include "robots.h"

#include <stdio.h>
#include <string.h>

#define LINKS_MAX 8

/* A chain of `joints` revolute joints with axes in turn; the last link hangs on the second. */
static int make(test_robot *robot, const char *name, uint32_t joints, tfa_base base)
{
    tfa_link links[LINKS_MAX] = {0};
    tfa_joint list[LINKS_MAX] = {0};
    char names[2 * LINKS_MAX][16];
    const tfa_description description = {.name = name,
                                         .links = links,
                                         .link_count = joints + 1u,
                                         .joints = list,
                                         .joint_count = joints};
    const tfa_model_options options = {.base = base};
    for (uint32_t i = 0; i <= joints; i++) {
        snprintf(names[i], sizeof names[i], "link%u", i);
        links[i] = (tfa_link){
            .name = names[i],
            .mass = 1.0 + 0.3 * i,
            .com = {0.01 * i, 0.02, 0.1},
            .quat = {0, 0, 0, 1},
            .inertia = {0.02, 0.001, 0, 0.03, 0.002, 0.01},
        };
    }
    for (uint32_t i = 0; i < joints; i++) {
        snprintf(names[LINKS_MAX + i], sizeof names[i], "joint%u", i);
        list[i] = (tfa_joint){
            .name = names[LINKS_MAX + i],
            .type = TFA_JOINT_REVOLUTE,
            .parent = i + 1 == joints ? 1 : i,
            .child = i + 1,
            .xyz = {0.05, 0, 0.3},
            .quat = {0, 0, 0, 1},
            .axis = {i % 3 == 0, i % 3 == 1, i % 3 == 2},
            .mimic = -1,
        };
    }
    robot->name = name;
    return tfa_model_create(&description, &options, NULL, &robot->model);
}

bool test_robots_make(test_robot robots[TEST_ROBOTS])
{
    memset(robots, 0, TEST_ROBOTS * sizeof *robots);
    return make(&robots[0], "arm", 7, TFA_BASE_FIXED) == TFA_OK &&
           make(&robots[1], "walker", 5, TFA_BASE_FLOATING) == TFA_OK;
}
