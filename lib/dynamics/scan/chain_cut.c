/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cuts outboard of heavy bodies.
 */
#include "dynamics/scan/chain_cut.h"

/* A cut moves away from the middle for a ratio this many times smaller. */
#define RATIO_GAIN 1.5
/* Bodies beyond a cut that enter its ratio. */
#define LOOKAHEAD 4u

/* Shorter chains are faster body by body, longer ones have twice the segments. */
#define SEGMENT_LANES_BODIES_MIN 48u
#define SEGMENT_LANES_BODIES_MANY 256u
/* A cut moves by at most this part of a segment. */
#define SEGMENT_LANES_REACH 8u

/* Inertia outboard of the end of a segment behind body k, in multiples of what its joint moves by
 * itself: the heaviest of the next bodies, held by the next joint, which moves with body k but for
 * its own rotation.
 *   (m |r|^2 + |I| (1 - (z . z')^2)) / D_k     r, z': of the next joint, across z and along it */
static double outboard_ratio(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t k)
{
    const struct tfa_body *b = &body[chain->body[k]], *next = &body[chain->body[k + 1]];
    double mass = 0, moment = 0;
    for (uint32_t j = k + 1; j < chain->length && j <= k + LOOKAHEAD; j++) {
        const struct tfa_body *o = &body[chain->body[j]];
        mass = o->mass > mass ? o->mass : mass;
        moment = o->I[0] + o->I[3] + o->I[5] > moment ? o->I[0] + o->I[3] + o->I[5] : moment;
    }
    if (!is_revolute(b->kind))
        return mass / (b->mass + b->armature);
    const double across = next->r[0] * next->r[0] + next->r[1] * next->r[1];
    const double along = is_revolute(next->kind) ? next->E[8] : 0;
    return (mass * across + moment * (1 - along * along)) / (b->I[5] + b->armature);
}

static int can_cut(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t k,
                   int floating)
{
    const struct tfa_body *next = &body[chain->body[k + 1]];
    return body[chain->body[k]].regular &&
           (!floating || (next->regular && next->n == 1 && !(next->armature > 0)));
}

int64_t tfa_best_cut(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t middle,
                     uint32_t reach, int floating)
{
    int64_t best = -1;
    double least = 0;
    for (uint32_t away = 0; away <= 2 * reach; away++) { /* 0, -1, +1, -2, +2, .. */
        const uint32_t k = away % 2 ? middle - (away + 1) / 2 : middle + away / 2;
        const double ratio = outboard_ratio(body, chain, k);
        if (can_cut(body, chain, k, floating) && (best < 0 || RATIO_GAIN * ratio < least)) {
            best = k;
            least = ratio;
        }
    }
    return best;
}

uint32_t tfa_segment_count(uint32_t length)
{
    return length < SEGMENT_LANES_BODIES_MIN ? 1 : length < SEGMENT_LANES_BODIES_MANY ? 8 : 16;
}

int64_t tfa_segment_end(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t k,
                        int floating)
{
    const uint32_t count = tfa_segment_count(chain->length), length = chain->length / count;
    const uint32_t middle = (uint32_t)((uint64_t)chain->length * (k + 1) / count) - 1;
    return k + 1 == count
               ? middle
               : tfa_best_cut(body, chain, middle, length / SEGMENT_LANES_REACH, floating);
}

static int fits_segment_lanes(const tfa_model *m)
{
    if (m->trees != 1 || m->bodies < SEGMENT_LANES_BODIES_MIN || m->chain[0].length != m->bodies ||
        m->base_freedoms || m->mimics)
        return 0;
    for (uint32_t i = 0; i < m->bodies; i++)
        if (!is_revolute(m->body[i].kind) || m->body[i].armature > 0)
            return 0;
    return 1;
}

struct tfa_chain_segments tfa_cut_segments(const tfa_model *m)
{
    struct tfa_chain_segments s = {
        .count = fits_segment_lanes(m) ? tfa_segment_count(m->bodies) : 0, .shortest = m->bodies};
    for (uint32_t k = 0, end = 0; k < s.count; k++) {
        const int64_t last = tfa_segment_end(m->body, m->chain, k, 0);
        if (last < 0)
            return (struct tfa_chain_segments){0};
        s.first[k] = end;
        end = (uint32_t)last + 1;
        s.length[k] = end - s.first[k];
        s.shortest = s.length[k] < s.shortest ? s.length[k] : s.shortest;
        s.longest = s.length[k] > s.longest ? s.length[k] : s.longest;
    }
    return s;
}
