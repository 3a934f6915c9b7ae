/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A model is a robot compiled for computing: immutable, shared by any number of threads.
 */
#ifndef TOTALFORCE_MODEL_H
#define TOTALFORCE_MODEL_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/description.h>
#include <totalforce/report.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Opaque. Compiled once by tfa_model_init, constant from then on; any thread may read it. */
typedef struct tfa_model tfa_model;

typedef enum tfa_base {
    TFA_BASE_FIXED = 0,   /**< the root link does not move */
    TFA_BASE_FLOATING = 1 /**< six freedoms between the world and the root link */
} tfa_base;

typedef struct tfa_model_options {
    tfa_base base;
    const double *gravity;  /**< 3 numbers, m/s^2, world frame; NULL: 0 0 -9.80665 */
    uint32_t rotor_inertia; /**< 1: adds each joint's `rotor` to its armature; 0: a note says that
                                 the file has some */
} tfa_model_options;

/** One public joint, in declared order (document order, parents first, fixed joints absent). */
typedef struct tfa_joint_info {
    const char *name;
    tfa_joint_type type;
    uint32_t q_index, q_count; /**< its coordinates in q */
    uint32_t v_index, v_count; /**< its freedoms in v, tau and qdd */
    uint32_t body;             /**< the body it moves */
    double armature;
} tfa_joint_info;

/** One link of the file, kept by name as a frame although its body may hold several links. */
typedef struct tfa_frame_info {
    const char *name;
    int32_t body; /**< body that carries the frame; -1: fixed to the world */
} tfa_frame_info;

/** Where a description became smaller. */
typedef struct tfa_model_summary {
    uint32_t links, joints;    /**< as declared, fixed joints included */
    uint32_t bodies;           /**< after merging, the floating base included */
    uint32_t q_count, v_count; /**< coordinates and freedoms of the joints, base excluded */
    uint32_t depth;            /**< bodies on the longest path from the root */
    uint32_t main_chain;       /**< bodies on the main chain of the largest tree */
    double moving_mass;        /**< kg */
    double total_mass;         /**< kg, the fixed base included */
    tfa_base base;
    double gravity[3];
    int32_t singular_body; /**< body on a main chain whose inertia cannot be inverted, or -1 */
} tfa_model_summary;

/**
 * Bytes that tfa_model_init needs for this description, 64-byte aligned memory. 0 when the
 * description cannot be compiled (call tfa_model_init to hear why).
 */
TFA_API size_t tfa_model_size(const tfa_description *description, const tfa_model_options *options);

/**
 * Compiles a description into `memory`: merges bodies joined by fixed joints, aligns each body
 * frame with its joint axis, precomputes the constant terms, plans the main chains, hashes.
 *
 * @param memory  64-byte aligned, at least tfa_model_size() bytes; the model lives in it
 * @param report  gets the messages; may be NULL
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, a base that does not exist); TFA_E_VALUE (gravity not
 *         finite); TFA_E_MEMORY (too small or not aligned); TFA_E_MODEL (a loop, two parents, an inertia that is
 *         not positive semidefinite, a zero axis, ...); TFA_E_NO_MASS (a massless moving leaf).
 * The description is not needed afterwards. Cost: O(bodies). Allocates nothing that stays.
 */
TFA_API TFA_CHECKED int tfa_model_init(void *memory, size_t size,
                                       const tfa_description *description,
                                       const tfa_model_options *options, tfa_report *report,
                                       const tfa_model **model);

/** tfa_model_size + aligned_alloc + tfa_model_init. Release with tfa_model_free. */
TFA_API TFA_CHECKED int tfa_model_create(const tfa_description *description,
                                         const tfa_model_options *options, tfa_report *report,
                                         tfa_model **model);

/** tfa_urdf_load + tfa_model_create. */
TFA_API TFA_CHECKED int tfa_model_load(const char *urdf_path, const tfa_model_options *options,
                                       tfa_report *report, tfa_model **model);

/** Releases a model made by tfa_model_create or tfa_model_load. NULL is allowed. */
TFA_API void tfa_model_free(tfa_model *model);

/* The rest reads the model: any thread, no cost worth naming, strings live as long as the model. */

TFA_API const char *tfa_model_name(const tfa_model *model);
/** SHA-256 of all that decides the answers and of the names in their order: 32 bytes. */
TFA_API const uint8_t *tfa_model_hash(const tfa_model *model);
/** The hash as 64 hexadecimal digits. */
TFA_API const char *tfa_model_hash_text(const tfa_model *model);
TFA_API tfa_model_summary tfa_model_summarise(const tfa_model *model);
/** Coordinates in q, joints only (a floating base has its own fields). */
TFA_API uint32_t tfa_model_q_count(const tfa_model *model);
/** Freedoms in v, tau, qdd, joints only. */
TFA_API uint32_t tfa_model_v_count(const tfa_model *model);
/** 6 for a floating base, else 0. */
TFA_API uint32_t tfa_model_base_freedoms(const tfa_model *model);
TFA_API uint32_t tfa_model_joint_count(const tfa_model *model);
TFA_API tfa_joint_info tfa_model_joint(const tfa_model *model, uint32_t joint);
/** Index of the moving joint with this name, or -1. */
TFA_API int32_t tfa_model_find_joint(const tfa_model *model, const char *name);
TFA_API uint32_t tfa_model_frame_count(const tfa_model *model);
TFA_API tfa_frame_info tfa_model_frame(const tfa_model *model, uint32_t frame);
/** Index of the link's frame with this name, or -1. */
TFA_API int32_t tfa_model_find_frame(const tfa_model *model, const char *name);
/** Name of the link that gave body its name (the child link of its joint). */
TFA_API const char *tfa_model_body_name(const tfa_model *model, uint32_t body);
/** Frame of that link: what a reply's TFA_FIELD_BODY names. 0 for a body that does not exist. */
TFA_API uint32_t tfa_model_body_frame(const tfa_model *model, uint32_t body);
/** Body that carries body `body` (its parent), or -1 for the world. */
TFA_API int32_t tfa_model_body_parent(const tfa_model *model, uint32_t body);

#ifdef __cplusplus
}
#endif
#endif
