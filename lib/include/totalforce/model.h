/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Models: a robot compiled for computing, constant and shared by any number of threads.
 *
 * Links joined by fixed joints become one body. Each body frame is turned so that the axis of its
 * joint is an axis of the frame; where possible it follows Denavit and Hartenberg in Craig's form
 * (Craig, Introduction to Robotics). Spatial inertias, model of a tree and expanded tree of
 * freedoms: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 2, 4 and 6.
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

/** Opaque; constant once it is compiled. Any thread may read it. */
typedef struct tfa_model tfa_model;

/** Connection of the root link to the world. */
typedef enum tfa_base {
    TFA_BASE_FIXED = 0,   /**< the root link does not move */
    TFA_BASE_FLOATING = 1 /**< six freedoms between the world and the root link */
} tfa_base;
/** Their words: X(value, word) */
#define TFA_BASE_WORDS(X)                                                                          \
    X(TFA_BASE_FIXED, "fixed")                                                                     \
    X(TFA_BASE_FLOATING, "floating")

/** Policy for inertias that no rigid body has: a negative eigenvalue, or a principal moment larger
 *  than the sum of the other two (triangle inequality; Wensing, Kim and Slotine, IEEE RA-L 3(1),
 *  2018). Links merged into a fixed base cause warnings only. */
typedef enum tfa_inertia_policy {
    TFA_INERTIA_STRICT = 0, /**< a negative eigenvalue is an error, a broken triangle a warning */
    TFA_INERTIA_WARN,       /**< both are warnings; the inertia is used as written */
    TFA_INERTIA_REPAIR,     /**< negative eigenvalues become 0; a warning gives both values */
    TFA_INERTIA_STRICT_PHYSICAL, /**< both are errors */
} tfa_inertia_policy;
/** Their words: X(value, word) */
#define TFA_INERTIA_WORDS(X)                                                                       \
    X(TFA_INERTIA_STRICT, "strict")                                                                \
    X(TFA_INERTIA_WARN, "warn")                                                                    \
    X(TFA_INERTIA_REPAIR, "repair")                                                                \
    X(TFA_INERTIA_STRICT_PHYSICAL, "strict-physical")

/** Policy for joints that mimic another joint, the leader. */
typedef enum tfa_mimic_policy {
    TFA_MIMIC_FREE = 0, /**< an ordinary joint with its own coordinates; a warning says so */
    TFA_MIMIC_PROJECT,  /**< exact: q = multiplier q_leader + offset; absent from q, v, tau, qdd */
    TFA_MIMIC_LOCK,     /**< fixed at its position for a leader at 0 */
} tfa_mimic_policy;
/** Their words: X(value, word) */
#define TFA_MIMIC_WORDS(X)                                                                         \
    X(TFA_MIMIC_FREE, "free")                                                                      \
    X(TFA_MIMIC_PROJECT, "project")                                                                \
    X(TFA_MIMIC_LOCK, "lock")

/** A joint that a scene fixes at a position. */
typedef struct tfa_lock {
    const char *joint; /**< name in the file */
    double q[7]; /**< the joint's coordinates, rad or m (docs/conventions.md); the rest unused */
} tfa_lock;

/** A rigid load on a link. */
typedef struct tfa_payload {
    const char *link;  /**< name in the file */
    double mass;       /**< kg, not negative */
    double com[3];     /**< centre of mass, m, in the link frame */
    double inertia[6]; /**< ixx ixy ixz iyy iyz izz about its centre of mass, kg m^2, link axes */
} tfa_payload;

/** A motor's rotor: its inertia times the square of the joint's `reduction` is added to the
 *  armature of the joint. */
typedef struct tfa_rotor {
    const char *joint; /**< name in the file */
    double inertia;    /**< about the rotor's axis, kg m^2 (prismatic joints: reduction in rad/m),
                            not negative */
} tfa_rotor;

