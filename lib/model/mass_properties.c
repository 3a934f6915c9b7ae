/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The masses of a model with its payloads.
 */
#include "model/mass_properties.h"

#include <math.h>
#include <string.h>

#include "model/eigen.h"
#include "model/ext.h"
#include "model/payload.h"
#include "model/sizes.h"

/* A principal moment this far below the moments about the joint is rounding: a point or a rod. */
#define FLAT_MOMENT 1e-15L

/* Bodies with their payloads; returns the mass of the payloads. */
static ext add_payloads(const struct tfa_model *m, struct tfa_mass_scratch *mass_scratch,
                        const tfa_payload *payloads, size_t count)
{
    ext mass = 0;
    for (uint32_t i = 0; i <= m->bodies; i++)
        mass_scratch[i].sum = m->without_payload[i];
    for (size_t k = 0; k < count; k++) {
        int32_t frame = tfa_model_find_frame(m, payloads[k].link);
        if (frame < 0)
            continue;
        const struct tfa_frame *f = &m->frame[frame];
        const uint32_t body = f->body < 0 ? m->bodies : (uint32_t)f->body;
        tfa_mass_properties_add_payload(&mass_scratch[body].sum, &m->frame_quad[frame],
                                        &payloads[k]);
        mass += payloads[k].mass;
    }
    return mass;
}

static void round_body(struct tfa_body *b, struct tfa_body_quad *quad,
                       const struct tfa_mass_properties *sum)
{
    quad->mass = *sum;
    b->quad = quad;
    b->mass = (double)sum->mass;
    ext_round_vector(b->h, sum->h, sum->mass * ext_hypot(b->r[0], ext_hypot(b->r[1], b->r[2])));
    ext_round_inertia(b->I, sum->I);
    b->regular = tfa_inertia_is_regular(b);
}

/* Gyration radii and condition from the principal moments about the centre of mass. */
static void fill_moments(tfa_body_info *info, const struct tfa_mass_properties *sum, const ext c[3])
{
    const ext m = sum->mass, cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    long double central[6], value[3];
    for (int k = 0; k < 6; k++)
        central[k] = (long double)(sum->I[k] - m * ((ext_row[k] == ext_col[k] ? cc : 0) -
                                                    c[ext_row[k]] * c[ext_col[k]]));
    tfa_eigen(central, value, NULL);
    for (int k = 0; k < 3; k++)
        if (value[k] < FLAT_MOMENT * (long double)(sum->I[0] + sum->I[3] + sum->I[5]))
            value[k] = 0;
    info->gyration_min = (double)sqrtl(value[0] / (long double)m);
    info->gyration_max = (double)sqrtl(value[2] / (long double)m);
    info->condition = value[0] > 0 ? (double)(value[2] / value[0]) : (double)INFINITY;
}

static void fill_body_info(const struct tfa_model *m, const struct tfa_body *b, tfa_body_info *info,
                           const struct tfa_mass_properties *sum)
{
    const struct tfa_frame *f = &m->frame[b->link];
    ext c[3] = {0, 0, 0}, R[9], from[3], com[3];
    info->name = f->name;
    info->parent = b->parent;
    info->freedoms = b->n;
    info->mass = b->mass;
    info->regular = b->regular;
    info->gyration_min = info->gyration_max = info->condition = (double)NAN;
    for (int k = 0; sum->mass > 0 && k < 3; k++)
        c[k] = sum->h[k] / sum->mass;
    ext_from_double(R, f->R, 9);
    for (int k = 0; k < 3; k++)
        from[k] = c[k] - f->p[k];
    ext_apply_transposed(com, R, from); /* in the frame of the link that gives the name */
    ext_round(info->com, com, 3);
    if (sum->mass > 0)
        fill_moments(info, sum, c);
}

