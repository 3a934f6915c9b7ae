/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transfers between the lanes of a step and those of its parents and children
 * (parent_transfer.h), in a specialised kernel: the schedule is constant, so that the
 * compiler chooses the moves.
 */
#ifndef TFA_LAYOUT_SPECIALISED_BODY_LANES_TRANSFER_H
#define TFA_LAYOUT_SPECIALISED_BODY_LANES_TRANSFER_H

#include "layout/body.h"

/* DO(component) for all components */
#define SVEC_COMPONENTS(DO) DO(w.x) DO(w.y) DO(w.z) DO(v.x) DO(v.y) DO(v.z)
#define SYM6_COMPONENTS(DO)                                                                        \
    DO(A.xx)                                                                                       \
    DO(A.xy)                                                                                       \
    DO(A.xz)                                                                                       \
    DO(A.yy)                                                                                       \
    DO(A.yz)                                                                                       \
    DO(A.zz)                                                                                       \
    DO(B.xx)                                                                                       \
    DO(B.xy)                                                                                       \
    DO(B.xz)                                                                                       \
    DO(B.yx) DO(B.yy) DO(B.yz) DO(B.zx) DO(B.zy) DO(B.zz) DO(M.xx) DO(M.xy) DO(M.xz) DO(M.yy)      \
        DO(M.yz) DO(M.zz)

/* ---- parents ---- */

/* That of the body in lane l; -1: the world. An empty lane may have any value that is
 * finite: it goes with the first one. */
TFA_INLINE int32_t parent_of_lane(const body_constants *b, int l)
{
    return robot_body[b->body[l]].parent;
}

/* Whether lane l has its parent in the same lane of that step, or none */
TFA_INLINE int parent_is_in_lane(const body_constants *b, int l, uint32_t step)
{
    const int32_t p = parent_of_lane(b, l);
    return !(b->lane_mask >> l & 1) ||
           (p >= 0 && robot_step_of[p] == step && robot_lane_of[p] == l);
}

#define ROBOT_PARENT_IN_LANE(l) parent_is_in_lane(b, l, step)
/* Step of the parent of the body in lane l */
TFA_INLINE uint32_t parent_step(const body_constants *b, int l)
{
    const int32_t p = parent_of_lane(b, l);
    return p < 0 ? 0 : robot_step_of[p];
}

TFA_INLINE svec parent_motion(const body_constants *b, const svec *motion, svec world)
{
    if (b->parent < 0)
        return world;
    const uint32_t step = (uint32_t)b->parent;
    if (NUM_EVERY(ROBOT_PARENT_IN_LANE))
        return motion[step];
    svec x;
#define ROBOT_GET(l, e)                                                                            \
    (parent_of_lane(b, l) < 0                                                                      \
         ? world.e[l]                                                                              \
         : motion[parent_step(b, l)]                                                               \
               .e[parent_of_lane(b, l) < 0 ? 0 : robot_lane_of[parent_of_lane(b, l)]])
#if NUM_LANES == 8
#define ROBOT_PUT(e)                                                                               \
    x.e = (num){ROBOT_GET(0, e), ROBOT_GET(1, e), ROBOT_GET(2, e), ROBOT_GET(3, e),                \
                ROBOT_GET(4, e), ROBOT_GET(5, e), ROBOT_GET(6, e), ROBOT_GET(7, e)};
#elif NUM_LANES == 4
#define ROBOT_PUT(e)                                                                               \
    x.e = (num){ROBOT_GET(0, e), ROBOT_GET(1, e), ROBOT_GET(2, e), ROBOT_GET(3, e)};
#else
#define ROBOT_PUT(e) x.e = (num){ROBOT_GET(0, e), ROBOT_GET(1, e)};
#endif
    SVEC_COMPONENTS(ROBOT_PUT)
#undef ROBOT_PUT
#undef ROBOT_GET
    return x;
}

/* Roots get X 0. */
TFA_INLINE svec velocity_from_parent(const struct state *s, uint32_t i, const body_constants *b)
{
    return b->parent < 0 ? sv_zero() : motion_to_child(s, i, b, parent_motion(b, s->v, sv_zero()));
}

/* ---- children ---- */

TFA_INLINE void add_inertia_to_parent(struct state *s, uint32_t i, const sym6 *up, int flags)
{
    (void)flags; /* ABA_FULL_SWEEP: the result of a step stays with it */
    s->IA[i] = *up;
}

TFA_INLINE void add_force_to_parent(struct state *s, uint32_t i, svec up, int flags)
{
    (void)flags;
    s->pA[i] = up;
}

/* Child number k of the body in lane l, or -1 */
TFA_INLINE int32_t child_of_lane(const body_constants *b, int l, int k)
{
    return b->lane_mask >> l & 1 ? robot_child[b->body[l]][k] : -1;
}