#define TFA_MAX_LINK_MODES 12 /**< modes of one link */

/** How the modes of a flexible link move one of its child joints: for each mode, per unit of its
 *  coordinate, the translation of the joint's origin (m) and the rotation of its axes (rad), linear
 *  first, in the axes of the link. */
typedef struct tfa_mode_shape {
    const char *joint;   /**< name in the file: a joint, fixed ones too, whose parent is the link */
    const double *shape; /**< mode_count x 6 */
} tfa_mode_shape;

/**
 * Modes of a flexible link: it is clamped at its frame, and deforms by small coordinates eta. With
 * mass m, centre of mass c0 and inertia I about it of the description's link, its velocity w, V at
 * its origin, the momenta (l_k, a_k) and the matrices M, K, D, lambda = sum eta_k l_k and
 * c = c0 + lambda / m:
 *
 *     T = 1/2 m |V + w x c + lambda'/m|^2 + 1/2 w.I w + sum eta'_k w.(a_k - c0 x l_k)
 *         + 1/2 eta'^T (M - l^T l / m) eta'
 *     potential: 1/2 eta^T K eta - gravity . (m origin + R m c);  damping forces - D eta'
 *
 * The centre of mass moves exactly; what belongs to the motion about it is constant. The origin of
 * child joint j stands at r_j + sum eta_k d_jk; its axes are turned by the rotation whose Rodrigues
 * vector is half of sum eta_k t_jk. Links behind a fixed child joint are rigid and move with it.
 * What is left out: docs/methods.md.
 */
typedef struct tfa_link_modes {
    const char *link;          /**< name in the file */
    size_t mode_count;         /**< 1..TFA_MAX_LINK_MODES */
    const double *momentum;    /**< mode_count x 6: l_k, kg m, and a_k about the link's origin,
                                    kg m^2, per unit rate, linear first: integrals of phi and of
                                    r x phi over the mass; axes of the link */
    const double *mass;        /**< mode_count^2, M: integrals of phi_j . phi_k */
    const double *stiffness;   /**< mode_count^2, K: symmetric */
    const double *damping;     /**< mode_count^2, D: symmetric; NULL: 0 */
    const double *limit;       /**< mode_count: bound of each |eta|, above 0, up to which the
                                    modes hold; NULL: none */
    const tfa_mode_shape *shapes; /**< of every child joint of the link */
    size_t shape_count;           /**< of shapes */
} tfa_link_modes;

/**
 * Reduction of a robot to the part that a client needs; exact, because it is folded into the
 * constants. Links and joints outside the scene are absent from every array and list.
 */
typedef struct tfa_scene {
    const char *root;        /**< link that becomes the root; NULL: the root of the file */
    const char *const *tips; /**< fixed base: keeps only the trees that carry one of these links */
    size_t tip_count;        /**< 0: all trees */
    const tfa_lock *locks;   /**< joints that stand still */
    size_t lock_count;       /**< of locks */
    const tfa_payload *payloads; /**< several may be on one link */
    size_t payload_count;        /**< of payloads */
    const tfa_link_modes *modes; /**< flexible links, each once */
    size_t modes_count;          /**< of modes */
    const tfa_constraint *constraints; /**< besides those of the file */
    size_t constraint_count;           /**< of constraints */
    const char *const *actuated;       /**< joints with a motor (constrained_inverse_dynamics);
                                            a mimic's follower stands for its leader */
    size_t actuated_count;             /**< of actuated; 0: all joints have one */
    const tfa_rotor *rotors;           /**< of joints, each once */
    size_t rotor_count;                /**< of rotors */
} tfa_scene;

#define TFA_SNAP_MAX 0.01 /**< largest tfa_model_options.snap, rad */
#define TFA_FRICTION_VELOCITY 0.01 /**< default of friction_velocity, rad/s or m/s */
#define TFA_FRICTION_VELOCITY_MIN 1e-9 /**< smallest friction_velocity but 0 */

