/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Specialised kernels: the numeric source compiled once more with the constants of one robot, as a
 * shared object. Same algorithms as the generic kernels (rnea, aba, propagation: dynamics.h).
 * Gravity and payloads stay inputs of a request; rotor inertias are constants. The generic kernel
 * answers requests that the specialised one does not support, and states without a finite answer.
 * Which requests: docs/specialised.md; which files are trusted: docs/security.md.
 */
#ifndef TOTALFORCE_SPECIALISED_H
#define TOTALFORCE_SPECIALISED_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/model.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A loaded and tested kernel; constant. Any number of workspaces share it. */
typedef struct tfa_specialised tfa_specialised;

/** Largest number of bodies of a specialised robot: the size of the code grows with it. */
#define TFA_SPECIALISED_BODIES_MAX 128

/** Bytes of a kernel's file name, terminator included. */
#define TFA_SPECIALISED_NAME_SIZE 96

/** Description of a loaded kernel. Strings live as long as the kernel. */
typedef struct tfa_specialised_info {
    const char *path;       /**< its file */
    const char *isa;        /**< as tfa_isa_name */
    const char *compiler;   /**< with its version */
    const char *algorithms; /**< of each kind of request; where they were timed in the build, with
                                 times a state and errors of both: "forward crba (..), .." */
    uint32_t bodies;        /**< as tfa_model_summary */
    uint32_t lanes;        /**< states of one SIMD batch; 0: it computes one state at a time only */
    uint32_t lanes_f32;    /**< the same in single precision; 0: it computes none */
    const uint8_t *digest; /**< SHA-256 of the file, 32 bytes */
    double error;     /**< largest relative difference from the generic kernel in the self-test */
    double error_f32; /**< the same in single precision */
} tfa_specialised_info;

/* In every function below, `error_text` gets the reason of an error; it is always terminated, empty
 * with TFA_OK, and may be NULL with size 0. */

/**
 * Checks that a robot can be specialised: no projected mimics, no flexible links, no fused, planar
 * or floating joints besides the floating base, 1 to TFA_SPECIALISED_BODIES_MAX bodies. Cost: O(N).
 * Any thread.
 *
 * @return TFA_OK; TFA_E_ARGUMENT (model NULL); TFA_E_UNSUPPORTED (error_text names the joint
 *         or the link)
 */
TFA_API TFA_CHECKED int tfa_specialised_check(const tfa_model *model, char *error_text,
                                              size_t size);

/** Writes the file name of a model's kernel for this machine's instruction set: HASH-ISA.so, with
 *  the hash of the model without gravity, because kernels read gravity at run time. Any thread. */
TFA_API void tfa_specialised_name(const tfa_model *model, char name[TFA_SPECIALISED_NAME_SIZE]);

/**
 * Checks that code at `path` may be executed: the file or folder and every folder above it belong
 * to root or to the user of this process, and no other user may write there, except in folders
 * above it with the sticky bit (/tmp). Symbolic links are resolved first. Any thread.
 *
 * @return TFA_OK; TFA_E_ARGUMENT (path NULL); TFA_E_FILE (does not exist or cannot be opened, see
 *         errno); TFA_E_REFUSED (owner or mode; error_text gives the remedy)
 */
TFA_API TFA_CHECKED int tfa_specialised_check_ownership(const char *path, char *error_text,
                                                        size_t size);

/**
 * Loads a kernel after these checks, in this order: owner and mode, checksum, version, model,
 * instruction set; then a self-test compares its answers at random states with those of the generic
 * kernel. They may differ by 1e-10 of the largest number of an answer, or by 100 times the error
 * estimate of the generic answer if that is larger. No code of the file runs before all other
 * checks have passed.
 *
 * Cost: at most 50 ms for an arm. Allocates. Any thread that serves no requests meanwhile.
 *
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_FILE (cannot be opened, read or loaded);
 *         TFA_E_REFUSED (as tfa_specialised_check_ownership); TFA_E_PARSE (truncated, larger than
 *         64 MiB, or the checksum does not fit); TFA_E_UNSUPPORTED (built for another version of
 *         the library, another model or another instruction set); TFA_E_NOT_COMPUTED (the self-test
 *         found wrong answers); TFA_E_MEMORY; TFA_E_SYSTEM (mapping or sealing memory failed).
 *         On error *specialised is NULL.
 */
TFA_API TFA_CHECKED int tfa_specialised_load(const char *path, const tfa_model *model,
                                             tfa_specialised **specialised, char *error_text,
                                             size_t size);

