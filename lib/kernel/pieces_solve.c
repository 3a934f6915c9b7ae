/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm on a chain in pieces: all rows of a piece but the last are eliminated
 * one after the other, each between the row behind it and the last row of the piece before; the last
 * rows of all pieces by cyclic reduction (pieces_last.c); then outside in, with the accelerations.
 */
#include "kernel/hinge.h"
#include "kernel/pieces_row.h"

/* ---- one row from its body and the one before ---- */

/* D += Z TIT Z^T */
static inline void add_turned(sym5 *D, const sym5 *T, num s, num c)
{
    const num cc = c * c, ss = s * s, cs = c * s;
    for (int k = 0; k < 2; k++) { /* of angular and of linear components among themselves */
        const int a = 2 * k, b = 2 * k + 1;
        const num xx = T->x[SYM5(a, a)], xy = T->x[SYM5(b, a)], yy = T->x[SYM5(b, b)];
        const num both = cs * xy;
        D->x[SYM5(a, a)] += cc * xx + (both + both) + ss * yy;
        D->x[SYM5(b, b)] += ss * xx - (both + both) + cc * yy;
        D->x[SYM5(b, a)] += cs * (yy - xx) + (cc - ss) * xy;
        const num zx = T->x[SYM5(4, a)], zy = T->x[SYM5(4, b)];
        D->x[SYM5(4, a)] += c * zx + s * zy;
        D->x[SYM5(4, b)] += c * zy - s * zx;
    }
    const num xx = T->x[SYM5(2, 0)], xy = T->x[SYM5(2, 1)], yx = T->x[SYM5(3, 0)],
              yy = T->x[SYM5(3, 1)]; /* linear rows, angular columns */
    const num ux = c * xx + s * yx, uy = c * xy + s * yy, dx = c * yx - s * xx,
              dy = c * yy - s * xy;
    D->x[SYM5(2, 0)] += c * ux + s * uy;
    D->x[SYM5(2, 1)] += c * uy - s * ux;
    D->x[SYM5(3, 0)] += c * dx + s * dy;
    D->x[SYM5(3, 1)] += c * dy - s * dx;
    D->x[SYM5(4, 4)] += T->x[SYM5(4, 4)];
}

/* The transpose of L = -W^T Z TI W */
static inline mat5 turned_transpose(const mat5 *T, num s, num c)
{
    mat5 U;
    for (int i = 0; i < 5; i++) {
        U.x[i][0] = c * T->x[i][0] + s * T->x[i][1];
        U.x[i][1] = c * T->x[i][1] - s * T->x[i][0];
        U.x[i][2] = c * T->x[i][2] + s * T->x[i][3];
        U.x[i][3] = c * T->x[i][3] - s * T->x[i][2];
        U.x[i][4] = T->x[i][4];
    }
    return U;
}

/* e = I^-1 (Wa tau - X^T Wa tau of the next - p), the acceleration without constraint forces */
static inline svec unconstrained(const struct piece_body *b, const struct piece_row *r, num next,
                                 int what)
{
    svec f = {{-b->next_z.x * next, -b->next_z.y * next, r->rhs - b->next_z.z * next}, v3_zero()};
    if (what & PIECES_BIAS)
        f = sv_sub(f, r->p);
    return s6_mul(&b->Iinv, f);
}

/* ---- inside the pieces ---- */

/* What the body before has: acceleration without constraint forces, what v is wrong by */
struct walk {
    svec e, dv;
};

/* v and p of a body */
static inline void products(const struct piece_body *b, struct piece_row *r, svec dv)
{
    const svec v = r->v = sv_add(r->v, dv);
    r->p = cross_force(v, s6_rigid_mul(b->I, b->h, b->mass, v));
}

static inline struct walk walk_start(const struct pieces *p, uint32_t g, int what)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    struct walk w;
    w.dv = sv_zero();
    if (what & PIECES_BIAS)
        r->p = sv_zero();
    if (what & PIECES_BIAS && p->moving) {
        border_get_many(p, BORDER_DV, g, &w.dv.w.x, 6);
        products(b, r, w.dv);
    }
    w.e = unconstrained(b, r, r[1].rhs, what);
    if (g == 0 && what & PIECES_BIAS) { /* the ground stands before the first piece */
        ((double *)&w.e.v.x)[0] = -num_lane(p->gravity.x, 0);
        ((double *)&w.e.v.y)[0] = -num_lane(p->gravity.y, 0);
        ((double *)&w.e.v.z)[0] = -num_lane(p->gravity.z, 0);
    }
    return w;
}

