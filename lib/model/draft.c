/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Making and releasing a draft.
 */
#include "model/draft.h"

#include <stdlib.h>
#include <string.h>

static int allocate(struct draft *d, const tfa_description *s)
{
    d->body = calloc(s->joint_count + 1, sizeof *d->body);
    d->frame = calloc(s->link_count + 1, sizeof *d->frame);
    d->order = calloc(s->joint_count + 1, sizeof *d->order);
    d->joint_body = calloc(s->joint_count + 1, sizeof *d->joint_body);
    return d->body && d->frame && d->order && d->joint_body ? TFA_OK : TFA_E_MEMORY;
}

int tfa_draft_make(struct draft *d, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report)
{
    memset(d, 0, sizeof *d);
    d->description = description;
    int status = allocate(d, description);
    if (status == TFA_OK)
        status = tfa_draft_order(d, report);
    if (status == TFA_OK)
        status = tfa_draft_values(d, options, report);
    if (status == TFA_OK)
        status = tfa_draft_merge(d, options, report);
    if (status == TFA_OK)
        status = tfa_draft_check(d, report);
    return status;
}

void tfa_draft_free(struct draft *d)
{
    free(d->body);
    free(d->frame);
    free(d->order);
    free(d->joint_body);
    memset(d, 0, sizeof *d);
}
