/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of a tip on the last body of a chain in pieces: the one-sided form of TFA (lambda_tfa.c)
 * with blocks of five. The unit wrenches P stand in the last row only,
 *
 *   b_N = -W^T I_N^-1 P,   Lambda^-1 = P^T I_N^-1 (W x_N + P)
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

/* x of the tip's row for the right-hand side b. The first call factors the last rows. */
static vec5 tip_row(struct pieces *p, struct tip tip, vec5 b, int what)
{
    const struct piece_factors *f = &piece_rows(p, tip.group)[tip.row].factors;
    const int last = tip.row == p->rows;
    vec5 y = b, left;
    for (int k = 0; k < 5; k++) {
        double *own = p->border + (size_t)(BORDER_B + k) * p->width;
        double *shares = p->border + (size_t)(BORDER_LEFT_B + k) * p->width;
        for (uint32_t l = 0; l < p->pieces; l++)
            own[l] = shares[l] = 0;
    }
    if (!last) {
        vec5 scaled, share = {{num_of(0), num_of(0), num_of(0), num_of(0), num_of(0)}};
        s5_lower(&f->M, &y);
        scaled = y;
        s5_scale(&f->M, &scaled);
        v5_take_t(&share, &f->ZL, &scaled);
        for (int k = 0; k < 5; k++)
            p->border[(size_t)(BORDER_LEFT_B + k) * p->width + tip.piece] =
                num_lane(share.x[k], tip.lane);
    } else {
        for (int k = 0; k < 5; k++)
            p->border[(size_t)(BORDER_B + k) * p->width + tip.piece] = num_lane(b.x[k], tip.lane);
    }
    p->what = what;
    TFA_V(pieces_last)(p);
    for (int k = 0; k < 5; k++) {
        const double *x = p->border + (size_t)(BORDER_B + k) * p->width + tip.piece;
        if (last)
            y.x[k] = num_of(*x);
        else
            left.x[k] = num_of(tip.piece > 0 ? x[-1] : 0);
    }
    if (!last) {
        v5_take(&y, &f->ZL, &left);
        s5_scale(&f->M, &y);
        s5_upper(&f->M, &y);
    }
    return y;
}

void TFA_V(pieces_lambda)(struct pieces *p, const tfa_request *r, double *lambda)
{
    const struct tip tip = tip_of(p);
    const struct piece_body *b = &piece_bodies(p, tip.group)[tip.row];
    svec P[6], a[6];
    TFA_V(pieces_factor)(p);
    unit_columns(p, tip, r, P);
    for (int e = 0; e < 6; e++) {
        const vec5 rhs = v5_of(sv_scale(s6_mul(&b->Iinv, P[e]), num_of(-1)));
        const vec5 x = tip_row(p, tip, rhs, e == 0 ? PIECES_FACTOR : 0);
        a[e] = s6_mul(&b->Iinv, sv_add(v5_with(x, num_of(0)), P[e]));
    }
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < 6; f++) {
            const num both = sv_dot(P[e], a[f]) + sv_dot(P[f], a[e]);
            lambda[6 * e + f] = num_lane(both, tip.lane) / 2;
        }
}
