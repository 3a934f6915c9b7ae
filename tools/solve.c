/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce solve`: answers JSON lines in process.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/scene_options.h"
#include "common/suggest.h"
#include "jsonl/jsonl_options.h"
#include "jsonl/jsonl_serve.h"

#include <stdio.h>
#include <string.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

typedef struct solve_options {
    const char *file;
    scene_options scene;
    tfa_workspace_options workspace;
    jsonl_options lines;
} solve_options;

enum { KEY_PRECISION = 256, KEY_RESIDUAL };

static const struct argp_option option_table[] = {
    {.name = "precision",
     .key = KEY_PRECISION,
     .arg = "f64|f128|f32",
     .doc = "Arithmetic of the factors (f64)"},
    {.name = "residual",
     .key = KEY_RESIDUAL,
     .arg = "same|f64|f128",
     .doc = "Arithmetic in which accelerations are refined and all else is answered (same)"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    solve_options *options = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &options->lines;
        state->child_inputs[1] = &options->scene;
        return 0;
    case KEY_PRECISION:
        options->workspace.precision =
            (tfa_precision)option_enum(state, "precision", text, TFA_WORDS_PRECISION);
        return 0;
    case KEY_RESIDUAL:
        options->workspace.residual =
            (tfa_residual)option_enum(state, "residual", text, TFA_WORDS_RESIDUAL);
        return 0;
    case ARGP_KEY_END:
        if (options->workspace.precision == TFA_F128 &&
            options->workspace.residual == TFA_RESIDUAL_F64)
            argp_error(state, "--residual f64: narrower than --precision f128");
        if (options->file && strcmp(options->file, "-") == 0 &&
            (!options->lines.file || strcmp(options->lines.file, "-") == 0))
            argp_error(state, "the robot comes from standard input: name the file of the requests, "
                              "totalforce solve - REQUESTS.jsonl");
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, options->file ? &options->lines.file : &options->file, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which URDF file?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* The library as a solver */
typedef struct solver {
    tfa_names names;
    tfa_workspace *workspace;
} solver;

static int prepare(void *self, const tfa_names **names, jsonl_error *error)
{
    (void)error;
    *names = &((solver *)self)->names;
    return TFA_OK;
}

static int solve_request(void *self, const tfa_request *request, tfa_reply *reply)
{
    return tfa_compute(((solver *)self)->workspace, request, reply);
}

static int solve_lines(const solve_options *options, const tfa_model *model)
{
    solver self = {0};
    int result = EXIT_FAILED;
    int status = tfa_names_of_model(&self.names, model);
    if (status == TFA_OK)
        status = tfa_workspace_create(model, &options->workspace, &self.workspace);
    if (status != TFA_OK)
        fprintf(stderr, "totalforce solve: %s: %s: %s\n", options->file, tfa_status_text(status),
                tfa_status_cause(status));
    else
        result =
            jsonl_run("totalforce solve", &options->lines,
                      &(jsonl_backend){.self = &self, .prepare = prepare, .answer = solve_request});
    tfa_workspace_free(self.workspace);
    tfa_names_free(&self.names);
    return result;
}

int command_solve(int argc, char **argv)
{
    static const command_line_values values[] = {{"METHOD", suggest_method}, {0}};
    static const struct argp_child children[] = {{.argp = &jsonl_argp}, {.argp = &scene_argp}, {0}};
    static const struct argp argp = {.options = option_table,
                                     .parser = parse_option,
                                     .args_doc = "FILE.urdf [REQUESTS.jsonl]",
                                     .doc = "Answers JSON lines, one reply a line, in order. "
                                            "Either file may be -, which is standard "
                                            "input: the default of the requests.\v" JSONL_HELP,
                                     .children = children};
    solve_options options = {
        .lines = JSONL_OPTIONS_DEFAULT,
        .workspace = {.methods = TFA_METHODS_ALL, .max_tips = TFA_MAX_TIPS},
    };
    error_t error = command_line_parse(&argp, values, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce solve: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    tfa_report report = {0};
    tfa_model *model = load_scene(options.file, &options.scene, TFA_WARNING, &report);
    int result = model ? solve_lines(&options, model) : EXIT_FAILED;
    tfa_model_free(model);
    tfa_report_free(&report);
    scene_options_free(&options.scene);
    return result;
}
