/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The command line of `totalforce atlas`, and its maps.
 */
#include "atlas.h"
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

static const struct {
    mechanism_kind kind;
    size_t member; /* where in mechanism_options the value goes */
    double first, last;
    const char *axis, *what;
} maps[] = {
#define ATLAS_MAP_ROW(name, word, kind, member, first, last, axis, what)                           \
    {MECHANISM_##kind, offsetof(mechanism_options, member), first, last, axis, what},
    ATLAS_MAP_LIST(ATLAS_MAP_ROW)
#undef ATLAS_MAP_ROW
};

const char *const atlas_map_words[ATLAS_MAP_COUNT] = {
#define ATLAS_MAP_WORD(name, word, kind, member, first, last, axis, what) word,
    ATLAS_MAP_LIST(ATLAS_MAP_WORD)
#undef ATLAS_MAP_WORD
};

const char *const atlas_mode_words[ATLAS_MODE_COUNT] = {
#define ATLAS_MODE_WORD(name, word, what) word,
    ATLAS_MODE_LIST(ATLAS_MODE_WORD)
#undef ATLAS_MODE_WORD
};

double atlas_value(atlas_map map, uint32_t point, uint32_t points)
{
    const double first = maps[map].first, last = maps[map].last;
    const double way = points > 1 ? (double)point / (points - 1) : 1.0;
    return first == 0.0 ? last * way * way : first * pow(last / first, way);
}

mechanism_options atlas_mechanism(atlas_map map, double value, uint32_t bodies, uint64_t seed)
{
    mechanism_options m = mechanism_defaults(maps[map].kind, bodies);
    m.seed = seed;
    memcpy((char *)&m + maps[map].member, &value, sizeof value);
    return m;
}

const char *atlas_axis(atlas_map map)
{
    return maps[map].axis;
}

const char *atlas_map_text(atlas_map map)
{
    return maps[map].what;
}

enum {
    KEY_MAPS = 256,
    KEY_POINTS,
    KEY_RHS,
    KEY_STATES,
    KEY_SEEDS,
    KEY_JSON,
    KEY_HTML,
    KEY_SCRIPTS
};

static const struct argp_option option_table[] = {
    {.name = "maps", .key = KEY_MAPS, .arg = "MAP,...", .doc = "Maps (all)"},
    {.name = "points", .key = KEY_POINTS, .arg = "N", .doc = "Values along the axis (13)"},
    {.name = "bodies", .key = 'n', .arg = "N,...", .doc = "Sizes (2,4,8,16,32,64,128,256)"},
    {.name = "methods",
     .key = 'M',
     .arg = "METHOD,...",
     .doc = "Methods (all of forward dynamics)"},
    {.name = "rhs", .key = KEY_RHS, .arg = "qdd|tau|gravity", .doc = "Right-hand side (qdd)"},
    {.name = "states", .key = KEY_STATES, .arg = "N", .doc = "Random states of each seed (3)"},
    {.name = "seed", .key = 's', .arg = "N", .doc = "Of the random numbers (1)"},
    {.name = "seeds",
     .key = KEY_SEEDS,
     .arg = "N",
     .doc = "Seeds in each cell, from --seed on: other mechanisms and states (3)"},
    {.name = "json", .key = KEY_JSON, .doc = "JSON, one row a line, in place of CSV"},
    {.name = "html",
     .key = KEY_HTML,
     .arg = "FILE",
     .doc = "Write a self-contained page there: all maps, numbers under the pointer, filters"},
    {.name = "output", .key = 'o', .arg = "FOLDER", .doc = "Write atlas.csv, SVG and PNG there"},
    {.name = "scripts",
     .key = KEY_SCRIPTS,
     .arg = "FOLDER",
     .doc = "The gnuplot scripts (those installed with the program)"},
    {0}};

static void check_sizes(struct argp_state *state, const atlas_options *o)
{
    for (uint32_t k = 1; k < o->size_count; k++)
        if (o->sizes[k] <= o->sizes[k - 1])
            argp_error(state, "--bodies: '%u' is not larger than the size before it", o->sizes[k]);
}

static void complete(atlas_options *o)
{
    const tfa_method_info *info;
    o->maps = o->maps ? o->maps : (1u << ATLAS_MAP_COUNT) - 1;
    const uint32_t asked = o->size_count;
    for (uint32_t size = 2; asked == 0 && size <= 256; size *= 2)
        o->sizes[o->size_count++] = size;
    if (o->method_count)
        return;
    for (uint32_t m = TFA_METHOD_AUTO + 1; (info = tfa_method_describe(m)); m++)
        if (info->forward_dynamics && o->method_count < ATLAS_METHODS)
            o->methods[o->method_count++] = m;
}

static error_t parse_lists(int key, char *text, struct argp_state *state)
{
    atlas_options *o = state->input;
    const option_list sizes = {o->sizes, &o->size_count, ATLAS_SIZES};
    const option_list methods = {o->methods, &o->method_count, ATLAS_METHODS};
    switch (key) {
    case KEY_MAPS:
        o->maps |= option_words(state, "maps", text, atlas_map_words, ATLAS_MAP_COUNT);
        return 0;
    case 'n':
        option_list_read(state, "bodies", text, sizes, chart_read_size);
        check_sizes(state, o);
        return 0;
    case 'M':
        option_list_read(state, "methods", text, methods, option_forward_method);
        return 0;
    case KEY_RHS:
        o->rhs = (chart_rhs)option_word(state, "rhs", text, chart_rhs_words, CHART_RHS_COUNT);
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "one argument too many: '%s'", text);
        return 0;
    case ARGP_KEY_END:
        complete(o);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    atlas_options *o = state->input;
    switch (key) {
    case KEY_POINTS:
        o->points = (uint32_t)option_unsigned(state, "points", text, 2, ATLAS_POINTS);
        return 0;
    case KEY_STATES:
        o->states = (uint32_t)option_unsigned(state, "states", text, 1, CHART_STATES);
        return 0;
    case KEY_SEEDS:
        o->seeds = (uint32_t)option_unsigned(state, "seeds", text, 1, CHART_SEEDS);
        return 0;
    case 's':
        o->seed = option_unsigned(state, "seed", text, 0, UINT64_MAX);
        return 0;
    case KEY_JSON:
        o->json = 1;
        return 0;
    case 'o':
        o->folder = text;
        return 0;
    case KEY_HTML:
        o->html = text;
        return 0;
    case KEY_SCRIPTS:
        o->scripts = text;
        return 0;
    default:
        return parse_lists(key, text, state);
    }
}

#define ATLAS_MAP_HELP(name, word, kind, member, first, last, axis, what)                          \
    "  " word ": " what "; " axis "\n"
#define ATLAS_MODE_HELP(name, word, what) "  " word ": " what "\n"

static const char *map_word(size_t index)
{
    return index < ATLAS_MAP_COUNT ? atlas_map_words[index] : NULL;
}

int atlas_parse(int argc, char **argv, atlas_options *options)
{
    static const command_line_values values[] = {
        {"MAP", map_word}, {"METHOD", suggest_forward_method}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .doc =
            "Maps the error of every method over the cause of its failures, and over the number of "
            "bodies, against articulated bodies in quadruple precision.\v"
            "Maps:\n" ATLAS_MAP_LIST(
                ATLAS_MAP_HELP) "\nModes, a row of each for every "
                                "cell:\n" ATLAS_MODE_LIST(
                                    ATLAS_MODE_HELP) "\nExit status 1: an estimate was below a "
                                                     "thirtieth of the true error, or an "
                                                     "error above 1e-6 was estimated below 1e-7."};
    *options = (atlas_options){
        .points = 13, .states = 3, .seeds = 3, .seed = 1, .command = join_arguments(argc, argv)};
    return options->command ? command_line_parse(&argp, values, argc, argv, options) : ENOMEM;
}
