/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two processes, some cache lines each way, no system call while it runs.
 */
#include "pingpong.h"

#include <errno.h>
#include <signal.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct line {
    alignas(64) uint64_t word[8];
} line;

/* The words, then what goes with them; two lines apart: the hardware fetches neighbours in
 * pairs. */
typedef struct table {
    alignas(128) _Atomic uint64_t ping; /* P1: parent stores (release), child loads (acquire) */
    line send[PINGPONG_LINES_MAX];      /* payload, published by P1 */
    alignas(128) _Atomic uint64_t pong; /* P2: child stores (release), parent loads (acquire) */
    line receive[PINGPONG_LINES_MAX];   /* payload, published by P2 */
} table;

static const uint64_t stop = UINT64_MAX, ready = UINT64_MAX;

static void write_lines(line *to, uint32_t count, uint64_t value)
{
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 8; k++)
            to[i].word[k] = value;
}

static uint64_t read_lines(const line *from, uint32_t count)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 8; k++)
            sum += from[i].word[k];
    return sum;
}

static void echo(table *t, pingpong_size size)
{
    uint64_t last = 0;
    atomic_store_explicit(&t->pong, ready, memory_order_release); /* P2 */
    for (;;) {
        uint64_t now = atomic_load_explicit(&t->ping, memory_order_acquire); /* P1 */
        if (now == last) {
            cpu_relax();
            continue;
        }
        if (now == stop)
            return;
        last = now;
        write_lines(t->receive, size.reply_lines - 1, read_lines(t->send, size.request_lines - 1));
        atomic_store_explicit(&t->pong, now, memory_order_release); /* P2 */
    }
}

/* Sleeps until the child is on its processor: it begins on this one, which it would not get from a
 * parent that spins with a real-time priority. */
static int wait_for_child(const table *t, uint64_t end)
{
    while (atomic_load_explicit(&t->pong, memory_order_acquire) != ready) { /* P2 */
        if (clock_ns() > end)
            return TFA_E_TIMEOUT;
        nanosleep(&(struct timespec){.tv_nsec = 50000}, NULL);
    }
    return TFA_OK;
}

/* Waits for the echo; looks at the clock now and then, so that a dead child ends the run. */
static int wait_for(table *t, uint64_t number, uint64_t end)
{
    for (unsigned spins = 1;; spins++) {
        if (atomic_load_explicit(&t->pong, memory_order_acquire) == number) /* P2 */
            return TFA_OK;
        if (spins % 4096 == 0 && clock_ns() > end)
            return TFA_E_TIMEOUT;
        cpu_relax();
    }
}

static int reply_side(table *t, pingpong_size size, uint64_t count, uint64_t warmup, uint64_t end,
                      tfa_histogram *h)
{
    volatile uint64_t sink; /* the payload is read, whatever the compiler thinks */
    for (uint64_t i = 1; i <= warmup + count; i++) {
        uint64_t sent = clock_ns();
        if (sent > end)
            return TFA_E_TIMEOUT;
        write_lines(t->send, size.request_lines - 1, i);
        atomic_store_explicit(&t->ping, i, memory_order_release); /* P1 */
        int status = wait_for(t, i, end);
        if (status != TFA_OK)
            return status;
        sink = read_lines(t->receive, size.reply_lines - 1);
        (void)sink;
        if (i > warmup)
            tfa_histogram_add(h, clock_ns() - sent);
    }
    return TFA_OK;
}

static uint32_t limited(uint32_t lines)
{
    return lines < 1 ? 1 : lines > PINGPONG_LINES_MAX ? PINGPONG_LINES_MAX : lines;
}

int pingpong_run(pingpong_size size, uint64_t count, uint64_t warmup, uint64_t limit,
                 const cpu_set_t *others, tfa_histogram *h)
{
    size = (pingpong_size){limited(size.request_lines), limited(size.reply_lines)};
    table *t = mmap(NULL, sizeof *t, PROT_READ | PROT_WRITE,
                    MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (t == MAP_FAILED)
        return TFA_E_SYSTEM;
    pid_t parent = getpid();
    pid_t child = fork();
    if (child == 0) {
        /* the other side is gone: do not spin for ever */
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (others)
            sched_setaffinity(0, sizeof *others, others);
        if (getppid() == parent)
            echo(t, size);
        _exit(0);
    }
    const uint64_t end = clock_ns() + limit;
    int status = child < 0 ? TFA_E_SYSTEM : wait_for_child(t, end);
    if (status == TFA_OK)
        status = reply_side(t, size, count, warmup, end, h);
    int saved = errno;
    if (child > 0) {
        atomic_store_explicit(&t->ping, stop, memory_order_release); /* P1 */
        while (waitpid(child, NULL, 0) < 0 && errno == EINTR)
            ;
    }
    munmap(t, sizeof *t);
    errno = saved;
    return status;
}
