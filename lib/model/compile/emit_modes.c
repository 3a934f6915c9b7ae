/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies of a compiled model: modes of the link, and the links that ride rigidly on its
 * handles, in the frame of the body.
 */
#include <math.h>

#include "model/compile/compile.h"

/* The links that are fixed to a handle, payloads included */
static void add_riders(struct layout *l, const struct draft *d, uint32_t number)
{
    struct tfa_mass_properties sum = {0};
    struct tfa_handle *to = &l->handle[number];
    for (size_t k = 0; k < d->description->link_count; k++) {
        if (!d->link[k].present || d->link[k].handle != (int32_t)number)
            continue;
        const struct tfa_mass_properties *m = l->link[d->frame[k].number].quad;
        sum.mass += m->mass;
        for (int e = 0; e < 3; e++)
            sum.h[e] += m->h[e];
        for (int e = 0; e < 6; e++)
            sum.I[e] += m->I[e];
    }
    to->mass = (double)sum.mass;
    ext_round(to->h, sum.h, 3);
    ext_round(to->I, sum.I, 6);
    to->next = -1;
    if (to->mass > 0) {
        to->next = l->flexible[to->flexible].riders;
        l->flexible[to->flexible].riders = (int32_t)number;
    }
}

static const double *keep(double **pool, const ext *from, size_t count)
{
    const double *start = *pool;
    for (size_t k = 0; k < count; k++)
        *(*pool)++ = (double)from[k];
    return start;
}

static const double *keep_doubles(double **pool, const double *from, size_t count, double otherwise)
{
    const double *start = *pool;
    for (size_t k = 0; k < count; k++)
        *(*pool)++ = from ? from[k] : otherwise;
    return start;
}

static void emit_handles(struct layout *l, const struct draft *d, double **pool)
{
    static const ext none[3];
    for (uint32_t k = 0; k < d->handles; k++) {
        const struct draft_handle *from = &d->handle[k];
        const struct draft_flexible *x = &d->flexible[from->flexible];
        const struct draft_frame *f = &d->frame[x->link];
        struct tfa_handle *to = &l->handle[k];
        ext xyz[3], p[3], in[3], out[3];
        ext_from_double(xyz, d->description->joints[from->joint].xyz, 3);
        ext_apply(p, f->R, xyz, f->p);
        ext_round(to->p, p, 3);
        to->flexible = from->flexible;
        to->shape = *pool;
        for (size_t e = 0; e < 2 * x->modes->mode_count; e++) { /* rotation first */
            ext_from_double(in, from->shape + 3 * (e ^ 1), 3);
            ext_apply(out, f->R, in, none);
            (void)keep(pool, out, 3);
        }
    }
}

static void emit_flexible(struct layout *l, const struct draft *d, uint32_t i, double **pool)
{
    const struct draft_flexible *x = &d->flexible[i];
    const size_t n = x->modes->mode_count;
    struct tfa_flexible *to = &l->flexible[i];
    struct tfa_model *m = l->model;
    const struct tfa_mass_properties *link = l->link[d->frame[x->link].number].quad;
    *to = (struct tfa_flexible){.body = x->body,
                                .frame = d->frame[x->link].number,
                                .n = (uint32_t)n,
                                .first = m->modes,
                                .v = m->freedoms - d->modes + m->modes,
                                .mass = (double)link->mass,
                                .riders = -1};
    for (int e = 0; link->mass > 0 && e < 3; e++)
        to->c[e] = (double)(link->h[e] / link->mass);
    to->B = *pool;
    for (size_t k = 0; k < n; k++) {
        ext row[6];
        tfa_draft_momentum(d, x, k, row, row + 3);
        (void)keep(pool, row, 6);
    }
    to->M = *pool;
    for (size_t k = 0; k < n * n; k++)
        *(*pool)++ = (x->modes->mass[k] + x->modes->mass[k % n * n + k / n]) / 2;
    to->K = keep_doubles(pool, x->modes->stiffness, n * n, 0);
    to->D = keep_doubles(pool, x->modes->damping, n * n, 0);
    to->limit = keep_doubles(pool, x->modes->limit, n, (double)INFINITY);
    m->modes += to->n;
}

size_t tfa_modal_numbers(const struct draft *d)
{
    size_t numbers = 0;
    for (uint32_t i = 0; i < d->flexible_bodies; i++) {
        const size_t n = d->flexible[i].modes->mode_count;
        numbers += n * (6 + 3 * n + 1);
    }
    for (uint32_t k = 0; k < d->handles; k++)
        numbers += 6 * d->flexible[d->handle[k].flexible].modes->mode_count;
    return numbers;
}

void tfa_emit_modes(struct layout *l, const struct draft *d)
{
    double *pool = l->modal;
    for (uint32_t i = 0; i < d->bodies; i++) {
        l->body[i].flexible = d->body[i].flexible;
        l->body[i].handle = d->body[i].handle;
    }
    for (size_t k = 0; k < d->description->link_count; k++)
        if (d->link[k].present)
            l->frame[d->frame[k].number].handle = d->link[k].handle;
    emit_handles(l, d, &pool);
    for (uint32_t i = 0; i < d->flexible_bodies; i++)
        emit_flexible(l, d, i, &pool);
    for (uint32_t k = d->handles; k-- > 0;)
        add_riders(l, d, k);
}
