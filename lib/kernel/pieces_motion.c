/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint transforms of a chain in pieces, and the velocities at their borders: each piece moves on
 * a body at rest first, which gives its transform as a whole; then the borders follow one from the
 * other.
 */
#include "kernel/hinge.h"
#include "kernel/pieces.h"

static inline num load_one(const double *array, const uint32_t *index)
{
    return array ? num_gather(array, 1, index) : num_of(0);
}

static inline void load_row(const struct pieces *p, const struct piece_body *b, struct piece_row *r)
{
    num q = load_one(p->q, b->q);
    num_sincos_many(&q, &r->sine, &r->cosine, 0, 1);
    r->X = (place){hinge_turn(b->E, r->sine, r->cosine), b->r};
    r->qd = load_one(p->qd, b->v) * b->live;
    r->rhs = r->tau = (load_one(p->tau, b->v) - b->damping * r->qd) * b->live;
}

/* X of the bodies of a group, and where they move the last body of each piece */
static void move_group(void *context, uint32_t g, uint32_t worker)
{
    const struct pieces *p = context;
    const struct piece_body *body = piece_bodies(p, g);
    struct piece_row *row = piece_rows(p, g);
    (void)worker;
    load_row(p, &body[0], &row[0]);
    load_row(p, &body[1], &row[1]);
    place whole = row[1].X;
    svec v = {{num_of(0), num_of(0), row[1].qd}, v3_zero()};
    for (uint32_t k = 2; k <= p->rows; k++) {
        load_row(p, &body[k], &row[k]);
        whole = x_then(&whole, &row[k].X);
        v = x_motion(&row[k].X, v);
        v.w.z += row[k].qd;
    }
    border_put_many(p, BORDER_PLACE, g, &whole.E.xx, 12);
    border_put_many(p, BORDER_MOVED, g, &v.w.x, 6);
}

/* v of every body from BORDER_V, and of the last one to BORDER_MOVED */
static void step_group(void *context, uint32_t g, uint32_t worker)
{
    const struct pieces *p = context;
    struct piece_row *row = piece_rows(p, g);
    svec v;
    (void)worker;
    border_get_many(p, BORDER_V, g, &v.w.x, 6);
    row[0].v = v;
    for (uint32_t k = 1; k <= p->rows; k++) {
        v = x_motion(&row[k].X, v);
        v.w.z += row[k].qd;
        row[k].v = v;
    }
    border_put_many(p, BORDER_MOVED, g, &v.w.x, 6);
}

/* Before piece l + 1 from before piece l. The same in every lane. */
static void travel(const struct pieces *p)
{
    svec v = sv_zero();
    for (uint32_t l = 0; l < p->pieces; l++) {
        place X;
        svec moved;
        border_put_column(p, BORDER_V, l, v);
        border_column(p, BORDER_PLACE, l, &X.E.xx, 12);
        border_column(p, BORDER_MOVED, l, &moved.w.x, 6);
        v = sv_add(x_motion(&X, v), moved);
    }
}

/* The rounding of a whole piece's transform, by which no velocity may jump where pieces meet:
 *   dv before piece l + 1 = X dv before piece l + (v of its last body - v before piece l + 1) */
void TFA_V(pieces_close_gaps)(const struct pieces *p)
{
    svec dv = sv_zero();
    border_put_column(p, BORDER_DV, 0, dv);
    for (uint32_t l = 0; l + 1 < p->pieces; l++) {
        place X;
        svec moved, v;
        border_column(p, BORDER_PLACE, l, &X.E.xx, 12);
        border_column(p, BORDER_MOVED, l, &moved.w.x, 6);
        border_column(p, BORDER_V, l + 1, &v.w.x, 6);
        dv = sv_add(x_motion(&X, dv), sv_sub(moved, v));
        border_put_column(p, BORDER_DV, l + 1, dv);
    }
}

void TFA_V(pieces_motion)(struct pieces *p)
{
    crew_run(p->crew, move_group, p, p->groups);
    if (!p->moving)
        return;
    travel(p);
    crew_run(p->crew, step_group, p, p->groups);
    TFA_V(pieces_close_gaps)(p);
}
