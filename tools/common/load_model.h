/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loads models for the subcommands; messages go to standard error.
 */
#ifndef TOOLS_COMMON_LOAD_MODEL_H
#define TOOLS_COMMON_LOAD_MODEL_H

#include <stdio.h>
#include <totalforce/model.h>

/**
 * Loads and compiles a URDF ("-": from standard input) and prints what the report says at or above
 * `lowest` on stderr. Of joints in `armature` the inertias take the place of the file's armature.
 * @return the model, or NULL after an error message.
 */
tfa_model *load_model(const char *path, const tfa_model_options *options, const tfa_rotor *armature,
                      uint32_t armature_count, tfa_severity lowest, tfa_report *report);

/** Prints the messages at or above `lowest` on stderr, one a line. */
void print_messages(const tfa_report *report, tfa_severity lowest);

/** The text of a robot ("-": of standard input); free() it. NULL after an error message. */
char *read_robot(const char *path, size_t *length);

#endif