/* R <- R E^T Rz(q), p <- p + R r, or along z: across one joint with one freedom */
static void advance_pose(ext R[9], ext p[3], const double *E, const double *r, int prismatic, ext q)
{
    ext T[9], Tt[9], at[3], turned[9];
    const ext along = prismatic ? q : 0;
    ext s = 0, c = 1;
    if (!prismatic && q != 0)
        TFA_QUAD_SINCOS(q, &s, &c);
    ext_from_double(T, E, 9);
    for (int k = 0; k < 3; k++)
        at[k] = r[k] + along * T[6 + k];
    ext to[3];
    ext_apply(to, R, at, p);
    memcpy(p, to, sizeof to);
    ext_transpose(Tt, T);
    ext_mul(turned, R, Tt);
    for (int k = 0; k < 9; k += 3) {
        R[k] = c * turned[k] + s * turned[k + 1];
        R[k + 1] = c * turned[k + 1] - s * turned[k];
        R[k + 2] = turned[k + 2];
    }
}

/* Where body i stands when q is 0: followers at their offsets. */
static void pose_at_zero(const struct tfa_model *m, const struct tfa_body *body,
                         struct tfa_mass_scratch *mass_scratch, uint32_t i)
{
    const struct tfa_body *b = &body[i];
    struct tfa_mass_scratch *w = &mass_scratch[i];
    ext_identity(w->R);
    memset(w->p, 0, sizeof w->p);
    if (b->base)
        return;
    if (b->parent >= 0) {
        memcpy(w->R, mass_scratch[b->parent].R, sizeof w->R);
        memcpy(w->p, mass_scratch[b->parent].p, sizeof w->p);
    }
    const struct tfa_coordinate *q = m->coordinate + b->q;
    if (!is_fused(b->kind))
        advance_pose(w->R, w->p, b->E, b->r, is_prismatic(b->kind), b->n == 1 ? q->offset : 0);
    for (uint32_t k = 0; is_fused(b->kind) && k < b->n; k++) {
        const struct tfa_part *part = &m->part[b->part + k];
        advance_pose(w->R, w->p, part->E, part->r, is_prismatic(part->kind), q[k].offset);
    }
}

/* Masses and centre of mass of all there is */
static void sum_masses(struct tfa_model *m, const struct tfa_body *body,
                       struct tfa_mass_scratch *mass_scratch, ext payloads)
{
    tfa_model_summary *s = &m->summary;
    const struct tfa_mass_properties *world = &mass_scratch[m->bodies].sum;
    const ext total = m->mass_without_payload + payloads;
    ext moving = 0, h[3] = {world->h[0], world->h[1], world->h[2]};
    for (uint32_t i = 0; i < m->bodies; i++) {
        struct tfa_mass_scratch *w = &mass_scratch[i];
        ext at[3];
        pose_at_zero(m, body, mass_scratch, i);
        moving += w->sum.mass;
        ext_apply(at, w->R, w->sum.h, h);
        for (int k = 0; k < 3; k++)
            h[k] = at[k] + w->sum.mass * w->p[k];
    }
    s->total_mass = (double)total;
    s->moving_mass = (double)moving;
    for (int k = 0; k < 3; k++)
        s->com[k] = total > 0 ? (double)(h[k] / total) : 0;
}

/* Children come after parents: sum backwards. */
static uint32_t count_massless_followers(const struct tfa_model *m, const struct tfa_body *body,
                                         struct tfa_mass_scratch *mass_scratch)
{
    uint32_t massless_followers = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        mass_scratch[i].has_mass =
            body[i].mass > 0 || body[i].I[0] + body[i].I[3] + body[i].I[5] > 0;
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &body[i];
        if (b->parent >= 0)
            mass_scratch[b->parent].has_mass |= mass_scratch[i].has_mass;
        for (uint32_t k = b->v; k < b->v + b->n; k++)
            massless_followers += !mass_scratch[i].has_mass && !(m->armature[k] > 0);
    }
    return massless_followers;
}