/** Zero-initialise for the defaults. */
typedef struct tfa_model_options {
    tfa_base base;          /**< of the root link */
    const double *gravity;  /**< 3 numbers, m/s^2, world frame; NULL: 0 0 -9.80665 */
    uint32_t rotor_inertia; /**< 1: adds each joint's `rotor` to its armature; 0: a note says that
                                 the file has some */
    uint32_t damping;       /**< 1: subtracts damping times velocity from tau; 0: not used */
    uint32_t friction;      /**< 1: subtracts friction times v / sqrt(v^2 + friction_velocity^2), a
                                 smooth sign of v, from tau; 0: not used, a note says so */
    double friction_velocity;      /**< rad/s or m/s, 1e-9 and up: where that sign is 0.7; below
                                        it friction is viscous, friction / friction_velocity v;
                                        0: TFA_FRICTION_VELOCITY */
    uint32_t lock_massless_leaves; /**< 1: joints that move nothing with mass become fixed at 0;
                                        0: they are an error */
    tfa_inertia_policy inertia;    /**< for inertias that no body can have */
    tfa_mimic_policy mimic;        /**< for joints that mimic others */
    const tfa_scene *scene;        /**< NULL: the whole robot */
    double snap; /**< rad, 0 to TFA_SNAP_MAX: rotations of joints and inertial frames within this
                      angle of right angles about the axes become exactly that; a note gives the
                      largest change. 0: as in the file */
} tfa_model_options;

/** A public joint, in declared order (document order, parents first, fixed joints absent). */
typedef struct tfa_joint_info {
    const char *name;    /**< as in the file */
    tfa_joint_type type; /**< as in the file */
    uint32_t q_index;    /**< first of its coordinates in q */
    uint32_t q_count;    /**< number of them */
    uint32_t v_index;    /**< first of its freedoms in v, tau and qdd */
    uint32_t v_count;    /**< number of them */
    uint32_t body;       /**< index of the body that it moves */
    double armature;     /**< reflected rotor inertia in use, kg m^2 or kg */
    double damping;      /**< in use, N m s/rad or N s/m */
    double friction;     /**< in use, N m or N */
    uint32_t actuated;   /**< 1: it has a motor (tfa_scene.actuated) */
} tfa_joint_info;

/** Role of a joint of the file in the model. */
typedef enum tfa_fate {
    TFA_FATE_MOVES = 0,   /**< moves a body of its own */
    TFA_FATE_FIXED = 1,   /**< fixed in the file: its links are merged */
    TFA_FATE_LOCKED = 2,  /**< fixed by a scene, by TFA_MIMIC_LOCK or as a massless leaf */
    TFA_FATE_FUSED = 3,   /**< moves; one of several joints of a body (massless links between) */
    TFA_FATE_FOLLOWS = 4, /**< moves with its leader (TFA_MIMIC_PROJECT) */
    TFA_FATE_ABSENT = 5,  /**< not part of the scene */
} tfa_fate;
/** Their words: X(value, word) */
#define TFA_FATE_WORDS(X)                                                                          \
    X(TFA_FATE_MOVES, "moves")                                                                     \
    X(TFA_FATE_FIXED, "fixed")                                                                     \
    X(TFA_FATE_LOCKED, "locked")                                                                   \
    X(TFA_FATE_FUSED, "fused")                                                                     \
    X(TFA_FATE_FOLLOWS, "follows")                                                                 \
    X(TFA_FATE_ABSENT, "absent")

/** A joint as the file declares it, in document order, parents first. */
typedef struct tfa_declared_joint {
    const char *name;    /**< as in the file */
    tfa_joint_type type; /**< as in the file */
    tfa_fate fate;       /**< in the model */
    int32_t body;        /**< body that its child link belongs to; -1: the world or absent */
    int32_t joint;       /**< index of the public joint; -1: it has no coordinates of its own */
    int32_t leader;      /**< public joint that it follows, or -1 */
    double multiplier;   /**< of a follower: q = multiplier * q[leader] + offset */
    double offset;       /**< rad or m; chained mimics are resolved */
} tfa_declared_joint;

