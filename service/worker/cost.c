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

static uint32_t kind_of(const tfa_request *r)
{
    uint32_t kind = 1u << 31; /* never 0 */
    kind |= ((uint32_t)r->op & 7) | ((uint32_t)r->method & 31) << 3;
    kind |= (r->tip_count & 15) << 8 | (r->flags & 15) << 12;
    kind |= (r->refine & 3) << 16 | ((uint32_t)r->estimate & 7) << 18;
    kind |= (uint32_t)(r->wrench_count != 0) << 21 | (uint32_t)(r->payload_count != 0) << 22;
    kind |= (uint32_t)(r->locked_count != 0) << 23;
    return kind | count_class(r->count) << 24;
}

tfa_cost *tfa_cost_find(tfa_cost_table *table, const tfa_request *request)
{
    const uint32_t kind = kind_of(request);
    /* Fibonacci hashing: Knuth, The Art of Computer Programming, volume 3, section 6.4 */
    tfa_cost *row = &table->row[kind * 2654435769u >> 26];
    _Static_assert(TFA_COST_ROWS == 64, "the shift takes 6 bits");
    if (row->kind != kind)
        *row = (tfa_cost){.kind = kind};
    return row;
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

void tfa_cost_record(tfa_cost *cost, uint32_t states, uint64_t ns)
{
    const uint64_t each = ns / (states ? states : 1) + 1;
    const uint32_t measured = each < UINT32_MAX ? (uint32_t)each : UINT32_MAX;
    if (measured > cost->state_ns)
        cost->state_ns = measured;
    else
        cost->state_ns -= (cost->state_ns - measured) / 2;
}
