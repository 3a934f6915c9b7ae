/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost model of a worker: time of one state by kind of request, learned from the clock.
 *
 * A kind is everything that changes the time of a state of the same robot: op, method, tips,
 * estimate, ... The table is direct-mapped: a kind that meets another one in its row starts anew,
 * and so does one whose clients ask for many kinds in turn. Whoever must not wait for such a one
 * goes by its bound.
 * A row follows a larger measurement at once and a smaller one by half, so that a request is cut
 * too finely rather than too coarsely after an interrupted measurement.
 *
 * A table belongs to one thread. No allocation, no system call.
 */
#ifndef TFA_SERVICE_WORKER_COST_H
#define TFA_SERVICE_WORKER_COST_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/dynamics.h>

#include "ipc/wire_blocks.h"

#define TFA_COST_ROWS 64 /* a power of two */

typedef struct tfa_cost {
    uint64_t kind;     /**< 0: no request came yet */
    uint32_t state_ns; /**< 0: not measured */
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
    tfa_cost *row = &table->row[kind * UINT64_C(11400714819323198485) >> 58];
    _Static_assert(TFA_COST_ROWS == 64, "the shift takes 6 bits");
    if (row->kind != kind)
        *row = (tfa_cost){.kind = kind};
    return row;
}

/** States that fit `budget_ns`, at least 1; 1 for a kind that was not measured. Full vectors of
 *  lanes where there is room for one. */
uint32_t tfa_cost_states(const tfa_cost *cost, uint64_t budget_ns);

/** Bound on ns for one state, for a kind that was not measured: from the request alone. */
uint64_t tfa_cost_bound(const tfa_wire_shape *shape, const tfa_request *request);

/** Records that `states` states took `ns`. */
void tfa_cost_record(tfa_cost *cost, uint32_t states, uint64_t ns);

#endif