/* b of a row, and on to its body. `next`: the right-hand side of the next joint */
static inline vec5 walk_on(const struct pieces *p, struct walk *w, const struct piece_body *b,
                           struct piece_row *r, num next, int what)
{
    svec gap = x_motion(&r->X, w->e);
    if (what & PIECES_BIAS)
        r->p = sv_zero();
    if (what & PIECES_BIAS && p->moving) {
        w->dv = x_motion(&r->X, w->dv);
        products(b, r, w->dv);
        gap = sv_add(gap, hinge_products(r->v, r->qd));
    }
    w->e = unconstrained(b, r, next, what);
    return v5_of(sv_scale(sv_sub(gap, w->e), b->live));
}

/* Right-hand side of the joint behind row k: that of the last row is of the next piece */
static num next_force(const struct pieces *p, uint32_t g, uint32_t k)
{
    num x = piece_rows(p, g)[k < p->rows ? k + 1 : k].rhs;
    if (k < p->rows)
        return x;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const uint32_t next = g * NUM_LANES + l + 1;
        const struct piece_row *r = piece_rows(p, next / NUM_LANES) + 1;
        ((double *)&x)[l] = next < p->pieces ? ((const double *)&r->rhs)[next % NUM_LANES] : 0;
    }
    return x;
}

static inline __attribute__((always_inline)) void eliminate(const struct pieces *p, uint32_t g,
                                                            int what)
{
    static const struct piece_block none;
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    struct walk w = walk_start(p, g, what);
    struct piece_share left;
    struct piece_block row = none;
    share_clear(&left);
    for (uint32_t k = 1; k <= p->rows; k++) {
        const struct piece_body *bk = &b[k];
        struct piece_factors *before = &r[k - 1].factors;
        const num s = r[k].sine, c = r[k].cosine;
        const mat5 U = what & PIECES_FACTOR ? turned_transpose(&bk->minus_TI, s, c) : before->ZU;
        if (k > 1)
            row_factor(&row, &U, before, what);
        else if (what & PIECES_FACTOR)
            row.L = m5_t(&U);
        row.b = walk_on(p, &w, bk, &r[k], next_force(p, g, k), what);
        if (what & PIECES_FACTOR) {
            row.D = s5_of(&bk->Iinv);
            add_turned(&row.D, &bk->TIT, s, c);
        }
        if (k > 1)
            row_share(before, &left, &row, what);
    }
    if (what & PIECES_FACTOR) {
        border_put_many(p, BORDER_D, g, row.D.x, 15);
        border_put_many(p, BORDER_L, g, &row.L.x[0][0], 25);
        border_put_many(p, BORDER_LEFT_D, g, left.D.x, 15);
    }
    border_put_many(p, BORDER_B, g, row.b.x, 5);
    border_put_many(p, BORDER_LEFT_B, g, left.b.x, 5);
}

static void eliminate_group(void *context, uint32_t g, uint32_t worker)
{
    const struct pieces *p = context;
    (void)worker;
    if (p->what & PIECES_FACTOR)
        eliminate(p, g, PIECES_FACTOR | PIECES_BIAS);
    else
        eliminate(p, g, 0);
}

/* ---- outside in ---- */

/* Angular part of I^-1 f */
static inline vec3 angular(const sym6 *Iinv, svec f)
{
    return v3_add(s3_mul(Iinv->A, f.w), m3_mul(Iinv->B, f.v));
}

/* x of the last row of each piece of the group, and of the piece before */
static inline void last_rows(const struct pieces *p, uint32_t g, vec5 *own, vec5 *before)
{
    for (int k = 0; k < 5; k++) {
        const double *x = border_at(p, BORDER_B + k, g);
        own->x[k] = *(const num *)(const void *)x;
        for (uint32_t l = 0; l < NUM_LANES; l++)
            ((double *)&before->x[k])[l] = g + l > 0 ? x[(int)l - 1] : 0;
    }
}

/* What was found for the joints at one place of the pieces */
struct found {
    num finite, sum_qdd, sum_dx;
};

static inline void give(const struct pieces *p, const struct piece_body *b, struct piece_row *r,
                        num x, struct found *found)
{
    found->sum_qdd += r->qdd * r->qdd;
    found->sum_dx += x * x;
    r->qdd = p->what & PIECES_BIAS ? x : r->qdd + x;
    found->finite += r->qdd - r->qdd;
    for (uint32_t l = 0; p->qdd && l < NUM_LANES; l++)
        if (b->real[l])
            p->qdd[b->v[l]] = num_lane(r->qdd, l);
}

