/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Measures round trips in a closed loop, where the next request leaves when the reply is there, or
 * at a fixed rate, where the client sleeps until the next one is due.
 */
#include "common/commands.h"
#include "common/robot_names.h"
#include "latency.h"
#include "pingpong.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

/* Requests that differ: enough that no branch predictor learns one by heart, few enough that they
 * stay in the second-level cache. */
enum { SETS = 64 };
/* After so many misses in a row the daemon is taken for gone. */
enum { MISSES_IN_A_ROW = 100 };
static const uint64_t SEED = 0x9e3779b97f4a7c15u;

const char *const latency_parts[PART_COUNT] = {"round_trip", "request", "queue", "compute",
                                               "reply"};

/* splitmix64, scaled to -1 .. 1 */
static double uniform(uint64_t *seed)
{
    uint64_t z = (*seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

static double *fill(double **at, size_t count, double scale, uint64_t *seed)
{
    double *first = *at;
    for (size_t i = 0; i < count; i++)
        first[i] = scale * uniform(seed);
    *at += count;
    return first;
}

static void set_unit(double *quaternion)
{
    memset(quaternion, 0, 3 * sizeof *quaternion);
    quaternion[3] = 1.0;
}

static void fill_request(tfa_request *request, const robot_names *names, double **at,
                         uint64_t *seed)
{
    size_t batch = request->count;
    double *q = fill(at, batch * names->q_count, 3.0, seed);
    for (size_t k = 0; k < batch; k++)
        for (uint32_t j = 0; j < names->joint_count; j++)
            if (names->joints[j].q_count == 7)
                set_unit(q + k * names->q_count + names->joints[j].q_index + 3);
    request->q = q;
    request->v = fill(at, batch * names->v_count, 1.0, seed);
    request->tau = fill(at, batch * names->v_count, 10.0, seed);
    if (names->base_freedoms == 0)
        return;
    double *pose = fill(at, batch * 7, 1.0, seed);
    for (size_t k = 0; k < batch; k++)
        set_unit(pose + 7 * k + 3);
    request->base_pose = pose;
    request->base_twist = fill(at, batch * 6, 1.0, seed);
    request->base_wrench = fill(at, batch * 6, 10.0, seed);
}

static void states_free(latency_states *states)
{
    free(states->requests);
    free(states->memory);
    *states = (latency_states){0};
}

static int states_init(latency_states *states, const latency_options *options,
                       const tfa_client_info *info)
{
    robot_names names;
    int status = robot_names_from_info(&names, options->daemon.robot, info);
    if (status != TFA_OK)
        return status;
    size_t numbers = (size_t)info->q_count + 2 * (size_t)info->v_count + 19;
    uint64_t seed = SEED;
    *states = (latency_states){.sets = SETS,
                               .requests = calloc(SETS, sizeof *states->requests),
                               .memory = calloc(SETS * numbers, options->batch * sizeof(double))};
    if (!states->requests || !states->memory) {
        states_free(states);
        robot_names_free(&names);
        return TFA_E_MEMORY;
    }
    double *at = states->memory;
    for (uint32_t i = 0; i < SETS; i++) {
        states->requests[i] = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                                            .method = options->method,
                                            .estimate = options->estimate,
                                            .refine = TFA_REFINE_DEFAULT,
                                            .count = options->batch};
        fill_request(&states->requests[i], &names, &at, &seed);
    }
    robot_names_free(&names);
    return TFA_OK;
}

int latency_reply_init(tfa_reply *reply, const latency_options *options,
                       const tfa_client_info *info)
{
    size_t batch = options->batch;
    *reply = (tfa_reply){.qdd = calloc(batch * ((size_t)info->v_count + 1), sizeof(double)),
                         .answers = calloc(batch, sizeof(tfa_answer))};
    if (info->base_freedoms)
        reply->base_acceleration = calloc(batch * 6, sizeof(double));
    int whole = reply->qdd && reply->answers && (reply->base_acceleration || !info->base_freedoms);
    return whole ? TFA_OK : TFA_E_MEMORY;
}

void latency_reply_free(tfa_reply *reply)
{
    free(reply->qdd);
    free(reply->base_acceleration);
    free(reply->answers);
}

/* Everything the measured loop needs, allocated before it starts. */
typedef struct loop {
    const latency_options *options;
    daemon_link *link;
    tfa_reply reply;
    latency_run *run;
    uint64_t started, misses_in_a_row;
    uint64_t due; /* of the next request, at a fixed rate */
} loop;

/* A stamp brought between two others. The daemon may stamp a burst once, before our request left,
 * and DDS times are translated: what is out of order counts as at once, and the parts add up. */
static uint64_t between(uint64_t low, uint64_t stamp, uint64_t high)
{
    return stamp < low ? low : stamp > high ? high : stamp;
}

static void record(loop *l, uint64_t index, uint64_t sent, uint64_t back, const tfa_exchange *x)
{
    latency_run *run = l->run;
    const uint64_t received = between(sent, x->t_received, back);
    const uint64_t start = between(received, x->t_start, back);
    const uint64_t done = between(start, x->t_done, back);
    const uint64_t parts[PART_COUNT] = {back - sent, received - sent, start - received,
                                        done - start, back - done};
    for (int i = 0; i < PART_COUNT; i++)
        tfa_histogram_add(&run->parts[i], parts[i]);
    if (run->parts[0].highest_index + 1 == run->parts[0].count)
        run->highest_at = sent - l->started;
    if (run->samples) {
        latency_sample *sample = &run->samples[run->sample_count++];
        *sample = (latency_sample){.index = index, .at = sent - l->started};
        memcpy(sample->parts, parts, sizeof parts);
    }
}

/* A request without a good reply, or with a late one. */
static void count_miss(loop *l)
{
    l->misses_in_a_row++;
    if (l->misses_in_a_row > l->run->longest_run)
        l->run->longest_run = l->misses_in_a_row;
}

static int reconnect(loop *l)
{
    daemon_close(l->link);
    int status = daemon_connect(&l->options->daemon, l->run->via, &l->link);
    l->run->reconnects += status == TFA_OK;
    return status;
}

void latency_progress(const char *what, uint64_t done, uint64_t count)
{
    static const uint64_t pause = 500000000;
    static int terminal = -1, shown;
    static uint64_t last;
    if (terminal < 0)
        terminal = isatty(STDERR_FILENO);
    if (!terminal || (what == NULL && !shown))
        return;
    const uint64_t now = clock_ns();
    if (what != NULL && count > 0 && now - last < pause)
        return;
    last = now;
    shown = what != NULL;
    if (what == NULL)
        fputs("\r\033[K", stderr);
    else if (count == 0)
        fprintf(stderr, "\r\033[K%s ...", what);
    else
        fprintf(stderr, "\r\033[K%s: %" PRIu64 " of %" PRIu64 " round trips", what, done, count);
    fflush(stderr);
}

/* At a fixed rate: sleeps until the next request is due. One that is overdue leaves at once, and
 * those after it keep their times. */
static void wait_until_due(loop *l)
{
    if (!(l->options->rate > 0))
        return;
    if (!l->due)
        l->due = clock_ns();
    l->due += (uint64_t)(1e9 / l->options->rate);
    const struct timespec at = {.tv_sec = (time_t)(l->due / 1000000000u),
                                .tv_nsec = (long)(l->due % 1000000000u)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
}

/* One request there and back. @return TFA_OK to go on. */
static int exchange_one(loop *l, uint64_t index, int measured)
{
    const tfa_request *request = &l->run->states.requests[index % l->run->states.sets];
    tfa_exchange times = {0};
    wait_until_due(l);
    uint64_t sent = clock_ns();
    int status = l->link ? daemon_call(l->link, request, &l->reply, &times) : TFA_E_DISCONNECTED;
    uint64_t back = clock_ns();
    if (!measured)
        return status;
    if (status == TFA_OK) {
        record(l, index, sent, back, &times);
        int late =
            l->options->deadline_us > 0 && (double)(back - sent) > 1000.0 * l->options->deadline_us;
        l->run->late += (uint64_t)late;
        if (late)
            count_miss(l);
        else
            l->misses_in_a_row = 0;
        return TFA_OK;
    }
    l->run->misses++;
    count_miss(l);
    if (l->misses_in_a_row >= MISSES_IN_A_ROW)
        return status;
    if (daemon_lost(status) && (status = reconnect(l)) != TFA_OK)
        return status;
    return TFA_OK;
}

static int measure_loop(loop *l)
{
    int status = TFA_OK;
    for (uint64_t i = 0; i < l->options->warmup && status == TFA_OK; i++)
        status = exchange_one(l, i, 0);
    if (status != TFA_OK)
        return status;
    latency_run *run = l->run;
    static thread_usage before[THREADS_MAX];
    pid_t process = daemon_info(l->link)->daemon_pid;
    int threads = environment_threads(process, before);
    uint64_t steal = environment_steal_ticks();
    thread_usage client = environment_this_thread();
    l->started = clock_ns();
    for (uint64_t i = 0; i < l->options->count && status == TFA_OK; i++) {
        status = exchange_one(l, i, 1);
        latency_progress(daemon_via_name(run->via), i + 1, l->options->count);
    }
    run->elapsed_ns = clock_ns() - l->started;
    thread_usage now = environment_this_thread();
    run->client = environment_difference(&client, &now);
    run->steal_ticks = environment_steal_ticks() - steal;
    run->thread_count = environment_threads(process, run->threads);
    for (int i = 0; i < run->thread_count; i++)
        for (int k = 0; k < threads; k++)
            if (before[k].tid == run->threads[i].tid)
                run->threads[i] = environment_difference(&before[k], &run->threads[i]);
    run->method = l->reply.answers[0].method;
    return status;
}

static int prepare(loop *l)
{
    const tfa_client_info *info = daemon_info(l->link);
    latency_run *run = l->run;
    run->info = *info;
    /* touched now, so that no page fault falls into the measurement */
    latency_run_init(run);
    snprintf(run->hash, sizeof run->hash, "%s", info->model_hash ? info->model_hash : "");
    if (l->options->csv) {
        run->samples = malloc(l->options->count * sizeof *run->samples);
        if (!run->samples)
            return TFA_E_MEMORY;
        memset(run->samples, 1, l->options->count * sizeof *run->samples);
    }
    int status = states_init(&run->states, l->options, info);
    return status == TFA_OK ? latency_reply_init(&l->reply, l->options, info) : status;
}

int latency_measure(const latency_options *options, daemon_via via, latency_run *run)
{
    loop l = {.options = options, .run = run};
    char text[512];
    run->via = via;
    int status = daemon_connect(&options->daemon, via, &l.link);
    if (status != TFA_OK) {
        daemon_explain(&options->daemon, via, status, text, sizeof text);
        fprintf(stderr, "totalforce latency: %s\n", text);
        return status;
    }
    status = prepare(&l);
    if (status == TFA_OK)
        status = measure_loop(&l);
    latency_progress(NULL, 0, 0);
    if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: robot '%s' over %s: %s: %s\n", options->daemon.robot,
                daemon_via_name(via), tfa_status_text(status), tfa_status_cause(status));
    /* the strings go with the connection */
    run->info.joint_names = run->info.frame_names = NULL;
    run->info.joint_types = NULL;
    run->info.model_hash = NULL;
    daemon_close(l.link);
    latency_reply_free(&l.reply);
    return status;
}

void latency_run_init(latency_run *run)
{
    for (int i = 0; i < PART_COUNT; i++)
        (void)!tfa_histogram_init(&run->parts[i], LATENCY_BITS, 64, run->buckets[i]);
}

void latency_run_free(latency_run *run)
{
    states_free(&run->states);
    free(run->samples);
    run->samples = NULL;
}
