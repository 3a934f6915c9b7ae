/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Views, stores and races.
 */
#include "memory.h"

#include <stdlib.h>
#include <string.h>

#include "sc_order.h"

typedef struct view {
    uint16_t clock[MEMORY_THREADS];
    uint8_t floor[MEMORY_LOCATIONS];
    uint8_t sc[MEMORY_THREADS]; /* 1 + the last seq_cst operation of each thread; 0: none */
} view;

typedef struct store {
    uint64_t value;
    view released;
    sc_set readers; /* seq_cst loads that read it */
    int sc;         /* its number in S; -1: none */
} store;

typedef struct location {
    const volatile void *at;
    int stores, writers; /* count; set of threads */
    store store[MEMORY_STORES];
} location;

typedef struct cell { /* of plain memory */
    const void *at;
    int writer;
    uint16_t written, read[MEMORY_THREADS];
} cell;

static view views[MEMORY_THREADS];
static location locations[MEMORY_LOCATIONS];
static cell cells[MEMORY_CELLS];
static int location_count, cell_count;
static bool weak_sc;

void memory_reset(bool weak)
{
    weak_sc = weak;
    memset(views, 0, sizeof views);
    memset(cells, 0, sizeof cells);
    location_count = cell_count = 0;
    sc_reset();
}

int memory_location(const volatile void *at)
{
    for (int k = 0; k < location_count; k++)
        if (locations[k].at == at)
            return k;
    if (location_count == MEMORY_LOCATIONS)
        abort();
    location *l = &locations[location_count];
    l->at = at;
    l->stores = 1;
    l->writers = 0;
    l->store[0] = (store){.sc = -1};
    return location_count++;
}

const volatile void *memory_address(int location_number)
{
    return locations[location_number].at;
}

static void join(view *to, const view *from)
{
    for (int k = 0; k < MEMORY_THREADS; k++)
        if (from->clock[k] > to->clock[k])
            to->clock[k] = from->clock[k];
    for (int k = 0; k < MEMORY_LOCATIONS; k++)
        if (from->floor[k] > to->floor[k])
            to->floor[k] = from->floor[k];
    for (int k = 0; k < MEMORY_THREADS && !weak_sc; k++)
        if (from->sc[k] > to->sc[k])
            to->sc[k] = from->sc[k];
}

static bool acquires(memory_order order)
{
    return order != memory_order_relaxed && order != memory_order_release;
}

static bool releases(memory_order order)
{
    return order >= memory_order_release;
}

/* ---- S ---- */

/* The last seq_cst operation of each thread that happens before the next one of a thread with this
 * view; the earlier ones precede these. */
static sc_set sc_before(const view *v)
{
    sc_set set = 0;
    for (int k = 0; k < MEMORY_THREADS; k++)
        if (v->sc[k])
            set |= SC_BIT(v->sc[k] - 1);
    return set;
}

/* The seq_cst stores to a location that follow a store in modification order: a seq_cst load that
 * reads that store precedes them in S. */
static sc_set sc_stores_after(const location *l, int number)
{
    sc_set set = 0;
    for (int k = number + 1; k < l->stores; k++)
        if (l->store[k].sc >= 0)
            set |= SC_BIT(l->store[k].sc);
    return set;
}

/* The seq_cst store that a load reads, which precedes it in S; so do those before it. */
static sc_set sc_store_read(const location *l, int number)
{
    return l->store[number].sc < 0 ? 0 : SC_BIT(l->store[number].sc);
}

/* The seq_cst operations on a location that precede a new seq_cst store to it. */
static sc_set sc_accesses(const location *l)
{
    sc_set set = 0;
    for (int k = 0; k < l->stores; k++)
        set |= l->store[k].readers | (l->store[k].sc >= 0 ? SC_BIT(l->store[k].sc) : 0);
    return set;
}

static int sc_append(int thread, sc_set before, sc_set after)
{
    const int number = sc_add(before, after);
    if (number < 0)
        return -1;
    views[thread].sc[thread] = (uint8_t)(number + 1);
    return number;
}

