/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mimic joints: resolution of chains, and the policy for followers.
 */
#include <math.h>
#include <stdlib.h>

#include "model/draft/draft.h"

static int mimics(const struct draft *d, size_t j)
{
    const tfa_joint *joint = &d->description->joints[j];
    return joint->mimic >= 0 && joint->type != TFA_JOINT_FIXED;
}

static int is_misnamed(const struct draft *d, size_t j)
{
    const tfa_joint *joint = &d->description->joints[j];
    return joint->mimic == TFA_MIMIC_UNKNOWN && joint->type != TFA_JOINT_FIXED;
}

static void warn_free(const struct draft *d, tfa_report *report)
{
    size_t count = 0;
    for (size_t j = 0; j < d->description->joint_count; j++)
        count += mimics(d, j) && d->joint[j].fate == TFA_FATE_MOVES;
    if (count)
        tfa_report_add(report, TFA_WARNING, 0, "mimic-free",
                       "robot: joints that mimic others move on their own here: %zu; choose %s to "
                       "have them follow, or %s",
                       count, tfa_option_text(report, TFA_OPTION_MIMIC_PROJECT),
                       tfa_option_text(report, TFA_OPTION_MIMIC_LOCK));
}

static int has_one_freedom(const tfa_joint *joint)
{
    return tfa_joint_type_describe(joint->type).freedoms == 1;
}

/* The URDF front end checks files; this checks descriptions made by a program. */
static int check_mimic(const struct draft *d, size_t j, tfa_report *report)
{
    const tfa_description *s = d->description;
    const tfa_joint *joint = &s->joints[j];
    const char *wrong = NULL, *code = "mimic-type";
    if ((size_t)joint->mimic >= s->joint_count) {
        code = "mimic-unknown";
        wrong = "mimics a joint that does not exist; correct its name or index, or let it move by "
                "itself";
    } else if (!has_one_freedom(joint)) {
        wrong = "only a joint with one freedom can follow another; let it move by itself";
    } else if (!has_one_freedom(&s->joints[joint->mimic])) {
        wrong = "mimics a joint that has no single coordinate; follow a revolute, continuous or "
                "prismatic joint";
    } else if (!isfinite(joint->multiplier) || !isfinite(joint->offset)) {
        code = "bad-number";
        wrong = "the multiplier or the offset of its mimic is not finite; correct it";
    }
    if (!wrong)
        return TFA_OK;
    return TFA_REFUSE(report, TFA_E_MODEL, joint->line, code, "joint '%s': %s", joint->name, wrong);
}

/* 1: the chain of mimics ends here: the joint follows none, or the scene locks it */
static int chain_ends(const struct draft *d, size_t j)
{
    return !mimics(d, j) || d->joint[j].fate == TFA_FATE_LOCKED;
}

/* Finds the leader of j and of all joints on the way. `path` is scratch. */
static int resolve(struct draft *d, uint32_t j, uint32_t *path, tfa_report *report)
{
    const tfa_description *s = d->description;
    size_t length = 0;
    uint32_t k = j;
    do {
        if (length == s->joint_count)
            return TFA_REFUSE(
                report, TFA_E_MODEL, s->joints[k].line, "mimic-loop",
                "joint '%s': in the end it mimics itself; let one of the joints move by itself",
                s->joints[k].name);
        path[length++] = k;
        k = (uint32_t)s->joints[k].mimic;
    } while (!chain_ends(d, k) && d->joint[k].leader < 0);
    while (length > 0) {
        struct draft_joint *follower = &d->joint[path[--length]];
        const tfa_joint *stated = &s->joints[path[length]];
        const struct draft_joint *up = &d->joint[k];
        const int last = chain_ends(d, k);
        follower->leader = last ? (int32_t)k : up->leader;
        follower->multiplier = stated->multiplier * (last ? 1 : up->multiplier);
        follower->offset = stated->offset + stated->multiplier * (last ? 0 : up->offset);
        k = path[length];
    }
    return TFA_OK;
}

