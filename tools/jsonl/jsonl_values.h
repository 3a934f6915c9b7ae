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
    const robot_names *names;
    jsonl_buffers *buffers;
    tfa_request *request;
    jsonl_error *error;
    const char *key; /**< for messages: "q", "wrench.tool0", ... */
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
/** true or false. @return TFA_OK, TFA_E_ARGUMENT. */
int jsonl_read_poses(jsonl_reader *r, const json_t *value);

#endif
