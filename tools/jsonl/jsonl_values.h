/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the parts of a request out of JSON values. Private to the jsonl_*.c files.
 */
#ifndef TOOLS_JSONL_JSONL_VALUES_H
#define TOOLS_JSONL_JSONL_VALUES_H

#include "jsonl.h"

/** Everything that the function of a key may need. */
typedef struct jsonl_reader {
    const tfa_names *names;
    jsonl_buffers *buffers;
    tfa_request *request;
    jsonl_error *error;
    const char *key;            /**< for messages: "q", "wrench.tool0", ... */
    const json_t *acceleration; /**< of the tips, read once tips and rows are known */
    int rows_given;             /**< the request has the key "rows" */
    const json_t *constraint_acceleration; /**< read once the active constraints are known */
    int constraints_given;                 /**< the request has the key "constraints" */
} jsonl_reader;

/** "an object", "a string", ...: the type of a value, for messages. */
const char *jsonl_type(const json_t *value);

/** Reads an array of exactly `count` numbers. @return TFA_OK, TFA_E_ARGUMENT, TFA_E_SIZE. */
int jsonl_numbers(jsonl_reader *r, const json_t *value, size_t count, double *out);

/** Reads q (of_q) or v, tau, qdd: an array in joint order, or {joint: value} where joints left out
 *  are 0. @return TFA_OK, TFA_E_ARGUMENT, TFA_E_SIZE, TFA_E_JOINT. */
int jsonl_joints(jsonl_reader *r, const json_t *value, int of_q, double *out);

/** There is no such joint that moves; `key` stands for it in the message. @return TFA_E_JOINT */
int jsonl_no_joint(jsonl_reader *r, const char *key, const char *name);

/** Looks a link up; `key` stands for it in the message. @return TFA_OK, TFA_E_LINK. */
int jsonl_find_frame(jsonl_reader *r, const char *key, const char *link, uint32_t *frame);

/* jsonl_changes.c: changes of the robot by a request */

/** ["joint",...] @return TFA_OK, TFA_E_ARGUMENT, TFA_E_JOINT. */
int jsonl_read_locked(jsonl_reader *r, const json_t *value);
/** {"link":..,"mass":..,"com":[3],"inertia":[6]} or a list of such. @return TFA_OK,
 *  TFA_E_ARGUMENT, TFA_E_SIZE, TFA_E_LINK. */
int jsonl_read_payload(jsonl_reader *r, const json_t *value);

/* jsonl_answers.c */

/** Lets a reply point to buffers for all answers to the request, allocated where they are too
 *  small. @return TFA_OK, TFA_E_MEMORY. */
int jsonl_point_reply(jsonl_reader *r, tfa_reply *reply);

/* jsonl_want.c: answers besides those of the op */

/** ["jacobian",...] @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_want(jsonl_reader *r, const json_t *value);
/** true or false: the poses of the tips, under the key "poses". @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_poses(jsonl_reader *r, const json_t *value);

/* jsonl_task.c: tips and what belongs to them */

/** ["link",...] @return TFA_OK, TFA_E_ARGUMENT, TFA_E_SIZE, TFA_E_LINK. */
int jsonl_read_tips(jsonl_reader *r, const json_t *value);
/** "pose" or "point" @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_rows(jsonl_reader *r, const json_t *value);
/** "truncate", "damp" or "refuse" @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_rank_loss(jsonl_reader *r, const json_t *value);
/** A number between 0 and 1 @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_rank_threshold(jsonl_reader *r, const json_t *value);
int jsonl_read_characteristic_length(jsonl_reader *r, const json_t *value);
/** {"link":[6 or 3 numbers],...}, to be read by jsonl_finish_acceleration. @return TFA_OK,
 *  TFA_E_ARGUMENT. */
int jsonl_read_acceleration(jsonl_reader *r, const json_t *value);
/** Reads the accelerations once tips and rows were read: the tips are those that it names, in this
 *  order, or those of `tips`, which must be the same. @return TFA_OK, TFA_E_ARGUMENT, TFA_E_SIZE,
 *  TFA_E_LINK. */
int jsonl_finish_acceleration(jsonl_reader *r);

/* jsonl_constraints.c: active constraints and what belongs to them. @return TFA_OK,
 * TFA_E_ARGUMENT, TFA_E_SIZE, TFA_E_JOINT */

/** ["constraint",...] */
int jsonl_read_constraints(jsonl_reader *r, const json_t *value);
/** {"constraint":[6],...}, to be read by jsonl_finish_constraints */
int jsonl_read_constraint_acceleration(jsonl_reader *r, const json_t *value);
/** [k0,k1] */
int jsonl_read_stabilisation(jsonl_reader *r, const json_t *value);
/** An array in joint order, or {joint: weight} */
int jsonl_read_torque_weights(jsonl_reader *r, const json_t *value);
/** All constraints are active if the request names none; reads the accelerations. */
int jsonl_finish_constraints(jsonl_reader *r);

#endif
