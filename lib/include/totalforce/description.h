/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Descriptions: links and joints of a robot as its file states them, neither merged nor reordered,
 * and the functions that read URDF (http://wiki.ros.org/urdf/XML) or MJCF (docs/loading.md).
 *
 * Rotations and axes have a low part: the value is quat + quat_low (axis + axis_low), which is
 * within 1e-32 of rpy and axis of the file. A program that writes quat or axis sets the low part
 * to 0; the double is then the value.
 */
#ifndef TOTALFORCE_DESCRIPTION_H
#define TOTALFORCE_DESCRIPTION_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/report.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Joint types of URDF; coordinates q and velocities v as in docs/conventions.md. */
typedef enum tfa_joint_type {
    TFA_JOINT_FIXED = 0,      /**< no q, no v */
    TFA_JOINT_REVOLUTE = 1,   /**< 1 q (rad), 1 v: rotation about the axis */
    TFA_JOINT_CONTINUOUS = 2, /**< as revolute, any winding */
    TFA_JOINT_PRISMATIC = 3,  /**< 1 q (m), 1 v: translation along the axis */
    TFA_JOINT_PLANAR = 4,     /**< 3 q (x, y in m, theta in rad), 3 v (see docs/conventions.md) */
    TFA_JOINT_FLOATING = 5,   /**< 7 q (x y z, quaternion x y z w), 6 v (linear, angular) */
} tfa_joint_type;

/** Their words, those of URDF: X(value, word) */
#define TFA_JOINT_TYPE_WORDS(X)                                                                    \
    X(TFA_JOINT_FIXED, "fixed")                                                                    \
    X(TFA_JOINT_REVOLUTE, "revolute")                                                              \
    X(TFA_JOINT_CONTINUOUS, "continuous")                                                          \
    X(TFA_JOINT_PRISMATIC, "prismatic")                                                            \
    X(TFA_JOINT_PLANAR, "planar")                                                                  \
    X(TFA_JOINT_FLOATING, "floating")

/** Numbers of a joint type in q and v. */
typedef struct tfa_joint_type_info {
    const char *name;     /**< as in URDF */
    uint32_t coordinates; /**< numbers in q */
    uint32_t freedoms;    /**< numbers in v, tau and qdd */
    uint32_t lengths;     /**< coordinates in m: the first ones */
    int32_t quaternion;   /**< coordinate that is the first of x y z w; -1: it has none */
} tfa_joint_type_info;

/** Numbers of a joint type; of any other number "unknown" without coordinates. Any thread. */
TFA_API tfa_joint_type_info tfa_joint_type_describe(uint32_t type);

/** A rigid link. The creator of the description owns the strings. SI units. */
typedef struct tfa_link {
    const char *name;   /**< unique among the links */
    uint32_t line;      /**< line of its declaration in the file; 0 if unknown */
    double mass;        /**< kg; 0 with zero inertia for a frame without `<inertial>` */
    double com[3];      /**< centre of mass, m, in the link frame */
    double quat[4];     /**< inertial frame in the link frame, x y z w */
    double quat_low[4]; /**< low part of quat */
    double inertia[6];  /**< ixx ixy ixz iyy iyz izz, kg m^2, about the centre of mass,
                            along the axes of the inertial frame */
    uint32_t inertial;  /**< 1: the file states mass and inertia, zeros included; 0: it has no
                            `<inertial>`, a warning if the link moves by itself */
    double last_digit;  /**< unit of the last decimal that the file prints of the inertia, kg m^2;
                            0: unknown. A negative moment that half a unit of each entry explains is
                            0 in a link that is merged into a good body */
} tfa_link;

/** tfa_joint.mimic: the file names a leader that it does not have; an error with the policies
 *  project and lock. */
#define TFA_MIMIC_UNKNOWN (-2)

/** A joint between two links. */
typedef struct tfa_joint {
    const char *name;    /**< unique among the joints */
    uint32_t line;       /**< line of its declaration; 0 if unknown */
    tfa_joint_type type; /**< decides how many coordinates it has */
    uint32_t parent;     /**< index of the parent link */
    uint32_t child;      /**< index of the child link */
    double xyz[3];       /**< joint origin in the parent link frame, m */
    double quat[4];      /**< joint frame in the parent link frame, x y z w */
    double quat_low[4];  /**< low part of quat */
    double axis[3];      /**< unit axis in the joint frame (plane normal for planar) */
    double axis_low[3];  /**< low part of axis */
    double armature;     /**< reflected rotor inertia, kg m^2 or kg, on each freedom */
    double rotor;        /**< reflected rotor inertia of the file (drake:rotor_inertia times the
                            square of drake:gear_ratio), kg m^2 or kg; added to armature with
                            tfa_model_options.rotor_inertia only */
    double damping;      /**< N m s/rad or N s/m; used with tfa_model_options.damping only */
    double friction;     /**< N m or N; used with tfa_model_options.friction only */
    double reduction;    /**< of its transmission, turns of the rotor per turn of the joint; 0: none
                            in the file, which counts as 1 (tfa_rotor) */
    int32_t mimic;       /**< index of the joint it follows; -1: none; TFA_MIMIC_UNKNOWN */
    double multiplier;   /**< q = multiplier * q[mimic] + offset */
    double offset;       /**< rad or m */
} tfa_joint;

/** An item of the file that no model uses, such as limits or transmissions. */
typedef struct tfa_unused {
    const char *item; /**< "velocity limits", "<gazebo>" */
    uint32_t line;    /**< of the first occurrence */
    size_t count;     /**< occurrences */
} tfa_unused;

#define TFA_MAX_CONSTRAINTS 32 /**< constraints of a model, those of file and scene */

/* Rows that a constraint holds: bit k is component k of the relative motion, linear x y z, angular
 * x y z. */
#define TFA_CONSTRAINT_POINT 0x07u /**< one point */
#define TFA_CONSTRAINT_HINGE 0x1fu /**< all but the rotation about z */
#define TFA_CONSTRAINT_WELD 0x3fu  /**< all */
/** Words of sets of rows, which YAML, JSON and Python combine: X(rows, word) */
#define TFA_CONSTRAINT_WORDS(X)                                                                    \
    X(TFA_CONSTRAINT_POINT, "point")                                                               \
    X(TFA_CONSTRAINT_HINGE, "hinge")                                                               \
    X(TFA_CONSTRAINT_WELD, "weld")                                                                 \
    X(0x01u, "x")                                                                                  \
    X(0x02u, "y")                                                                                  \
    X(0x04u, "z")                                                                                  \
    X(0x08u, "rx")                                                                                 \
    X(0x10u, "ry")                                                                                 \
    X(0x20u, "rz")

/**
 * A bilateral constraint between two frames: a loop that the tree of the file leaves open, or a
 * contact with the ground. The relative motion of the second frame, by axes of the first,
 *
 *     w = [R1^T (v2 - v1); R1^T (w2 - w1)] = J_c v,     v_k: velocity of the frame's origin
 *
 * is held in the chosen rows: requests say when, and which accelerations dw/dt they want
 * (constrained_dynamics).
 */
typedef struct tfa_constraint {
    const char *name;    /**< unique among the constraints */
    const char *link[2]; /**< names in the file; one may be NULL: the world, with a fixed base the
                              root link's frame */
    double pose[2][7];   /**< of the two frames in their links: x y z (m), quaternion x y z w; four
                              zeros: axes of the link */
    uint32_t rows;       /**< TFA_CONSTRAINT_ or any other choice, at least one */
    uint32_t unilateral; /**< 1: its force along z of the first frame can only push the second one
                              away, as the ground a foot; answers name it where it would have to
                              pull (TFA_ANSWER_PULLS) */
    uint32_t line;       /**< of its declaration in the file; 0 if unknown */
} tfa_constraint;

/** A tree of links: exactly one link, the root, is not the child of a joint. */
typedef struct tfa_description {
    const char *name;         /**< of the robot */
    tfa_link *links;          /**< in document order */
    size_t link_count;        /**< of links */
    tfa_joint *joints;        /**< in document order */
    size_t joint_count;       /**< of joints */
    const tfa_unused *unused; /**< in order of first occurrence; a model's report notes each */
    size_t unused_count;      /**< of unused */
    tfa_constraint *constraints; /**< loops that the tree leaves open; a model has those whose links
                                      are in its scene and move against each other */
    size_t constraint_count;     /**< of constraints */
    int root_is_free; /**< the source says so; 0: it says nothing. A model's base is its option */
} tfa_description;

#define TFA_URDF_PATH_MAX 4096 /**< bytes of a path, its NUL included */

/**
 * Finds the file that the name of a robot stands for, wherever one is given: here, in Python, on
 * the command line and in a daemon's configuration. Reads the environment; runs nothing. Any
 * thread, while none changes the environment.
 *
 *     package://PACKAGE/FILE, $(find PACKAGE)/FILE, $(find-pkg-share PACKAGE)/FILE
 *                    FOLDER/share/PACKAGE/FILE of the first FOLDER of AMENT_PREFIX_PATH that has
 *                    the package, or else FOLDER/PACKAGE/FILE of ROS_PACKAGE_PATH
 *     ~/FILE         below HOME
 *     file:///PATH   PATH, with %XX decoded
 *     otherwise      the name itself; other URIs and substitutions are refused
 *
 * @param name  as a user writes it
 * @param path  gets the path, which need not exist; with TFA_E_FILE the reason, which names what
 *              was searched
 * @param size  of path, bytes
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or no room); TFA_E_FILE (errno is set)
 */
TFA_API TFA_CHECKED int tfa_urdf_find(const char *name, char *path, size_t size);

/** Reads the file that tfa_urdf_find finds into `text`, a malloc block of `length` bytes and a NUL,
 *  in which MJCF holds the files that it includes; NULL on error. The report's file is its path. */
TFA_API TFA_CHECKED int tfa_urdf_read(const char *name, char **text, size_t *length,
                                      tfa_report *report);

/**
 * Reads a URDF or MJCF file into a description. Cost: O(file size). It does not print, opens no
 * file but those that MJCF includes, uses no network, and does not depend on the locale.
 *
 * Thread rule: one call at a time in a process (urdfdom's log handler is global).
 *
 * @param path         file name, or what tfa_urdf_find expands
 * @param description  one malloc block; release with tfa_description_free; NULL on error
 * @param report       gets every error, warning and note with its line; may not be NULL
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_FILE (cannot be read, errno is set, or larger than
 *         64 MiB); TFA_E_PARSE (malformed: the report has at least one error); TFA_E_MEMORY.
 */
TFA_API TFA_CHECKED int tfa_urdf_load(const char *path, tfa_description **description,
                                      tfa_report *report);

/** As tfa_urdf_load, from `length` bytes in memory, opening no file; `name`: file name in messages,
 *  NULL: none. TFA_E_FILE: longer than 64 MiB. */
TFA_API TFA_CHECKED int tfa_urdf_parse(const char *text, size_t length, const char *name,
                                       tfa_description **description, tfa_report *report);

/** Releases a description made by tfa_urdf_load or tfa_urdf_parse. NULL is allowed. */
TFA_API void tfa_description_free(tfa_description *description);

#ifdef __cplusplus
}
#endif
#endif
