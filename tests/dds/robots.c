/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See robots.h.
 */
#include "robots.h"

#include "models.h"

void test_robots_make(test_robot robots[TEST_ROBOTS])
{
    static const tfa_constraint constraints[] = {
        {.name = "stand", .link = {NULL, "FL_foot"}, .rows = TFA_CONSTRAINT_POINT, .unilateral = 1},
        {.name = "rod", .link = {"FR_foot", "RL_foot"}, .rows = TFA_CONSTRAINT_HINGE},
    };
    const tfa_scene scene = {.constraints = constraints, .constraint_count = 2};
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING, .scene = &scene};
    robots[0] = (test_robot){"arm", bundled_model("arm7.urdf", NULL)};
    robots[1] = (test_robot){"four.walker", bundled_model("quadruped.urdf", &floating)};
}
