/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Independent limbs of a tree side by side: outward, each step takes those bodies whose parents have
 * been taken and that have the longest way to a leaf behind them. For bodies that all cost the same
 * no schedule has fewer steps (T. C. Hu, Parallel sequencing and assembly line problems, 1961). So
 * fingers stand beside fingers, arms beside legs, and a torso goes before what hangs on it.
 */
#include "plan/limbs.h"

/* Bodies of one step do the same operations. */
enum {
    CLASS_REVOLUTE,
    CLASS_GEARED,
    CLASS_AXIAL,
    CLASS_GEARED_AXIAL,
    CLASS_PRISMATIC,
    CLASS_ALONE
};

static int class_of(const struct tfa_body *b)
{
    if (is_prismatic(b->kind))
        return CLASS_PRISMATIC;
    if (!is_revolute(b->kind))
        return CLASS_ALONE;
    if (b->axial)
        return b->armature > 0 ? CLASS_GEARED_AXIAL : CLASS_AXIAL;
    return b->armature > 0 ? CLASS_GEARED : CLASS_REVOLUTE;
}

/* A plan under way. */
struct limbs {
    const struct tfa_model *m;
    uint32_t lanes, steps;
    int stay; /* bodies whose parents stand in the step before go first, whatever is behind them */
    int32_t *table;
    int16_t level[TFA_LIMBS_BODIES_MAX]; /* bodies to the farthest leaf, this one included */
    int16_t step[TFA_LIMBS_BODIES_MAX];  /* -1: not taken yet */
};

static void find_levels(struct limbs *p)
{
    for (uint32_t i = 0; i < p->m->bodies; i++) {
        p->level[i] = 1;
        p->step[i] = -1;
    }
    for (uint32_t i = p->m->bodies; i-- > 0;) {
        const int32_t parent = p->m->body[i].parent;
        if (parent >= 0 && p->level[parent] <= p->level[i])
            p->level[parent] = (int16_t)(p->level[i] + 1);
    }
}

static int is_ready(const struct limbs *p, uint32_t i)
{
    const int32_t parent = p->m->body[i].parent;
    return p->step[i] < 0 &&
           (parent < 0 || (p->step[parent] >= 0 && p->step[parent] < (int16_t)p->steps));
}

/* The lane where the parent stands in the step before, -1: none. */
static int32_t lane_before(const struct limbs *p, uint32_t i)
{
    const int32_t parent = p->m->body[i].parent;
    if (parent < 0 || p->step[parent] + 1 != (int32_t)p->steps)
        return -1;
    const int32_t *row = p->table + (size_t)p->lanes * (p->steps - 1);
    for (uint32_t l = 0; l < p->lanes; l++)
        if (row[l] == parent)
            return (int32_t)l;
    return -1;
}

/* The ready body with the longest way to a leaf, of the class if there is one; among several one
 * that goes on where its parent stands. -1: none. */
static int32_t next(const struct limbs *p, int class)
{
    int32_t best = -1;
    int score = 0;
    for (uint32_t i = 0; i < p->m->bodies; i++) {
        if (!is_ready(p, i) || (class >= 0 && class_of(&p->m->body[i]) != class))
            continue;
        const int goes_on = lane_before(p, i) >= 0;
        const int own = 2 * p->level[i] + goes_on * (p->stay ? 2 * TFA_LIMBS_BODIES_MAX : 1);
        if (own > score) {
            best = (int32_t)i;
            score = own;
        }
    }
    return best;
}

/* Where it stands: in its parent's lane if that is free, else later in any. */
static void seat(struct limbs *p, const int32_t *taken, uint32_t count)
{
    int32_t *row = p->table + (size_t)p->lanes * p->steps;
    for (uint32_t l = 0; l < p->lanes; l++)
        row[l] = -1;
    uint32_t left = 0;
    int32_t moved[TFA_LIMBS_LANES_MAX];
    for (uint32_t k = 0; k < count; k++) {
        const int32_t lane = lane_before(p, (uint32_t)taken[k]);
        if (lane >= 0 && row[lane] < 0)
            row[lane] = taken[k];
        else
            moved[left++] = taken[k];
    }
    uint32_t l = 0;
    for (uint32_t k = 0; k < left; k++) {
        while (row[l] >= 0)
            l++;
        row[l] = moved[k];
    }
}

/* Returns how many bodies the step takes. */
static uint32_t take_step(struct limbs *p)
{
    int32_t taken[TFA_LIMBS_LANES_MAX] = {next(p, -1)};
    const int class = class_of(&p->m->body[taken[0]]);
    uint32_t count = 0;
    while (taken[count] >= 0) {
        p->step[taken[count++]] = (int16_t)p->steps;
        if (count == p->lanes || class == CLASS_ALONE)
            break;
        taken[count] = next(p, class);
    }
    seat(p, taken, count);
    return count;
}

static void walk(struct limbs *p)
{
    find_levels(p);
    for (uint32_t taken = 0; taken < p->m->bodies; p->steps++)
        taken += take_step(p);
}

/* What passes between lanes costs something, so that limbs are walked without a pause wherever that
 * takes no more steps. */
struct tfa_packing tfa_limbs_pack(const struct tfa_model *model, uint32_t lanes, int32_t *table)
{
    struct limbs p = {.m = model, .lanes = lanes, .table = table, .stay = 1};
    if (model->bodies > TFA_LIMBS_BODIES_MAX || (model->base_freedoms && model->trees > 1))
        return (struct tfa_packing){lanes, 0, table};
    struct limbs fewest = p;
    fewest.stay = 0;
    walk(&fewest);
    walk(&p);
    if (fewest.steps < p.steps) {
        p = fewest;
        p.steps = 0;
        walk(&p);
    }
    return (struct tfa_packing){lanes, p.steps, table};
}
