/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See robots.h.
 */
#include "robots.h"

#include "models.h"

void test_robots_make(test_robot robots[TEST_ROBOTS])
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    robots[0] = (test_robot){"arm", bundled_model("arm7.urdf", NULL)};
    robots[1] = (test_robot){"walker", bundled_model("quadruped.urdf", &floating)};
}
