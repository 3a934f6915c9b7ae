/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce model`: report of a loaded URDF.
 */
#include "advise.h"
#include "command_line/command_line.h"
#include "common/commands.h"
#include "model_report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/specialised.h>

typedef struct model_options {
    const char *file;
    scene_options scene;
    const char *kernels; /* folder */
    const char *states;  /* file */
    double tolerance;
    int json, tree, notes;
} model_options;

enum { KEY_JSON = 256, KEY_KERNELS, KEY_TREE, KEY_NOTES, KEY_ADVISE, KEY_TOLERANCE };

static const struct argp_option option_table[] = {
    {.name = "json", .key = KEY_JSON, .doc = "Print the report as JSON"},
    {.name = "tree",
     .key = KEY_TREE,
     .doc = "Draw the robot: bodies with the joints that move them, masses, [links fixed to them]"},
    {.name = "notes",
     .key = KEY_NOTES,
     .doc = "Print the notes - what of the file is not used - and not only their number"},
    {.name = "kernels",
     .key = KEY_KERNELS,
     .arg = "FOLDER",
     .doc = "Where `totalforce specialise` put kernels: say which one the robot runs on"},
    {.name = "advise",
     .key = KEY_ADVISE,
     .arg = "STATES.jsonl",
     .doc = "Say which joints a scene may lock in these states (lines of `totalforce solve`: "
            "forward_dynamics with q, v, tau; -: standard input), and print the scene as a "
            "configuration of totalforced; exit status 1 if none"},
    {.name = "tolerance",
     .key = KEY_TOLERANCE,
     .arg = "T",
     .doc = "Largest error for that, relative, in the energy norm of the accelerations"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    model_options *options = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &options->scene;
        return 0;
    case KEY_JSON:
        options->json = 1;
        return 0;
    case KEY_TREE:
        options->tree = 1;
        return 0;
    case KEY_NOTES:
        options->notes = 1;
        return 0;
    case KEY_KERNELS:
        options->kernels = text;
        return 0;
    case KEY_ADVISE:
        options->states = text;
        return 0;
    case KEY_TOLERANCE:
        options->tolerance = option_positive(state, "tolerance", text, INFINITY);
        return 0;
    case ARGP_KEY_END:
        if (options->json + options->tree + (options->states != NULL) > 1)
            argp_error(state, "--json, --tree and --advise: choose one");
        if (!options->states != !(options->tolerance > 0))
            argp_error(state, "--advise and --tolerance go together");
        if (options->states && options->scene.model.mimic == TFA_MIMIC_LOCK)
            argp_error(state, "--advise: with --mimic lock a lock on a joint moves its followers; "
                              "choose free or project");
        if (options->states && options->file && strcmp(options->file, "-") == 0)
            argp_error(state, "--advise: the scene names the URDF; give a file instead of -");
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &options->file, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which URDF file?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Which kernel answers, and why not the specialised one */
static void describe_kernel(const model_options *options, const tfa_model *model, char *text,
                            size_t size)
{
    char error_text[512];
    tfa_specialised *specialised = NULL;
    snprintf(text, size, "generic");
    if (!options->kernels || !model)
        return;
    const int status =
        tfa_specialised_find(options->kernels, model, &specialised, error_text, sizeof error_text);
    if (status != TFA_OK)
        snprintf(text, size, "generic: %s", error_text[0] ? error_text : tfa_status_text(status));
    if (!specialised)
        return;
    const tfa_specialised_info info = tfa_specialised_describe(specialised);
    snprintf(text, size, "specialised: %s, %u states at a time, within %.2g of the generic one, %s",
             info.path, info.lanes ? info.lanes : 1, info.error, info.compiler);
    tfa_specialised_free(specialised);
}

/* One line for all notes, unless they are printed */
static void print_note_count(const model_options *options, const tfa_report *report)
{
    size_t notes = 0;
    for (size_t k = 0; k < report->count; k++)
        notes += report->messages[k].severity == TFA_NOTE;
    if (notes > 0 && !options->json && !options->notes && !options->states)
        fprintf(stderr, "%s: %zu note%s, shown with --notes\n", report->file, notes,
                notes == 1 ? "" : "s");
}

/* @return an exit status */
static int print_report(const model_options *options, const tfa_report *messages,
                        const tfa_model *model)
{
    model_report report;
    int failed = 0;
    char kernel[1024];
    int status = model_report_init(&report, options->file, &options->scene, messages, model);
    describe_kernel(options, model, kernel, sizeof kernel);
    report.kernel = kernel;
    if (status != TFA_OK)
        fprintf(stderr, "totalforce model: %s\n", tfa_status_text(status));
    else if (options->json)
        failed = model_report_print_json(&report);
    else if (model && options->tree)
        failed = model_report_print_tree(&report);
    else if (model)
        failed = model_report_print_text(&report);
    if (model && status == TFA_OK && !options->json)
        model_loops_warn(model, &report.loops, options->file);
    if (fflush(stdout) != 0 || failed) {
        perror("totalforce model: standard output");
        failed = 1;
    }
    model_report_free(&report);
    return model && status == TFA_OK && !failed ? EXIT_GOOD : EXIT_FAILED;
}

int command_model(int argc, char **argv)
{
    static const struct argp_child children[] = {{.argp = &scene_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "FILE.urdf",
        .doc = "Loads a URDF (-: standard input) and reports the result: bodies before and "
               "after, masses, what "
               "was merged, locked, fused, left out or repaired, how well each inertia can be "
               "inverted, the order of the joints, the plan.\v"
               "Errors, warnings and (--notes) notes go to standard error as FILE:LINE: severity: "
               "text; with --json all of them are in \"messages\" instead.",
        .children = children};
    model_options options = {0};
    error_t error = command_line_parse(&argp, NULL, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce model: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    tfa_report report = {0};
    tfa_model *model = load_scene(options.file, &options.scene,
                                  options.json    ? (tfa_severity)(TFA_ERROR + 1)
                                  : options.notes ? TFA_NOTE
                                                  : TFA_WARNING,
                                  &report);
    print_note_count(&options, &report);
    int result;
    if (!options.states)
        result = print_report(&options, &report, model);
    else if (model)
        result =
            advise_locks(model, options.file, &options.scene, options.states, options.tolerance);
    else
        result = EXIT_FAILED;
    tfa_report_free(&report);
    tfa_model_free(model);
    scene_options_free(&options.scene);
    return result;
}
