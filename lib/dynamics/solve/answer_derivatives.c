/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of forward dynamics (Carpentier and Mansard, RSS 2018): with qdd = FD(q, v, tau),
 *
 *     dqdd/dtau = M^-1,   dqdd/dq = -M^-1 dID/dq,   dqdd/dv = -M^-1 dID/dv
 */
#include <math.h>
#include <string.h>

#include "dynamics/core/frame.h"
#include "dynamics/core/recursions.h"
#include "dynamics/core/sentinel.h"
#include "dynamics/derivatives/inverse_derivatives.h"
#include "dynamics/kinematics/world_pose.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"

static size_t public_freedoms(const struct state *s)
{
    return (size_t)s->m->base_freedoms + s->m->v_count;
}

/* Numbers of a wrench in world axes about the reference point */
static svec world_wrench(const double *x, const mat3 *axes, vec3 at)
{
    svec w = {v3_load(x + 3), v3_load(x)};
    if (axes)
        w = (svec){m3_mul(*axes, w.w), m3_mul(*axes, w.v)};
    w.w = v3_add(w.w, v3_cross(at, w.v));
    return w;
}

/* Wrenches of the request that do not follow their bodies rigidly. Returns how many. */
static uint32_t held_wrenches(const struct state *s, const tfa_request *r, uint32_t k, vec3 origin,
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
        xform at = frame_in_body(s, frame);
        world_frame(&s->world[held->body], &at.E, &at.r);
        held->at = v3_sub(r->frame == TFA_FRAME_WORLD ? v3_zero() : at.r, origin);
        held->wrench = world_wrench(r->wrenches + 6 * ((size_t)r->wrench_count * k + w),
                                    r->frame == TFA_FRAME_LOCAL ? &at.E : NULL, held->at);
        count++;
    }
    return count;
}

/* ---- M^-1 X for the rows of a matrix, public freedoms ---- */

/* Columns of X go in panels of so many vectors, which stay in registers. */
#define PANEL_COLUMNS 8
#define PANEL_VECS (PANEL_COLUMNS / NUM_VEC_LANES)
#define PANEL_VECS_MOST (3 * PANEL_VECS)

TFA_INLINE num_vec column_load(const num *x, int v)
{
    num_vec y;
    memcpy(&y, x + v * NUM_VEC_LANES, sizeof y);
    return y;
}

TFA_INLINE void column_store(num *x, int v, num_vec y)
{
    memcpy(x + v * NUM_VEC_LANES, &y, sizeof y);
}

/* Rows of ancestors -= L x their descendant's, inward */
TFA_INLINE void solve_inward(struct state *s, num *X, size_t columns, int vecs)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = m->freedoms; k-- > 0;) {
        const num *const L = s->M + m->dof_row[k];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = column_load(X + columns * k, v);
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *const row = X + columns * (size_t)i;
            const num l = L[m->dof_depth[i]];
            for (int v = 0; v < vecs; v++)
                column_store(row, v, column_load(row, v) - l * x[v]);
        }
    }
}

/* Rows divided by D, -= L x those of their ancestors, outward */
TFA_INLINE void solve_outward(struct state *s, num *X, size_t columns, int vecs)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = 0; k < m->freedoms; k++) {
        const num *const L = s->M + m->dof_row[k];
        const num inverse = 1 / L[m->dof_depth[k]];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = column_load(X + columns * k, v) * inverse;
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            const num *const row = X + columns * (size_t)i;
            const num l = L[m->dof_depth[i]];
            for (int v = 0; v < vecs; v++)
                x[v] -= l * column_load(row, v);
        }
        for (int v = 0; v < vecs; v++)
            column_store(X + columns * k, v, x[v]);
    }
}

/* By M = L^T D L: as ltdl_solve, for all columns of so many panels at once */
TFA_INLINE void solve_panels(struct state *s, num *X, size_t columns, int panels)
{
    solve_inward(s, X, columns, panels * PANEL_VECS);
    solve_outward(s, X, columns, panels * PANEL_VECS);
}

static void solve_rows(struct state *s, num *X, size_t columns)
{
    size_t c = 0;
    for (; c + 3 * PANEL_COLUMNS <= columns; c += 3 * PANEL_COLUMNS)
        solve_panels(s, X + c, columns, 3);
    if (c + 2 * PANEL_COLUMNS <= columns)
        solve_panels(s, X + c, columns, 2);
    else if (c < columns)
        solve_panels(s, X + c, columns, 1);
}

/* Column by column with the factors of a method: a force on a public freedom is its leader's, and
 * so is the acceleration. */
static void solve_columns(struct state *s, tfa_method method, num *X, size_t columns)
{
    for (size_t c = 0; c < columns; c++) {
        num multiplier;
        for (uint32_t j = 0; j < s->freedoms; j++) {
            const size_t row = TFA_V(reduced_freedom)(s->m, j, &multiplier);
            s->res[j] = multiplier == num_of(1) ? X[columns * row + c] : num_of(0);
        }
        for (uint32_t k = 0; k < s->m->mimics; k++)
            s->res[s->m->mimic[k].follower] = num_of(0);
        TFA_V(solve)(s, method, s->res, s->dx);
        for (uint32_t j = 0; j < s->freedoms; j++) {
            const size_t row = TFA_V(reduced_freedom)(s->m, j, &multiplier);
            if (multiplier == num_of(1))
                X[columns * row + c] = s->dx[j];
        }
    }
}

