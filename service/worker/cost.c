/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost model of a worker.
 */
#include "worker/cost.h"

#include "config/config.h"
#include "ipc/wire_blocks.h"

/* Lanes of the widest batch kernel: f32 with AVX-512. */
#define LANES 16

/* Batches fill lanes, single states do not. */
static uint32_t count_class(uint32_t count)
{
    return count >= LANES ? 2 : count > 1;
}

/* Multiplication and shift: the finaliser of SplitMix64 (Steele, Lea, Flood 2014). Kinds differ
 * unless 64 bits of two are the same. */
static uint64_t mix(uint64_t hash, uint64_t value)
{
    hash = (hash ^ value) * UINT64_C(0xbf58476d1ce4e5b9);
    return hash ^ hash >> 29;
}

/* A count above the most is refused by the solver. */
static uint64_t mix_indices(uint64_t hash, const uint32_t *indices, uint32_t count, uint32_t most)
{
    for (uint32_t k = 0; indices && k < count && k < most; k++)
        hash = mix(hash, indices[k] + UINT64_C(1));
    return hash;
}

/* Deep tips and loads on deep links take longer than those near the root. */
uint64_t tfa_cost_kind(const tfa_request *r)
{
    uint64_t kind = 1;
    kind = mix(kind, (uint64_t)r->op << 32 | (uint32_t)r->method);
    kind = mix(kind, (uint64_t)r->flags << 32 | r->refine);
    kind = mix(kind, (uint64_t)r->estimate << 32 | (uint32_t)r->rows);
    kind = mix(kind, (uint64_t)r->tip_count << 32 | r->wrench_count);
    kind = mix(kind, (uint64_t)r->payload_count << 32 | r->locked_count);
    kind = mix(kind, count_class(r->count));
    if (tfa_constraint_numbers(r))
        kind = mix(kind, r->constraints);
    kind = mix_indices(kind, r->tips, r->tip_count, TFA_MAX_TIPS);
    kind = mix_indices(kind, r->payload_frames, r->payload_count, TFA_MAX_PAYLOADS);
    kind = mix_indices(kind, r->locked, r->locked_count, UINT32_MAX);
    return kind ? kind : 1;
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

/* A measurement counts for so much of the way up. */
#define RISE 64
#define REFUSED_NS 1000000000u

/* No more than the largest limit, or a processor that was away for long would refuse a kind. */
static void record_least(tfa_cost *cost, uint32_t measured)
{
    const uint32_t most = CONFIG_STATE_US_MOST * 1000u;
    if (measured > most && most > cost->least_ns)
        measured = most;
    if (measured <= cost->least_ns || cost->least_ns == 0)
        cost->least_ns = measured;
    else
        cost->least_ns += (measured - cost->least_ns) / RISE;
}

bool tfa_cost_admit_again(tfa_cost *cost, uint32_t bound_ns, uint32_t most_ns, uint64_t now)
{
    if (bound_ns > most_ns)
        return false;
    if (!cost->refused_ns)
        cost->refused_ns = now;
    if (now - cost->refused_ns < REFUSED_NS)
        return false;
    cost->refused_ns = 0;
    cost->least_ns = bound_ns;
    return true;
}

/* Of answers that took no longer than their kind. */
static bool is_plain(const tfa_answer *answers, uint32_t first, uint32_t count)
{
    uint32_t flags = 0;
    for (uint32_t k = 0; answers && k < count; k++)
        flags |= answers[first + k].flags;
    return !(flags & (TFA_ANSWER_FALLBACK | TFA_ANSWER_INACCURATE | TFA_ANSWER_STALLED |
                      TFA_ANSWER_NOT_FINITE | TFA_ANSWER_SENTINEL | TFA_ANSWER_RANK_LOSS));
}

void tfa_cost_record(tfa_cost *cost, const tfa_reply *reply, uint32_t first, uint32_t states,
                     uint64_t ns)
{
    if (!tfa_wire_has_answers(reply->status))
        return;
    const uint64_t each = (states > 1 ? ns / states : ns) + 1;
    const uint32_t measured = each < UINT32_MAX ? (uint32_t)each : UINT32_MAX;
    if (measured > cost->state_ns)
        cost->state_ns = measured;
    else
        cost->state_ns -= (cost->state_ns - measured) / 2;
    if (is_plain(reply->answers, first, states))
        record_least(cost, measured);
}

/* ---- states that take longer than their kind ---- */

#define SHARE 500                   /* of the time in which it passes */
#define CREDIT_NS UINT64_C(4000000) /* a few of 500 us to 2.5 ms */
#define DEBT_MOST_NS (3 * CREDIT_NS)

static uint64_t owed_at(const tfa_cost_debt *debt, uint64_t now)
{
    const uint64_t passed = (now - debt->since_ns) / SHARE;
    return debt->owed_ns > passed ? debt->owed_ns - passed : 0;
}

void tfa_cost_owe(tfa_cost_debt *debt, const tfa_reply *reply, uint32_t first, uint32_t states,
                  uint64_t ns, uint32_t most_ns, uint64_t now)
{
    if (!most_ns || ns / states <= most_ns || !tfa_wire_has_answers(reply->status) ||
        is_plain(reply->answers, first, states))
        return;
    const uint64_t owed = owed_at(debt, now) + ns;
    debt->owed_ns = owed < DEBT_MOST_NS ? owed : DEBT_MOST_NS;
    debt->since_ns = now;
}

bool tfa_cost_in_debt(tfa_cost_debt *debt, uint64_t now)
{
    const uint64_t owed = owed_at(debt, now);
    if (!owed)
        debt->owed_ns = 0;
    return owed > CREDIT_NS;
}
