/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Survives a client that truncates the memory it shares with the daemon.
 *
 * Reading a page that no longer exists raises SIGBUS. The handler looks the address up in a fixed
 * table of guarded mappings, puts anonymous zeros in its place (mmap with MAP_FIXED) and marks the
 * mapping as lost; the reader continues with zeros and then looks at that mark. An address that no
 * guard covers ends the process as it would without us.
 */
#ifndef TFA_SERVICE_PLATFORM_SIGBUS_H
#define TFA_SERVICE_PLATFORM_SIGBUS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <totalforce/status.h>

#define TFA_SIGBUS_GUARDS 1024

/** Installs the handler, once in a process. @return TFA_OK; TFA_E_SYSTEM */
TFA_CHECKED int tfa_sigbus_install(void);

/** Guards a mapping; *lost becomes true when it loses its memory. @return its number, or -1: the
 *  table is full. Any thread. */
int tfa_sigbus_guard(const void *base, size_t size, _Atomic bool *lost);

/** A mapping of this mark lost its memory: after an access, by the thread of the access. */
static inline bool tfa_sigbus_is_lost(const _Atomic bool *lost)
{
    atomic_signal_fence(memory_order_seq_cst); /* no instruction: the access comes before */
    return atomic_load_explicit(lost, memory_order_relaxed); /* B4 */
}

/** Ends the guard; the mapping must still be there. */
void tfa_sigbus_release(int guard);

#endif
