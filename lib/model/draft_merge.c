/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Links become bodies: fixed joints merged, frames turned so that joint axes are z, inertias
 * summed about the joint. All of it in extended precision, rounded to double once at the end.
 */
#include <math.h>
#include <string.h>

#include "model/draft.h"

/* c = a b, row major; c may not be a or b */
static void mul(ext *c, const ext *a, const ext *b)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

static void transpose(ext *t, const ext *a)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            t[3 * i + j] = a[3 * j + i];
}

/* y = a x + b */
static void apply(ext *y, const ext *a, const ext *x, const ext *b)
{
    for (int i = 0; i < 3; i++)
        y[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2] + b[i];
}

/* Rotation matrix (child axes to parent axes) of a quaternion x y z w, normalised here. */
static void rotation(ext *R, const double quat[4])
{
    ext x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    ext s = 2 / (x * x + y * y + z * z + w * w);
    ext m[9] = {1 - s * (y * y + z * z), s * (x * y - w * z),     s * (x * z + w * y),
                s * (x * y + w * z),     1 - s * (x * x + z * z), s * (y * z - w * x),
                s * (x * z - w * y),     s * (y * z + w * x),     1 - s * (x * x + y * y)};
    memcpy(R, m, sizeof m);
}

/* Axes (columns) of the body frame in the joint frame: z along the joint axis. With the axis
 * along a coordinate axis e_k the others follow cyclically and every entry is 0 or +-1 exactly. */
static int alignment(ext *R, const double axis[3])
{
    ext a[3] = {axis[0], axis[1], axis[2]};
    ext norm = sqrtl(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(norm > 0) || !isfinite(norm))
        return TFA_E_MODEL;
    int k = 0;
    for (int i = 0; i < 3; i++) {
        a[i] /= norm;
        if (fabsl(a[i]) > fabsl(a[k]))
            k = i;
    }
    ext x[3] = {0, 0, 0};
    int e = (k + 1) % 3;
    for (int i = 0; i < 3; i++)
        x[i] = (i == e) - a[i] * a[e];
    norm = sqrtl(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int i = 0; i < 3; i++)
        x[i] /= norm;
    ext y[3] = {a[1] * x[2] - a[2] * x[1], a[2] * x[0] - a[0] * x[2], a[0] * x[1] - a[1] * x[0]};
    for (int i = 0; i < 3; i++) {
        R[3 * i] = x[i];
        R[3 * i + 1] = y[i];
        R[3 * i + 2] = a[i];
    }
    return TFA_OK;
}

/* Adds a link's inertia to its body, about the body's origin. f: the link's frame in the body. */
static void add_inertia(struct draft_body *b, const tfa_link *link, const struct draft_frame *f)
{
    int empty = link->mass == 0;
    for (int k = 0; k < 6; k++)
        empty &= link->inertia[k] == 0;
    if (empty)
        return;
    ext Q[9], R[9], Rt[9], t[9], I[9];
    rotation(Q, link->quat);
    mul(R, f->R, Q);
    const double *s = link->inertia;
    const ext Ic[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
    mul(t, R, Ic);
    transpose(Rt, R);
    mul(I, t, Rt);
    const ext com[3] = {link->com[0], link->com[1], link->com[2]};
    ext c[3], m = link->mass;
    apply(c, f->R, com, f->p);
    ext cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    static const int row[6] = {0, 0, 0, 1, 1, 2}, col[6] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; k++) {
        int i = row[k], j = col[k];
        b->I[k] += (I[3 * i + j] + I[3 * j + i]) / 2 + m * ((i == j ? cc : 0) - c[i] * c[j]);
    }
    b->mass += m;
    for (int i = 0; i < 3; i++)
        b->h[i] += m * c[i];
}

static struct draft_body *new_body(struct draft *d, uint32_t link, int32_t joint, uint8_t kind)
{
    static const uint8_t freedoms[] = {1, 1, 3, 6};
    struct draft_body *b = &d->body[d->bodies++];
    memset(b, 0, sizeof *b);
    b->link = link;
    b->joint = joint;
    b->kind = kind;
    b->n = freedoms[kind];
    b->E[0] = b->E[4] = b->E[8] = 1;
    return b;
}

