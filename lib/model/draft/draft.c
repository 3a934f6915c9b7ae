/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Making and releasing a draft.
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
    if (!d->link || !d->frame || !d->joint || !d->body || !d->part || !d->mass_scratch || !d->order)
        return TFA_E_MEMORY;
    for (size_t j = 0; j < joints; j++)
        d->joint[j].leader = d->joint[j].body = -1;
    return TFA_OK;
}

/* What is part of it, and what of that moves. */
static int decide_fates(struct draft *d, tfa_report *report)
{
    int status = tfa_draft_scene(d, report);
    if (status == TFA_OK)
        status = tfa_draft_locks(d, report);
    if (status == TFA_OK)
        status = tfa_draft_mimics(d, report);
    if (status == TFA_OK)
        status = tfa_draft_trees(d);
    if (status == TFA_OK)
        status = tfa_draft_inertias(d, report);
    if (status == TFA_OK)
        status = tfa_draft_leaves(d, report);
    return status;
}

static int make_bodies(struct draft *d, tfa_report *report)
{
    int status = tfa_draft_merge(d, report);
    if (status == TFA_OK)
        status = tfa_draft_base(d, report);
    if (status == TFA_OK)
        status = tfa_draft_fuse(d, report);
    if (status == TFA_OK)
        status = tfa_draft_singular(d, report);
    if (status == TFA_OK)
        tfa_draft_axial(d);
    if (status == TFA_OK)
        status = tfa_draft_sort(d);
    if (status == TFA_OK) {
        tfa_draft_note_unused(d, report);
        if (d->options->base == TFA_BASE_FIXED)
            tfa_draft_note_base(d, report);
    }
    return status;
}

int tfa_draft_make(struct draft *d, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report)
{
    static const tfa_model_options defaults = {0};
    memset(d, 0, sizeof *d);
    d->description = description;
    d->options = options ? options : &defaults;
    int status = allocate(d, description);
    if (status == TFA_OK)
        status = tfa_draft_order(d, report);
    if (status == TFA_OK)
        status = tfa_draft_values(d, report);
    if (status == TFA_OK)
        status = decide_fates(d, report);
    if (status == TFA_OK)
        status = make_bodies(d, report);
    return status;
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
    memset(d, 0, sizeof *d);
}
