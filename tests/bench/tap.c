/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost of recording a request for the worker: forward dynamics of a 7-joint arm in wire form,
 * without a tap (the check alone), and with one whose recorder runs in another thread; each alone,
 * and after a solve as the difference to the same without. CSV of medians over alternating rounds.
 *
 *   build/release/bin/bench_tap config/robots/arm7.urdf 301
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "timing.h"
#include "worker/worker_internal.h"

enum { CALLS = 4096, ROUNDS_MAX = 1001, JOINTS = 7, SLOT_BYTES = 1024, BLOCK = 1 << 20 };
#define RING_BYTES ((uint64_t)32 << 20) /* --buffer of totalforce record */
#define PAUSE_NS 1000000                /* of totalforce record, between two looks */

static tfa_worker worker;
static tfa_worker_client *const client = &worker.clients[0];
static _Atomic(tfa_tap *) tap_of_robot;
static tfa_tap tap;
static tfa_workspace *workspace;
static _Alignas(TFA_CACHE_LINE) unsigned char scratch[SLOT_BYTES], replies[2 * SLOT_BYTES];

/* ---- the recorder ---- */

static _Atomic bool ended;

static void pause_recorder(void)
{
    nanosleep(&(struct timespec){.tv_nsec = PAUSE_NS}, NULL);
}

/* Copies each record, as totalforce record does. */
static void *record(void *argument)
{
    static unsigned char block[BLOCK];
    tfa_tap_reader *reader = argument;
    size_t used = 0;
    while (!atomic_load(&ended)) {
        const tfa_tap_record *next;
        tfa_tap_look(reader);
        if (reader->read == reader->written)
            pause_recorder();
        while ((next = tfa_tap_next(reader)) != NULL) {
            used = used + next->bytes > sizeof block ? 0 : used;
            memcpy(block + used, next, next->bytes);
            used += next->bytes;
            tfa_tap_release(reader, reader->found);
        }
    }
    return NULL;
}

static void wait_for_recorder(void)
{
    do
        pause_recorder();
    while (atomic_load_explicit(&tap.words->read, memory_order_acquire) != tap.written); /* T2 */
}

/* ---- the worker ---- */

/* A request as begin_request of the worker leaves it. */
static int make_request(const tfa_model *model)
{
    static const double q[JOINTS] = {0.1, 0.5, 0.2, -1, 0.3, 0.5, 0.1}, v[JOINTS], tau[JOINTS];
    static tfa_answer answer;
    static double qdd[JOINTS];
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = q,
                                 .v = v,
                                 .tau = tau};
    const tfa_reply reply = {.qdd = qdd, .answers = &answer};
    tfa_wire_reply_shape shape;
    worker_request *at = &client->at;
    client->shape = (tfa_wire_shape){.q_count = JOINTS,
                                     .v_count = JOINTS,
                                     .frames = tfa_model_frame_count(model),
                                     .max_batch = 1,
                                     .max_tips = 1};
    client->scratch = scratch;
    client->ring = (tfa_ring_server){.layout = {.slots = 1, .reply_stride = SLOT_BYTES},
                                     .requests = scratch,
                                     .replies = replies};
    int status = tfa_wire_encode_request(&client->shape, &request, tfa_wire_want(&request, &reply),
                                         1, 0, scratch, &shape, NULL);
    if (status == TFA_OK)
        status = tfa_wire_decode_request(&client->shape, scratch, &at->request, &shape,
                                         &at->reply.field);
    at->want = shape.want;
    if (status == TFA_OK)
        tfa_wire_reply_buffers(&client->shape, &shape, tfa_ring_reply(&client->ring), &at->reply);
    worker.taps.taps = &tap_of_robot;
    return status;
}

static void solve(void)
{
    client->at.reply.status = tfa_compute(workspace, &client->at.request, &client->at.reply);
    if (client->at.reply.status != TFA_OK)
        abort();
    worker.now = (uint64_t)wall_ns(); /* as the worker does after each request */
}

enum kind { SOLVES = 1, LOOKS = 2, RECORDS = 4, KINDS = 5 };
static const unsigned kinds[KINDS] = {SOLVES, SOLVES | LOOKS, SOLVES | LOOKS | RECORDS, LOOKS,
                                      LOOKS | RECORDS};

static void answer_kind(unsigned kind)
{
    if (kind & SOLVES)
        solve();
    if (kind & LOOKS) {
        tfa_robot_taps_take(&worker.taps);
        tfa_worker_tap_request(&worker, client);
    }
}

/* ns of a request. Each turn begins alike: after a pause, with warm code. */
static double time_turn(unsigned kind)
{
    tfa_robot_taps_set(&worker.taps, 0, kind & RECORDS ? &tap : NULL);
    wait_for_recorder();
    for (int k = 0; k < CALLS / 8; k++)
        answer_kind(kind);
    const double start = cpu_ns();
    for (int k = 0; k < CALLS; k++)
        answer_kind(kind);
    return (cpu_ns() - start) / CALLS;
}

static double ns[KINDS][ROUNDS_MAX];

static void measure(int rounds)
{
    for (int r = -1; r < rounds; r++) /* the first touches all memory */
        for (int k = 0; k < KINDS; k++) {
            const int kind = r % 2 ? KINDS - 1 - k : k;
            ns[kind][r < 0 ? 0 : r] = time_turn(kinds[kind]);
        }
    for (int r = 0; r < rounds; r++) {
        ns[1][r] -= ns[0][r];
        ns[2][r] -= ns[0][r];
    }
}

static void print(int rounds)
{
    puts("solve_ns,check_alone_ns,check_added_ns,record_alone_ns,record_added_ns");
    printf("%.1f,%.1f,%.1f,%.1f,%.1f\n", median_of(ns[0], rounds), median_of(ns[3], rounds),
           median_of(ns[1], rounds), median_of(ns[4], rounds), median_of(ns[2], rounds));
}

/* With a recorder. @return an exit status */
static int run_rounds(int rounds)
{
    const size_t size = tfa_tap_segment_size(1, RING_BYTES);
    unsigned char *segment = aligned_alloc(TFA_TAP_PAGE, size);
    pthread_t thread;
    if (!segment)
        return 2;
    memset(segment, 0, size);
    tap = (tfa_tap){.words = tfa_tap_words_of(segment, 0),
                    .bytes = tfa_tap_ring_of(segment, 1, RING_BYTES, 0),
                    .size = RING_BYTES};
    tfa_tap_reader reader = {.words = tap.words, .bytes = tap.bytes, .size = tap.size};
    if (pthread_create(&thread, NULL, record, &reader) != 0)
        return 2;
    measure(rounds);
    atomic_store(&ended, true);
    pthread_join(thread, NULL);
    const bool is_good = tfa_tap_dropped(tap.words) == 0 && reader.read > 0;
    free(segment);
    if (is_good)
        print(rounds);
    return is_good ? 0 : 2;
}

int main(int argc, char **argv)
{
    const int rounds = argc > 2 ? atoi(argv[2]) : 101;
    tfa_model *model;
    tfa_report report = {0};
    if (argc < 2 || rounds < 1 || rounds > ROUNDS_MAX) {
        fputs("bench_tap URDF [ROUNDS]\n", stderr);
        return 3;
    }
    if (tfa_model_load(argv[1], NULL, &report, &model) != TFA_OK ||
        tfa_model_q_count(model) != JOINTS ||
        tfa_workspace_create(model, NULL, &workspace) != TFA_OK || make_request(model) != TFA_OK)
        return 2;
    const int status = run_rounds(rounds);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    tfa_report_free(&report);
    return status;
}
