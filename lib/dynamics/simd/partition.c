/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Partitioned chains: the chains that qualify, their memory, and their constants in lane order.
 */
#include "dynamics/simd/partition.h"

#include <string.h>

#include "spatial/inverse.h"

/* Shorter chains are not worth the interfaces. */
#define PARTITION_LENGTH_MIN 48

/* A row of the table: chains from this length on have so many partitions. 1000 bodies in 16 of 63
 * rows leave 4 levels of the interface system and two barriers. */
static const struct {
    uint32_t length, partitions;
} partition_counts[] = {{PARTITION_LENGTH_MIN, 16}, {2048, 32}};

static uint32_t partition_count(uint32_t length)
{
    uint32_t count = 0;
    for (size_t k = 0; k < sizeof partition_counts / sizeof *partition_counts; k++)
        if (length >= partition_counts[k].length)
            count = partition_counts[k].partitions;
    return count;
}

/* An unbranched chain of revolute joints without rotor inertia, all of them free, whose every body
 * has an inverse inertia */
static int is_revolute_chain(const struct tfa_model *m)
{
    if (m->trees != 1 || m->chain[0].length != m->bodies || m->base_freedoms || m->mimics ||
        m->bodies < PARTITION_LENGTH_MIN)
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

size_t TFA_V(partition_walk)(const struct tfa_model *m, void *base, struct partition **out)
{
    struct arena a = {base, 0};
    struct partition *p = arena_alloc(&a, 1, sizeof *p), count_only;
    struct partition *o = p ? p : &count_only;
    *out = p;
    if (!is_revolute_chain(m))
        return 0;
    o->m = m;
    o->length = m->bodies;
    o->partitions = partition_count(o->length);
    o->rows = (o->length + o->partitions - 1) / o->partitions;
    o->groups = o->partitions / NUM_LANES;
    o->width = o->partitions + 8;
    const size_t all = (size_t)o->groups * (o->rows + 1);
    o->body = arena_alloc(&a, all, sizeof *o->body);
    o->row = arena_alloc(&a, all, sizeof *o->row);
    o->interface_factors = arena_alloc(&a, o->groups + 8, sizeof *o->interface_factors);
    o->interface = arena_alloc(&a, (size_t)INTERFACE_ROWS * o->width, sizeof(double));
    o->unrefined = arena_alloc(&a, (size_t)12 * o->width, sizeof(double));
    o->finite = arena_alloc(&a, o->groups, sizeof(num));
    o->sum_qdd = arena_alloc(&a, o->groups, sizeof(num));
    o->sum_dx = arena_alloc(&a, o->groups, sizeof(num));
    o->residual = arena_alloc(&a, m->v_count, sizeof(double));
    o->change = arena_alloc(&a, m->v_count, sizeof(double));
    return a.used;
}

static void set_lane(num *x, uint32_t lane, double value)
{
    ((double *)x)[lane] = value;
}

static void set_lanes(num *x, uint32_t lane, const double *values, int count)
{
    for (int k = 0; k < count; k++)
        set_lane(x + k, lane, values[k]);
}

/* Padding behind the last body; without inverse inertia, the ground */
static void set_padding_body(struct partition_body *b, uint32_t lane, double inverse)
{
    static const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    set_lanes(&b->E.xx, lane, unit, 9);
    set_lane(&b->Iinv.A.xx, lane, inverse);
    set_lane(&b->Iinv.A.yy, lane, inverse);
    set_lane(&b->Iinv.A.zz, lane, inverse);
    set_lane(&b->Iinv.M.xx, lane, inverse);
    set_lane(&b->Iinv.M.yy, lane, inverse);
    set_lane(&b->Iinv.M.zz, lane, inverse);
}

static void set_body(struct partition_body *b, uint32_t lane, const struct tfa_model *m, uint32_t i)
{
    const struct tfa_body *from = &m->body[i];
    set_lanes(&b->E.xx, lane, from->E, 9);
    set_lanes(&b->r.x, lane, from->r, 3);
    set_lanes(&b->I.xx, lane, from->I, 6);
    set_lanes(&b->h.x, lane, from->h, 3);
    set_lane(&b->mass, lane, from->mass);
    set_lane(&b->damping, lane, m->damping ? m->damping[from->v] : 0);
    set_lane(&b->is_body_mask, lane, 1);
    if (i + 1 < m->bodies)
        set_lanes(&b->next_z.x, lane, m->body[i + 1].E + 6, 3);
    b->q[lane] = m->coordinate[from->q].from;
    b->v[lane] = m->freedom[from->v].from;
    b->real[lane] = 1;
}

/* Terms with the inverse inertia, of all lanes in one go. Lanes without inertia keep what they
 * have. */
static void invert_inertia(struct partition_body *b)
{
    const sym6 I = s6_rigid(b->I, b->h, b->mass);
    const num_mask is_body_mask = b->is_body_mask > num_of(0);
    sym6 safe = I, inverse = I;
    const num one = num_select(is_body_mask, num_of(0), num_of(1));
    safe.A.xx += one, safe.A.yy += one, safe.A.zz += one;
    safe.M.xx += one, safe.M.yy += one, safe.M.zz += one;
    (void)s6_invert(&safe, &inverse);
    const num *from = &inverse.A.xx;
    num *to = &b->Iinv.A.xx;
    for (int k = 0; k < 21; k++)
        to[k] = num_select(is_body_mask, from[k], to[k]);
}

/* T I^-1 and T I^-1 T^T from the body before */
static void set_coupling(struct partition_body *b, const struct partition_body *before)
{
    static const uint8_t five[] = {0, 1, 3, 4, 5};
    const xform T = {b->E, b->r};
    num TI[36];
    sym6 TIT;
    inverse_inertia_to_child(&T, &before->Iinv, TI, &TIT);
    b->TIT = s5_of(&TIT);
    for (int k = 0; k < 15; k++)
        b->TIT.x[k] *= b->is_body_mask;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            b->minus_TI.x[j][i] = -TI[6 * five[i] + five[j]] * b->is_body_mask;
}

struct partition *TFA_V(partition_init)(const struct tfa_model *m, void *memory)
{
    struct partition *p;
    memset(memory, 0, TFA_V(partition_walk)(m, NULL, &p));
    (void)TFA_V(partition_walk)(m, memory, &p);
    for (uint32_t g = 0; g < p->groups; g++) {
        struct partition_body *body = group_bodies(p, g);
        for (uint32_t k = 0; k <= p->rows; k++) {
            for (uint32_t l = 0; l < NUM_LANES; l++) {
                const uint32_t i = (g * NUM_LANES + l) * p->rows + k; /* behind the body wanted */
                if (i >= 1 && i <= p->length)
                    set_body(&body[k], l, m, i - 1);
                else
                    set_padding_body(&body[k], l, i > 0);
            }
            invert_inertia(&body[k]);
            if (k > 0)
                set_coupling(&body[k], &body[k - 1]);
        }
    }
    return p;
}
