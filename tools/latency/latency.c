/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce latency`: measures round trips to a running daemon, beside their lower bounds.
 */
#include "common/commands.h"
#include "common/progress.h"
#include "latency/report/report.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Files that were asked for. @return 0, or -1 after a message */
static int write_files(const latency_options *options, const latency_session *session)
{
    const struct {
        const char *path;
        int (*write)(const char *path, const latency_session *session);
    } files[] = {{options->csv, latency_write_csv},
                 {options->table, latency_write_table},
                 {options->histogram, latency_write_histogram},
                 {options->save, latency_save}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        if (files[i].path && files[i].write(files[i].path, session) != 0) {
            fprintf(stderr, "totalforce latency: %s: %s\n", files[i].path, strerror(errno));
            return -1;
        }
    return 0;
}

/* @return 0, or errno: the file is none, or neither exists nor can be made */
static int check_writable(const char *path)
{
    struct stat info;
    char folder[PATH_MAX];
    if (stat(path, &info) == 0) {
        if (S_ISDIR(info.st_mode))
            return EISDIR;
        return access(path, W_OK) == 0 ? 0 : errno;
    }
    if (errno != ENOENT)
        return errno;
    if (snprintf(folder, sizeof folder, "%s", path) >= (int)sizeof folder)
        return ENAMETOOLONG;
    return access(dirname(folder), W_OK | X_OK) == 0 ? 0 : errno;
}

/* Files that are needed at the end, before a run that may take hours. @return 0, or -1 after a
 * message */
static int check_files(const latency_options *o)
{
    const char *const paths[] = {o->csv, o->table, o->histogram, o->html, o->save};
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        const int error = paths[i] ? check_writable(paths[i]) : 0;
        if (error) {
            fprintf(stderr, "totalforce latency: %s: %s\n", paths[i], strerror(error));
            return -1;
        }
    }
    return latency_check_plot(o) == EXIT_GOOD ? 0 : -1;
}

static int print(const latency_options *options, const latency_session *session)
{
    if (options->json)
        return latency_print_json(stdout, session);
    if (options->cyclictest)
        latency_print_cyclictest(stdout, session);
    else
        latency_print_text(stdout, session);
    return 0;
}

static int report(const latency_options *options, const latency_session *session)
{
    int met = 1;
    const int bad = print(options, session) != 0;
    if (fflush(stdout) != 0 || bad) {
        perror("totalforce latency: standard output");
        return EXIT_FAILED;
    }
    if (write_files(options, session) != 0 || latency_plot(options, session) != EXIT_GOOD)
        return EXIT_FAILED;
    for (int i = 0; i < session->count; i++) {
        if (latency_expected(&session->runs[i], session->baseline))
            continue;
        met = 0;
        fprintf(stderr, "totalforce latency: %s: expectation not met\n",
                latency_via_names[session->runs[i].via]);
    }
    return met ? EXIT_GOOD : EXIT_UNMET;
}

/* The runs, until one ends early: it is the last one of the report if it has figures.
 * @return an exit status */
static int measure_runs(latency_session *session)
{
    for (int i = 0; i < session->count; i++) {
        latency_run *run = &session->runs[i];
        if (i > 0 && strcmp(run->options.daemon.robot, run[-1].options.daemon.robot) == 0)
            run->options.known = run[-1].facts.info;
        const int status = latency_measure(run);
        if (status == TFA_OK && !run->ended_early)
            continue;
        const int has_figures = run->total && run->total->parts[PART_ROUND_TRIP].h.count;
        session->count = i + (has_figures ? 1 : 0);
        return status == TFA_OK ? EXIT_UNMET : EXIT_FAILED;
    }
    return EXIT_GOOD;
}

static int measure(const latency_options *options, latency_session *session)
{
    latency_baseline *baseline = session->baseline;
    if (options->mlock && machine_lock_memory() != 0)
        return EXIT_FAILED;
    if (options->priority && machine_set_priority(options->priority) != 0)
        return EXIT_FAILED;
    if (latency_measure_machine(options, baseline) != 0)
        return EXIT_FAILED;
    session->environment = environment_read();
    const int result = measure_runs(session);
    if (session->count == 0)
        return result;
    const latency_run *first = &session->runs[0];
    if (first->via == VIA_SHM)
        latency_measure_same_size(first, baseline);
    if (options->urdf && first->states.requests) {
        progress_show("solve in process", 0, 0, "");
        const int status = latency_solve(first, &baseline->solve.h);
        progress_show(NULL, 0, 0, "");
        if (status != TFA_OK)
            return EXIT_FAILED;
    }
    if (options->priority && machine_set_priority(0) != 0)
        return EXIT_FAILED;
    const int reported = report(options, session);
    return result == EXIT_GOOD ? reported : result;
}

static int run(const latency_options *options, const char *command)
{
    latency_session session = {.command = command};
    const time_t now = time(NULL);
    struct tm utc;
    int result = EXIT_FAILED, planned = 0;
    strftime(session.date, sizeof session.date, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
    /* histograms are too large for the stack */
    session.baseline = malloc(sizeof *session.baseline);
    if (session.baseline) {
        latency_baseline_init(session.baseline);
        session.count = planned = latency_plan(options, &session.runs);
        if (session.count)
            result = measure(options, &session);
    } else
        fprintf(stderr, "totalforce latency: %s\n", tfa_status_text(TFA_E_MEMORY));
    latency_runs_free(session.runs, planned);
    free(session.baseline);
    json_decref(session.environment);
    return result;
}

int command_latency(int argc, char **argv)
{
    latency_options options;
    char *command = join_arguments(argc, argv);
    const int error = latency_options_parse(&options, argc, argv);
    int result = EXIT_USAGE;
    if (error)
        fprintf(stderr, "totalforce latency: %s\n", strerror(error));
    else if (!options.daemon.robot)
        result = latency_compare(options.compare[0], options.compare[1]);
    else if (check_files(&options) != 0)
        result = EXIT_FAILED;
    else
        result = run(&options, command ? command : "totalforce latency");
    free(command);
    return result;
}
