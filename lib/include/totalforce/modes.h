/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Side files of a URDF: the modes of flexible links, as YAML. SI units, axes of the link; the
 * letters are those of tfa_link_modes.
 *
 *     links:
 *       boom:                                  # link of the URDF
 *         modes:                               # 1..TFA_MAX_LINK_MODES
 *           - momentum: [lx, ly, lz, ax, ay, az]
 *             mass: [m1, .., mn]               # row of M; or one number, on the diagonal
 *             stiffness: 1.2e3                 # of K, in the same way
 *             damping: 0.5                     # of D; 0 when absent
 *             limit: 0.1                       # of |eta|; none when absent
 *             shape: {tip_joint: [dx, dy, dz, tx, ty, tz]}   # each child joint of the link
 *
 * JSON is YAML, too. Anchors and aliases are refused.
 */
#ifndef TOTALFORCE_MODES_H
#define TOTALFORCE_MODES_H

#include <stddef.h>
#include <totalforce/model.h>
#include <totalforce/report.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_MODES_MAX_BYTES (4 << 20) /**< of a side file */

/** Flexible links of side files, for tfa_scene.modes and modes_count. Zero-initialise before first
 *  use; release with tfa_modes_free. */
typedef struct tfa_modes {
    tfa_link_modes *links; /**< in the order of the files, each with its arrays in one block */
    size_t count;          /**< of links */
} tfa_modes;

/**
 * Appends the flexible links of a side file. The names of links and joints and the matrices are
 * checked where a model is compiled. Cost: O(file size). It prints nothing, and does not depend on
 * the locale.
 *
 * Thread rule: one thread at a time uses `modes`.
 *
 * @param path    file name, or what tfa_urdf_find expands
 * @param modes   what it held stays; nothing is appended on error
 * @param report  gets every error, up to 100, with line and column; on error its file becomes that
 *                of the modes, else it stays. May not be NULL
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_FILE (cannot be read, errno is set, or larger than
 *         TFA_MODES_MAX_BYTES); TFA_E_PARSE (malformed); TFA_E_MEMORY
 */
TFA_API TFA_CHECKED int tfa_modes_load(const char *path, tfa_modes *modes, tfa_report *report);

/** As tfa_modes_load, from `length` bytes in memory; `name`: file name in messages, NULL: none. */
TFA_API TFA_CHECKED int tfa_modes_parse(const char *text, size_t length, const char *name,
                                        tfa_modes *modes, tfa_report *report);

/** Releases the links and sets `modes` to zero. NULL is allowed. */
TFA_API void tfa_modes_free(tfa_modes *modes);

#ifdef __cplusplus
}
#endif
#endif
