/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The residual tau - RNEA(qdd) of a chain in pieces: accelerations as velocities in pieces_motion.c,
 * first on a body at rest, then on the one before; forces likewise, inward. Shaken as in rnea.c, the
 * same in every piece.
 */
#include "kernel/hinge.h"
#include "kernel/pieces.h"
#include "kernel/shake.h"

/* By turns of its own for each row and number, so that a row is shaken the same in every pass. */
static inline uint32_t turn_of(uint32_t k, uint32_t number)
{
    return (3 * k + number) * 0x9e3779b9u;
}

static inline place row_place(const struct piece_row *r, uint32_t k, int shaken)
{
    uint32_t turn = turn_of(k, 0);
    return shaken ? shake_place(&r[k].X, 1, &turn) : r[k].X;
}

/* X a + c + H qdd */
static inline svec row_motion(const struct pieces *p, const struct piece_row *r, uint32_t k,
                              const place *X, svec a, int shaken)
{
    uint32_t turn = turn_of(k, 1);
    a = x_motion(X, a);
    if (p->moving) {
        const svec c = hinge_products(r[k].v, r[k].qd);
        a = sv_add(a, shaken ? shake_svec(c, &turn) : c);
    }
    a.w.z += r[k].qdd;
    return a;
}

/* I a + p */
static inline svec row_force(const struct pieces *p, const struct piece_body *b,
                             const struct piece_row *r, uint32_t k, svec a, int shaken)
{
    uint32_t turn = turn_of(k, 2);
    const svec f = s6_rigid_mul(b[k].I, b[k].h, b[k].mass, a);
    if (!p->moving)
        return f;
    if (!shaken)
        return sv_add(f, r[k].p);
    const svec momentum = s6_rigid_mul(b[k].I, b[k].h, b[k].mass, shake_svec(r[k].v, &turn));
    return sv_add(f, cross_force(shake_svec(r[k].v, &turn), momentum));
}

/* Each piece on a body at rest */
static inline __attribute__((always_inline)) void move(const struct pieces *p, uint32_t g,
                                                       int shaken)
{
    const struct piece_row *r = piece_rows(p, g);
    place whole = row_place(r, 1, shaken);
    svec a = row_motion(p, r, 1, &whole, sv_zero(), shaken);
    for (uint32_t k = 2; k <= p->rows; k++) {
        const place X = row_place(r, k, shaken);
        a = row_motion(p, r, k, &X, a, shaken);
        if (shaken)
            whole = x_then(&whole, &X);
    }
    if (shaken)
        border_put_many(p, BORDER_PLACE, g, &whole.E.xx, 12);
    border_put_many(p, BORDER_MOVED, g, &a.w.x, 6);
}

/* f of each body, and what they sum up to on the body before the piece */
static inline __attribute__((always_inline)) void press(const struct pieces *p, uint32_t g,
                                                        int shaken)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    svec a, f = sv_zero();
    border_get_many(p, BORDER_V, g, &a.w.x, 6);
    for (uint32_t k = 1; k <= p->rows; k++) {
        const place X = row_place(r, k, shaken);
        a = row_motion(p, r, k, &X, a, shaken);
        r[k].f = row_force(p, b, r, k, a, shaken);
    }
    for (uint32_t k = p->rows; k > 0; k--) {
        const place X = row_place(r, k, shaken);
        f = x_t_force(&X, sv_add(f, r[k].f));
    }
    border_put_many(p, BORDER_FORCE, g, &f.w.x, 6);
}

/* To its joints' places in the array for the judge */
static inline void give_residual(const struct pieces *p, const struct piece_body *b, num rest)
{
    for (uint32_t l = 0; l < NUM_LANES; l++)
        if (b->real[l])
            p->residual[b->v[l]] = num_lane(rest, l);
}

/* rhs = tau - H^T f, with the force of the pieces behind */
static inline __attribute__((always_inline)) void compare(const struct pieces *p, uint32_t g,
                                                          int shaken)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    svec f;
    border_get_many(p, BORDER_BEHIND, g, &f.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        const place X = row_place(r, k, shaken);
        f = sv_add(f, r[k].f);
        r[k].rhs = (r[k].tau - f.w.z) * b[k].live;
        if (shaken) { /* with the sign that cannot cancel the rest */
            const num e = num_abs(r[k].tau) * NUM_EPSILON;
            r[k].rhs += num_select(r[k].rhs < num_of(0), -e, e);
            give_residual(p, &b[k], r[k].rhs);
        }
        f = x_t_force(&X, f);
    }
}

#define PIECES_TASK(name)                                                                          \
    static void name##_group(void *context, uint32_t g, uint32_t worker)                           \
    {                                                                                              \
        const struct pieces *p = context;                                                          \
        (void)worker;                                                                              \
        if (p->what & PIECES_SHAKEN)                                                               \
            name(p, g, 1);                                                                         \
        else                                                                                       \
            name(p, g, 0);                                                                         \
    }
PIECES_TASK(move)
PIECES_TASK(press)
PIECES_TASK(compare)

/* Force behind piece l from that behind piece l + 1. The same in every lane. */
static void push_borders(const struct pieces *p)
{
    svec f = sv_zero();
    for (uint32_t l = p->pieces; l-- > 0;) {
        const num out[6] = {f.w.x, f.w.y, f.w.z, f.v.x, f.v.y, f.v.z};
        num x[18];
        for (uint32_t k = 0; k < 6; k++)
            p->border[(size_t)(BORDER_BEHIND + k) * p->width + l] = num_lane(out[k], 0);
        for (uint32_t k = 0; k < 12; k++)
            x[k] = num_of(p->border[(size_t)(BORDER_PLACE + k) * p->width + l]);
        for (uint32_t k = 0; k < 6; k++)
            x[12 + k] = num_of(p->border[(size_t)(BORDER_FORCE + k) * p->width + l]);
        const place X = {{x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8]},
                         {x[9], x[10], x[11]}};
        f = sv_add(x_t_force(&X, f), sv_from(x + 12));
    }
}

/* The joint before each piece has what that of the piece before found. */
static void tell_next(const struct pieces *p)
{
    for (uint32_t piece = 1; piece < p->pieces; piece++) {
        const struct piece_row *from = &piece_rows(p, (piece - 1) / NUM_LANES)[p->rows];
        struct piece_row *to = piece_rows(p, piece / NUM_LANES);
        ((double *)&to->rhs)[piece % NUM_LANES] = num_lane(from->rhs, (piece - 1) % NUM_LANES);
    }
}

void TFA_V(pieces_residual)(struct pieces *p, int shaken)
{
    p->what = shaken ? PIECES_SHAKEN : 0;
    crew_run(p->crew, move_group, p, p->groups);
    TFA_V(pieces_travel)(p, (svec){v3_zero(), v3_neg(p->gravity)});
    crew_run(p->crew, press_group, p, p->groups);
    push_borders(p);
    crew_run(p->crew, compare_group, p, p->groups);
    tell_next(p);
}
