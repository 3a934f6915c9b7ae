/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce top`: rates and percentiles of a running daemon, live in a terminal.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/operator.h"
#include "watch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { KEY_ONCE = 256, KEY_JSON };

#define CTRL_C 3
#define REOPEN_MS 300 /* a daemon that hangs delays the keys by this at most */

typedef struct arguments {
    const char *runtime_dir;
    double interval;
    int once, json;
} arguments;

static const struct argp_option options[] = {
    {"interval", 'i', "S", 0, "Seconds between two readings, 0.05 to 3600 (1)", 0},
    {"once", KEY_ONCE, NULL, 0, "Print the figures of one interval, and end", 0},
    {"json", KEY_JSON, NULL, 0, "Print JSON, a line for each interval", 0},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->runtime_dir;
        return 0;
    case 'i':
        a->interval = option_double(state, "interval", text);
        if (!(a->interval >= 0.05 && a->interval <= 3600))
            argp_error(state, "--interval: %s: 0.05 to 3600 seconds", text);
        return 0;
    case KEY_ONCE:
        a->once = 1;
        return 0;
    case KEY_JSON:
        a->json = 1;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is taken", text);
        return EINVAL;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void sleep_for(double seconds)
{
    struct timespec left = {.tv_sec = (time_t)seconds,
                            .tv_nsec = (long)(1e9 * (seconds - (double)(time_t)seconds))};
    while (nanosleep(&left, &left) != 0 && errno == EINTR)
        ;
}

/* ---- without a terminal ---- */

static int print_json(const watch *w)
{
    json_t *all = watch_json(w);
    const int bad = !all || json_dumpf(all, stdout, JSON_COMPACT) != 0 || putchar('\n') == EOF;
    json_decref(all);
    return bad || fflush(stdout) != 0;
}

/* One interval, or with --json one after the other until the daemon ends. */
static int print(watch *w, const arguments *a)
{
    do {
        sleep_for(a->interval);
        const int status = watch_read(w);
        if (status != TFA_OK) {
            operator_explain("top", a->runtime_dir, status);
            return EXIT_FAILED;
        }
        if (!a->json)
            watch_write_table(w, stdout);
        if (a->json ? print_json(w) : fflush(stdout) != 0)
            return EXIT_FAILED;
    } while (a->json && !a->once && !watch_is_gone(w));
    return EXIT_GOOD;
}

/* ---- live ---- */

/* Shows the last reading, and what is wrong. */
static void show(const watch *w, const arguments *a, const char *note)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return;
    fprintf(out, "totalforce top: every %g s, q ends%s%s\n", a->interval, *note ? "; " : "", note);
    if (w->now)
        watch_write_table(w, out);
    if (fclose(out) == 0)
        terminal_show(text);
    free(text);
}

/* A reading, or another attempt to find a daemon. @return a remark for the first line */
static const char *update(watch *w)
{
    const bool was_gone = !w->now || watch_is_gone(w);
    if (w->now && !was_gone)
        return watch_read(w) == TFA_OK ? (watch_is_gone(w) ? "the daemon ended" : "")
                                       : "a worker stands still";
    watch other = {.runtime_dir = w->runtime_dir};
    const int status = watch_open(&other, REOPEN_MS);
    if (status != TFA_OK)
        return status == TFA_E_DISCONNECTED ? "the daemon ended; waiting for one"
                                            : "the daemon does not answer";
    if (watch_read(&other) != TFA_OK) {
        watch_close(&other);
        return "a worker stands still";
    }
    watch_close(w);
    *w = other;
    return "connected again";
}

static uint64_t now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000 + (uint64_t)t.tv_nsec / 1000000;
}

static void watch_live(watch *w, const arguments *a)
{
    const uint64_t interval = (uint64_t)(1e3 * a->interval);
    const char *note = "";
    uint64_t next = now_ms();
    for (;;) {
        char key = 0;
        const uint64_t now = now_ms();
        if (now >= next) {
            note = update(w);
            next = now + interval;
        }
        show(w, a, note);
        const terminal_event event =
            terminal_wait((int)(next > now_ms() ? next - now_ms() : 0), &key);
        if (event == TERMINAL_END ||
            (event == TERMINAL_KEY && (key == 'q' || key == 'Q' || key == CTRL_C)))
            return;
    }
}

int command_top(int argc, char **argv)
{
    static const struct argp_child children[] = {{.argp = &operator_argp}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse_option,
        .children = children,
        .doc =
            "Shows rates, percentiles, queues, methods and refusals of a running daemon by robot "
            "and client: live in a terminal, until q or Ctrl-C; elsewhere one table.\v"
            "Percentiles are those of the last interval, in us: queue (receipt to start), "
            "compute, total (the client's sending to the answer)."};
    arguments a = {.interval = 1};
    const error_t error = command_line_parse(&argp, NULL, argc, argv, &a);
    if (error) {
        fprintf(stderr, "totalforce top: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    watch w = {.runtime_dir = a.runtime_dir};
    const int status = watch_open(&w, 0);
    if (status != TFA_OK) {
        operator_explain("top", a.runtime_dir, status);
        return EXIT_FAILED;
    }
    int result = EXIT_GOOD;
    if (a.once || a.json || !isatty(STDOUT_FILENO) || !terminal_open()) {
        result = print(&w, &a);
    } else {
        watch_live(&w, &a);
        terminal_close();
    }
    watch_close(&w);
    return result;
}
