/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Chains in pieces: which chains, their memory, and their constants in the order of lanes.
 */
#include "kernel/pieces.h"

#include <string.h>

#include "spatial/inverse.h"

/* Shorter chains are not worth the borders. */
#define PIECES_LENGTH_MIN 48

/* A row of the table: chains from this length on have so many pieces. */
static const struct {
    uint32_t length, pieces;
} cuts[] = {{PIECES_LENGTH_MIN, 16}, {2048, 32}};

static uint32_t pieces_of(uint32_t length)
{
    uint32_t pieces = 0;
    for (size_t k = 0; k < sizeof cuts / sizeof *cuts; k++)
        if (length >= cuts[k].length)
            pieces = cuts[k].pieces;
    return pieces;
}

/* An unbranched chain of revolute joints without rotor inertia, all of them free, whose every body
 * has an inverse inertia */
static int is_plain(const struct tfa_model *m)
{
    if (m->trees != 1 || m->chain[0].length != m->bodies || m->base_freedoms || m->mimics ||
        m->bodies < PIECES_LENGTH_MIN)
        return 0;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &m->body[i];
        const struct tfa_coordinate *c = &m->coordinate[b->q];
        if (!is_revolute(b->kind) || b->armature > 0 || !b->regular || c->offset != 0 ||
            c->multiplier != 1 || m->freedom[b->v].multiplier != 1)
            return 0;
    }
    return 1;
}

size_t TFA_V(pieces_walk)(const struct tfa_model *m, void *base, struct pieces **out)
{
    struct arena a = {base, 0};
    struct pieces *p = arena_take(&a, 1, sizeof *p), count_only;
    struct pieces *o = p ? p : &count_only;
    *out = p;
    if (!is_plain(m))
        return 0;
    o->m = m;
    o->length = m->bodies;
    o->pieces = pieces_of(o->length);
    o->rows = (o->length + o->pieces - 1) / o->pieces;
    o->groups = o->pieces / NUM_LANES;
    o->width = o->pieces + 8;
    const size_t all = (size_t)o->groups * (o->rows + 1);
    o->body = arena_take(&a, all, sizeof *o->body);
    o->row = arena_take(&a, all, sizeof *o->row);
    o->last = arena_take(&a, o->groups + 8, sizeof *o->last);
    o->border = arena_take(&a, (size_t)BORDER_ROWS * o->width, sizeof(double));
    o->unrefined = arena_take(&a, (size_t)12 * o->width, sizeof(double));
    o->finite = arena_take(&a, o->groups, sizeof(num));
    o->sum_qdd = arena_take(&a, o->groups, sizeof(num));
    o->sum_dx = arena_take(&a, o->groups, sizeof(num));
    o->residual = arena_take(&a, m->v_count, sizeof(double));
    o->change = arena_take(&a, m->v_count, sizeof(double));
    return a.used;
}

static void put(num *x, uint32_t lane, double value)
{
    ((double *)x)[lane] = value;
}

static void put_many(num *x, uint32_t lane, const double *values, int count)
{
    for (int k = 0; k < count; k++)
        put(x + k, lane, values[k]);
}

/* Nothing at rest: what stands behind the last body, and, without inverse inertia, the ground */
static void fill(struct piece_body *b, uint32_t lane, double inverse)
{
    static const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    put_many(&b->E.xx, lane, unit, 9);
    put(&b->Iinv.A.xx, lane, inverse);
    put(&b->Iinv.A.yy, lane, inverse);
    put(&b->Iinv.A.zz, lane, inverse);
    put(&b->Iinv.M.xx, lane, inverse);
    put(&b->Iinv.M.yy, lane, inverse);
    put(&b->Iinv.M.zz, lane, inverse);
}

static void copy_body(struct piece_body *b, uint32_t lane, const struct tfa_model *m, uint32_t i)
{
    const struct tfa_body *from = &m->body[i];
    put_many(&b->E.xx, lane, from->E, 9);
    put_many(&b->r.x, lane, from->r, 3);
    put_many(&b->I.xx, lane, from->I, 6);
    put_many(&b->h.x, lane, from->h, 3);
    put(&b->mass, lane, from->mass);
    put(&b->damping, lane, m->damping ? m->damping[from->v] : 0);
    put(&b->live, lane, 1);
    if (i + 1 < m->bodies)
        put_many(&b->next_z.x, lane, m->body[i + 1].E + 6, 3);
    b->q[lane] = m->coordinate[from->q].from;
    b->v[lane] = m->freedom[from->v].from;
    b->real[lane] = 1;
}

/* Terms with the inverse inertia, of all lanes in one go. Lanes without inertia keep what they have. */
static void invert(struct piece_body *b)
{
    const sym6 I = s6_rigid(b->I, b->h, b->mass);
    const num_mask live = b->live > num_of(0);
    sym6 safe = I, inverse = I;
    const num one = num_select(live, num_of(0), num_of(1));
    safe.A.xx += one, safe.A.yy += one, safe.A.zz += one;
    safe.M.xx += one, safe.M.yy += one, safe.M.zz += one;
    (void)s6_invert(&safe, &inverse);
    const num *from = &inverse.A.xx;
    num *to = &b->Iinv.A.xx;
    for (int k = 0; k < 21; k++)
        to[k] = num_select(live, from[k], to[k]);
}

/* T I^-1 and T I^-1 T^T from the body before */
static void couple(struct piece_body *b, const struct piece_body *before)
{
    static const uint8_t five[] = {0, 1, 3, 4, 5};
    const place T = {b->E, b->r};
    num TI[36];
    sym6 TIT;
    inverse_behind(&T, &before->Iinv, TI, &TIT);
    b->TIT = s5_of(&TIT);
    for (int k = 0; k < 15; k++)
        b->TIT.x[k] *= b->live;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            b->minus_TI.x[j][i] = -TI[6 * five[i] + five[j]] * b->live;
}

struct pieces *TFA_V(pieces_init)(const struct tfa_model *m, void *memory)
{
    struct pieces *p;
    memset(memory, 0, TFA_V(pieces_walk)(m, NULL, &p));
    (void)TFA_V(pieces_walk)(m, memory, &p);
    for (uint32_t g = 0; g < p->groups; g++) {
        struct piece_body *body = piece_bodies(p, g);
        for (uint32_t k = 0; k <= p->rows; k++) {
            for (uint32_t l = 0; l < NUM_LANES; l++) {
                const uint32_t i = (g * NUM_LANES + l) * p->rows + k; /* behind the body wanted */
                if (i >= 1 && i <= p->length)
                    copy_body(&body[k], l, m, i - 1);
                else
                    fill(&body[k], l, i > 0);
            }
            invert(&body[k]);
            if (k > 0)
                couple(&body[k], &body[k - 1]);
        }
    }
    return p;
}
