/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory that is shared with a client: it has no name, so nothing of it outlives the processes.
 *
 * A process of the daemon's own user can reopen a descriptor for writing through /proc, whatever
 * its access mode. Seals stop that: a memfd segment cannot be resized, and peers cannot write the
 * part that they only read. POSIX shared memory takes no seals: there a peer of the same user can
 * spoil its own segments (sigbus.h), never those of another client.
 */
#ifndef TFA_SERVICE_PLATFORM_SEGMENT_H
#define TFA_SERVICE_PLATFORM_SEGMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <totalforce/status.h>

#include "config/config.h"

typedef enum tfa_segment_access {
    TFA_SEGMENT_PEER_READS,
    TFA_SEGMENT_PEER_WRITES,
} tfa_segment_access;

typedef struct tfa_segment {
    int fd;          /**< read-write; -1 once closed */
    int fd_readonly; /**< for peers that may only look; -1 if none */
    void *memory;
    size_t size;
} tfa_segment;

/** Makes a segment, zeroed, present in memory, mapped here read-write.
 *  @return TFA_OK; TFA_E_MEMORY (none left, or the limit of /dev/shm); TFA_E_SYSTEM. */
TFA_CHECKED int tfa_segment_create(config_backend backend, tfa_segment_access access, size_t size,
                                   tfa_segment *segment);

/** Makes a segment of constants: a memfd that no process can write or resize, mapped here
 *  read-only.
 *  @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM. */
TFA_CHECKED int tfa_segment_create_constant(const void *bytes, size_t size, tfa_segment *segment);

/** A peer changed the size of the file, or made it take more memory. A system call. */
bool tfa_segment_was_resized(const tfa_segment *segment);

/** Closes the descriptors; the mapping stays. */
void tfa_segment_close(tfa_segment *segment);

/** Closes and unmaps. Allowed for {0} with fds -1 and twice. */
void tfa_segment_destroy(tfa_segment *segment);

#define TFA_SEGMENT_NONE ((tfa_segment){.fd = -1, .fd_readonly = -1})

#endif
