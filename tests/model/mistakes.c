/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The mistakes that no robot survives. See mistakes.h.
 */
#include "mistakes.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

CHANGE(no_links, h->d.link_count = h->d.joint_count = 0)
CHANGE(unknown_parent, h->joint[ELBOW].parent = 4)
CHANGE(unknown_child, h->joint[FLANGE].child = UINT32_MAX)
CHANGE(two_parents, hand_joint(h, "strut", TFA_JOINT_FIXED, BASE, LOWER))
CHANGE(self_parent, h->joint[ELBOW].parent = LOWER)
CHANGE(two_roots, hand_link(h, "stray", 1, 0, 0, 0))
CHANGE(no_root, hand_joint(h, "back", TFA_JOINT_REVOLUTE, TOOL, BASE))

/* The joint that is named lies in the loop, not below it. */
static void loop_above(hand *h)
{
    uint32_t a = hand_link(h, "a", 1, 0, 0, 0), b = hand_link(h, "b", 1, 0, 0, 0);
    uint32_t tail = hand_link(h, "tail", 1, 0, 0, 0), end = hand_link(h, "end", 1, 0, 0, 0);
    hand_joint(h, "tail_end", TFA_JOINT_REVOLUTE, tail, end);
    hand_joint(h, "a_tail", TFA_JOINT_REVOLUTE, a, tail);
    hand_joint(h, "a_b", TFA_JOINT_REVOLUTE, a, b);
    hand_joint(h, "b_a", TFA_JOINT_REVOLUTE, b, a);
}

CHANGE(zero_axis, h->joint[ELBOW].axis[1] = 0)
CHANGE(nan_axis, h->joint[ELBOW].axis[0] = (double)NAN)
CHANGE(infinite_origin, h->joint[FLANGE].xyz[1] = (double)INFINITY)
CHANGE(zero_quaternion, h->joint[SHOULDER].quat[3] = 0)
CHANGE(large_low_part, h->joint[SHOULDER].quat_low[1] = 1e-15)
CHANGE(nan_low_part, h->joint[ELBOW].axis_low[0] = (double)NAN)
CHANGE(large_low_part_of_inertia, h->link[UPPER].quat_low[3] = -1e-15)
CHANGE(unknown_type, h->joint[ELBOW].type = (tfa_joint_type)6)
CHANGE(negative_armature, h->joint[ELBOW].armature = -0.5)
CHANGE(nan_mass, h->link[UPPER].mass = (double)NAN)
CHANGE(nan_com, h->link[UPPER].com[2] = (double)NAN)
CHANGE(infinite_inertia, h->link[UPPER].inertia[4] = (double)INFINITY)
CHANGE(zero_inertia_quaternion, h->link[UPPER].quat[3] = 0)
CHANGE(negative_mass, h->link[UPPER].mass = -2)

/* The body's mass as a whole is positive: its part is wrong nevertheless. */
CHANGE(negative_mass_merged, h->link[TOOL].mass = -0.25)
CHANGE(negative_mass_root, h->link[BASE].mass = -1)
CHANGE(negative_inertia, h->link[UPPER].inertia[0] = -0.5)

/* Principal moments 0.02 +- 0.03 and 0.02. */
CHANGE(indefinite_inertia, h->link[UPPER].inertia[1] = 0.03)

static void products_without_moments(hand *h)
{
    hand_link(h, "probe", 0, 0, 0, 0);
    hand_joint(h, "mount", TFA_JOINT_REVOLUTE, UPPER, 4);
    h->link[4].inertia[2] = 0.125;
}

void massless_leaf(hand *h)
{
    hand_link(h, "pointer", 0, 0, 0, 0);
    hand_joint(h, "swing", TFA_JOINT_CONTINUOUS, TOOL, 4);
}

/* Both joints move nothing: one message. */
static void massless_branch(hand *h)
{
    massless_leaf(h);
    hand_link(h, "needle", 0, 0, 0, 0);
    hand_joint(h, "twist", TFA_JOINT_CONTINUOUS, 4, 5);
}

void massless_base(hand *h)
{
    h->d.link_count = 1;
    h->d.joint_count = 0;
    h->link[BASE].mass = 0;
    memset(h->link[BASE].inertia, 0, sizeof h->link[BASE].inertia);
}

static const double nan_gravity[3] = {0, (double)NAN, -9.81};
static const double infinite_gravity[3] = {0, 0, -(double)INFINITY};

