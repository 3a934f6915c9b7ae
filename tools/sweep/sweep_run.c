/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Threads take blocks until none is left. A thread has a block to itself - states, dynamics,
 * statistics - so that nothing but the list of blocks is shared.
 */
#include "common/commands.h"
#include "sweep_resume.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

typedef struct job {
    const sweep_plan *plan;
    sweep_ranks *ranks;
    sweep_results *results;
    sweep_worker *workers;
    uint32_t threads, running;
    FILE *resume;
    /* below: under the lock */
    pthread_mutex_t lock;
    pthread_cond_t ended;
    uint64_t next, taken; /* block; blocks of this rank that were taken or skipped */
    int failed;
} job;

static volatile sig_atomic_t interrupted;

/* The second signal ends the program. */
static void interrupt(int number)
{
    interrupted = 1;
    signal(number, SIG_DFL);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Blocks go to the parts in turn, and those of a part that are not done to its ranks in turn. */
static int is_mine(job *j, uint64_t block)
{
    const sweep_options *o = j->plan->options;
    if (sweep_is_done(j->results->done, block) ||
        (o->parts && block % o->parts != (uint64_t)(o->part - 1)))
        return 0;
    return (int)(j->taken++ % (uint64_t)j->ranks->size) == j->ranks->rank;
}

/* @return whether there is one */
static int take_block(job *j, uint64_t *block)
{
    int found = 0;
    pthread_mutex_lock(&j->lock);
    while (!found && !interrupted && !j->failed && j->next < j->plan->blocks) {
        *block = j->next++;
        found = is_mine(j, *block);
    }
    pthread_mutex_unlock(&j->lock);
    return found;
}

/* Its answers are written already: a block in the resume file is complete. */
static void finish_block(job *j, const sweep_worker *w, uint64_t block)
{
    pthread_mutex_lock(&j->lock);
    const int error = j->resume ? sweep_resume_add(j->resume, block, &w->statistics) : 0;
    if (error) {
        fprintf(stderr, "totalforce sweep: --resume %s: %s\n", j->plan->options->resume,
                strerror(error));
        j->failed = 1;
    } else {
        statistics_merge(&j->results->statistics, &w->statistics);
        sweep_set_done(j->results->done, block);
        j->results->finished++;
        j->results->states += sweep_block_count(j->plan, block);
    }
    pthread_mutex_unlock(&j->lock);
}

static void fail(job *j, const sweep_worker *w, uint64_t block)
{
    pthread_mutex_lock(&j->lock);
    if (!j->failed)
        fprintf(stderr, "totalforce sweep: block %" PRIu64 ": %s\n", block, w->error);
    j->failed = 1;
    pthread_mutex_unlock(&j->lock);
}

typedef struct thread {
    job *job;
    sweep_worker *worker;
    pthread_t id;
} thread;

static void *work(void *argument)
{
    const thread *t = argument;
    uint64_t block;
    tfa_stack_prepare();
    while (take_block(t->job, &block)) {
        if (sweep_worker_block(t->worker, block) == 0)
            finish_block(t->job, t->worker, block);
        else
            fail(t->job, t->worker, block);
    }
    pthread_mutex_lock(&t->job->lock);
    t->job->running--;
    pthread_cond_signal(&t->job->ended);
    pthread_mutex_unlock(&t->job->lock);
    return NULL;
}

/* Rank 0 speaks; the others go as fast. */
static void print_progress(const job *j, double elapsed, int last)
{
    const sweep_results *r = j->results;
    const uint64_t done = r->found + r->finished * (uint64_t)j->ranks->size;
    const uint64_t all =
        j->plan->options->parts ? j->plan->blocks / j->plan->options->parts + 1 : j->plan->blocks;
    if (j->ranks->rank != 0 || j->plan->options->quiet)
        return;
    fprintf(stderr, "%s%5.1f %%, %.3g states/s%s", last < 0 ? "" : "\r",
            100.0 * (double)(done < all ? done : all) / (double)all,
            (double)r->states * j->ranks->size / elapsed, last ? "\n" : "");
}

/* Waits for the threads; says each second how far they are on a terminal, each ten seconds
 * elsewhere. */
static void watch(job *j)
{
    const double start = now();
    const int terminal = isatty(STDERR_FILENO);
    double told = start;
    pthread_mutex_lock(&j->lock);
    while (j->running) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec++;
        const int error = pthread_cond_timedwait(&j->ended, &j->lock, &until);
        if (error == ETIMEDOUT && now() - told >= (terminal ? 0.9 : 9.9)) {
            told = now();
            print_progress(j, told - start, terminal ? 0 : -1);
        }
    }
    pthread_mutex_unlock(&j->lock);
    if (terminal && told > start)
        print_progress(j, now() - start, 1);
    j->results->elapsed = now() - start;
}

