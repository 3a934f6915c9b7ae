/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The matrices of a state's derivatives side by side, and M^-1 times them.
 */
#ifndef TFA_DYNAMICS_DERIVATIVES_BLOCKS_H
#define TFA_DYNAMICS_DERIVATIVES_BLOCKS_H

#include "dynamics/derivatives/inverse_derivatives.h"
#include "layout/mass_rows.h"
#include "spatial/rows.h"

/* By q, by v, by tau */
enum { BY_Q, BY_V, BY_TAU, BLOCKS = DERIVATIVES_MATRICES };

struct blocks {
    double *out[BLOCKS]; /* of all states; NULL: not asked */
    num *X[BLOCKS];      /* first number of each; those asked stand first in their groups */
    num *all;
    int asked;
    size_t n, groups, stride;
};

/* Of n public freedoms, in `all`; all zero, but 1 for the forces */
TFA_INLINE struct blocks clear_blocks(double *const matrices[BLOCKS], num *all, size_t n)
{
    struct blocks b = {.all = all, .n = n};
    for (int by = 0; by < BLOCKS; by++) {
        b.out[by] = matrices[by];
        b.asked += b.out[by] != NULL;
    }
    for (int by = 0, first = 0, last = b.asked; by < BLOCKS; by++)
        b.X[by] = all + DERIVATIVES_GROUP * (b.out[by] ? first++ : last++);
    b.groups = (n + DERIVATIVES_GROUP - 1) / DERIVATIVES_GROUP;
    b.stride = DERIVATIVES_GROUP * BLOCKS * b.groups;
    for (size_t e = 0; e < b.stride * n; e++)
        all[e] = num_of(0);
    for (uint32_t j = 0; j < n; j++)
        b.X[BY_TAU][b.stride * j + derivatives_column(j)] = num_of(1);
    return b;
}

/* ---- M^-1 X of the blocks asked ---- */

/* M = L^T D L (layout/mass_rows.h), and the public row of each freedom */
struct mass_factors {
    const struct tfa_model *m;
    const num *M;
    const uint32_t *row;
};

/* The columns of as many groups as registers hold, the same freedoms in each block: rows are zero
 * at the branches of other freedoms. */
#define GROUP_VECS (DERIVATIVES_GROUP / NUM_VEC_LANES)
#define PANEL_GROUPS NUM_VEC_LANES /* twelve vectors */
#define PANEL_VECS_MOST (PANEL_GROUPS * BLOCKS * GROUP_VECS)

/* Vectors v of a row, of so many blocks asked */
TFA_INLINE num *panel_vec(num *row, int v, int blocks)
{
    const int group = v / (blocks * GROUP_VECS), rest = v % (blocks * GROUP_VECS);
    return row + DERIVATIVES_GROUP * BLOCKS * group + NUM_VEC_LANES * rest;
}

/* Rows of ancestors -= L x their descendant's, inward */
TFA_INLINE void solve_inward(const struct mass_factors *f, num *X, size_t stride, int groups,
                             int blocks)
{
    const struct tfa_model *m = f->m;
    const int vecs = groups * blocks * GROUP_VECS;
    for (uint32_t k = m->freedoms; k-- > 0;) {
        const num *L = f->M + m->dof_row[k] + m->dof_depth[k];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = numbers_load(panel_vec(X + stride * f->row[k], v, blocks));
        if (numbers_are_zero(x, vecs))
            continue;
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *const row = X + stride * f->row[i];
            const num l = *--L;
            for (int v = 0; v < vecs; v++) {
                num *const at = panel_vec(row, v, blocks);
                numbers_store(at, numbers_load(at) - l * x[v]);
            }
        }
    }
}

/* Rows divided by D, -= L x those of their ancestors, outward */
TFA_INLINE void solve_outward(const struct mass_factors *f, num *X, size_t stride, int groups,
                              int blocks)
{
    const struct tfa_model *m = f->m;
    const int vecs = groups * blocks * GROUP_VECS;
    for (uint32_t k = 0; k < m->freedoms; k++) {
        const num *L = f->M + m->dof_row[k] + m->dof_depth[k];
        const num inverse = 1 / *L;
        num *const to = X + stride * f->row[k];
        num_vec x[PANEL_VECS_MOST];
        for (int v = 0; v < vecs; v++)
            x[v] = numbers_load(panel_vec(to, v, blocks)) * inverse;
        for (int32_t i = m->dof_parent[k]; i >= 0; i = m->dof_parent[i]) {
            num *const row = X + stride * f->row[i];
            const num l = *--L;
            for (int v = 0; v < vecs; v++)
                x[v] -= l * numbers_load(panel_vec(row, v, blocks));
        }
        for (int v = 0; v < vecs; v++)
            numbers_store(panel_vec(to, v, blocks), x[v]);
    }
}

