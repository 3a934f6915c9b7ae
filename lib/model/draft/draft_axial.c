/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frames after Denavit and Hartenberg in Craig's form. Two joint axes have a common normal; a body
 * frame may turn about its own z axis and move along it until x lies on the normal to a child's
 * axis. The constant transform to the child is then a screw about x and one about z, which takes
 * fewer operations than a general transform (spatial/screw.h). A body has that for one child only;
 * for nearly parallel axes, whose normal is far away, the transform stays general.
 */
#include "model/draft/draft.h"

/* Limit of the growth of the inverse inertia at a new origin, relative to that at the joints:
 * methods that invert inertias lose that factor of accuracy. It excludes origins far beside a thin
 * body. */
#define MOBILITY_RATIO_MAX 8

/* Smallest principal moment in use, relative to the sum of the moments */
#define FLAT_MOMENT_RATIO 1e-9L

/* Tolerances of parallel axes and of zeros, far below the rounding of the constants to double */
#define PARALLEL 1e-18L
#define EXACT 1e-17L

/* I x = y for a symmetric positive I: xx xy xz yy yz zz */
static void solve(const long double I[6], const long double y[3], long double x[3])
{
    const long double l1 = I[1] / I[0], l2 = I[2] / I[0];
    const long double yy = I[3] - l1 * I[1], yz = I[4] - l1 * I[2], l = yz / yy;
    const long double zz = I[5] - l2 * I[2] - l * yz;
    const long double b = y[1] - l1 * y[0];
    x[2] = (y[2] - l2 * y[0] - l * b) / zz;
    x[1] = b / yy - l * x[2];
    x[0] = y[0] / I[0] - l1 * x[1] - l2 * x[2];
}

/* Trace of the inverse mass at a point p from the centre of mass, times the mass:
 *   3 + m tr([p]x I^-1 [p]x^T) */
static long double mobility(const struct draft_body *b, const long double I[6],
                            const long double point[3])
{
    long double p[3], sum = 3;
    for (int k = 0; k < 3; k++)
        p[k] = point[k] - (long double)(b->sum.h[k] / b->sum.mass);
    const long double rows[3][3] = {{0, -p[2], p[1]}, {p[2], 0, -p[0]}, {-p[1], p[0], 0}};
    for (int k = 0; k < 3; k++) {
        long double x[3];
        solve(I, rows[k], x);
        sum +=
            (long double)b->sum.mass * (rows[k][0] * x[0] + rows[k][1] * x[1] + rows[k][2] * x[2]);
    }
    return sum;
}

/* 1: the body's origin may move to height w of its axis. r: joint of the child */
static uint8_t origin_may_move(const struct draft_body *b, const ext r[3], ext w)
{
    if (!(b->sum.mass > 0))
        return 0;
    const long double origin[3] = {0, 0, 0}, foot[3] = {0, 0, (long double)w};
    const long double joint[3] = {(long double)r[0], (long double)r[1], (long double)r[2]};
    const ext *h = b->sum.h, m = b->sum.mass;
    const ext hh = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
    const ext trace =
        b->sum.I[0] + b->sum.I[3] + b->sum.I[5] - 2 * hh / m; /* about the centre of mass */
    long double I[6];
    for (int k = 0; k < 6; k++) {
        const int diagonal = ext_row[k] == ext_col[k];
        I[k] =
            (long double)(b->sum.I[k] - ((diagonal ? hh : 0) - h[ext_row[k]] * h[ext_col[k]]) / m +
                          (diagonal ? FLAT_MOMENT_RATIO * trace : 0));
    }
    const long double now = mobility(b, I, origin), there = mobility(b, I, joint);
    return mobility(b, I, foot) <= MOBILITY_RATIO_MAX * (now > there ? now : there);
}

/* Finds the common normal of a body's and a child's axis. Returns 0 if it is too far away. */
static uint8_t find_normal(const struct draft_body *child, struct draft_body *b)
{
    const ext *e = child->E + 6, *r = child->r; /* the child's axis, and its joint */
    const ext sine = ext_hypot(e[0], e[1]), away = ext_hypot(r[0], r[1]);
    if (sine < PARALLEL) {
        if (away > 0)
            b->move = (struct draft_move){r[0] / away, r[1] / away, 0};
        return 1;
    }
    const ext t = -(r[0] * e[0] + r[1] * e[1]) / (sine * sine); /* along the child's axis */
    const ext w = r[2] + t * e[2];
    if (!origin_may_move(b, r, w))
        return 0;
    b->move = (struct draft_move){-e[1] / sine, e[0] / sine, w};
    return 1;
}

/* x <- R^T x */
static void rotate_vector(ext *x, const struct draft_move *f)
{
    const ext a = x[0];
    x[0] = f->c * a + f->s * x[1];
    x[1] = f->c * x[1] - f->s * a;
}

