/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests through a local client.
 */
#include "local_client_calls.h"

int send_to(tfa_local_client *local_client, double x, uint64_t id)
{
    const double q[2] = {x, 2 * x}, tau[2] = {1, 2};
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = q, .tau = tau};
    tfa_wire_reply_shape ask;
    if (tfa_ring_full(&local_client->ring))
        return TFA_E_AGAIN;
    int status =
        tfa_wire_encode_request(&local_client->shape, &request, tfa_wire_want(&request, NULL), id,
                                0, tfa_ring_next_request(&local_client->ring), &ask, NULL);
    if (status == TFA_OK)
        tfa_local_client_send(local_client);
    return status;
}

bool receive_from(tfa_local_client *local_client, double x, uint64_t id)
{
    const tfa_wire_reply_shape ask = {.count = 1,
                                      .want = 1u << TFA_WIRE_ANSWERS | 1u << TFA_WIRE_OUT_QDD |
                                              1u << TFA_WIRE_OUT_BASE_ACCELERATION};
    tfa_wire_reply_shape fixed = ask;
    fixed.want &= ~(1u << TFA_WIRE_OUT_BASE_ACCELERATION);
    double qdd[2] = {0};
    tfa_reply reply = {.qdd = qdd};
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&local_client->ring);
    bool good = line->id == id && tfa_wire_decode_reply(line, &reply) == fixed.want &&
                reply.status == TFA_OK;
    tfa_wire_copy_answers(&local_client->shape, &fixed, line, &reply);
    good = good && qdd[0] == x + 1 && qdd[1] == 2 * x + 2 && line->t_received <= line->t_start &&
           line->t_start <= line->t_done;
    tfa_ring_release(&local_client->ring);
    return good;
}