/** As tfa_specialised_load, of the file named by tfa_specialised_name in `directory`. */
TFA_API TFA_CHECKED int tfa_specialised_find(const char *directory, const tfa_model *model,
                                             tfa_specialised **specialised, char *error_text,
                                             size_t size);

/** Description of a kernel. Any thread. */
TFA_API tfa_specialised_info tfa_specialised_describe(const tfa_specialised *specialised);

/** Unloads a kernel. No workspace may use it any more. NULL is allowed. */
TFA_API void tfa_specialised_free(tfa_specialised *specialised);

/** Algorithms of a kernel. */
typedef enum tfa_specialise_algorithm {
    TFA_SPECIALISE_FASTEST = 0, /**< for each kind of request the fastest, timed in the build; crba
                                     only if its error is at most twice that of aba
                                     with every tip */
    TFA_SPECIALISE_ABA = 1,     /**< articulated bodies */
    TFA_SPECIALISE_CRBA = 2, /**< composite rigid bodies and factors of M: fixed bases, at most 16
                                     bodies; others get aba */
} tfa_specialise_algorithm;
/** Their words: X(value, word) */
#define TFA_ALGORITHM_WORDS(X)                                                                     \
    X(TFA_SPECIALISE_FASTEST, "fastest")                                                           \
    X(TFA_SPECIALISE_ABA, "aba")                                                                   \
    X(TFA_SPECIALISE_CRBA, "crba")

/** Options of a build. Zero-initialise for the defaults. */
typedef struct tfa_specialise_options {
    uint32_t single;      /**< 1: without code for SIMD batches; 0: with it */
    const char *compiler; /**< program; NULL: the first of clang, gcc and cc in PATH */
    const char *sources;  /**< folder of the sources; NULL: beside the program, then as installed */
    uint32_t seconds;     /**< limit of processor time of one compiler run, s; it is killed after
                               twice that in wall-clock time; 0: 300 */
    uint32_t memory_mib;  /**< limit of a compiler's address space, MiB; 0: 4096 */
    uint32_t file_mib;    /**< largest file that a compiler may write, MiB; 0: 64 */
    uint32_t keep_tables; /**< 1: keeps the tables, as PATH with .h in place of .so */
    tfa_specialise_algorithm algorithm; /**< which code the kernel has */
    const volatile int *cancel; /**< NULL; or set to other than 0, by a signal handler or another
                                     thread, it stops the compilers and the build */
} tfa_specialise_options;

/** Result of a build. */
typedef struct tfa_specialise_result {
    double compile_s;   /**< wall-clock time of the compiler runs, s */
    size_t bytes;       /**< of the shared object, its checksum trailer included */
    char compiler[256]; /**< its version line */
} tfa_specialise_result;

/**
 * Writes the constants of a model as C tables, the input of
 * lib/dynamics/specialised/specialised.c. They contain no algorithm. Names of the URDF appear in
 * comments only, with _ for every character other than letters, digits and . _ -. Any thread.
 *
 * @param model  of the robot
 * @param text   one malloc block, terminated; NULL on error
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_MEMORY; TFA_E_UNSUPPORTED as tfa_specialised_check
 */
TFA_API TFA_CHECKED int tfa_specialised_tables(const tfa_model *model, char **text);

/**
 * Compiles a kernel for the model and this machine's instruction set: runs the system's compiler in
 * child processes with limits on time, memory and file size, appends the checksum trailer, and
 * renames the file to `path` once it is complete and on disk. Where there are algorithms to choose
 * from, or clang has fused products, the build runs the kernel on random states.
 *
 * Cost: seconds to a minute. One thread for each path; not a thread that serves requests.
 *
 * @param model       of the robot
 * @param options     NULL: all defaults
 * @param path        file to write
 * @param result      may be NULL
 * @param error_text  includes the start of the compiler's output
 * @param size        of error_text, bytes
 * @return TFA_OK; TFA_E_ARGUMENT (model or path NULL); TFA_E_UNSUPPORTED (as tfa_specialised_check,
 *         or no compiler); TFA_E_FILE (no sources, or `path` cannot be written); TFA_E_TIMEOUT (a
 *         compiler exceeded its time); TFA_E_NOT_COMPUTED (a compiler failed or was cancelled, or
 *         the kernel is larger than 64 MiB); TFA_E_MEMORY; TFA_E_SYSTEM (a process cannot be
 *         started, or a path is too long).
 */
TFA_API TFA_CHECKED int tfa_specialised_build(const tfa_model *model,
                                              const tfa_specialise_options *options,
                                              const char *path, tfa_specialise_result *result,
                                              char *error_text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
