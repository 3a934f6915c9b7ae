/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compiler command lines that make a shared object of the sources.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/dynamics.h>

#include "specialised/specialised_internal.h"

/* As in lib/dynamics/CMakeLists.txt */
static const struct isa {
    const char *name, *lanes_f64, *lanes_f32;
    const char *flags[8];
} isas[] = {
    {"base", "2", "4", {NULL}},
    {"avx2", "4", "8", {"-mavx2", "-mfma", NULL}},
    {"avx512",
     "8",
     "16",
     {"-mavx2", "-mfma", "-mavx512f", "-mavx512vl", "-mavx512dq", "-mavx512bw", NULL}},
};

/* Finite numbers, zeros without signs: products with a constant 0 disappear from the code; answers
 * that are not finite are found by their bits. Sums keep their order, so that one state and states
 * in lanes round alike. No vectorising: it turns scalar stores into wide loads that wait for them
 * (lib/dynamics/CMakeLists.txt). */
static const char *const common[] = {"-std=gnu11",
                                     "-fPIC",
                                     "-O3",
                                     "-DNDEBUG",
                                     "-D_GNU_SOURCE",
                                     "-w",
                                     "-fvisibility=hidden",
                                     "-ffunction-sections",
                                     "-fno-math-errno",
                                     "-ffinite-math-only",
                                     "-fno-signed-zeros",
                                     "-fno-trapping-math",
                                     "-fno-tree-vectorize",
                                     "-fno-tree-slp-vectorize",
                                     "-DTFA_ONE_FILE", /* all steps inline: spatial/num.h */
                                     "-DTFA_PRECISION=TFA_F64",
#ifdef TFA_EXACT
                                     "-DTFA_EXACT", /* of sines: number/sincos.h */
#endif
                                     NULL};

struct writer {
    struct build_commands *commands;
    size_t position, storage;
    int run, overflowed;
};

static void add_argument(struct writer *w, const char *argument)
{
    if (w->position + 1 >= BUILD_ARGUMENTS_MAX) {
        w->overflowed = 1;
        return;
    }
    w->commands->argv[w->run][w->position++] = argument;
    w->commands->argv[w->run][w->position] = NULL;
}

static void add_arguments(struct writer *w, const char *const *argv)
{
    for (; *argv; argv++)
        add_argument(w, *argv);
}

/* Adds an argument formatted as by printf. */
__attribute__((format(printf, 2, 3))) static void add_formatted(struct writer *w,
                                                                const char *format, ...)
{
    va_list arguments;
    if (w->storage == sizeof w->commands->storage / sizeof *w->commands->storage) {
        w->overflowed = 1;
        return;
    }
    char *text = w->commands->storage[w->storage++];
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof *w->commands->storage, format, arguments);
    va_end(arguments);
    w->overflowed |= length >= (int)sizeof *w->commands->storage;
    add_argument(w, text);
}

static void begin_command(struct writer *w, const struct compiler_info *compiler)
{
    w->run = w->commands->runs++;
    w->position = 0;
    add_argument(w, compiler->path);
}

static const struct isa *current_isa(void)
{
    for (size_t k = 0; k < sizeof isas / sizeof *isas; k++)
        if (strcmp(isas[k].name, tfa_isa_name()) == 0)
            return &isas[k];
    return &isas[0];
}

/* One object: specialised_solve.c, specialised_derivatives.c, specialised_body_lanes.c or the table
 * (specialised.c) */
struct object {
    const char *name; /* the variant, and NAME.o */
    const char *source;
    const char *algorithm;                                 /* folder of dynamics/specialised */
    const char *define;                                    /* or NULL */
    const char *number;                                    /* folder of number/ */
    enum { LANES_NONE, LANES_STATES, LANES_BODIES } lanes; /* of a number */
};

static const struct object objects[] = {
    {"scalar_aba", "specialised_solve", "aba", "-DROBOT_INVERSE", "f64", LANES_NONE},
    {"body_lanes_aba", "specialised_body_lanes", "aba", NULL, "f64xn", LANES_BODIES},
    {"payloads_aba", "specialised_solve", "aba", "-DROBOT_PAYLOADS", "f64", LANES_NONE},
    {"scalar_crba", "specialised_solve", "crba", NULL, "f64", LANES_NONE},
    {"batch_aba", "specialised_solve", "aba", "-DROBOT_INVERSE", "f64xn", LANES_STATES},
    {"batch_payloads_aba", "specialised_solve", "aba", "-DROBOT_PAYLOADS", "f64xn", LANES_STATES},
    {"batch_crba", "specialised_solve", "crba", NULL, "f64xn", LANES_STATES},
    {"batch_f32_aba", "specialised_solve", "aba", "-DROBOT_INVERSE", "f32xn", LANES_STATES},
    {"batch_f32_payloads_aba", "specialised_solve", "aba", "-DROBOT_PAYLOADS", "f32xn",
     LANES_STATES},
    {"batch_f32_crba", "specialised_solve", "crba", NULL, "f32xn", LANES_STATES},
    {"derivatives_one", "specialised_derivatives", "aba", NULL, "f64", LANES_NONE},
    {"derivatives_batch", "specialised_derivatives", "aba", NULL, "f64xn", LANES_STATES},
    {"table", "specialised", "aba", NULL, "f64", LANES_NONE},
};
enum { OBJECTS = sizeof objects / sizeof *objects, TABLE = OBJECTS - 1 };

