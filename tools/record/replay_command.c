/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce replay`: the requests of a recording again, and a comparison of the answers.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "record/replay.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    KEY_RUNTIME_DIR = 256,
    KEY_URDF,
    KEY_ROBOT,
    KEY_KERNEL,
    KEY_RATE,
    KEY_TOLERANCE,
    KEY_ANY_MODEL,
    KEY_JSON
};

static const struct argp_option option_table[] = {
    {.name = "robot",
     .key = KEY_ROBOT,
     .arg = "ROBOT",
     .doc = "Asks a running daemon that serves ROBOT (in process unless given)"},
    {.name = "runtime-dir",
     .key = KEY_RUNTIME_DIR,
     .arg = "DIR",
     .doc = "Where that daemon's sockets are ($TOTALFORCE_RUNTIME_DIR, else /run/totalforce)"},
    {.name = "urdf", .key = KEY_URDF, .arg = "FILE", .doc = "In place of the recording's own URDF"},
    {.name = "kernel",
     .key = KEY_KERNEL,
     .arg = "FILE",
     .doc = "Specialised kernel to compute with (the generic one)"},
    {.name = "rate",
     .key = KEY_RATE,
     .arg = "RATE",
     .doc = "original: at the recorded times; max: one after the other; or so many a second (max)"},
    {.name = "tolerance",
     .key = KEY_TOLERANCE,
     .arg = "X",
     .doc = "Numbers may differ by X of the largest one of their array (the same bits)"},
    {.name = "any-model",
     .key = KEY_ANY_MODEL,
     .doc = "Compares even if the model is not that of the recording"},
    {.name = "json", .key = KEY_JSON, .doc = "Prints the report as JSON"},
    {0}};

static double parse_rate(struct argp_state *state, const char *text)
{
    if (strcmp(text, "original") == 0)
        return -1;
    if (strcmp(text, "max") == 0)
        return 0;
    const double hz = option_double(state, "rate", text);
    if (!(hz > 0 && hz <= 1e9))
        argp_error(state, "--rate: '%s' is not original, max or a number of Hz above 0", text);
    return hz;
}

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    replay_options *o = state->input;
    switch (key) {
    case KEY_RUNTIME_DIR:
        o->runtime_dir = text;
        return 0;
    case KEY_URDF:
        o->urdf = text;
        return 0;
    case KEY_ROBOT:
        o->robot = text;
        return 0;
    case KEY_KERNEL:
        o->kernel = text;
        return 0;
    case KEY_RATE:
        o->hz = parse_rate(state, text);
        return 0;
    case KEY_TOLERANCE:
        o->tolerance = option_double(state, "tolerance", text);
        if (!(o->tolerance >= 0))
            argp_error(state, "--tolerance: %s is below 0", text);
        return 0;
    case KEY_ANY_MODEL:
        o->any_model = 1;
        return 0;
    case KEY_JSON:
        o->json = 1;
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &o->file, text);
        return 0;
    case ARGP_KEY_END:
        if (!o->file)
            argp_error(state, "which recording?");
        if (o->robot && (o->urdf || o->kernel))
            argp_error(state, "--urdf and --kernel belong to a replay in process, not to --robot");
        if (o->runtime_dir && !o->robot)
            argp_error(state, "--runtime-dir: which --robot?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

int command_replay(int argc, char **argv)
{
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "FILE",
        .doc = "Asks the requests of a recording (`totalforce record`) again and compares the "
               "answers with the recorded ones, and the times. Requests that were late when "
               "recorded are counted, not played.\vExit status: 0 the same, 1 not the same, 2 "
               "failure. Records are numbered from 0."};
    replay_options options = {0};
    if (command_line_parse(&argp, NULL, argc, argv, &options))
        return EXIT_USAGE;
    replay *r = calloc(1, sizeof *r);
    if (!r) {
        fprintf(stderr, "totalforce replay: %s\n", tfa_status_text(TFA_E_MEMORY));
        return EXIT_FAILED;
    }
    int result = replay_open(r, &options);
    if (result == EXIT_GOOD)
        result = replay_run(r);
    if (result == EXIT_GOOD) {
        if (options.json)
            result = replay_print_json(r);
        else
            replay_print(r);
        if (result == EXIT_GOOD && r->differing)
            result = EXIT_UNMET;
    }
    replay_close(r);
    free(r);
    return fflush(stdout) == 0 ? result : EXIT_FAILED;
}
