/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Six numbers side by side in as many vectors as they take: the same component of six spatial
 * vectors, so that what is done to one of them is done to all in one go. NUM_ROW is how many numbers
 * the variant's instruction set takes at a time; what stands behind the sixth is never read.
 */
#ifndef TFA_SPATIAL_SIX_H
#define TFA_SPATIAL_SIX_H

#include <string.h>

#include "spatial/spatial.h"

#ifdef NUM_ROW
typedef num num_row __attribute__((vector_size(NUM_ROW * sizeof(num))));
#define row_lane(x, k) ((x)[k])
#if NUM_ROW == 8
typedef num num_row_4 __attribute__((vector_size(4 * sizeof(num))));
typedef num num_row_2 __attribute__((vector_size(2 * sizeof(num))));
#endif
#else
#define NUM_ROW 1
typedef num num_row;
#define row_lane(x, k) (x)
#endif

#define SIX_ROWS ((6 + NUM_ROW - 1) / NUM_ROW)

typedef struct six {
    num_row row[SIX_ROWS];
} six;

/* Number e: a constant wherever speed counts */
#define six_lane(x, e) row_lane((x)->row[(e) / NUM_ROW], (e) % NUM_ROW)

static inline six six_zero(void)
{
    six x;
    for (int k = 0; k < SIX_ROWS; k++)
        x.row[k] = (num_row){0};
    return x;
}

static inline six six_scale(num s, six x)
{
    for (int k = 0; k < SIX_ROWS; k++)
        x.row[k] = s * x.row[k];
    return x;
}

/* x + s y */
static inline six six_add(six x, num s, six y)
{
    for (int k = 0; k < SIX_ROWS; k++)
        x.row[k] += s * y.row[k];
    return x;
}

/* x - s y */
static inline six six_sub(six x, num s, six y)
{
    for (int k = 0; k < SIX_ROWS; k++)
        x.row[k] -= s * y.row[k];
    return x;
}

/* a x + b y + c z */
static inline six six_combine(num a, six x, num b, six y, num c, six z)
{
    return six_add(six_add(six_scale(a, x), b, y), c, z);
}

/* As many at a time as fit: nothing behind the sixth is written. */
static inline void six_store(num *out, const six *x)
{
#if NUM_ROW == 8
    const num_row_4 first = __builtin_shufflevector(x->row[0], x->row[0], 0, 1, 2, 3);
    const num_row_2 rest = __builtin_shufflevector(x->row[0], x->row[0], 4, 5);
    memcpy(out, &first, sizeof first);
    memcpy(out + 4, &rest, sizeof rest);
#else
    memcpy(out, x->row, 6 / NUM_ROW * sizeof(num_row));
    for (int e = 6 / NUM_ROW * NUM_ROW; e < 6; e++)
        out[e] = six_lane(x, e);
#endif
}

static inline six six_load(const num *in)
{
#if NUM_ROW == 8
    num_row_4 first;
    num_row_2 rest;
    memcpy(&first, in, sizeof first);
    memcpy(&rest, in + 4, sizeof rest);
    const num_row_4 last = __builtin_shufflevector(rest, rest, 0, 1, 1, 1);
    return (six){{__builtin_shufflevector(first, last, 0, 1, 2, 3, 4, 5, 5, 5)}};
#else
    six x = six_zero();
    memcpy(x.row, in, 6 / NUM_ROW * sizeof(num_row));
    for (int e = 6 / NUM_ROW * NUM_ROW; e < 6; e++)
        six_lane(&x, e) = in[e];
    return x;
#endif
}

/* ---- three numbers, which stand in front; 0 behind ---- */

#define THREE_ROWS ((3 + NUM_ROW - 1) / NUM_ROW)

typedef struct three {
    num_row row[THREE_ROWS];
} three;

static inline three three_of(num a, num b, num c)
{
#if NUM_ROW >= 4
    return (three){{(num_row){a, b, c}}};
#elif NUM_ROW == 2
    return (three){{(num_row){a, b}, (num_row){c}}};
#else
    return (three){{a, b, c}};
#endif
}

/* a x - b y */
static inline three three_minus(num a, three x, num b, three y)
{
    for (int k = 0; k < THREE_ROWS; k++)
        x.row[k] = a * x.row[k] - b * y.row[k];
    return x;
}

