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

/** What an inertia that no body can have leads to. Bodies that do not move (merged into a fixed
 * base) are only ever warned about. */
typedef enum tfa_inertia_policy {
    TFA_INERTIA_STRICT = 0, /**< a negative eigenvalue is an error, a broken triangle a warning */
    TFA_INERTIA_WARN,       /**< both are warnings; the inertia is used as written */
    TFA_INERTIA_REPAIR,     /**< negative eigenvalues become 0, a warning says what changed */
    TFA_INERTIA_STRICT_PHYSICAL, /**< both are errors */
} tfa_inertia_policy;

/** What becomes of a joint that mimics another. */
typedef enum tfa_mimic_policy {
    TFA_MIMIC_FREE = 0, /**< an ordinary joint with coordinates of its own; a warning says so */
    TFA_MIMIC_PROJECT,  /**< exact: q = multiplier q_leader + offset; absent from q, v, tau, qdd */
    TFA_MIMIC_LOCK,     /**< fixed where it stands when its leader is at 0 */
} tfa_mimic_policy;

/** A joint that does not move in a scene: as if it were fixed, at these coordinates. */
typedef struct tfa_lock {
    const char *joint;
    double q[7]; /**< as many as the joint has coordinates */
} tfa_lock;

/** A load on a link, rigidly. */
typedef struct tfa_payload {
    const char *link;
    double mass;       /**< kg, not negative */
    double com[3];     /**< centre of mass, m, in the link frame */
    double inertia[6]; /**< ixx ixy ixz iyy iyz izz about its centre of mass, kg m^2, link axes */
} tfa_payload;

/**
 * What a client needs of a robot, so that no more is modelled: all of it is folded into the
 * constants, exactly. Joints and links that are left out are absent from every array and list.
 */
typedef struct tfa_scene {
    /** only what hangs from this link, which takes the root's place; NULL: all */
    const char *root;
    const char *const *tips; /**< fixed base: only the trees that carry one of these links */
    size_t tip_count;        /**< 0: all trees */
    const tfa_lock *locks;
    size_t lock_count;
    const tfa_payload *payloads;
    size_t payload_count;
} tfa_scene;

#define TFA_SNAP_MAX 0.01 /**< rad: more is no rounding */

/** Zero-initialise for the defaults. */
typedef struct tfa_model_options {
    tfa_base base;
    const double *gravity;  /**< 3 numbers, m/s^2, world frame; NULL: 0 0 -9.80665 */
    uint32_t rotor_inertia; /**< 1: adds each joint's `rotor` to its armature; 0: a note says that
                                 the file has some */
    uint32_t damping;       /**< 1: subtracts damping times velocity from tau; 0: not used */
    uint32_t lock_massless_leaves; /**< 1: joints that move nothing with mass become fixed at 0;
                                        0: they are an error */
    tfa_inertia_policy inertia;
    tfa_mimic_policy mimic;
    const tfa_scene *scene; /**< NULL: the whole robot */
    double snap; /**< rad, at most TFA_SNAP_MAX: rotations of joints and inertias this near to right
                      angles about the axes become exactly that, and a note says what the largest
                      change was; 0: as in the file */
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

/** What became of a joint of the file. */
typedef enum tfa_fate {
    TFA_FATE_MOVES = 0,   /**< it moves a body of its own */
    TFA_FATE_FIXED = 1,   /**< fixed in the file: its links were merged */
    TFA_FATE_LOCKED = 2,  /**< made fixed by a scene, by mimic = lock or as a massless leaf */
    TFA_FATE_FUSED = 3,   /**< moves; one of several joints of a body (massless links between) */
    TFA_FATE_FOLLOWS = 4, /**< moves with its leader (mimic = project) */
    TFA_FATE_ABSENT = 5,  /**< not part of the scene */
} tfa_fate;

/** A joint as the file declares it, in document order, parents first. */
typedef struct tfa_declared_joint {
    const char *name;
    tfa_joint_type type;
    tfa_fate fate;
    int32_t body;   /**< body that its child link became part of; -1: the world or absent */
    int32_t joint;  /**< public joint; -1: it has no coordinates of its own */
    int32_t leader; /**< public joint that it follows, or -1 */
    double multiplier, offset; /**< of a follower, chained mimics resolved */
} tfa_declared_joint;

/** The mass of one body at the origin of its joint, and how well it can be inverted. */
typedef struct tfa_body_info {
    const char *name; /**< of the link that gave it its name: the child of its (last) joint */
    int32_t parent;   /**< body index, -1: the world */
    uint32_t freedoms;
    double mass;                       /**< kg */
    double com[3];                     /**< m, in the frame of the link that names it */
    double gyration_min, gyration_max; /**< radii of gyration about the centre of mass, m */
    double condition; /**< largest over smallest principal moment about the centre of mass;
                           infinite for points and rods; NaN without mass */
    uint32_t regular; /**< 1: the inertia can be inverted: TFA takes it on a main chain */
} tfa_body_info;

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
    double com[3]; /**< centre of mass of all that, m, in the root link's frame, all q at 0 (free
                        joints: no displacement, no rotation) */
    uint32_t fixed, locked, fused, follows, absent; /**< joints by fate */
    tfa_base base;
    double gravity[3];
    int32_t singular_body; /**< body on a main chain whose inertia cannot be inverted, or -1 */
    uint32_t mimics;       /**< freedoms that follow others */
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
 *         finite, snap out of range); TFA_E_MEMORY (too small or not aligned); TFA_E_MODEL (a loop,
 *         two parents, an inertia that is
 *         not positive semidefinite, a zero axis, ...); TFA_E_NO_MASS (a massless moving leaf, or a
 *         mass
 *         matrix that is singular at every q).
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

/**
 * A model that shares the constants of another and differs in gravity, in payloads, or in both:
 * several scenes of one robot cost little more than one. `model` must outlive it.
 *
 * @param gravity   3 numbers, m/s^2; NULL: as `model`
 * @param payloads  in place of those that `model` carries; payload_count 0: as `model`
 * @return TFA_OK; TFA_E_ARGUMENT; TFA_E_VALUE (not finite, mass negative); TFA_E_LINK; TFA_E_MODEL
 *         (an inertia that is not positive semidefinite; a massless link inside a fused body);
 *         TFA_E_NO_MASS (a payload in `model` was all that moved with a joint); TFA_E_MEMORY.
 *         Release with tfa_model_free.
 */
TFA_API TFA_CHECKED int tfa_model_derive(const tfa_model *model, const double *gravity,
                                         const tfa_payload *payloads, size_t payload_count,
                                         tfa_report *report, tfa_model **derived);

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
/** The first eight bytes of the hash as a number, most significant first: what replies carry. Its
 * 16 hexadecimal digits are the first 16 of the hash text. */
TFA_API uint64_t tfa_model_tag(const tfa_model *model);
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
/** Joints of the file, whatever became of them. */
TFA_API uint32_t tfa_model_declared_count(const tfa_model *model);
TFA_API tfa_declared_joint tfa_model_declared(const tfa_model *model, uint32_t index);
/** All zero (name NULL) for a body that does not exist. */
TFA_API tfa_body_info tfa_model_body(const tfa_model *model, uint32_t body);
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
