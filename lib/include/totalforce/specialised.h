/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A specialised kernel: the sources of the kernels compiled once more with the constants of one
 * robot, in a shared object. Gravity and payloads of requests stay inputs of every kernel; rotor
 * inertias are constants. The generic kernel answers requests that the specialised one does not
 * take, and states without a finite answer. Which files are trusted, and why: docs/security.md.
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

/** A loaded and tested kernel: constant; any number of workspaces share it. */
typedef struct tfa_specialised tfa_specialised;

/** Bodies of the largest robot that is specialised: the code grows with them. */
#define TFA_SPECIALISED_BODIES_MAX 128

/** A folder name and the file name in it, terminator included; all of it fits PATH_MAX. */
#define TFA_SPECIALISED_NAME_SIZE 96

/** What a kernel tells about itself. Strings live as long as the kernel. */
typedef struct tfa_specialised_info {
    const char *path;     /**< the file it came from */
    const char *isa;      /**< as tfa_isa_name */
    const char *compiler; /**< with its version */
    uint32_t bodies;
    uint32_t lanes;        /**< states that it takes at a time; 0: one only */
    const uint8_t *digest; /**< SHA-256 of the file: 32 bytes that tell one build from another */
    double error; /**< largest relative difference from the generic kernel in the self-test */
} tfa_specialised_info;

/**
 * Is this a robot for a specialised kernel? Not one with projected mimics, nor with fused, planar
 * or free joints besides the floating base, nor with more than TFA_SPECIALISED_BODIES_MAX bodies.
 * @param reason  gets why not, naming the joint; always terminated; may be NULL with size 0
 * @return TFA_OK; TFA_E_ARGUMENT (no model); TFA_E_UNSUPPORTED. Any thread.
 */
TFA_API TFA_CHECKED int tfa_specialised_check(const tfa_model *model, char *error_text,
                                              size_t size);

/** The file name of a model's kernel for this machine's instruction set, in `name`: HASH-ISA.so,
 *  with the hash of the model without its gravity, which kernels read at run time. Any thread. */
TFA_API void tfa_specialised_name(const tfa_model *model, char name[TFA_SPECIALISED_NAME_SIZE]);

/**
 * May what lies at `path` be executed? The file or folder, and every folder above it, must belong
 * to root or to the user of this process; nobody else may write there, but in folders above with
 * the sticky bit (/tmp). Symbolic links are followed first, and it is where they lead to that
 * counts.
 * @param reason  gets what is wrong and the remedy; always terminated; may be NULL with size 0
 * @return TFA_OK; TFA_E_ARGUMENT; TFA_E_FILE (not there, see errno); TFA_E_REFUSED. Any thread.
 */
TFA_API TFA_CHECKED int tfa_specialised_check_ownership(const char *path, char *error_text,
                                                        size_t size);

/**
 * Loads a kernel and tests it: owner and mode, checksum, version, model, instruction set, then its
 * answers at random states beside those of the generic kernel, which may differ by 1e-10 of the
 * largest number of an answer, or by 100 times the error that the generic kernel estimates of its
 * own, where that is more.
 *
 * Code of the file runs only after everything but the answers was checked. Takes at most 50 ms for
 * an arm; allocates; not for a thread that serves requests.
 * @param reason  gets why not, or, with TFA_OK, stays empty; always terminated; may be NULL with
 *  size 0
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_FILE (cannot be opened or loaded); TFA_E_REFUSED
 *         (owner or mode, see tfa_specialised_check_ownership); TFA_E_PARSE (truncated, too large,
 *         or not what
 *         the checksum says); TFA_E_UNSUPPORTED (another version of the library, another model,
 *         another
 *         instruction set); TFA_E_NOT_COMPUTED (its answers are wrong); TFA_E_MEMORY; TFA_E_SYSTEM.
 *         On error *specialised is NULL. Any thread.
 */
TFA_API TFA_CHECKED int tfa_specialised_load(const char *path, const tfa_model *model,
                                             tfa_specialised **specialised, char *error_text,
                                             size_t size);

/** tfa_specialised_load of the file tfa_specialised_name in `directory`. */
TFA_API TFA_CHECKED int tfa_specialised_find(const char *directory, const tfa_model *model,
                                             tfa_specialised **specialised, char *error_text,
                                             size_t size);

/** Any thread. */
TFA_API tfa_specialised_info tfa_specialised_describe(const tfa_specialised *specialised);

/** Unloads it. No workspace may use it any more. NULL is allowed. */
TFA_API void tfa_specialised_free(tfa_specialised *specialised);

/** How a kernel is built. Zero-initialise for the defaults. */
typedef struct tfa_specialise_options {
    uint32_t single;      /**< 1: no code for several states at a time; 0: with it */
    const char *compiler; /**< program; NULL: the first of clang, gcc and cc in PATH */
    const char *sources;  /**< the installed sources; NULL: beside the program, then as installed */
    uint32_t seconds;     /**< processor time and patience for one compiler run; 0: 300 */
    uint32_t memory_mib;  /**< address space of a compiler; 0: 4096 */
    uint32_t file_mib;    /**< largest file that it writes; 0: 64 */
    uint32_t keep_tables; /**< 1: the tables stay, as PATH with .h in place of .so */
} tfa_specialise_options;

/** What a build took. */
typedef struct tfa_specialise_result {
    double compile_s; /**< wall clock, s */
    size_t bytes;     /**< of the shared object, its checksum trailer included */
    char compiler[256];
} tfa_specialise_result;

/**
 * Writes the C tables of a model, as lib/dynamics/specialised/specialised.c reads them, in one
 * malloc block: numbers with names and units, no algorithm. Names of the URDF appear in comments
 * only, every character but letters, digits and . _ - replaced.
 * @return TFA_OK; TFA_E_ARGUMENT; TFA_E_MEMORY; as tfa_specialised_check
 */
TFA_API TFA_CHECKED int tfa_specialised_tables(const tfa_model *model, char **text);

/**
 * Compiles a kernel for the model and this machine's instruction set with the system's compiler, in
 * child processes with limits on time, memory and file size; appends its checksum; and puts it at
 * `path`, whole or not at all. Nothing of it is run. Takes seconds; not for a thread that serves
 * requests.
 *
 * @param result  may be NULL
 * @param reason  gets what went wrong, the compiler's first words included; always terminated; may
 *  be
 *                NULL with size 0
 * @return TFA_OK; TFA_E_ARGUMENT; TFA_E_UNSUPPORTED (tfa_specialised_check, or no compiler);
 *  TFA_E_FILE
 *         (no sources, or `path` cannot be written); TFA_E_TIMEOUT; TFA_E_NOT_COMPUTED (the
 *         compiler
 *         failed); TFA_E_MEMORY; TFA_E_SYSTEM. One thread for each path.
 */
TFA_API TFA_CHECKED int tfa_specialised_build(const tfa_model *model,
                                              const tfa_specialise_options *options,
                                              const char *path, tfa_specialise_result *result,
                                              char *error_text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
