/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The recorder's side of a daemon's taps.
 */
#ifndef TOOLS_RECORD_TAPS_H
#define TOOLS_RECORD_TAPS_H

#include <stddef.h>
#include <stdint.h>

#include "ipc/recording.h"

/** A connection. Zero-initialise with socket -1. */
typedef struct taps {
    int socket;
    void *segment; /**< of the rings */
    size_t segment_bytes;
    uint32_t producers;
    uint64_t ring_bytes;
    tfa_tap_reader *readers; /**< by producer */
    const void *texts;       /**< the description: its head, settings and URDF */
    size_t texts_bytes;
    char reason[160]; /**< why the daemon ended the recording; "": it hung up */
} taps;

/** Asks a daemon for the taps of a robot. @return 0, or -1 and why not in `text` */
int taps_open(taps *t, const char *runtime_dir, const char *robot, unsigned mib, char *text,
              size_t size);
void taps_close(taps *t);

const tfa_recording_description *taps_description(const taps *t);
/** Settings, then URDF, each with its zeros. */
const char *taps_texts(const taps *t);

/**
 * Hands the records that are there to `take`, until it returns 0.
 * @return how many, or -1: what a tap holds is no record
 */
int64_t taps_drain(taps *t, int (*take)(void *self, const tfa_tap_record *record), void *self);

/** Waits at most timeout_ms for the daemon to hang up. @return 1: it has, see `reason` */
int taps_wait(taps *t, int timeout_ms);

/** Records that found no room. */
uint64_t taps_dropped(const taps *t);

#endif
