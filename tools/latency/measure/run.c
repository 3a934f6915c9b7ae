/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One measured run: a thread for each client, all after the same start, and the counters of the
 * system before and after.
 */
#include "run.h"

#include "common/progress.h"
#include "latency/machine/background_load.h"
#include "latency/transports/open.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

/* From the last thread that is ready to the start */
static const uint64_t start_delay_ns = 2000000;
/* With --csv and without --count: round trips of each client that are written */
enum { SAMPLES_MAX = 1 << 20 };
static const uint64_t default_timeout_ns = 10000000000;

/* A signal came */
static _Atomic int interrupted;

/* One client's thread */
typedef struct client_thread {
    const latency_run *run;
    latency_client *client;
    transport *t;
    loop *l;
    load_shape shape;
    pthread_barrier_t *ready, *go;
    const uint64_t *start; /* valid after `go` */
    pthread_t thread;
    _Atomic int *ended;
} client_thread;

load_shape latency_shape(const latency_options *options, uint32_t k)
{
    load_shape shape = {.open = options->open,
                        .rate = options->rate,
                        .think_ns = (uint64_t)(1e3 * options->think_us),
                        .jitter_ns = (uint64_t)(1e3 * options->jitter_us),
                        .burst = options->burst,
                        .count = options->count,
                        .duration_ns = (uint64_t)(1e9 * options->seconds),
                        .timeout_ns = options->daemon.timeout_ns,
                        .deadline_ns = (uint64_t)(1e3 * options->deadline_us),
                        .seed = UINT64_C(1000003) * k,
                        .stop = &interrupted};
    if (shape.timeout_ns == 0)
        shape.timeout_ns = default_timeout_ns;
    if (options->open && options->clients > 1) /* spread over the period */
        shape.offset_ns = (uint64_t)(1e9 / options->rate * k / options->clients);
    return shape;
}

static void *work(void *arg)
{
    client_thread *w = arg;
    latency_client *client = w->client;
    prctl(PR_SET_TIMERSLACK, 1UL);
    load_shape warmup = w->shape;
    warmup.count = w->run->options.warmup;
    warmup.duration_ns = 0;
    if (warmup.count)
        client->status = loop_run(w->l, &warmup, clock_ns(), NULL);
    pthread_barrier_wait(w->ready);
    pthread_barrier_wait(w->go);
    if (client->status == TFA_OK && *w->start) {
        transport_sleep(TFA_WAIT_BLOCK, *w->start - start_delay_ns / 2);
        thread_usage before = environment_this_thread();
        transport_sleep(TFA_WAIT_SPIN, *w->start);
        client->status = loop_run(w->l, &w->shape, *w->start, client->figures);
        thread_usage after = environment_this_thread();
        client->usage = environment_difference(&before, &after);
    }
    client->usage.tid = gettid();
    atomic_fetch_add_explicit(w->ended, 1, memory_order_release);
    return NULL;
}

/* ---- before and after ---- */

/* Counters of the system */
typedef struct counters {
    thread_usage threads[THREADS_MAX];
    int count;
    uint64_t steal, at;
    int64_t cpu_ns;
} counters;

static void read_counters(pid_t daemon, counters *c)
{
    struct timespec cpu = {0};
    c->count = environment_threads(daemon, c->threads);
    c->steal = environment_steal_ticks();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    c->cpu_ns = (int64_t)cpu.tv_sec * 1000000000 + cpu.tv_nsec;
    c->at = clock_ns();
}

