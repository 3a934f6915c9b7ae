/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies of a compiled model: modes of the link, and of the links that ride rigidly on its
 * handles, in the frame of the body.
 */
#include <math.h>

#include "model/compile/compile.h"

/* The numbers of one flexible body, before they are rounded */
struct sums {
    ext B[TFA_MAX_LINK_MODES][6]; /* angular first */
    ext G[TFA_MAX_LINK_MODES][9]; /* first moment, moments of inertia */
    ext M[TFA_MAX_LINK_MODES][TFA_MAX_LINK_MODES];
};

/* I += 2 (a . b) 1 - (a b^T + b a^T) */
static void add_moments(ext *I, const ext *a, const ext *b)
{
    const ext trace = 2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    for (int e = 0; e < 6; e++)
        I[e] += (ext_row[e] == ext_col[e] ? trace : 0) - a[ext_row[e]] * b[ext_col[e]] -
                b[ext_row[e]] * a[ext_col[e]];
}

/* The flexible link: its own moments of inertia about its own origin do not change. */
static void add_own(const struct draft *d, const struct draft_flexible *x, struct sums *s)
{
    const size_t n = x->modes->mode_count;
    for (size_t k = 0; k < n; k++) {
        tfa_draft_momentum(d, x, k, s->B[k], s->B[k] + 3);
        for (int e = 0; e < 3; e++)
            s->G[k][e] = s->B[k][3 + e];
        add_moments(s->G[k] + 3, d->frame[x->link].p, s->G[k]);
        for (size_t j = 0; j < n; j++)
            s->M[k][j] = (x->modes->mass[n * k + j] + x->modes->mass[n * j + k]) / 2;
    }
}

/* Motion of a handle by a mode as that of the body's origin: rotation, translation */
static void handle_motion(const struct tfa_handle *h, size_t k, ext t[3], ext v[3])
{
    ext p[3];
    ext_from_double(t, h->shape + 6 * k, 3);
    ext_from_double(v, h->shape + 6 * k + 3, 3);
    ext_from_double(p, h->p, 3);
    ext_add_cross(v, p, t);
}

/* A link of inertia (m, h, I about the body's origin) that rides on a handle */
static void add_rider(const struct tfa_handle *handle, size_t n,
                      const struct tfa_mass_properties *m, struct sums *s)
{
    ext t[TFA_MAX_LINK_MODES][3], v[TFA_MAX_LINK_MODES][3];
    for (size_t k = 0; k < n; k++)
        handle_motion(handle, k, t[k], v[k]);
    for (size_t k = 0; k < n; k++) {
        ext momentum[6] = {0}, I[9], turned[3], *G = s->G[k];
        for (int e = 0; e < 6; e++) {
            I[3 * ext_row[e] + ext_col[e]] = I[3 * ext_col[e] + ext_row[e]] = m->I[e];
        }
        for (int e = 0; e < 3; e++) {
            momentum[e] = I[3 * e] * t[k][0] + I[3 * e + 1] * t[k][1] + I[3 * e + 2] * t[k][2];
            momentum[3 + e] = m->mass * v[k][e];
        }
        ext_add_cross(momentum, m->h, v[k]);
        ext_add_cross(momentum + 3, t[k], m->h);
        for (size_t j = 0; j < n; j++)
            for (int e = 0; e < 3; e++)
                s->M[j][k] += t[j][e] * momentum[e] + v[j][e] * momentum[3 + e];
        for (int e = 0; e < 3; e++)
            G[e] += momentum[3 + e]; /* m v + t x h */
        for (int e = 0; e < 6; e++)
            s->B[k][e] += momentum[e];
        add_moments(G + 3, m->h, v[k]);
        for (int e = 0; e < 6; e++) { /* [t] I - I [t], row by row: t x column, and transposed */
            const int a = ext_row[e], b = ext_col[e];
            for (int side = 0; side < 2; side++) {
                const int i = side ? b : a, j = side ? a : b;
                ext column[3] = {I[j], I[3 + j], I[6 + j]};
                turned[0] = turned[1] = turned[2] = 0;
                ext_add_cross(turned, t[k], column);
                G[3 + e] += turned[i];
            }
        }
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
    struct sums s = {0};
    add_own(d, x, &s);
    for (size_t k = 0; k < d->description->link_count; k++) {
        const int32_t handle = d->link[k].present ? d->link[k].handle : -1;
        if (handle >= 0 && l->handle[handle].flexible == i)
            add_rider(&l->handle[handle], n, l->link[d->frame[k].number].quad, &s);
    }
    *to = (struct tfa_flexible){.body = x->body,
                                .frame = d->frame[x->link].number,
                                .n = (uint32_t)n,
                                .first = m->modes,
                                .v = m->freedoms - d->modes + m->modes};
    to->B = *pool;
    for (size_t k = 0; k < n; k++)
        (void)keep(pool, s.B[k], 6);
    to->G = *pool;
    for (size_t k = 0; k < n; k++)
        (void)keep(pool, s.G[k], 9);
    to->M = *pool;
    for (size_t k = 0; k < n; k++)
        (void)keep(pool, s.M[k], n);
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
        numbers += n * (6 + 9 + 3 * n + 1);
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
}
