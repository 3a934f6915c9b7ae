/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce record`: requests and answers of one robot of a running daemon, to a file.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/environment.h"
#include "common/operator.h"
#include "record/recorded_robot.h"
#include "record/recording.h"
#include "record/taps.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define DEFAULT_MIB 32
#define PAUSE_MS 1             /* between two looks at empty taps */
#define PROGRESS_NS 500000000u /* between two lines of progress */

enum { KEY_COUNT = 256, KEY_SECONDS, KEY_BUFFER };

typedef struct arguments {
    const char *robot, *file, *runtime_dir;
    uint64_t count; /* 0: no limit */
    double seconds; /* 0: no limit */
    unsigned mib;
} arguments;

static const struct argp_option option_table[] = {
    {.name = "output", .key = 'o', .arg = "FILE", .doc = "The recording; one of before is lost"},
    {.name = "count", .key = KEY_COUNT, .arg = "N", .doc = "Ends after N requests"},
    {.name = "seconds", .key = KEY_SECONDS, .arg = "S", .doc = "Ends after S seconds"},
    {.name = "buffer",
     .key = KEY_BUFFER,
     .arg = "MIB",
     .doc = "MiB of memory for each worker and gateway until the file takes its records: a power "
            "of two, at most 256 (32)"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case 'o':
        a->file = text;
        return 0;
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->runtime_dir;
        return 0;
    case KEY_COUNT:
        a->count = option_unsigned(state, "count", text, 1, UINT64_MAX);
        return 0;
    case KEY_SECONDS:
        a->seconds = option_positive(state, "seconds", text, 1e9);
        return 0;
    case KEY_BUFFER:
        a->mib = (unsigned)option_unsigned(state, "buffer", text, 1, TFA_TAP_RING_MAX >> 20);
        if (a->mib & (a->mib - 1))
            argp_error(state, "--buffer: %s is not a power of two", text);
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &a->robot, text);
        return 0;
    case ARGP_KEY_END:
        if (!a->robot)
            argp_error(state, "which robot?");
        if (!a->file)
            argp_error(state, "to which file? (-o FILE)");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* ---- the run ---- */

static volatile sig_atomic_t interrupted;

static void interrupt(int signal)
{
    (void)signal;
    interrupted = 1;
}

typedef struct run {
    const arguments *a;
    taps taps;
    recording_writer file;
    uint64_t start, shown; /* CLOCK_MONOTONIC ns; start 0: the file could not be made */
    int hung_up;
    int broken; /* a tap holds no records */
} run;

static int write_record(void *self, const tfa_tap_record *record)
{
    run *r = self;
    recording_add(&r->file, record);
    return !r->file.error && (!r->a->count || r->file.records < r->a->count);
}

static void show_progress(run *r, uint64_t now)
{
    if (!isatty(STDERR_FILENO) || now - r->shown < PROGRESS_NS)
        return;
    r->shown = now;
    fprintf(stderr, "\r\033[K%" PRIu64 " requests, %.1f MB, %.0f s, dropped %" PRIu64 " ",
            r->file.records, (double)(r->file.file_bytes + r->file.used) * 1e-6,
            (double)(now - r->start) * 1e-9, taps_dropped(&r->taps));
    fflush(stderr);
}

static int is_full(const run *r)
{
    return r->a->count && r->file.records >= r->a->count;
}

/* Takes records until its end is requested, or the daemon hangs up. What is in the taps then is
 * taken, too. */
static void record(run *r)
{
    r->start = clock_ns();
    for (int last = 0; !is_full(r) && !r->file.error && !r->broken;) {
        const int64_t taken = taps_drain(&r->taps, write_record, r);
        const uint64_t now = clock_ns();
        r->broken = taken < 0;
        show_progress(r, now);
        if (last)
            break;
        r->hung_up = taps_wait(&r->taps, taken > 0 ? 0 : PAUSE_MS);
        last = r->hung_up || interrupted ||
               (r->a->seconds > 0 && (double)(now - r->start) * 1e-9 >= r->a->seconds);
    }
    if (r->shown)
        fputs("\r\033[K", stderr);
}

/* The daemon's file may have changed since it was loaded. @return an exit status */
static int check_model(const run *r)
{
    char text[200];
    recorded_robot robot;
    const tfa_recording_description *d = taps_description(&r->taps);
    const char *texts = taps_texts(&r->taps),
               *urdf = texts + tfa_recording_padded(d->settings_bytes);
    if (recorded_robot_read(texts, (size_t)d->settings_bytes, &robot, text, sizeof text) != 0) {
        fprintf(stderr, "totalforce record: the daemon's description: %s\n", text);
        return EXIT_FAILED;
    }
    int result = EXIT_GOOD;
    tfa_model *model = recorded_robot_compile(&robot, robot.urdf_name, urdf, (size_t)d->urdf_bytes);
    if (!model || strcmp(tfa_model_hash_text(model), robot.model_hash) != 0) {
        fprintf(stderr,
                "totalforce record: '%s' is not what the daemon compiled robot '%s' of (model "
                "%.16s, now %.16s), or this program is not of its version (%s): let it read the "
                "file (totalforce reload)\n",
                robot.urdf_name, robot.robot, robot.model_hash,
                model ? tfa_model_hash_text(model) : "none", robot.version);
        result = EXIT_FAILED;
    }
    tfa_model_free(model);
    recorded_robot_free(&robot);
    return result;
}

/* @return an exit status */
static int finish(run *r)
{
    const uint64_t dropped = taps_dropped(&r->taps);
    const double seconds = (double)(clock_ns() - r->start) * 1e-9;
    const int error = recording_close(&r->file);
    if (r->start)
        fprintf(stderr,
                "%s: %" PRIu64 " requests of robot '%s', %.1f MB, %.1f s, dropped %" PRIu64 "\n",
                r->a->file, r->file.records, r->a->robot, (double)r->file.file_bytes * 1e-6,
                seconds, dropped);
    if (error && !r->start) {
        fprintf(stderr, "totalforce record: %s: %s\n", r->a->file, strerror(error));
        return EXIT_FAILED;
    }
    if (error) {
        fprintf(stderr, "totalforce record: %s: %s: the recording ends there\n", r->a->file,
                strerror(error));
        return EXIT_FAILED;
    }
    if (r->broken) {
        fprintf(stderr, "totalforce record: the daemon's taps hold something else than records\n");
        return EXIT_FAILED;
    }
    if (r->hung_up)
        fprintf(stderr, "totalforce record: the daemon ended the recording: %s\n",
                *r->taps.reason ? r->taps.reason : "it hung up");
    if (dropped)
        fprintf(stderr,
                "totalforce record: %" PRIu64 " requests are missing: --buffer gives the daemon "
                "more memory for them (%u MiB now)\n",
                dropped, r->a->mib);
    return dropped || (r->hung_up && (r->a->count || r->a->seconds > 0)) ? EXIT_UNMET : EXIT_GOOD;
}

/* SIGXFSZ would end the program at a limit that write() reports as well. */
static void catch_signals(void)
{
    const struct sigaction stop = {.sa_handler = interrupt}, ignore = {.sa_handler = SIG_IGN};
    sigaction(SIGINT, &stop, NULL);
    sigaction(SIGTERM, &stop, NULL);
    sigaction(SIGXFSZ, &ignore, NULL);
}

int command_record(int argc, char **argv)
{
    static const struct argp_child children[] = {{.argp = &operator_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .children = children,
        .args_doc = "ROBOT -o FILE",
        .doc =
            "Records requests and answers of a robot, of all its clients, until Ctrl-C. The file "
            "has the robot, too: `totalforce replay` needs nothing else. For root and the "
            "daemon's user.\vExit status: 1 if requests are missing, or the daemon ended the "
            "recording before --count or --seconds was reached."};
    arguments a = {.mib = DEFAULT_MIB};
    char text[512];
    if (command_line_parse(&argp, NULL, argc, argv, &a))
        return EXIT_USAGE;
    run r = {.a = &a, .file.fd = -1};
    catch_signals();
    if (taps_open(&r.taps, a.runtime_dir, a.robot, a.mib, text, sizeof text) != 0) {
        fprintf(stderr, "totalforce record: %s\n", text);
        return EXIT_FAILED;
    }
    int result = check_model(&r);
    if (result == EXIT_GOOD) {
        const int error =
            recording_create(&r.file, a.file, taps_description(&r.taps), taps_texts(&r.taps));
        if (!error)
            record(&r);
        result = finish(&r);
    }
    taps_close(&r.taps);
    return result;
}