/* Whether any lane has one; whether all have, in the same lanes of one step */
#define ROBOT_CHILDLESS(l) (child_of_lane(b, l, k) < 0)
#define ROBOT_CHILD_IN_LANE(l)                                                                     \
    (!(b->lane_mask >> l & 1) || (child_of_lane(b, l, k) >= 0 &&                                   \
                                  robot_step_of[ROBOT_CHILD_OR_ZERO(l)] == step_of_child(b, k) &&  \
                                  robot_lane_of[ROBOT_CHILD_OR_ZERO(l)] == l))
#define ROBOT_CHILD_OR_ZERO(l) (child_of_lane(b, l, k) < 0 ? 0 : child_of_lane(b, l, k))

/* The step of the first child that some lane has */
TFA_INLINE uint32_t step_of_child(const body_constants *b, int k)
{
    for (int l = 0; l < NUM_LANES; l++)
        if (child_of_lane(b, l, k) >= 0)
            return robot_step_of[child_of_lane(b, l, k)];
    return 0;
}

#define ROBOT_GET(l, e)                                                                            \
    (child_of_lane(b, l, k) < 0 ? 0.0                                                              \
                                : ROBOT_ARRAY[robot_step_of[ROBOT_CHILD_OR_ZERO(l)]]               \
                                      .e[robot_lane_of[ROBOT_CHILD_OR_ZERO(l)]])
#if NUM_LANES == 8
#define ROBOT_ADD_LANES(e)                                                                         \
    x.e += (num){ROBOT_GET(0, e), ROBOT_GET(1, e), ROBOT_GET(2, e), ROBOT_GET(3, e),               \
                 ROBOT_GET(4, e), ROBOT_GET(5, e), ROBOT_GET(6, e), ROBOT_GET(7, e)};
#elif NUM_LANES == 4
#define ROBOT_ADD_LANES(e)                                                                         \
    x.e += (num){ROBOT_GET(0, e), ROBOT_GET(1, e), ROBOT_GET(2, e), ROBOT_GET(3, e)};
#else
#define ROBOT_ADD_LANES(e) x.e += (num){ROBOT_GET(0, e), ROBOT_GET(1, e)};
#endif

#define ROBOT_ARRAY s->IA
TFA_INLINE sym6 add_child_inertia(const struct state *s, const body_constants *b, int k, sym6 x)
{
    if (NUM_EVERY(ROBOT_CHILDLESS))
        return x;
    if (NUM_EVERY(ROBOT_CHILD_IN_LANE))
        s6_add(&x, &s->IA[step_of_child(b, k)]);
    else {
        SYM6_COMPONENTS(ROBOT_ADD_LANES)
    }
    return x;
}
#undef ROBOT_ARRAY

#define ROBOT_ARRAY s->pA
TFA_INLINE svec add_child_force(const struct state *s, const body_constants *b, int k, svec x)
{
    if (NUM_EVERY(ROBOT_CHILDLESS))
        return x;
    if (NUM_EVERY(ROBOT_CHILD_IN_LANE))
        return sv_add(x, s->pA[step_of_child(b, k)]);
    SVEC_COMPONENTS(ROBOT_ADD_LANES)
    return x;
}
#undef ROBOT_ARRAY

/* The children are summed first, as where they add to their parent (layout/scalar). */
TFA_INLINE void add_inertia_from_children(const struct state *s, uint32_t i, sym6 *I)
{
    sym6 x = s6_zero();
#define ROBOT_ADD(k) x = add_child_inertia(s, &robot_step[i], k, x);
    ROBOT_CHILD_RANKS(ROBOT_ADD)
#undef ROBOT_ADD
    s6_add(I, &x);
}

TFA_INLINE svec force_from_children(const struct state *s, uint32_t i)
{
    svec x = sv_zero();
#define ROBOT_ADD(k) x = add_child_force(s, &robot_step[i], k, x);
    ROBOT_CHILD_RANKS(ROBOT_ADD)
#undef ROBOT_ADD
    return x;
}

/* Up to its parent, which reads it later */
TFA_INLINE void add_total_force_to_parent(struct state *s, uint32_t i, svec up)
{
    s->pA[i] = up;
}

/* One by one, as where they add to their parent */
TFA_INLINE void add_total_forces_of_children(struct state *s, uint32_t i)
{
#define ROBOT_ADD(k) s->f[i] = add_child_force(s, &robot_step[i], k, s->f[i]);
    ROBOT_CHILD_RANKS(ROBOT_ADD)
#undef ROBOT_ADD
}

#undef ROBOT_ADD_LANES
#undef ROBOT_GET

#endif
