/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The command line of `totalforce drift`.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"
#include "drift.h"

#include <errno.h>
#include <string.h>

enum {
    KEY_URDF = 256,
    KEY_PRECISION,
    KEY_STEP,
    KEY_INTEGRATOR,
    KEY_REFINE,
    KEY_SECONDS,
    KEY_SAMPLES,
    KEY_TURN,
    KEY_SCRIPTS
};

static const struct argp_option option_table[] = {
    {.name = "urdf", .key = KEY_URDF, .arg = "FILE", .doc = "A robot on a fixed base"},
    {.name = "mechanism", .key = 'm', .arg = "MECHANISM", .doc = "In place of a robot (random)"},
    {.name = "bodies", .key = 'n', .arg = "N", .doc = "Of the mechanism (8)"},
    {.name = "methods", .key = 'M', .arg = "METHOD,...", .doc = "Of forward dynamics (aba)"},
    {.name = "precision",
     .key = KEY_PRECISION,
     .arg = "f64|f32|f32+f64|f64+f128|f128,...",
     .doc = "Arithmetic of the accelerations (f64)"},
    {.name = "step", .key = KEY_STEP, .arg = "S,...", .doc = "Steps in seconds (0.001)"},
    {.name = "integrator", .key = KEY_INTEGRATOR, .arg = "euler|rk4|gbs8", .doc = "(gbs8)"},
    {.name = "refine", .key = KEY_REFINE, .arg = "0|1|2", .doc = "Refinement steps (0; mixed: 1)"},
    {.name = "seconds", .key = KEY_SECONDS, .arg = "S", .doc = "Simulated time (10)"},
    {.name = "samples", .key = KEY_SAMPLES, .arg = "N", .doc = "Energies of each line (100)"},
    {.name = "turn",
     .key = KEY_TURN,
     .arg = "X",
     .doc = "Joint angles at the start within +-X rad (1 for mechanisms, 3 for robots)"},
    {.name = "seed", .key = 's', .arg = "N", .doc = "Of the random numbers (1)"},
    {.name = "output", .key = 'o', .arg = "FOLDER", .doc = "Write drift.csv, SVG and PNG there"},
    {.name = "scripts",
     .key = KEY_SCRIPTS,
     .arg = "FOLDER",
     .doc = "The gnuplot scripts (those installed with the program)"},
    {0}};

static void parse_steps(struct argp_state *state, drift_options *o, const char *text)
{
    o->step_count +=
        option_numbers(state, "step", text, o->steps + o->step_count, DRIFT_STEPS - o->step_count);
    for (uint32_t k = 0; k < o->step_count; k++)
        if (!(o->steps[k] > 0.0 && o->steps[k] <= 10.0))
            argp_error(state, "--step: %g, must be above 0 and at most 10", o->steps[k]);
}

static void parse_mechanism(struct argp_state *state, const char *word)
{
    drift_options *o = state->input;
    const int kind = mechanism_find(word);
    if (kind < 0)
        argp_error(state, "--mechanism: no '%s'; `totalforce chain --help` lists them", word);
    o->target = (chart_target){.label = word, .kind = (mechanism_kind)kind};
}

static void complete(struct argp_state *state, drift_options *o)
{
    if (!o->target.label)
        o->target =
            (chart_target){.label = mechanism_name(MECHANISM_RANDOM), .kind = MECHANISM_RANDOM};
    if (o->method_count == 0)
        o->methods[o->method_count++] = TFA_METHOD_ABA;
    if (o->precision_count == 0)
        o->precisions[o->precision_count++] = CHART_F64;
    if (o->step_count == 0)
        o->steps[o->step_count++] = 1e-3;
    if (o->turn == 0.0)
        o->turn = o->target.file ? 3.0 : 1.0;
    for (uint32_t k = 0; k < o->step_count; k++)
        if (o->steps[k] * o->samples > o->seconds * (1.0 + 1e-9))
            argp_error(state,
                       "--step: %g s are less than %u steps in %g s; --samples says how "
                       "many energies",
                       o->steps[k], o->samples, o->seconds);
}

static error_t parse_number(int key, char *text, struct argp_state *state)
{
    drift_options *o = state->input;
    switch (key) {
    case 'n':
        o->bodies = chart_read_size(state, "bodies", text);
        return 0;
    case KEY_REFINE:
        o->refine = (uint32_t)option_unsigned(state, "refine", text, 0, CHART_REFINE - 1);
        return 0;
    case KEY_SECONDS:
        o->seconds = option_positive(state, "seconds", text, 1e6);
        return 0;
    case KEY_SAMPLES:
        o->samples = (uint32_t)option_unsigned(state, "samples", text, 1, 100000);
        return 0;
    case KEY_TURN:
        o->turn = option_positive(state, "turn", text, 1e3);
        return 0;
    case 's':
        o->seed = option_unsigned(state, "seed", text, 0, UINT64_MAX);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    drift_options *o = state->input;
    const option_list methods = {o->methods, &o->method_count, CHART_METHODS};
    const option_list precisions = {o->precisions, &o->precision_count, CHART_PRECISION_COUNT};
    switch (key) {
    case KEY_URDF:
        o->target = (chart_target){.label = text, .file = text};
        return 0;
    case 'm':
        parse_mechanism(state, text);
        return 0;
    case 'M':
        option_list_read(state, "methods", text, methods, option_forward_method);
        return 0;
    case KEY_PRECISION:
        option_list_read(state, "precision", text, precisions, chart_read_precision);
        return 0;
    case KEY_STEP:
        parse_steps(state, o, text);
        return 0;
    case KEY_INTEGRATOR:
        o->integrator = (drift_integrator)option_word(
            state, "integrator", text, drift_integrator_words, DRIFT_INTEGRATOR_COUNT);
        return 0;
    case 'o':
        o->folder = text;
        return 0;
    case KEY_SCRIPTS:
        o->scripts = text;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "one argument too many: '%s'", text);
        return 0;
    case ARGP_KEY_END:
        complete(state, o);
        return 0;
    default:
        return parse_number(key, text, state);
    }
}

#define DRIFT_INTEGRATOR_HELP(name, word, what) "  " word ": " what "\n"

/* clang-format off */
static const char documentation[] =
    "Lets a robot swing freely - no torques, no friction, gravity on - and prints how its energy "
    "drifts: a line for each method, precision and step, and one with accelerations in quadruple "
    "precision, which is the error of the integrator alone.\v"
    "Integrators:\n"
    DRIFT_INTEGRATOR_LIST(DRIFT_INTEGRATOR_HELP)
    "\nErrors are relative to the kinetic energy of the start plus the weight of what moves times "
    "the distance of its centre of mass from the origin.";
/* clang-format on */

int drift_parse(int argc, char **argv, drift_options *options)
{
    static const command_line_values values[] = {
        {"METHOD", suggest_forward_method}, {"MECHANISM", mechanism_word}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .doc = documentation,
    };
    *options = (drift_options){.bodies = 8,
                               .integrator = DRIFT_GBS8,
                               .samples = 100,
                               .seconds = 10.0,
                               .seed = 1,
                               .command = join_arguments(argc, argv)};
    return options->command ? command_line_parse(&argp, values, argc, argv, options) : ENOMEM;
}
