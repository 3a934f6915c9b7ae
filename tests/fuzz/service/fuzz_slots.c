/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes as a request in a slot of the ring, before a worker that solves. It
 * is answered under its id, with a status of the list, and by finite numbers if by any.
 */
#include <string.h>

#include "fuzz_service.h"
#include "worker/local_client.h"

#define BATCH 4

static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    if (first == 0 && tfa_request_check(fuzz_model(), request, reply) != TFA_OK)
        return reply->status;
    return tfa_compute_states(self, request, first, count, reply);
}

static tfa_worker *open_worker(tfa_local_client *client)
{
    tfa_workspace *workspace;
    tfa_worker *worker;
    const tfa_model *model = fuzz_model();
    require(tfa_workspace_create(model, NULL, &workspace) == TFA_OK);
    const tfa_worker_robot robot = {.shape = {.q_count = tfa_model_q_count(model),
                                              .v_count = tfa_model_v_count(model),
                                              .frames = tfa_model_frame_count(model),
                                              .max_batch = BATCH,
                                              .max_tips = TFA_DEFAULT_TIPS},
                                    .solve = solve,
                                    .self = workspace};
    const tfa_worker_options options = {.robots = &robot, .robot_count = 1, .wait = TFA_WAIT_BLOCK};
    require(tfa_worker_create(&options, &worker) == TFA_OK);
    require(tfa_local_client_open(worker, 0, 2, BATCH, client) == TFA_OK);
    return worker;
}

static void check_reply(const tfa_local_client *client, uint64_t id)
{
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&client->ring);
    tfa_reply reply = {0};
    require(line->id == id && is_known_status(line->status));
    const uint64_t want = tfa_wire_decode_reply(line, &reply);
    require(want == 0 || tfa_wire_has_answers(line->status));
    require(line->t_received <= line->t_start && line->t_start <= line->t_done);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static tfa_local_client client;
    static tfa_worker *worker;
    if (!worker)
        worker = open_worker(&client);
    const size_t room = client.ring.layout.request_stride - 8;
    unsigned char *slot = tfa_ring_next_request(&client.ring);
    memset(slot + 8, 0, room); /* all but seq */
    memcpy(slot + 8, data, size < room ? size : room);
    tfa_wire_request line;
    memcpy(&line, slot, sizeof line);
    tfa_local_client_send(&client);
    while (tfa_worker_cycle(worker))
        ;
    require(tfa_ring_reply_ready(&client.ring));
    check_reply(&client, line.id);
    tfa_ring_release(&client.ring);
    return 0;
}
