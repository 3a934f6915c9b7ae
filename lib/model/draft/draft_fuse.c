/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Fusion of massless bodies: a body without mass that carries one other body becomes part of that
 * body's joint. This is exact, because a massless body transmits forces unchanged. Armature stays
 * with its freedom.
 */
#include <stdlib.h>
#include <string.h>

#include "model/draft/draft.h"

struct fusion {
    uint32_t *children;      /* of each body */
    uint32_t *joints_in_row; /* joints fused here: 1 for an ordinary body */
    uint32_t *next;          /* body that it is fused with; 0: none */
    int32_t *new_index;      /* new index; -1: fused with another body */
};

static int is_massless(const struct draft_body *b)
{
    for (int k = 0; k < 6; k++)
        if (b->sum.I[k] != 0)
            return 0;
    return b->sum.mass == 0 && !b->loaded && !b->base && b->n == 1;
}

static int count_rows(const struct draft *d, struct fusion *f, tfa_report *report)
{
    const tfa_description *s = d->description;
    int status = TFA_OK;
    for (uint32_t i = 0; i < d->bodies; i++)
        if (d->body[i].parent >= 0)
            f->children[d->body[i].parent]++;
    for (uint32_t i = 0; i < d->bodies; i++) {
        const struct draft_body *b = &d->body[i];
        const int32_t up = b->parent;
        f->joints_in_row[i] = 1;
        if (up < 0 || b->n != 1 || f->children[up] != 1 || !is_massless(&d->body[up]))
            continue;
        f->joints_in_row[i] = f->joints_in_row[up] + 1;
        f->new_index[up] = -1;
        f->next[up] = i;
        if (f->joints_in_row[i] != TFA_PARTS_MAX + 1)
            continue; /* one message for each chain */
        tfa_report_add(report, TFA_ERROR, s->joints[b->joint].line, "massless-chain",
                       "joint '%s': more than %d joints in a row with nothing but massless links "
                       "between them; give link '%s' mass, or lock some of the joints",
                       s->joints[b->joint].name, TFA_PARTS_MAX, s->links[d->body[up].link].name);
        status = TFA_E_MODEL;
    }
    return status;
}

static void make_part(struct draft *d, const struct draft_body *from, uint32_t at, uint32_t k)
{
    struct draft_part *part = &d->part[at + k];
    struct draft_joint *joint = &d->joint[from->joint];
    memcpy(part->E, from->E, sizeof part->E);
    memcpy(part->r, from->r, sizeof part->r);
    part->kind = from->kind;
    part->joint = (uint32_t)from->joint;
    joint->freedom = (uint8_t)k;
    if (joint->fate == TFA_FATE_MOVES)
        joint->fate = TFA_FATE_FUSED;
}

/* The joints that end at body i become its parts, the one nearest the root first. */
static void make_fused(struct draft *d, uint32_t i, uint32_t count)
{
    struct draft_body *b = &d->body[i];
    const struct draft_body *from = b;
    b->first = d->parts;
    d->parts += count;
    for (uint32_t k = count; k-- > 0;) {
        make_part(d, from, b->first, k);
        d->joint[from->joint].body = (int32_t)i;
        if (k > 0)
            from = &d->body[from->parent];
    }
    b->parent = from->parent;
    b->kind = TFA_KIND_FUSED;
    b->n = (uint8_t)count;
    b->armature = 0;
    ext_identity(b->E);
    memset(b->r, 0, sizeof b->r);
}

/* Moves frames of fused bodies to the body that replaces them. */
static void move_frames(struct draft *d, const struct fusion *f)
{
    for (size_t k = 0; k < d->description->link_count; k++) {
        struct draft_frame *frame = &d->frame[k];
        if (!d->link[k].present || frame->body < 0 || f->new_index[frame->body] >= 0)
            continue;
        const int32_t joint = d->body[frame->body].joint;
        frame->part = (uint8_t)(d->joint[joint].freedom + 1);
        frame->body = d->joint[joint].body;
    }
}

static void close_gaps(struct draft *d, struct fusion *f)
{
    const tfa_description *s = d->description;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < d->bodies; i++) {
        if (f->new_index[i] < 0)
            continue;
        f->new_index[i] = (int32_t)kept;
        if (d->body[i].parent >= 0)
            d->body[i].parent = f->new_index[d->body[i].parent];
        d->body[kept++] = d->body[i];
    }
    for (size_t k = 0; k < s->link_count; k++)
        if (d->link[k].present && d->frame[k].body >= 0)
            d->frame[k].body = f->new_index[d->frame[k].body];
    for (size_t j = 0; j < s->joint_count; j++)
        if (draft_moves(d, j))
            d->joint[j].body = f->new_index[d->joint[j].body];
    d->bodies = kept;
}

static int fuse(struct draft *d, struct fusion *f, tfa_report *report)
{
    int status = count_rows(d, f, report);
    if (status == TFA_OK)
        status = tfa_draft_check_massless(d, f->next, report);
    if (status != TFA_OK)
        return status;
    for (uint32_t i = 0; i < d->bodies; i++)
        if (f->new_index[i] >= 0 && f->joints_in_row[i] > 1)
            make_fused(d, i, f->joints_in_row[i]);
    move_frames(d, f);
    close_gaps(d, f);
    return TFA_OK;
}

int tfa_draft_fuse(struct draft *d, tfa_report *report)
{
    const size_t n = d->bodies + 1u;
    struct fusion f = {calloc(n, sizeof *f.children), calloc(n, sizeof *f.joints_in_row),
                       calloc(n, sizeof *f.next), calloc(n, sizeof *f.new_index)};
    int status = TFA_E_MEMORY;
    if (f.children && f.joints_in_row && f.next && f.new_index)
        status = fuse(d, &f, report);
    free(f.new_index);
    free(f.next);
    free(f.joints_in_row);
    free(f.children);
    return status;
}
