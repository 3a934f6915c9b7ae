/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The command line of `totalforce chart`.
 */
#include "chart.h"
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"
#include "peer.h"

#include <errno.h>
#include <string.h>

enum {
    KEY_URDF = 256,
    KEY_BASE,
    KEY_OP,
    KEY_TIP,
    KEY_RHS,
    KEY_REFINE,
    KEY_PRECISION,
    KEY_THREADS,
    KEY_STRATEGIES,
    KEY_KERNELS,
    KEY_TURN,
    KEY_STATES,
    KEY_SEEDS,
    KEY_BUDGET,
    KEY_JSON,
    KEY_HTML,
    KEY_SCRIPTS
};

static const struct argp_option option_table[] = {
    {.name = "mechanisms",
     .key = 'm',
     .arg = "MECHANISM[:X],...",
     .doc = "NAME or NAME:X, where X is its mass "
            "ratio, taper or radius (all, unless --urdf is given)"},
    {.name = "bodies", .key = 'n', .arg = "N,...", .doc = "Sizes of the mechanisms (8,32,128)"},
    {.name = "urdf", .key = KEY_URDF, .arg = "FILE", .doc = "A robot; may be repeated"},
    {.name = "base", .key = KEY_BASE, .arg = "fixed|floating", .doc = "Of the robots (fixed)"},
    {.name = "methods",
     .key = 'M',
     .arg = "METHOD,...",
     .doc = "Methods and peers (all of the ops)"},
    {.name = "op",
     .key = KEY_OP,
     .arg = "forward_dynamics|operational_inertia,...",
     .doc = "Answers (forward_dynamics)"},
    {.name = "tip",
     .key = KEY_TIP,
     .arg = "LINK",
     .doc = "Link of operational_inertia (the one behind most joints)"},
    {.name = "rhs", .key = KEY_RHS, .arg = "qdd|tau|gravity,...", .doc = "Right-hand sides (all)"},
    {.name = "refine", .key = KEY_REFINE, .arg = "0|1|2,...", .doc = "Refinement steps (0,1)"},
    {.name = "precision",
     .key = KEY_PRECISION,
     .arg = "f64|f32|f32+f64|f64+f128|f128,...",
     .doc = "Arithmetic (f64)"},
    {.name = "threads",
     .key = KEY_THREADS,
     .arg = "N,...",
     .doc = "Numbers of threads; more than 1: on a pool (1)"},
    {.name = "strategies",
     .key = KEY_STRATEGIES,
     .arg = "single|batch|specialised|specialised-batch,...",
     .doc = "States of a request and code (single; with more than one thread batch)"},
    {.name = "kernels",
     .key = KEY_KERNELS,
     .arg = "FOLDER",
     .doc = "Where `totalforce specialise` put kernels"},
    {.name = "turn",
     .key = KEY_TURN,
     .arg = "X",
     .doc = "Joint angles within +-X rad (0.001 for mechanisms, 3 for robots)"},
    {.name = "states", .key = KEY_STATES, .arg = "N", .doc = "Random states of each seed (3)"},
    {.name = "seed", .key = 's', .arg = "N", .doc = "Of the random numbers (1)"},
    {.name = "seeds",
     .key = KEY_SEEDS,
     .arg = "N",
     .doc = "Seeds for each row, from --seed on: other mechanisms and states (3)"},
    {.name = "budget-ms", .key = KEY_BUDGET, .arg = "N", .doc = "CPU time for timing one row (20)"},
    {.name = "json", .key = KEY_JSON, .doc = "JSON, one row a line, in place of CSV"},
    {.name = "html",
     .key = KEY_HTML,
     .arg = "FILE",
     .doc = "Write a self-contained page there: pictures, numbers under the pointer, filters"},
    {.name = "output", .key = 'o', .arg = "FOLDER", .doc = "Write chart.csv, SVG and PNG there"},
    {.name = "scripts",
     .key = KEY_SCRIPTS,
     .arg = "FOLDER",
     .doc = "The gnuplot scripts (those "
            "installed with the program)"},
    {0}};

static void parse_mechanism(struct argp_state *state, char *word)
{
    chart_options *o = state->input;
    if (o->target_count == CHART_CASES)
        argp_error(state, "--mechanisms: more than %d mechanisms and robots", CHART_CASES);
    char name[32];
    const char *colon = strchr(word, ':');
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, ":"), word);
    int kind = mechanism_find(name);
    if (kind < 0)
        argp_error(state, "--mechanisms: no '%s'; `totalforce chain --help` lists them", name);
    double value = colon ? option_double(state, "mechanisms", colon + 1) : 0.0;
    if (colon && !(value > 0.0))
        argp_error(state, "--mechanisms: %s: the number must be positive", word);
    o->targets[o->target_count++] =
        (chart_target){.label = word, .kind = (mechanism_kind)kind, .value = value};
}

