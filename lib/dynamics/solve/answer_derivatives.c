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
#include "dynamics/derivatives/inverse_derivatives.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/kinematics/world_pose.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "spatial/row_vectors.h"
#include "spatial/rows.h"

static size_t public_freedoms(const struct state *s)
{
    return (size_t)s->m->base_freedoms + s->m->v_count;
}

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

/* ---- blocks: matrices by q, by v, by tau ---- */

enum { BY_Q, BY_V, BY_TAU, BLOCKS = DERIVATIVES_MATRICES };

struct blocks {
    double *out[BLOCKS]; /* of all states; NULL: not asked */
    num *X[BLOCKS];      /* first number of each; those asked stand first in their groups */
    int asked;
    size_t n, groups, stride;
};

/* All zero, but 1 for the forces */
static struct blocks clear_blocks(struct state *s, double *const matrices[BLOCKS])
{
    struct blocks b = {.n = public_freedoms(s)};
    for (int by = 0; by < BLOCKS; by++) {
        b.out[by] = matrices[by];
        b.asked += b.out[by] != NULL;
    }
    for (int by = 0, first = 0, last = b.asked; by < BLOCKS; by++)
        b.X[by] = s->derivatives + DERIVATIVES_GROUP * (b.out[by] ? first++ : last++);
    b.groups = (b.n + DERIVATIVES_GROUP - 1) / DERIVATIVES_GROUP;
    b.stride = DERIVATIVES_GROUP * BLOCKS * b.groups;
    for (size_t e = 0; e < b.stride * b.n; e++)
        s->derivatives[e] = num_of(0);
    for (uint32_t j = 0; j < b.n; j++)
        b.X[BY_TAU][b.stride * j + derivatives_column(j)] = num_of(1);
    for (uint32_t j = 0; j < s->freedoms; j++) {
        num multiplier;
        s->public_row[j] = TFA_V(reduced_freedom)(s->m, j, &multiplier);
    }
    return b;
}

/* ---- M^-1 X of the blocks asked ---- */

/* The columns of as many groups as registers hold, the same freedoms in each block: rows are zero
 * at the branches of other freedoms. */
#define GROUP_VECS (DERIVATIVES_GROUP / NUM_VEC_LANES)
#define PANEL_GROUPS NUM_VEC_LANES /* twelve vectors */
#define PANEL_VECS_MOST (PANEL_GROUPS * BLOCKS * GROUP_VECS)

/* Vectors v of a row, of so many blocks asked */
TFA_INLINE num *panel_vec(num *row, int v, int blocks)
{
    const int group = v / (blocks * GROUP_VECS), rest = v % (blocks * GROUP_VECS);
    return row + DERIVATIVES_GROUP * BLOCKS * group + NUM_VEC_LANES * rest;
}

/* Rows of ancestors -= L x their descendant's, inward */
TFA_INLINE void solve_inward(struct state *s, num *X, size_t stride, int groups, int blocks)
{
    const struct tfa_model *m = s->m;
    const int vecs = groups * blocks * GROUP_VECS;
    for (uint32_t k = m->freedoms; k-- > 0;) {
        const num *L = s->M + m->dof_row[k] + m->dof_depth[k];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = numbers_load(panel_vec(X + stride * s->public_row[k], v, blocks));
        if (numbers_are_zero(x, vecs))
            continue;
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *const row = X + stride * s->public_row[i];
            const num l = *--L;
            for (int v = 0; v < vecs; v++) {
                num *const at = panel_vec(row, v, blocks);
                numbers_store(at, numbers_load(at) - l * x[v]);
            }
        }
    }
}

/* Rows divided by D, -= L x those of their ancestors, outward */
TFA_INLINE void solve_outward(struct state *s, num *X, size_t stride, int groups, int blocks)
{
    const struct tfa_model *m = s->m;
    const int vecs = groups * blocks * GROUP_VECS;
    for (uint32_t k = 0; k < m->freedoms; k++) {
        const num *L = s->M + m->dof_row[k] + m->dof_depth[k];
        const num inverse = 1 / *L;
        num *const to = X + stride * s->public_row[k];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = numbers_load(panel_vec(to, v, blocks)) * inverse;
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *const row = X + stride * s->public_row[i];
            const num l = *--L;
            for (int v = 0; v < vecs; v++)
                x[v] -= l * numbers_load(panel_vec(row, v, blocks));
        }
        for (int v = 0; v < vecs; v++)
            numbers_store(panel_vec(to, v, blocks), x[v]);
    }
}

