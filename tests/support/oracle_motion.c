/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of the oracle's links, as an observer who stands in the world sees it: classical
 * velocities and accelerations, no spatial vectors.
 */
#include "oracle_motion.h"

/* Axes of a planar joint: z the normal; x the coordinate axis that follows the normal's largest
 * component, made perpendicular; y completes them. */
static mat3 plane_axes(vec3 normal)
{
    int k = 0;
    for (int i = 1; i < 3; i++) {
        quad a = normal.x[i] < 0 ? -normal.x[i] : normal.x[i];
        quad b = normal.x[k] < 0 ? -normal.x[k] : normal.x[k];
        k = a > b ? i : k;
    }
    vec3 e = {{0, 0, 0}};
    e.x[(k + 1) % 3] = 1;
    vec3 x = vec_unit(vec_sub(e, vec_scale(vec_dot(e, normal), normal)));
    return (mat3){{x, vec_cross(normal, x), normal}};
}

/* Six freedoms in the child's own axes at its own origin, linear first. */
static void free_motion(struct freedom *f, const mat3 *R)
{
    for (int i = 0; i < 3; i++) {
        f[i].linear = R->col[i];
        f[i].angular = (vec3){{0, 0, 0}};
        f[3 + i].linear = (vec3){{0, 0, 0}};
        f[3 + i].angular = R->col[i];
    }
}

/* Moves the link from its joint's frame (already in b->R, b->p) by the joint's coordinates and
 * sets the joint's freedoms, all but `at`. */
static void move_joint(const oracle *o, struct body *b, struct freedom *f, const tfa_joint *j,
                       const double *q)
{
    mat3 at_rest = b->R;
    if (j->type == TFA_JOINT_FIXED)
        return;
    if (j->type == TFA_JOINT_FLOATING) {
        mat3 turn = mat_from_quaternion(q + 3);
        b->p = vec_add(b->p, mat_apply(&at_rest, vec_from(q)));
        b->R = mat_mul(&at_rest, &turn);
        free_motion(f, &b->R);
        return;
    }
    vec3 axis = vec_unit(o->text ? o->text->axis[b->joint] : vec_from_parts(j->axis, j->axis_low));
    vec3 zero = {{0, 0, 0}}, axis_world = mat_apply(&at_rest, axis);
    if (j->type == TFA_JOINT_PRISMATIC) {
        b->p = vec_add(b->p, vec_scale(q[0], axis_world));
        f[0].linear = axis_world;
        f[0].angular = zero;
        return;
    }
    int planar = j->type == TFA_JOINT_PLANAR;
    mat3 turn = mat_about_axis(axis, q[planar ? 2 : 0]);
    b->R = mat_mul(&at_rest, &turn);
    f[planar ? 2 : 0].linear = zero;
    f[planar ? 2 : 0].angular = axis_world;
    if (!planar)
        return;
    mat3 plane = plane_axes(axis);
    vec3 shift = mat_apply(&plane, (vec3){{q[0], q[1], 0}});
    b->p = vec_add(b->p, mat_apply(&at_rest, shift));
    for (int i = 0; i < 2; i++) {
        f[i].linear = mat_apply(&b->R, plane.col[i]);
        f[i].angular = zero;
    }
}

/* Classical relative motion: parent to child through `b`'s joint. NULL parent: the world. */
static void velocity_and_acceleration(struct body *b, const struct body *parent,
                                      const struct freedom *f, const quad *v, int child_axes)
{
    static const struct body world;
    vec3 u = {{0, 0, 0}}, w_rel = {{0, 0, 0}};
    if (!parent)
        parent = &world;
    for (uint32_t i = 0; i < b->freedoms; i++) {
        u = vec_add(u, vec_scale(v[i], f[i].linear));
        w_rel = vec_add(w_rel, vec_scale(v[i], f[i].angular));
    }
    vec3 d = vec_sub(b->p, parent->p);
    vec3 d_dot = vec_add(vec_cross(parent->w, d), u);
    b->w = vec_add(parent->w, w_rel);
    b->v = vec_add(parent->v, d_dot);
    b->alpha = vec_add(parent->alpha, vec_cross(parent->w, w_rel));
    /* u keeps its components in the axes of the child or of the parent */
    vec3 u_dot = vec_cross(child_axes ? b->w : parent->w, u);
    vec3 turning = vec_add(vec_cross(parent->alpha, d), vec_cross(parent->w, d_dot));
    b->a = vec_add(parent->a, vec_add(turning, u_dot));
}

void oracle_mass_properties(struct body *b, const tfa_link *link, const mat3 *turn)
{
    const double *i = link->inertia;
    mat3 I = {{{{i[0], i[1], i[2]}}, {{i[1], i[3], i[4]}}, {{i[2], i[4], i[5]}}}};
    mat3 axes = mat_mul(&b->R, turn);
    mat3 axes_t = mat_transposed(&axes);
    mat3 RI = mat_mul(&axes, &I);
    b->I = mat_mul(&RI, &axes_t);
    vec3 arm = mat_apply(&b->R, vec_from(link->com));
    vec3 spin = vec_cross(b->w, arm);
    b->com = vec_add(b->p, arm);
    b->v_com = vec_add(b->v, spin);
    b->a_com = vec_add(b->a, vec_add(vec_cross(b->alpha, arm), vec_cross(b->w, spin)));
}

void oracle_move_links(oracle *o, const double *q, const double *base_pose)
{
    const tfa_description *d = o->description;
    for (size_t k = 0; k < d->link_count; k++) {
        uint32_t link = o->order[k];
        struct body *b = &o->body[link], *parent = NULL;
        const tfa_joint *j = joint_above(o, b);
        struct freedom *f = &o->freedom[b->freedom];
        b->R = mat_identity();
        b->p = (vec3){{0, 0, 0}};
        if (j) {
            parent = &o->body[j->parent];
            mat3 turn = o->text ? o->text->joint[b->joint]
                                : mat_from_quaternion_parts(j->quat, j->quat_low);
            b->R = mat_mul(&parent->R, &turn);
            b->p = vec_add(parent->p, mat_apply(&parent->R, vec_from(j->xyz)));
            move_joint(o, b, f, j, q + b->q);
        } else if (o->base) {
            if (base_pose) {
                b->R = mat_from_quaternion(base_pose + 3);
                b->p = vec_from(base_pose);
            }
            free_motion(f, &b->R);
        }
        for (uint32_t i = 0; i < b->freedoms; i++)
            f[i].at = b->p;
        velocity_and_acceleration(b, parent, f, o->v + b->freedom,
                                  !j || j->type == TFA_JOINT_PLANAR ||
                                      j->type == TFA_JOINT_FLOATING);
        const tfa_link *l = &d->links[link];
        mat3 turn = o->text ? o->text->link[link] : mat_from_quaternion_parts(l->quat, l->quat_low);
        oracle_mass_properties(b, l, &turn);
    }
}
