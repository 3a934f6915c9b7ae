/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * JSON lines: one request a line in, one reply a line out, in order. `totalforce solve` and
 * `totalforce call` share everything here, so their replies agree to the byte.
 *
 *     {"id":1,"op":"forward_dynamics","q":[...],"v":[...],"tau":[...]}
 *     -> {"id":1,"status":"ok","method":"aba","qdd":[...],
 *         "model":"0123456789abcdef"}
 *     -> {"id":1,"status":"error","error":"q: 6 values, the robot has 7 joints (a, ...)",
 *         "code":"E_SIZE"}
 */
#ifndef TOOLS_JSONL_JSONL_H
#define TOOLS_JSONL_JSONL_H

#include <totalforce/text.h>

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>
#include <totalforce/dynamics.h>

/** Error of one line: a status and a sentence that names the invalid field */
typedef struct jsonl_error {
    int status;
    char text[1024];
} jsonl_error;

/** Sets the error, formatted as by printf, and returns `status`. */
int jsonl_fail(jsonl_error *error, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Defaults of requests, set from the command line */
typedef struct jsonl_defaults {
    tfa_method method;
    tfa_estimate estimate; /**< of ops that answer lambda_inv, as method and refine */
    uint32_t refine;
} jsonl_defaults;

/** Method auto, estimate where the sentinel trips, the method's own refinement. */
#define JSONL_DEFAULTS                                                                             \
    {                                                                                              \
        .method = TFA_METHOD_AUTO, .estimate = TFA_ESTIMATE_DEFAULT, .refine = TFA_REFINE_DEFAULT  \
    }

/** Numbers of one answer; allocated when it is first asked for, larger when more are. */
typedef struct jsonl_array {
    void *items;
    size_t count;
} jsonl_array;

/** Memory for one request and its reply. Written by jsonl_read and by whoever answers. */
typedef struct jsonl_buffers {
    double *q, *v, *tau, *qdd; /**< q_count, then v_count each: the request */
    double *modes, *mode_velocities; /**< mode_count each */
    double base_pose[7], base_twist[6], base_wrench[6], base_acceleration[6], gravity[3];
    double wrenches[TFA_MAX_WRENCHES * 6];
    double payloads[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    double task_acceleration[6 * TFA_MAX_TIPS];
    double constraint_acceleration[6 * TFA_MAX_CONSTRAINTS], stabilisation[2];
    double *torque_weights; /**< v_count */
    double rank_threshold, characteristic_length;
    uint32_t *locked;          /**< v_count: no robot has more joints than freedoms */
    uint8_t *named;            /**< v_count: joints of the list that is being read */
    jsonl_array *answers;      /**< one for each row of the table of answers */
    const char *tip_poses_key; /**< key of the tips' poses in the reply; NULL: "pose" */
    tfa_answer answer;
} jsonl_buffers;

/** Allocates for this robot. @return TFA_OK, TFA_E_MEMORY (then nothing is left allocated). */
TFA_CHECKED int jsonl_buffers_init(jsonl_buffers *buffers, const tfa_names *names);
void jsonl_buffers_free(jsonl_buffers *buffers);

/**
 * Parses one line into an object. NaN, 1e999, duplicate keys, NUL bytes, nesting without end and
 * everything else that is not JSON is an error that says at which column. A byte order mark is
 * skipped.
 * @param number  line number for messages
 * @return TFA_OK and a new reference in *object; TFA_E_PARSE.
 */
TFA_CHECKED int jsonl_load(const char *line, size_t length, uint64_t number, json_t **object,
                           jsonl_error *error);

/**
 * Reads a request out of an object. Unknown keys, keys that the op cannot use, wrong sizes and
 * unknown names are errors that name the invalid field.
 * @param[out] request  points into `buffers`
 * @param[out] reply    empty, with the buffers that this request asks for
 * @return TFA_OK, TFA_E_ARGUMENT, TFA_E_SIZE, TFA_E_VALUE, TFA_E_LINK, TFA_E_JOINT, TFA_E_METHOD,
 *         TFA_E_UNSUPPORTED, TFA_E_MEMORY.
 */
TFA_CHECKED int jsonl_read(const json_t *object, const tfa_names *names,
                           const jsonl_defaults *defaults, jsonl_buffers *buffers,
                           tfa_request *request, tfa_reply *reply, jsonl_error *error);

/** Explains a reply with a bad status in a sentence: the field, the joint or link, the
 *  value. Sets `error` and returns its status. */
int jsonl_explain(const tfa_names *names, const tfa_request *request, const tfa_reply *reply,
                  jsonl_error *error);

/** Prints the reply to a request that was answered, with its newline. Numbers have 17 significant
 *  digits: they read back to the same bits; those that are not finite are null. `id` may be NULL:
 *  the request had none. */
void jsonl_print_reply(FILE *out, const json_t *id, const tfa_names *names,
                       const jsonl_buffers *buffers, const tfa_request *request,
                       const tfa_reply *reply);

/** Prints an error reply with its newline. `id` may be NULL: null is printed. */
void jsonl_print_error(FILE *out, const json_t *id, const jsonl_error *error);

/** Prints a string with its quotes; bytes that are not UTF-8 become U+FFFD. */
void jsonl_print_string(FILE *out, const char *text);

/** Prints a double so that it reads back to the same bits, and as a real, not an integer; null if
 *  it is infinite or NaN. */
void jsonl_print_number(FILE *out, double value);

#endif
