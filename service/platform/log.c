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
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define CELLS 256 /* a power of two */
#define TEXT 1024 /* paths of a file and its errors, with their remedy */
/* Messages of one format in a window of time; the others are counted. */
#define FORMATS 256 /* a power of two, several times the formats of the daemon */
#define BURST 20
#define WINDOW_SHIFT 33 /* 8.6 s in ns */
/* The log waits at most this time for a terminal or a pipe that is not read; later lines do not
 * wait. */
#define WRITE_WAIT_MS 100
/* At the end the queue is written for at most this time. */
#define STOP_NS 200000000u
/* Between two looks for messages that were suppressed and not reported. */
#define REPORT_S 5

typedef struct cell {
    _Atomic uint64_t sequence;
    char text[TEXT];
} cell;

/* Relaxed: a race miscounts by a message. */
typedef struct limit {
    _Atomic(const char *) format;
    _Atomic uint64_t window;
    _Atomic uint32_t count, suppressed;
} limit;

static limit limits[FORMATS];

static struct {
    cell cells[CELLS];
    _Atomic uint64_t tail, dropped;
    uint64_t head;
    sem_t wake;
    pthread_t thread;
    _Atomic bool running, stop;
    _Atomic uint32_t level;
    bool journal;
    int out;           /* standard error, or a descriptor of our own that never blocks */
    /* The stream is not read: the log thread's, before it runs that of any thread that writes. It
     * orders nothing; a stale value costs a wait or a line. */
    _Atomic bool stalled;
    uint64_t deadline; /* the log thread's: from then on lines are dropped; 0: none */
} log_state = {.level = TFA_LOG_INFO, .out = STDERR_FILENO};

static uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* A terminal says that there is room, and blocks all the same. O_NONBLOCK on standard error itself
 * would change it for every process that shares it. */
static int open_output(void)
{
    struct stat info;
    if (fstat(STDERR_FILENO, &info) != 0 || !(S_ISCHR(info.st_mode) || S_ISFIFO(info.st_mode)))
        return STDERR_FILENO;
    const int fd = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    return fd >= 0 ? fd : STDERR_FILENO;
}

static bool wait_for_room(void)
{
    struct pollfd out = {.fd = log_state.out, .events = POLLOUT};
    const bool late = log_state.deadline && clock_ns() > log_state.deadline;
    log_state.stalled =
        late || poll(&out, 1, log_state.stalled || log_state.deadline ? 0 : WRITE_WAIT_MS) <= 0;
    return !log_state.stalled;
}

/* @return false: the stream is not read, the rest is lost */
static bool write_all(const char *text, size_t length)
{
    while (length) {
        if (!wait_for_room())
            return false;
        ssize_t n = write(log_state.out, text, length);
        if (n < 0 && errno != EINTR && errno != EAGAIN)
            return true; /* there is nowhere to report it */
        if (n > 0) {
            text += n;
            length -= (size_t)n;
        }
    }
    return true;
}

/* @param prefix  without control characters */
static size_t format_line(char *text, const char *prefix, const char *format, va_list arguments)
{
    int n = snprintf(text, TEXT - 1, "%s", prefix);
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
    if (!write_all(text, (size_t)size))
        atomic_fetch_add_explicit(&log_state.dropped, n, memory_order_relaxed);
}

static void drain(void)
{
    for (;;) {
        cell *c = &log_state.cells[log_state.head % CELLS];
        uint64_t sequence = atomic_load_explicit(&c->sequence, memory_order_acquire); /* L2 */
        if (sequence != log_state.head + 1)
            break;
        if (!write_all(c->text, strlen(c->text)))
            atomic_fetch_add_explicit(&log_state.dropped, 1, memory_order_relaxed);
        atomic_store_explicit(&c->sequence, log_state.head + CELLS, memory_order_release); /* L3 */
        log_state.head++;
    }
    log_dropped();
}

/* Tells how many messages were suppressed in windows that are over. */
static void report_suppressed(bool all)
{
    const uint64_t window = clock_ns() >> WINDOW_SHIFT;
    for (int i = 0; i < FORMATS; i++) {
        char text[TEXT];
        const char *format = atomic_load_explicit(&limits[i].format, memory_order_relaxed);
        if (!format ||
            (!all && atomic_load_explicit(&limits[i].window, memory_order_relaxed) == window))
            continue;
        const uint32_t n = atomic_exchange_explicit(&limits[i].suppressed, 0, memory_order_relaxed);
        if (n == 0)
            continue;
        const int size =
            snprintf(text, sizeof text,
                     "totalforced: %u more messages like '%.120s' were suppressed\n", n, format);
        (void)write_all(text, (size_t)size);
    }
}

static void *run_log(void *unused)
{
    (void)unused;
    while (!atomic_load_explicit(&log_state.stop, memory_order_acquire)) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec += REPORT_S;
        while (sem_timedwait(&log_state.wake, &until) != 0 && errno == EINTR)
            ;
        drain();
        report_suppressed(false);
    }
    log_state.deadline = clock_ns() + STOP_NS;
    drain();
    report_suppressed(true);
    return NULL;
}

