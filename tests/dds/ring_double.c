/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Stands in for the internal ring and the worker behind it: computes at submission, in the caller's
 * thread, and shows the answer after a delay. Lets the gateway be tested by itself.
 */
#include "dds_gateway/dds_internal.h"
#include "test_worker.h"

#include <stdlib.h>
#include <time.h>

#define TIPS_ROWS (6 * TFA_MAX_TIPS)

struct tfa_worker {
    int64_t delay_ns; /* how long an answer takes */
};

struct tfa_worker *test_worker_start(const test_robot robots[TEST_ROBOTS], uint32_t delay_us)
{
    static struct tfa_worker worker;

    (void)robots;
    worker.delay_ns = (int64_t)delay_us * 1000;
    return &worker;
}

void test_worker_stop(struct tfa_worker *worker)
{
    (void)worker;
}

typedef struct ring_slot {
    dds_ring_answer answer;
    int64_t ready; /* CLOCK_MONOTONIC */
    double *numbers;
    tfa_answer *answers;
    tfa_spectrum *spectrum;
} ring_slot;

struct tfa_dds_ring {
    tfa_workspace *workspace;
    tfa_dds_shape shape;
    int64_t delay_ns;
    uint32_t slots;
    uint64_t first, last; /* guarded by the gateway's mutex */
    ring_slot slot[];
};

static size_t doubles_of(const tfa_dds_shape *s)
{
    const size_t n = s->base_freedoms + s->v_count;

    return s->max_batch *
           (2 * (s->v_count + 6u) + TIPS_ROWS * TIPS_ROWS + n * n + 7 * TFA_MAX_TIPS);
}

static bool make_slot(ring_slot *slot, const tfa_dds_shape *s)
{
    const size_t n = s->base_freedoms + s->v_count, batch = s->max_batch;

    slot->numbers = calloc(doubles_of(s), sizeof(double));
    slot->answers = calloc(batch, sizeof *slot->answers);
    slot->spectrum = calloc(batch, sizeof *slot->spectrum);
    if (slot->numbers == NULL || slot->answers == NULL || slot->spectrum == NULL)
        return false;
    tfa_reply *reply = &slot->answer.reply;
    reply->qdd = slot->numbers;
    reply->base_acceleration = reply->qdd + batch * s->v_count;
    reply->tau = reply->base_acceleration + batch * 6;
    reply->base_wrench = reply->tau + batch * s->v_count;
    reply->mass_matrix = reply->base_wrench + batch * 6;
    reply->lambda_inv = reply->mass_matrix + batch * n * n;
    reply->poses = reply->lambda_inv + batch * TIPS_ROWS * TIPS_ROWS;
    reply->answers = slot->answers;
    reply->spectrum = slot->spectrum;
    return true;
}

int tfa_dds_ring_open(struct tfa_worker *worker, const dds_robot *robot, uint32_t slots,
                      struct tfa_dds_ring **result)
{
    struct tfa_dds_ring *ring = calloc(1, sizeof *ring + slots * sizeof ring->slot[0]);

    *result = ring;
    if (ring == NULL)
        return TFA_E_MEMORY;
    ring->shape = robot->shape;
    ring->delay_ns = worker->delay_ns;
    ring->slots = slots;
    for (uint32_t i = 0; i < slots; i++)
        if (!make_slot(&ring->slot[i], &ring->shape))
            return TFA_E_MEMORY;
    return tfa_workspace_create(robot->model, NULL, &ring->workspace);
}

void tfa_dds_ring_close(struct tfa_dds_ring *ring)
{
    if (ring == NULL)
        return;
    for (uint32_t i = 0; i < ring->slots; i++) {
        free(ring->slot[i].numbers);
        free(ring->slot[i].answers);
        free(ring->slot[i].spectrum);
    }
    tfa_workspace_free(ring->workspace);
    free(ring);
}

int tfa_dds_ring_submit(struct tfa_dds_ring *ring, const tfa_request *request)
{
    ring_slot *slot = &ring->slot[ring->last % ring->slots];

    if (ring->last - ring->first == ring->slots)
        return TFA_E_AGAIN;
    slot->answer.t_start = tfa_dds_monotonic();
    (void)tfa_compute(ring->workspace, request, &slot->answer.reply);
    slot->answer.t_done = tfa_dds_monotonic();
    slot->ready = slot->answer.t_done + ring->delay_ns;
    ring->last++;
    return TFA_OK;
}

bool tfa_dds_ring_peek(struct tfa_dds_ring *ring, dds_ring_answer *answer)
{
    const ring_slot *slot = &ring->slot[ring->first % ring->slots];

    if (ring->first == ring->last || tfa_dds_monotonic() < slot->ready)
        return false;
    *answer = slot->answer;
    return true;
}

void tfa_dds_ring_release(struct tfa_dds_ring *ring)
{
    ring->first++;
}

void tfa_dds_ring_wait(const struct tfa_dds_ring *ring, uint64_t index, uint64_t timeout_ns)
{
    const struct timespec time = {.tv_nsec = (long)timeout_ns / 10};

    (void)ring;
    (void)index;
    clock_nanosleep(CLOCK_MONOTONIC, 0, &time, NULL);
}
