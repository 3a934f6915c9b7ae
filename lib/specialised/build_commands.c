/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * How the sources become a shared object: the one place that says it.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/dynamics.h>

#include "specialised/specialised_internal.h"

/* As in lib/kernel/CMakeLists.txt */
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

/* Numbers are finite and zeros have no sign: what is multiplied by a constant 0 is not in the code.
 * What is not finite is found by its bits. Sums are added in the order that waits least, and
 * products fused with them wherever they stand: 291 ns instead of 312 for the forward dynamics of
 * arm7 together with the tuning below, Lambda^-1 250 instead of 272, and as accurate
 * (specialised_agreement; a loop by hand, AMD EPYC family 25 model 17, clang 14, 2026-11-22). Not
 * when linking, where it would change the arithmetic of the thread that loads the kernel. No
 * vectorising: it turns scalar stores into wide loads that wait for them
 * (lib/kernel/CMakeLists.txt). */
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

/* A word that is put together */
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

/* What specialised.c is compiled for: one number at a time, bodies or states in lanes, payloads */
enum { SCALAR, BODY_LANES, BATCH, PAYLOADS };
static const char *const variants[] = {"scalar", "body_lanes", "batch", "payloads"};

/* specialised.c over one number type: `folder`/NAME.o. Lanes: those of own_many, 0 when there is
 * none. */
static void add_compile_command(struct writer *w, const struct compiler_info *compiler,
                                const char *sources, const char *folder, int variant,
                                const char *lanes)
{
    const struct isa *isa = current_isa();
    begin_command(w, compiler);
    add_arguments(w, common);
    add_arguments(w, isa->flags);
    if (compiler->clang) { /* every step is in place, whatever its size (gcc: flatten) */
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
    else if (variant != BODY_LANES) /* their number of lanes is in the tables */
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
    return w.overflowed ? set_error_text(err, TFA_E_SYSTEM, "a path is too long: '%s'", sources)
                        : TFA_OK;
}
