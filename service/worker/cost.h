/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost model of a worker: time of one state by kind of request, learned from the clock, and
 * admission by it.
 *
 * A kind is everything that changes the time of a state of the same robot: op, method, tips,
 * estimate, ... The table is direct-mapped: a kind that meets another one in its row starts anew,
 * and so does one whose clients ask for many kinds in turn.
 *
 * Requests are cut by `state_ns`, which follows a larger measurement at once and a smaller one by
 * half, so that a request is cut too finely rather than too coarsely after an interrupted
 * measurement. They are admitted by `least_ns`, which begins at the bound of the kind
 * (cost_bound.h), follows a smaller measurement at once and a larger one by a 64th: what an
 * interrupt or another program adds does not refuse a kind, a bound that is too low does not last.
 *
 * States that trip the sentinel, fall back or lose rank take longer than their kind, by the numbers
 * of one client, who then answers for it: tfa_cost_debt.
 *
 * A table belongs to one thread. No allocation, no system call.
 */
#ifndef TFA_SERVICE_WORKER_COST_H
#define TFA_SERVICE_WORKER_COST_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/dynamics.h>

#define TFA_COST_ROWS 256 /* a power of two */

typedef struct tfa_cost {
    uint64_t kind;       /**< 0: no request came yet */
    uint64_t refused_ns; /**< CLOCK_MONOTONIC, when it was refused first since; 0: it was not */
    uint32_t state_ns;   /**< 0: not measured */
    uint32_t least_ns;   /**< 0: neither measured nor bounded */
} tfa_cost;

typedef struct tfa_cost_table {
    tfa_cost row[TFA_COST_ROWS];
} tfa_cost_table;

/** Kind of a request; never 0. */
uint64_t tfa_cost_kind(const tfa_request *request);

/** The row of a kind; a row of another kind is cleared. */
static inline tfa_cost *tfa_cost_find(tfa_cost_table *table, uint64_t kind)
{
    /* Fibonacci hashing: Knuth, The Art of Computer Programming, volume 3, section 6.4 */
    tfa_cost *row = &table->row[kind * UINT64_C(11400714819323198485) >> 56];
    _Static_assert(TFA_COST_ROWS == 256, "the shift takes 8 bits");
    if (row->kind != kind)
        *row = (tfa_cost){.kind = kind};
    return row;
}

/** States that fit `budget_ns`, at least 1; 1 for a kind that was not measured. Full vectors of
 *  lanes where there is room for one. */
uint32_t tfa_cost_states(const tfa_cost *cost, uint64_t budget_ns);

/** Records that the states first .. first + states - 1 of a reply took `ns`. One without answers
 *  says nothing about its kind; answers that tripped the sentinel, fell back or lost rank took
 *  longer than their kind costs other clients. */
void tfa_cost_record(tfa_cost *cost, const tfa_reply *reply, uint32_t first, uint32_t states,
                     uint64_t ns);

/** Time that a client owes for such states beyond the limit. It may take a 500th of the worker's
 *  time with them, which an interrupted state now and then does not exceed. */
typedef struct tfa_cost_debt {
    uint64_t owed_ns, since_ns; /**< at CLOCK_MONOTONIC since_ns */
} tfa_cost_debt;

/** Adds them to the debt, where each took longer than `most_ns`. */
void tfa_cost_owe(tfa_cost_debt *debt, const tfa_reply *reply, uint32_t first, uint32_t states,
                  uint64_t ns, uint32_t most_ns, uint64_t now);

/** Longest time of a state of this kind by a client in debt: twelve times that of its kind.
 *  Measured are 5.8 for arm7, 11.8 for the humanoid, where 1.4 % of 13,616 kinds are above 6 (loads
 *  of 1e9 kg, bench_state_costs --loaded; Intel Xeon, 2026-11-28). */
static inline uint64_t tfa_cost_doubted(const tfa_cost *cost)
{
    return UINT64_C(12) * cost->least_ns;
}

/** It passes with time. */
bool tfa_cost_in_debt(tfa_cost_debt *debt, uint64_t now);

/** A kind that `least_ns` refuses: once a second it starts anew at its bound, so that a time in
 *  which the machine was slow passes. @return it is admitted */
bool tfa_cost_admit_again(tfa_cost *cost, uint32_t bound_ns, uint32_t most_ns, uint64_t now);

#endif
