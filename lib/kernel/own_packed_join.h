/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What passes between the lanes of a step and those of its parents and children (join.h), in a kernel
 * of one robot's own: who stands where is constant, so that the compiler chooses the moves.
 */
#ifndef TFA_KERNEL_OWN_PACKED_JOIN_H
#define TFA_KERNEL_OWN_PACKED_JOIN_H

#include "kernel/body.h"

/* DO(component) for all components */
#define OWN_SVEC(DO) DO(w.x) DO(w.y) DO(w.z) DO(v.x) DO(v.y) DO(v.z)
#define OWN_SYM6(DO)                                                                               \
    DO(A.xx)                                                                                       \
    DO(A.xy)                                                                                       \
    DO(A.xz)                                                                                       \
    DO(A.yy)                                                                                       \
    DO(A.yz)                                                                                       \
    DO(A.zz) DO(B.xx) DO(B.xy) DO(B.xz) DO(B.yx) DO(B.yy) DO(B.yz) DO(B.zx) DO(B.zy) DO(B.zz)      \
        DO(M.xx) DO(M.xy) DO(M.xz) DO(M.yy) DO(M.yz) DO(M.zz)

/* ---- parents ---- */

/* That of the body in lane l; -1: the world. A lane that holds nobody may have anything that is finite:
 * it goes with the first one. */
TFA_INLINE int32_t own_parent(const terms *b, int l)
{
    return own_body[b->body[l]].parent;
}

/* Does lane l have its parent in the same lane of that step, if it has one? */
TFA_INLINE int own_stands(const terms *b, int l, uint32_t step)
{
    const int32_t p = own_parent(b, l);
    return !(b->held >> l & 1) || (p >= 0 && own_step_of[p] == step && own_lane_of[p] == l);
}

#define OWN_STANDS(l) own_stands(b, l, step)
/* Step of the parent of the body in lane l */
TFA_INLINE uint32_t own_from_step(const terms *b, int l)
{
    const int32_t p = own_parent(b, l);
    return p < 0 ? 0 : own_step_of[p];
}

TFA_INLINE svec parent_motion(const terms *b, const svec *motion, svec world)
{
    if (b->parent < 0)
        return world;
    const uint32_t step = (uint32_t)b->parent;
    if (NUM_EVERY(OWN_STANDS))
        return motion[step];
    svec x;
#define OWN_GET(l, e)                                                                              \
    (own_parent(b, l) < 0 ? world.e[l]                                                             \
                          : motion[own_from_step(b, l)]                                            \
                                .e[own_parent(b, l) < 0 ? 0 : own_lane_of[own_parent(b, l)]])
#if NUM_LANES == 8
#define OWN_PUT(e)                                                                                 \
    x.e = (num){OWN_GET(0, e), OWN_GET(1, e), OWN_GET(2, e), OWN_GET(3, e),                        \
                OWN_GET(4, e), OWN_GET(5, e), OWN_GET(6, e), OWN_GET(7, e)};
#elif NUM_LANES == 4
#define OWN_PUT(e) x.e = (num){OWN_GET(0, e), OWN_GET(1, e), OWN_GET(2, e), OWN_GET(3, e)};
#else
#define OWN_PUT(e) x.e = (num){OWN_GET(0, e), OWN_GET(1, e)};
#endif
    OWN_SVEC(OWN_PUT)
#undef OWN_PUT
#undef OWN_GET
    return x;
}

/* Roots get X 0. */
TFA_INLINE svec moved_along(const struct state *s, uint32_t i, const terms *b)
{
    return b->parent < 0 ? sv_zero() : motion_down(s, i, b, parent_motion(b, s->v, sv_zero()));
}

/* ---- children ---- */

TFA_INLINE void give_inertia(struct state *s, uint32_t i, const sym6 *up, int what)
{
    (void)what; /* FOLD_FRESH: what a step gives stays with it */
    s->IA[i] = *up;
}

TFA_INLINE void give_force(struct state *s, uint32_t i, svec up, int what)
{
    (void)what;
    s->pA[i] = up;
}

/* Child number k of the body in lane l, or -1 */
TFA_INLINE int32_t own_child_of(const terms *b, int l, int k)
{
    return b->held >> l & 1 ? own_child[b->body[l]][k] : -1;
}

/* Does any lane have one? Do all of them, in the same lanes of one step? */
#define OWN_CHILDLESS(l) (own_child_of(b, l, k) < 0)
#define OWN_HANDED(l)                                                                              \
    (!(b->held >> l & 1) ||                                                                        \
     (own_child_of(b, l, k) >= 0 && own_step_of[OWN_SOME(l)] == own_child_step(b, k) &&            \
      own_lane_of[OWN_SOME(l)] == l))
#define OWN_SOME(l) (own_child_of(b, l, k) < 0 ? 0 : own_child_of(b, l, k))

/* The step of the first child that some lane has */
TFA_INLINE uint32_t own_child_step(const terms *b, int k)
{
    for (int l = 0; l < NUM_LANES; l++)
        if (own_child_of(b, l, k) >= 0)
            return own_step_of[own_child_of(b, l, k)];
    return 0;
}

#define OWN_GET(l, e)                                                                              \
    (own_child_of(b, l, k) < 0 ? 0.0                                                               \
                               : OWN_ARRAY[own_step_of[OWN_SOME(l)]].e[own_lane_of[OWN_SOME(l)]])
#if NUM_LANES == 8
#define OWN_TAKE(e)                                                                                \
    x.e += (num){OWN_GET(0, e), OWN_GET(1, e), OWN_GET(2, e), OWN_GET(3, e),                       \
                 OWN_GET(4, e), OWN_GET(5, e), OWN_GET(6, e), OWN_GET(7, e)};
#elif NUM_LANES == 4
#define OWN_TAKE(e) x.e += (num){OWN_GET(0, e), OWN_GET(1, e), OWN_GET(2, e), OWN_GET(3, e)};
#else
#define OWN_TAKE(e) x.e += (num){OWN_GET(0, e), OWN_GET(1, e)};
#endif

#define OWN_ARRAY s->IA
TFA_INLINE sym6 own_take_inertia(const struct state *s, const terms *b, int k, sym6 x)
{
    if (NUM_EVERY(OWN_CHILDLESS))
        return x;
    if (NUM_EVERY(OWN_HANDED))
        s6_add(&x, &s->IA[own_child_step(b, k)]);
    else {
        OWN_SYM6(OWN_TAKE)
    }
    return x;
}
#undef OWN_ARRAY

#define OWN_ARRAY s->pA
TFA_INLINE svec own_take_force(const struct state *s, const terms *b, int k, svec x)
{
    if (NUM_EVERY(OWN_CHILDLESS))
        return x;
    if (NUM_EVERY(OWN_HANDED))
        return sv_add(x, s->pA[own_child_step(b, k)]);
    OWN_SVEC(OWN_TAKE)
    return x;
}
#undef OWN_ARRAY

TFA_INLINE void add_given_inertia(const struct state *s, uint32_t i, sym6 *I)
{
    sym6 x = *I;
#define OWN_ADD(k) x = own_take_inertia(s, &own_step[i], k, x);
    OWN_RANKS(OWN_ADD)
#undef OWN_ADD
    *I = x;
}

TFA_INLINE svec given_force(const struct state *s, uint32_t i)
{
    svec x = sv_zero();
#define OWN_ADD(k) x = own_take_force(s, &own_step[i], k, x);
    OWN_RANKS(OWN_ADD)
#undef OWN_ADD
    return x;
}

#undef OWN_TAKE
#undef OWN_GET

#endif
