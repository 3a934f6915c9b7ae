/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The loop around JSON lines: read, answer, print, whatever the line holds.
 */
#ifndef TOOLS_JSONL_JSONL_SERVE_H
#define TOOLS_JSONL_JSONL_SERVE_H

#include "jsonl.h"

#include <stdint.h>
#include <stdio.h>

/** The longest line that is read; a longer one is refused and skipped without keeping it. It holds
 *  a q, v, tau request of a 100 000-joint chain twice over. */
#define JSONL_LINE_MAX ((size_t)16 << 20)

/** The solver: the library in process, or a daemon */
typedef struct jsonl_backend {
    void *self;
    /** Called before every request. Gives the names of the robot as they are now (they change when
     *  a daemon comes back with another model). A bad status becomes the reply to that line. */
    int (*prepare)(void *self, const tfa_names **names, jsonl_error *error);
    /** Answers; returns reply->status. */
    int (*answer)(void *self, const tfa_request *request, tfa_reply *reply);
} jsonl_backend;

/** Counts of the loop */
typedef struct jsonl_tally {
    uint64_t lines, errors;
} jsonl_tally;

/**
 * Answers every line of `input` on `out`, one reply a line, flushed one by one, until the input
 * ends. Memory is bounded by JSONL_LINE_MAX.
 * @param input  file descriptor
 * @return TFA_OK at the end of the input; TFA_E_SYSTEM when reading or writing fails (errno says
 *         how: EPIPE when the reader of the replies has gone); TFA_E_MEMORY.
 */
TFA_CHECKED int jsonl_serve(int input, FILE *out, const jsonl_backend *backend,
                            const jsonl_defaults *defaults, jsonl_tally *tally);

#endif
