/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Validation of a description's numbers. The URDF front end has validated those of files.
 */
#include <math.h>

#include "model/draft/draft.h"

static int all_finite(const double *x, int count)
{
    for (int k = 0; k < count; k++)
        if (!isfinite(x[k]))
            return 0;
    return 1;
}

/* Any finite length but zero: rotations are normalised when they are used. */
static int is_valid_quaternion(const double q[4])
{
    return all_finite(q, 4) && (q[0] != 0 || q[1] != 0 || q[2] != 0 || q[3] != 0);
}

/* 1: `low` is at most the rounding of `high` to double */
static int is_rounding_remainder(const double *high, const double *low, int count)
{
    double largest = 0;
    int small = 1;
    for (int k = 0; k < count; k++)
        largest = fmax(largest, fabs(high[k]));
    for (int k = 0; k < count; k++)
        small &= fabs(low[k]) <= 0x1p-52 * largest;
    return small;
}

static int refuse_low(const char *kind, const char *name, uint32_t line, const char *field,
                      tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, line, "bad-number",
                      "%s '%s': %s_low is more than rounding leaves of %s; set it to 0", kind, name,
                      field, field);
}

static int refuse_link(const tfa_link *link, const char *what, tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, link->line, "bad-number",
                      "link '%s': its %s is not finite; correct it", link->name, what);
}

static int check_link(const tfa_link *link, tfa_report *report)
{
    if (!isfinite(link->mass))
        return refuse_link(link, "mass", report);
    if (!all_finite(link->com, 3))
        return refuse_link(link, "centre of mass", report);
    if (!all_finite(link->inertia, 6))
        return refuse_link(link, "inertia", report);
    if (!is_valid_quaternion(link->quat))
        return TFA_REFUSE(report, TFA_E_MODEL, link->line, "bad-quaternion",
                          "link '%s': quaternion %g %g %g %g of its inertia is no rotation; give 0 "
                          "0 0 1 for none",
                          link->name, link->quat[0], link->quat[1], link->quat[2], link->quat[3]);
    if (!is_rounding_remainder(link->quat, link->quat_low, 4))
        return refuse_low("link", link->name, link->line, "quat", report);
    if (link->mass < 0)
        return TFA_REFUSE(report, TFA_E_MODEL, link->line, "negative-mass",
                          "link '%s': mass %g kg is negative; correct it", link->name, link->mass);
    return TFA_OK;
}

/* The armature in use; an unused one is not checked. */
static int check_armature(const tfa_joint *joint, int with_rotor, tfa_report *report)
{
    const double a = joint->armature + (with_rotor ? joint->rotor : 0);
    if (joint->type == TFA_JOINT_FIXED || (isfinite(a) && a >= 0))
        return TFA_OK;
    return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "bad-armature",
                      "joint '%s': armature %g must be finite and not negative; correct it",
                      joint->name, a);
}

/* 1: its axis matters. An axis without direction is refused when it is used. */
static int has_axis(const tfa_joint *joint)
{
    return joint->type != TFA_JOINT_FIXED && tfa_joint_type_describe(joint->type).quaternion < 0 &&
           all_finite(joint->axis, 3);
}

static int check_joint(const tfa_joint *joint, const tfa_model_options *options, tfa_report *report)
{
    if (joint->type != TFA_JOINT_FIXED && joint_type_of(joint->type) == JOINT_TYPES)
        return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "bad-type",
                          "joint '%s': type %d does not exist; use one of tfa_joint_type",
                          joint->name, (int)joint->type);
    if (!all_finite(joint->xyz, 3))
        return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "bad-number",
                          "joint '%s': its origin %g %g %g is not finite; correct it", joint->name,
                          joint->xyz[0], joint->xyz[1], joint->xyz[2]);
    if (!is_valid_quaternion(joint->quat))
        return TFA_REFUSE(
            report, TFA_E_MODEL, joint->line, "bad-quaternion",
            "joint '%s': quaternion %g %g %g %g is no rotation; give 0 0 0 1 for none", joint->name,
            joint->quat[0], joint->quat[1], joint->quat[2], joint->quat[3]);
    if (!is_rounding_remainder(joint->quat, joint->quat_low, 4))
        return refuse_low("joint", joint->name, joint->line, "quat", report);
    if (has_axis(joint) && !is_rounding_remainder(joint->axis, joint->axis_low, 3))
        return refuse_low("joint", joint->name, joint->line, "axis", report);
    if (options->damping && !isfinite(joint->damping))
        return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "bad-number",
                          "joint '%s': its damping is not finite; correct it", joint->name);
    if (options->friction && !isfinite(joint->friction))
        return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "bad-number",
                          "joint '%s': its friction is not finite; correct it", joint->name);
    return check_armature(joint, options->rotor_inertia != 0, report);
}

int tfa_draft_values(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    int status = TFA_OK;
    for (size_t k = 0; k < s->link_count; k++)
        if (check_link(&s->links[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    for (size_t j = 0; j < s->joint_count; j++)
        if (check_joint(&s->joints[j], d->options, report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}