/* Returns the method of the factors. */
static tfa_method solve_matrix(struct state *s, num *X, size_t columns)
{
    const int rows = s->identity_map && !s->locked && reserves_method(s->methods, TFA_METHOD_CRBA);
    const tfa_method method =
        rows || s->by.method == TFA_METHOD_CRBA ? TFA_METHOD_CRBA : TFA_V(last_resort)(s);
    (void)TFA_V(factor)(s, method);
    if (rows)
        solve_rows(s, X, columns);
    else
        solve_columns(s, method, X, columns);
    return method;
}

/* Flags derivatives that may have lost digits; those by motion are made about one point, to which
 * light bodies far from it lose theirs. The estimate, which is of qdd, is none of theirs. */
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
    out->flags &= (uint16_t)~TFA_ANSWER_ESTIMATED;
    out->error_estimate = (double)NAN;
}

/* ---- the op ---- */

/* A block of n columns of X is an answer: its derivative is by q, by v or by tau. */
enum { BY_Q, BY_V, BY_TAU, BLOCKS };

struct blocks {
    double *out[BLOCKS]; /* NULL: not asked */
    num *X[BLOCKS];      /* first column of those that are */
    size_t n, columns;   /* rows are whole cache lines */
};

static double *square_of_state(double *matrices, size_t n, uint32_t k)
{
    return matrices ? matrices + n * n * k : NULL;
}

/* Blocks of the answers asked for, side by side; zero, and 1 for the forces */
static struct blocks clear_blocks(struct state *s, const tfa_reply *reply, uint32_t k)
{
    struct blocks b = {.n = public_freedoms(s)};
    size_t asked = 0;
    b.out[BY_Q] = square_of_state(reply->dqdd_dq, b.n, k);
    b.out[BY_V] = square_of_state(reply->dqdd_dv, b.n, k);
    b.out[BY_TAU] = square_of_state(reply->dqdd_dtau, b.n, k);
    for (int by = 0; by < BLOCKS; by++)
        if (b.out[by])
            b.X[by] = s->derivatives + b.n * asked++;
    b.columns = (b.n * asked + PANEL_COLUMNS - 1) & ~(size_t)(PANEL_COLUMNS - 1);
    for (size_t e = 0; e < b.columns * b.n; e++)
        s->derivatives[e] = num_of(0);
    for (size_t j = 0; b.X[BY_TAU] && j < b.n; j++)
        b.X[BY_TAU][b.columns * j + j] = num_of(1);
    return b;
}

/* Numbers of a vector as doubles */
TFA_INLINE void store_doubles(double *out, num_vec x)
{
    if (sizeof(num) == sizeof *out)
        memcpy(out, &x, NUM_VEC_LANES * sizeof *out);
    else
        for (int l = 0; l < NUM_VEC_LANES; l++)
            out[l] = (double)vec_lane(x, l);
}

/* out = sign x, n numbers. Returns rest + 0 if all are finite, else not a number somewhere. */
TFA_INLINE num_vec unload_row(const num *x, num sign, double *out, size_t n, num_vec rest)
{
    size_t j = 0;
    for (; j + NUM_VEC_LANES <= n; j += NUM_VEC_LANES) {
        const num_vec y = sign * column_load(x + j, 0);
        rest += y - y;
        store_doubles(out + j, y);
    }
    for (; j < n; j++) {
        rest += x[j] - x[j];
        out[j] = (double)(sign * x[j]);
    }
    return rest;
}

/* sign times a block. Returns 1 when all of it is finite. */
static int unload_block(const struct blocks *b, int by, num sign)
{
    num_vec rest = {0};
    num sum = num_of(0);
    for (size_t i = 0; b->out[by] && i < b->n; i++)
        rest = unload_row(b->X[by] + b->columns * i, sign, b->out[by] + b->n * i, b->n, rest);
    for (int l = 0; l < NUM_VEC_LANES; l++)
        sum += vec_lane(rest, l);
    return sum == num_of(0);
}

static void forces_by_motion(struct state *s, const tfa_request *r, uint32_t k,
                             const struct blocks *b)
{
    struct held_wrench held[TFA_MAX_WRENCHES];
    struct inverse_derivatives d = {.dq = b->X[BY_Q],
                                    .dv = b->X[BY_V],
                                    .stride = b->columns,
                                    .origin = TFA_V(derivatives_origin)(s),
                                    .held = held};
    d.held_count = held_wrenches(s, r, k, d.origin, held);
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
        const size_t j = TFA_V(reduced_freedom)(s->m, root->v, &multiplier);
        num *X = b->X[BY_V] + b->columns * j + j + 3;
        if (!is_free(root->kind))
            continue;
        for (size_t e = 0; e < 3; e++) {
            X[b->columns * e + (e + 1) % 3] += v[(e + 2) % 3];
            X[b->columns * e + (e + 2) % 3] -= v[(e + 1) % 3];
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
    const struct blocks b = clear_blocks(s, reply, k);
    if (b.X[BY_Q] || b.X[BY_V])
        forces_by_motion(s, r, k, &b);
    if (b.columns)
        doubt(s, r, solve_matrix(s, s->derivatives, b.columns), b.X[BY_Q] || b.X[BY_V], out);
    if (b.X[BY_V])
        add_boost(s, &b);
    const int finite = unload_block(&b, BY_Q, num_of(-1)) & unload_block(&b, BY_V, num_of(-1)) &
                       unload_block(&b, BY_TAU, num_of(1));
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
