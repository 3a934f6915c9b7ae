/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robot of a recording: from settings and URDF to the model that answered.
 */
#ifndef TOOLS_RECORD_RECORDED_ROBOT_H
#define TOOLS_RECORD_RECORDED_ROBOT_H

#include <jansson.h>
#include <totalforce/dynamics.h>

#include "ipc/wire_blocks.h"

/** Settings of a recording. Texts live as long as `json`. */
typedef struct recorded_robot {
    json_t *json;
    const char *robot, *urdf_name, *model_hash, *isa, *version;
    const char *specialised; /**< file of its specialised kernel; NULL: none */
    const char *digest;      /**< of that */
    int sampled;             /**< the daemon estimated every so-many-th open request */
    tfa_wire_shape shape;
    tfa_workspace_options workspace;
} recorded_robot;

/** Reads settings. @return 0, or -1 and why not in `text` */
int recorded_robot_read(const char *settings, size_t bytes, recorded_robot *r, char *text,
                        size_t size);
void recorded_robot_free(recorded_robot *r);

/**
 * Compiles a URDF with the options of the settings, and prints its errors on standard error.
 * @param name  of the URDF, in messages
 * @return the model, or NULL after a message; its hash is the caller's to compare
 */
tfa_model *recorded_robot_compile(const recorded_robot *r, const char *name, const char *urdf,
                                  size_t bytes);

/** The shape of this model's requests is that of the settings. */
int recorded_robot_fits(const recorded_robot *r, const tfa_model *model);

#endif
