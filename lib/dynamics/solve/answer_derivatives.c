/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of forward dynamics (Carpentier and Mansard, RSS 2018): with qdd = FD(q, v, tau),
 *
 *     dqdd/dtau = M^-1,   dqdd/dq = -M^-1 dID/dq,   dqdd/dv = -M^-1 dID/dv
 *
 * and those of inverse dynamics, dID/dq and dID/dv, at qdd of the request.
 */
#include <math.h>
#include <string.h>

#include "dynamics/core/recursions.h"
#include "dynamics/core/sentinel.h"
#include "dynamics/derivatives/blocks.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/kinematics/world_pose.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "spatial/rows.h"

/* Wrench `index` of the request in world axes about the reference point */
static svec world_wrench(const struct state *s, const tfa_request *r, uint32_t index,
                         const mat3 *axes, vec3 at)
{
    num x[6];
    for (size_t e = 0; e < 6; e++)
        x[e] = gather_states(s, r->wrenches, 6 * (size_t)r->wrench_count, 6 * (size_t)index + e);
    svec w = {v3(x[3], x[4], x[5]), v3(x[0], x[1], x[2])};
    if (axes)
        w = (svec){m3_mul(*axes, w.w), m3_mul(*axes, w.v)};
    w.w = v3_add(w.w, v3_cross(at, w.v));
    return w;
}

/* Wrenches of the request that do not follow their bodies rigidly. Returns how many. */
static uint32_t held_wrenches(const struct state *s, const tfa_request *r, vec3 origin,
                              struct held_wrench out[TFA_MAX_WRENCHES])
{
    uint32_t count = 0;
    for (uint32_t w = 0; w < r->wrench_count; w++) {
        const uint32_t frame = r->wrench_frames[w];
        struct held_wrench *held = &out[count];
        held->body = s->m->frame[frame].body;
        held->frame = r->frame;
        if (held->body < 0)
            continue;
        held->freedoms = TFA_V(frame_freedoms)(s, frame);
        if (r->frame == TFA_FRAME_LOCAL && held->freedoms == s->body[held->body].n)
            continue;
        const xform at = frame_in_body(s, frame);
        const struct world_pose *W = &s->world[held->body];
        const mat3 axes = axes_in_world(W, at.E);
        const vec3 p = vec3_of_simd(point_in_world(W, at.r));
        held->at = v3_sub(r->frame == TFA_FRAME_WORLD ? v3_zero() : p, origin);
        held->wrench = world_wrench(s, r, w, r->frame == TFA_FRAME_LOCAL ? &axes : NULL, held->at);
        count++;
    }
    return count;
}

/* ---- the blocks asked ---- */

/* Those of the request, and s->public_row */
static struct blocks blocks_of_state(struct state *s, double *const matrices[BLOCKS])
{
    for (uint32_t j = 0; j < s->freedoms; j++) {
        num multiplier;
        s->public_row[j] = TFA_V(reduced_freedom)(s->m, j, &multiplier);
    }
    return clear_blocks(matrices, s->derivatives, (size_t)s->m->base_freedoms + s->m->v_count);
}

/* One column with the factors of a method: a force on a public freedom is its leader's, and so is
 * the acceleration. */
static void solve_column(struct state *s, tfa_method method, num *X, size_t stride)
{
    num multiplier;
    for (uint32_t j = 0; j < s->freedoms; j++) {
        const size_t row = TFA_V(reduced_freedom)(s->m, j, &multiplier);
        s->res[j] = num_all(multiplier == num_of(1)) ? X[stride * row] : num_of(0);
    }
    for (uint32_t k = 0; k < s->m->mimics; k++)
        s->res[s->m->mimic[k].follower] = num_of(0);
    TFA_V(solve)(s, method, s->res, s->dx);
    for (uint32_t j = 0; j < s->freedoms; j++) {
        const size_t row = TFA_V(reduced_freedom)(s->m, j, &multiplier);
        if (num_all(multiplier == num_of(1)))
            X[stride * row] = s->dx[j];
    }
}

/* Returns the method of the factors. */
static tfa_method solve_blocks(struct state *s, const struct blocks *b)
{
    const int rows = !s->m->mimics && !s->locked && reserves_method(s->methods, TFA_METHOD_CRBA);
    const tfa_method method =
        rows || s->by.method == TFA_METHOD_CRBA ? TFA_METHOD_CRBA : TFA_V(last_resort)(s);
    (void)TFA_V(factor)(s, method);
    if (rows) {
        const struct mass_factors f = {s->m, s->M, s->public_row};
        solve_rows(&f, b);
        return method;
    }
    for (int by = 0; by < BLOCKS; by++)
        for (uint32_t j = 0; b->out[by] && j < b->n; j++)
            solve_column(s, method, b->X[by] + derivatives_column(j), b->stride);
    return method;
}

