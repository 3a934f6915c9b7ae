/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of a tip on the last body of a partitioned chain: the one-sided form of TFA
 * (lambda_tfa.c) with blocks of five. Right-hand sides are the effects of the unit wrenches P on
 * the joints,
 *
 *   tau_i = H^T P_i,   Lambda^-1 = P^T I_N^-1 (W x_N + Wa tau_N)
 *
 * so that the rows inside the partitions are eliminated and never found again: of the last body's
 * partition the row itself, of all partitions their last rows.
 */
#include "dynamics/core/unit_wrenches.h"
#include "dynamics/simd/block_row.h"

/* Where the last body stands */
struct tip {
    uint32_t part, group, lane, row;
};

static struct tip tip_of(const struct partition *p)
{
    const uint32_t part = (p->length - 1) / p->rows;
    return (struct tip){part, part / NUM_LANES, part % NUM_LANES, (p->length - 1) % p->rows + 1};
}

/* From the world's axes and origin to the tip's body. The same in every lane. */
static xform world_to_tip(const struct partition *p, struct tip tip)
{
    const struct block_row *r = group_rows(p, tip.group);
    xform X = r[1].X, from;
    double *numbers = (double *)&X.E.xx;
    for (uint32_t k = 2; k <= tip.row; k++)
        X = xform_compose(&X, &r[k].X);
    for (int e = 0; e < 12; e++) /* of the tip's lane in all of them */
        (&X.E.xx)[e] = num_of(numbers[(uint32_t)e * NUM_LANES + tip.lane]);
    for (uint32_t l = tip.part; l-- > 0;) {
        for (int e = 0; e < 12; e++)
            (&from.E.xx)[e] = num_of(p->interface[(size_t)(INTERFACE_XFORM + e) * p->width + l]);
        X = xform_compose(&from, &X);
    }
    return X;
}

static void unit_columns(const struct partition *p, struct tip tip, const tfa_request *r, svec P[6])
{
    const struct tfa_frame *f = &p->m->frame[r->tips[0]];
    mat3 R = m3_load(f->R);
    vec3 at = v3_load(f->p);
    if (r->frame != TFA_FRAME_LOCAL) {
        const xform X = world_to_tip(p, tip);
        R = X.E;
        if (r->frame == TFA_FRAME_WORLD)
            at = v3_neg(m3_mul(X.E, X.r));
    }
    unit_wrenches(R, at, P);
}

/* INTERFACE_FORCE_OUTBOARD: a wrench on the tip as the last body of each partition feels it, and
 * filling behind the tip */
static void propagate_to_interfaces(const struct partition *p, struct tip tip, svec P)
{
    const struct block_row *r = group_rows(p, tip.group);
    num *numbers = &P.w.x;
    for (uint32_t l = tip.part + 1; l < p->partitions; l++)
        interface_put_column(p, INTERFACE_FORCE_OUTBOARD, l, sv_zero());
    interface_put_column(p, INTERFACE_FORCE_OUTBOARD, tip.part, P);
    for (uint32_t k = tip.row; k > 0; k--)
        P = xform_t_force(&r[k].X, P);
    for (int e = 0; e < 6; e++) /* of the tip's lane in all of them */
        numbers[e] = num_of(num_lane(numbers[e], tip.lane));
    for (uint32_t l = tip.part; l-- > 0;) {
        xform X;
        interface_put_column(p, INTERFACE_FORCE_OUTBOARD, l, P);
        interface_column(p, INTERFACE_XFORM, l, &X.E.xx, 12);
        P = xform_t_force(&X, P);
    }
}

/* From the last body of each partition inward; lanes without a body pass their value on. */
static void propagate_group(void *context, uint32_t g, uint32_t worker)
{
    const struct partition *p = context;
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    svec P;
    (void)worker;
    interface_get_many(p, INTERFACE_FORCE_OUTBOARD, g, &P.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        const svec inboard = xform_t_force(&r[k].X, P);
        const num *from = &inboard.w.x;
        num *to = &P.w.x;
        r[k].rhs = P.w.z * b[k].is_body_mask;
        for (int e = 0; e < 6; e++)
            to[e] = num_select(b[k].is_body_mask > num_of(0), from[e], to[e]);
    }
}

/* Force on the tip's body by the right-hand side of P */
static svec tip_force(struct partition *p, struct tip tip, svec P, int flags)
{
    const struct block_row *r = &group_rows(p, tip.group)[tip.row];
    vec5 x, left;
    propagate_to_interfaces(p, tip, P);
    parallel_for(p->executor, propagate_group, p, p->groups);
    TFA_V(partition_share_rhs)(p);
    TFA_V(partition_eliminate)(p);
    p->flags = flags;
    TFA_V(partition_interface_solve)(p);
    for (int k = 0; k < 5; k++) {
        const double *found = p->interface + (size_t)(INTERFACE_B + k) * p->width + tip.part;
        x.x[k] = tip.row == p->rows ? num_of(*found) : r->factors.y.x[k];
        left.x[k] = num_of(tip.part > 0 ? found[-1] : 0);
    }
    if (tip.row < p->rows) { /* nothing is outboard of it */
        v5_sub_mul(&x, &r->factors.ZL, &left);
        s5_scale(&r->factors.M, &x);
        s5_upper(&r->factors.M, &x);
    }
    return v5_with(x, P.w.z);
}

void TFA_V(partition_lambda)(struct partition *p, const tfa_request *r, double *lambda)
{
    const struct tip tip = tip_of(p);
    const struct partition_body *b = &group_bodies(p, tip.group)[tip.row];
    svec P[6], a[6];
    TFA_V(partition_factor)(p);
    unit_columns(p, tip, r, P);
    for (int e = 0; e < 6; e++)
        a[e] = s6_mul(&b->Iinv, tip_force(p, tip, P[e], e == 0 ? PARTITION_FACTOR : 0));
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++) {
            const num both = sv_dot(P[e], a[f]) + sv_dot(P[f], a[e]);
            lambda[6 * e + f] = num_lane(both, tip.lane) / 2;
        }
}