/* ---- loads and stores ---- */

static view view_after_load(int thread, const store *from, memory_order order)
{
    view v = views[thread];
    if (acquires(order))
        join(&v, &from->released);
    return v;
}

int memory_readable(int thread, int location_number, memory_order order, int from,
                    uint8_t readable[MEMORY_STORES])
{
    const location *l = &locations[location_number];
    const int floor = views[thread].floor[location_number];
    int count = 0;
    for (int k = from > floor ? from : floor; k < l->stores; k++) {
        if (order == memory_order_seq_cst && k + 1 < l->stores) {
            const view v = view_after_load(thread, &l->store[k], order);
            if (!sc_possible(sc_before(&v) | sc_store_read(l, k), sc_stores_after(l, k)))
                continue;
        }
        readable[count++] = (uint8_t)k;
    }
    return count;
}

uint64_t memory_load(int thread, int location_number, memory_order order, int number)
{
    location *l = &locations[location_number];
    view *v = &views[thread];
    *v = view_after_load(thread, &l->store[number], order);
    v->clock[thread]++;
    if (v->floor[location_number] < number)
        v->floor[location_number] = (uint8_t)number;
    if (order == memory_order_seq_cst) {
        const int sc =
            sc_append(thread, sc_before(v) | sc_store_read(l, number), sc_stores_after(l, number));
        if (sc < 0)
            abort();
        l->store[number].readers |= SC_BIT(sc);
    }
    return l->store[number].value;
}

/* Appends a store; `carried`: the view that it carries besides its own. */
static int append(int thread, int location_number, memory_order order, uint64_t value,
                  const view *carried)
{
    location *l = &locations[location_number];
    view *v = &views[thread];
    const int number = l->stores;
    if (number == MEMORY_STORES)
        return -1;
    store *s = &l->store[number];
    *s = (store){.value = value, .sc = -1};
    v->floor[location_number] = (uint8_t)number;
    if (order == memory_order_seq_cst) {
        s->sc = sc_append(thread, sc_before(v) | sc_accesses(l), 0);
        if (s->sc < 0)
            return -1;
    }
    if (releases(order))
        s->released = *v;
    if (carried)
        join(&s->released, carried);
    l->writers |= 1 << thread;
    l->stores++;
    return number;
}

int memory_store(int thread, int location_number, memory_order order, uint64_t value)
{
    views[thread].clock[thread]++;
    return append(thread, location_number, order, value, NULL);
}

int memory_exchange(int thread, int location_number, memory_order order, uint64_t value)
{
    location *l = &locations[location_number];
    const int number = l->stores - 1;
    const view carried = l->store[number].released;
    views[thread] = view_after_load(thread, &l->store[number], order);
    views[thread].clock[thread]++;
    return append(thread, location_number, order, value, &carried) < 0 ? -1 : number;
}

int memory_last(int location_number)
{
    return locations[location_number].stores - 1;
}

uint64_t memory_value(int location_number, int number)
{
    return locations[location_number].store[number].value;
}

bool memory_has_other_writer(int thread, int location_number)
{
    return (locations[location_number].writers & ~(1 << thread)) != 0;
}

int memory_floor(int thread, int location_number)
{
    return views[thread].floor[location_number];
}

/* ---- plain memory ---- */

static cell *cell_at(const void *at)
{
    for (int k = 0; k < cell_count; k++)
        if (cells[k].at == at)
            return &cells[k];
    if (cell_count == MEMORY_CELLS)
        abort();
    cells[cell_count].at = at;
    return &cells[cell_count++];
}

bool memory_data_access(int thread, const void *at, bool is_write)
{
    cell *c = cell_at(at);
    view *v = &views[thread];
    if (c->written > v->clock[c->writer])
        return false;
    v->clock[thread]++;
    if (!is_write) {
        c->read[thread] = v->clock[thread];
        return true;
    }
    for (int k = 0; k < MEMORY_THREADS; k++)
        if (c->read[k] > v->clock[k])
            return false;
    c->writer = thread;
    c->written = v->clock[thread];
    return true;
}