static void take_difference(latency_run *run, const counters *before, const counters *after)
{
    const double elapsed = (double)(after->at - before->at);
    const double processors = (double)sysconf(_SC_NPROCESSORS_ONLN);
    const double tick = 1e9 / (double)sysconf(_SC_CLK_TCK);
    double daemon = 0;
    run->thread_count = after->count;
    for (int i = 0; i < after->count; i++) {
        run->threads[i] = after->threads[i];
        for (int k = 0; k < before->count; k++)
            if (before->threads[k].tid == after->threads[i].tid)
                run->threads[i] = environment_difference(&before->threads[k], &after->threads[i]);
        daemon += (double)run->threads[i].cpu_ns;
    }
    run->daemon_cpu = after->count ? daemon / elapsed : -1;
    run->tool_cpu = (double)(after->cpu_ns - before->cpu_ns) / elapsed;
    run->busy.gap_share = -1;
    run->busy.steal = (double)(after->steal - before->steal) * tick / (processors * elapsed);
    run->busy.load = -1; /* of the run itself */
    run->busy.processors = machine_processors();
    machine_judge(&run->busy);
}

/* ---- threads ---- */

/* All clients of a run */
typedef struct client_threads {
    client_thread *each;
    uint32_t count, started;
    pthread_barrier_t ready, go;
    uint64_t start;
    _Atomic int ended;
} client_threads;

static void show_progress(const latency_run *run, client_threads *c)
{
    const struct timespec pause = {.tv_nsec = 100000000};
    const uint64_t each = load_count(&c->each[0].shape);
    char what[64];
    snprintf(what, sizeof what, "%s%s%s", latency_via_names[run->via], run->swept ? " " : "",
             run->swept ? run->swept : "");
    while (atomic_load_explicit(&c->ended, memory_order_acquire) < (int)c->count) {
        uint64_t done = 0;
        for (uint32_t k = 0; k < c->count; k++)
            done += atomic_load_explicit(&run->clients[k].figures->done, memory_order_relaxed);
        if (each)
            progress_show(what, done, each * c->count, "round trips");
        else
            progress_show(what, (clock_ns() - c->start) / 1000000000u,
                          (uint64_t)ceil(run->options.seconds), "seconds");
        nanosleep(&pause, NULL);
    }
    progress_show(NULL, 0, 0, "");
}

static int open_client(latency_run *run, client_thread *w, uint32_t k)
{
    const int status = transport_open(&run->options, run->via, &run->states, &w->t, &run->facts);
    if (status != TFA_OK)
        return status;
    w->run = run;
    w->client = &run->clients[k];
    w->shape = latency_shape(&run->options, k);
    w->l = loop_create(w->t, loop_window(&w->shape, run->facts.info.slots));
    return w->l ? TFA_OK : TFA_E_MEMORY;
}

/* ---- signals ---- */

static const int ending_signals[] = {SIGINT, SIGTERM};
enum { ENDING_SIGNALS = sizeof ending_signals / sizeof *ending_signals };

static void interrupt(int number)
{
    (void)number;
    atomic_store_explicit(&interrupted, 1, memory_order_relaxed);
}

/* The second signal ends the program. One that is ignored stays so. */
static void catch_signals(struct sigaction before[ENDING_SIGNALS])
{
    const struct sigaction action = {.sa_handler = interrupt, .sa_flags = (int)SA_RESETHAND};
    for (int i = 0; i < ENDING_SIGNALS; i++) {
        sigaction(ending_signals[i], NULL, &before[i]);
        if (before[i].sa_handler != SIG_IGN)
            sigaction(ending_signals[i], &action, NULL);
    }
}

static void release_signals(const struct sigaction before[ENDING_SIGNALS])
{
    for (int i = 0; i < ENDING_SIGNALS; i++)
        sigaction(ending_signals[i], &before[i], NULL);
}