/* a x + b y + c z */
static inline three three_combine(num a, three x, num b, three y, num c, three z)
{
    for (int k = 0; k < THREE_ROWS; k++)
        x.row[k] = a * x.row[k] + b * y.row[k] + c * z.row[k];
    return x;
}

/* x, then y; and x alone */
static inline six six_join(three x, three y)
{
#if NUM_ROW == 8
    return (six){{__builtin_shufflevector(x.row[0], y.row[0], 0, 1, 2, 8, 9, 10, 3, 3)}};
#elif NUM_ROW == 4
    return (six){{__builtin_shufflevector(x.row[0], y.row[0], 0, 1, 2, 4),
                  __builtin_shufflevector(y.row[0], y.row[0], 1, 2, 3, 3)}};
#elif NUM_ROW == 2
    return (six){{x.row[0], __builtin_shufflevector(x.row[1], y.row[0], 0, 2),
                  __builtin_shufflevector(y.row[0], y.row[1], 1, 2)}};
#else
    return (six){{x.row[0], x.row[1], x.row[2], y.row[0], y.row[1], y.row[2]}};
#endif
}

static inline six six_alone(three x)
{
    six out = six_zero();
    for (int k = 0; k < THREE_ROWS; k++)
        out.row[k] = x.row[k];
    return out;
}

/* The three by rows */
struct axes {
    three row[3];
};

static inline struct axes axes_of(mat3 R)
{
    return (struct axes){
        {three_of(R.xx, R.xy, R.xz), three_of(R.yx, R.yy, R.yz), three_of(R.zx, R.zy, R.zz)}};
}

static inline num three_lane(const three *x, int e)
{
    return row_lane(x->row[e / NUM_ROW], e % NUM_ROW);
}

static inline struct axes axes_transpose(const struct axes *R)
{
    struct axes out;
    for (int k = 0; k < 3; k++)
        out.row[k] = three_of(three_lane(&R->row[0], k), three_lane(&R->row[1], k),
                              three_lane(&R->row[2], k));
    return out;
}

/* E^T R */
static inline struct axes axes_turn_back(const mat3 *E, const struct axes *R)
{
    const three x = R->row[0], y = R->row[1], z = R->row[2];
    return (struct axes){{three_combine(E->xx, x, E->yx, y, E->zx, z),
                          three_combine(E->xy, x, E->yy, y, E->zy, z),
                          three_combine(E->xz, x, E->yz, y, E->zz, z)}};
}

/* ---- six wrenches ---- */

/* Six forces on a body: component k of all of them, angular first */
struct wrenches {
    six at[6];
};

/* Vector by vector, without a loop: gcc copies a structure of this size, and makes of a loop, a string
 * instruction that takes longer than what is done to it on the way past a joint (10 ns, AMD EPYC Zen 5,
 * gcc 12, 2026-11-22). */
static inline void six_copy(six *to, const six *from)
{
    to->row[0] = from->row[0];
#if NUM_ROW < 8
    to->row[1] = from->row[1];
#endif
#if NUM_ROW < 4
    to->row[2] = from->row[2];
#endif
#if NUM_ROW < 2
    to->row[3] = from->row[3];
    to->row[4] = from->row[4];
    to->row[5] = from->row[5];
#endif
}

static inline void sixes_copy(six to[6], const six from[6])
{
    six_copy(&to[0], &from[0]);
    six_copy(&to[1], &from[1]);
    six_copy(&to[2], &from[2]);
    six_copy(&to[3], &from[3]);
    six_copy(&to[4], &from[4]);
    six_copy(&to[5], &from[5]);
}

static inline void wrenches_copy(struct wrenches *to, const struct wrenches *from)
{
    sixes_copy(to->at, from->at);
}

static inline struct wrenches wrenches_from(const svec P[6])
{
    struct wrenches w;
    for (int k = 0; k < 6; k++)
        w.at[k] = six_zero();
    for (int e = 0; e < 6; e++) {
        num x[6];
        sv_store(x, P[e]);
        for (int k = 0; k < 6; k++)
            six_lane(&w.at[k], e) = x[k];
    }
    return w;
}

