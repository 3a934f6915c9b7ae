/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Internal interface: a specialised kernel from model to file to workspace.
 */
#ifndef TFA_SPECIALISED_SPECIALISED_INTERNAL_H
#define TFA_SPECIALISED_SPECIALISED_INTERNAL_H

#include <sys/types.h>
#include <totalforce/specialised.h>

#include "interface/specialised_abi.h"

/* Largest shared object, bytes */
#define TFA_SPECIALISED_FILE_MAX ((size_t)64 << 20)

struct tfa_specialised {
    const struct tfa_specialised_kernel *kernel; /* in the shared object */
    void *object;                                /* of dlopen */
    /* its sealed copy, open while it is loaded: dlopen identifies objects by path, here
     * /proc/self/fd/N */
    int file;
    char *path;
    uint8_t digest[32];
    double error, error_f32;
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
int refuse(struct error_text *err, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* ---- ownership_check.c ---- */

/* As tfa_specialised_check_ownership, for a process of `user`. */
int check_ownership(const char *path, uid_t user, struct error_text *err);
/* The same for an open file and the folders above `path`, which has no links. */
int check_ownership_of_file(int file, const char *path, uid_t user, struct error_text *err);

/* ---- checksum_trailer.c: end of a shared object ---- */

#define TFA_SPECIALISED_MAGIC "tfa specialised" /* with its terminator 16 bytes */

struct checksum_trailer {
    char magic[16];
    uint32_t abi;
    uint32_t padding;
    uint64_t length;    /* bytes of the shared object before the trailer */
    uint8_t model[32];  /* tfa_hash_without_gravity */
    uint8_t sha256[32]; /* of all bytes before it */
};

/* Computes the trailer of `length` bytes. */
void checksum_trailer_make(const void *bytes, size_t length, const uint8_t model[32],
                           struct checksum_trailer *trailer);
/* Checks that `bytes` end with a valid trailer for this model. */
int checksum_trailer_check(const char *path, const void *bytes, size_t size, const tfa_model *model,
                           struct error_text *err);

/* ---- checked_copy.c ---- */

/* Opens a sealed copy of the checked shared object without trailer; `digest`: that of the trailer.
 * -1: refused. */
int open_checked_copy(const char *path, const tfa_model *model, uint8_t digest[32], int *status,
                      struct error_text *err);

/* Functions that kernels get from the library */
struct tfa_host_api specialised_host_api(const tfa_model *model);

/* Whether the table that `path` exports is of this library, model and instruction set */
int specialised_check_table(const char *path, const struct tfa_specialised_kernel *kernel,
                            const tfa_model *model, struct error_text *err);

/* ---- self_test.c ---- */

/* Compares the answers of s->kernel with the generic ones; s->error, s->error_f32: the largest
 * relative differences. */
int specialised_self_test(const char *path, const tfa_model *model, tfa_specialised *s,
                          struct error_text *err);

/* ---- tables.c, text_buffer.c ---- */

/* Growing text; unchanged after an allocation failed. */
struct text_buffer {
    char *text;
    size_t used, capacity;
    int failed;
};

void text_append(struct text_buffer *t, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Appends a name with _ for all characters but letters, digits and . _ -. */
void text_append_name(struct text_buffer *t, const char *name);

/* Appends the macro `name`(DO): DO(0) DO(1) .. DO(n - 1), or in reverse. */
void write_sequence(struct text_buffer *t, const char *name, uint32_t n, int reverse);

/* Doubles in a vector of this machine */
uint32_t specialised_lanes(void);

/* Whether the dynamics of one state have their branches in lanes on this machine */
int specialised_has_body_lanes(const tfa_model *model);

/* Appends the tables of body lanes, at most `lanes_max` lanes. */
void write_body_lane_tables(struct text_buffer *t, const tfa_model *model, uint32_t lanes_max);

/* ---- choice.c: the algorithm of each kind of request ---- */

enum { ALGORITHM_ABA, ALGORITHM_CRBA, ALGORITHMS };
enum {
    CHOICE_FORWARD,
    CHOICE_LAMBDA,
    CHOICE_FORWARD_LAMBDA,
    CHOICE_FORWARD_BATCH,
    CHOICE_LAMBDA_BATCH,
    CHOICE_FORWARD_LAMBDA_BATCH,
    CHOICE_FORWARD_BATCH_F32,
    CHOICE_LAMBDA_BATCH_F32,
    CHOICE_FORWARD_LAMBDA_BATCH_F32,
    CHOICES
};

/* Of each kind of request the algorithm, and what was measured for it; ns 0: nothing */
struct choices {
    uint8_t algorithm[CHOICES];
    struct {
        double ns[ALGORITHMS]; /* a state, the least of all rounds */
        double loss;           /* error by crba over that by aba, see choice.c */
    } measured[CHOICES];
};

/* Algorithms that a robot has code for */
int specialised_algorithms(const tfa_model *model);

/* Appends robot_choice.h. */
void specialised_choice_write(struct text_buffer *t, const tfa_model *model,
                              const struct choices *choices);

/* Times kernels that answer everything by one algorithm each, and compares them with quadruple
 * precision; all algorithms are ALGORITHM_ABA before. */
int specialised_choose(const tfa_model *model, const char *const path[ALGORITHMS],
                       struct choices *choices);

/* 1: states have the same bits alone and in lanes, or it is no kernel of this model */
int specialised_same_bits(const tfa_model *model, const char *path);

/* ---- sources.c: the folder with dynamics/specialised/specialised.c ---- */

int find_kernel_sources(const char *wanted, char *folder, size_t size, struct error_text *err);

/* ---- build_folder.c: a temporary folder beside the result ---- */

/* Removes those of this user that killed builds left there, makes one and locks it. @return 0, or
 * as errno */
int build_folder_make(const char *result, char *path, size_t size, int *lock);
void build_folder_remove(const char *path, int lock);

/* ---- compiler.c, build_commands.c, child_process.c: a compiler and how it is run ---- */

struct compiler_info {
    char path[512];
    char version[200]; /* the first line of --version */
    int clang;
    int major;
};

struct process_limits {
    uint32_t seconds, memory_mib, file_mib;
    const volatile int *cancel; /* NULL, or kills the program when it is not 0 */
};

/* `wanted`, or the first in PATH. */
int find_compiler(const char *wanted, const char *folder, const struct process_limits *limits,
                  struct compiler_info *compiler, struct error_text *err);

/* Command lines that make a shared object, with products fused (clang; of floats
 * always) or not: at most BUILD_COMMANDS_MAX,
 * each ends with NULL. The last two compile the table, which needs robot_choice.h, and link. */
#define BUILD_COMMANDS_MAX 14
#define BUILD_ARGUMENTS_MAX 60
struct build_commands {
    int runs;
    const char *argv[BUILD_COMMANDS_MAX][BUILD_ARGUMENTS_MAX];
    char storage[200][640]; /* formatted arguments */
};
int build_commands_write(struct build_commands *commands, const struct compiler_info *compiler,
                         const char *sources, const char *folder,
                         const tfa_specialise_options *options, int algorithms, int fused,
                         struct error_text *err);

/* Monotonic time, s */
double seconds_now(void);

/* A running program; its output goes to output_path */
struct child_process {
    pid_t process; /* 0: none */
    const char *program;
    double start_time; /* s, monotonic */
    char output_path[600];
};

/* Starts a program with its output in `folder`, distinguished by `number`. */
int child_process_start(const char *const *argv, const char *folder, int number,
                        const struct process_limits *limits, struct child_process *child,
                        struct error_text *err);
/* Waits for it; kills it at the wall-clock limit, or when it is cancelled. */
int child_process_wait(struct child_process *child, const struct process_limits *limits,
                       struct error_text *err);
/* Kills it and waits. */
void child_process_stop(struct child_process *child);
/* Starts a program, number 0, and waits for it. */
int child_process_run(const char *const *argv, const char *folder,
                      const struct process_limits *limits, struct error_text *err);

#endif
