/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce call`: the JSON lines of `solve`, answered by a running daemon.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/daemon.h"
#include "common/suggest.h"
#include "jsonl/jsonl_options.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct call_options {
    daemon_via via;
    daemon_options daemon;
    jsonl_options lines;
} call_options;

enum { KEY_VIA = 256 };

static const struct argp_option option_table[] = {
    {.name = "via", .key = KEY_VIA, .arg = "shm|dds", .doc = "Transport (shm)"}, {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    static const char *const vias[] = {"shm", "dds"};
    call_options *options = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &options->daemon;
        state->child_inputs[1] = &options->lines;
        return 0;
    case KEY_VIA:
        options->via = (daemon_via)option_word(state, "via", text, vias, 2);
        return 0;
    case ARGP_KEY_ARG:
        option_argument(
            state, options->daemon.robot ? &options->lines.file : &options->daemon.robot, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which robot?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* The daemon as a solver. Without a link it is looked for again at every line. */
typedef struct caller {
    const call_options *options;
    daemon_link *link;
    int lost;    /* the last call ended the link: close it before the next line */
    int reached; /* there was a daemon at least once */
    int missed;  /* and once there was none */
    tfa_names names;
} caller;

static void disconnect(caller *c)
{
    tfa_names_free(&c->names);
    daemon_close(c->link);
    c->link = NULL;
    c->lost = 0;
}

static int prepare(void *self, const tfa_names **names, jsonl_error *error)
{
    caller *c = self;
    const daemon_options *options = &c->options->daemon;
    *names = &c->names;
    if (c->lost)
        disconnect(c);
    if (c->link)
        return TFA_OK;
    int status = daemon_connect(options, c->options->via, &c->link);
    if (status == TFA_OK)
        status = tfa_names_of_info(&c->names, options->robot, daemon_info(c->link));
    if (status == TFA_OK) {
        c->reached = 1;
        return TFA_OK;
    }
    c->missed = 1;
    char text[512];
    daemon_explain(options, c->options->via, status, text, sizeof text);
    disconnect(c);
    return jsonl_fail(error, status, "%s", text);
}

static int call_daemon(void *self, const tfa_request *request, tfa_reply *reply)
{
    caller *c = self;
    int status = daemon_call(c->link, request, reply, NULL);
    /* the names are still needed to print this reply: hang up before the next line */
    c->lost = daemon_lost(status);
    return status;
}

int command_call(int argc, char **argv)
{
    static const command_line_values values[] = {{"METHOD", suggest_method}, {0}};
    static const struct argp_child children[] = {
        {.argp = &daemon_argp}, {.argp = &jsonl_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "ROBOT [REQUESTS.jsonl]",
        .doc = "Sends JSON lines (-, the default: standard input) to the daemon that serves ROBOT; "
               "one "
               "reply a line, in order, the same as `totalforce solve` gives.\v" JSONL_HELP,
        .children = children};
    call_options options = {.lines = JSONL_OPTIONS_DEFAULT};
    error_t error = command_line_parse(&argp, values, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce call: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    options.daemon.max_tips = TFA_MAX_TIPS; /* one line after the other: two slots are enough */
    options.daemon.slots = 2;
    caller self = {.options = &options};
    int result =
        jsonl_run("totalforce call", &options.lines,
                  &(jsonl_backend){.self = &self, .prepare = prepare, .answer = call_daemon});
    disconnect(&self);
    return self.missed && !self.reached ? EXIT_FAILED : result;
}
