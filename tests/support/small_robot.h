/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots of a few links, written down one joint at a time.
 */
#ifndef TESTS_SUPPORT_SMALL_ROBOT_H
#define TESTS_SUPPORT_SMALL_ROBOT_H

#include <totalforce/description.h>

#define SMALL_ROBOT_LINKS 32

typedef struct small_robot {
    tfa_link link[SMALL_ROBOT_LINKS];
    tfa_joint joint[SMALL_ROBOT_LINKS]; /**< joint k carries link k + 1 */
    char names[2 * SMALL_ROBOT_LINKS][8];
    tfa_description d; /**< points into this struct, which must stay where it is */
} small_robot;

/** A root without mass. */
void small_robot_begin(small_robot *r);
/** A link without mass, on a joint about or along this axis at its parent's origin. */
tfa_joint *small_robot_add(small_robot *r, uint32_t parent, tfa_joint_type type, double x, double y,
                           double z);
/** Mass of a link, and its principal moments of inertia about axes of the link. */
void small_robot_load(small_robot *r, uint32_t link, double mass, double xx, double yy, double zz);

#endif
