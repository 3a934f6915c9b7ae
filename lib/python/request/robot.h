/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names and sizes of a robot, from a model or from a daemon's description.
 */
#ifndef PYTHON_ROBOT_H
#define PYTHON_ROBOT_H

#include "numpy_api.h"

#include <totalforce/client.h>
#include <totalforce/model.h>

/** Places of a joint in q and in v, tau, qdd */
typedef struct joint_span {
    uint32_t q_index, q_count, v_index, v_count;
    int32_t quaternion; /**< coordinate that is its first; -1: none */
} joint_span;

typedef struct robot_names {
    uint32_t q_count, v_count, base_freedoms, joint_count, frame_count;
    PyObject *joints;      /**< tuple of names in declared order */
    PyObject *links;       /**< tuple of link names; the position is the frame index */
    PyObject *joint_index; /**< name -> index */
    PyObject *link_index;  /**< name -> index */
    joint_span *spans;     /**< joint_count */
} robot_names;

/* Each fills an empty robot. @return 0; -1 with an exception, the robot empty */
int robot_from_model(robot_names *robot, const tfa_model *model);
int robot_from_info(robot_names *robot, const tfa_client_info *info);

/** Releases everything and leaves the robot empty. */
void robot_clear(robot_names *robot);

/** Name of a link; "?" out of range. Lives as long as the robot. */
const char *robot_link_name(const robot_names *robot, uint32_t frame);

/** Name of the joint that owns number `index` of q (of_q) or of v, tau, qdd; NULL out of range. */
const char *robot_owner(const robot_names *robot, int of_q, uint32_t index);

/** Writes "7 joints (a, b, ...)" or "9 coordinates in 3 joints (a, b, c)". */
void robot_describe(const robot_names *robot, int of_q, char *text, size_t size);

/* Index of a link or joint given by name or index. @return 0; -1 with an exception that names
 * `field` and the nearest names */
int robot_find_link(const robot_names *robot, const char *field, PyObject *value, uint32_t *frame);
int robot_find_joint(const robot_names *robot, const char *field, PyObject *value, uint32_t *joint);

#endif
