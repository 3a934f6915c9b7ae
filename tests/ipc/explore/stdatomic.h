/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Stands before the compiler's <stdatomic.h> in the include path of the explorer: ring.h, tap.h and
 * robot_taps.h compile unchanged, and their atomic operations go to the explorer with their call
 * site.
 */
#ifndef TFA_EXPLORER_STDATOMIC_H
#define TFA_EXPLORER_STDATOMIC_H

#include <stdint.h>

#define ATOMIC_LLONG_LOCK_FREE __GCC_ATOMIC_LLONG_LOCK_FREE

/** In ascending strength; consume and acq_rel are not supported by ring.h and the explorer */
typedef enum memory_order {
    memory_order_relaxed,
    memory_order_acquire,
    memory_order_release,
    memory_order_acq_rel,
    memory_order_seq_cst
} memory_order;

/** Where an atomic operation stands in the source; one for each call site, listed at the first use
 *  (sites.h). */
typedef struct explorer_site {
    const char *file;
    int line, kind;
    const char *function;
    memory_order declared, order; /**< of the source; in force (a mutation weakens it) */
    struct explorer_site *next;
    int id; /**< 0: not listed yet */
} explorer_site;

enum { SITE_LOAD, SITE_STORE, SITE_EXCHANGE };

uint64_t explorer_load(const volatile void *at, memory_order order, explorer_site *site,
                       const char *function);
void explorer_store(volatile void *at, uint64_t value, memory_order order, explorer_site *site,
                    const char *function);
uint64_t explorer_fetch_add(volatile void *at, uint64_t value, memory_order order,
                            explorer_site *site, const char *function);
int explorer_compare_exchange(volatile void *at, uint64_t *expected, uint64_t desired,
                              memory_order order, explorer_site *site, const char *function);

#define EXPLORER_SITE_                                                                             \
    __extension__({                                                                                \
        static explorer_site site_ = {.file = __FILE__, .line = __LINE__};                         \
        &site_;                                                                                    \
    })
#define atomic_load_explicit(at, order)                                                            \
    ((__typeof__((void)0, *(at)))explorer_load((at), (order), EXPLORER_SITE_, __func__))
#define atomic_store_explicit(at, value, order)                                                    \
    explorer_store((at), (uint64_t)(value), (order), EXPLORER_SITE_, __func__)
#define atomic_fetch_add_explicit(at, value, order)                                                \
    explorer_fetch_add((at), (uint64_t)(value), (order), EXPLORER_SITE_, __func__)
#define atomic_compare_exchange_strong_explicit(at, expected, desired, order, failure)             \
    explorer_compare_exchange((at), (expected), (desired), (order), EXPLORER_SITE_, __func__)

#endif