/* Measures with threads that exist: they wait for the start, which is 0 if one is missing. */
static void conduct(latency_run *run, client_threads *c)
{
    static counters before, after;
    pid_t daemon = run->facts.info.daemon_pid;
    if (!daemon && (run->via == VIA_DDS || run->via == VIA_ROS2))
        daemon = run->options.known.daemon_pid; /* of an earlier run over shared memory */
    background_load *load = NULL;
    struct sigaction before_run[ENDING_SIGNALS];
    int failed = 0;
    pthread_barrier_wait(&c->ready);
    for (uint32_t k = 0; k < c->count; k++)
        failed += run->clients[k].status != TFA_OK;
    if (run->options.compute_load + run->options.memory_load)
        load = background_load_start(run->options.compute_load, run->options.memory_load);
    read_counters(daemon, &before);
    catch_signals(before_run);
    c->start = failed ? 0 : clock_ns() + start_delay_ns;
    pthread_barrier_wait(&c->go);
    if (!failed && progress_wanted())
        show_progress(run, c);
    for (uint32_t k = 0; k < c->count; k++)
        pthread_join(c->each[k].thread, NULL);
    release_signals(before_run);
    read_counters(daemon, &after);
    background_load_stop(load);
    take_difference(run, &before, &after);
}

/* One thread for each client; the clients that exist wait for all. */
static int start_threads(client_threads *c)
{
    pthread_barrier_init(&c->ready, NULL, c->count + 1);
    pthread_barrier_init(&c->go, NULL, c->count + 1);
    for (uint32_t k = 0; k < c->count; k++) {
        client_thread *w = &c->each[k];
        w->ready = &c->ready;
        w->go = &c->go;
        w->start = &c->start;
        w->ended = &c->ended;
        if (pthread_create(&w->thread, NULL, work, w) != 0) {
            perror("totalforce latency: threads");
            _exit(2); /* those that wait at the barrier cannot be ended */
        }
    }
    return TFA_OK;
}

static int collect(latency_run *run)
{
    if (atomic_load_explicit(&interrupted, memory_order_relaxed))
        run->ended_early = "interrupted";
    for (uint32_t k = 0; k < run->client_count; k++)
        tally_merge(run->total, run->clients[k].figures);
    for (uint32_t k = 0; k < run->client_count; k++) {
        if (run->clients[k].status == TFA_OK)
            continue;
        const int status = run->clients[k].status;
        run->ended_early = tfa_status_text(status);
        fprintf(stderr, "totalforce latency: robot '%s' over %s: %s: %s\n",
                run->options.daemon.robot, latency_via_names[run->via], tfa_status_text(status),
                tfa_status_cause(status));
        return status;
    }
    return TFA_OK;
}

static int make_figures(latency_run *run)
{
    const latency_options *o = &run->options;
    const load_shape shape = latency_shape(o, 0);
    const uint64_t expected = load_count(&shape);
    const uint64_t samples = !o->csv ? 0 : expected ? expected : SAMPLES_MAX;
    run->client_count = o->clients;
    run->clients = calloc(o->clients, sizeof *run->clients);
    run->total = tally_create(0);
    if (!run->clients || !run->total)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < o->clients; k++) {
        run->clients[k].figures = tally_create(samples);
        if (!run->clients[k].figures)
            return TFA_E_MEMORY;
    }
    return TFA_OK;
}

int latency_measure(latency_run *run)
{
    client_threads c = {.count = run->options.clients};
    int status = make_figures(run);
    c.each = calloc(c.count, sizeof *c.each);
    if (status != TFA_OK || !c.each)
        fprintf(stderr, "totalforce latency: %s\n", tfa_status_text(status = TFA_E_MEMORY));
    for (uint32_t k = 0; k < c.count && status == TFA_OK; k++)
        status = open_client(run, &c.each[k], k);
    if (status == TFA_OK)
        status = start_threads(&c);
    if (status == TFA_OK) {
        conduct(run, &c);
        status = collect(run);
        pthread_barrier_destroy(&c.ready);
        pthread_barrier_destroy(&c.go);
    }
    for (uint32_t k = 0; c.each && k < c.count; k++) {
        loop_free(c.each[k].l);
        if (c.each[k].t)
            c.each[k].t->ops->close(c.each[k].t);
    }
    free(c.each);
    return status;
}
