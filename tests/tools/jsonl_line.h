/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One JSON line read for one of some small robots, for the tests of the reader.
 */
#ifndef TFA_TESTS_JSONL_LINE_H
#define TFA_TESTS_JSONL_LINE_H

#include "jsonl/jsonl.h"

/** Joints pan, lift, slide; links base, upper, lower, tool. */
extern const tfa_client_info arm;
/** The same with two modes of link upper and one of link lower. */
extern const tfa_client_info boom;
/** The arm with the constraints "loop" and "foot". */
extern const tfa_client_info closed;
/** A floating base that carries a revolute joint, a planar joint and a floating joint. */
extern const tfa_client_info ship;

/** One line read; everything it points to. */
typedef struct reading {
    tfa_names names;
    jsonl_buffers buffers;
    json_t *object;
    tfa_request request;
    tfa_reply reply;
    jsonl_error error;
    int status;
} reading;

/** Reads a line; forget() releases what it holds. */
void read_line(reading *r, const tfa_client_info *info, const char *line, size_t length);
void forget(reading *r);

/** Reads a line that must be good. */
void read_good(reading *r, const tfa_client_info *info, const char *line);
/** 1, 2, 3, ... */
void count_up(double *numbers, int count);
/** The line of the reply, for free(). */
char *print_line(reading *r);
/** Fails unless the line of the reply is this one; then forget(). */
void prints(reading *r, const char *want);

/** A line, and the status and exactly the sentence with which it is refused. */
typedef struct refusal {
    const char *line;
    int status;
    const char *text;
} refusal;

/** Fails unless each line is refused so. */
void refuse_all(const tfa_client_info *info, const refusal *rows, size_t count);
#define REFUSE(info, rows) refuse_all(info, rows, sizeof(rows) / sizeof *(rows))
void refuse(const tfa_client_info *info, const char *line, int status, const char *text);

/** Fails unless this reply to a good line is explained with exactly this sentence. */
void explain(const tfa_client_info *info, const char *line, const tfa_reply *reply,
             const char *want);

#define Q "\"q\":[0,0,0]"
#define FD "\"op\":\"forward_dynamics\""
#define ID "\"op\":\"inverse_dynamics\""
#define OI "\"op\":\"operational_inertia\""
#define MM "\"op\":\"mass_matrix\""

#define POSE "\"base_pose\":[1,2,3,0,0,0,1]"

#endif