static int run_threads(job *j)
{
    thread *threads = calloc(j->threads, sizeof *threads);
    uint32_t started = 0;
    for (; threads && started < j->threads; started++) {
        threads[started] = (thread){.job = j, .worker = &j->workers[started]};
        pthread_mutex_lock(&j->lock);
        j->running++;
        pthread_mutex_unlock(&j->lock);
        if (pthread_create(&threads[started].id, NULL, work, &threads[started]) != 0)
            break;
    }
    if (threads && started < j->threads) {
        pthread_mutex_lock(&j->lock);
        j->running--;
        pthread_mutex_unlock(&j->lock);
    }
    if (started == 0)
        fprintf(stderr, "totalforce sweep: no thread could be started: %s\n", strerror(errno));
    else
        watch(j);
    for (uint32_t k = 0; k < started; k++)
        pthread_join(threads[k].id, NULL);
    free(threads);
    return started ? EXIT_GOOD : EXIT_FAILED;
}

static int open_workers(job *j)
{
    const char *file = j->plan->options->file;
    int status = TFA_OK;
    j->workers = calloc(j->threads, sizeof *j->workers);
    if (!j->workers)
        status = TFA_E_MEMORY;
    for (uint32_t k = 0; status == TFA_OK && k < j->threads; k++)
        status = sweep_worker_open(&j->workers[k], j->plan, j->ranks);
    if (status == TFA_OK)
        status = sweep_worker_try(&j->workers[0]);
    if (status == TFA_OK)
        return EXIT_GOOD;
    const tfa_field field = j->workers ? j->workers[0].reply.field : TFA_FIELD_NONE;
    fprintf(stderr, "totalforce sweep: %s: %s%s%s: %s\n", file, tfa_field_name(field),
            field ? ": " : "", tfa_status_text(status), tfa_status_cause(status));
    return EXIT_FAILED;
}

static int open_file(const job *j, int file, const char *path, uint64_t width)
{
    const int error =
        path ? j->ranks->open_file(file, path, j->plan->count * width * sizeof(double)) : 0;
    if (error && j->ranks->rank == 0)
        fprintf(stderr, "totalforce sweep: %s: %s\n", path, strerror(error));
    return j->ranks->agree(error == 0) ? EXIT_GOOD : EXIT_FAILED;
}

/* All ranks together, whatever one of them meets */
static int open_all(job *j)
{
    const sweep_options *o = j->plan->options;
    const unsigned parts = o->parts ? o->part - 1 : 0;
    int result = open_workers(j);
    if (result == EXIT_GOOD && o->resume) {
        j->resume =
            sweep_resume_open(j->plan, parts * (unsigned)j->ranks->size + (unsigned)j->ranks->rank);
        result = j->resume ? EXIT_GOOD : EXIT_FAILED;
    }
    if (!j->ranks->agree(result == EXIT_GOOD))
        return EXIT_FAILED;
    result = open_file(j, SWEEP_FILE_ANSWERS, o->out, j->plan->answer);
    return result == EXIT_GOOD
               ? open_file(j, SWEEP_FILE_STATES, o->out_states, j->plan->record.width)
               : result;
}

