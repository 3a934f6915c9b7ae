/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Command line of `totalforce latency`.
 */
#include "options.h"

#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"

#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

enum {
    KEY_VIA = 256,
    KEY_LOOP,
    KEY_COUNT,
    KEY_SECONDS,
    KEY_WARMUP,
    KEY_RATE,
    KEY_THINK,
    KEY_JITTER,
    KEY_BURST,
    KEY_CLIENTS,
    KEY_SLOTS,
    KEY_LOAD,
    KEY_SWEEP,
    KEY_BATCH,
    KEY_METHOD,
    KEY_ESTIMATE,
    KEY_CPU,
    KEY_PRIORITY,
    KEY_MLOCK,
    KEY_URDF,
    KEY_BASELINE,
    KEY_JSON,
    KEY_CSV,
    KEY_TABLE,
    KEY_HISTOGRAM,
    KEY_HTML,
    KEY_CYCLICTEST,
    KEY_SAVE,
    KEY_COMPARE,
    KEY_DEADLINE,
    KEY_FAIL_P99,
    KEY_FAIL_RATIO
};

static const uint64_t default_count = 100000;

const char *const latency_via_names[VIA_COUNT] = {"shm", "dds", "ros2", "process", "socket"};

static const struct argp_option option_table[] = {
    {.name = "via",
     .key = KEY_VIA,
     .arg = "WAY,...",
     .doc =
         "Ways to an answer: shm, dds, both of them, ros2 (/ROBOT/joint_states and joint_efforts "
         "to /ROBOT/totalforce/accelerations), process (the library in this process, with "
         "--urdf), socket (echo of as many bytes over a Unix socket) (shm)"},
    {.name = "loop",
     .key = KEY_LOOP,
     .arg = "closed|open",
     .doc = "closed: a request leaves after the reply to the one before; open: at its time, from "
            "which it is measured (closed)"},
    {.name = "count",
     .key = KEY_COUNT,
     .arg = "N",
     .doc = "Round trips measured of each client (100000)"},
    {.name = "seconds",
     .key = KEY_SECONDS,
     .arg = "S",
     .doc = "Measure so long, in an open loop until the last request of that time has its reply; "
            "or --count, if sooner"},
    {.name = "warmup",
     .key = KEY_WARMUP,
     .arg = "N",
     .doc = "Round trips of each client before that (1000)"},
    {.name = "rate",
     .key = KEY_RATE,
     .arg = "HZ",
     .doc = "Requests a second of each client; closed: the client sleeps between them (closed: "
            "without a pause, open: 1000)"},
    {.name = "think-us",
     .key = KEY_THINK,
     .arg = "X",
     .doc = "Closed loop: pause after each reply (0)"},
    {.name = "jitter-us",
     .key = KEY_JITTER,
     .arg = "X",
     .doc = "With a rate: every time is late by 0 to X (0)"},
    {.name = "burst", .key = KEY_BURST, .arg = "N", .doc = "With a rate: N requests at a time (1)"},
    {.name = "clients",
     .key = KEY_CLIENTS,
     .arg = "N",
     .doc = "Threads with a connection each (1)"},
    {.name = "slots",
     .key = KEY_SLOTS,
     .arg = "N",
     .doc = "Requests under way of a client over shm, a power of two (16)"},
    {.name = "load",
     .key = KEY_LOAD,
     .arg = "compute=N,memory=N",
     .doc = "Threads of this program that compute, or write through 64 MiB, beside the run (none)"},
    {.name = "sweep",
     .key = KEY_SWEEP,
     .arg = "KEY=VALUE,...",
     .doc = "A run for each value of rate, batch, clients, wait or robots (other robots of the "
            "daemon)"},
    {.name = "batch", .key = KEY_BATCH, .arg = "N", .doc = "States of one request (1)"},
    {.name = "method", .key = KEY_METHOD, .arg = "METHOD", .doc = "Forward dynamics by (auto)"},
    {.name = "estimate",
     .key = KEY_ESTIMATE,
     .arg = "default|never|always",
     .doc = "Error estimates (default: the daemon's policy)"},
    {.name = "cpu", .key = KEY_CPU, .arg = "N", .doc = "Pin the clients to processor N"},
    {.name = "priority",
     .key = KEY_PRIORITY,
     .arg = "N",
     .doc = "Baseline and clients run by SCHED_FIFO with this priority, 1 to 99 (none)"},
    {.name = "mlock", .key = KEY_MLOCK, .doc = "Lock the memory of this program"},
    {.name = "urdf",
     .key = KEY_URDF,
     .arg = "FILE",
     .doc = "Also solve in process, with this robot, for the baseline"},
    {.name = "baseline-ms",
     .key = KEY_BASELINE,
     .arg = "MS",
     .doc = "Duration of the timer loop, and of the gap detector, before the runs (200; 0: none)"},
    {.name = "json", .key = KEY_JSON, .doc = "Print the report as JSON"},
    {.name = "csv", .key = KEY_CSV, .arg = "FILE", .doc = "Write every round trip"},
    {.name = "table", .key = KEY_TABLE, .arg = "FILE", .doc = "Write a line of CSV for every run"},
    {.name = "histogram",
     .key = KEY_HISTOGRAM,
     .arg = "FILE",
     .doc = "Write the percentile distribution (.hgrm), in us"},
    {.name = "html",
     .key = KEY_HTML,
     .arg = "FILE",
     .doc = "Write a self-contained page: percentiles, histogram, parts, numbers under the pointer "
            "(by `totalforce plot`)"},
    {.name = "cyclictest",
     .key = KEY_CYCLICTEST,
     .doc = "Print a line for every client as cyclictest -N does"},
    {.name = "save",
     .key = KEY_SAVE,
     .arg = "FILE",
     .doc = "Write the session, for `totalforce plot`"},
    {.name = "compare",
     .key = KEY_COMPARE,
     .arg = "FILE",
     .doc = "Print the ratios to a saved session (by `totalforce plot`); twice and without a "
            "robot: of the second to the first"},
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

static double not_negative(struct argp_state *state, const char *name, const char *text)
{
    double value = option_double(state, name, text);
    if (!(value >= 0))
        argp_error(state, "--%s: '%s' must not be below 0", name, text);
    return value;
}

static void add_via(struct argp_state *state, char *word)
{
    static const char *const words[] = {"shm", "dds", "ros2", "process", "socket", "both"};
    static const unsigned vias[] = {1u << VIA_SHM,    1u << VIA_DDS,
                                    1u << VIA_ROS2,   1u << VIA_PROCESS,
                                    1u << VIA_SOCKET, (1u << VIA_SHM) | (1u << VIA_DDS)};
    latency_options *options = state->input;
    options->vias |= vias[option_word(state, "via", word, words, 6)];
}

static void add_load(struct argp_state *state, char *word)
{
    static const char *const words[] = {"compute", "memory"};
    latency_options *options = state->input;
    char *value = strchr(word, '=');
    if (!value)
        argp_error(state, "--load: '%s' is not compute=N or memory=N", word);
    *value++ = '\0';
    const int which = option_word(state, "load", word, words, 2);
    const uint32_t threads = (uint32_t)option_unsigned(state, "load", value, 0, 256);
    *(which ? &options->memory_load : &options->compute_load) = threads;
}

static error_t parse_shape(int key, char *text, struct argp_state *state)
{
    static const char *const loops[] = {"closed", "open"};
    latency_options *options = state->input;
    switch (key) {
    case KEY_LOOP:
        options->open = option_word(state, "loop", text, loops, 2);
        return 0;
    case KEY_COUNT:
        options->count = option_unsigned(state, "count", text, 1, UINT64_C(1) << 32);
        return 0;
    case KEY_SECONDS:
        options->seconds = option_positive(state, "seconds", text, INFINITY);
        return 0;
    case KEY_WARMUP:
        options->warmup = option_unsigned(state, "warmup", text, 0, UINT64_C(1) << 32);
        return 0;
    case KEY_RATE:
        options->rate = option_positive(state, "rate", text, INFINITY);
        return 0;
    case KEY_THINK:
        options->think_us = not_negative(state, "think-us", text);
        return 0;
    case KEY_JITTER:
        options->jitter_us = not_negative(state, "jitter-us", text);
        return 0;
    case KEY_BURST:
        options->burst = (uint32_t)option_unsigned(state, "burst", text, 1, 4096);
        return 0;
    case KEY_CLIENTS:
        options->clients = (uint32_t)option_unsigned(state, "clients", text, 1, CLIENTS_MAX);
        return 0;
    case KEY_LOAD:
        for_each_word(state, text, add_load);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse_measure(int key, char *text, struct argp_state *state)
{
    latency_options *options = state->input;
    switch (key) {
    case KEY_VIA:
        options->vias = 0;
        for_each_word(state, text, add_via);
        return 0;
    case KEY_SLOTS:
        options->daemon.slots = (uint32_t)option_unsigned(state, "slots", text, 1, 4096);
        return 0;
    case KEY_SWEEP:
        options->sweep = text;
        return 0;
    case KEY_BATCH:
        options->batch = (uint32_t)option_unsigned(state, "batch", text, 1, 1 << 20);
        options->daemon.max_batch = options->batch;
        return 0;
    case KEY_METHOD:
        options->method = option_method(state, text);
        return 0;
    case KEY_ESTIMATE:
        options->estimate = (tfa_estimate)option_enum(state, "estimate", text, TFA_WORDS_ESTIMATE);
        return 0;
    case KEY_CPU:
        options->cpu = (int)option_unsigned(state, "cpu", text, 0, CPU_SETSIZE - 1);
        return 0;
    case KEY_PRIORITY:
        options->priority = (int)option_unsigned(state, "priority", text, 1, 99);
        return 0;
    case KEY_MLOCK:
        options->mlock = 1;
        return 0;
    case KEY_URDF:
        options->urdf = text;
        return 0;
    case KEY_BASELINE:
        options->baseline_ms = option_unsigned(state, "baseline-ms", text, 0, 60000);
        return 0;
    default:
        return parse_shape(key, text, state);
    }
}

static void add_compared(struct argp_state *state, latency_options *options, const char *text)
{
    if (options->compare_count == COMPARED_MAX)
        argp_error(state, "--compare: at most twice");
    options->compare[options->compare_count++] = text;
}

static error_t parse_report(int key, char *text, struct argp_state *state)
{
    latency_options *options = state->input;
    switch (key) {
    case KEY_JSON:
        options->json = 1;
        return 0;
    case KEY_CSV:
        options->csv = text;
        return 0;
    case KEY_TABLE:
        options->table = text;
        return 0;
    case KEY_HISTOGRAM:
        options->histogram = text;
        return 0;
    case KEY_HTML:
        options->html = text;
        return 0;
    case KEY_CYCLICTEST:
        options->cyclictest = 1;
        return 0;
    case KEY_SAVE:
        options->save = text;
        return 0;
    case KEY_COMPARE:
        add_compared(state, options, text);
        return 0;
    case KEY_DEADLINE:
        options->deadline_us = option_positive(state, "deadline-us", text, INFINITY);
        return 0;
    case KEY_FAIL_P99:
        options->fail_p99_us = option_positive(state, "fail-p99-us", text, INFINITY);
        return 0;
    case KEY_FAIL_RATIO:
        options->fail_ratio = option_positive(state, "fail-ratio", text, INFINITY);
        return 0;
    default:
        return parse_measure(key, text, state);
    }
}

static void finish(struct argp_state *state, latency_options *options)
{
    if (!options->daemon.robot && options->compare_count != COMPARED_MAX)
        argp_error(state, "which robot?");
    if (options->daemon.robot && options->compare_count == COMPARED_MAX)
        argp_error(state, "--compare: twice and a robot");
    if (options->open && !(options->rate > 0))
        options->rate = 1000;
    if (options->open && options->think_us > 0)
        argp_error(state, "--think-us belongs to a closed loop");
    if (!(options->rate > 0) && (options->jitter_us > 0 || options->burst > 1))
        argp_error(state, "--jitter-us and --burst need --rate");
    if (options->count == 0 && !(options->seconds > 0))
        options->count = default_count;
    if ((options->vias & (1u << VIA_PROCESS)) && !options->urdf)
        argp_error(state, "--via process needs --urdf");
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    latency_options *options = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &options->daemon;
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &options->daemon.robot, text);
        return 0;
    case ARGP_KEY_END:
        finish(state, options);
        return 0;
    default:
        return parse_report(key, text, state);
    }
}

int latency_options_parse(latency_options *options, int argc, char **argv)
{
    static const command_line_values values[] = {{"METHOD", suggest_method}, {0}};
    static const struct argp_child children[] = {{.argp = &daemon_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .args_doc = "ROBOT",
        .doc = "Measures round trips of forward dynamics to the daemon that serves ROBOT, in a "
               "closed or an open loop, and the floor under them: a ping-pong of one cache line "
               "between two processes, the latency of timers, and the solve itself.\v"
               "The parts of a round trip: client (open loop: from its time until it leaves), "
               "request (client to daemon), queue, compute, reply.\n\nCtrl-C or SIGTERM ends a "
               "measurement: the report has what was measured until then, and the exit status is "
               "1; after a lost daemon it is 2.",
        .children = children};
    *options = (latency_options){.vias = 1u << VIA_SHM,
                                 .warmup = 1000,
                                 .batch = 1,
                                 .burst = 1,
                                 .clients = 1,
                                 .cpu = -1,
                                 .baseline_ms = 200};
    return command_line_parse(&argp, values, argc, argv, options);
}