/* Floats have lanes only: no other code need have their bits. */
static int is_f32(const struct object *o)
{
    return strcmp(o->number, "f32xn") == 0;
}

struct build_paths {
    const char *sources, *folder;
};

/* single: no batches. */
static void add_compile_command(struct writer *w, const struct compiler_info *compiler,
                                const struct build_paths *p, const struct object *o, int single,
                                int fused)
{
    const struct isa *isa = current_isa();
    begin_command(w, compiler);
    add_arguments(w, common);
    add_argument(w, fused ? "-ffp-contract=on" : "-ffp-contract=off"); /* within expressions */
    add_arguments(w, isa->flags);
    if (compiler->clang) { /* inlines every step (gcc: flatten) */
        add_argument(w, "-mllvm");
        add_argument(w, "-inline-threshold=1000000");
    }
#if defined(__x86_64__)
    add_argument(w, "-mtune=native");
    if (!compiler->clang && compiler->major >= 12 && !o->lanes) {
        add_argument(w, "-mmove-max=128");
        add_argument(w, "-mstore-max=128");
    }
#endif
    add_formatted(w, "-DTFA_VARIANT=%s", o->name);
    add_formatted(w, "-DTFA_ISA_NAME=%s", isa->name);
    if (o->define)
        add_argument(w, o->define);
    if (o == &objects[TABLE]) {
        add_formatted(w, "-DROBOT_BATCH_LANES=%s", single ? "0" : isa->lanes_f64);
        add_formatted(w, "-DROBOT_BATCH_F32_LANES=%s", single ? "0" : isa->lanes_f32);
    } else if (o->lanes == LANES_STATES) { /* the tables hold the number of body lanes */
        add_formatted(w, "-DTFA_LANES=%s", is_f32(o) ? isa->lanes_f32 : isa->lanes_f64);
    }
    add_formatted(w, "-I%s", p->folder);
    add_formatted(w, "-I%s", p->sources);
    add_formatted(w, "-I%s/include", p->sources);
    add_formatted(w, "-I%s/dynamics/specialised/%s", p->sources, o->algorithm);
    add_formatted(w, "-I%s/number/%s", p->sources, o->number);
    if (o->lanes == LANES_BODIES)
        add_formatted(w, "-I%s/layout/specialised_body_lanes", p->sources);
    add_formatted(w, "-I%s/layout/specialised", p->sources);
    add_argument(w, "-c");
    add_formatted(w, "%s/dynamics/specialised/%s.c", p->sources, o->source);
    add_argument(w, "-o");
    add_formatted(w, "%s/%s.o", p->folder, o->name);
}

static int is_wanted(const struct object *o, int single, int algorithms)
{
    return !(o->lanes == LANES_STATES && single) &&
           (algorithms > 1 || strcmp(o->algorithm, "crba") != 0);
}

int build_commands_write(struct build_commands *commands, const struct compiler_info *compiler,
                         const char *sources, const char *folder,
                         const tfa_specialise_options *options, int algorithms, int fused,
                         struct error_text *err)
{
    struct writer w = {.commands = commands};
    const struct build_paths p = {sources, folder};
    commands->runs = 0;
    for (int k = 0; k < OBJECTS; k++)
        if (is_wanted(&objects[k], (int)options->single, algorithms))
            add_compile_command(&w, compiler, &p, &objects[k], (int)options->single,
                                compiler->clang && (fused || is_f32(&objects[k])));
    begin_command(&w, compiler);
    static const char *const link[] = {
        "-shared", "-Wl,--gc-sections", "-Wl,-z,defs", "-Wl,-z,now", "-s", NULL};
    add_arguments(&w, link);
    for (int k = 0; k < OBJECTS; k++)
        if (is_wanted(&objects[k], (int)options->single, algorithms))
            add_formatted(&w, "%s/%s.o", folder, objects[k].name);
    add_argument(&w, "-lm");
    add_argument(&w, "-o");
    add_formatted(&w, "%s/kernel.so", folder);
    return w.overflowed ? refuse(err, TFA_E_SYSTEM, "a path is too long: '%s'", sources) : TFA_OK;
}