static int close_all(job *j)
{
    const sweep_options *o = j->plan->options;
    const char *const paths[SWEEP_FILES] = {o->out, o->out_states};
    int result = EXIT_GOOD;
    for (uint32_t k = 0; j->workers && k < j->threads; k++) {
        for (int part = 0; part < SWEEP_TIMES; part++)
            j->results->seconds[part] += j->workers[k].seconds[part];
        sweep_worker_close(&j->workers[k]);
    }
    free(j->workers);
    for (int file = 0; file < SWEEP_FILES; file++) {
        const int error = j->ranks->close_file(file);
        if (error)
            fprintf(stderr, "totalforce sweep: %s: %s\n", paths[file], strerror(error));
        result = error ? EXIT_FAILED : result;
    }
    if (j->resume && fclose(j->resume) != 0) {
        fprintf(stderr, "totalforce sweep: --resume %s: %s\n", o->resume, strerror(errno));
        result = EXIT_FAILED;
    }
    return result;
}

static int compute(const sweep_plan *plan, sweep_ranks *ranks, sweep_results *results)
{
    job j = {.plan = plan,
             .ranks = ranks,
             .results = results,
             .threads = results->threads,
             .lock = PTHREAD_MUTEX_INITIALIZER,
             .ended = PTHREAD_COND_INITIALIZER};
    int result = open_all(&j);
    if (result == EXIT_GOOD) {
        signal(SIGINT, interrupt);
        signal(SIGTERM, interrupt);
        result = run_threads(&j);
    }
    if (close_all(&j) != EXIT_GOOD || j.failed)
        result = EXIT_FAILED;
    return result;
}

/* Rank 0 knows the finished blocks; their statistics stay with it. */
static int take_finished(const sweep_plan *plan, sweep_ranks *ranks, sweep_results *results)
{
    const size_t bytes = (size_t)(plan->blocks + 7) / 8;
    results->done = calloc(bytes, 1);
    int result = results->done ? EXIT_GOOD : EXIT_FAILED;
    if (result != EXIT_GOOD)
        fprintf(stderr, "totalforce sweep: %s\n", tfa_status_text(TFA_E_MEMORY));
    if (result == EXIT_GOOD && plan->options->resume && ranks->rank == 0)
        result = sweep_resume_read(plan, results);
    if (!ranks->agree(result == EXIT_GOOD))
        return EXIT_FAILED;
    ranks->broadcast(results->done, bytes);
    ranks->broadcast(&results->found, sizeof results->found);
    return EXIT_GOOD;
}

static void merge(const sweep_plan *plan, sweep_ranks *ranks, sweep_results *r)
{
    double numbers[SWEEP_TIMES + 4] = {(double)r->finished, (double)r->states, (double)r->threads,
                                       interrupted};
    memcpy(numbers + 4, r->seconds, sizeof r->seconds);
    ranks->merge_statistics(&r->statistics);
    ranks->merge_bits(r->done, (size_t)(plan->blocks + 7) / 8);
    ranks->merge_doubles(numbers, SWEEP_TIMES + 4);
    r->finished = (uint64_t)numbers[0];
    r->states = (uint64_t)numbers[1];
    r->threads = (uint32_t)numbers[2];
    r->interrupted = numbers[3] > 0;
    memcpy(r->seconds, numbers + 4, sizeof r->seconds);
}

/* Processors that this process may use: mpirun and srun give each rank its own. */
static uint32_t own_processors(void)
{
    cpu_set_t set;
    const int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return count < SWEEP_THREADS_MAX ? (uint32_t)count : SWEEP_THREADS_MAX;
}

int sweep_run(const sweep_plan *plan, sweep_ranks *ranks, sweep_results *results)
{
    const uint32_t asked = plan->options->threads;
    *results = (sweep_results){.threads = asked ? asked : own_processors()};
    int result = take_finished(plan, ranks, results);
    if (result != EXIT_GOOD)
        return result;
    if (!plan->options->merge)
        result = compute(plan, ranks, results);
    result = ranks->agree(result == EXIT_GOOD) ? EXIT_GOOD : EXIT_FAILED;
    merge(plan, ranks, results);
    return result;
}

void sweep_results_free(sweep_results *results)
{
    free(results->done);
}
