/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A participant that writes requests and torques as it likes, beside the client library.
 */
#ifndef TESTS_DDS_RAW_DDS_H
#define TESTS_DDS_RAW_DDS_H

#include <dds/dds.h>

#include "dds/topics/dds_convert.h"
#include "herald.h"
#include "support/scoped.h"

#define RAW_DDS_JOINTS 7     /* of robot "arm" */
#define RAW_DDS_IN_VAIN 1000 /* id of requests that nobody may answer */

typedef struct raw_dds {
    dds_entity_t participant, writer, reader, torques, accelerations;
} raw_dds;

/** Zeros for as many states as a batch may have. */
extern double raw_dds_zeros[];

raw_dds raw_dds_open(uint32_t domain);
void raw_dds_close(const raw_dds *r);
#define SCOPED_RAW_DDS SCOPED(raw_dds_close) raw_dds
/** Takes the next valid sample. @return whether there was one */
bool raw_dds_take(dds_entity_t reader, void *out);
/** Takes what has come of the descriptions of robots. @return that of the arm was among it, or was
 * withdrawn, as the leader's is that yields */
bool raw_dds_take_info(dds_entity_t reader, totalforce_dds_RobotInfo *arm, bool withdrawn);
/** Writes a request that nobody may answer, and waits until every daemon has it: the functions
 * below fail if they find a reply to it. */
void raw_dds_ask_in_vain(const raw_dds *r, totalforce_dds_Request *request);
/** Writes a request and returns the reply to it. */
totalforce_dds_Reply *raw_dds_ask(const raw_dds *r, totalforce_dds_Request *request);
/** Repeats hellos until one is answered with that status: both sides are matched. */
void raw_dds_await(const raw_dds *r, const char *robot, int status);
/** Forward dynamics of the arm at rest. */
totalforce_dds_Request raw_dds_request(void);

#endif
