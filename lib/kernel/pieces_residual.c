/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The residual tau - RNEA(qdd) of a chain in pieces. Each piece starts from the acceleration of the
 * body before it and from the force behind it that the solution has (BORDER_V, BORDER_FORCE), and
 * ends on a slightly different value than its neighbour started from. These gaps follow from one
 * another along the borders,
 *
 *   da before piece l + 1 = X da before piece l + (a of its last body - a before piece l + 1)
 *   df behind piece l     = X^T df behind piece l + 1 + (f of its first joint - f that piece l had)
 *
 * and the pieces carry them to all their bodies. So every joint's acceleration and force differs
 * from RNEA's by roundings of its own size. A piece that starts on a body at rest would lose
 * roundings of what the whole piece adds up to, which in light bodies between heavy ones is a
 * million times more. Perturbed as in rnea.c; the small da and df need no perturbation.
 */
#include "kernel/hinge.h"
#include "kernel/perturb.h"
#include "kernel/pieces.h"

/* By the row, alike in all pieces */
static inline struct perturb_start row_start(uint32_t k)
{
    return (struct perturb_start){{PERTURB_EACH * k % PERTURB_COUNT}};
}

/* The joint's velocity as a spatial vector */
static inline svec joint_velocity(const struct piece_row *r, uint32_t k)
{
    return (svec){v3(num_of(0), num_of(0), r[k].qd), v3_zero()};
}

/* X a + c + H qdd */
static inline svec row_motion(const struct pieces *p, const struct piece_row *r, uint32_t k, svec a,
                              int perturbed)
{
    const place X = place_abs(&r[k].X, 1);
    svec size = x_motion_abs(&X, sv_abs(a));
    a = x_motion(&r[k].X, a);
    if (p->moving) {
        a = sv_add(a, hinge_products(r[k].v, r[k].qd));
        size = sv_add(size, cross_motion_abs(sv_abs(r[k].v), sv_abs(joint_velocity(r, k))));
    }
    a.w.z += r[k].qdd;
    const struct perturb_start start = row_start(k);
    return perturbed ? sv_perturb(a, size, &start, 0) : a;
}

/* I a + p */
static inline svec row_force(const struct pieces *p, const struct piece_body *b,
                             const struct piece_row *r, uint32_t k, svec a, int perturbed)
{
    svec f = s6_rigid_mul(b[k].I, b[k].h, b[k].mass, a);
    if (p->moving)
        f = sv_add(f, r[k].p);
    if (!perturbed)
        return f;
    const svec v = sv_abs(r[k].v);
    svec size = rigid_mul_abs(b[k].I, b[k].h, b[k].mass, sv_abs(a));
    if (p->moving)
        size = sv_add(size, cross_force_abs(v, rigid_mul_abs(b[k].I, b[k].h, b[k].mass, v)));
    const struct perturb_start start = row_start(k);
    return sv_perturb(f, size, &start, 6);
}

/* X^T f */
static inline svec row_force_up(const struct piece_row *r, uint32_t k, svec f, int perturbed)
{
    const svec up = x_t_force(&r[k].X, f);
    if (!perturbed)
        return up;
    const place X = place_abs(&r[k].X, 1);
    const struct perturb_start start = row_start(k);
    return sv_perturb(up, x_t_force_abs(&X, sv_abs(f)), &start, 12);
}

/* a of each body, from the one that the solution has before the piece; of the last one to the
 * border */
static inline __attribute__((always_inline)) void move(const struct pieces *p, uint32_t g,
                                                       int perturbed)
{
    struct piece_row *r = piece_rows(p, g);
    svec a;
    border_get_many(p, BORDER_V, g, &a.w.x, 6);
    for (uint32_t k = 1; k <= p->rows; k++) {
        a = r[k].a = row_motion(p, r, k, a, perturbed);
    }
    border_put_many(p, BORDER_MOVED, g, &a.w.x, 6);
}

/* rhs = tau - H^T f with the force behind the piece that the solution has; the force on the body
 * before the piece to the border */
