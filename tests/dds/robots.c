/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See robots.h.
 */
#include "robots.h"

#include "models.h"
#include "support/closed_dog.h"

void test_robots_make(test_robot robots[TEST_ROBOTS])
{
    robots[0] = (test_robot){"arm", bundled_model("arm7.urdf", NULL)};
    robots[1] = (test_robot){"four.closed", bundled_model("quadruped.urdf", &closed_dog)};
}
