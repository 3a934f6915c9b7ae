/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Independent branches of a tree in SIMD lanes: outward, each step takes the bodies whose parents
 * have been taken and that have the longest path to a leaf. For bodies that all cost the same
 * no schedule has fewer steps (T. C. Hu, Parallel sequencing and assembly line problems, 1961). So
 * fingers share steps with fingers, arms with legs, and a torso precedes its branches.
 */
#include "layout/schedule_body_lanes.h"

/* Bodies of one step do the same operations. */
enum {
    CLASS_REVOLUTE,
    CLASS_ARMATURE,
    CLASS_AXIAL,
    CLASS_ARMATURE_AXIAL,
    CLASS_PRISMATIC,
    CLASS_SINGLE
};

static int class_of(const struct tfa_body *b)
{
    if (is_prismatic(b->kind))
        return CLASS_PRISMATIC;
    if (!is_revolute(b->kind))
        return CLASS_SINGLE;
    if (b->axial)
        return b->armature > 0 ? CLASS_ARMATURE_AXIAL : CLASS_AXIAL;
    return b->armature > 0 ? CLASS_ARMATURE : CLASS_REVOLUTE;
}

/* State of the scheduler. */
struct scheduler {
    const struct tfa_model *m;
    uint32_t lanes, steps;
    int prefer_parent_lane; /* bodies whose parents are in the preceding step go first */
    int32_t *table;
    int16_t level[TFA_BODY_LANES_BODIES_MAX]; /* bodies to the farthest leaf, this one included */
    int16_t step[TFA_BODY_LANES_BODIES_MAX];  /* -1: not taken yet */
};

static void find_levels(struct scheduler *p)
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

static int is_ready(const struct scheduler *p, uint32_t i)
{
    const int32_t parent = p->m->body[i].parent;
    return p->step[i] < 0 &&
           (parent < 0 || (p->step[parent] >= 0 && p->step[parent] < (int16_t)p->steps));
}

/* The lane of the parent in the preceding step, -1: none. */
static int32_t lane_before(const struct scheduler *p, uint32_t i)
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
 * in its parent's lane. -1: none. */
static int32_t next_body(const struct scheduler *p, int class)
{
    int32_t best = -1;
    int score = 0;
    for (uint32_t i = 0; i < p->m->bodies; i++) {
        if (!is_ready(p, i) || (class >= 0 && class_of(&p->m->body[i]) != class))
            continue;
        const int goes_on = lane_before(p, i) >= 0;
        const int score_of_body =
            2 * p->level[i] + goes_on * (p->prefer_parent_lane ? 2 * TFA_BODY_LANES_BODIES_MAX : 1);
        if (score_of_body > score) {
            best = (int32_t)i;
            score = score_of_body;
        }
    }
    return best;
}

/* Assigns lanes: the parent's lane if that is free, else any other. */
static void assign_lanes(struct scheduler *p, const int32_t *taken, uint32_t count)
{
    int32_t *row = p->table + (size_t)p->lanes * p->steps;
    for (uint32_t l = 0; l < p->lanes; l++)
        row[l] = -1;
    uint32_t left = 0;
    int32_t moved[TFA_BODY_LANES_MAX];
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
static uint32_t schedule_step(struct scheduler *p)
{
    int32_t taken[TFA_BODY_LANES_MAX] = {next_body(p, -1)};
    const int class = class_of(&p->m->body[taken[0]]);
    uint32_t count = 0;
    while (taken[count] >= 0) {
        p->step[taken[count++]] = (int16_t)p->steps;
        if (count == p->lanes || class == CLASS_SINGLE)
            break;
        taken[count] = next_body(p, class);
    }
    assign_lanes(p, taken, count);
    return count;
}

static void walk(struct scheduler *p)
{
    find_levels(p);
    for (uint32_t taken = 0; taken < p->m->bodies; p->steps++)
        taken += schedule_step(p);
}

/* Transfers between lanes have a cost, so that branches are walked without a pause wherever that
 * takes no more steps. */
struct tfa_lane_schedule tfa_schedule_body_lanes(const struct tfa_model *model, uint32_t lanes,
                                                 int32_t *table)
{
    struct scheduler p = {.m = model, .lanes = lanes, .table = table, .prefer_parent_lane = 1};
    if (model->bodies > TFA_BODY_LANES_BODIES_MAX || (model->base_freedoms && model->trees > 1))
        return (struct tfa_lane_schedule){lanes, 0, table};
    struct scheduler fewest = p;
    fewest.prefer_parent_lane = 0;
    walk(&fewest);
    walk(&p);
    if (fewest.steps < p.steps) {
        p = fewest;
        p.steps = 0;
        walk(&p);
    }
    return (struct tfa_lane_schedule){lanes, p.steps, table};
}
