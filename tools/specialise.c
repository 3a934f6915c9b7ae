/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce specialise`: a kernel specialised for one robot, compiled and tested.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/progress.h"
#include "common/scene_options.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <totalforce/specialised.h>
#include <unistd.h>

typedef struct specialise_options {
    const char *file, *output;
    scene_options scene;
    tfa_specialise_options build;
} specialise_options;

enum { KEY_COMPILER = 256, KEY_SOURCES, KEY_LANES, KEY_TABLES, KEY_ALGORITHM };

static const struct argp_option option_table[] = {
    {.name = "output",
     .key = 'o',
     .arg = "FILE",
     .doc = "The shared object; in a folder it gets the name that the daemon looks for"},
    {.name = "lanes",
     .key = KEY_LANES,
     .arg = "auto|one",
     .doc = "auto: several states at a time, too; one: the smallest kernel (auto)"},
    {.name = "algorithm",
     .key = KEY_ALGORITHM,
     .arg = "fastest|aba|crba",
     .doc = "aba, crba, or fastest: timed for each kind of request in the build (fastest)"},
    {.name = "compiler", .key = KEY_COMPILER, .arg = "PROGRAM", .doc = "(clang, gcc or cc)"},
    {.name = "sources",
     .key = KEY_SOURCES,
     .arg = "FOLDER",
     .doc = "Sources of the kernels (those that came with this program)"},
    {.name = "tables", .key = KEY_TABLES, .doc = "Keep the generated tables beside it, as FILE.h"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    static const char *const lanes[] = {"auto", "one"};
    specialise_options *o = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &o->scene;
        return 0;
    case 'o':
        o->output = text;
        return 0;
    case KEY_LANES:
        o->build.single = (uint32_t)option_word(state, "lanes", text, lanes, 2);
        return 0;
    case KEY_ALGORITHM:
        o->build.algorithm =
            (tfa_specialise_algorithm)option_enum(state, "algorithm", text, TFA_WORDS_ALGORITHM);
        return 0;
    case KEY_COMPILER:
        o->build.compiler = text;
        return 0;
    case KEY_SOURCES:
        o->build.sources = text;
        return 0;
    case KEY_TABLES:
        o->build.keep_tables = 1;
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &o->file, text);
        return 0;
    case ARGP_KEY_END:
        if (!o->file)
            argp_error(state, "which URDF file?");
        if (!o->output)
            argp_error(state, "where to? -o FILE or -o FOLDER");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* The file itself, or the model's name in a folder. */
static char *output_path(const char *output, const tfa_model *model)
{
    char name[TFA_SPECIALISED_NAME_SIZE], *path = NULL;
    struct stat facts;
    if (stat(output, &facts) != 0 || !S_ISDIR(facts.st_mode))
        return strdup(output);
    tfa_specialised_name(model, name);
    return asprintf(&path, "%s/%s", output, name) < 0 ? NULL : path;
}

static double milliseconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* A line for each kind of request that has reasons, "forward crba (..), lambda .." */
static void print_algorithms(const char *text)
{
    for (const char *end; (end = strstr(text, "), ")); text = end + 3)
        printf("  %.*s\n", (int)(end + 1 - text), text);
    printf("  %s\n", text);
}

/* As the daemon will; a kernel whose answers are wrong does not stay. */
static int try_out(const char *path, const tfa_model *model)
{
    char error_text[512];
    tfa_specialised *kernel;
    const double start = milliseconds_now();
    const int status = tfa_specialised_load(path, model, &kernel, error_text, sizeof error_text);
    const double took = milliseconds_now() - start;
    if (status == TFA_OK) {
        const tfa_specialised_info info = tfa_specialised_describe(kernel);
        printf(
            "  loaded and tested in %.1f ms: within %.2g of the generic kernel, %s, %u states at a "
            "time\n",
            took, info.error, info.isa, info.lanes ? info.lanes : 1);
        if (info.lanes_f32)
            printf("  single precision: within %.2g, %u states at a time\n", info.error_f32,
                   info.lanes_f32);
        print_algorithms(info.algorithms);
        tfa_specialised_free(kernel);
        return EXIT_GOOD;
    }
    fflush(stdout);
    fprintf(stderr, "totalforce specialise: %s\n",
            error_text[0] ? error_text : tfa_status_text(status));
    if (status == TFA_E_REFUSED) {
        fprintf(stderr, "totalforce specialise: it is built, but cannot be loaded from there\n");
        return EXIT_UNMET;
    }
    unlink(path);
    return EXIT_FAILED;
}

/* The signal that ends the build: the compilers are in process groups of their own, and would go
 * on. */
static volatile int cancelled;

static void cancel(int number)
{
    cancelled = number;
}

/* tfa_specialised_build; a signal that would end the program does so once nothing is left behind */
static int build_or_end(const tfa_model *model, const tfa_specialise_options *options,
                        const char *path, tfa_specialise_result *result, char *error_text,
                        size_t size)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    enum { COUNT = sizeof numbers / sizeof *numbers };
    struct sigaction before[COUNT], action = {.sa_handler = cancel};
    for (int k = 0; k < COUNT; k++)
        if (sigaction(numbers[k], NULL, &before[k]) == 0 && before[k].sa_handler != SIG_IGN)
            sigaction(numbers[k], &action, NULL);
    const int status = tfa_specialised_build(model, options, path, result, error_text, size);
    progress_show(NULL, 0, 0, "");
    for (int k = 0; k < COUNT; k++)
        sigaction(numbers[k], &before[k], NULL);
    if (cancelled)
        raise(cancelled);
    return status;
}

static int build(specialise_options *o, const char *path, const tfa_model *model)
{
    char error_text[1024];
    tfa_specialise_result result;
    o->build.cancel = &cancelled;
    progress_show("kernels generated, compiled and timed", 0, 0, "");
    const int status = build_or_end(model, &o->build, path, &result, error_text, sizeof error_text);
    if (status != TFA_OK) {
        fprintf(stderr, "totalforce specialise: %s: %s\n", tfa_model_name(model),
                error_text[0] ? error_text : tfa_status_text(status));
        return EXIT_FAILED;
    }
    printf("%s\n  %s, model %.16s, %zu bytes, compiled in %.2f s by %s\n", path,
           tfa_model_name(model), tfa_model_hash_text(model), result.bytes, result.compile_s,
           result.compiler);
    return try_out(path, model);
}

int command_specialise(int argc, char **argv)
{
    static const struct argp_child children[] = {{.argp = &scene_argp}, {0}};
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "FILE.urdf -o FILE",
        .doc =
            "Compiles the kernels once more with the constants of one robot in them, into a shared "
            "object that the library and the daemon load by the hash of the model: forward "
            "dynamics, inverse dynamics, the mass matrix, Lambda^-1 of one tip, the first "
            "with the last, and derivatives.\v"
            "Takes the system's compiler. The options of the model are those of `totalforce "
            "model`: "
            "another base, scene or policy is another model with another kernel.",
        .children = children};
    specialise_options options = {0};
    error_t error = command_line_parse(&argp, NULL, argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce specialise: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    tfa_report report = {0};
    int result = EXIT_FAILED;
    /* changes by --snap are shown */
    const tfa_severity lowest = options.scene.model.snap > 0 ? TFA_NOTE : TFA_WARNING;
    tfa_model *model = load_scene(options.file, &options.scene, lowest, &report);
    char *path = model ? output_path(options.output, model) : NULL;
    if (path)
        result = build(&options, path, model);
    else if (model)
        fprintf(stderr, "totalforce specialise: %s\n", strerror(errno));
    free(path);
    tfa_report_free(&report);
    tfa_model_free(model);
    scene_options_free(&options.scene);
    return result;
}
