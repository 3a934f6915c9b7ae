/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce latency`: measures round trips to a running daemon, beside their lower bounds.
 */
#include "latency.h"

#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"
#include "pingpong.h"

#include <errno.h>
#include <inttypes.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

enum {
    KEY_VIA = 256,
    KEY_COUNT,
    KEY_WARMUP,
    KEY_RATE,
    KEY_BATCH,
    KEY_METHOD,
    KEY_ESTIMATE,
    KEY_CPU,
    KEY_URDF,
    KEY_JSON,
    KEY_CSV,
    KEY_HISTOGRAM,
    KEY_DEADLINE,
    KEY_FAIL_P99,
    KEY_FAIL_RATIO
};

/* Round trips of the ping-pong: enough for a p99.9, over in a tenth of a second. */
enum { PINGPONGS = 100000 };

static const struct argp_option option_table[] = {
    {.name = "via", .key = KEY_VIA, .arg = "shm|dds|both", .doc = "Transport (shm)"},
    {.name = "count", .key = KEY_COUNT, .arg = "N", .doc = "Round trips measured (100000)"},
    {.name = "warmup", .key = KEY_WARMUP, .arg = "N", .doc = "Round trips before that (1000)"},
    {.name = "rate",
     .key = KEY_RATE,
     .arg = "HZ",
     .doc = "Round trips a second; the client sleeps between them (a closed loop)"},
    {.name = "batch", .key = KEY_BATCH, .arg = "N", .doc = "States of one request (1)"},
    {.name = "method", .key = KEY_METHOD, .arg = "METHOD", .doc = "Forward dynamics by (auto)"},
    {.name = "estimate",
     .key = KEY_ESTIMATE,
     .arg = "default|never|always",
     .doc = "Error estimates (default: the daemon's policy)"},
    {.name = "cpu", .key = KEY_CPU, .arg = "N", .doc = "Pin the client to processor N"},
    {.name = "urdf",
     .key = KEY_URDF,
     .arg = "FILE",
     .doc = "Also solve in process, with this robot, for the baseline"},
    {.name = "json", .key = KEY_JSON, .doc = "Print the report as JSON"},
    {.name = "csv", .key = KEY_CSV, .arg = "FILE", .doc = "Write every round trip"},
    {.name = "histogram",
     .key = KEY_HISTOGRAM,
     .arg = "FILE",
     .doc = "Write the percentile distribution (.hgrm), in us"},
    {.name = "deadline-us", .key = KEY_DEADLINE, .arg = "X", .doc = "Count later replies as late"},
    {.name = "fail-p99-us",
     .key = KEY_FAIL_P99,
     .arg = "X",
     .doc = "Exit with 1 if p99 is above X or a reply was missed"},
    {.name = "fail-ratio",
     .key = KEY_FAIL_RATIO,
     .arg = "X",
     .doc = "Exit with 1 if p50 is above X times (ping-pong + solve) or a reply was missed"},
    {0}};

static double positive(struct argp_state *state, const char *name, const char *text)
{
    double value = option_double(state, name, text);
    if (!(value > 0))
        argp_error(state, "--%s: '%s' must be above 0", name, text);
    return value;
}

static tfa_method method_of(struct argp_state *state, const char *text)
{
    int32_t method = tfa_method_find(text);
    if (method < 0)
        argp_error(state, "--method: no '%s'", text);
    return (tfa_method)method;
}

static void set_via(struct argp_state *state, latency_options *options, const char *text)
{
    static const char *const vias[] = {"shm", "dds", "both"};
    int via = option_word(state, "via", text, vias, 3);
    options->shm = via != 1;
    options->dds = via != 0;
}

static error_t parse_measure(int key, char *text, struct argp_state *state)
{
    static const char *const policies[] = {"default", "never", "always"};
    latency_options *options = state->input;
    switch (key) {
    case KEY_VIA:
        set_via(state, options, text);
        return 0;
    case KEY_COUNT:
        options->count = option_unsigned(state, "count", text, 1, UINT64_C(1) << 32);
        return 0;
    case KEY_WARMUP:
        options->warmup = option_unsigned(state, "warmup", text, 0, UINT64_C(1) << 32);
        return 0;
    case KEY_RATE:
        options->rate = positive(state, "rate", text);
        return 0;
    case KEY_BATCH:
        options->batch = (uint32_t)option_unsigned(state, "batch", text, 1, 1 << 20);
        options->daemon.max_batch = options->batch;
        return 0;
    case KEY_METHOD:
        options->method = method_of(state, text);
        return 0;
    case KEY_ESTIMATE:
        options->estimate = (tfa_estimate)option_word(state, "estimate", text, policies, 3);
        return 0;
    case KEY_CPU:
        options->cpu = (int)option_unsigned(state, "cpu", text, 0, CPU_SETSIZE - 1);
        return 0;
    case KEY_URDF:
        options->urdf = text;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    latency_options *options = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &options->daemon;
        return 0;
    case KEY_JSON:
        options->json = 1;
        return 0;
    case KEY_CSV:
        options->csv = text;
        return 0;
    case KEY_HISTOGRAM:
        options->histogram = text;
        return 0;
    case KEY_DEADLINE:
        options->deadline_us = positive(state, "deadline-us", text);
        return 0;
    case KEY_FAIL_P99:
        options->fail_p99_us = positive(state, "fail-p99-us", text);
        return 0;
    case KEY_FAIL_RATIO:
        options->fail_ratio = positive(state, "fail-ratio", text);
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &options->daemon.robot, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which robot?");
        return 0;
    default:
        return parse_measure(key, text, state);
    }
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

static const cpu_set_t *other_processors(const latency_baseline *baseline)
{
    return baseline->pinned ? &baseline->others : NULL;
}

static int run_pingpong(pingpong_size size, const latency_baseline *baseline, tfa_histogram *h)
{
    return pingpong_run(size, PINGPONGS, PINGPONGS / 10, PINGPONG_LIMIT_NS,
                        other_processors(baseline), h);
}

/* Processors that the two sides of a ping-pong may use. */
static int processors_of(const latency_baseline *baseline)
{
    cpu_set_t ours;
    if (baseline->pinned)
        return 1 + CPU_COUNT(&baseline->others);
    return sched_getaffinity(0, sizeof ours, &ours) == 0 ? CPU_COUNT(&ours) : 1;
}

/* The two sides did not have a processor each: says so, with the load. */
static void report_busy_processors(const latency_baseline *baseline)
{
    const tfa_histogram *seen = &baseline->pingpong;
    const int processors = processors_of(baseline);
    double load = 0;
    if (processors < 2) {
        fputs("totalforce latency: no ping-pong baseline: two processors are needed, this process "
              "may use one\n",
              stderr);
        return;
    }
    (void)getloadavg(&load, 1);
    fprintf(stderr,
            "totalforce latency: no ping-pong baseline: busy: %" PRIu64 " of %d round trips in "
            "%.0f s, p50 %.1f us, slowest %.0f us; %d processors, load %.1f: end other programs, "
            "or choose a free processor with --cpu\n",
            seen->count, PINGPONGS, (double)PINGPONG_LIMIT_NS / 1e9,
            (double)tfa_histogram_quantile(seen, 0.5) / 1e3, (double)seen->highest / 1e3,
            processors, load);
}

/* Before the daemon has a client, so that its spinning worker does not take part. */
static int measure_pingpong(const latency_options *options, latency_baseline *baseline)
{
    if (pin_client(options, baseline) != 0)
        return EXIT_FAILED;
    latency_progress("ping-pong", 0, 0);
    const int status = run_pingpong((pingpong_size){1, 1}, baseline, &baseline->pingpong);
    const int saved = errno;
    latency_progress(NULL, 0, 0);
    baseline->have_pingpong = status == TFA_OK;
    if (status == TFA_E_TIMEOUT)
        report_busy_processors(baseline);
    else if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: no ping-pong baseline: %s\n", strerror(saved));
    return EXIT_GOOD;
}

static uint32_t cache_lines_of(size_t bytes)
{
    return (uint32_t)((bytes + 63) / 64);
}

/* After the runs: now the size of a request (a line, q, v, tau) and of a reply (a line, what is
 * known of each answer, qdd) is known, and the worker has no client again. */
static void measure_same_size(const latency_options *options, const tfa_client_info *info,
                              latency_baseline *baseline)
{
    const size_t base = info->base_freedoms ? 1 : 0, batch = options->batch;
    const size_t asked = info->q_count + 2 * (size_t)info->v_count + base * 19;
    const size_t reported = info->v_count + base * 6;
    baseline->size =
        (pingpong_size){cache_lines_of(64 + batch * 8 * asked),
                        cache_lines_of(64 + batch * (sizeof(tfa_answer) + 8 * reported))};
    if (baseline->have_pingpong)
        (void)!run_pingpong(baseline->size, baseline, &baseline->same_size);
}

static int report(const latency_options *options, const latency_run *runs, int count,
                  const latency_baseline *baseline)
{
    int bad = 0, met = 1;
    if (options->json)
        bad = latency_print_json(stdout, options, runs, count, baseline) != 0;
    else
        latency_print_text(stdout, options, runs, count, baseline);
    if (fflush(stdout) != 0 || bad) {
        perror("totalforce latency: standard output");
        return EXIT_FAILED;
    }
    if (options->csv && latency_write_csv(options, runs, count) != 0) {
        perror(options->csv);
        return EXIT_FAILED;
    }
    if (options->histogram && latency_write_histogram(options, runs, count) != 0) {
        perror(options->histogram);
        return EXIT_FAILED;
    }
    for (int i = 0; i < count; i++) {
        if (latency_expected(options, &runs[i], baseline))
            continue;
        met = 0;
        fprintf(stderr, "totalforce latency: %s: expectation not met\n",
                daemon_via_name(runs[i].via));
    }
    return met ? EXIT_GOOD : EXIT_UNMET;
}

static int measure(const latency_options *options, latency_run *runs, latency_baseline *baseline)
{
    int count = 0;
    if (measure_pingpong(options, baseline) != EXIT_GOOD)
        return EXIT_FAILED;
    for (int via = DAEMON_SHM; via <= DAEMON_DDS; via++) {
        if (!(via == DAEMON_SHM ? options->shm : options->dds))
            continue;
        if (latency_measure(options, (daemon_via)via, &runs[count++]) != TFA_OK)
            return EXIT_FAILED;
    }
    if (options->shm)
        measure_same_size(options, &runs[0].info, baseline);
    if (options->urdf && latency_solve(options, &runs[0], &baseline->solve) != TFA_OK)
        return EXIT_FAILED;
    return report(options, runs, count, baseline);
}

int command_latency(int argc, char **argv)
{
    static const command_line_values values[] = {{"METHOD", suggest_method}, {0}};
    static const struct argp_child children[] = {{.argp = &daemon_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .args_doc = "ROBOT",
        .doc = "Measures round trips of forward dynamics to the daemon that serves ROBOT, in a "
               "closed loop or at a fixed rate, and the floor under them: a ping-pong of one cache "
               "line between two processes, and the solve itself.\v"
               "The parts of a round trip: request (client to daemon), queue, compute, reply.",
        .children = children};
    latency_options options = {.shm = 1, .count = 100000, .warmup = 1000, .batch = 1, .cpu = -1};
    error_t error = command_line_parse(&argp, values, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce latency: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    /* histograms are too large for the stack */
    latency_run *runs = calloc(2, sizeof *runs);
    latency_baseline *baseline = calloc(1, sizeof *baseline);
    int result = EXIT_FAILED;
    if (runs && baseline) {
        latency_baseline_init(baseline);
        for (int i = 0; i < 2; i++)
            latency_run_init(&runs[i]);
        result = measure(&options, runs, baseline);
    } else {
        fprintf(stderr, "totalforce latency: %s\n", tfa_status_text(TFA_E_MEMORY));
    }
    for (int i = 0; runs && i < 2; i++)
        latency_run_free(&runs[i]);
    free(runs);
    free(baseline);
    return result;
}
