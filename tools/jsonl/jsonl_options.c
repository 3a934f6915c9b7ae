/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Options that `solve` and `call` have in common, and the run from requests to replies.
 */
#include "jsonl_options.h"

#include "common/commands.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { KEY_METHOD = 512, KEY_REFINE, KEY_ESTIMATE, KEY_STRICT };

static const struct argp_option option_table[] = {
    {.name = "method",
     .key = KEY_METHOD,
     .arg = "METHOD",
     .doc = "Method of forward_dynamics, operational_inertia and task_torques where a request "
            "names none (auto)"},
    {.name = "refine",
     .key = KEY_REFINE,
     .arg = "0|1|2|3",
     .doc = "Refinement steps (the method's)"},
    {.name = "estimate",
     .key = KEY_ESTIMATE,
     .arg = "default|always|never",
     .doc = "Measure the error of answers: where the sentinel trips (default), of all, of none"},
    {.name = "strict", .key = KEY_STRICT, .doc = "Exit with 1 if any reply was an error"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    jsonl_options *options = state->input;
    switch (key) {
    case KEY_METHOD:
        options->defaults.method = option_method(state, text);
        return 0;
    case KEY_REFINE:
        options->defaults.refine =
            (uint32_t)option_unsigned(state, "refine", text, 0, TFA_MAX_REFINE);
        return 0;
    case KEY_ESTIMATE:
        options->defaults.estimate =
            (tfa_estimate)option_enum(state, "estimate", text, TFA_WORDS_ESTIMATE);
        return 0;
    case KEY_STRICT:
        options->strict = 1;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

const struct argp jsonl_argp = {.options = option_table, .parser = parse_option};

int jsonl_run(const char *command, const jsonl_options *options, const jsonl_backend *backend)
{
    jsonl_tally tally;
    const int is_standard = !options->file || strcmp(options->file, "-") == 0;
    const int input = is_standard ? STDIN_FILENO : open(options->file, O_RDONLY | O_CLOEXEC);
    if (input < 0) {
        fprintf(stderr, "%s: %s: %s\n", command, options->file, strerror(errno));
        return EXIT_FAILED;
    }
    int status = jsonl_serve(input, stdout, backend, &options->defaults, &tally);
    const int error = errno;
    if (!is_standard)
        close(input);
    errno = error;
    if (status == TFA_OK)
        return options->strict && tally.errors ? EXIT_UNMET : EXIT_GOOD;
    /* a reader that closed the pipe needs no message */
    if (status != TFA_E_SYSTEM || errno != EPIPE)
        fprintf(stderr, "%s: line %llu: %s: %s\n", command, (unsigned long long)tally.lines,
                tfa_status_text(status),
                status == TFA_E_SYSTEM ? strerror(errno) : tfa_status_cause(status));
    return EXIT_FAILED;
}
