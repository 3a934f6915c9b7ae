/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random requests of one robot, and room for the replies to them.
 */
#ifndef TOOLS_LATENCY_WORKLOAD_STATES_H
#define TOOLS_LATENCY_WORKLOAD_STATES_H

#include "latency/machine/pingpong.h"
#include "options.h"

/** Random requests of one robot, the same for every transport and client. */
typedef struct latency_states {
    uint32_t sets; /**< requests that differ */
    tfa_request *requests;
    double *memory;
} latency_states;

TFA_CHECKED int latency_states_init(latency_states *states, const latency_options *options,
                                    const tfa_client_info *info);
void latency_states_free(latency_states *states);

/** Buffers of a reply to a whole batch. @return TFA_OK, TFA_E_MEMORY; free it either way. */
TFA_CHECKED int latency_reply_init(tfa_reply *reply, const latency_options *options,
                                   const tfa_client_info *info);
void latency_reply_free(tfa_reply *reply);

/** Cache lines of a request (a line, q, v, tau) and of a reply (a line, what is known of each
 *  answer, qdd). */
pingpong_size latency_size(const latency_options *options, const tfa_client_info *info);

#endif
