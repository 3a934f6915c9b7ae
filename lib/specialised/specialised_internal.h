/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot's specialised kernel from its file to a workspace: owner, checksum, loading, self-test.
 */
#ifndef TFA_SPECIALISED_SPECIALISED_INTERNAL_H
#define TFA_SPECIALISED_SPECIALISED_INTERNAL_H

#include <sys/types.h>
#include <totalforce/specialised.h>

#include "interface/specialised_abi.h"

/* A shared object is larger than this only by mistake. */
#define TFA_SPECIALISED_FILE_MAX ((size_t)64 << 20)

struct tfa_specialised {
    const struct tfa_specialised_kernel *kernel; /* in the shared object */
    void *object;                                /* of dlopen */
    /* its write-protected copy, open as long as it is loaded: the loader knows objects by path,
     * and this one's is /proc/self/fd/N */
    int file;
    char *path;
    uint8_t digest[32];
    double error;
};

/* Buffer for an error text; may have size 0. */
struct error_text {
    char *text;
    size_t size;
};

static inline struct error_text begin_error_text(char *text, size_t size)
{
    if (size)
        text[0] = '\0';
    return (struct error_text){text, size};
}

/* Formats the text, unless there is one, and returns the status. */
int set_error_text(struct error_text *err, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* --- ownership_check.c
 * ------------------------------------------------------------------------------ */

/* As tfa_specialised_check_ownership, of a process of that user. */
int check_ownership(const char *path, uid_t user, struct error_text *err);
/* The same of an open file and of the folders above `path`, which is free of links. */
int check_ownership_of_file(int file, const char *path, uid_t user, struct error_text *err);

/* --- checksum_trailer.c: end of a shared object ----------------------------------------------- */

#define TFA_SPECIALISED_MAGIC "tfa specialised" /* with its terminator 16 bytes */

struct checksum_trailer {
    char magic[16];
    uint32_t abi;
    uint32_t padding;
    uint64_t length;    /* of the shared object, all that stands before */
    uint8_t model[32];  /* tfa_hash_without_gravity */
    uint8_t sha256[32]; /* of all that stands before it */
};

/* The trailer of `length` bytes */
void checksum_trailer_make(const void *bytes, size_t length, const uint8_t model[32],
                           struct checksum_trailer *trailer);
/* Is `bytes` a shared object with its trailer, for this model? */
int checksum_trailer_check(const char *path, const void *bytes, size_t size, const tfa_model *model,
                           struct error_text *err);

/* --- checked_copy.c
 * ------------------------------------------------------------------------------- */

/* The checked shared object without its trailer, in memory that nobody can change: a file. -1:
 * refused. `digest` gets that of its trailer. */
int open_checked_copy(const char *path, const tfa_model *model, uint8_t digest[32], int *status,
                      struct error_text *err);

/* What kernels are given */
struct tfa_host_api specialised_host_api(const tfa_model *model);

/* --- self_test.c ----------------------------------------------------------------------------- */

/* Compares a kernel's answers with the generic ones; *error: the largest relative difference. */
int specialised_self_test(const char *path, const struct tfa_specialised_kernel *kernel,
                          const tfa_model *model, double *error, struct error_text *err);

/* --- tables.c, text_buffer.c
 * --------------------------------------------------------------------- */

/* Text that grows. Once memory is short it stays as it is. */
struct text_buffer {
    char *text;
    size_t used, capacity;
    int failed;
};

void text_append(struct text_buffer *t, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* A name that may hold anything: nothing but letters, digits and . _ - gets through. */
void text_append_name(struct text_buffer *t, const char *name);

/* --- tables_body_lanes.c: bodies of one state in lanes, in at most so many lanes
 * ----------------------------- */

void write_body_lane_tables(struct text_buffer *t, const tfa_model *model, uint32_t lanes_max);

/* --- sources.c: the folder with dynamics/specialised/specialised.c
 * ---------------------------------------------------- */

int find_kernel_sources(const char *wanted, char *folder, size_t size, struct error_text *err);

/* --- compiler.c, build_commands.c, child_process.c: a compiler and how it is run
 * --------------------------------- */

struct compiler_info {
    char path[512];
    char version[200]; /* the first line of --version */
    int clang;
    int major;
};

struct process_limits {
    uint32_t seconds, memory_mib, file_mib;
};

/* `wanted`, or the first in PATH. */
int find_compiler(const char *wanted, const char *folder, const struct process_limits *limits,
                  struct compiler_info *compiler, struct error_text *err);

/* The runs that make a shared object of the sources. At most BUILD_COMMANDS_MAX; each ends with
 * NULL. */
#define BUILD_COMMANDS_MAX 5
#define BUILD_ARGUMENTS_MAX 56
struct build_commands {
    int runs;
    const char *argv[BUILD_COMMANDS_MAX][BUILD_ARGUMENTS_MAX];
    char storage[48][640]; /* for words that are put together */
};
int build_commands_write(struct build_commands *commands, const struct compiler_info *compiler,
                         const char *sources, const char *folder,
                         const tfa_specialise_options *options, struct error_text *err);

/* A program that runs; what it says is in `said` */
struct child_process {
    pid_t process; /* 0: none */
    const char *program;
    double start_time; /* s, monotonic */
    char output_path[600];
};

/* Starts a program whose files go to `folder`, `number` telling it from others there. */
int child_process_start(const char *const *argv, const char *folder, int number,
                        const struct process_limits *limits, struct child_process *child,
                        struct error_text *err);
/* Waits for it; kills it when it takes too long. */
int child_process_wait(struct child_process *child, const struct process_limits *limits,
                       struct error_text *err);
/* Kills it and waits. */
void child_process_stop(struct child_process *child);
/* Both: a program from start to end, number 0 */
int child_process_run(const char *const *argv, const char *folder,
                      const struct process_limits *limits, struct error_text *err);

#endif
