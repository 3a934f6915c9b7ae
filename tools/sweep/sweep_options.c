/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The command line of `totalforce sweep`.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/suggest.h"
#include "sweep.h"

#include <math.h>
#include <string.h>

enum {
    KEY_OP = 256,
    KEY_PRECISION,
    KEY_RESIDUAL,
    KEY_ESTIMATE,
    KEY_REFINE,
    KEY_TIPS,
    KEY_STATES,
    KEY_OFFSET,
    KEY_VELOCITY,
    KEY_TORQUE,
    KEY_ACCELERATION,
    KEY_BLOCK,
    KEY_PART,
    KEY_RESUME,
    KEY_MERGE,
    KEY_OUT,
    KEY_OUT_STATES,
    KEY_REFERENCE,
    KEY_EXPECT,
    KEY_JSON,
    KEY_QUIET,
};

static const struct argp_option option_table[] = {
    {.doc = "What is computed:"},
    {.name = "op", .key = KEY_OP, .arg = "OP", .doc = "Operation (forward_dynamics)"},
    {.name = "method", .key = 'm', .arg = "METHOD", .doc = "Method (auto)"},
    {.name = "precision",
     .key = KEY_PRECISION,
     .arg = "f64|f128|f32",
     .doc = "Arithmetic of the factors (f64)"},
    {.name = "residual",
     .key = KEY_RESIDUAL,
     .arg = "same|f64|f128",
     .doc = "Arithmetic of refinement (same)"},
    {.name = "estimate",
     .key = KEY_ESTIMATE,
     .arg = "default|never|always",
     .doc = "Error estimates (default: where the sentinel trips)"},
    {.name = "refine", .key = KEY_REFINE, .arg = "0|1|2|3", .doc = "Refinement steps (default)"},
    {.name = "tips",
     .key = KEY_TIPS,
     .arg = "LINK,...",
     .doc = "Links of operational_inertia, in this order"},
    {.doc = "States:"},
    {.name = "count", .key = 'n', .arg = "N", .doc = "How many (of a file: all)"},
    {.name = "seed", .key = 's', .arg = "N", .doc = "Of the drawn states (1)"},
    {.name = "offset", .key = KEY_OFFSET, .arg = "N", .doc = "Number of the first state (0)"},
    {.name = "states",
     .key = KEY_STATES,
     .arg = "FILE",
     .doc = "Read them from this file of little-endian doubles, see docs/sweep.md"},
    {.name = "velocity",
     .key = KEY_VELOCITY,
     .arg = "X",
     .doc = "Drawn velocities are within -X..X (1)"},
    {.name = "torque",
     .key = KEY_TORQUE,
     .arg = "X",
     .doc = "Drawn torques and forces are within -X..X (1)"},
    {.name = "acceleration",
     .key = KEY_ACCELERATION,
     .arg = "X",
     .doc = "Drawn accelerations of inverse_dynamics are within -X..X (1)"},
    {.doc = "Work:"},
    {.name = "threads",
     .key = 't',
     .arg = "N",
     .doc = "Of each rank (one for each processor that it may use)"},
    {.name = "block",
     .key = KEY_BLOCK,
     .arg = "N",
     .doc = "States of a block, a multiple of 512 (65536)"},
    {.name = "resume",
     .key = KEY_RESUME,
     .arg = "FILE",
     .doc = "Keep finished blocks in FILE.0, FILE.1, ..., and compute the others only"},
    {.name = "part",
     .key = KEY_PART,
     .arg = "I/N",
     .doc = "Only the blocks of part I of N; needs --resume"},
    {.name = "merge",
     .key = KEY_MERGE,
     .doc = "Compute nothing: the statistics of the blocks of --resume"},
    {.doc = "Results:"},
    {.name = "out",
     .key = KEY_OUT,
     .arg = "FILE",
     .doc = "Write the answers there, little-endian doubles"},
    {.name = "out-states", .key = KEY_OUT_STATES, .arg = "FILE", .doc = "Write the states there"},
    {.name = "reference",
     .key = KEY_REFERENCE,
     .arg = "N",
     .doc = "Compare every N-th state with quadruple precision"},
    {.name = "expect-error",
     .key = KEY_EXPECT,
     .arg = "X",
     .doc = "Exit status 1 if a state fails, or an error (without --reference: an estimate) is "
            "above X"},
    {.name = "json", .key = KEY_JSON, .doc = "JSON in place of a table"},
    {.name = "quiet", .key = KEY_QUIET, .doc = "No progress and no rate on standard error"},
    {0}};