/* The first body on a main chain that cannot be inverted */
static int32_t find_singular_body(const struct tfa_model *m, const struct tfa_body *body)
{
    for (uint32_t t = 0; t < m->trees; t++)
        for (uint32_t k = 0; k < m->chain[t].length; k++)
            if (!body[m->chain[t].body[k]].regular)
                return (int32_t)m->chain[t].body[k];
    return -1;
}

void tfa_compute_mass_properties(struct tfa_model *m, struct tfa_body *body,
                                 struct tfa_body_quad *quad, tfa_body_info *info,
                                 struct tfa_mass_scratch *mass_scratch, const tfa_payload *payloads,
                                 size_t payload_count)
{
    const ext mass = add_payloads(m, mass_scratch, payloads, payload_count);
    for (uint32_t i = 0; i < m->bodies; i++) {
        round_body(&body[i], &quad[i], &mass_scratch[i].sum);
        fill_body_info(m, &body[i], &info[i], &mass_scratch[i].sum);
    }
    sum_masses(m, body, mass_scratch, mass);
    m->massless_followers = count_massless_followers(m, body, mass_scratch);
    m->summary.singular_body = find_singular_body(m, body);
    tfa_compute_sizes(m, body, mass_scratch);
}

void tfa_compute_links(const struct tfa_model *m, struct tfa_link_mass *link,
                       struct tfa_mass_properties *quad, const tfa_payload *payloads,
                       size_t payload_count)
{
    for (uint32_t k = 0; k < m->frames; k++)
        quad[k] = m->link_without_payload[k];
    for (size_t k = 0; k < payload_count; k++) {
        const int32_t frame = tfa_model_find_frame(m, payloads[k].link);
        if (frame >= 0)
            tfa_mass_properties_add_payload(&quad[frame], &m->frame_quad[frame], &payloads[k]);
    }
    for (uint32_t k = 0; k < m->frames; k++) {
        link[k].quad = &quad[k];
        link[k].mass = (double)quad[k].mass;
        ext_round_vector(link[k].h, quad[k].h, 0);
        ext_round_inertia(link[k].I, quad[k].I);
    }
}

void tfa_model_parameters(const tfa_model *model, uint32_t frame, double parameters[10])
{
    ext R[9], p[3], h[3], out[10] = {0}, moved[3];
    const struct tfa_frame *f = frame < model->frames ? &model->frame[frame] : NULL;
    const int has_mass = f && f->body >= 0 && !f->part;
    if (has_mass) {
        const struct tfa_mass_properties *of = &model->body[f->body].quad->mass;
        ext I[9], turned[9], Rt[9];
        memcpy(R, model->frame_quad[frame].E, sizeof R);
        memcpy(p, model->frame_quad[frame].r, sizeof p);
        const ext hp = of->h[0] * p[0] + of->h[1] * p[1] + of->h[2] * p[2],
                  pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        for (int k = 0; k < 3; k++)
            h[k] = of->h[k] - of->mass * p[k];
        ext_apply_transposed(moved, R, h);
        for (int e = 0; e < 6; e++) { /* about p: sum of m ((x-p).(x-p) 1 - (x-p)(x-p)^T) */
            const int i = ext_row[e], j = ext_col[e];
            I[3 * i + j] = of->I[e] + of->h[i] * p[j] + p[i] * of->h[j] - of->mass * p[i] * p[j] +
                           (i == j ? of->mass * pp - 2 * hp : 0);
            I[3 * j + i] = I[3 * i + j];
        }
        ext_transpose(Rt, R);
        ext_mul(turned, Rt, I);
        ext_mul(I, turned, R);
        out[0] = of->mass;
        memcpy(out + 1, moved, sizeof moved);
        for (int e = 0; e < 6; e++)
            out[4 + e] = I[3 * ext_row[e] + ext_col[e]];
    }
    ext_round(parameters, out, 10);
}