/** Mass properties of one body, payloads of the scene included. */
typedef struct tfa_body_info {
    const char *name;    /**< of the child link of its (last) joint */
    int32_t parent;      /**< body index, -1: the world */
    uint32_t freedoms;   /**< of its joint, 1 to 6 */
    double mass;         /**< kg */
    double com[3];       /**< centre of mass, m, in the frame of that link */
    double gyration_min; /**< least radius of gyration about the centre of mass, m */
    double gyration_max; /**< largest one, m */
    double condition;    /**< largest over smallest principal moment about the centre of mass;
                           infinite for points and rods; NaN without mass */
    uint32_t regular;    /**< 1: the inertia can be inverted, so that TFA accepts the body on a main
                           chain */
} tfa_body_info;

/** A link of the file: a frame on a body, which may carry several. */
typedef struct tfa_frame_info {
    const char *name; /**< of the link */
    int32_t body;     /**< body that carries the frame; -1: fixed to the world */
} tfa_frame_info;

/** A constraint of a model: bit k of tfa_request.constraints is the k-th. */
typedef struct tfa_constraint_info {
    const char *name;    /**< as in the file or the scene */
    int32_t frame[2];    /**< of its links; -1: the world */
    uint32_t rows;       /**< that it holds, as tfa_constraint.rows */
    uint32_t unilateral; /**< as tfa_constraint.unilateral */
} tfa_constraint_info;

/** A mode of a flexible link: one modal coordinate of requests. */
typedef struct tfa_mode_info {
    const char *link; /**< name in the file */
    uint32_t index;   /**< among the modes of that link */
    double limit;     /**< bound of its coordinate; infinite: none */
} tfa_mode_info;

/** Sizes and totals of a model. */
typedef struct tfa_model_summary {
    uint32_t links;      /**< as declared */
    uint32_t joints;     /**< as declared, fixed joints included */
    uint32_t bodies;     /**< after merging, the floating base included */
    uint32_t q_count;    /**< coordinates of the joints, base excluded */
    uint32_t v_count;    /**< freedoms of the joints, base excluded */
    uint32_t depth;      /**< bodies on the longest path from the root */
    uint32_t main_chain; /**< bodies on the longest main chain (path to the deepest body) */
    double moving_mass;  /**< kg */
    double total_mass;   /**< kg, the fixed base included */
    double com[3];    /**< centre of mass of the total mass, m, in the root link's frame, all q at 0
                        (floating joints: no displacement, no rotation) */
    uint32_t fixed;   /**< joints of the fate TFA_FATE_FIXED */
    uint32_t locked;  /**< TFA_FATE_LOCKED */
    uint32_t fused;   /**< TFA_FATE_FUSED */
    uint32_t follows; /**< TFA_FATE_FOLLOWS */
    uint32_t absent;  /**< TFA_FATE_ABSENT */
    tfa_base base;    /**< of the root link */
    double gravity[3];     /**< m/s^2, world frame */
    int32_t singular_body; /**< body on a main chain whose inertia cannot be inverted, or -1 */
    uint32_t mimics;       /**< freedoms that follow others */
} tfa_model_summary;

/**
 * Size of the memory of tfa_model_init, in bytes; 0 if the description cannot be compiled
 * (tfa_model_init reports why). Cost: as tfa_model_init. Any thread.
 */
TFA_API size_t tfa_model_size(const tfa_description *description, const tfa_model_options *options);

