/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Comparison of answers, number by number.
 */
#include "compare.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

typedef struct comparison {
    compared result;
    double tolerance;
} comparison;

/* A whole number that must agree. */
static void compare_whole(comparison *c, const char *field, uint32_t state, int64_t recorded,
                          int64_t other)
{
    if (recorded == other)
        return;
    if (c->result.differences++ == 0)
        c->result.first = (difference){.field = field,
                                       .state = state,
                                       .recorded = (double)recorded,
                                       .other = (double)other,
                                       .relative = INFINITY};
}

static double relative(double a, double b, double scale)
{
    if (a == b || (isnan(a) && isnan(b)))
        return 0;
    return isfinite(a) && isfinite(b) && scale > 0 ? fabs(a - b) / scale : INFINITY;
}

/* A number, in relation to `scale`. */
static void compare_number(comparison *c, const char *field, uint32_t state, uint32_t index,
                           const double *recorded, const double *other, double scale)
{
    difference d = {.field = field, .state = state, .index = index};
    memcpy(&d.bits[0], recorded, 8);
    memcpy(&d.bits[1], other, 8);
    if (d.bits[0] == d.bits[1])
        return;
    d.recorded = *recorded;
    d.other = *other;
    d.relative = relative(*recorded, *other, scale);
    if (!c->result.largest.field || d.relative > c->result.largest.relative)
        c->result.largest = d;
    if (c->tolerance > 0 && d.relative <= c->tolerance)
        return;
    if (c->result.differences++ == 0)
        c->result.first = d;
}

/* The numbers of a state. */
static void compare_array(comparison *c, const char *field, uint32_t state, uint32_t count,
                          const double *recorded, const double *other)
{
    double scale = 0;
    if (memcmp(recorded, other, count * sizeof *recorded) == 0)
        return;
    for (uint32_t i = 0; i < count; i++)
        scale = fmax(scale, isfinite(recorded[i]) ? fabs(recorded[i]) : 0);
    for (uint32_t i = 0; i < count; i++)
        compare_number(c, field, state, i, &recorded[i], &other[i], scale);
}

/* An estimate is made of rounding errors: with a tolerance it may be another one. */
static void compare_estimate(comparison *c, const char *field, uint32_t state,
                             const double *recorded, const double *other)
{
    if (!(c->tolerance > 0))
        compare_number(c, field, state, 0, recorded, other, fabs(*recorded));
}

static void compare_answer(comparison *c, uint32_t state, const tfa_answer *a, const tfa_answer *b)
{
    const uint16_t rounding = TFA_ANSWER_ESTIMATED | TFA_ANSWER_SENTINEL | TFA_ANSWER_STALLED;
    const uint16_t flags = (uint16_t)(c->tolerance > 0 ? ~rounding : ~0);
    compare_whole(c, "answers.status", state, a->status, b->status);
    compare_whole(c, "answers.method", state, a->method, b->method);
    compare_whole(c, "answers.flags", state, a->flags & flags, b->flags & flags);
    compare_estimate(c, "answers.error_estimate", state, &a->error_estimate, &b->error_estimate);
}

static void compare_spectrum(comparison *c, uint32_t state, const tfa_spectrum *a,
                             const tfa_spectrum *b)
{
    compare_whole(c, "spectrum.rank", state, a->rank, b->rank);
    compare_number(c, "spectrum.eig_min", state, 0, &a->eig_min, &b->eig_min, fabs(a->eig_max));
    compare_number(c, "spectrum.eig_max", state, 0, &a->eig_max, &b->eig_max, fabs(a->eig_max));
}

static void compare_rank(comparison *c, uint32_t state, const tfa_rank *a, const tfa_rank *b)
{
    compare_whole(c, "rank.rank", state, a->rank, b->rank);
    compare_whole(c, "rank.lost", state, a->lost, b->lost);
    compare_number(c, "rank.threshold", state, 0, &a->threshold, &b->threshold, fabs(a->threshold));
    /* an error of the smallest eigenvalue, relative to the largest, counts as often */
    compare_number(c, "rank.condition", state, 0, &a->condition, &b->condition,
                   a->condition * a->condition);
    compare_number(c, "rank.length", state, 0, &a->length, &b->length, fabs(a->length));
    compare_estimate(c, "rank.error_estimate", state, &a->error_estimate, &b->error_estimate);
}

/* ---- blocks ---- */

static const char *name_of(uint32_t block)
{
    static const char *const names[] = {
#define NAME(block, field, ...) #field,
        TFA_OUTPUT_LIST(NAME)
#undef NAME
    };
    return names[block];
}

static void compare_state(comparison *c, uint32_t block, uint32_t state, size_t bytes,
                          const unsigned char *a, const unsigned char *b)
{
    const void *x = a + state * bytes, *y = b + state * bytes;
    if (block == TFA_WIRE_ANSWERS)
        compare_answer(c, state, x, y);
    else if (block == TFA_WIRE_SPECTRUM)
        compare_spectrum(c, state, x, y);
    else if (block == TFA_WIRE_RANK)
        compare_rank(c, state, x, y);
    else
        compare_array(c, name_of(block), state, (uint32_t)(bytes / 8), x, y);
}

/* A state that failed has no numbers, but a verdict. Without verdicts those before the first that
 * failed have numbers. */
static int has_numbers(const tfa_wire_reply *line, const tfa_answer *answers, uint32_t state)
{
    if (line->status == TFA_OK || line->status == TFA_E_RANK)
        return 1;
    return answers ? answers[state].status == TFA_OK : state < line->state;
}

static void compare_blocks(comparison *c, const tfa_wire_shape *shape,
                           const tfa_wire_reply_shape *reply_shape, const unsigned char *a,
                           const unsigned char *b)
{
    const tfa_wire_reply *line = (const void *)a;
    const tfa_answer *answers =
        reply_shape->want & TFA_WIRE_BIT(ANSWERS) ? (const void *)(a + TFA_WIRE_LINE) : NULL;
    /* a client that asks for a spectrum without the matrix has none */
    const uint64_t none = reply_shape->want & TFA_WIRE_BIT(LAMBDA_INV) ? 0 : TFA_WIRE_BIT(SPECTRUM);
    size_t at = TFA_WIRE_LINE;
    for (uint64_t bits = reply_shape->want; bits && reply_shape->count; bits &= bits - 1) {
        const uint32_t block = (uint32_t)__builtin_ctzll(bits);
        const size_t width = tfa_wire_reply_width(shape, block, reply_shape);
        for (uint32_t k = 0; k < reply_shape->count && !(none >> block & 1); k++)
            if (block == TFA_WIRE_ANSWERS || has_numbers(line, answers, k))
                compare_state(c, block, k, width / reply_shape->count, a + at, b + at);
        at += (width + 7) & ~(size_t)7;
    }
}

compared compare_replies(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                         const void *recorded, const void *other, double tolerance, int any_model)
{
    const tfa_wire_reply *a = recorded, *b = other;
    comparison c = {.tolerance = tolerance};
    compare_whole(&c, "status", 0, a->status, b->status);
    compare_whole(&c, "field", 0, a->field, b->field);
    compare_whole(&c, "index", 0, a->index, b->index);
    compare_whole(&c, "state", 0, a->state, b->state);
    if (!any_model)
        compare_whole(&c, "model", 0, (int64_t)a->model, (int64_t)b->model);
    if (c.result.differences)
        return c.result;
    compare_blocks(&c, shape, reply_shape, recorded, other);
    return c.result;
}
