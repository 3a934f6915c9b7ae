/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Wrenches of a request as forces of the joints, J^T w: what they do to accelerations and forces is
 * linear, so that the recursions know nothing of them and every algorithm takes them. A loop over
 * the bodies between the wrenches and the world, with constants read at run time: written out it
 * would be as long as the recursions.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_WRENCHES_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_WRENCHES_H

#include "dynamics/specialised/specialised_forward.h"

/* Poses of the bodies that feel a wrench, and the sum of what each feels, in its coordinates. No
 * struct state: with indices that are not constant all of it would lie on the stack. */
struct wrench_sums {
    uint8_t feels[ROBOT_BODIES];
    xform X[ROBOT_BODIES];
    svec f[ROBOT_BODIES];
};

/* As pose_body: joints of a specialised robot have one freedom each, but for the base. */
TFA_INLINE xform loaded_xform(const struct robot_inputs *in, const body_constants *b)
{
    if (ROBOT_BASE && b->base)
        return (xform){
            m3_mm(rotation_from_quaternion(in->base + 3), body_E(b)),
            v3_add(body_r(b), m3_tmul(body_E(b), v3(in->base[0], in->base[1], in->base[2])))};
    if (is_revolute(b->kind))
        return revolute_xform(body_E(b), body_r(b), in->sine[b->q], in->cosine[b->q]);
    return prismatic_xform(body_E(b), body_r(b), in->angle[b->q]);
}

/* Bodies from `body` to the world, the last one first. Returns how many there are. */
TFA_INLINE int path_to_world(struct wrench_sums *sums, const struct robot_inputs *in, int32_t body,
                             uint32_t path[ROBOT_BODIES])
{
    int count = 0;
    for (int32_t i = body; i >= 0; i = robot_body[i].parent) {
        path[count++] = (uint32_t)i;
        if (sums->feels[i])
            continue;
        sums->feels[i] = 1;
        sums->X[i] = loaded_xform(in, &robot_body[i]);
        sums->f[i] = sv_zero();
    }
    return count;
}

/* Adds wrench w, six numbers in the axes that were asked for, where it acts, as add_wrench of
 * load_changes.c. */
TFA_INLINE void add_wrench(struct wrench_sums *sums, const struct robot_inputs *in,
                           const struct tfa_frame *frame, tfa_reference_frame mode, const num *w)
{
    uint32_t path[ROBOT_BODIES];
    if (frame->body < 0)
        return;
    svec f = {v3(w[3], w[4], w[5]), v3(w[0], w[1], w[2])};
    const int count = path_to_world(sums, in, frame->body, path);
    if (mode == TFA_FRAME_LOCAL) {
        const mat3 R = m3_load(frame->R);
        f = (svec){m3_mul(R, f.w), m3_mul(R, f.v)};
    }
    for (int k = count; mode != TFA_FRAME_LOCAL && k-- > 0;) {
        const xform *X = &sums->X[path[k]];
        if (mode == TFA_FRAME_WORLD) /* about the origin of the next frame */
            f.w = v3_sub(f.w, v3_cross(X->r, f.v));
        f = (svec){m3_mul(X->E, f.w), m3_mul(X->E, f.v)};
    }
    if (mode != TFA_FRAME_WORLD)
        f.w = v3_add(f.w, v3_cross(v3_load(frame->p), f.v));
    sums->f[frame->body] = sv_add(sums->f[frame->body], f);
}

static __attribute__((noinline)) void
wrench_forces(num x[ROBOT_UNIT_FREEDOMS], const struct robot_inputs *in,
              const struct tfa_host_api *host, const tfa_request *r, const struct lane_states *at)
{
    struct wrench_sums sums;
    num w[6];
    memset(sums.feels, 0, sizeof sums.feels);
    for (uint32_t k = 0; k < r->wrench_count; k++) {
        gather_numbers(w, at, r->wrenches + 6 * (size_t)k, 6 * (size_t)r->wrench_count, 0, 6);
        add_wrench(&sums, in, &host->model->frame[r->wrench_frames[k]], r->frame, w);
    }
    for (uint32_t i = ROBOT_BODIES; i-- > 0;) {
        const body_constants *b = &robot_body[i];
        const svec f = sums.feels[i] ? sums.f[i] : sv_zero();
        if (ROBOT_BASE && b->base)
            base_force(f, x + b->v);
        else
            x[b->v] = is_revolute(b->kind) ? f.w.z : f.v.z;
        if (sums.feels[i] && b->parent >= 0)
            sums.f[b->parent] = sv_add(sums.f[b->parent], xform_t_force(&sums.X[i], f));
    }
}

#endif
