/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A description is a robot as its file states it: links and joints, nothing merged or reordered.
 *
 * Rotations and axes have a low part: the number is quat + quat_low (axis + axis_low), to 1e-32
 * what rpy and axis of the file say. A program that writes quat or axis sets the low part to 0,
 * which is its default, too: then the double is the number.
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

typedef enum tfa_joint_type {
    TFA_JOINT_FIXED = 0,
    TFA_JOINT_REVOLUTE = 1,   /**< 1 q (rad), 1 v: rotation about the axis */
    TFA_JOINT_CONTINUOUS = 2, /**< as revolute, any winding */
    TFA_JOINT_PRISMATIC = 3,  /**< 1 q (m), 1 v: translation along the axis */
    TFA_JOINT_PLANAR = 4,     /**< 3 q (x, y in m, theta in rad), 3 v (see docs/conventions.md) */
    TFA_JOINT_FLOATING = 5,   /**< 7 q (x y z, quaternion x y z w), 6 v (linear, angular) */
} tfa_joint_type;

/** A rigid link. Strings are owned by whoever made the description. SI units. */
typedef struct tfa_link {
    const char *name;
    uint32_t line;      /**< where the file declares it; 0 if unknown */
    double mass;        /**< kg; 0 with zero inertia for a frame without <inertial> */
    double com[3];      /**< centre of mass, m, in the link frame */
    double quat[4];     /**< inertial frame in the link frame, x y z w */
    double quat_low[4]; /**< what quat leaves of it */
    double inertia[6];  /**< ixx ixy ixz iyy iyz izz, kg m^2, about the centre of mass,
                            along the axes of the inertial frame */
    uint32_t inertial;  /**< 1: the file states mass and inertia, zeros included; 0: it has no
                            <inertial>, which is warned about where the link moves by itself */
} tfa_link;

/** A joint between two links. */
typedef struct tfa_joint {
    const char *name;
    uint32_t line;
    tfa_joint_type type;
    uint32_t parent;    /**< index of the parent link */
    uint32_t child;     /**< index of the child link */
    double xyz[3];      /**< joint origin in the parent link frame, m */
    double quat[4];     /**< joint frame in the parent link frame, x y z w */
    double quat_low[4]; /**< what quat leaves of it */
    double axis[3];     /**< unit axis in the joint frame (plane normal for planar) */
    double axis_low[3]; /**< what axis leaves of it */
    double armature;    /**< reflected rotor inertia, kg m^2 or kg, on each freedom */
    double rotor;      /**< the same as written in the file (drake:rotor_inertia times the square of
                            drake:gear_ratio); added to armature only when asked for */
    double damping;    /**< N m s/rad or N s/m, as written; used only when asked for */
    double friction;   /**< N m or N, as written; never used: a note says so */
    int32_t mimic;     /**< index of the joint it follows, or -1 */
    double multiplier; /**< q = multiplier * q[mimic] + offset */
    double offset;
} tfa_joint;

/** Something that the file says and that no model uses, such as limits or transmissions. */
typedef struct tfa_unused {
    const char *item; /**< "velocity limits", "<gazebo>" */
    uint32_t line;    /**< of the first one */
    size_t count;
} tfa_unused;

/** A tree of links: exactly one link is nobody's child. Joints stand in document order. */
typedef struct tfa_description {
    const char *name;
    tfa_link *links;
    size_t link_count;
    tfa_joint *joints;
    size_t joint_count;
    const tfa_unused *unused; /**< in order of first appearance; noted when a model is made */
    size_t unused_count;
} tfa_description;

/**
 * Reads a URDF file into a description.
 *
 * @param path     file name
 * @param[out] description  made with malloc; release with tfa_description_free; NULL on error
 * @param report   every error, warning and note with its line; may not be NULL
 * @return TFA_OK; TFA_E_FILE (cannot be read, too large); TFA_E_PARSE (malformed: the report has
 *         at least one error); TFA_E_MEMORY; TFA_E_UNSUPPORTED (library built without urdfdom).
 *
 * Never prints, never opens a mesh, never uses the network, independent of the locale.
 * Thread rule: one call at a time in a process (urdfdom's log handler is global).
 */
TFA_API TFA_CHECKED int tfa_urdf_load(const char *path, tfa_description **description,
                                      tfa_report *report);

/** As tfa_urdf_load, from text in memory; `name` stands for the file in messages. */
TFA_API TFA_CHECKED int tfa_urdf_parse(const char *text, size_t length, const char *name,
                                       tfa_description **description, tfa_report *report);

/** Releases a description made by tfa_urdf_load or tfa_urdf_parse. NULL is allowed. */
TFA_API void tfa_description_free(tfa_description *description);

#ifdef __cplusplus
}
#endif
#endif
