/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints that the scene locks.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/text.h>

#include "model/draft/draft.h"

static int refuse(const tfa_lock *lock, const char *what, tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-lock", "joint '%s': %s",
                      lock->joint ? lock->joint : "(none)", what);
}

static int32_t find_joint(const struct draft *d, const char *name)
{
    for (size_t j = 0; name && j < d->description->joint_count; j++)
        if (strcmp(d->description->joints[j].name, name) == 0)
            return (int32_t)j;
    return -1;
}

static const char *joint_name(const void *description, size_t index)
{
    return ((const tfa_description *)description)->joints[index].name;
}

static int refuse_unknown(const struct draft *d, const tfa_lock *lock, tfa_report *report)
{
    char suggestions[200], what[320];
    tfa_suggest(lock->joint ? lock->joint : "", d->description, d->description->joint_count,
                joint_name, suggestions, sizeof suggestions);
    snprintf(what, sizeof what,
             "the scene locks it, but the robot has no such joint; correct the name; nearest: %s",
             suggestions);
    return refuse(lock, what, report);
}

/* What is wrong with the coordinates, or NULL. */
static const char *fault(const tfa_lock *lock, tfa_joint_type type)
{
    for (int k = 0; k < draft_coordinates[type]; k++)
        if (!isfinite(lock->q[k]))
            return "the scene locks it at a coordinate that is not finite; correct it";
    const double *o = lock->q + 3;
    if (type == TFA_JOINT_FLOATING &&
        !(fabs(sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2] + o[3] * o[3]) - 1) <= 1e-3))
        return "the scene locks it at a quaternion whose norm is off from 1 by more than 1e-3; "
               "correct it (x y z, then x y z w)";
    return NULL;
}

static int lock_joint(struct draft *d, const tfa_lock *lock, tfa_report *report)
{
    int32_t j = find_joint(d, lock->joint);
    if (j < 0)
        return refuse_unknown(d, lock, report);
    struct draft_joint *joint = &d->joint[j];
    const tfa_joint_type type = d->description->joints[j].type;
    if (type == TFA_JOINT_FIXED)
        return refuse(lock, "the scene locks it, but it is fixed in the file; remove the lock",
                      report);
    if (joint->fate == TFA_FATE_LOCKED)
        return refuse(lock, "the scene locks it twice; remove one of the locks", report);
    const char *wrong = fault(lock, type);
    if (wrong)
        return refuse(lock, wrong, report);
    if (joint->fate == TFA_FATE_ABSENT) {
        tfa_report_add(report, TFA_NOTE, 0, "scene-lock",
                       "joint '%s': it is not part of the scene, its lock does nothing; remove it",
                       lock->joint);
        return TFA_OK;
    }
    joint->fate = TFA_FATE_LOCKED;
    ext_from_double(joint->q, lock->q, draft_coordinates[type]);
    return TFA_OK;
}

int tfa_draft_locks(struct draft *d, tfa_report *report)
{
    const tfa_scene *scene = d->options->scene;
    int status = TFA_OK;
    for (size_t k = 0; scene && k < scene->lock_count; k++)
        if (lock_joint(d, &scene->locks[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}
