/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The log: a bounded queue of many producers and one consumer, after Dmitry Vyukov's idea.
 *
 * Atomics: a cell's turn says whose it is. L1 turn store release (producer: text is complete) <->
 * L2 load acquire (log thread). L3 turn store release (log thread: text was read) <-> L4 load
 * acquire (producer of the next lap). `tail` only hands out cells: relaxed.
 */
#include "log.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CELLS 256 /* a power of two */
#define TEXT 256

typedef struct cell {
    _Atomic uint64_t sequence;
    char text[TEXT];
} cell;

static struct {
    cell cells[CELLS];
    _Atomic uint64_t tail, dropped;
    uint64_t head;
    sem_t wake;
    pthread_t thread;
    _Atomic bool running, stop;
    _Atomic uint32_t level;
    bool journal;
} log_state = {.level = TFA_LOG_INFO};

static void write_all(const char *text, size_t length)
{
    while (length) {
        ssize_t n = write(STDERR_FILENO, text, length);
        if (n < 0 && errno != EINTR)
            return; /* there is nowhere to report it */
        if (n > 0) {
            text += n;
            length -= (size_t)n;
        }
    }
}

/* The journal takes the priority from "<N>" in front of a line. */
static size_t format_line(char *text, tfa_log_level level, const char *format, va_list arguments)
{
    static const char *const prefixes[2][4] = {
        {"totalforced: error: ", "totalforced: warning: ", "totalforced: ", "totalforced: "},
        {"<3>", "<4>", "<6>", "<7>"}};
    int n = snprintf(text, TEXT - 1, "%s", prefixes[log_state.journal][level]);
    n += vsnprintf(text + n, (size_t)(TEXT - 1 - n), format, arguments);
    if (n > TEXT - 2)
        n = TEXT - 2;
    for (int i = 0; i < n; i++)
        if ((unsigned char)text[i] < ' ')
            text[i] = '?'; /* names may come from clients */
    text[n] = '\n';
    text[n + 1] = 0;
    return (size_t)n + 1;
}

static void log_dropped(void)
{
    char text[64];
    uint64_t n = atomic_exchange_explicit(&log_state.dropped, 0, memory_order_relaxed);
    if (n == 0)
        return;
    int size = snprintf(text, sizeof text, "totalforced: %llu log lines were dropped\n",
                        (unsigned long long)n);
    write_all(text, (size_t)size);
}

static void drain(void)
{
    for (;;) {
        cell *c = &log_state.cells[log_state.head % CELLS];
        uint64_t sequence = atomic_load_explicit(&c->sequence, memory_order_acquire); /* L2 */
        if (sequence != log_state.head + 1)
            break;
        write_all(c->text, strlen(c->text));
        atomic_store_explicit(&c->sequence, log_state.head + CELLS, memory_order_release); /* L3 */
        log_state.head++;
    }
    log_dropped();
}

static void *run_log(void *unused)
{
    (void)unused;
    while (!atomic_load_explicit(&log_state.stop, memory_order_acquire)) {
        while (sem_wait(&log_state.wake) != 0 && errno == EINTR)
            ;
        drain();
    }
    drain();
    return NULL;
}

int tfa_log_start(tfa_log_level level)
{
    log_state.journal = getenv("JOURNAL_STREAM") != NULL;
    atomic_store_explicit(&log_state.level, (uint32_t)level, memory_order_relaxed);
    for (uint64_t i = 0; i < CELLS; i++)
        atomic_store_explicit(&log_state.cells[i].sequence, i, memory_order_relaxed);
    log_state.head = 0;
    atomic_store_explicit(&log_state.tail, 0, memory_order_relaxed);
    atomic_store_explicit(&log_state.stop, false, memory_order_relaxed);
    if (sem_init(&log_state.wake, 0, 0) != 0)
        return TFA_E_SYSTEM;
    if (pthread_create(&log_state.thread, NULL, run_log, NULL) != 0) {
        sem_destroy(&log_state.wake);
        return TFA_E_SYSTEM;
    }
    pthread_setname_np(log_state.thread, "log");
    atomic_store_explicit(&log_state.running, true, memory_order_release);
    return TFA_OK;
}

void tfa_log_stop(void)
{
    if (!atomic_exchange_explicit(&log_state.running, false, memory_order_acq_rel))
        return;
    atomic_store_explicit(&log_state.stop, true, memory_order_release);
    sem_post(&log_state.wake);
    pthread_join(log_state.thread, NULL);
    sem_destroy(&log_state.wake);
}

/* Takes a cell of the queue. @return NULL: it is full */
static cell *claim_cell(uint64_t *ticket)
{
    uint64_t at = atomic_load_explicit(&log_state.tail, memory_order_relaxed);
    for (;;) {
        cell *c = &log_state.cells[at % CELLS];
        const uint64_t sequence = atomic_load_explicit(&c->sequence, memory_order_acquire); /* L4 */
        if (sequence < at)
            return NULL;
        if (sequence > at) {
            at = atomic_load_explicit(&log_state.tail, memory_order_relaxed);
            continue;
        }
        if (atomic_compare_exchange_weak_explicit(&log_state.tail, &at, at + 1,
                                                  memory_order_relaxed, memory_order_relaxed)) {
            *ticket = at;
            return c;
        }
    }
}

void tfa_log(tfa_log_level level, const char *format, ...)
{
    va_list arguments;
    if ((uint32_t)level > atomic_load_explicit(&log_state.level, memory_order_relaxed))
        return;
    va_start(arguments, format);
    if (!atomic_load_explicit(&log_state.running, memory_order_acquire)) {
        char text[TEXT];
        write_all(text, format_line(text, level, format, arguments));
    } else {
        uint64_t ticket;
        cell *c = claim_cell(&ticket);
        if (c) {
            (void)format_line(c->text, level, format, arguments);
            atomic_store_explicit(&c->sequence, ticket + 1, memory_order_release); /* L1 */
            sem_post(&log_state.wake);
        } else {
            atomic_fetch_add_explicit(&log_state.dropped, 1, memory_order_relaxed);
        }
    }
    va_end(arguments);
}