/* Groups from g on, so many at a time. Returns the first one that is left. */
TFA_INLINE size_t solve_groups(const struct mass_factors *f, const struct blocks *b, size_t g,
                               int groups, int blocks)
{
    for (; g + (size_t)groups <= b->groups; g += (size_t)groups) {
        num *X = b->all + DERIVATIVES_GROUP * BLOCKS * g;
        solve_inward(f, X, b->stride, groups, blocks);
        solve_outward(f, X, b->stride, groups, blocks);
    }
    return g;
}

/* By M = L^T D L: as solve_mass_rows, for all columns of a panel at once */
TFA_INLINE void solve_panels(const struct mass_factors *f, const struct blocks *b, int blocks)
{
    size_t g = solve_groups(f, b, 0, PANEL_GROUPS, blocks);
    if (PANEL_GROUPS > 2)
        g = solve_groups(f, b, g, 2, blocks);
    if (PANEL_GROUPS > 1)
        (void)solve_groups(f, b, g, 1, blocks);
}

TFA_INLINE void solve_rows(const struct mass_factors *f, const struct blocks *b)
{
    if (b->asked == 1)
        solve_panels(f, b, 1);
    else
        solve_panels(f, b, BLOCKS);
}

/* ---- output ---- */

/* Added up, not finite where a number is not, as a double: 0 elsewhere, or where compilers are told
 * that there are no such numbers, the numbers */
#ifdef NUM_QUAD
#define BLOCKS_REST(y) ((double)(y) - (double)(y))
#elif defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__
#define BLOCKS_REST(y) (y)
#else
#define BLOCKS_REST(y) ((y) - (y))
#endif

#if NUM_LANES == 1
/* Numbers of a vector as doubles */
TFA_INLINE void store_doubles(double *out, num_vec x)
{
    if (sizeof(num) == sizeof *out)
        memcpy(out, &x, NUM_VEC_LANES * sizeof *out);
    else
        for (int l = 0; l < NUM_VEC_LANES; l++)
            out[l] = (double)vec_lane(x, l);
}
#endif

/* out = sign x + zero for a row of n numbers in groups, in the matrices of all states. Returns
 * rest + BLOCKS_REST of them. */
TFA_INLINE num_vec unload_row(const num *x, num sign, num zero, double *out, size_t n,
                              const uint32_t *lane, num_vec rest)
{
    const size_t square = n * n, whole = n / DERIVATIVES_GROUP * DERIVATIVES_GROUP;
    for (size_t j = 0; j < whole; j += DERIVATIVES_GROUP) {
        num_vec y[GROUP_VECS];
        for (int v = 0; v < GROUP_VECS; v++) {
            const num *const from = x + derivatives_column((uint32_t)j) + NUM_VEC_LANES * v;
            y[v] = sign * numbers_load(from) + zero;
            rest += BLOCKS_REST(y[v]);
#if NUM_LANES == 1
            store_doubles(out + square * lane[0] + j + NUM_VEC_LANES * (size_t)v, y[v]);
#endif
        }
#if NUM_LANES > 1
        scatter_numbers(y, lane, out + j, square, DERIVATIVES_GROUP);
#endif
    }
    for (size_t j = whole; j < n; j++) {
        const num y = sign * x[derivatives_column((uint32_t)j)] + zero;
        rest += BLOCKS_REST(y);
        scatter_numbers(&y, lane, out + j, square, 1);
    }
    return rest;
}

/* The blocks asked, those by motion times sign, all + zero. Returns the sum of BLOCKS_REST of their
 * numbers. */
TFA_INLINE num unload_blocks(const struct blocks *b, num sign, num zero, const uint32_t *lane)
{
    num_vec rest = {0};
    num sum = num_of(0);
    for (int by = 0; by < BLOCKS; by++)
        for (size_t i = 0; b->out[by] && i < b->n; i++)
            rest = unload_row(b->X[by] + b->stride * i, by == BY_TAU ? num_of(1) : sign, zero,
                              b->out[by] + b->n * i, b->n, lane, rest);
    for (int l = 0; l < NUM_VEC_LANES; l++)
        sum += vec_lane(rest, l);
    return sum;
}

#endif
