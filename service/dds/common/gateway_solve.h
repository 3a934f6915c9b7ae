/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A gateway that answers by itself: solve, record, count. The caller holds the mutex that guards
 * the robot.
 */
#ifndef TFA_SERVICE_DDS_GATEWAY_SOLVE_H
#define TFA_SERVICE_DDS_GATEWAY_SOLVE_H

#include "gateway/gateway.h"

typedef struct gateway_robot {
    tfa_worker_robot solver;      /* of the gateway's own */
    struct tfa_tap *tap;          /* records what is answered; NULL: no */
    tfa_shared_robot *statistics; /* NULL: none */
    tfa_shared_state *state;      /* NULL: none */
} gateway_robot;

/* Of a request, CLOCK_MONOTONIC ns */
typedef struct gateway_stamps {
    uint64_t id;
    uint64_t sent; /* 0, or after its answer: not known */
    uint64_t received;
} gateway_stamps;

/* Solves into call->reply, whose buffers are there, with times, and records.
 * @return call->reply.status */
int gateway_solve(const gateway_robot *robot, tfa_request *request, const gateway_stamps *stamps,
                  tfa_worker_call *call);

/* Counts an answer of this source and publishes its state. @param request  NULL: it was refused
 * before; t_start may be 0 then */
void gateway_count(const gateway_robot *robot, uint32_t source, const tfa_request *request,
                   const gateway_stamps *stamps, const tfa_worker_call *call);

/* Publishes the state of a request if it has an answer. */
void gateway_publish_state(const gateway_robot *robot, const tfa_request *request,
                           const tfa_worker_call *call);

#endif
