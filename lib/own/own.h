/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot's own kernel from its file to a workspace: trusted, sealed, loaded, tested.
 */
#ifndef TFA_OWN_OWN_H
#define TFA_OWN_OWN_H

#include <sys/types.h>
#include <totalforce/specialised.h>

#include "kernel/own_abi.h"

/* A shared object is larger than this only by mistake. */
#define TFA_OWN_FILE_MAX ((size_t)64 << 20)

struct tfa_specialised {
    const struct tfa_own_kernel *kernel; /* in the shared object */
    void *object;                        /* of dlopen */
    int file; /* its sealed copy, open as long as it is loaded: the loader knows objects by path, and
                 this one's is /proc/self/fd/N */
    char *path;
    uint8_t digest[32];
    double error;
};

/* Where a reason goes; may hold no room at all. */
struct own_reason {
    char *text;
    size_t size;
};

/* Formats the reason, unless there is one, and returns the status. */
int own_refuse(struct own_reason *why, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* --- trust.c ------------------------------------------------------------------------------ */

/* As tfa_specialised_trust, of a process of that user. */
int own_trust(const char *path, uid_t user, struct own_reason *why);
/* The same of an open file and of the folders above `path`, which is free of links. */
int own_trust_open(int file, const char *path, uid_t user, struct own_reason *why);

/* --- seal.c: what stands behind a shared object ----------------------------------------------- */

#define TFA_OWN_MAGIC "totalforce own\n" /* with its terminator 16 bytes */

struct own_seal {
    char magic[16];
    uint32_t abi;
    uint32_t padding;
    uint64_t length;    /* of the shared object, all that stands before */
    uint8_t model[32];  /* tfa_hash_without_gravity */
    uint8_t sha256[32]; /* of all that stands before it */
};

/* The seal of `length` bytes */
void own_seal_make(const void *bytes, size_t length, const uint8_t model[32],
                   struct own_seal *seal);
/* Is `bytes` a shared object with its seal, for this model? */
int own_seal_check(const char *path, const void *bytes, size_t size, const tfa_model *model,
                   struct own_reason *why);

/* --- file.c ------------------------------------------------------------------------------- */

/* The checked shared object without its seal, in memory that nobody can change: a file. -1: refused.
 * `digest` gets that of its seal. */
int own_open(const char *path, const tfa_model *model, uint8_t digest[32], int *status,
             struct own_reason *why);

/* What kernels are given */
struct tfa_own_host own_host(const tfa_model *model);

/* --- verify.c ----------------------------------------------------------------------------- */

/* Compares a kernel's answers with the generic ones; *error: the largest relative difference. */
int own_verify(const char *path, const struct tfa_own_kernel *kernel, const tfa_model *model,
               double *error, struct own_reason *why);

/* --- tables.c, text.c --------------------------------------------------------------------- */

/* Text that grows. Once memory is short it stays as it is. */
struct own_text {
    char *text;
    size_t used, room;
    int failed;
};

void own_say(struct own_text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* A name that may hold anything: nothing but letters, digits and . _ - gets through. */
void own_say_name(struct own_text *t, const char *name);

/* --- tables_limbs.c: limbs side by side, in at most so many lanes ----------------------------- */

void own_say_limbs(struct own_text *t, const tfa_model *model, uint32_t lanes_max);

/* --- sources.c: the folder with kernel/own.c ---------------------------------------------------- */

int own_sources_find(const char *wanted, char *folder, size_t size, struct own_reason *why);

/* --- compiler.c, recipe.c, child.c: a compiler and how it is run --------------------------------- */

struct own_compiler {
    char path[512];
    char version[200]; /* the first line of --version */
    int clang;
    int major;
};

struct own_limits {
    uint32_t seconds, memory_mib, file_mib;
};

/* `wanted`, or the first in PATH. */
int own_compiler_find(const char *wanted, const char *folder, const struct own_limits *limits,
                      struct own_compiler *compiler, struct own_reason *why);

/* The runs that make a shared object of the sources. At most OWN_RUNS; each ends with NULL. */
#define OWN_RUNS 5
#define OWN_WORDS 56
struct own_recipe {
    int runs;
    const char *words[OWN_RUNS][OWN_WORDS];
    char room[48][640]; /* for words that are put together */
};
int own_recipe_write(struct own_recipe *recipe, const struct own_compiler *compiler,
                     const char *sources, const char *folder, const tfa_specialise_options *options,
                     struct own_reason *why);

/* A program that runs; what it says is in `said` */
struct own_child {
    pid_t process; /* 0: none */
    const char *program;
    double start; /* s, monotonic */
    char said[600];
};

/* Starts a program whose files go to `folder`, `number` telling it from others there. */
int own_child_start(const char *const *words, const char *folder, int number,
                    const struct own_limits *limits, struct own_child *child,
                    struct own_reason *why);
/* Waits for it; kills it when it takes too long. */
int own_child_wait(struct own_child *child, const struct own_limits *limits,
                   struct own_reason *why);
/* Kills it and waits. */
void own_child_stop(struct own_child *child);
/* Both: a program from start to end, number 0 */
int own_child_run(const char *const *words, const char *folder, const struct own_limits *limits,
                  struct own_reason *why);

#endif
