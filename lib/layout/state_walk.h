/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Places the arrays of struct state in memory: one walk gives their size and the pointers. The
 * layout defines state_read_model.
 */
#ifndef TFA_LAYOUT_STATE_WALK_H
#define TFA_LAYOUT_STATE_WALK_H

#include <string.h>

#include "layout/state_struct.h"
#include "model/arena.h"

static inline struct extent model_extent(const struct tfa_model *m, struct tfa_reserved reserved)
{
    return (struct extent){m->bodies, m->inner_q, m->freedoms, reserved.methods, reserved.tips};
}

/* One walk: with a base it places the state and its arrays, without it only counts. */
static inline size_t state_walk(const struct tfa_model *m, struct extent n, void *base,
                                struct state **out)
{
    struct arena a = {base, 0};
    const size_t nb = n.bodies, nq = n.coordinates, nv = n.freedoms;
    struct state *s = arena_alloc(&a, 1, sizeof *s), count_only;
    struct state *o = s ? s : &count_only;
#define TFA_STATE_TAKE(type, name, count, unit, frame, meaning)                                    \
    o->name = arena_alloc(&a, (count) + 1, sizeof(type));
    TFA_STATE_ARRAYS(TFA_STATE_TAKE)
#undef TFA_STATE_TAKE
    o->m = m;
    o->bodies = n.bodies;
    o->coordinates = n.coordinates;
    o->freedoms = n.freedoms;
    o->methods = n.methods;
    state_read_model(o);
    *out = s;
    return a.used;
}

/* The backward pass is complete: the factors replace those of TFA's side branches and of locked
 * joints. */
static inline void have_aba(struct state *s)
{
    s->have = (s->have | HAVE_ABA) & ~(uint32_t)(HAVE_CHAIN | HAVE_LOCKED);
}

/* H of planar and free joints, which is constant: unit axes, linear freedoms first (pose.c). */
void TFA_V(unit_axes)(struct state *s);

/* A state in memory of that size, all zero but for the constants. */
static inline struct state *state_init(const struct tfa_model *m, struct extent n, void *memory)
{
    struct state *s;
    memset(memory, 0, state_walk(m, n, NULL, &s));
    (void)state_walk(m, n, memory, &s);
    TFA_V(unit_axes)(s);
    return s;
}

#endif