/* Words of the ops that it computes: the first ones */
static const char *const *op_words(void)
{
    uint32_t count;
    return tfa_word_list(TFA_WORDS_OP, &count) + TFA_OP_FORWARD_DYNAMICS;
}

static uint32_t small_number(struct argp_state *state, const char *name, const char *text,
                             uint32_t lowest, uint32_t highest)
{
    return (uint32_t)option_unsigned(state, name, text, lowest, highest);
}

static void parse_part(struct argp_state *state, sweep_options *o, char *text)
{
    char *slash = strchr(text, '/');
    if (!slash)
        argp_error(state, "--part: '%s' is not I/N, such as 1/8", text);
    *slash = '\0';
    o->parts = small_number(state, "part", slash + 1, 1, SWEEP_PARTS_MAX);
    o->part = small_number(state, "part", text, 1, o->parts);
    *slash = '/';
}

static void parse_block(struct argp_state *state, sweep_options *o, const char *text)
{
    o->block = small_number(state, "block", text, STATISTICS_GROUP, SWEEP_BLOCK_MAX);
    if (o->block % STATISTICS_GROUP)
        argp_error(state, "--block: %s is not a multiple of %d", text, STATISTICS_GROUP);
}

static void check_states(struct argp_state *state, const sweep_options *o)
{
    if (!o->file)
        argp_error(state, "which URDF file?");
    if (!o->count && !o->states)
        argp_error(state, "how many states? --count N");
    if (o->count > UINT64_MAX / 4 || o->offset > UINT64_MAX / 4)
        argp_error(state, "--count and --offset: at most 2^62 states");
    if (o->count / o->block >= SWEEP_BLOCKS_MAX)
        argp_error(state, "--count: more than 2^30 blocks of %u states: --block %d", o->block,
                   SWEEP_BLOCK_MAX);
}

static void check(struct argp_state *state, const sweep_options *o)
{
    const tfa_method_info *info = tfa_method_describe(o->method);
    check_states(state, o);
    if (!(info->ops & TFA_OP_BIT(o->op)))
        argp_error(state, "--method: %s does not answer %s; `totalforce methods` lists who does",
                   info->name, tfa_word(TFA_WORDS_OP, o->op));
    if (o->op == TFA_OP_OPERATIONAL_INERTIA && !o->tips)
        argp_error(state, "operational_inertia of which links? --tips LINK,...");
    if (o->op != TFA_OP_OPERATIONAL_INERTIA && o->tips)
        argp_error(state, "--tips: %s has none", tfa_word(TFA_WORDS_OP, o->op));
    if (o->workspace.precision == TFA_F128 && o->workspace.residual == TFA_RESIDUAL_F64)
        argp_error(state, "--residual f64: narrower than --precision f128");
    if ((o->parts || o->merge) && !o->resume)
        argp_error(state, "%s: finished blocks are kept in a file: --resume FILE",
                   o->parts ? "--part" : "--merge");
    if (o->parts && o->merge)
        argp_error(state, "--merge: takes all parts, not --part %u/%u", o->part, o->parts);
}

