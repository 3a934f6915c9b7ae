/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Moves numbers to their neighbours.
 */
#include "move.h"

#include "mechanism.h"

#include <math.h>
#include <string.h>

void move_numbers(uint64_t *random, double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        switch (mechanism_random_bits(random) % 3) {
        case 0:
            values[i] = values[i] == 0.0 ? 0.0 : nextafter(values[i], INFINITY);
            break;
        case 1:
            values[i] = values[i] == 0.0 ? 0.0 : nextafter(values[i], -INFINITY);
            break;
        default:
            break;
        }
}

void move_description(uint64_t *random, tfa_description *d)
{
    for (size_t k = 0; k < d->link_count; k++) {
        tfa_link *link = &d->links[k];
        move_numbers(random, &link->mass, 1);
        move_numbers(random, link->com, 3);
        move_numbers(random, link->quat, 4);
        move_numbers(random, link->inertia, 6);
        memset(link->quat_low, 0, sizeof link->quat_low);
    }
    for (size_t k = 0; k < d->joint_count; k++) {
        tfa_joint *joint = &d->joints[k];
        move_numbers(random, joint->xyz, 3);
        move_numbers(random, joint->quat, 4);
        move_numbers(random, joint->axis, 3);
        memset(joint->quat_low, 0, sizeof joint->quat_low);
        memset(joint->axis_low, 0, sizeof joint->axis_low);
        move_numbers(random, &joint->armature, 1);
        move_numbers(random, &joint->multiplier, 1);
        move_numbers(random, &joint->offset, 1);
    }
    for (size_t k = 0; k < d->constraint_count; k++)
        move_numbers(random, *d->constraints[k].pose, 2 * 7);
}