static inline __attribute__((always_inline)) void press(const struct pieces *p, uint32_t g,
                                                        int perturbed)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    svec da, f;
    border_get_many(p, BORDER_DV, g, &da.w.x, 6);
    for (uint32_t k = 1; k <= p->rows; k++) {
        da = x_motion(&r[k].X, da);
        r[k].a = sv_add(r[k].a, da);
    }
    border_get_many(p, BORDER_BEHIND, g, &f.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        f = sv_add(f, row_force(p, b, r, k, r[k].a, perturbed));
        r[k].rhs = r[k].tau - f.w.z;
        f = row_force_up(r, k, f, perturbed);
    }
    border_put_many(p, BORDER_PRESSED, g, &f.w.x, 6);
}

/* To its joints' places in the array for the judge */
static inline void give_residual(const struct pieces *p, const struct piece_body *b, num rest)
{
    for (uint32_t l = 0; l < NUM_LANES; l++)
        if (b->real[l])
            p->residual[b->v[l]] = num_lane(rest, l);
}

/* rhs -= H^T df, what the force behind the piece was wrong by */
static inline __attribute__((always_inline)) void compare(const struct pieces *p, uint32_t g,
                                                          int perturbed)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    svec df;
    border_get_many(p, BORDER_BEHIND, g, &df.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        r[k].rhs = (r[k].rhs - df.w.z) * b[k].live;
        if (perturbed) { /* with the sign that cannot cancel the rest */
            const num e = num_abs(r[k].tau) * NUM_EPSILON;
            r[k].rhs += num_select(r[k].rhs < num_of(0), -e, e);
            give_residual(p, &b[k], r[k].rhs);
        }
        df = x_t_force(&r[k].X, df);
    }
}

#define PIECES_TASK(name)                                                                          \
    static void name##_group(void *context, uint32_t g, uint32_t worker)                           \
    {                                                                                              \
        const struct pieces *p = context;                                                          \
        (void)worker;                                                                              \
        if (p->what & PIECES_PERTURBED)                                                            \
            name(p, g, 1);                                                                         \
        else                                                                                       \
            name(p, g, 0);                                                                         \
    }
PIECES_TASK(move)
PIECES_TASK(press)
PIECES_TASK(compare)

/* BORDER_BEHIND: the force behind each piece that the solution has on the body before the next one
 */
static void set_behind(const struct pieces *p)
{
    for (int e = 0; e < 6; e++) {
        double *behind = p->border + (size_t)(BORDER_BEHIND + e) * p->width;
        const double *found = p->border + (size_t)(BORDER_FORCE + e) * p->width;
        for (uint32_t l = 0; l < p->pieces; l++)
            behind[l] = l + 1 < p->pieces ? found[l + 1] : 0;
    }
}

/* BORDER_BEHIND: what that force was wrong by */
static void push_borders(const struct pieces *p)
{
    svec df = sv_zero();
    for (uint32_t l = p->pieces; l-- > 0;) {
        place X;
        svec pressed, found;
        border_put_column(p, BORDER_BEHIND, l, df);
        border_column(p, BORDER_PLACE, l, &X.E.xx, 12);
        border_column(p, BORDER_PRESSED, l, &pressed.w.x, 6);
        border_column(p, BORDER_FORCE, l, &found.w.x, 6);
        df = sv_add(x_t_force(&X, df), sv_sub(pressed, found));
    }
}

void TFA_V(pieces_tell_next)(const struct pieces *p)
{
    for (uint32_t piece = 1; piece < p->pieces; piece++) {
        const struct piece_row *from = &piece_rows(p, (piece - 1) / NUM_LANES)[p->rows];
        struct piece_row *to = piece_rows(p, piece / NUM_LANES);
        ((double *)&to->rhs)[piece % NUM_LANES] = num_lane(from->rhs, (piece - 1) % NUM_LANES);
    }
}

void TFA_V(pieces_residual)(struct pieces *p, int perturbed)
{
    p->what = perturbed ? PIECES_PERTURBED : 0;
    border_put_column(p, BORDER_V, 0, (svec){v3_zero(), v3_neg(p->gravity)});
    crew_run(p->crew, move_group, p, p->groups);
    TFA_V(pieces_close_gaps)(p);
    set_behind(p);
    crew_run(p->crew, press_group, p, p->groups);
    push_borders(p);
    crew_run(p->crew, compare_group, p, p->groups);
    TFA_V(pieces_tell_next)(p);
}