/**
 * Compiles a description into `memory`: merges bodies joined by fixed joints, fuses massless ones,
 * aligns body frames with joint axes, precomputes constants in quadruple precision and rounds them
 * once, plans the main chains, and computes the hash. Refuses robots whose mass matrix M is
 * singular at every q. The description is not needed afterwards.
 *
 * Cost: O(N) for N bodies; temporary allocations only. Any thread; one thread for each report.
 *
 * @param memory       64-byte aligned; the model lives in it
 * @param size         at least tfa_model_size()
 * @param description  as tfa_model_create
 * @param options      NULL: all defaults
 * @param report       gets the messages; may be NULL
 * @param model        NULL on error
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or a base or policy that does not exist); TFA_E_VALUE
 *         (gravity, snap or friction_velocity out of range); TFA_E_MEMORY (`memory` too small or
 *         not aligned, or a temporary allocation failed); TFA_E_MODEL (a loop, two parents, an
 *         invalid inertia, a zero axis, an unknown name in the scene, ...: the report names it and
 *         the remedy); TFA_E_NO_MASS (a joint moves no mass, or M is singular at every q).
 */
TFA_API TFA_CHECKED int tfa_model_init(void *memory, size_t size,
                                       const tfa_description *description,
                                       const tfa_model_options *options, tfa_report *report,
                                       const tfa_model **model);

/** As tfa_model_init, in memory that it allocates; TFA_E_MEMORY: the allocation failed. Release
 *  with tfa_model_free. */
TFA_API TFA_CHECKED int tfa_model_create(const tfa_description *description,
                                         const tfa_model_options *options, tfa_report *report,
                                         tfa_model **model);

/**
 * Creates a model that shares the constants of another and differs in gravity, in payloads, or in
 * both; with the same payloads it equals, to the bit and the hash, a model compiled from the scene.
 * `model` must outlive it. Cost: O(N), with payloads also O(payloads x frames). Any thread.
 *
 * @param model          the robot as it is
 * @param gravity        3 numbers, m/s^2, world frame; NULL: that of `model`
 * @param payloads       replace those of `model`; payload_count 0: those of `model`
 * @param payload_count  of payloads
 * @param report         gets the messages; may be NULL
 * @param derived        release with tfa_model_free; NULL on error
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_VALUE (a number is not finite, a mass negative);
 *         TFA_E_LINK (no such link); TFA_E_MODEL (an inertia that is not positive semidefinite, or
 *         a link inside a fused body); TFA_E_NO_MASS (without a payload of `model` a joint moves no
 *         mass); TFA_E_MEMORY.
 */
TFA_API TFA_CHECKED int tfa_model_derive(const tfa_model *model, const double *gravity,
                                         const tfa_payload *payloads, size_t payload_count,
                                         tfa_report *report, tfa_model **derived);

/** As tfa_urdf_load, then tfa_model_create; with the statuses of both and the thread rule of
 *  tfa_urdf_load. The description is released again. */
TFA_API TFA_CHECKED int tfa_model_load(const char *urdf_path, const tfa_model_options *options,
                                       tfa_report *report, tfa_model **model);

/** Releases a model of tfa_model_create, _load or _derive. No workspace, pool or derived model may
 *  use it any more. NULL is allowed. */
TFA_API void tfa_model_free(tfa_model *model);

/* The remaining functions read a model, which may not be NULL: any thread, O(1) except the find
 * functions, which compare every name. Strings live as long as the model. */

/** Name of the robot in the file. */
TFA_API const char *tfa_model_name(const tfa_model *model);
/** SHA-256 (FIPS 180-4) of all constants that decide answers, and of the names in their order: 32
 *  bytes. */
TFA_API const uint8_t *tfa_model_hash(const tfa_model *model);
/** The hash as 64 hexadecimal digits. */
TFA_API const char *tfa_model_hash_text(const tfa_model *model);
/** First eight bytes of the hash as a number, most significant first: tfa_reply.model. Its 16
 *  hexadecimal digits are the first 16 of the hash text. */