/* Groups from g on, so many at a time. Returns the first one that is left. */
TFA_INLINE size_t solve_groups(struct state *s, const struct blocks *b, size_t g, int groups,
                               int blocks)
{
    for (; g + (size_t)groups <= b->groups; g += (size_t)groups) {
        num *X = s->derivatives + DERIVATIVES_GROUP * BLOCKS * g;
        solve_inward(s, X, b->stride, groups, blocks);
        solve_outward(s, X, b->stride, groups, blocks);
    }
    return g;
}

/* By M = L^T D L: as ltdl_solve, for all columns of a panel at once */
TFA_INLINE void solve_panels(struct state *s, const struct blocks *b, int blocks)
{
    size_t g = solve_groups(s, b, 0, PANEL_GROUPS, blocks);
    if (PANEL_GROUPS > 2)
        g = solve_groups(s, b, g, 2, blocks);
    if (PANEL_GROUPS > 1)
        (void)solve_groups(s, b, g, 1, blocks);
}

static void solve_rows(struct state *s, const struct blocks *b)
{
    if (b->asked == 1)
        solve_panels(s, b, 1);
    else
        solve_panels(s, b, BLOCKS);
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
        solve_rows(s, b);
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

#if NUM_LANES == 1
/* Numbers of a vector as doubles */
TFA_INLINE void store_doubles(double *out, num_vec x)
{
    if (sizeof(num) == sizeof *out)
        memcpy(out, &x, NUM_VEC_LANES * sizeof *out);
    else
        for (int l = 0; l < NUM_VEC_LANES; l++)
            out[l] = (double)vec_lane(x, l);
}
#endif

/* out = sign x for four numbers of a row, in the matrices of all states. Returns rest + 0 if all
 * are finite, else not a number somewhere. */
TFA_INLINE num_vec unload_group(const struct state *s, const num *x, num sign, double *out,
                                size_t square, num_vec rest)
{
    num_vec y[GROUP_VECS];
    for (int v = 0; v < GROUP_VECS; v++) {
        y[v] = sign * numbers_load(x + NUM_VEC_LANES * v);
        rest += y[v] - y[v];
    }
#if NUM_LANES == 1
    for (int v = 0; v < GROUP_VECS; v++)
        store_doubles(out + square * s->lane[0] + NUM_VEC_LANES * v, y[v]);
#else
    scatter_numbers(y, s->lane, out, square, DERIVATIVES_GROUP);
#endif
    return rest;
}

/* The same for a row of n numbers in groups */
TFA_INLINE num_vec unload_row(const struct state *s, const num *x, num sign, double *out, size_t n,
                              num_vec rest)
{
    const size_t square = n * n, whole = n / DERIVATIVES_GROUP * DERIVATIVES_GROUP;
    for (size_t j = 0; j < whole; j += DERIVATIVES_GROUP)
        rest = unload_group(s, x + derivatives_column((uint32_t)j), sign, out + j, square, rest);
    for (size_t j = whole; j < n; j++) {
        const num y = sign * x[derivatives_column((uint32_t)j)];
        rest += y - y;
        scatter_numbers(&y, s->lane, out + j, square, 1);
    }
    return rest;
}

/* sign times a block. Returns 1 when all of it is finite. */
static int unload_block(const struct state *s, const struct blocks *b, int by, num sign)
{
    num_vec rest = {0};
    num sum = num_of(0);
    for (size_t i = 0; b->out[by] && i < b->n; i++)
        rest = unload_row(s, b->X[by] + b->stride * i, sign, b->out[by] + b->n * i, b->n, rest);
    for (int l = 0; l < NUM_VEC_LANES; l++)
        sum += vec_lane(rest, l);
    return num_all(sum == num_of(0));
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
    const struct blocks b = clear_blocks(s, matrices);
    const int by_motion = b.out[BY_Q] || b.out[BY_V];
    if (by_motion)
        forces_by_motion(s, r, &b, 0);
    if (b.asked)
        doubt(s, r, solve_blocks(s, &b), by_motion, out);
    if (b.out[BY_V])
        add_boost(s, &b);
    const int finite = unload_block(s, &b, BY_Q, num_of(-1)) &
                       unload_block(s, &b, BY_V, num_of(-1)) &
                       unload_block(s, &b, BY_TAU, num_of(1));
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}

int TFA_V(answer_inverse_derivatives)(struct state *s, const tfa_request *r, tfa_reply *reply,
                                      tfa_answer *out)
{
    double *const matrices[BLOCKS] = {reply->dtau_dq, reply->dtau_dv, NULL};
    const struct blocks b = clear_blocks(s, matrices);
    out->method = (uint16_t)s->by.method;
    forces_by_motion(s, r, &b, 1);
    return unload_block(s, &b, BY_Q, num_of(1)) & unload_block(s, &b, BY_V, num_of(1))
               ? TFA_OK
               : TFA_E_NOT_COMPUTED;
}
