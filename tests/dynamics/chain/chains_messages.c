/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages of cyclic reduction between neighbours, counted: whose numbers a row reads at each level
 * is found by spoiling them. A row reads the two rows at distance h and no other, so that chains of
 * messages grow with the logarithm of the length.
 */
#include <math.h>

#include "dynamics/chain/cyclic.h"
#include "support/fixture.h"
#include "test.h"

#define LONGEST 32

/* What a row does at a level, in the order of a solution: all rows of a step at the same time */
enum step { ELIMINATE, REDUCE, REDUCE_X, SUBSTITUTE_X, STEPS };
static const enum cyclic_kind kinds[] = {CYCLIC_GENERAL, CYCLIC_SYMMETRIC};

typedef struct test_system {
    struct cyclic_row row[LONGEST];
    size_t length;
    enum cyclic_kind kind;
} test_system;

static bool at_odd_rows(enum step step)
{
    return step == ELIMINATE || step == SUBSTITUTE_X;
}

static void run(test_system *t, enum step step, size_t k, size_t h)
{
    if (step == ELIMINATE)
        cyclic_eliminate(t->row, t->length, k, h, t->kind);
    else if (step == REDUCE)
        cyclic_reduce(t->row, t->length, k, h, t->kind);
    else if (step == REDUCE_X)
        cyclic_reduce_x(t->row, t->length, k, h, t->kind, 1);
    else
        cyclic_substitute_x(t->row, t->length, k, h, t->kind, 1);
}

/* Numbers of a row, eliminated or not: all different and its block dominant; NULL: none is one */
static void fill_row(struct cyclic_row *r, random_source *s)
{
    num *const blocks[] = {r->D.a, r->L, r->U, r->P, r->Q, r->x};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++)
        for (int e = 0; e < 36; e++)
            blocks[b][e] = num_of(s ? random_uniform(s, 0.5, 1) : (double)NAN);
    for (int e = 0; s && e < 6; e++)
        r->D.a[7 * e] = num_of(20);
}

static void fill(test_system *t, uint64_t seed)
{
    random_source s = {seed};
    memset(t->row, 0, sizeof t->row);
    for (size_t k = 0; k < t->length; k++) {
        fill_row(&t->row[k], &s);
        t->row[k].size = 5;
    }
}

/* Whether row k of level h reads a number of row j in that step */
static bool reads(const test_system *t, enum step step, size_t k, size_t h, size_t j)
{
    static test_system clean, spoilt;
    clean = spoilt = *t;
    fill_row(&spoilt.row[j], NULL);
    run(&clean, step, k, h);
    run(&spoilt, step, k, h);
    return memcmp(&clean.row[k], &spoilt.row[k], sizeof clean.row[k]) != 0;
}

/* Messages one after the other when each of so many processors has as many rows: one for each step
 * of a level in which a row reads one of another processor */
static uint32_t messages(const test_system *t, size_t processors)
{
    const size_t share = (t->length + processors - 1) / processors;
    uint32_t count = 0;
    for (size_t h = 1; h < t->length; h *= 2)
        for (enum step step = ELIMINATE; step < STEPS; step++) {
            bool sent = false;
            for (size_t k = at_odd_rows(step) ? h : 0; k < t->length; k += 2 * h)
                for (size_t j = 0; j < t->length; j++)
                    sent |= j / share != k / share && reads(t, step, k, h, j);
            count += sent;
        }
    return count;
}

/* Symmetric: the coupling to the row before is the row's own. */
static void every_other_row(const test_system *t, size_t k, size_t h)
{
    for (enum step step = ELIMINATE; step < STEPS; step++) {
        if (at_odd_rows(step) != (k / h % 2 == 1))
            continue;
        const bool own = step == ELIMINATE && t->kind == CYCLIC_SYMMETRIC;
        for (size_t j = 0; j < t->length; j++)
            if (j != k)
                assert_int_equal(reads(t, step, k, h, j), j == k + h || (!own && j + h == k));
    }
}

TEST(rows_read_their_two_neighbours)
{
    static test_system t;
    for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++)
        for (t.length = 2; t.length <= 21; t.length++) {
            t.kind = kinds[n];
            fill(&t, t.length);
            for (size_t h = 1; h < t.length; h *= 2)
                for (size_t k = 0; k < t.length; k += h)
                    every_other_row(&t, k, h);
        }
}

/* The last row to be eliminated of a symmetric system has all it needs. */
TEST(chains_of_messages_are_logarithmic)
{
    static test_system t;
    for (uint32_t levels = 1; levels <= 5; levels++)
        for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++) {
            t.length = (size_t)1 << levels;
            t.kind = kinds[n];
            fill(&t, levels);
            for (size_t processors = 2; processors <= t.length; processors *= 2)
                assert_int_equal(messages(&t, processors),
                                 4 * levels - (t.kind == CYCLIC_SYMMETRIC));
        }
}
