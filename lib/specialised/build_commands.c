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
    const char *name, *lanes;
    const char *flags[8];
} isas[] = {
    {"base", "2", {NULL}},
    {"avx2", "4", {"-mavx2", "-mfma", NULL}},
    {"avx512",
     "8",
     {"-mavx2", "-mfma", "-mavx512f", "-mavx512vl", "-mavx512dq", "-mavx512bw", NULL}},
};

/* -ffast-math: products with a constant 0 disappear from the code; answers that are not finite are
 * found by their bits. Sums in the fastest order, products fused: 7 % faster and as accurate
 * (specialised_agreement). Not when linking, where it would change the arithmetic of the loading
 * thread. No vectorising: it turns scalar stores into wide loads that wait for them
 * (lib/dynamics/CMakeLists.txt). */
static const char *const common[] = {"-std=gnu11",
                                     "-fPIC",
                                     "-O3",
                                     "-DNDEBUG",
                                     "-D_GNU_SOURCE",
                                     "-w",
                                     "-fvisibility=hidden",
                                     "-ffunction-sections",
                                     "-ffast-math",
                                     "-ffp-contract=fast",
                                     "-fno-tree-vectorize",
                                     "-fno-tree-slp-vectorize",
                                     "-DTFA_OUTLINE=TFA_INLINE",
                                     "-DTFA_PRECISION=TFA_F64",
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

/* Variants of specialised.c: one state, its bodies in lanes, states in lanes, payloads */
enum { SCALAR, BODY_LANES, BATCH, PAYLOADS };
static const char *const variants[] = {"scalar", "body_lanes", "batch", "payloads"};

/* Compiles a variant of specialised.c to `folder`/NAME.o. lanes: states of a batch, "0": none. */
static void add_compile_command(struct writer *w, const struct compiler_info *compiler,
                                const char *sources, const char *folder, int variant,
                                const char *lanes)
{
    const struct isa *isa = current_isa();
    begin_command(w, compiler);
    add_arguments(w, common);
    add_arguments(w, isa->flags);
    if (compiler->clang) { /* inlines every step (gcc: flatten) */
        add_argument(w, "-mllvm");
        add_argument(w, "-inline-threshold=1000000");
    }
#if defined(__x86_64__)
    add_argument(w, "-mtune=native");
    if (!compiler->clang && compiler->major >= 12 && (variant == SCALAR || variant == PAYLOADS)) {
        add_argument(w, "-mmove-max=128");
        add_argument(w, "-mstore-max=128");
    }
#endif
    add_formatted(w, "-DTFA_VARIANT=%s", variants[variant]);
    add_formatted(w, "-DTFA_ISA_NAME=%s", isa->name);
    if (variant == PAYLOADS)
        add_argument(w, "-DROBOT_PAYLOADS");
    else if (variant != BODY_LANES) /* the tables hold its number of lanes */
        add_formatted(w, variant == BATCH ? "-DTFA_LANES=%s" : "-DROBOT_BATCH_LANES=%s", lanes);
    add_formatted(w, "-I%s", folder);
    add_formatted(w, "-I%s", sources);
    add_formatted(w, "-I%s/include", sources);
    add_formatted(w, "-I%s/number/%s", sources,
                  variant == SCALAR || variant == PAYLOADS ? "f64" : "f64xn");
    if (variant == BODY_LANES)
        add_formatted(w, "-I%s/layout/specialised_body_lanes", sources);
    add_formatted(w, "-I%s/layout/specialised", sources);
    add_argument(w, "-c");
    add_formatted(w, "%s/dynamics/specialised/specialised%s.c", sources,
                  variant == BODY_LANES ? "_body_lanes" : "");
    add_argument(w, "-o");
    add_formatted(w, "%s/%s.o", folder, variants[variant]);
}

int build_commands_write(struct build_commands *commands, const struct compiler_info *compiler,
                         const char *sources, const char *folder,
                         const tfa_specialise_options *options, struct error_text *err)
{
    struct writer w = {.commands = commands};
    const char *lanes = current_isa()->lanes;
    commands->runs = 0;
    add_compile_command(&w, compiler, sources, folder, SCALAR, options->single ? "0" : lanes);
    add_compile_command(&w, compiler, sources, folder, BODY_LANES, lanes);
    add_compile_command(&w, compiler, sources, folder, PAYLOADS, lanes);
    if (!options->single)
        add_compile_command(&w, compiler, sources, folder, BATCH, lanes);
    begin_command(&w, compiler);
    static const char *const link[] = {
        "-shared", "-Wl,--gc-sections", "-Wl,-z,defs", "-Wl,-z,now", "-s", NULL};
    add_arguments(&w, link);
    add_formatted(&w, "%s/scalar.o", folder);
    add_formatted(&w, "%s/body_lanes.o", folder);
    add_formatted(&w, "%s/payloads.o", folder);
    if (!options->single)
        add_formatted(&w, "%s/batch.o", folder);
    add_argument(&w, "-lm");
    add_argument(&w, "-o");
    add_formatted(&w, "%s/kernel.so", folder);
    return w.overflowed ? refuse(err, TFA_E_SYSTEM, "a path is too long: '%s'", sources) : TFA_OK;
}