static uint8_t kind_of(tfa_joint_type type)
{
    switch (type) {
    case TFA_JOINT_PRISMATIC:
        return TFA_KIND_PRISMATIC;
    case TFA_JOINT_PLANAR:
        return TFA_KIND_PLANAR;
    case TFA_JOINT_FLOATING:
        return TFA_KIND_FREE;
    default:
        return TFA_KIND_REVOLUTE;
    }
}

/* The child link of a fixed joint is a frame on the parent's body. */
static void merge_fixed(struct draft *d, const tfa_joint *joint)
{
    const struct draft_frame *up = &d->frame[joint->parent];
    struct draft_frame *f = &d->frame[joint->child];
    const ext xyz[3] = {joint->xyz[0], joint->xyz[1], joint->xyz[2]};
    ext R[9];
    rotation(R, joint->quat);
    f->body = up->body;
    mul(f->R, up->R, R);
    apply(f->p, up->R, xyz, up->p);
}

/* The child link of a moving joint starts a body whose z axis is the joint's. */
static int add_moving(struct draft *d, uint32_t j, int with_rotor, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    const struct draft_frame *up = &d->frame[joint->parent];
    struct draft_frame *f = &d->frame[joint->child];
    ext align[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (joint->type != TFA_JOINT_FLOATING && alignment(align, joint->axis) != TFA_OK) {
        tfa_report_add(report, TFA_ERROR, joint->line, "zero-axis",
                       "joint '%s': axis %g %g %g has no direction; give it a unit vector",
                       joint->name, joint->axis[0], joint->axis[1], joint->axis[2]);
        return TFA_E_MODEL;
    }
    struct draft_body *b = new_body(d, joint->child, (int32_t)j, kind_of(joint->type));
    ext Rj[9], upj[9], axes[9];
    rotation(Rj, joint->quat);
    mul(upj, up->R, Rj);
    mul(axes, upj, align); /* body axes in the parent body's axes */
    transpose(b->E, axes);
    const ext xyz[3] = {joint->xyz[0], joint->xyz[1], joint->xyz[2]};
    apply(b->r, up->R, xyz, up->p);
    b->parent = up->body;
    b->armature = joint->armature + (with_rotor ? joint->rotor : 0);
    d->joint_body[j] = d->bodies - 1;
    d->movable++;
    f->body = (int32_t)(d->bodies - 1);
    transpose(f->R, align); /* link axes (those of the joint) to body axes */
    memset(f->p, 0, sizeof f->p);
    return TFA_OK;
}

/* Rotors that the file states and nobody asked for deserve a note. */
static void note_rotors(const tfa_description *s, tfa_report *report)
{
    size_t count = 0;
    for (size_t j = 0; j < s->joint_count; j++)
        count += s->joints[j].type != TFA_JOINT_FIXED && s->joints[j].rotor != 0;
    if (count)
        tfa_report_add(report, TFA_NOTE, 0, "rotor-inertia",
                       "rotor inertia in the file: not used, on %zu of its joints; ask for it if "
                       "the motors reflect it",
                       count);
}

int tfa_draft_merge(struct draft *d, const tfa_model_options *options, tfa_report *report)
{
    const tfa_base base = options ? options->base : TFA_BASE_FIXED;
    const int with_rotor = options && options->rotor_inertia;
    const tfa_description *s = d->description;
    struct draft_frame *root = &d->frame[d->root];
    if (!with_rotor)
        note_rotors(s, report);
    memset(root, 0, sizeof *root);
    root->R[0] = root->R[4] = root->R[8] = 1;
    root->body = -1;
    if (base == TFA_BASE_FLOATING) {
        struct draft_body *b = new_body(d, d->root, -1, TFA_KIND_FREE);
        b->parent = -1;
        b->base = 1;
        root->body = 0;
    }
    for (size_t k = 0; k < s->joint_count; k++) {
        uint32_t j = d->order[k];
        if (s->joints[j].type == TFA_JOINT_FIXED) {
            merge_fixed(d, &s->joints[j]);
            continue;
        }
        int status = add_moving(d, j, with_rotor, report);
        if (status != TFA_OK)
            return status;
    }
    for (size_t k = 0; k < s->link_count; k++)
        if (d->frame[k].body >= 0)
            add_inertia(&d->body[d->frame[k].body], &s->links[k], &d->frame[k]);
    return TFA_OK;
}