const struct mistake mistakes[] = {
    {"no links", no_links, {0}, TFA_E_MODEL, 0, 1, "no-links", "the robot has no links"},
    {"unknown parent",
     unknown_parent,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "unknown-link",
     "joint 'elbow': parent or child link does not exist"},
    {"unknown child",
     unknown_child,
     {0},
     TFA_E_MODEL,
     102,
     1,
     "unknown-link",
     "joint 'flange': parent or child link does not exist"},
    {"two parents",
     two_parents,
     {0},
     TFA_E_MODEL,
     103,
     1,
     "two-parents",
     "link 'lower': child of joint 'elbow' and of joint 'strut'; a robot is a tree: remove one"},
    {"own parent",
     self_parent,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "loop",
     "joint 'elbow': its parent link 'lower' hangs from itself; a robot is a tree: open the loop"},
    {"two roots",
     two_roots,
     {0},
     TFA_E_MODEL,
     14,
     1,
     "two-roots",
     "link 'stray': neither it nor link 'base' is the child of a joint; connect them or remove "
     "one"},
    {"no root",
     no_root,
     {0},
     TFA_E_MODEL,
     0,
     1,
     "no-root",
     "every link is the child of a joint: the joints form a loop; remove one"},
    {"loop",
     loop_above,
     {0},
     TFA_E_MODEL,
     105,
     1,
     "loop",
     "joint 'a_b': its parent link 'a' hangs from itself; a robot is a tree: open the loop"},
    {"zero axis",
     zero_axis,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "zero-axis",
     "joint 'elbow': axis 0 0 0 has no direction; give it a unit vector"},
    {"NaN axis",
     nan_axis,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "zero-axis",
     "joint 'elbow': axis nan 1 0 has no direction; give it a unit vector"},
    {"infinite origin",
     infinite_origin,
     {0},
     TFA_E_MODEL,
     102,
     1,
     "bad-number",
     "joint 'flange': its origin 0.3 inf 0 is not finite; correct it"},
    {"zero quaternion",
     zero_quaternion,
     {0},
     TFA_E_MODEL,
     100,
     1,
     "bad-quaternion",
     "joint 'shoulder': quaternion 0 0 0 0 is no rotation; give 0 0 0 1 for none"},
    {"unknown type",
     unknown_type,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "bad-type",
     "joint 'elbow': type 6 does not exist; use one of tfa_joint_type"},
    {"negative armature",
     negative_armature,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "bad-armature",
     "joint 'elbow': armature -0.5 must be finite and not negative; correct it"},
    {"NaN mass",
     nan_mass,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "bad-number",
     "link 'upper': its mass is not finite; correct it"},
    {"NaN centre",
     nan_com,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "bad-number",
     "link 'upper': its centre of mass is not finite; correct it"},
    {"infinite inertia",
     infinite_inertia,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "bad-number",
     "link 'upper': its inertia is not finite; correct it"},
    {"large low part of a quaternion",
     large_low_part,
     {0},
     TFA_E_MODEL,
     100,
     1,
     "bad-number",
     "joint 'shoulder': quat_low is more than rounding leaves of quat; set it to 0"},
    {"low part of an axis",
     nan_low_part,
     {0},
     TFA_E_MODEL,
     101,
     1,
     "bad-number",
     "joint 'elbow': axis_low is more than rounding leaves of axis; set it to 0"},
    {"large low part of an inertia's quaternion",
     large_low_part_of_inertia,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "bad-number",
     "link 'upper': quat_low is more than rounding leaves of quat; set it to 0"},
    {"zero quaternion of an inertia",
     zero_inertia_quaternion,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "bad-quaternion",
     "link 'upper': quaternion 0 0 0 0 of its inertia is no rotation; give 0 0 0 1 for none"},
    {"negative mass",
     negative_mass,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "negative-mass",
     "link 'upper': mass -2 kg is negative; correct it"},
    {"negative mass of a part",
     negative_mass_merged,
     {0},
     TFA_E_MODEL,
     13,
     1,
     "negative-mass",
     "link 'tool': mass -0.25 kg is negative; correct it"},
    {"negative mass of the fixed root",
     negative_mass_root,
     {0},
     TFA_E_MODEL,
     10,
     1,
     "negative-mass",
     "link 'base': mass -1 kg is negative; correct it"},
    {"negative inertia",
     negative_inertia,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "inertia-not-positive",
     "link 'upper': its inertia has the eigenvalue -0.5 kg m^2; a body cannot have a negative one: "
     "correct <inertia>, or choose inertia = repair"},
    {"indefinite inertia",
     indefinite_inertia,
     {0},
     TFA_E_MODEL,
     11,
     1,
     "inertia-not-positive",
     "link 'upper': its inertia has the eigenvalue -0.01 kg m^2; a body cannot have a negative "
     "one: "
     "correct <inertia>, or choose inertia = repair"},
    {"products without moments",
     products_without_moments,
     {0},
     TFA_E_MODEL,
     14,
     1,
     "inertia-not-positive",
     "link 'probe': its inertia has the eigenvalue -0.125 kg m^2; a body cannot have a negative "
     "one: correct <inertia>, or choose inertia = repair"},
    {"massless leaf",
     massless_leaf,
     {0},
     TFA_E_NO_MASS,
     103,
     1,
     "massless-leaf",
     "joint 'swing': nothing with mass moves with it, so the mass matrix is singular; lock it "
     "(lock_massless_leaves = 1 locks all of them), make it fixed, or give link 'pointer' mass or "
     "the "
     "joint "
     "armature"},
    {"massless branch",
     massless_branch,
     {0},
     TFA_E_NO_MASS,
     103,
     2,
     "massless-leaf",
     "joint 'swing': nothing with mass moves with it, so the mass matrix is singular; lock it "
     "(lock_massless_leaves = 1 locks all of them), make it fixed, or give link 'pointer' mass or "
     "the joint armature; joints like it: 2 ('swing', 'twist')"},
    {"massless floating base",
     massless_base,
     {.base = TFA_BASE_FLOATING},
     TFA_E_NO_MASS,
     10,
     1,
     "massless-root",
     "link 'base': the floating base has no mass, and no two joints hold it, so the mass matrix is "
     "singular; give it mass, make its joint fixed, or let the link that has the mass be the root"},
    {"NaN gravity",
     NULL,
     {.gravity = nan_gravity},
     TFA_E_VALUE,
     0,
     1,
     "bad-gravity",
     "gravity: component 1 is not finite; give three numbers in m/s^2"},
    {"infinite gravity",
     NULL,
     {.gravity = infinite_gravity},
     TFA_E_VALUE,
     0,
     1,
     "bad-gravity",
     "gravity: component 2 is not finite; give three numbers in m/s^2"},
    {"unknown base",
     NULL,
     {.base = (tfa_base)2},
     TFA_E_ARGUMENT,
     0,
     1,
     "bad-base",
     "base: 2 does not exist; give 0 (fixed) or 1 (floating)"},
};

const size_t mistake_count = sizeof mistakes / sizeof *mistakes;
