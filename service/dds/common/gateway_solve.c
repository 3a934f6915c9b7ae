/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See gateway_solve.h.
 */
#include "dds/common/gateway_solve.h"

#include "dds/common/dds_domain.h"
#include "ipc/wire_blocks.h"
#include "worker/worker_tap.h"

/* @param asked  the estimate policy before it was settled */
static void record(const gateway_robot *robot, const tfa_request *request, tfa_estimate asked,
                   const gateway_stamps *stamps, const tfa_worker_call *call)
{
    const tfa_tap_entry entry = {.shape = &robot->solver.shape,
                                 .request = request,
                                 .reply = &call->reply,
                                 .estimate = asked,
                                 .id = stamps->id,
                                 .t_sent = stamps->sent ? stamps->sent : stamps->received,
                                 .t_received = stamps->received,
                                 .t_start = call->t_start,
                                 .t_done = call->t_done};
    tfa_tap_put(robot->tap, &entry);
}

int gateway_solve(const gateway_robot *robot, tfa_request *request, const gateway_stamps *stamps,
                  tfa_worker_call *call)
{
    const tfa_estimate asked = request->estimate;
    call->t_start = (uint64_t)tfa_dds_monotonic();
    call->reply.status =
        robot->solver.solve(robot->solver.self, request, &call->reply, 0, request->count);
    call->t_done = (uint64_t)tfa_dds_monotonic();
    if (robot->tap)
        record(robot, request, asked, stamps, call);
    return call->reply.status;
}

void gateway_count(const gateway_robot *robot, uint32_t source, const tfa_request *request,
                   const gateway_stamps *stamps, const tfa_worker_call *call)
{
    const bool has_answers = request && tfa_wire_has_answers(call->reply.status);
    const uint64_t received = stamps->received,
                   start = call->t_start && call->t_start > received ? call->t_start : received,
                   done = call->t_done > start ? call->t_done : start;
    const tfa_tally_request counted = {.status = call->reply.status,
                                       .has_answers = has_answers,
                                       .refined =
                                           has_answers && request->refine - 1 < TFA_MAX_REFINE,
                                       .states = has_answers ? request->count : 0,
                                       .answers = has_answers ? call->reply.answers : NULL,
                                       .busy_ns = done - start,
                                       .sent = stamps->sent,
                                       .received = received,
                                       .start = start,
                                       .done = done};
    if (robot->statistics)
        tfa_tally_count(&robot->statistics->gateway[source], &counted);
    if (has_answers)
        gateway_publish_state(robot, request, call);
}

void gateway_publish_state(const gateway_robot *robot, const tfa_request *request,
                           const tfa_worker_call *call)
{
    const tfa_wire_shape *shape = &robot->solver.shape;
    if (robot->state && tfa_wire_has_answers(call->reply.status))
        tfa_state_publish(robot->state, request, shape->q_count, shape->base_freedoms != 0,
                          call->t_done);
}
