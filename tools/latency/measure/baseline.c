/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The floor under round trips, from the same session: ping-pong, timer, gaps, and the same requests
 * solved in process.
 */
#include "baseline.h"

#include "common/progress.h"
#include "latency/transports/open.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>

/* Round trips of the ping-pong: enough for a p99.9, over in a tenth of a second. */
enum { PINGPONGS = 100000 };
/* Solves of one process settle long before this; more would only take the user's time. */
enum { SOLVES_MAX = 100000 };
static const uint64_t shortest_interval_ns = 100000, usual_interval_ns = 1000000;

void latency_baseline_init(latency_baseline *baseline)
{
    memset(baseline, 0, sizeof *baseline);
    latency_times_init(&baseline->pingpong);
    latency_times_init(&baseline->same_size);
    latency_times_init(&baseline->solve);
    latency_times_init(&baseline->timer.late);
    latency_times_init(&baseline->gaps.gaps);
}

/* Pins this thread; `others` becomes the processors it could use before, without that one. */
static int pin(size_t cpu, cpu_set_t *others)
{
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    if (sched_getaffinity(0, sizeof *others, others) != 0 ||
        sched_setaffinity(0, sizeof one, &one) != 0)
        return -1;
    CPU_CLR(cpu, others);
    return 0;
}

/* Pins the client when that was asked for. The other side of a ping-pong then runs elsewhere. */
static int pin_client(const latency_options *options, latency_baseline *baseline)
{
    if (options->cpu < 0)
        return 0;
    if (pin((size_t)options->cpu, &baseline->others) == 0) {
        baseline->pinned = CPU_COUNT(&baseline->others) > 0;
        return 0;
    }
    fprintf(stderr, "totalforce latency: --cpu %d: %s\n", options->cpu, strerror(errno));
    return -1;
}

static int run_pingpong(pingpong_size size, const latency_baseline *baseline, tfa_histogram *h)
{
    return pingpong_run(size, PINGPONGS, PINGPONGS / 10, PINGPONG_LIMIT_NS,
                        baseline->pinned ? &baseline->others : NULL, h);
}

/* The two sides did not have a processor each: says so, with the load. */
static void report_busy_processors(const latency_baseline *baseline)
{
    const tfa_histogram *seen = &baseline->pingpong.h;
    const int processors = baseline->busy.processors;
    if (processors < 2) {
        fputs("totalforce latency: no ping-pong baseline: two processors are needed, this process "
              "may use one\n",
              stderr);
        return;
    }
    fprintf(stderr,
            "totalforce latency: no ping-pong baseline: busy: %" PRIu64 " of %d round trips in "
            "%.0f s, p50 %.1f us, slowest %.0f us; %d processors, load %.1f: end other programs, "
            "or choose a free processor with --cpu\n",
            seen->count, PINGPONGS, (double)PINGPONG_LIMIT_NS / 1e9,
            (double)tfa_histogram_quantile(seen, 0.5) / 1e3, (double)seen->highest / 1e3,
            processors, baseline->busy.load);
}

static void measure_pingpong(latency_baseline *baseline)
{
    progress_show("ping-pong", 0, 0, "");
    const int status = run_pingpong((pingpong_size){1, 1}, baseline, &baseline->pingpong.h);
    const int saved = errno;
    progress_show(NULL, 0, 0, "");
    baseline->have_pingpong = status == TFA_OK;
    if (status == TFA_E_TIMEOUT)
        report_busy_processors(baseline);
    else if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: no ping-pong baseline: %s\n", strerror(saved));
}

static uint64_t timer_interval(const latency_options *options)
{
    if (!(options->rate > 0))
        return usual_interval_ns;
    const double interval = 1e9 / options->rate;
    if (interval > (double)usual_interval_ns)
        return usual_interval_ns;
    return interval < (double)shortest_interval_ns ? shortest_interval_ns : (uint64_t)interval;
}

static void measure_busy(latency_baseline *baseline, double steal_ticks)
{
    machine_busy *busy = &baseline->busy;
    busy->gap_share = -1;
    busy->steal = steal_ticks;
    if (baseline->gaps.elapsed_ns)
        busy->gap_share = (double)baseline->gaps.lost_ns / (double)baseline->gaps.elapsed_ns;
    machine_judge(busy);
}

int latency_measure_machine(const latency_options *options, latency_baseline *baseline)
{
    const uint64_t duration = 1000000 * options->baseline_ms;
    baseline->busy.load = machine_load();
    baseline->busy.processors = machine_processors();
    if (pin_client(options, baseline) != 0)
        return -1;
    measure_pingpong(baseline);
    if (duration) {
        prctl(PR_SET_TIMERSLACK, 1UL);
        progress_show("timer and gaps", 0, 0, "");
        machine_measure_timer(&baseline->timer, timer_interval(options), duration);
        machine_measure_gaps(&baseline->gaps, duration);
        progress_show(NULL, 0, 0, "");
    }
    measure_busy(baseline, -1);
    return 0;
}

void latency_measure_same_size(const latency_run *run, latency_baseline *baseline)
{
    baseline->size = latency_size(&run->options, &run->facts.info);
    if (baseline->have_pingpong)
        (void)!run_pingpong(baseline->size, baseline, &baseline->same_size.h);
}

static int solve_all(transport *t, const latency_options *options, tfa_histogram *h)
{
    const uint64_t wanted = options->count ? options->count : SOLVES_MAX;
    const uint64_t count = wanted < SOLVES_MAX ? wanted : SOLVES_MAX;
    const uint64_t warmup = options->warmup < count ? options->warmup : count;
    for (uint64_t i = 0; i < warmup + count; i++) {
        transport_answer answer;
        const uint64_t start = clock_ns();
        const int status = t->ops->call(t, i + 1, i, &answer);
        const uint64_t end = clock_ns();
        if (status != TFA_OK || answer.status != TFA_OK)
            return status != TFA_OK ? status : answer.status;
        if (i >= warmup)
            tfa_histogram_add(h, end - start);
    }
    return TFA_OK;
}

int latency_solve(const latency_run *run, tfa_histogram *h)
{
    latency_options options = run->options;
    latency_states states = run->states;
    transport *t = NULL;
    transport_facts facts = {0};
    options.known = run->facts.info;
    int status = transport_process_open(&options, &states, &t, &facts);
    if (status != TFA_OK)
        return status;
    if (facts.info.q_count != run->facts.info.q_count ||
        facts.info.v_count != run->facts.info.v_count)
        status = TFA_E_SIZE;
    else
        status = solve_all(t, &options, h);
    if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: --urdf %s: %s: %s\n", options.urdf,
                tfa_status_text(status), tfa_status_cause(status));
    else if (strcmp(facts.hash, run->facts.hash) != 0)
        fprintf(stderr,
                "totalforce latency: note: %s has another hash than the daemon's robot: same "
                "sizes, other masses, gravity or options\n",
                options.urdf);
    t->ops->close(t);
    return status;
}
