/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost model of a worker.
 */
#include "worker/cost.h"

/* Lanes of the widest batch kernel: f32 with AVX-512. */
#define LANES 16

/* Batches fill lanes, single states do not. */
static uint32_t count_class(uint32_t count)
{
    return count >= LANES ? 2 : count > 1;
}

static void append(uint64_t *kind, int bits, uint64_t value)
{
    *kind = *kind << bits | (value & ((UINT64_C(1) << bits) - 1));
}

uint64_t tfa_cost_kind(const tfa_request *r)
{
    uint64_t kind = 1;
    _Static_assert(TFA_OP_LAST < 16 && TFA_MAX_TIPS < 64 && TFA_WANT_ALL < 1 << 16 &&
                       TFA_MAX_REFINE < 7,
                   "each has bits of its own");
    append(&kind, 4, r->op);
    append(&kind, 5, r->method);
    append(&kind, 6, r->tip_count);
    append(&kind, 16, r->flags & TFA_WANT_ALL);
    append(&kind, 3, r->refine <= TFA_MAX_REFINE ? r->refine : 7);
    append(&kind, 3, r->estimate);
    append(&kind, 1, r->wrench_count != 0);
    append(&kind, 1, r->payload_count != 0);
    append(&kind, 1, r->locked_count != 0);
    append(&kind, 1, r->rows != TFA_ROWS_POSE);
    append(&kind, 2, count_class(r->count));
    return kind;
}

uint32_t tfa_cost_states(const tfa_cost *cost, uint64_t budget_ns)
{
    if (cost->state_ns == 0)
        return 1;
    const uint64_t states = budget_ns / cost->state_ns;
    if (states < LANES)
        return states ? (uint32_t)states : 1;
    return states < UINT32_MAX ? (uint32_t)states / LANES * LANES : UINT32_MAX;
}

/* lambda_inv is decomposed: several sweeps over a matrix of all rows. */
static bool decomposes(const tfa_request *r)
{
    const uint32_t flags = TFA_WANT_SPECTRUM | TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P;
    return r->op == TFA_OP_TASK_TORQUES || (r->flags & flags) != 0;
}

/* A matrix of all freedoms is computed, or may be. */
static bool is_quadratic(const tfa_request *r)
{
    return r->op == TFA_OP_MASS_MATRIX || r->op == TFA_OP_BIAS ||
           TFA_OP_BIT(r->op) & (TFA_OPS_DERIVATIVES | TFA_OPS_ID_DERIVATIVES) ||
           r->method != TFA_METHOD_AUTO;
}

/* Powers by the algorithms, factors by docs/tuning.md, which says for which kinds it is too low. */
uint64_t tfa_cost_bound(const tfa_wire_shape *shape, const tfa_request *r)
{
    const uint64_t n = tfa_wire_freedoms(shape) + shape->modes;
    const uint64_t m = (uint64_t)r->tip_count * tfa_tip_rows(r->rows);
    uint64_t ns = 1000 + 500 * ((uint64_t)shape->frames + shape->modes) + 10 * n * m + 8 * m * m;
    if (is_quadratic(r))
        ns += (20 + n) * n * n;
    if (decomposes(r))
        ns += 15 * m * m * m;
    return ns;
}

void tfa_cost_record(tfa_cost *cost, uint32_t states, uint64_t ns)
{
    const uint64_t each = (states > 1 ? ns / states : ns) + 1;
    const uint32_t measured = each < UINT32_MAX ? (uint32_t)each : UINT32_MAX;
    if (measured > cost->state_ns)
        cost->state_ns = measured;
    else
        cost->state_ns -= (cost->state_ns - measured) / 2;
}
