/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The operations of the threads under test.
 */
#include "explorer.h"
#include "sites.h"
#include "thread.h"

static explorer_thread *at_location(const volatile void *at)
{
    explorer_thread *t = thread_current();
    t->location = memory_location(at);
    t->site = NULL;
    return t;
}

uint64_t explorer_load(const volatile void *at, memory_order order, explorer_site *site,
                       const char *function)
{
    explorer_thread *t = at_location(at);
    t->order = site_order(site, SITE_LOAD, order, function);
    t->site = site;
    thread_stop(THREAD_LOADS);
    const int store = t->last_store;
    thread_record(thread_number(), "load", at, store, t->value);
    return t->value;
}

void explorer_store(volatile void *at, uint64_t value, memory_order order, explorer_site *site,
                    const char *function)
{
    explorer_thread *t = at_location(at);
    const int location = t->location, k = thread_number();
    t->order = site_order(site, SITE_STORE, order, function);
    t->site = site;
    if (thread_many_writers())
        thread_stop(THREAD_STORES);
    else if (memory_has_other_writer(k, location))
        thread_fail("second writer");
    const int store = memory_store(k, location, t->order, value);
    if (store < 0)
        thread_fail("too many operations");
    thread_record(k, "store", at, store, value);
}

/* Stops before a read-modify-write. @return the last value */
static uint64_t last_value(volatile void *at, memory_order order, explorer_site *site,
                           const char *function)
{
    explorer_thread *t = at_location(at);
    t->order = site_order(site, SITE_EXCHANGE, order, function);
    t->site = site;
    thread_stop(THREAD_EXCHANGES);
    return memory_value(t->location, memory_last(t->location));
}

static void exchange(volatile void *at, uint64_t value)
{
    const explorer_thread *t = thread_current();
    const int store = memory_exchange(thread_number(), t->location, t->order, value);
    if (store < 0)
        thread_fail("too many operations");
    thread_record(thread_number(), "exchange", at, store + 1, value);
}

uint64_t explorer_fetch_add(volatile void *at, uint64_t value, memory_order order,
                            explorer_site *site, const char *function)
{
    const uint64_t before = last_value(at, order, site, function);
    exchange(at, before + value);
    return before;
}

int explorer_compare_exchange(volatile void *at, uint64_t *expected, uint64_t desired,
                              memory_order order, explorer_site *site, const char *function)
{
    const uint64_t before = last_value(at, order, site, function);
    const explorer_thread *t = thread_current();
    if (before == *expected) {
        exchange(at, desired);
        return 1;
    }
    const int store = memory_last(t->location);
    *expected = memory_load(thread_number(), t->location, memory_order_relaxed, store);
    thread_record(thread_number(), "load", at, store, *expected);
    return 0;
}

uint64_t explorer_data_read(const uint64_t *at)
{
    if (!memory_data_access(thread_number(), at, false))
        thread_fail("data race");
    thread_record(thread_number(), "read", at, 0, *at);
    return *at;
}

void explorer_data_write(uint64_t *at, uint64_t value)
{
    if (!memory_data_access(thread_number(), at, true))
        thread_fail("data race");
    *at = value;
    thread_record(thread_number(), "write", at, 0, value);
}

void explorer_spin(void)
{
    explorer_thread *t = thread_current();
    t->spun_location = t->last_location;
    t->spun_store = t->last_store;
}

void explorer_futex_wait(const volatile void *word, uint32_t value)
{
    explorer_thread *t = at_location(word);
    t->order = memory_order_relaxed;
    t->value = value;
    thread_stop(THREAD_FUTEX_WAITS);
    thread_record(thread_number(), "futex wait ends", word, t->last_store, value);
}

void explorer_futex_wake(const volatile void *word)
{
    (void)at_location(word);
    thread_stop(THREAD_FUTEX_WAKES);
}

void explorer_doorbell_write(void)
{
    thread_current()->site = NULL;
    thread_stop(THREAD_DOORBELL_WRITES);
}

void explorer_doorbell_wait(void)
{
    thread_current()->site = NULL;
    thread_stop(THREAD_DOORBELL_WAITS);
}

void explorer_die(void)
{
    thread_stop(THREAD_ENDED);
}

void explorer_check(bool condition, const char *finding)
{
    if (!condition)
        thread_fail(finding);
}
