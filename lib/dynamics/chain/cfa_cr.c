/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constraint force algorithm by block cyclic reduction: the rows of cfa_row.h, each assembled
 * for itself, then cyclic.h with LDL^T blocks.
 */
#include "dynamics/chain/cfa_row.h"
#include "dynamics/chain/chain.h"
#include "dynamics/chain/cyclic.h"

/* Factors kept: the block rows of the system, and behind them the terms of their entries */
static inline struct cfa_row *cfa_rows_of(struct cyclic_row *row, size_t length)
{
    return (struct cfa_row *)(void *)(row + length);
}

static size_t bytes(size_t length)
{
    return length * (sizeof(struct cyclic_row) + sizeof(struct cfa_row));
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    struct cyclic_row *row = rows;
    struct cfa_row *parts = cfa_rows_of(row, chain->length);
    for (uint32_t k = 0; k < chain->length; k++)
        if (!cfa_start(s, chain, parts, k))
            return TFA_E_SINGULAR;
    for (uint32_t k = 0; k < chain->length; k++) {
        row[k].size = cfa_size(&parts[k].joint);
        cfa_assemble(s, chain, parts, k, row[k].D.a, row[k].L);
    }
    cyclic_factor(row, chain->length, CYCLIC_SYMMETRIC);
    return TFA_OK;
}

static void solve(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                  num *qdd, int bias)
{
    struct cyclic_row *row = rows;
    struct cfa_row *parts = cfa_rows_of(row, chain->length);
    cfa_right_hand_sides(s, chain, parts, tau, row->x, sizeof *row, bias);
    cyclic_solve(row, chain->length, CYCLIC_SYMMETRIC, 1);
    for (uint32_t k = 0; k < chain->length; k++)
        cfa_add_constraint_force(&parts[k].joint, row[k].x, parts[k].f);
    cfa_accelerations(s, chain, parts, qdd, bias);
}

CHAIN_METHOD(cfa_cr) = {.inverts = 1, .bytes = bytes, .factor = factor, .solve = solve};
