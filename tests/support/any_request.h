/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests of every kind about any robot, good and bad, and their answers over a transport beside
 * those of the library in this process.
 */
#ifndef TESTS_SUPPORT_ANY_REQUEST_H
#define TESTS_SUPPORT_ANY_REQUEST_H

#include <stdbool.h>
#include <totalforce/client.h>
#include <totalforce/dynamics.h>

#define ANY_BATCH 3
#define ANY_REQUESTS (208 * 42)
#ifdef TFA_INSTRUMENTED /* and slower; 7 has no factor in common with 208 */
#define ANY_STEP(step) (7 * (step))
#else
#define ANY_STEP(step) (step)
#endif
#define ANY_COUNT 4096 /* numbers of one input */

/** Random numbers for each input, and poses of a base. */
extern double any_numbers[8][ANY_COUNT], any_pose[ANY_BATCH * 7];

/** Request number `i` of ANY_REQUESTS: each of its digits chooses something; some are refused. */
tfa_request any_request(unsigned i, const tfa_client_info *info);

/** A buffer for every answer, each of so many numbers; all of them are 0. */
typedef struct any_answers {
    tfa_reply reply;
    double *numbers;
    size_t bytes;
} any_answers;
any_answers any_answers_make(const tfa_client_info *info);
void any_answers_free(any_answers *a);

/** A client of a transport: `call` as tfa_client_call. */
typedef struct any_client {
    const char *name;
    int (*call)(void *client, const tfa_request *request, tfa_reply *reply, uint64_t timeout_ns,
                tfa_exchange *exchange);
    void *client;
    const tfa_client_info *info;
    tfa_workspace *library;
    /* Over DDS an op that does not exist is not asked for: one is a greeting. What no sample holds
       the client refuses without the name of a field. */
    bool dds;
} any_client;

/** Status, field, index, state, model and all buffers are those of the library. @return the status
 */
int any_compare(const any_client *c, const tfa_request *request);
/** Every ANY_STEP(step)th request of any_request. */
void any_compare_all(const any_client *c, unsigned step);
/** Requests with one mistake each, and a good one after each. */
void any_compare_mistakes(const any_client *c);
/** What a client knows of the robot is what the model says. */
void any_check_info(const tfa_client_info *info, const tfa_model *model);

#endif
