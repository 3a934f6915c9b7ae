/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * How the sources become a shared object: the one place that says it.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/dynamics.h>

#include "own/own.h"

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

/* Numbers are finite and zeros have no sign: what is multiplied by a constant 0 is not in the code. What
 * is not finite is found by its bits. Sums are added in the order that waits least, and products fused with
 * them wherever they stand: 291 ns instead of 312 for the forward dynamics of arm7 together with the tuning
 * below, Lambda^-1 250 instead of 272, and as accurate (own_agreement; a loop by hand, AMD EPYC family 25 model 17,
 * clang 14, 2026-11-22). Not when linking, where it would change the arithmetic of the thread that
 * loads the kernel. No vectorising: it turns scalar stores into wide loads that wait for them
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
                                     "-DTFA_OWN",
                                     "-DTFA_PRECISION=TFA_F64",
                                     NULL};

struct writer {
    struct own_recipe *recipe;
    size_t word, room;
    int run, full;
};

static void add(struct writer *w, const char *word)
{
    if (w->word + 1 >= OWN_WORDS) {
        w->full = 1;
        return;
    }
    w->recipe->words[w->run][w->word++] = word;
    w->recipe->words[w->run][w->word] = NULL;
}

static void add_all(struct writer *w, const char *const *words)
{
    for (; *words; words++)
        add(w, *words);
}

/* A word that is put together */
__attribute__((format(printf, 2, 3))) static void add_made(struct writer *w, const char *format,
                                                           ...)
{
    va_list arguments;
    if (w->room == sizeof w->recipe->room / sizeof *w->recipe->room) {
        w->full = 1;
        return;
    }
    char *text = w->recipe->room[w->room++];
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof *w->recipe->room, format, arguments);
    va_end(arguments);
    w->full |= length >= (int)sizeof *w->recipe->room;
    add(w, text);
}

static void begin(struct writer *w, const struct own_compiler *compiler)
{
    w->run = w->recipe->runs++;
    w->word = 0;
    add(w, compiler->path);
}

static const struct isa *isa_here(void)
{
    for (size_t k = 0; k < sizeof isas / sizeof *isas; k++)
        if (strcmp(isas[k].name, tfa_isa_name()) == 0)
            return &isas[k];
    return &isas[0];
}

/* What own.c is compiled for: one number at a time, bodies or states in lanes, payloads */
enum { ONE, LIMBS, MANY, LOADED };
static const char *const names[] = {"own_one", "own_limbs", "own_many", "own_loaded"};

/* own.c over one number type: `folder`/NAME.o. Lanes: those of own_many, 0 when there is none. */
static void compile(struct writer *w, const struct own_compiler *compiler, const char *sources,
                    const char *folder, int what, const char *lanes)
{
    const struct isa *isa = isa_here();
    begin(w, compiler);
    add_all(w, common);
    add_all(w, isa->flags);
    if (compiler->clang) { /* every step is in place, whatever its size (gcc: flatten) */
        add(w, "-mllvm");
        add(w, "-inline-threshold=1000000");
    }
#if defined(__x86_64__)
    add(w, "-mtune=native");
    if (!compiler->clang && compiler->major >= 12 && (what == ONE || what == LOADED)) {
        add(w, "-mmove-max=128");
        add(w, "-mstore-max=128");
    }
#endif
    add_made(w, "-DTFA_VARIANT=%s", names[what]);
    add_made(w, "-DTFA_ISA_NAME=%s", isa->name);
    if (what == LIMBS) /* how many lanes is in the tables */
        add(w, "-DTFA_PACKED");
    else if (what == LOADED)
        add(w, "-DOWN_LOADED");
    else
        add_made(w, what == MANY ? "-DTFA_LANES=%s" : "-DOWN_LANES=%s", lanes);
    add_made(w, "-I%s", folder);
    add_made(w, "-I%s", sources);
    add_made(w, "-I%s/include", sources);
    add_made(w, "-I%s/variants/%s", sources, what == ONE || what == LOADED ? "f64" : "f64xn");
    add(w, "-c");
    add_made(w, "%s/kernel/own.c", sources);
    add(w, "-o");
    add_made(w, "%s/%s.o", folder, names[what]);
}

int own_recipe_write(struct own_recipe *recipe, const struct own_compiler *compiler,
                     const char *sources, const char *folder, const tfa_specialise_options *options,
                     struct own_reason *why)
{
    struct writer w = {.recipe = recipe};
    const char *lanes = isa_here()->lanes;
    recipe->runs = 0;
    compile(&w, compiler, sources, folder, ONE, options->single ? "0" : lanes);
    compile(&w, compiler, sources, folder, LIMBS, lanes);
    compile(&w, compiler, sources, folder, LOADED, lanes);
    if (!options->single)
        compile(&w, compiler, sources, folder, MANY, lanes);
    begin(&w, compiler);
    static const char *const link[] = {
        "-shared", "-Wl,--gc-sections", "-Wl,-z,defs", "-Wl,-z,now", "-s", NULL};
    add_all(&w, link);
    add_made(&w, "%s/own_one.o", folder);
    add_made(&w, "%s/own_limbs.o", folder);
    add_made(&w, "%s/own_loaded.o", folder);
    if (!options->single)
        add_made(&w, "%s/own_many.o", folder);
    add(&w, "-lm");
    add(&w, "-o");
    add_made(&w, "%s/own.so", folder);
    return w.full ? own_refuse(why, TFA_E_SYSTEM, "a path is too long: '%s'", sources) : TFA_OK;
}
