/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of a tip on the last body of a chain in pieces: the one-sided form of TFA
 * (lambda_tfa.c) with blocks of five. Right-hand sides are what the unit wrenches P do to the
 * joints,
 *
 *   tau_i = H^T P_i,   Lambda^-1 = P^T I_N^-1 (W x_N + Wa tau_N)
 *
 * so that the rows inside the pieces are eliminated and never found again: of the last body's piece
 * the row itself, of all pieces their last rows.
 */
#include "kernel/pieces_row.h"
#include "kernel/wrenches.h"

/* Where the last body stands */
struct tip {
    uint32_t piece, group, lane, row;
};

static struct tip tip_of(const struct pieces *p)
{
    const uint32_t piece = (p->length - 1) / p->rows;
    return (struct tip){piece, piece / NUM_LANES, piece % NUM_LANES, (p->length - 1) % p->rows + 1};
}

/* From the world's axes and origin to the tip's body. The same in every lane. */
static place world_to_tip(const struct pieces *p, struct tip tip)
{
    const struct piece_row *r = piece_rows(p, tip.group);
    place X = r[1].X, from;
    double *numbers = (double *)&X.E.xx;
    for (uint32_t k = 2; k <= tip.row; k++)
        X = x_then(&X, &r[k].X);
    for (int e = 0; e < 12; e++) /* of the tip's lane in all of them */
        (&X.E.xx)[e] = num_of(numbers[(uint32_t)e * NUM_LANES + tip.lane]);
    for (uint32_t l = tip.piece; l-- > 0;) {
        for (int e = 0; e < 12; e++)
            (&from.E.xx)[e] = num_of(p->border[(size_t)(BORDER_PLACE + e) * p->width + l]);
        X = x_then(&from, &X);
    }
    return X;
}

static void unit_columns(const struct pieces *p, struct tip tip, const tfa_request *r, svec P[6])
{
    const struct tfa_frame *f = &p->m->frame[r->tips[0]];
    mat3 R = m3_load(f->R);
    vec3 at = v3_load(f->p);
    if (r->frame != TFA_FRAME_LOCAL) {
        const place X = world_to_tip(p, tip);
        R = X.E;
        if (r->frame == TFA_FRAME_WORLD)
            at = v3_neg(m3_mul(X.E, X.r));
    }
    unit_wrenches(R, at, P);
}

/* BORDER_BEHIND: a wrench on the tip as the last body of each piece feels it, and filling behind
 * the tip */
static void carry_borders(const struct pieces *p, struct tip tip, svec P)
{
    const struct piece_row *r = piece_rows(p, tip.group);
    num *numbers = &P.w.x;
    for (uint32_t l = tip.piece + 1; l < p->pieces; l++)
        border_put_column(p, BORDER_BEHIND, l, sv_zero());
    border_put_column(p, BORDER_BEHIND, tip.piece, P);
    for (uint32_t k = tip.row; k > 0; k--)
        P = x_t_force(&r[k].X, P);
    for (int e = 0; e < 6; e++) /* of the tip's lane in all of them */
        numbers[e] = num_of(num_lane(numbers[e], tip.lane));
    for (uint32_t l = tip.piece; l-- > 0;) {
        place X;
        border_put_column(p, BORDER_BEHIND, l, P);
        border_column(p, BORDER_PLACE, l, &X.E.xx, 12);
        P = x_t_force(&X, P);
    }
}

/* From the last body of each piece inward; filling hands on what it has. */
static void carry_group(void *context, uint32_t g, uint32_t worker)
{
    const struct pieces *p = context;
    const struct piece_body *b = piece_bodies(p, g);
    struct piece_row *r = piece_rows(p, g);
    svec P;
    (void)worker;
    border_get_many(p, BORDER_BEHIND, g, &P.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        const svec inboard = x_t_force(&r[k].X, P);
        const num *from = &inboard.w.x;
        num *to = &P.w.x;
        r[k].rhs = P.w.z * b[k].live;
        for (int e = 0; e < 6; e++)
            to[e] = num_select(b[k].live > num_of(0), from[e], to[e]);
    }
}

/* Force on the tip's body by the right-hand side of P */
static svec tip_force(struct pieces *p, struct tip tip, svec P, int what)
{
    const struct piece_row *r = &piece_rows(p, tip.group)[tip.row];
    vec5 x, left;
    carry_borders(p, tip, P);
    crew_run(p->crew, carry_group, p, p->groups);
    TFA_V(pieces_tell_next)(p);
    TFA_V(pieces_eliminate)(p);
    p->what = what;
    TFA_V(pieces_last)(p);
    for (int k = 0; k < 5; k++) {
        const double *found = p->border + (size_t)(BORDER_B + k) * p->width + tip.piece;
        x.x[k] = tip.row == p->rows ? num_of(*found) : r->factors.y.x[k];
        left.x[k] = num_of(tip.piece > 0 ? found[-1] : 0);
    }
    if (tip.row < p->rows) { /* nothing is outboard of it */
        v5_take(&x, &r->factors.ZL, &left);
        s5_scale(&r->factors.M, &x);
        s5_upper(&r->factors.M, &x);
    }
    return v5_with(x, P.w.z);
}

void TFA_V(pieces_lambda)(struct pieces *p, const tfa_request *r, double *lambda)
{
    const struct tip tip = tip_of(p);
    const struct piece_body *b = &piece_bodies(p, tip.group)[tip.row];
    svec P[6], a[6];
    TFA_V(pieces_factor)(p);
    unit_columns(p, tip, r, P);
    for (int e = 0; e < 6; e++)
        a[e] = s6_mul(&b->Iinv, tip_force(p, tip, P[e], e == 0 ? PIECES_FACTOR : 0));
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++) {
            const num both = sv_dot(P[e], a[f]) + sv_dot(P[f], a[e]);
            lambda[6 * e + f] = num_lane(both, tip.lane) / 2;
        }
}
