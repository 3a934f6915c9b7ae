/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total force algorithm on a partitioned chain: all rows of a partition but the last are
 * eliminated one after the other, each between the row behind it and the last row of the partition
 * before; the last rows of all partitions by cyclic reduction (partition_interface_solve.c); then
 * outside in, with the accelerations.
 */
#include "dynamics/core/revolute.h"
#include "dynamics/simd/block_row.h"

/* ---- one row from its body and the one before ---- */

/* D += Z TIT Z^T */
static inline void add_rotated(sym5 *D, const sym5 *T, num s, num c)
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
static inline mat5 rotated_transpose(const mat5 *T, num s, num c)
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
static inline svec unconstrained(const struct partition_body *b, const struct block_row *r,
                                 num next, int flags)
{
    svec f = {{-b->next_z.x * next, -b->next_z.y * next, r->rhs - b->next_z.z * next}, v3_zero()};
    if (flags & PARTITION_BIAS)
        f = sv_sub(f, r->p);
    return s6_mul(&b->Iinv, f);
}

/* ---- inside the partitions ---- */

/* Of the body before: acceleration without constraint forces, error of v */
struct elimination {
    svec e, dv;
};

/* v and p of a body */
static inline void velocity_products(const struct partition_body *b, struct block_row *r, svec dv)
{
    const svec v = r->v = sv_add(r->v, dv);
    r->p = s6_rigid_bias(b->I, b->h, b->mass, v);
}

static inline struct elimination elimination_start(const struct partition *p, uint32_t g, int flags)
{
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    struct elimination w;
    w.dv = sv_zero();
    if (flags & PARTITION_BIAS)
        r->p = sv_zero();
    if (flags & PARTITION_BIAS && p->moving) {
        interface_get_many(p, INTERFACE_MOTION_GAP, g, &w.dv.w.x, 6);
        velocity_products(b, r, w.dv);
    }
    w.e = unconstrained(b, r, r[1].rhs, flags);
    if (g == 0 && flags & PARTITION_BIAS) { /* the ground stands before the first partition */
        ((double *)&w.e.v.x)[0] = -num_lane(p->gravity.x, 0);
        ((double *)&w.e.v.y)[0] = -num_lane(p->gravity.y, 0);
        ((double *)&w.e.v.z)[0] = -num_lane(p->gravity.z, 0);
    }
    return w;
}

/* b of a row, and on to its body. `next`: the right-hand side of the next joint */
static inline vec5 elimination_step(const struct partition *p, struct elimination *w,
                                    const struct partition_body *b, struct block_row *r, num next,
                                    int flags)
{
    svec gap = xform_motion(&r->X, w->e);
    if (flags & PARTITION_BIAS)
        r->p = sv_zero();
    if (flags & PARTITION_BIAS && p->moving) {
        w->dv = xform_motion(&r->X, w->dv);
        velocity_products(b, r, w->dv);
        gap = sv_add(gap, revolute_velocity_product(r->v, r->qd));
    }
    w->e = unconstrained(b, r, next, flags);
    return v5_of(sv_scale(sv_sub(gap, w->e), b->is_body_mask));
}

/* Right-hand side of the joint behind row k: that of the last row is of the next partition */
static num next_force(const struct partition *p, uint32_t g, uint32_t k)
{
    num x = group_rows(p, g)[k < p->rows ? k + 1 : k].rhs;
    if (k < p->rows)
        return x;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const uint32_t next = g * NUM_LANES + l + 1;
        const struct block_row *r = group_rows(p, next / NUM_LANES) + 1;
        ((double *)&x)[l] = next < p->partitions ? ((const double *)&r->rhs)[next % NUM_LANES] : 0;
    }
    return x;
}