int tfa_log_start(tfa_log_level level)
{
    log_state.journal = getenv("JOURNAL_STREAM") != NULL;
    log_state.out = open_output();
    log_state.stalled = false;
    log_state.deadline = 0;
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

void tfa_log_finish(void)
{
    if (atomic_exchange_explicit(&log_state.stop, true, memory_order_acq_rel))
        return;
    sem_post(&log_state.wake);
    pthread_join(log_state.thread, NULL);
}

void tfa_log_stop(void)
{
    if (!atomic_exchange_explicit(&log_state.running, false, memory_order_acq_rel))
        return;
    tfa_log_finish();
    if (log_state.out != STDERR_FILENO)
        close(log_state.out);
    log_state.out = STDERR_FILENO;
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

/* ---- limits ---- */

static _Thread_local bool thread_is_limited;

void tfa_log_limit_thread(void)
{
    thread_is_limited = true;
}

/* The row of a format: by its address, open addressing. NULL: the table is full. */
static limit *limit_of(const char *format)
{
    const uint32_t first = (uint32_t)((uintptr_t)format * 0x9e3779b97f4a7c15u >> 32);
    for (uint32_t k = 0; k < FORMATS; k++) {
        limit *l = &limits[(first + k) % FORMATS];
        const char *holder = NULL;
        if (atomic_load_explicit(&l->format, memory_order_relaxed) == format ||
            atomic_compare_exchange_strong_explicit(&l->format, &holder, format,
                                                    memory_order_relaxed, memory_order_relaxed) ||
            holder == format)
            return l;
    }
    return NULL;
}

/* Counts a message. @return it may be logged */
static bool is_within_limit(const char *format)
{
    const uint64_t window = clock_ns() >> WINDOW_SHIFT;
    limit *l = limit_of(format);
    if (!l)
        return true;
    if (atomic_exchange_explicit(&l->window, window, memory_order_relaxed) != window)
        atomic_store_explicit(&l->count, 0, memory_order_relaxed);
    if (atomic_fetch_add_explicit(&l->count, 1, memory_order_relaxed) < BURST)
        return true;
    atomic_fetch_add_explicit(&l->suppressed, 1, memory_order_relaxed);
    return false;
}

/* The journal takes the priority from "<N>" in front of a line. */
static const char *prefix_of(tfa_log_level level)
{
    static const char *const prefixes[2][4] = {
        {"totalforced: error: ", "totalforced: warning: ", "totalforced: ", "totalforced: "},
        {"<3>", "<4>", "<6>", "<7>"}};
    return prefixes[log_state.journal][level];
}

static void enqueue(tfa_log_level level, const char *format, va_list arguments)
{
    uint64_t ticket;
    cell *c = claim_cell(&ticket);
    if (!c) {
        atomic_fetch_add_explicit(&log_state.dropped, 1, memory_order_relaxed);
        return;
    }
    (void)format_line(c->text, prefix_of(level), format, arguments);
    atomic_store_explicit(&c->sequence, ticket + 1, memory_order_release); /* L1 */
    sem_post(&log_state.wake);
}

static void write_message(tfa_log_level level, const char *format, va_list arguments)
{
    if (atomic_load_explicit(&log_state.running, memory_order_acquire)) {
        enqueue(level, format, arguments);
        return;
    }
    char text[TEXT];
    (void)write_all(text, format_line(text, prefix_of(level), format, arguments));
}

static _Thread_local char *errors;
static _Thread_local size_t errors_room;

void tfa_log_copy_errors(char *text, size_t size)
{
    errors = text;
    errors_room = size;
}

static void copy_error(const char *format, va_list arguments)
{
    char text[TEXT];
    const size_t length = format_line(text, "", format, arguments);
    if (length >= errors_room)
        return;
    memcpy(errors, text, length + 1);
    errors += length;
    errors_room -= length;
}

static bool is_wanted(tfa_log_level level)
{
    return (uint32_t)level <= atomic_load_explicit(&log_state.level, memory_order_relaxed);
}

void tfa_log(tfa_log_level level, const char *format, ...)
{
    va_list arguments;
    if (!is_wanted(level) || (thread_is_limited && !is_within_limit(format)))
        return;
    va_start(arguments, format);
    write_message(level, format, arguments);
    va_end(arguments);
    if (level != TFA_LOG_ERROR || !errors)
        return;
    va_start(arguments, format);
    copy_error(format, arguments);
    va_end(arguments);
}

void tfa_log_client(tfa_log_level level, const char *format, ...)
{
    va_list arguments;
    if (!is_wanted(level) || !is_within_limit(format))
        return;
    va_start(arguments, format);
    write_message(level, format, arguments);
    va_end(arguments);
}