/* 1 in each component in turn */
static inline struct wrenches wrenches_unit(void)
{
    struct wrenches w;
    for (int k = 0; k < 6; k++) {
        w.at[k] = six_zero();
        six_lane(&w.at[k], k) = num_of(1);
    }
    return w;
}

/* Unit forces, then unit moments about point p along three axes, the columns of R: row by row
 * [p x R, R; R, 0] */
static inline struct wrenches wrenches_at(const struct axes *R, vec3 p)
{
    const three x = R->row[0], y = R->row[1], z = R->row[2];
    return (struct wrenches){
        {six_join(three_minus(p.y, z, p.z, y), x), six_join(three_minus(p.z, x, p.x, z), y),
         six_join(three_minus(p.x, y, p.y, x), z), six_alone(x), six_alone(y), six_alone(z)}};
}

/* Wrench e of the six */
static inline svec wrench(const struct wrenches *w, int e)
{
    num x[6];
    for (int k = 0; k < 6; k++)
        x[k] = six_lane(&w->at[k], e);
    return sv_from(x);
}

static inline void wrenches_store(const struct wrenches *w, svec P[6])
{
    for (int e = 0; e < 6; e++)
        P[e] = wrench(w, e);
}

/* X^T P: from the child's frame to the parent's. `past_z`: no moment about z is left, at[2] is 0. */
TFA_INLINE void wrenches_to_parent(const place *X, struct wrenches *P, int past_z)
{
    six *at = P->at;
    const mat3 *E = &X->E;
    const vec3 r = X->r;
    const six x = six_combine(E->xx, at[3], E->yx, at[4], E->zx, at[5]);
    const six y = six_combine(E->xy, at[3], E->yy, at[4], E->zy, at[5]);
    const six z = six_combine(E->xz, at[3], E->yz, at[4], E->zz, at[5]);
    six mx = six_add(six_scale(E->xx, at[0]), E->yx, at[1]);
    six my = six_add(six_scale(E->xy, at[0]), E->yy, at[1]);
    six mz = six_add(six_scale(E->xz, at[0]), E->yz, at[1]);
    if (!past_z) {
        mx = six_add(mx, E->zx, at[2]);
        my = six_add(my, E->zy, at[2]);
        mz = six_add(mz, E->zz, at[2]);
    }
    at[0] = six_sub(six_add(mx, r.y, z), r.z, y);
    at[1] = six_sub(six_add(my, r.z, x), r.x, z);
    at[2] = six_sub(six_add(mz, r.x, y), r.y, x);
    at[3] = x;
    at[4] = y;
    at[5] = z;
}

/* M P for a dense symmetric or other M, row major */
static inline struct wrenches wrenches_apply(const num *M, const struct wrenches *P)
{
    struct wrenches out;
    for (int i = 0; i < 6; i++) {
        out.at[i] = six_scale(M[6 * i], P->at[0]);
        for (int k = 1; k < 6; k++)
            out.at[i] = six_add(out.at[i], M[6 * i + k], P->at[k]);
    }
    return out;
}

/* M^T P */
static inline struct wrenches wrenches_apply_t(const num *M, const struct wrenches *P)
{
    struct wrenches out;
    for (int i = 0; i < 6; i++) {
        out.at[i] = six_scale(M[i], P->at[0]);
        for (int k = 1; k < 6; k++)
            out.at[i] = six_add(out.at[i], M[6 * k + i], P->at[k]);
    }
    return out;
}

/* ---- what six wrenches do to six: a 6 x 6 matrix by its rows ---- */

struct block {
    six row[6];
};

static inline struct block block_zero(void)
{
    struct block C;
    for (int e = 0; e < 6; e++)
        C.row[e] = six_zero();
    return C;
}

static inline void block_copy(struct block *to, const struct block *from)
{
    sixes_copy(to->row, from->row);
}

/* C += psi^T phi */
static inline void block_add(struct block *C, const six *psi, const six *phi)
{
    for (int e = 0; e < 6; e++)
        C->row[e] = six_add(C->row[e], six_lane(psi, e), *phi);
}

/* C += P^T Q */
static inline void wrenches_respond(struct block *C, const struct wrenches *P,
                                    const struct wrenches *Q)
{
    for (int k = 0; k < 6; k++)
        block_add(C, &P->at[k], &Q->at[k]);
}

#endif