static inline __attribute__((always_inline)) void eliminate(const struct partition *p, uint32_t g,
                                                            int flags)
{
    static const struct block_equation none;
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    struct elimination w = elimination_start(p, g, flags);
    struct block_update left;
    struct block_equation row = none;
    update_clear(&left);
    for (uint32_t k = 1; k <= p->rows; k++) {
        const struct partition_body *bk = &b[k];
        struct block_factors *before = &r[k - 1].factors;
        const num s = r[k].sine, c = r[k].cosine;
        const mat5 U =
            flags & PARTITION_FACTOR ? rotated_transpose(&bk->minus_TI, s, c) : before->ZU;
        if (k > 1)
            row_factor(&row, &U, before, flags);
        else if (flags & PARTITION_FACTOR)
            row.L = m5_t(&U);
        row.b = elimination_step(p, &w, bk, &r[k], next_force(p, g, k), flags);
        if (flags & PARTITION_FACTOR) {
            row.D = s5_of(&bk->Iinv);
            add_rotated(&row.D, &bk->TIT, s, c);
        }
        if (k > 1)
            row_update(before, &left, &row, flags);
    }
    if (flags & PARTITION_FACTOR) {
        interface_put_many(p, INTERFACE_D, g, row.D.x, 15);
        interface_put_many(p, INTERFACE_L, g, &row.L.x[0][0], 25);
        interface_put_many(p, INTERFACE_LEFT_D, g, left.D.x, 15);
    }
    interface_put_many(p, INTERFACE_B, g, row.b.x, 5);
    interface_put_many(p, INTERFACE_LEFT_B, g, left.b.x, 5);
}

static void eliminate_group(void *context, uint32_t g, uint32_t worker)
{
    const struct partition *p = context;
    (void)worker;
    if (p->flags & PARTITION_FACTOR)
        eliminate(p, g, PARTITION_FACTOR | PARTITION_BIAS);
    else
        eliminate(p, g, 0);
}

/* ---- outside in ---- */

/* Angular part of I^-1 f */
static inline vec3 angular(const sym6 *Iinv, svec f)
{
    return v3_add(s3_mul(Iinv->A, f.w), m3_mul(Iinv->B, f.v));
}

/* x of the last row of each partition of the group, and of the partition before */
static inline void interface_values(const struct partition *p, uint32_t g, vec5 *current,
                                    vec5 *before)
{
    for (int k = 0; k < 5; k++) {
        const double *x = interface_at(p, INTERFACE_B + k, g);
        current->x[k] = *(const num *)(const void *)x;
        for (uint32_t l = 0; l < NUM_LANES; l++)
            ((double *)&before->x[k])[l] = g + l > 0 ? x[(int)l - 1] : 0;
    }
}

/* Solution for the joints at one place of the partitions */
struct solution {
    num finite, sum_qdd, sum_dx;
};

static inline void store_qdd(const struct partition *p, const struct partition_body *b,
                             struct block_row *r, num x, struct solution *solution)
{
    solution->sum_qdd += r->qdd * r->qdd;
    solution->sum_dx += x * x;
    r->qdd = p->flags & PARTITION_BIAS ? x : r->qdd + x;
    solution->finite += r->qdd - r->qdd;
    for (uint32_t l = 0; p->qdd && l < NUM_LANES; l++)
        if (b->real[l])
            p->qdd[b->v[l]] = num_lane(r->qdd, l);
}

/* Start of the residual, of the solution or of its correction: acceleration of the
 * body before a partition, force of the partition on it */
static inline void store_interface(const struct partition *p, uint32_t g, svec a, svec f, int flags)
{
    if (!(flags & PARTITION_BIAS)) {
        svec before;
        interface_get_many(p, INTERFACE_MOTION, g, &before.w.x, 6);
        a = sv_add(a, before);
        interface_get_many(p, INTERFACE_FORCE, g, &before.w.x, 6);
        f = sv_add(f, before);
    }
    interface_put_many(p, INTERFACE_MOTION, g, &a.w.x, 6);
    interface_put_many(p, INTERFACE_FORCE, g, &f.w.x, 6);
}

