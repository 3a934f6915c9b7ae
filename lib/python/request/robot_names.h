/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names and sizes of a robot, from a model or from a daemon's description.
 */
#ifndef PYTHON_ROBOT_NAMES_H
#define PYTHON_ROBOT_NAMES_H

#include "python_api.h"

#include <totalforce/text.h>

typedef struct robot_names {
    tfa_names names;  /**< joints, links, constraints: UTF-8 of the tuples */
    PyObject *joints; /**< tuple of names in declared order */
    PyObject *links;  /**< tuple of link names; the position is the frame index */
    PyObject *modes;  /**< tuple: of each modal coordinate, the name of its link */
    PyObject *constraints; /**< tuple of names; the position is the bit in a request */
} robot_names;

/* Each fills an empty robot. @return 0; -1 with an exception, the robot empty */
int robot_from_model(robot_names *robot, const tfa_model *model);
int robot_from_info(robot_names *robot, const char *name, const tfa_client_info *info);

/** Releases everything and leaves the robot empty. */
void robot_clear(robot_names *robot);

/* Index of a link, joint or constraint given by name or index. @return 0; -1 with an exception that
 * names `field` and the nearest names */
int robot_find_link(const robot_names *robot, const char *field, PyObject *value, uint32_t *frame);
int robot_find_joint(const robot_names *robot, const char *field, PyObject *value, uint32_t *joint);
int robot_find_constraint(const robot_names *robot, const char *field, PyObject *value,
                          uint32_t *constraint);

#endif
