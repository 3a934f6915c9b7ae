/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Trees of a fixed base are independent unless mimics couple them: those without a tip of the scene
 * are removed.
 */
#include <stdlib.h>

#include "model/draft/draft.h"

/* Sets of coupled trees (union-find), by the first joint of each tree */
struct trees {
    int32_t *of_link; /* first joint of its tree; -1: fixed to the world */
    uint32_t *up;     /* by joint: parent in the set */
    uint8_t *kept;    /* by root of a set */
};

static uint32_t find_set(struct trees *t, uint32_t tree)
{
    while (t->up[tree] != tree) {
        t->up[tree] = t->up[t->up[tree]];
        tree = t->up[tree];
    }
    return tree;
}

static void assign_trees(const struct draft *d, struct trees *t)
{
    const tfa_description *s = d->description;
    t->of_link[d->root] = -1;
    for (size_t k = 0; k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        const tfa_joint *joint = &s->joints[j];
        t->up[j] = j;
        if (d->joint[j].fate == TFA_FATE_ABSENT)
            continue;
        t->of_link[joint->child] = t->of_link[joint->parent];
        if (t->of_link[joint->child] < 0 && draft_moves(d, j))
            t->of_link[joint->child] = (int32_t)j;
    }
}

static void merge_coupled_trees(const struct draft *d, struct trees *t)
{
    const tfa_description *s = d->description;
    for (size_t j = 0; j < s->joint_count; j++) {
        if (d->joint[j].fate != TFA_FATE_FOLLOWS)
            continue;
        const tfa_joint *leader = &s->joints[d->joint[j].leader];
        uint32_t a = find_set(t, (uint32_t)t->of_link[s->joints[j].child]);
        uint32_t b = find_set(t, (uint32_t)t->of_link[leader->child]);
        t->up[a] = b;
    }
}

static void remove_trees(struct draft *d, struct trees *t)
{
    const tfa_description *s = d->description;
    for (size_t k = 0; k < s->link_count; k++)
        if (d->link[k].tip && t->of_link[k] >= 0)
            t->kept[find_set(t, (uint32_t)t->of_link[k])] = 1;
    for (size_t j = 0; j < s->joint_count; j++) {
        const uint32_t child = s->joints[j].child;
        if (d->joint[j].fate == TFA_FATE_ABSENT || t->of_link[child] < 0 ||
            t->kept[find_set(t, (uint32_t)t->of_link[child])])
            continue;
        d->joint[j].fate = TFA_FATE_ABSENT;
        d->link[child].present = 0;
    }
}

int tfa_draft_trees(struct draft *d, tfa_report *report)
{
    (void)report;
    const tfa_scene *scene = d->options->scene;
    if (!scene || scene->tip_count == 0 || d->options->base == TFA_BASE_FLOATING)
        return TFA_OK;
    const size_t joints = d->description->joint_count + 1;
    struct trees t = {calloc(d->description->link_count, sizeof *t.of_link),
                      calloc(joints, sizeof *t.up), calloc(joints, 1)};
    int status = t.of_link && t.up && t.kept ? TFA_OK : TFA_E_MEMORY;
    if (status == TFA_OK) {
        assign_trees(d, &t);
        merge_coupled_trees(d, &t);
        remove_trees(d, &t);
    }
    free(t.kept);
    free(t.up);
    free(t.of_link);
    return status;
}
