/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constraint force algorithm: the rows of cfa_row.h by block LDL^T.
 *
 *   S_k = A_kk - A_{k,k-1} G_k,   G_k = S_{k-1}^-1 A_{k,k-1}^T
 */
#include "dynamics/chain/cfa_row.h"
#include "dynamics/chain/chain.h"
#include "spatial/dense.h"

struct ldl_row {
    num S[36]; /* LDL^T factors */
    num G[36]; /* as many rows as S of the row before, as many columns as S of this one */
    num x[6];  /* right-hand side, then lambda */
};

/* Factors kept, and behind them the terms of the rows */
static inline struct cfa_row *cfa_rows_of(struct ldl_row *row, size_t length)
{
    return (struct cfa_row *)(void *)(row + length);
}

/* G_k from L = A_{k,k-1}, and S_k from A_kk in it */
static void eliminate(struct ldl_row *row, uint32_t n, uint32_t before, const num *L)
{
    for (uint32_t j = 0; j < n; j++) { /* column j of G: row j of L */
        num column[6];
        for (uint32_t e = 0; e < before; e++)
            column[e] = L[6 * j + e];
        ldl_solve(row[-1].S, (int)before, column);
        for (uint32_t e = 0; e < before; e++)
            row->G[6 * e + j] = column[e];
    }
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t k = 0; k <= j; k++)
            for (uint32_t e = 0; e < before; e++)
                row->S[6 * j + k] -= L[6 * j + e] * row->G[6 * e + k];
}

static size_t bytes(size_t length)
{
    return length * (sizeof(struct ldl_row) + sizeof(struct cfa_row));
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    struct ldl_row *row = rows;
    struct cfa_row *parts = cfa_rows_of(row, chain->length);
    uint32_t before = 0;
    for (uint32_t k = 0; k < chain->length; k++) {
        num L[36];
        if (!cfa_start(s, chain, parts, k))
            return TFA_E_SINGULAR;
        const uint32_t n = cfa_size(&parts[k].joint);
        cfa_assemble(s, chain, parts, k, row[k].S, L);
        if (k > 0)
            eliminate(row + k, n, before, L);
        ldl_factor(row[k].S, (int)n);
        before = n;
    }
    return TFA_OK;
}

/* Outward b_k -= G_k^T b_{k-1}; inward x_k = S_k^-1 b_k - G_{k+1} x_{k+1}. Both in x. */
static void substitute(struct ldl_row *row, const struct cfa_row *parts, uint32_t length)
{
    uint32_t before = 0;
    for (uint32_t k = 0; k < length; k++) {
        const uint32_t n = cfa_size(&parts[k].joint);
        for (uint32_t j = 0; k > 0 && j < n; j++)
            for (uint32_t e = 0; e < before; e++)
                row[k].x[j] -= row[k].G[6 * e + j] * row[k - 1].x[e];
        before = n;
    }
    for (uint32_t k = length; k-- > 0;) {
        const uint32_t n = cfa_size(&parts[k].joint);
        ldl_solve(row[k].S, (int)n, row[k].x);
        if (k + 1 == length)
            continue;
        const uint32_t next = cfa_size(&parts[k + 1].joint);
        for (uint32_t j = 0; j < n; j++)
            for (uint32_t e = 0; e < next; e++)
                row[k].x[j] -= row[k + 1].G[6 * j + e] * row[k + 1].x[e];
    }
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    struct ldl_row *row = rows;
    struct cfa_row *parts = cfa_rows_of(row, chain->length);
    cfa_right_hand_sides(s, chain, parts, tau, row->x, sizeof *row, bias);
    substitute(row, parts, chain->length);
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_add_constraint_force(&parts[k].joint, row[k].x, parts[k].f);
    cfa_accelerations(s, chain, parts, qdd, bias);
}

CHAIN_METHOD(cfa) = {.inverts = 1, .bytes = bytes, .factor = factor, .solve = solve};
