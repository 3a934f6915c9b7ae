/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The handler of SIGBUS and its table.
 *
 * Atomics: B1 base store release (size and lost are written before) <-> B2 handler's load acquire.
 * The reader who faults is a thread that was given the mapping after B1. B3 *lost store relaxed <->
 * B4 load relaxed: the same thread, in its handler and after it.
 */
#include "sigbus.h"

#include <signal.h>
#include <stdint.h>
#include <sys/mman.h>

typedef struct guard {
    _Atomic uintptr_t base; /* 0: free; 1: being filled */
    _Atomic size_t size;
    _Atomic(_Atomic bool *) lost;
} guard;

static guard table[TFA_SIGBUS_GUARDS];

static guard *find(uintptr_t address)
{
    for (int i = 0; i < TFA_SIGBUS_GUARDS; i++) {
        const uintptr_t base = atomic_load_explicit(&table[i].base, memory_order_acquire); /* B2 */
        const size_t size = atomic_load_explicit(&table[i].size, memory_order_relaxed);
        if (base > 1 && address >= base && address - base < size)
            return &table[i];
    }
    return NULL;
}

/* Only mmap, which is a plain system call here, and atomics: safe in a handler. */
static void on_sigbus(int signal_number, siginfo_t *info, void *context)
{
    (void)context;
    guard *g = find((uintptr_t)info->si_addr);
    if (g) {
        void *base = (void *)atomic_load_explicit(&g->base, memory_order_relaxed);
        const size_t size = atomic_load_explicit(&g->size, memory_order_relaxed);
        void *zeros = mmap(base, size, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
        if (zeros == base) {
            atomic_store_explicit(atomic_load_explicit(&g->lost, memory_order_relaxed), true,
                                  memory_order_relaxed); /* B3 */
            return;
        }
    }
    signal(signal_number, SIG_DFL); /* returning repeats the access, which then ends us */
}

int tfa_sigbus_install(void)
{
    struct sigaction action = {.sa_sigaction = on_sigbus, .sa_flags = SA_SIGINFO};
    sigemptyset(&action.sa_mask);
    return sigaction(SIGBUS, &action, NULL) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

int tfa_sigbus_guard(const void *base, size_t size, _Atomic bool *lost)
{
    for (int i = 0; i < TFA_SIGBUS_GUARDS; i++) {
        uintptr_t expected = 0;
        if (!atomic_compare_exchange_strong_explicit(&table[i].base, &expected, 1,
                                                     memory_order_acquire, memory_order_relaxed))
            continue;
        atomic_store_explicit(&table[i].size, size, memory_order_relaxed);
        atomic_store_explicit(&table[i].lost, lost, memory_order_relaxed);
        atomic_store_explicit(&table[i].base, (uintptr_t)base, memory_order_release); /* B1 */
        return i;
    }
    return -1;
}

void tfa_sigbus_release(int number)
{
    if (number >= 0)
        atomic_store_explicit(&table[number].base, 0, memory_order_release);
}
