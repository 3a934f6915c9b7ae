/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ways between the origins of joints, at q = 0 where a joint slides, and masses. All have the
 * units of the model, so that nothing depends on them.
 */
#include "model/sizes.h"

#include <math.h>

static double norm(const double *x)
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* From the origin of the parent's frame along the joint's parts to that of the body's */
static double distance(const struct tfa_model *m, const struct tfa_body *b)
{
    if (!is_fused(b->kind))
        return norm(b->r);
    double sum = 0;
    for (uint32_t k = 0; k < b->n; k++)
        sum += norm(m->part[b->part + k].r);
    return sum;
}

/* Share of the longest path */
#define LENGTH_SHARE 0.25

/* A quarter of the longest way from a root along joints to a centre of mass, at any q. 1 where
 * there is no way. */
static double characteristic_length(const struct tfa_model *m, const struct tfa_body *body,
                                    struct tfa_mass_scratch *scratch)
{
    double longest = 0;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &body[i];
        const double way = distance(m, b) + (b->parent >= 0 ? scratch[b->parent].length : 0);
        scratch[i].length = way;
        longest = fmax(longest, way + (b->mass > 0 ? norm(b->h) / b->mass : 0));
    }
    return longest > 0 ? LENGTH_SHARE * longest : 1;
}

/* Of each joint outboard, twice the square of its distance, half as much for each joint between:
 * where a lever is long the rounding of what it moved is large. The longest counts. Returns that of
 * all bodies. */
static double compute_levers(const struct tfa_model *m, const struct tfa_body *body,
                             struct tfa_mass_scratch *scratch)
{
    double longest = 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        scratch[i].length = 0;
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &body[i];
        const double d = distance(m, b), lever = scratch[i].length;
        longest = fmax(longest, lever);
        if (b->parent >= 0)
            scratch[b->parent].length = fmax(scratch[b->parent].length, 2 * d * d + lever / 2);
    }
    return longest;
}

/* Largest traces of the inertia and of the mass of a single body outboard, at the lever of the
 * joint: joints may take all of it away, its rounding stays. Sums would be as large as no rounding
 * is, and trip for long chains. */
static void compute_outboard(const struct tfa_model *m, struct tfa_body *body,
                             const struct tfa_mass_scratch *scratch)
{
    for (uint32_t i = 0; i < m->bodies; i++)
        body[i].outboard[0] = body[i].outboard[1] = 0;
    for (uint32_t i = m->bodies; i-- > 0;) {
        struct tfa_body *b = &body[i];
        if (b->parent >= 0) {
            double *to = body[b->parent].outboard;
            to[0] = fmax(to[0], fmax(b->outboard[0], b->I[0] + b->I[3] + b->I[5]));
            to[1] = fmax(to[1], fmax(b->outboard[1], 3 * b->mass));
        }
        b->outboard[0] += scratch[i].length * b->outboard[1];
    }
}

void tfa_compute_sizes(struct tfa_model *m, struct tfa_body *body, struct tfa_mass_scratch *scratch)
{
    m->length = characteristic_length(m, body, scratch);
    m->lever = compute_levers(m, body, scratch);
    compute_outboard(m, body, scratch);
}
