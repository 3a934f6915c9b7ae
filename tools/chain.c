/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce chain`: writes a test mechanism as URDF.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "mechanism/mechanism.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Defaults depend on the kind, which may be named last: given options are applied after all. */
typedef struct chain_options {
    const char *name;
    mechanism_options read_argument;
    int has_radius, has_ratio, has_taper, has_curl;
} chain_options;

static const struct argp_option option_table[] = {
    {.name = "bodies", .key = 'n', .arg = "N", .doc = "Moving bodies (8)"},
    {.name = "radius", .key = 'r', .arg = "M", .doc = "Radius of the rods (0.1; thin 1e-4)"},
    {.name = "mass-ratio", .key = 'm', .arg = "X", .doc = "Heavy over light mass (1e6)"},
    {.name = "taper",
     .key = 't',
     .arg = "X",
     .doc = "Mass of the tip over that of the root (0.01)"},
    {.name = "curl", .key = 'c', .arg = "X", .doc = "Bends at q = 0: 0 straight, 1 as named (1)"},
    {.name = "seed", .key = 's', .arg = "N", .doc = "Of the random numbers (1)"},
    {0}};

static double read_argument(struct argp_state *state, const char *name, const char *text, int *has)
{
    *has = 1;
    return option_double(state, name, text);
}

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    chain_options *options = state->input;
    mechanism_options *m = &options->read_argument;
    switch (key) {
    case 'n':
        m->bodies = (uint32_t)option_unsigned(state, "bodies", text, 1, MECHANISM_BODIES_MAX);
        return 0;
    case 'r':
        m->radius = read_argument(state, "radius", text, &options->has_radius);
        return 0;
    case 'm':
        m->ratio = read_argument(state, "mass-ratio", text, &options->has_ratio);
        return 0;
    case 't':
        m->taper = read_argument(state, "taper", text, &options->has_taper);
        return 0;
    case 'c':
        m->curl = read_argument(state, "curl", text, &options->has_curl);
        return 0;
    case 's':
        m->seed = option_unsigned(state, "seed", text, 0, UINT64_MAX);
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &options->name, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which mechanism?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static mechanism_options complete(const chain_options *options, mechanism_kind kind)
{
    const mechanism_options *m = &options->read_argument;
    mechanism_options all = mechanism_defaults(kind, m->bodies);
    all.seed = m->seed;
    all.radius = options->has_radius ? m->radius : all.radius;
    all.ratio = options->has_ratio ? m->ratio : all.ratio;
    all.taper = options->has_taper ? m->taper : all.taper;
    all.curl = options->has_curl ? m->curl : all.curl;
    return all;
}

static int unknown_name(const char *name)
{
    const char *names[MECHANISM_COUNT];
    char list[512];
    for (int i = 0; i < MECHANISM_COUNT; i++)
        names[i] = mechanism_name((mechanism_kind)i);
    tfa_suggest_words(name, names, MECHANISM_COUNT, list, sizeof list);
    fprintf(stderr, "totalforce chain: no mechanism '%s'; %s\n", name, list);
    return EXIT_USAGE;
}

#define CHAIN_ROW(name, text, what) "  " text ": " what "\n"

int command_chain(int argc, char **argv)
{
    static const command_line_values values[] = {{"MECHANISM", mechanism_word}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "MECHANISM",
        .doc = "Writes a test mechanism as URDF on standard output; the same options give the same "
               "numbers everywhere.\v"
               "Mechanisms (links of 1 m, uniform rods of 1 kg, revolute joints, fixed "
               "base):\n" MECHANISM_LIST(CHAIN_ROW)};
    chain_options options = {.read_argument = {.bodies = 8, .seed = 1}};
    error_t error = command_line_parse(&argp, values, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce chain: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    int kind = mechanism_find(options.name);
    if (kind < 0)
        return unknown_name(options.name);
    char why[128];
    mechanism_options all = complete(&options, (mechanism_kind)kind);
    if (mechanism_check(&all, why, sizeof why) != 0) {
        fprintf(stderr, "totalforce chain: %s\n", why);
        return EXIT_USAGE;
    }
    mechanism_write(&all, stdout);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fprintf(stderr, "totalforce chain: standard output: %s\n", strerror(errno));
        return EXIT_FAILED;
    }
    return EXIT_GOOD;
}
