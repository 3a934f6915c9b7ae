/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Side files of a URDF: constraints and the joints that have a motor, as YAML. The scenes of a
 * daemon's configuration have the same keys. m and rad.
 *
 *     constraints:
 *       - name: foot                     # by which requests call it
 *         first: {link: ground, xyz: [0, 0, 0], rpy: [0, 0, 0]}    # the world when absent
 *         second: {link: sole, xyz: [0, 0, -0.05]}   # link: of the URDF, or world
 *         hold: point                    # TFA_CONSTRAINT_WORDS, or a list of them: [x, z, ry]
 *         unilateral: true               # false when absent
 *     actuated: [hip, knee]              # all joints when absent
 *
 * rpy turns as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll). JSON is YAML, too. Anchors and aliases are
 * refused.
 */
#ifndef TOTALFORCE_CONSTRAINTS_H
#define TOTALFORCE_CONSTRAINTS_H

#include <stddef.h>
#include <totalforce/description.h>
#include <totalforce/report.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_CONSTRAINTS_MAX_BYTES (1 << 20) /**< of a side file */

/** Contents of side files, for the lists of tfa_scene. Zero-initialise before first use; release
 *  with tfa_constraints_free. */
typedef struct tfa_constraints {
    tfa_constraint *list;  /**< in the order of the files */
    size_t count;          /**< of list */
    const char **actuated; /**< names of joints */
    size_t actuated_count; /**< of actuated */
} tfa_constraints;

/**
 * Appends the contents of a side file. Names of links and joints are checked where a model is
 * compiled. Cost: O(file size). It prints nothing, and does not depend on the locale.
 *
 * Thread rule: one thread at a time uses `constraints`.
 *
 * @param path         file name, or what tfa_urdf_find expands
 * @param constraints  what it held stays; nothing is appended on error
 * @param report       gets every error, up to 100, with line and column; on error its file becomes
 *                     that of the constraints, else it stays. May not be NULL
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_FILE (cannot be read, errno is set, or larger than
 *         TFA_CONSTRAINTS_MAX_BYTES); TFA_E_PARSE (malformed); TFA_E_MEMORY
 */
TFA_API TFA_CHECKED int tfa_constraints_load(const char *path, tfa_constraints *constraints,
                                             tfa_report *report);

/** As tfa_constraints_load, from `length` bytes in memory; `name`: file name in messages, NULL:
 *  none. */
TFA_API TFA_CHECKED int tfa_constraints_parse(const char *text, size_t length, const char *name,
                                              tfa_constraints *constraints, tfa_report *report);

/** Releases the lists and sets `constraints` to zero. NULL is allowed. */
TFA_API void tfa_constraints_free(tfa_constraints *constraints);

/** Sets a frame of tfa_constraint.pose by `xyz` (m) and `rpy` (rad), each 3 numbers; NULL: zeros.
 *  Any thread. */
TFA_API void tfa_constraint_set_pose(double pose[7], const double *xyz, const double *rpy);

#ifdef __cplusplus
}
#endif
#endif