uint32_t chart_read_size(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_unsigned(state, name, word, 1, MECHANISM_BODIES_MAX);
}

uint32_t chart_read_precision(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_word(state, name, word, chart_precision_words, CHART_PRECISION_COUNT);
}

static uint32_t read_method(struct argp_state *state, const char *name, const char *word)
{
    const int32_t method = chart_method_find(word);
    if (method < 0)
        argp_error(state, "--%s: no '%s'", name, word);
    return (uint32_t)method;
}

static uint32_t read_threads(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_unsigned(state, name, word, 1, 256);
}

static uint32_t read_strategy(struct argp_state *state, const char *name, const char *word)
{
    return (uint32_t)option_word(state, name, word, chart_strategy_words, CHART_STRATEGY_COUNT);
}

static void parse_file(struct argp_state *state, const char *file)
{
    chart_options *o = state->input;
    if (o->target_count == CHART_CASES)
        argp_error(state, "--urdf: more than %d mechanisms and robots", CHART_CASES);
    o->targets[o->target_count++] = (chart_target){.label = file, .file = file};
}

static void all_mechanisms(chart_options *o)
{
    for (int i = 0; i < MECHANISM_COUNT; i++)
        o->targets[i] =
            (chart_target){.label = mechanism_name((mechanism_kind)i), .kind = (mechanism_kind)i};
    o->target_count = MECHANISM_COUNT;
}

/* Whether the method answers one of the ops */
static int is_of_ops(const chart_options *o, uint32_t method)
{
    for (uint32_t op = 0; op < CHART_OP_COUNT; op++)
        if (o->ops >> op & 1u && chart_op_answered(op, method, CHART_F64))
            return 1;
    return 0;
}

/* All methods of the ops, and the peers of this build. */
static void all_methods(chart_options *o)
{
    for (uint32_t method = TFA_METHOD_AUTO + 1; tfa_method_describe(method); method++)
        if (is_of_ops(o, method))
            o->methods[o->method_count++] = method;
    for (uint32_t k = 0; peer_table[k]; k++)
        if (is_of_ops(o, CHART_PEER + k))
            o->methods[o->method_count++] = CHART_PEER + k;
}

static void complete(chart_options *o)
{
    static const uint32_t sizes[] = {8, 32, 128};
    if (o->target_count == 0)
        all_mechanisms(o);
    if (o->size_count == 0) {
        memcpy(o->sizes, sizes, sizeof sizes);
        o->size_count = sizeof sizes / sizeof *sizes;
    }
    o->ops = o->ops ? o->ops : 1u << CHART_FORWARD;
    if (o->method_count == 0)
        all_methods(o);
    if (o->precision_count == 0)
        o->precisions[o->precision_count++] = CHART_F64;
    if (o->thread_count == 0)
        o->threads[o->thread_count++] = 1;
    o->rhs = o->rhs ? o->rhs : (1u << CHART_RHS_COUNT) - 1;
    o->refine = o->refine ? o->refine : 3;
    if (o->budget == 0)
        o->budget = 20;
}

/* Combinations that cannot be charted */
static void check(struct argp_state *state, const chart_options *o)
{
    for (uint32_t k = 0; k < o->precision_count; k++) {
        const uint32_t p = o->precisions[k];
        if (chart_precisions[p].residual != TFA_RESIDUAL_SAME && o->refine == 1)
            argp_error(state, "--precision %s needs --refine 1 or 2", chart_precision_words[p]);
    }
    for (uint32_t m = 0; m < o->method_count; m++)
        if (!is_of_ops(o, o->methods[m]))
            argp_error(state, "--methods: %s answers none of --op",
                       chart_method_name(o->methods[m]));
    for (uint32_t k = 0; k < o->strategy_count; k++)
        if (chart_is_specialised(o->strategies[k]) && !o->kernels)
            argp_error(state, "--strategies %s needs --kernels FOLDER",
                       chart_strategy_words[o->strategies[k]]);
}

