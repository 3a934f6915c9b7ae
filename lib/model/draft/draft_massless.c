/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints that move no mass, and links without <inertial>.
 */
#include <stdio.h>
#include <stdlib.h>

#include "model/draft/draft.h"

/* has_mass: the link or its subtree has mass, inertia or a payload. */
static void propagate_has_mass(struct draft *d)
{
    const tfa_description *s = d->description;
    for (size_t k = 0; k < s->link_count; k++) {
        struct draft_link *link = &d->link[k];
        const long double *I = link->inertia;
        link->has_mass =
            link->present && (s->links[k].mass > 0 || I[0] + I[3] + I[5] > 0 || link->loaded);
    }
    for (size_t k = s->joint_count; k-- > 0;) {
        const tfa_joint *joint = &s->joints[d->order[k]];
        if (d->joint[d->order[k]].fate != TFA_FATE_ABSENT)
            d->link[joint->parent].has_mass |= d->link[joint->child].has_mass;
    }
}

/* moves_mass[j]: joint j or one of its followers moves mass or an armature. */
static void find_moving_mass(const struct draft *d, uint8_t *moves_mass)
{
    const tfa_description *s = d->description;
    for (size_t j = 0; j < s->joint_count; j++) {
        if (!draft_moves(d, j) ||
            !(d->link[s->joints[j].child].has_mass || draft_armature(d, j) > 0))
            continue;
        moves_mass[d->joint[j].fate == TFA_FATE_FOLLOWS ? (size_t)d->joint[j].leader : j] = 1;
    }
}

/* Locks a joint at 0. */
static void lock_at_zero(struct draft *d, size_t j, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    d->joint[j].fate = TFA_FATE_LOCKED;
    const int32_t quaternion = tfa_joint_type_describe(joint->type).quaternion;
    if (quaternion >= 0)
        d->joint[j].q[quaternion + 3] = 1;
    tfa_report_add_grouped(report, TFA_WARNING, joint->line, "massless-leaf-locked", "joints",
                           joint->name, "joint '%s': nothing with mass moves with it; locked at 0",
                           joint->name);
}

static void refuse(const struct draft *d, size_t j, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    tfa_report_add_grouped(
        report, TFA_ERROR, joint->line, "massless-leaf", "joints", joint->name,
        "joint '%s': nothing with mass moves with it, so the mass matrix is singular; lock it (%s "
        "locks all of them), make it fixed, or give link '%s' mass or the joint armature",
        joint->name, tfa_option_text(report, TFA_OPTION_LOCK_LEAVES),
        d->description->links[joint->child].name);
}

/* Locks the followers of locked joints. */
static void lock_followers(struct draft *d)
{
    for (size_t j = 0; j < d->description->joint_count; j++) {
        struct draft_joint *joint = &d->joint[j];
        if (joint->fate != TFA_FATE_FOLLOWS || d->joint[joint->leader].fate != TFA_FATE_LOCKED)
            continue;
        joint->fate = TFA_FATE_LOCKED;
        joint->q[0] = joint->offset;
    }
}

int tfa_draft_leaves(struct draft *d, tfa_report *report)
{
    uint8_t *moves_mass = calloc(d->description->joint_count + 1, 1);
    if (!moves_mass)
        return TFA_E_MEMORY;
    int status = TFA_OK;
    propagate_has_mass(d);
    find_moving_mass(d, moves_mass);
    for (size_t k = 0; k < d->description->joint_count; k++) {
        const uint32_t j = d->order[k];
        if (d->joint[j].fate != TFA_FATE_MOVES || moves_mass[j])
            continue;
        if (d->options->lock_massless_leaves) {
            lock_at_zero(d, j, report);
        } else {
            refuse(d, j, report);
            status = TFA_E_NO_MASS;
        }
    }
    lock_followers(d);
    free(moves_mass);
    return status;
}

/* "joint 'a' and joint 'b'" or "joint 'a' to joint 'c'": the joints of a fused body that ends
 * at b */
static void name_joints(const struct draft *d, const struct draft_body *b, uint32_t row, char *text,
                        size_t size)
{
    const tfa_joint *joints = d->description->joints;
    const struct draft_body *first = b;
    for (uint32_t k = 1; k < row; k++)
        first = &d->body[first->parent];
    snprintf(text, size, "joint '%s' %s joint '%s'", joints[first->joint].name,
             row == 2 ? "and" : "to", joints[b->joint].name);
}

/* end: the fused body of `row` joints that it is part of, or NULL */
static void report_massless_link(const struct draft *d, const struct draft_body *body,
                                 const struct draft_body *end, uint32_t row, tfa_report *report)
{
    const tfa_link *link = &d->description->links[body->link];
    const int refused = d->options->inertia == TFA_INERTIA_STRICT_PHYSICAL;
    char joints[600], became[700] = "";
    if (end) {
        name_joints(d, end, row, joints, sizeof joints);
        snprintf(became, sizeof became, ": %s became one joint with %u freedoms", joints, row);
    }
    tfa_report_add_grouped(
        report, refused ? TFA_ERROR : TFA_WARNING, link->line, "massless-link", "links", link->name,
        "link '%s': moves by itself and has no <inertial>%s; add <inertial>%s%s%s", link->name,
        became, body->base ? "" : ", or make its joint fixed", refused ? ", or choose " : "",
        refused ? tfa_option_text(report, TFA_OPTION_INERTIA_STRICT) : "");
}

/* 1: a body without mass, payload and <inertial> */
static int lacks_inertial(const struct draft *d, const struct draft_body *b)
{
    return b->sum.mass == 0 && b->sum.I[0] + b->sum.I[3] + b->sum.I[5] == 0 && !b->loaded &&
           !d->description->links[b->link].inertial;
}

int tfa_draft_check_massless(const struct draft *d, const uint32_t *next, tfa_report *report)
{
    int found = 0;
    for (uint32_t i = 0; i < d->bodies; i++) {
        uint32_t end = i, row = 1;
        if (!lacks_inertial(d, &d->body[i]))
            continue;
        while (next[end])
            end = next[end];
        for (int32_t up = d->body[end].parent; up >= 0 && next[up]; up = d->body[up].parent)
            row++;
        report_massless_link(d, &d->body[i], row > 1 ? &d->body[end] : NULL, row, report);
        found = 1;
    }
    return found && d->options->inertia == TFA_INERTIA_STRICT_PHYSICAL ? TFA_E_MODEL : TFA_OK;
}

/* 1: the floating base has inertia, or two joints or an armature constrain it */
static int base_is_constrained(const struct draft *d)
{
    const struct draft_body *b = &d->body[0];
    uint32_t children = 0;
    if (b->sum.mass > 0 || b->sum.I[0] + b->sum.I[3] + b->sum.I[5] > 0 || b->loaded)
        return 1;
    for (uint32_t i = 1; i < d->bodies; i++) {
        if (d->body[i].parent != 0 || !d->link[d->body[i].link].has_mass)
            continue;
        children++;
        if (d->body[i].armature > 0)
            return 1;
    }
    return children >= 2;
}

int tfa_draft_base(struct draft *d, tfa_report *report)
{
    if (d->options->base != TFA_BASE_FLOATING || base_is_constrained(d))
        return TFA_OK;
    const tfa_link *root = &d->description->links[d->root];
    return TFA_REFUSE(report, TFA_E_NO_MASS, root->line, "massless-root",
                      "link '%s': the floating base has no mass, and no two joints hold it, so the "
                      "mass matrix is singular; give it mass, make its joint fixed, or let the "
                      "link that has the mass be the root",
                      root->name);
}