/* Flags derivatives that may have lost digits; those by motion are made about one point, to which
 * light bodies far from it lose theirs. The estimate, which is of qdd, is none of theirs. In lanes
 * each state is then to be answered by itself, of floats by double. */
static void doubt(struct state *s, const tfa_request *r, tfa_method factors, int by_motion,
                  tfa_answer *out)
{
    const int crba = factors == TFA_METHOD_CRBA;
    if (r->estimate == TFA_ESTIMATE_NEVER)
        return;
    if (by_motion && !num_all(TFA_V(sentinel_margin_derivatives)(s, crba) >= 0))
        out->flags |= TFA_ANSWER_SENTINEL;
    if (!(out->flags & TFA_ANSWER_SENTINEL))
        return;
    s->lanes_diverged |= NUM_LANES > 1;
    out->flags &= (uint16_t)~TFA_ANSWER_ESTIMATED;
    out->error_estimate = (double)NAN;
}

/* ---- the op ---- */

/* The blocks by motion times sign. Returns the status: TFA_OK if all numbers are finite */
static int unload(const struct state *s, const struct blocks *b, num sign)
{
    const num rest = unload_blocks(b, sign, num_of(0), s->lane);
    return num_all(rest == num_of(0)) ? TFA_OK : TFA_E_NOT_COMPUTED;
}

static void forces_by_motion(struct state *s, const tfa_request *r, const struct blocks *b,
                             int of_world)
{
    struct held_wrench held[TFA_MAX_WRENCHES];
    struct inverse_derivatives d = {.dq = b->X[BY_Q],
                                    .dv = b->X[BY_V],
                                    .stride = b->stride,
                                    .origin = TFA_V(derivatives_origin)(s),
                                    .of_world = of_world,
                                    .held = held};
    d.held_count = held_wrenches(s, r, d.origin, held);
    TFA_V(inverse_derivatives)(s, &d);
}

/* qdd of a root body is less by w x boost in the world: its derivative by w, of the opposite sign
 * as everything in the block. Neither that frame's accelerations depend on the boost nor w x boost
 * on q. */
static void add_boost(const struct state *s, const struct blocks *b)
{
    for (uint32_t t = 0; s->boosted && t < s->m->trees; t++) {
        const struct tfa_body *root = &s->body[s->m->chain[t].first];
        const num *v = s->boost + root->v;
        num multiplier;
        const uint32_t j = TFA_V(reduced_freedom)(s->m, root->v, &multiplier);
        if (!is_free(root->kind))
            continue;
        for (uint32_t e = 0; e < 3; e++) {
            num *const X = b->X[BY_V] + b->stride * (j + e);
            X[derivatives_column(j + 3 + (e + 1) % 3)] += v[(e + 2) % 3];
            X[derivatives_column(j + 3 + (e + 2) % 3)] -= v[(e + 1) % 3];
        }
    }
}

int TFA_V(answer_derivatives)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *out)
{
    tfa_reply part = *reply;
    part.qdd = part.base_acceleration = part.lambda_inv = NULL;
    const int status = TFA_V(answer_forward)(s, r, k, &part, out);
    reply->field = part.field;
    reply->index = part.index;
    if (status != TFA_OK)
        return status;
    double *const matrices[BLOCKS] = {reply->dqdd_dq, reply->dqdd_dv, reply->dqdd_dtau};
    const struct blocks b = blocks_of_state(s, matrices);
    const int by_motion = b.out[BY_Q] || b.out[BY_V];
    if (by_motion)
        forces_by_motion(s, r, &b, 0);
    if (b.asked)
        doubt(s, r, solve_blocks(s, &b), by_motion, out);
    if (b.out[BY_V])
        add_boost(s, &b);
    return unload(s, &b, num_of(-1));
}

int TFA_V(answer_inverse_derivatives)(struct state *s, const tfa_request *r, tfa_reply *reply,
                                      tfa_answer *out)
{
    double *const matrices[BLOCKS] = {reply->dtau_dq, reply->dtau_dv, NULL};
    const struct blocks b = blocks_of_state(s, matrices);
    out->method = (uint16_t)s->by.method;
    forces_by_motion(s, r, &b, 1);
    return unload(s, &b, num_of(1));
}
