/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names of a robot on the command line: joints with their indices in q and v, and links.
 * From a model (in process) or the description of a daemon (shm, dds), with the same messages.
 */
#ifndef TOOLS_COMMON_ROBOT_NAMES_H
#define TOOLS_COMMON_ROBOT_NAMES_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/client.h>
#include <totalforce/model.h>

/** One moving joint and its places in q and in v, tau, qdd. */
typedef struct robot_joint {
    const char *name;   /**< owned by the model or the client */
    int32_t quaternion; /**< coordinate that is its first; -1: none */
    uint32_t q_index, q_count;
    uint32_t v_index, v_count;
} robot_joint;

/** Names and sizes of one robot. Valid as long as the model or the client's connection. */
typedef struct robot_names {
    const char *robot;
    uint32_t q_count, v_count, base_freedoms;
    uint32_t joint_count, frame_count;
    robot_joint *joints;
    const tfa_model *model;         /**< NULL when a daemon described the robot */
    const char *const *frame_names; /**< NULL when a model did */
    json_t *joint_lookup;           /**< name -> index */
    json_t *frame_lookup;           /**< link name -> frame index */
} robot_names;

/** Reads the names out of a model, which must outlive them. @return TFA_OK, TFA_E_MEMORY. */
TFA_CHECKED int robot_names_from_model(robot_names *names, const tfa_model *model);

/** Reads the names from a daemon's description; `info` must outlive them. @return TFA_OK,
 *  TFA_E_MEMORY, TFA_E_PROTOCOL (the joints do not add up to q_count and v_count). */
TFA_CHECKED int robot_names_from_info(robot_names *names, const char *robot,
                                      const tfa_client_info *info);

/** Releases the memory of the names and leaves them empty. */
void robot_names_free(robot_names *names);

/** Index of the joint, or -1. */
int64_t robot_names_joint(const robot_names *names, const char *name);
/** Index of the link's frame, or -1. */
int64_t robot_names_frame(const robot_names *names, const char *name);

/** Writes up to three joints or links that a wrong name may have meant: "'a', 'b', 'c'". */
void robot_names_suggest_joints(const robot_names *names, const char *wrong, char *text,
                                size_t size);
void robot_names_suggest_frames(const robot_names *names, const char *wrong, char *text,
                                size_t size);

/** Name of the link with this frame; "?" when out of range. */
const char *robot_names_frame_name(const robot_names *names, uint32_t frame);

/** The joint that owns number `index` of q (of_q) or of v, tau, qdd; NULL when out of range. */
const robot_joint *robot_names_owner(const robot_names *names, int of_q, uint32_t index);

/** Writes "7 joints (a, b, ...)" or "9 coordinates in 3 joints (a, b, c)": what q (of_q) or v, tau
 *  and qdd of this robot should hold. Always terminated. */
void robot_names_describe(const robot_names *names, int of_q, char *buffer, size_t size);

#endif
