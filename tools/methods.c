/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce methods`: the table of methods, as the library has it.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "jsonl/jsonl.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/dynamics.h>

enum { KEY_JSON = 1000 };

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    int *json = state->input;
    switch (key) {
    case KEY_JSON:
        *json = 1;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is taken", text);
        return EINVAL;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Calls `each` with the text of every bit that is set. */
static void each_refusal(unsigned refuses, void (*each)(const char *text, int first))
{
    int first = 1;
    for (unsigned bit = 1; bit <= refuses; bit <<= 1)
        if (refuses & bit) {
            each(tfa_refusal_text(bit), first);
            first = 0;
        }
}

static void print_plain(const char *text, int first)
{
    printf("%s%s", first ? "    refuses " : "; ", text);
}

static void print_item(const char *text, int first)
{
    fputs(first ? "" : ",", stdout);
    jsonl_print_string(stdout, text);
}

static const char *answers(const tfa_method_info *m)
{
    return m->forward_dynamics && m->lambda ? "qdd, lambda_inv"
           : m->forward_dynamics            ? "qdd"
           : m->lambda                      ? "lambda_inv"
                                            : "tau";
}

static void print_row(const tfa_method_info *m)
{
    printf("%-14s %-16s %-27s %s\n", m->name, answers(m), m->cost, m->summary);
    each_refusal(m->refuses, print_plain);
    if (m->refuses)
        putchar('\n');
}

static void print_row_json(const tfa_method_info *m)
{
    printf("{\"method\":\"%s\",\"number\":%d,\"forward_dynamics\":%s,\"lambda_inv\":%s,\"cost\":",
           m->name, (int)m->method, m->forward_dynamics ? "true" : "false",
           m->lambda ? "true" : "false");
    jsonl_print_string(stdout, m->cost);
    fputs(",\"refuses\":[", stdout);
    each_refusal(m->refuses, print_item);
    fputs("],\"what\":", stdout);
    jsonl_print_string(stdout, m->summary);
    fputs("}\n", stdout);
}

int command_methods(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {.name = "json", .key = KEY_JSON, .doc = "One JSON object a line"}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse_option,
        .doc = "The methods: answers, cost for N bodies, m tips, depth d and P "
               "processors, and refusals by name."};
    int json = 0;
    const error_t error = command_line_parse(&argp, NULL, argc, argv, &json);
    if (error) {
        fprintf(stderr, "totalforce methods: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    const tfa_method_info *row;
    for (uint32_t method = 0; (row = tfa_method_describe(method)); method++)
        (json ? print_row_json : print_row)(row);
    if (fflush(stdout) == 0 && !ferror(stdout))
        return EXIT_GOOD;
    fprintf(stderr, "totalforce methods: standard output: %s\n", strerror(errno));
    return EXIT_FAILED;
}
