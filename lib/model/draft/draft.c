/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Creates and releases a draft.
 */
#include "model/draft/draft.h"

#include <stdlib.h>
#include <string.h>

static int allocate(struct draft *d, const tfa_description *s)
{
    const size_t joints = s->joint_count + 1, links = s->link_count + 1;
    d->link = calloc(links, sizeof *d->link);
    d->frame = calloc(links, sizeof *d->frame);
    d->joint = calloc(joints, sizeof *d->joint);
    d->body = calloc(joints, sizeof *d->body);
    d->part = calloc(joints, sizeof *d->part);
    d->mass_scratch = calloc(joints + 1, sizeof *d->mass_scratch);
    d->order = calloc(joints, sizeof *d->order);
    d->flexible = calloc(links, sizeof *d->flexible);
    d->handle = calloc(joints, sizeof *d->handle);
    if (!d->flexible || !d->handle || !d->link || !d->frame || !d->joint || !d->body || !d->part ||
        !d->mass_scratch || !d->order)
        return TFA_E_MEMORY;
    for (size_t j = 0; j < joints; j++)
        d->joint[j].leader = d->joint[j].body = -1;
    return TFA_OK;
}

/* The passes in their order, each of which may refuse the robot */
static int (*const passes[])(struct draft *d, tfa_report *report) = {
    tfa_draft_order,       tfa_draft_values,   tfa_draft_scene,  tfa_draft_locks, tfa_draft_mimics,
    tfa_draft_trees,       tfa_draft_inertias, tfa_draft_leaves, tfa_draft_merge, tfa_draft_base,
    tfa_draft_fuse,        tfa_draft_singular, tfa_draft_axial,  tfa_draft_sort,  tfa_draft_modes,
    tfa_draft_constraints, tfa_draft_actuated};

int tfa_draft_make(struct draft *d, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report)
{
    static const tfa_model_options defaults = {0};
    memset(d, 0, sizeof *d);
    d->description = description;
    d->options = options ? options : &defaults;
    int status = allocate(d, description);
    for (size_t k = 0; status == TFA_OK && k < sizeof passes / sizeof *passes; k++)
        status = passes[k](d, report);
    if (status != TFA_OK)
        return status;
    tfa_draft_note_unused(d, report);
    if (d->options->base == TFA_BASE_FIXED) {
        tfa_draft_note_base(d, report);
        tfa_draft_note_immobile(d, report);
    }
    return TFA_OK;
}

void tfa_draft_free(struct draft *d)
{
    free(d->link);
    free(d->frame);
    free(d->joint);
    free(d->body);
    free(d->part);
    free(d->mass_scratch);
    free(d->order);
    free(d->flexible);
    free(d->handle);
    memset(d, 0, sizeof *d);
}
