/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The log of the daemon, to standard error or the journal, written by a thread of its own.
 *
 * The caller formats into a free cell of a lock-free queue and returns; it never waits for the
 * terminal or the disk. Nothing in the path of a request logs: workers mark, control speaks.
 */
#ifndef TFA_SERVICE_PLATFORM_LOG_H
#define TFA_SERVICE_PLATFORM_LOG_H

#include <stddef.h>
#include <totalforce/status.h>

typedef enum tfa_log_level {
    TFA_LOG_ERROR = 0,
    TFA_LOG_WARNING = 1,
    TFA_LOG_INFO = 2,
    TFA_LOG_DEBUG = 3,
} tfa_log_level;

/** Starts the log thread. Before it, and after tfa_log_stop, messages are written at once. */
TFA_CHECKED int tfa_log_start(tfa_log_level level);
/** Writes the queue and ends the thread; does not wait for a terminal or pipe that is not read. */
void tfa_log_stop(void);
/** The same where other threads may log until the process exits: their lines are lost. */
void tfa_log_finish(void);

/** One line, cut at 240 bytes. A full queue drops it; how many were dropped is said later. */
void tfa_log(tfa_log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** The same for a message that a client can cause: 20 lines in 8.6 s of each format; how many more
 *  there were is said later. `format` is a string literal: its address names the kind. */
void tfa_log_client(tfa_log_level level, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/** From now on tfa_log is tfa_log_client in this thread, which does what a client can cause. */
void tfa_log_limit_thread(void);

/** From now on the errors of this thread also go to `text`, a line each, while there is room. */
void tfa_log_copy_errors(char *text, size_t size);

#endif