static error_t parse_list(int key, char *text, struct argp_state *state)
{
    static const char *const refine_words[CHART_REFINE] = {"0", "1", "2"};
    chart_options *o = state->input;
    const option_list sizes = {o->sizes, &o->size_count, CHART_SIZES};
    const option_list methods = {o->methods, &o->method_count, CHART_METHODS};
    const option_list precisions = {o->precisions, &o->precision_count, CHART_PRECISION_COUNT};
    const option_list threads = {o->threads, &o->thread_count, CHART_THREADS};
    const option_list strategies = {o->strategies, &o->strategy_count, CHART_STRATEGY_COUNT};
    switch (key) {
    case 'm':
        for_each_word(state, text, parse_mechanism);
        return 0;
    case 'n':
        option_list_read(state, "bodies", text, sizes, chart_read_size);
        return 0;
    case 'M':
        option_list_read(state, "methods", text, methods, read_method);
        return 0;
    case KEY_OP:
        o->ops |= option_words(state, "op", text, chart_op_words, CHART_OP_COUNT);
        return 0;
    case KEY_RHS:
        o->rhs |= option_words(state, "rhs", text, chart_rhs_words, CHART_RHS_COUNT);
        return 0;
    case KEY_REFINE:
        o->refine |= option_words(state, "refine", text, refine_words, CHART_REFINE);
        return 0;
    case KEY_PRECISION:
        option_list_read(state, "precision", text, precisions, chart_read_precision);
        return 0;
    case KEY_THREADS:
        option_list_read(state, "threads", text, threads, read_threads);
        return 0;
    case KEY_STRATEGIES:
        option_list_read(state, "strategies", text, strategies, read_strategy);
        return 0;
    case KEY_URDF:
        parse_file(state, text);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse_number(int key, char *text, struct argp_state *state)
{
    chart_options *o = state->input;
    switch (key) {
    case KEY_STATES:
        o->states = (uint32_t)option_unsigned(state, "states", text, 2, CHART_STATES);
        return 0;
    case KEY_SEEDS:
        o->seeds = (uint32_t)option_unsigned(state, "seeds", text, 1, CHART_SEEDS);
        return 0;
    case KEY_BUDGET:
        o->budget = (uint32_t)option_unsigned(state, "budget-ms", text, 1, 100000);
        return 0;
    case KEY_TURN:
        o->turn = option_positive(state, "turn", text, 1e3);
        return 0;
    case 's':
        o->seed = option_unsigned(state, "seed", text, 0, UINT64_MAX);
        return 0;
    default:
        return parse_list(key, text, state);
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    chart_options *o = state->input;
    switch (key) {
    case KEY_BASE:
        o->base = (tfa_base)option_enum(state, "base", text, TFA_WORDS_BASE);
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
    case KEY_TIP:
        o->tip = text;
        return 0;
    case KEY_SCRIPTS:
        o->scripts = text;
        return 0;
    case KEY_KERNELS:
        o->kernels = text;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "one argument too many: '%s'", text);
        return 0;
    case ARGP_KEY_END:
        complete(o);
        check(state, o);
        return 0;
    default:
        return parse_number(key, text, state);
    }
}

#define CHART_OP_HELP(name, word, op, what) "  " word ": " what "\n"
#define CHART_RHS_HELP(name, word, what) "  " word ": " what "\n"
#define CHART_PRECISION_HELP(name, word, precision, residual, what) "  " word ": " what "\n"
#define CHART_STRATEGY_HELP(name, word, batch, specialised, what) "  " word ": " what "\n"

/* clang-format off */
static const char documentation[] =
    "Charts accuracy against speed: every method on every mechanism, size, right-hand side and "
    "number of refinement steps, against quadruple precision.\v"
    "Ops:\n"
    CHART_OP_LIST(CHART_OP_HELP)
    "\nRight-hand sides of forward dynamics:\n"
    CHART_RHS_LIST(CHART_RHS_HELP)
    "\nPrecisions:\n"
    CHART_PRECISION_LIST(CHART_PRECISION_HELP)
    "\nStrategies:\n"
    CHART_STRATEGY_LIST(CHART_STRATEGY_HELP)
    "\nTimes are CPU times of this thread for one state, medians, taken in turns with aba in f64; "
    "with more than one thread wall times. The floor is the change of "
    "the exact answer when each number of the robot and the request changes in its last bit and "
    "sines and cosines are rounded to double.";
/* clang-format on */

/* Methods of any op, then the peers of this build */
static const char *method_word(size_t index)
{
    const chart_options all = {.ops = (1u << CHART_OP_COUNT) - 1};
    size_t count = 0;
    for (uint32_t method = TFA_METHOD_AUTO + 1; tfa_method_describe(method); method++)
        if (is_of_ops(&all, method) && count++ == index)
            return tfa_method_name(method);
    for (size_t k = 0; peer_table[k]; k++)
        if (k == index - count)
            return peer_table[k]->name;
    return NULL;
}

int chart_parse(int argc, char **argv, chart_options *options)
{
    static const command_line_values values[] = {
        {"METHOD", method_word}, {"MECHANISM", mechanism_word}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .doc = documentation,
    };
    *options =
        (chart_options){.states = 3, .seeds = 3, .seed = 1, .command = join_arguments(argc, argv)};
    return options->command ? command_line_parse(&argp, values, argc, argv, options) : ENOMEM;
}
