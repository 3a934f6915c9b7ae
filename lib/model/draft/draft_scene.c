/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scene: links and joints that are part of it, payloads, tips, rotors, locked and actuated
 * joints.
 */
#include <math.h>
#include <string.h>
#include <totalforce/text.h>

#include "model/draft/draft.h"
#include "model/payload.h"

int32_t tfa_draft_find_link(const struct draft *d, const char *name)
{
    for (size_t k = 0; name && k < d->description->link_count; k++)
        if (strcmp(d->description->links[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

static const char *link_name(const void *description, size_t index)
{
    return ((const tfa_description *)description)->links[index].name;
}

int tfa_draft_refuse_link(const struct draft *d, const char *code, const char *name,
                          const char *what, tfa_report *report)
{
    char suggestions[200];
    tfa_suggest(name ? name : "", d->description, d->description->link_count, link_name,
                suggestions, sizeof suggestions);
    return TFA_REFUSE(report, TFA_E_MODEL, 0, code, "link '%s': %s; nearest: %s",
                      name ? name : "(none)", what, suggestions);
}

int32_t tfa_draft_find_joint(const struct draft *d, const char *name)
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

int tfa_draft_refuse_joint(const struct draft *d, const char *code, const char *name,
                           const char *what, tfa_report *report)
{
    char suggestions[200];
    tfa_suggest(name ? name : "", d->description, d->description->joint_count, joint_name,
                suggestions, sizeof suggestions);
    return TFA_REFUSE(report, TFA_E_MODEL, 0, code, "joint '%s': %s; nearest: %s",
                      name ? name : "(none)", what, suggestions);
}

static const char *shown(const char *name)
{
    return name ? name : "(none)";
}

static int find_root(struct draft *d, const char *name, tfa_report *report)
{
    if (!name)
        return TFA_OK;
    int32_t link = tfa_draft_find_link(d, name);
    if (link < 0)
        return tfa_draft_refuse_link(
            d, "scene-root", name,
            "the root of the scene does not exist; name a link of the robot, or none for all of it",
            report);
    d->root = (uint32_t)link;
    return TFA_OK;
}

/* Marks the links and joints below the root as present. */
static void mark_present(struct draft *d)
{
    const tfa_description *s = d->description;
    d->link[d->root].present = 1;
    for (size_t k = 0; k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        const tfa_joint *joint = &s->joints[j];
        if (!d->link[joint->parent].present)
            d->joint[j].fate = TFA_FATE_ABSENT;
        else if (joint->type == TFA_JOINT_FIXED)
            d->joint[j].fate = TFA_FATE_FIXED;
        d->link[joint->child].present |= d->link[joint->parent].present;
    }
}

static int mark_tip(struct draft *d, const char *name, tfa_report *report)
{
    int32_t link = tfa_draft_find_link(d, name);
    if (link >= 0 && d->link[link].present) {
        d->link[link].tip = 1;
        return TFA_OK;
    }
    if (link < 0)
        return tfa_draft_refuse_link(
            d, "scene-tip", name, "the tip of the scene does not exist; name a link of the robot",
            report);
    return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-tip",
                      "link '%s': the tip of the scene does not hang from its root; choose another "
                      "tip or another root",
                      name);
}

static int mark_payload(struct draft *d, const tfa_payload *payload, tfa_report *report)
{
    int32_t link = tfa_draft_find_link(d, payload->link);
    const char *wrong = tfa_payload_error(payload);
    if (link < 0)
        return tfa_draft_refuse_link(
            d, "scene-payload", payload->link,
            "the payload is on a link that does not exist; name a link of the robot", report);
    if (wrong)
        return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-payload", "link '%s': the payload %s",
                          shown(payload->link), wrong);
    if (!d->link[link].present) {
        tfa_report_add(report, TFA_WARNING, 0, "scene-payload",
                       "link '%s': it is not part of the scene, its payload is left out; choose "
                       "another root, or remove the payload",
                       payload->link);
        return TFA_OK;
    }
    const double *I = payload->inertia;
    d->link[link].loaded |= payload->mass > 0 || I[0] + I[3] + I[5] > 0;
    return TFA_OK;
}

static int mount_rotor(struct draft *d, const tfa_rotor *rotor, tfa_report *report)
{
    static const char code[] = "scene-rotor";
    const int32_t j = tfa_draft_find_joint(d, rotor->joint);
    if (j < 0)
        return tfa_draft_refuse_joint(
            d, code, rotor->joint,
            "the scene has a rotor for it, but the robot has no such joint; correct the name",
            report);
    const tfa_joint *joint = &d->description->joints[j];
    const double reduction = joint->reduction != 0 ? joint->reduction : 1;
    if (d->joint[j].has_rotor)
        return TFA_REFUSE(report, TFA_E_MODEL, 0, code,
                          "joint '%s': the scene has two rotors for it; remove one", joint->name);
    d->joint[j].has_rotor = 1;
    d->joint[j].rotor = rotor->inertia * reduction * reduction;
    if (!(rotor->inertia >= 0) || !isfinite(draft_armature(d, (size_t)j)))
        return TFA_REFUSE(report, TFA_E_MODEL, 0, code,
                          "joint '%s': rotor inertia %g kg m^2 and reduction %g give no finite "
                          "armature that is not negative; correct them",
                          joint->name, rotor->inertia, reduction);
    if (joint->reduction == 0)
        tfa_report_add_grouped(report, TFA_NOTE, joint->line, "no-reduction", "joints", joint->name,
                               "joint '%s': the file has no reduction for its rotor, which counts "
                               "as turning with the joint",
                               joint->name);
    return TFA_OK;
}

int tfa_draft_scene(struct draft *d, tfa_report *report)
{
    static const tfa_scene whole = {0};
    const tfa_scene *scene = d->options->scene ? d->options->scene : &whole;
    int status = find_root(d, scene->root, report);
    if (status != TFA_OK)
        return status;
    mark_present(d);
    for (size_t k = 0; k < scene->tip_count; k++)
        if (mark_tip(d, scene->tips[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    for (size_t k = 0; k < scene->payload_count; k++)
        if (mark_payload(d, &scene->payloads[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    for (size_t k = 0; k < scene->rotor_count; k++)
        if (mount_rotor(d, &scene->rotors[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}

/* ---- locked joints ---- */

static int refuse_lock(const tfa_lock *lock, const char *what, tfa_report *report)
{
    return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-lock", "joint '%s': %s", shown(lock->joint),
                      what);
}

/* Error of the coordinates, for a message; NULL: none. */
static const char *fault(const tfa_lock *lock, tfa_joint_type type)
{
    const tfa_joint_type_info info = tfa_joint_type_describe(type);
    for (uint32_t k = 0; k < info.coordinates; k++)
        if (!isfinite(lock->q[k]))
            return "the scene locks it at a coordinate that is not finite; correct it";
    const double *o = lock->q + (info.quaternion >= 0 ? info.quaternion : 0);
    if (info.quaternion >= 0 &&
        !(fabs(sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2] + o[3] * o[3]) - 1) <= 1e-3))
        return "the scene locks it at a quaternion whose norm is off from 1 by more than 1e-3; "
               "correct it (x y z, then x y z w)";
    return NULL;
}

static int lock_joint(struct draft *d, const tfa_lock *lock, tfa_report *report)
{
    int32_t j = tfa_draft_find_joint(d, lock->joint);
    if (j < 0)
        return tfa_draft_refuse_joint(
            d, "scene-lock", lock->joint,
            "the scene locks it, but the robot has no such joint; correct the name", report);
    struct draft_joint *joint = &d->joint[j];
    const tfa_joint_type type = d->description->joints[j].type;
    if (type == TFA_JOINT_FIXED)
        return refuse_lock(lock, "the scene locks it, but it is fixed in the file; remove the lock",
                           report);
    if (joint->fate == TFA_FATE_LOCKED)
        return refuse_lock(lock, "the scene locks it twice; remove one of the locks", report);
    const char *wrong = fault(lock, type);
    if (wrong)
        return refuse_lock(lock, wrong, report);
    if (joint->fate == TFA_FATE_ABSENT) {
        tfa_report_add(report, TFA_NOTE, 0, "scene-lock",
                       "joint '%s': it is not part of the scene, its lock does nothing; remove it",
                       lock->joint);
        return TFA_OK;
    }
    joint->fate = TFA_FATE_LOCKED;
    ext_from_double(joint->q, lock->q, (int)tfa_joint_type_describe(type).coordinates);
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

/* ---- joints with a motor ---- */

static int mark_actuated(struct draft *d, const char *name, tfa_report *report)
{
    static const char code[] = "scene-actuated";
    static const char *const faults[] = {
        [TFA_FATE_FIXED] = "it is fixed in the file",
        [TFA_FATE_LOCKED] = "it is locked",
        [TFA_FATE_ABSENT] = "it is not part of the scene",
    };
    const int32_t j = tfa_draft_find_joint(d, name);
    if (j < 0)
        return tfa_draft_refuse_joint(
            d, code, name,
            "the scene says that it is actuated, but the robot has no such joint; correct the name",
            report);
    const uint8_t fate = d->joint[j].fate;
    if (!draft_moves(d, (size_t)j))
        return TFA_REFUSE(report, TFA_E_MODEL, 0, code,
                          "joint '%s': the scene says that it is actuated, but %s; remove it from "
                          "the actuated joints",
                          name, faults[fate]);
    d->joint[fate == TFA_FATE_FOLLOWS ? d->joint[j].leader : j].actuated = 1;
    return TFA_OK;
}

int tfa_draft_actuated(struct draft *d, tfa_report *report)
{
    const tfa_scene *scene = d->options->scene;
    int status = TFA_OK;
    for (size_t k = 0; scene && k < scene->actuated_count; k++)
        if (mark_actuated(d, scene->actuated[k], report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}