static error_t parse_work(int key, char *text, struct argp_state *state)
{
    sweep_options *o = state->input;
    switch (key) {
    case 't':
        o->threads = small_number(state, "threads", text, 1, SWEEP_THREADS_MAX);
        return 0;
    case KEY_BLOCK:
        parse_block(state, o, text);
        return 0;
    case KEY_PART:
        parse_part(state, o, text);
        return 0;
    case KEY_RESUME:
        o->resume = text;
        return 0;
    case KEY_MERGE:
        o->merge = 1;
        return 0;
    case KEY_OUT:
        o->out = text;
        return 0;
    case KEY_OUT_STATES:
        o->out_states = text;
        return 0;
    case KEY_REFERENCE:
        o->reference = option_unsigned(state, "reference", text, 1, UINT64_MAX);
        return 0;
    case KEY_EXPECT:
        o->expect_error = option_positive(state, "expect-error", text, INFINITY);
        return 0;
    case KEY_JSON:
        o->json = 1;
        return 0;
    case KEY_QUIET:
        o->quiet = 1;
        return 0;
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &o->scene;
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &o->file, text);
        return 0;
    case ARGP_KEY_END:
        check(state, o);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse_states(int key, char *text, struct argp_state *state)
{
    sweep_options *o = state->input;
    switch (key) {
    case 'n':
        o->count = option_unsigned(state, "count", text, 1, UINT64_MAX);
        return 0;
    case 's':
        o->seed = option_unsigned(state, "seed", text, 0, UINT64_MAX);
        return 0;
    case KEY_OFFSET:
        o->offset = option_unsigned(state, "offset", text, 0, UINT64_MAX);
        return 0;
    case KEY_STATES:
        o->states = text;
        return 0;
    case KEY_VELOCITY:
        o->ranges.velocity = option_positive(state, "velocity", text, INFINITY);
        return 0;
    case KEY_TORQUE:
        o->ranges.force = option_positive(state, "torque", text, INFINITY);
        return 0;
    case KEY_ACCELERATION:
        o->ranges.acceleration = option_positive(state, "acceleration", text, INFINITY);
        return 0;
    default:
        return parse_work(key, text, state);
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    sweep_options *o = state->input;
    switch (key) {
    case KEY_OP:
        o->op = (tfa_op)(option_word(state, "op", text, op_words(), TFA_OP_MASS_MATRIX) + 1);
        return 0;
    case 'm':
        o->method = option_method(state, text);
        return 0;
    case KEY_PRECISION:
        o->workspace.precision =
            (tfa_precision)option_enum(state, "precision", text, TFA_WORDS_PRECISION);
        return 0;
    case KEY_RESIDUAL:
        o->workspace.residual =
            (tfa_residual)option_enum(state, "residual", text, TFA_WORDS_RESIDUAL);
        return 0;
    case KEY_ESTIMATE:
        o->estimate = (tfa_estimate)option_enum(state, "estimate", text, TFA_WORDS_ESTIMATE);
        return 0;
    case KEY_REFINE:
        o->refine = small_number(state, "refine", text, 0, TFA_MAX_REFINE);
        return 0;
    case KEY_TIPS:
        o->tips = text;
        return 0;
    default:
        return parse_states(key, text, state);
    }
}

static const char documentation[] =
    "Computes one operation of a robot for many states, and their statistics. The states are drawn "
    "from a seed or read from a file. Statistics and answers have the same bits for any number of "
    "threads, parts and ranks.\v"
    "Operations: forward_dynamics, inverse_dynamics, operational_inertia, mass_matrix.\n\n"
    "On several machines: `mpirun -n 8 totalforce sweep ...`, or srun; without MPI --part I/N "
    "--resume FILE on each, then the same command with --merge.\n\n"
    "Statistics are printed on standard output; progress and rate on standard error. Exit status "
    "1: --expect-error does not hold, or blocks are missing.";

/* For command_line_values. */
static const char *op_word(size_t index)
{
    return index < TFA_OP_MASS_MATRIX ? op_words()[index] : NULL;
}

int sweep_parse(int argc, char **argv, sweep_options *options)
{
    static const command_line_values values[] = {{"METHOD", suggest_method}, {"OP", op_word}, {0}};
    static const struct argp_child children[] = {{.argp = &scene_argp}, {0}};
    static const struct argp argp = {.options = option_table,
                                     .parser = parse,
                                     .args_doc = "FILE.urdf",
                                     .doc = documentation,
                                     .children = children};
    *options = (sweep_options){.op = TFA_OP_FORWARD_DYNAMICS,
                               .refine = TFA_REFINE_DEFAULT,
                               .seed = 1,
                               .block = SWEEP_BLOCK,
                               .ranges = {1, 1, 1},
                               .workspace = {.methods = 0}};
    return command_line_parse(&argp, values, argc, argv, options);
}