/* Inertia about the new origin p = (0, 0, w), in the new axes:
 *   I - 2 (h.p) 1 + h p^T + p h^T + m (p.p 1 - p p^T) */
static void move_inertia(struct draft_body *b, const struct draft_move *f)
{
    const ext w = f->w, c = f->c, s = f->s, m = b->sum.mass, *h = b->sum.h;
    ext *I = b->sum.I;
    I[0] += m * w * w - 2 * h[2] * w;
    I[3] += m * w * w - 2 * h[2] * w;
    I[2] += h[0] * w;
    I[4] += h[1] * w;
    b->sum.h[2] -= m * w;
    rotate_vector(b->sum.h, f);
    const ext xx = I[0], xy = I[1], yy = I[3], xz = I[2], yz = I[4];
    I[0] = c * (c * xx + s * xy) + s * (c * xy + s * yy);
    I[1] = c * (c * xy - s * xx) + s * (c * yy - s * xy);
    I[3] = c * (c * yy - s * xy) - s * (c * xy - s * xx);
    I[2] = c * xz + s * yz;
    I[4] = c * yz - s * xz;
}

/* Moves a frame in the body: columns of R (body axes first) and origin p */
static void move_columns(ext *R, ext *p, const struct draft_move *f)
{
    p[2] -= f->w;
    rotate_vector(p, f);
    for (int k = 0; k < 3; k++) {
        const ext x = R[k], y = R[3 + k];
        R[k] = f->c * x + f->s * y;
        R[3 + k] = f->c * y - f->s * x;
    }
}

/* The same with rows as axes: E of a child */
static void move_rows(ext *E, ext *r, const struct draft_move *f)
{
    r[2] -= f->w;
    rotate_vector(r, f);
    for (int k = 0; k < 3; k++)
        rotate_vector(E + 3 * k, f);
}

/* E <- R^T E, r <- r + E^T p: a body's own frame seen from its parent's */
static void move_body_frame(struct draft_body *b)
{
    const struct draft_move *f = &b->move;
    for (int k = 0; k < 3; k++) {
        b->r[k] += b->E[6 + k] * f->w;
        const ext x = b->E[k], y = b->E[3 + k];
        b->E[k] = f->c * x + f->s * y;
        b->E[3 + k] = f->c * y - f->s * x;
    }
    move_inertia(b, f);
}

static void move_all(struct draft *d)
{
    for (uint32_t k = 0; k < d->bodies; k++) {
        struct draft_body *b = &d->body[k];
        move_body_frame(b);
        if (b->parent < 0)
            continue;
        const int fused = is_fused(b->kind);
        struct draft_part *first = &d->part[b->first];
        move_rows(fused ? first->E : b->E, fused ? first->r : b->r, &d->body[b->parent].move);
    }
    for (size_t k = 0; k < d->description->link_count; k++) {
        struct draft_frame *f = &d->frame[k];
        if (d->link[k].present && f->body >= 0 && !f->part)
            move_columns(f->R, f->p, &d->body[f->body].move);
    }
}

/* Marks screws: E = Rz Rx and r = (a, -d sin alpha, d cos alpha), with (0, -sin alpha, cos alpha)
 * the last row of E. The doubles of the model become exactly that; the quadruple-precision
 * constants stay. */
static void detect_screw(struct draft_body *b, const struct draft_body *parent)
{
    const ext *E = b->E, *r = b->r;
    const ext d = r[1] * E[7] + r[2] * E[8], moved = ext_abs(parent->move.w) + ext_abs(b->move.w);
    const ext nothing = EXACT * (ext_hypot(r[0], ext_hypot(r[1], r[2])) + moved);
    const ext off = ext_hypot(r[1] - d * E[7], r[2] - d * E[8]);
    if (!is_revolute(b->kind) || ext_abs(E[6]) > EXACT || off > nothing)
        return;
    b->axial = 1;
    const ext size = ext_hypot(r[0], ext_hypot(r[1], r[2])) + moved;
    b->d = ext_abs(d) > EXT_ZERO * size ? d : 0;
    b->a = ext_abs(r[0]) > EXT_ZERO * size ? r[0] : 0;
}

int tfa_draft_axial(struct draft *d, tfa_report *report)
{
    (void)report;
    for (uint32_t k = 0; k < d->bodies; k++)
        d->body[k].move = (struct draft_move){1, 0, 0};
    for (uint32_t k = 0; k < d->bodies; k++) {
        const struct draft_body *child = &d->body[k];
        struct draft_body *b = child->parent < 0 ? NULL : &d->body[child->parent];
        if (b && !b->aligned && b->n == 1 && is_revolute(child->kind))
            b->aligned = find_normal(child, b);
    }
    move_all(d);
    for (uint32_t k = 0; k < d->bodies; k++) {
        const int32_t parent = d->body[k].parent;
        if (parent >= 0)
            detect_screw(&d->body[k], &d->body[parent]);
    }
    return TFA_OK;
}
