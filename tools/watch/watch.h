/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of `totalforce list` and `totalforce top`: a daemon's statistics, differences of two
 * readings, and their forms.
 */
#ifndef TOOLS_WATCH_WATCH_H
#define TOOLS_WATCH_WATCH_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <totalforce/statistics.h>

/* ---- watch.c: readings ---- */

/** Two readings of one daemon. Zero-initialise but for the directory. */
typedef struct watch {
    const char *runtime_dir; /**< NULL: the default */
    tfa_statistics *statistics;
    tfa_snapshot *now;
    tfa_snapshot *since;       /**< robots: what was added since the reading before */
    const tfa_tally **clients; /**< the same of now->clients */
    uint32_t client_room;
    double seconds;      /**< between the readings */
    uint64_t alive_time; /**< CLOCK_MONOTONIC ns: of the first reading with this heartbeat */
} watch;

/** Opens the statistics and reads them once: nothing is added yet. @return as
 *  tfa_statistics_open; TFA_E_BUSY */
TFA_CHECKED int watch_open(watch *w, int32_t timeout_ms);
/** Reads again. @return TFA_OK; TFA_E_BUSY; TFA_E_MEMORY */
TFA_CHECKED int watch_read(watch *w);
/** The daemon has ended, or no worker has made progress for seconds. */
bool watch_is_gone(const watch *w);
/** Allowed twice. */
void watch_close(watch *w);

/* ---- watch_table.c, watch_json.c ---- */

/** Writes the readings as lines of text. */
void watch_write_table(const watch *w, FILE *out);
/** The same as JSON; NULL: no memory. */
json_t *watch_json(const watch *w);

/* ---- terminal.c ---- */

/** Takes the terminal of standard input and output over: another screen, keys one by one. @return
 *  false: it is none, or its state cannot be changed (errno) */
bool terminal_open(void);
/** Gives it back as it was. Allowed twice. */
void terminal_close(void);
/** Shows text in place of what was shown, cut to the size of the terminal. */
void terminal_show(const char *text);

typedef enum terminal_event {
    TERMINAL_TIME,
    TERMINAL_KEY,
    TERMINAL_RESIZED,
    TERMINAL_END
} terminal_event;
/** Waits at most this time. `key` gets the key of TERMINAL_KEY; TERMINAL_END: a signal, or nobody
 *  is at the terminal any more. */
terminal_event terminal_wait(int timeout_ms, char *key);

#endif