/* Checks that a locked follower agrees with its leader. */
static int check_locked(const struct draft *d, uint32_t j, tfa_report *report)
{
    const struct draft_joint *follower = &d->joint[j];
    const struct draft_joint *leader = &d->joint[follower->leader];
    const tfa_description *s = d->description;
    const char *name = s->joints[j].name, *of = s->joints[follower->leader].name;
    if (d->options->mimic != TFA_MIMIC_PROJECT || leader->fate == TFA_FATE_ABSENT)
        return TFA_OK;
    if (leader->fate != TFA_FATE_LOCKED && follower->multiplier != 0)
        return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-lock",
                          "joint '%s': the scene locks it, but it follows joint '%s', which is not "
                          "locked; lock that one",
                          name, of);
    ext q = follower->multiplier * leader->q[0] + follower->offset;
    if (ext_abs(follower->q[0] - q) <= 1e-9L * (1 + ext_abs(q)))
        return TFA_OK;
    return TFA_REFUSE(report, TFA_E_MODEL, 0, "scene-lock",
                      "joint '%s': the scene locks it at %Lg, but following joint '%s' it stands "
                      "at %Lg; remove its lock",
                      name, (long double)follower->q[0], of, (long double)q);
}

static int refuse_absent(const struct draft *d, uint32_t j, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    return TFA_REFUSE(report, TFA_E_MODEL, joint->line, "scene-root",
                      "joint '%s': it follows joint '%s', which does not hang from the root of the "
                      "scene; lock it, or choose another root",
                      joint->name, d->description->joints[d->joint[j].leader].name);
}

static int apply_policy(struct draft *d, uint32_t j, tfa_report *report)
{
    struct draft_joint *follower = &d->joint[j];
    const struct draft_joint *leader = &d->joint[follower->leader];
    if (follower->fate == TFA_FATE_LOCKED)
        return check_locked(d, j, report);
    if (follower->fate == TFA_FATE_ABSENT) {
        const int held = leader->fate != TFA_FATE_MOVES || d->options->mimic == TFA_MIMIC_LOCK;
        if (!held && follower->multiplier != 0)
            tfa_report_add(report, TFA_WARNING, d->description->joints[j].line, "scene-root",
                           "joint '%s': it follows joint '%s' but does not hang from the root of "
                           "the scene: what it moves is left out; choose another root",
                           d->description->joints[j].name,
                           d->description->joints[follower->leader].name);
        return TFA_OK;
    }
    const int locked = leader->fate == TFA_FATE_LOCKED;
    if (locked || follower->multiplier == 0 || d->options->mimic == TFA_MIMIC_LOCK) {
        follower->fate = TFA_FATE_LOCKED;
        follower->q[0] = follower->offset + (locked ? follower->multiplier * leader->q[0] : 0);
        return TFA_OK;
    }
    if (leader->fate == TFA_FATE_ABSENT)
        return refuse_absent(d, j, report);
    follower->fate = TFA_FATE_FOLLOWS;
    return TFA_OK;
}

static int resolve_all(struct draft *d, uint32_t *path, tfa_report *report)
{
    const size_t count = d->description->joint_count;
    int status = TFA_OK;
    for (size_t j = 0; j < count; j++)
        if ((mimics(d, j) || is_misnamed(d, j)) && check_mimic(d, j, report) != TFA_OK)
            status = TFA_E_MODEL;
    for (uint32_t j = 0; j < count && status == TFA_OK; j++)
        if (mimics(d, j) && d->joint[j].leader < 0)
            status = resolve(d, j, path, report);
    return status;
}

int tfa_draft_mimics(struct draft *d, tfa_report *report)
{
    const size_t count = d->description->joint_count;
    if (d->options->mimic == TFA_MIMIC_FREE) {
        warn_free(d, report);
        return TFA_OK;
    }
    uint32_t *path = malloc((count + 1) * sizeof *path);
    if (!path)
        return TFA_E_MEMORY;
    int resolved = resolve_all(d, path, report), status = resolved;
    free(path);
    for (uint32_t j = 0; j < count && resolved == TFA_OK; j++)
        if (d->joint[j].leader >= 0 && apply_policy(d, j, report) != TFA_OK)
            status = TFA_E_MODEL;
    return status;
}