/* qdd of all joints but the last one of each partition, which needs the force behind it */
static inline __attribute__((always_inline)) void substitute(const struct partition *p, uint32_t g,
                                                             int flags)
{
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    const uint32_t last = p->rows;
    struct solution solution = {num_of(0), num_of(0), num_of(0)};
    vec5 x, left;
    interface_values(p, g, &x, &left);
    svec F = v5_with(x, r[last].rhs);
    const svec alone = flags & PARTITION_BIAS ? sv_sub(F, r[last].p) : F;
    interface_put(p, INTERFACE_RATE_FREE, g, angular(&b[last].Iinv, alone).z);
    num rate = num_of(0); /* of the body at hand about its axis */
    for (uint32_t k = last; k-- > 0;) {
        x = k > 0 ? row_back(&r[k].factors, &left, &x) : left;
        const svec current = v5_with(x, r[k].rhs);
        const svec outboard = xform_t_force(&r[k + 1].X, F);
        svec net = sv_sub(current, outboard);
        if (flags & PARTITION_BIAS)
            net = sv_sub(net, r[k].p);
        if (k == 0)
            store_interface(p, g, s6_mul(&b->Iinv, net), outboard, flags);
        const vec3 a = angular(&b[k].Iinv, net);
        const mat3 *E = &r[k + 1].X.E;
        const num inboard_rate = v3_dot(v3(E->zx, E->zy, E->zz), a);
        if (k + 1 == last)
            interface_put(p, INTERFACE_RATE_INBOARD, g, inboard_rate);
        else
            store_qdd(p, &b[k + 1], &r[k + 1], rate - inboard_rate, &solution);
        F = current;
        rate = a.z;
    }
    interface_put(p, INTERFACE_RATE, g, rate);
    p->finite[g] = solution.finite;
    p->sum_qdd[g] = solution.sum_qdd;
    p->sum_dx[g] = solution.sum_dx;
}

static void substitute_group(void *context, uint32_t g, uint32_t worker)
{
    const struct partition *p = context;
    (void)worker;
    if (p->flags & PARTITION_BIAS)
        substitute(p, g, PARTITION_BIAS);
    else
        substitute(p, g, 0);
}

/* The last joint of each partition */
static void substitute_last(const struct partition *p)
{
    for (uint32_t g = 0; g < p->groups; g++) {
        struct solution solution = {p->finite[g], p->sum_qdd[g], p->sum_dx[g]};
        num rate = interface_get(p, INTERFACE_RATE_FREE, g);
        for (uint32_t l = 0; l < NUM_LANES; l++)
            if (g * NUM_LANES + l + 1 < p->partitions)
                ((double *)&rate)[l] = interface_at(p, INTERFACE_RATE, g)[l + 1];
        rate -= interface_get(p, INTERFACE_RATE_INBOARD, g);
        store_qdd(p, &group_bodies(p, g)[p->rows], &group_rows(p, g)[p->rows], rate, &solution);
        p->finite[g] = solution.finite;
        p->sum_qdd[g] = solution.sum_qdd;
        p->sum_dx[g] = solution.sum_dx;
    }
}

void TFA_V(partition_factor)(struct partition *p)
{
    TFA_V(partition_motion)(p);
    p->flags = PARTITION_FACTOR | PARTITION_BIAS;
    parallel_for(p->executor, eliminate_group, p, p->groups);
}

/* Interface system after elimination of the rows inside the partitions */
static void solve_interior(struct partition *p)
{
    TFA_V(partition_interface_solve)(p);
    parallel_for(p->executor, substitute_group, p, p->groups);
    substitute_last(p);
}

void TFA_V(partition_forward)(struct partition *p)
{
    TFA_V(partition_factor)(p);
    solve_interior(p);
}

void TFA_V(partition_eliminate)(struct partition *p)
{
    p->flags = 0;
    parallel_for(p->executor, eliminate_group, p, p->groups);
}

void TFA_V(partition_correct)(struct partition *p)
{
    TFA_V(partition_eliminate)(p);
    solve_interior(p);
}
