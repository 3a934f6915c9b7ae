/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Survives a client that truncates the memory it shares with the daemon.
 *
 * Reading a page that no longer exists raises SIGBUS. The handler looks the address up in a fixed
 * table of guarded mappings, puts anonymous zeros in its place (mmap with MAP_FIXED) and marks the
 * mapping as hit; the reader continues with zeros and then asks tfa_sigbus_hit. An address that
 * no guard covers ends the process as it would without us.
 */
#ifndef TFA_SERVICE_PLATFORM_SIGBUS_H
#define TFA_SERVICE_PLATFORM_SIGBUS_H

#include <stdbool.h>
#include <stddef.h>
#include <totalforce/status.h>

#define TFA_SIGBUS_GUARDS 1024

/** Installs the handler, once in a process. @return TFA_OK; TFA_E_SYSTEM */
TFA_CHECKED int tfa_sigbus_install(void);

/** Guards a mapping. @return its number, or -1: the table is full. Any thread. */
int tfa_sigbus_guard(const void *base, size_t size);

/** The mapping lost its memory. Any thread; cost: one load. False for -1. */
bool tfa_sigbus_hit(int guard);

/** Ends the guard; the mapping must still be there. */
void tfa_sigbus_release(int guard);

#endif
