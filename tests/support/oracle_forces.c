/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle's forces across joints: what moves all links outboard, added up in world axes.
 */
#include "oracle_motion.h"
#include "oracle_operational.h"

static quad length(vec3 x)
{
    return quad_sqrt(vec_dot(x, x));
}

/* An acceleration, and the sizes of the terms that it is the sum of */
typedef struct motion {
    vec3 linear, angular;
    quad linear_terms, angular_terms;
} motion;

/* Adds what the point of a link that is now at `point` has beyond that of qdd = 0. */
static void accelerate(const oracle *o, uint32_t link, vec3 point, const quad *qdd, motion *a)
{
    for (;;) {
        const struct body *b = &o->body[link];
        for (uint32_t i = 0; i < b->freedoms; i++) {
            const struct freedom *f = &o->freedom[b->freedom + i];
            const oracle_tie *t = &o->tie[b->freedom + i];
            if (t->to == ORACLE_STILL)
                continue;
            const quad x = t->multiplier * qdd[t->to];
            const vec3 v = vec_add(f->linear, vec_cross(f->angular, vec_sub(point, f->at)));
            const vec3 linear = vec_scale(x, v), angular = vec_scale(x, f->angular);
            a->linear = vec_add(a->linear, linear);
            a->angular = vec_add(a->angular, angular);
            a->linear_terms += length(linear);
            a->angular_terms += length(angular);
        }
        if (b->joint < 0)
            return;
        link = o->description->joints[b->joint].parent;
    }
}

static void add(oracle_wrench *F, vec3 force, vec3 moment, vec3 arm, quad sign)
{
    F->force = vec_add(F->force, vec_scale(sign, force));
    F->moment = vec_add(F->moment, vec_scale(sign, vec_add(moment, vec_cross(arm, force))));
    F->size += (1 + length(arm)) * length(force) + length(moment);
}

/* d/dt of the momentum of a mass that moves with `link`, less its weight */
static void add_mass(const oracle *o, uint32_t link, const struct body *b, quad m, const quad *qdd,
                     oracle_wrench *F)
{
    const vec3 arm = vec_sub(b->com, o->body[link].p);
    motion a = {.linear = vec_sub(b->a_com, o->gravity), .angular = b->alpha};
    accelerate(o, link, b->com, qdd, &a);
    const vec3 spin = vec_add(mat_apply(&b->I, a.angular), vec_cross(b->w, mat_apply(&b->I, b->w)));
    const quad inertia = b->I.col[0].x[0] + b->I.col[1].x[1] + b->I.col[2].x[2];
    add(&F[link], vec_scale(m, a.linear), spin, arm, 1);
    F[link].size += (1 + length(arm)) * m * a.linear_terms + inertia * a.angular_terms;
}

static void subtract_wrench(const oracle *o, const tfa_request *r, uint32_t state, uint32_t w,
                            oracle_wrench *F)
{
    const uint32_t link = r->wrench_frames[w];
    const double *x = r->wrenches + ((size_t)state * r->wrench_count + w) * 6;
    const struct body *b = &o->body[link];
    vec3 force = vec_from(x), moment = vec_from(x + 3), arm = {{0, 0, 0}};
    if (r->frame == TFA_FRAME_LOCAL) {
        force = mat_apply(&b->R, force);
        moment = mat_apply(&b->R, moment);
    } else if (r->frame == TFA_FRAME_WORLD) {
        arm = vec_scale(-1, b->p);
    }
    add(&F[link], force, moment, arm, -1);
}

void oracle_joint_forces(const oracle *o, const tfa_request *r, uint32_t state, const quad *qdd,
                         const bool *absent, oracle_wrench *F)
{
    const tfa_description *d = o->description;
    for (size_t k = 0; k < d->link_count; k++)
        F[k] = (oracle_wrench){{{0, 0, 0}}, {{0, 0, 0}}, 0};
    for (uint32_t k = 0; k < d->link_count; k++)
        add_mass(o, k, &o->body[k], d->links[k].mass, qdd, F);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        const double *x = r->payloads + (size_t)k * TFA_PAYLOAD_NUMBERS;
        tfa_link load = {.mass = x[0], .com = {x[1], x[2], x[3]}, .quat = {0, 0, 0, 1}};
        for (int i = 0; i < 6; i++)
            load.inertia[i] = x[4 + i];
        struct body b = o->body[r->payload_frames[k]];
        const mat3 turn = mat_identity();
        oracle_mass_properties(&b, &load, &turn);
        add_mass(o, r->payload_frames[k], &b, load.mass, qdd, F);
    }
    for (uint32_t w = 0; w < r->wrench_count; w++)
        subtract_wrench(o, r, state, w, F);
    for (size_t k = d->link_count; k-- > 0;) {
        const uint32_t link = o->order[k];
        const tfa_joint *j = joint_above(o, &o->body[link]);
        if (!j || absent[link])
            continue;
        const quad size = F[j->parent].size + F[link].size;
        add(&F[j->parent], F[link].force, F[link].moment,
            vec_sub(o->body[link].p, o->body[j->parent].p), 1);
        if (F[j->parent].size < size)
            F[j->parent].size = size;
    }
}

void oracle_wrench_in(const oracle *o, uint32_t link, tfa_reference_frame frame,
                      const oracle_wrench *F, quad out[6])
{
    const struct body *b = &o->body[link];
    vec3 force = F->force, moment = F->moment;
    if (frame == TFA_FRAME_WORLD)
        moment = vec_add(moment, vec_cross(b->p, force));
    if (frame == TFA_FRAME_LOCAL) {
        force = mat_apply_transposed(&b->R, force);
        moment = mat_apply_transposed(&b->R, moment);
    }
    for (int e = 0; e < 3; e++) {
        out[e] = force.x[e];
        out[3 + e] = moment.x[e];
    }
}