/* What the residual starts from, of the solution or of what is added to it: acceleration of the body
 * before a piece, force of the piece on it */
static inline void leave_border(const struct pieces *p, uint32_t g, svec a, svec f, int what)
{
    if (!(what & PIECES_BIAS)) {
        svec before;
        border_get_many(p, BORDER_V, g, &before.w.x, 6);
        a = sv_add(a, before);
        border_get_many(p, BORDER_FORCE, g, &before.w.x, 6);
        f = sv_add(f, before);
    }
    border_put_many(p, BORDER_V, g, &a.w.x, 6);
    border_put_many(p, BORDER_FORCE, g, &f.w.x, 6);
}

/* qdd of all joints but the last one of each piece, which needs the force behind it */
static inline __attribute__((always_inline)) void substitute(const struct pieces *p, uint32_t g,
                                                             int what)
{
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    const uint32_t last = p->rows;
    struct found found = {num_of(0), num_of(0), num_of(0)};
    vec5 x, left;
    last_rows(p, g, &x, &left);
    svec F = v5_with(x, r[last].rhs);
    const svec alone = what & PIECES_BIAS ? sv_sub(F, r[last].p) : F;
    border_put(p, BORDER_ALONE, g, angular(&b[last].Iinv, alone).z);
    num rate = num_of(0); /* of the body at hand about its axis */
    for (uint32_t k = last; k-- > 0;) {
        x = k > 0 ? row_back(&r[k].factors, &left, &x) : left;
        const svec own = v5_with(x, r[k].rhs);
        const svec outboard = x_t_force(&r[k + 1].X, F);
        svec net = sv_sub(own, outboard);
        if (what & PIECES_BIAS)
            net = sv_sub(net, r[k].p);
        if (k == 0)
            leave_border(p, g, s6_mul(&b->Iinv, net), outboard, what);
        const vec3 a = angular(&b[k].Iinv, net);
        const mat3 *E = &r[k + 1].X.E;
        const num carried = v3_dot(v3(E->zx, E->zy, E->zz), a);
        if (k + 1 == last)
            border_put(p, BORDER_CARRIED, g, carried);
        else
            give(p, &b[k + 1], &r[k + 1], rate - carried, &found);
        F = own;
        rate = a.z;
    }
    border_put(p, BORDER_RATE, g, rate);
    p->finite[g] = found.finite;
    p->sum_qdd[g] = found.sum_qdd;
    p->sum_dx[g] = found.sum_dx;
}

static void substitute_group(void *context, uint32_t g, uint32_t worker)
{
    const struct pieces *p = context;
    (void)worker;
    if (p->what & PIECES_BIAS)
        substitute(p, g, PIECES_BIAS);
    else
        substitute(p, g, 0);
}

/* The last joint of each piece */
static void substitute_last(const struct pieces *p)
{
    for (uint32_t g = 0; g < p->groups; g++) {
        struct found found = {p->finite[g], p->sum_qdd[g], p->sum_dx[g]};
        num rate = border_get(p, BORDER_ALONE, g);
        for (uint32_t l = 0; l < NUM_LANES; l++)
            if (g * NUM_LANES + l + 1 < p->pieces)
                ((double *)&rate)[l] = border_at(p, BORDER_RATE, g)[l + 1];
        rate -= border_get(p, BORDER_CARRIED, g);
        give(p, &piece_bodies(p, g)[p->rows], &piece_rows(p, g)[p->rows], rate, &found);
        p->finite[g] = found.finite;
        p->sum_qdd[g] = found.sum_qdd;
        p->sum_dx[g] = found.sum_dx;
    }
}

void TFA_V(pieces_factor)(struct pieces *p)
{
    TFA_V(pieces_motion)(p);
    p->what = PIECES_FACTOR | PIECES_BIAS;
    crew_run(p->crew, eliminate_group, p, p->groups);
}

/* What is left when the rows inside the pieces are eliminated */
static void finish(struct pieces *p)
{
    TFA_V(pieces_last)(p);
    crew_run(p->crew, substitute_group, p, p->groups);
    substitute_last(p);
}

void TFA_V(pieces_forward)(struct pieces *p)
{
    TFA_V(pieces_factor)(p);
    finish(p);
}

void TFA_V(pieces_eliminate)(struct pieces *p)
{
    p->what = 0;
    crew_run(p->crew, eliminate_group, p, p->groups);
}

void TFA_V(pieces_correct)(struct pieces *p)
{
    TFA_V(pieces_eliminate)(p);
    finish(p);
}
