/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the sides of a tap share: the segment, and ipc/tap.h with its copies led through the
 * explorer, word by word.
 */
#ifndef TFA_EXPLORER_TAP_PARTS_H
#define TFA_EXPLORER_TAP_PARTS_H

#include "explorer.h"
#include "ipc/wire.h"
#include "tap_sides.h"

void tap_copy(void *to, const void *from, uint64_t bytes);

#define __builtin_memcpy tap_copy
#include "ipc/tap.h"
#include "worker/robot_taps.h"
#undef __builtin_memcpy

/** A producer, and what became of its records; the recorder's end of its ring */
typedef struct tap_producer {
    tfa_tap tap;
    tfa_tap_reader reader;
    uint64_t memory; /**< plain memory of `tap` for the explorer: which tap it is, 0: it is freed */
    uint32_t kept, missed, taken;
    uint64_t last; /**< number of the record that was taken last */
    _Atomic uint64_t hung_up;
} tap_producer;

extern tap_producer tap_producers[2];

static inline bool tap_has_error(tap_error error)
{
    return tap_error_made == error;
}

/** Makes the private end of a producer, on ring `ring` of the segment. */
void tap_open(tap_producer *p, uint32_t ring);

/** Records the next request of `tap`, or drops it; they are numbered from 1. */
void tap_put(tap_producer *p, tfa_tap *tap);

static inline uint32_t tap_records(void)
{
    uint32_t n = 0;
    while (n < TAP_RECORDS_MAX && tap_under_test.bytes[n])
        n++;
    return n;
}

#endif
