/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Orders of a model: bodies tree by tree; public coordinates and freedoms in declared order.
 */
#include <stdlib.h>
#include <string.h>

#include "model/draft/draft.h"

/* New index of each body. Stable: the order within a tree stays, trees come in the order of their
 * roots. */
static void order_bodies(const struct draft *d, uint32_t *new_index, uint32_t *tree,
                         uint32_t *start)
{
    uint32_t trees = 0;
    for (uint32_t i = 0; i < d->bodies; i++) {
        const int32_t up = d->body[i].parent;
        tree[i] = up < 0 ? trees++ : tree[up];
        start[tree[i] + 1]++;
    }
    for (uint32_t t = 0; t < trees; t++)
        start[t + 1] += start[t];
    for (uint32_t i = 0; i < d->bodies; i++)
        new_index[i] = start[tree[i]]++;
}

static void move_bodies(struct draft *d, const uint32_t *new_index, struct draft_body *copy)
{
    memcpy(copy, d->body, d->bodies * sizeof *copy);
    for (uint32_t i = 0; i < d->bodies; i++) {
        struct draft_body *b = &d->body[new_index[i]];
        *b = copy[i];
        if (b->parent >= 0)
            b->parent = (int32_t)new_index[b->parent];
    }
    for (size_t k = 0; k < d->description->link_count; k++)
        if (d->link[k].present && d->frame[k].body >= 0)
            d->frame[k].body = (int32_t)new_index[d->frame[k].body];
    for (size_t j = 0; j < d->description->joint_count; j++)
        if (draft_moves(d, j))
            d->joint[j].body = (int32_t)new_index[d->joint[j].body];
}

static void number_joints(struct draft *d)
{
    uint32_t q = 0, v = 0;
    for (size_t k = 0; k < d->description->joint_count; k++) {
        struct draft_joint *joint = &d->joint[d->order[k]];
        const tfa_joint_type_info type =
            tfa_joint_type_describe(d->description->joints[d->order[k]].type);
        if (joint->fate != TFA_FATE_MOVES && joint->fate != TFA_FATE_FUSED)
            continue;
        joint->number = d->joints++;
        joint->q_index = q;
        joint->v_index = v;
        q += type.coordinates;
        v += type.freedoms;
    }
    d->q_count = q;
    d->v_count = v;
}

static void number_frames(struct draft *d)
{
    for (size_t k = 0; k < d->description->link_count; k++)
        if (d->link[k].present)
            d->frame[k].number = d->frames++;
}

int tfa_draft_sort(struct draft *d, tfa_report *report)
{
    (void)report;
    const size_t n = d->bodies + 1u;
    uint32_t *new_index = calloc(n, sizeof *new_index), *tree = calloc(n, sizeof *tree);
    uint32_t *start = calloc(n, sizeof *start);
    struct draft_body *copy = malloc(n * sizeof *copy);
    int status = new_index && tree && start && copy ? TFA_OK : TFA_E_MEMORY;
    if (status == TFA_OK) {
        order_bodies(d, new_index, tree, start);
        move_bodies(d, new_index, copy);
        number_joints(d);
        number_frames(d);
    }
    free(copy);
    free(start);
    free(tree);
    free(new_index);
    return status;
}
