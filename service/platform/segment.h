/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory that is shared with a client: it has no name, so nothing of it outlives the processes.
 */
#ifndef TFA_SERVICE_PLATFORM_SEGMENT_H
#define TFA_SERVICE_PLATFORM_SEGMENT_H

#include <stddef.h>
#include <totalforce/status.h>

#include "config/config.h"

typedef struct tfa_segment {
    int fd;          /**< read-write; -1 once closed */
    int fd_readonly; /**< for peers that may only look; -1 if none */
    void *memory;
    size_t size;
} tfa_segment;

/** Makes a segment, zeroed, present in memory, mapped here read-write.
 *  @return TFA_OK; TFA_E_MEMORY (none left, or the limit of /dev/shm); TFA_E_SYSTEM. */
TFA_CHECKED int tfa_segment_create(config_backend backend, size_t size, tfa_segment *segment);

/** Closes the descriptors; the mapping stays. */
void tfa_segment_close(tfa_segment *segment);

/** Closes and unmaps. Allowed for {0} with fds -1 and twice. */
void tfa_segment_destroy(tfa_segment *segment);

#define TFA_SEGMENT_NONE ((tfa_segment){.fd = -1, .fd_readonly = -1})

#endif