TFA_API uint64_t tfa_model_tag(const tfa_model *model);
/** Sizes and totals. */
TFA_API tfa_model_summary tfa_model_summarise(const tfa_model *model);
/** Number of coordinates in q, without those of a floating base. */
TFA_API uint32_t tfa_model_q_count(const tfa_model *model);
/** Number of freedoms in v, tau and qdd, without those of a floating base. */
TFA_API uint32_t tfa_model_v_count(const tfa_model *model);
/** What a radian of a tip counts beside a metre where a request does not say it: a quarter of the
 *  longest way from a root along joints to a centre of mass, m; 1 if there is none. */
TFA_API double tfa_model_characteristic_length(const tfa_model *model);
/** 6 for a floating base, else 0. */
TFA_API uint32_t tfa_model_base_freedoms(const tfa_model *model);
/** Number of public joints. */
TFA_API uint32_t tfa_model_joint_count(const tfa_model *model);
/** Public joint `joint`; all zero if it does not exist. */
TFA_API tfa_joint_info tfa_model_joint(const tfa_model *model, uint32_t joint);
/** Index of the public joint with this name, or -1. */
TFA_API int32_t tfa_model_find_joint(const tfa_model *model, const char *name);
/** Number of constraints. */
TFA_API uint32_t tfa_model_constraint_count(const tfa_model *model);
/** Constraint `constraint`: those of the file, then those of the scene; name NULL if it does not
 *  exist. */
TFA_API tfa_constraint_info tfa_model_constraint(const tfa_model *model, uint32_t constraint);
/** Index of the constraint with this name, or -1. */
TFA_API int32_t tfa_model_find_constraint(const tfa_model *model, const char *name);
/** Number of modes of all flexible links: of modal coordinates in requests. */
TFA_API uint32_t tfa_model_mode_count(const tfa_model *model);
/** Mode `mode`, link by link in the order of the frames; link NULL if it does not exist. */
TFA_API tfa_mode_info tfa_model_mode(const tfa_model *model, uint32_t mode);
/** Number of frames: links in the scene. */
TFA_API uint32_t tfa_model_frame_count(const tfa_model *model);
/** Frame `frame`; name NULL and body -1 if it does not exist. */
TFA_API tfa_frame_info tfa_model_frame(const tfa_model *model, uint32_t frame);
/** Index of the frame of the link with this name, or -1. */
TFA_API int32_t tfa_model_find_frame(const tfa_model *model, const char *name);
/** Number of joints in the file, of any fate. */
TFA_API uint32_t tfa_model_declared_count(const tfa_model *model);
/** Joint `index` of the file; name NULL and indices -1 if it does not exist. */
TFA_API tfa_declared_joint tfa_model_declared(const tfa_model *model, uint32_t index);
/** Body `body`; all zero if it does not exist. */
TFA_API tfa_body_info tfa_model_body(const tfa_model *model, uint32_t body);
/**
 * Inertial parameters p of a body in the frame of one of its links, as the columns of a regressor
 * expect them: mass m (kg), m c (kg m, three), inertia ixx ixy ixz iyy iyz izz about the origin of
 * that frame (kg m^2), axes of the link. Payloads of the scene count; rotors do not. Zero for links
 * that are fixed to the world, do not exist, or lie inside a fused body and carry no mass.
 */
TFA_API void tfa_model_parameters(const tfa_model *model, uint32_t frame, double parameters[10]);
/** tfa_body_info.name of a body; "" if it does not exist. */
TFA_API const char *tfa_model_body_name(const tfa_model *model, uint32_t body);
/** Frame of the link that names a body, as in TFA_FIELD_BODY; 0 if the body does not exist. */
TFA_API uint32_t tfa_model_body_frame(const tfa_model *model, uint32_t body);
/** Index of the parent body; -1: the world, or the body does not exist. */
TFA_API int32_t tfa_model_body_parent(const tfa_model *model, uint32_t body);

#ifdef __cplusplus
}
#endif
#endif
