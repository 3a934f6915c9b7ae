/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Both ends of one ring.
 */
#include "ring_sides.h"

#include <string.h>

#include "explorer.h"
#include "ipc/ring.h"

#define SEGMENT_BYTES (2 * TFA_CACHE_LINE + RING_SLOTS_MAX * 3 * TFA_CACHE_LINE)

ring_case ring_under_test;
ring_error ring_error_made;

static _Alignas(TFA_CACHE_LINE) unsigned char requests[SEGMENT_BYTES], replies[SEGMENT_BYTES];
static tfa_ring_client client;
static tfa_ring_server server;

static bool has_error(ring_error error)
{
    return ring_error_made == error;
}

void ring_reset(void *argument)
{
    const tfa_ring_layout layout = {.slots = ring_under_test.slots,
                                    .request_stride = tfa_ring_stride(TFA_WIRE_LINE),
                                    .reply_stride = tfa_ring_stride(TFA_WIRE_LINE)};
    (void)argument;
    memset(requests, 0, sizeof requests);
    memset(replies, 0, sizeof replies);
    client = (tfa_ring_client){.layout = layout,
                               .requests = requests,
                               .replies = replies,
                               .worker_status = (const void *)replies,
                               .spin = ring_under_test.spin};
    server = (tfa_ring_server){
        .layout = layout, .requests = requests, .replies = replies, .spin = ring_under_test.spin};
}

/* ---- client: send_request, wait_until, read_reply ---- */

static bool send_after_flag(void)
{
    tfa_wire_request *line = tfa_ring_next_request(&client);
    const bool asleep =
        atomic_load_explicit(&client.worker_status->asleep, memory_order_seq_cst) != 0;
    atomic_store_explicit(&line->seq, ++client.sent, memory_order_seq_cst);
    return asleep;
}

static void send_request(void)
{
    tfa_wire_request *line = tfa_ring_next_request(&client);
    if (!has_error(CLIENT_WRITES_AFTER_SEND))
        explorer_data_write(&line->id, 100 + client.sent);
    const bool asleep =
        has_error(CLIENT_FLAG_READ_BEFORE_SEND) ? send_after_flag() : tfa_ring_send(&client);
    if (has_error(CLIENT_WRITES_AFTER_SEND))
        explorer_data_write(&line->id, 99 + client.sent);
    if (asleep && !has_error(CLIENT_NO_DOORBELL))
        explorer_doorbell_write();
}

static const tfa_wire_reply *reply_at(uint64_t index)
{
    return (const void *)(client.replies + tfa_ring_reply_offset(&client.layout, index));
}

static uint64_t prepare_wait(uint64_t index)
{
    _Atomic uint32_t *flag = &tfa_ring_client_flags_of(&client)->asleep;
    if (has_error(CLIENT_NO_FLAG))
        return atomic_load_explicit(&reply_at(index)->seq, memory_order_seq_cst);
    if (has_error(CLIENT_FLAG_AFTER_RECHECK)) {
        const uint64_t seq = atomic_load_explicit(&reply_at(index)->seq, memory_order_seq_cst);
        atomic_store_explicit(flag, 1, memory_order_seq_cst);
        return seq;
    }
    if (has_error(CLIENT_RECHECK_ACQUIRE)) {
        atomic_store_explicit(flag, 1, memory_order_seq_cst);
        return atomic_load_explicit(&reply_at(index)->seq, memory_order_acquire);
    }
    if (has_error(CLIENT_NO_RECHECK)) {
        atomic_store_explicit(flag, 1, memory_order_seq_cst);
        return index < client.layout.slots ? 0 : index + 1 - client.layout.slots;
    }
    return tfa_ring_client_prepare_wait(&client, index);
}

static void sleep_for(uint64_t index)
{
    for (;;) {
        const uint64_t seq = prepare_wait(index);
        if (seq == index + 1)
            break;
        const tfa_wire_reply *slot = reply_at(index);
        explorer_futex_wait(tfa_ring_futex_word(slot), (uint32_t)seq);
        if (atomic_load_explicit(&slot->seq, memory_order_acquire) == index + 1) /* R2 */
            break;
    }
    tfa_ring_client_end_wait(&client);
}

static void wait_for_reply(void)
{
    uint32_t polls = 0;
    if (ring_under_test.client_sleeps && ring_under_test.waits_for_last)
        sleep_for(client.sent - 1);
    while (!tfa_ring_reply_ready(&client)) {
        if (!ring_under_test.client_sleeps) {
            explorer_spin();
        } else if (polls++ >= ring_under_test.client_polls) {
            sleep_for(client.received);
            return;
        }
    }
}

static void read_reply(void)
{
    const tfa_wire_reply *line = tfa_ring_oldest_reply(&client);
    const uint64_t expected = 200 + client.received;
    if (has_error(CLIENT_READS_AFTER_RELEASE)) {
        tfa_ring_release(&client);
        if (client.sent < ring_under_test.requests)
            send_request();
    }
    explorer_check(explorer_data_read(&line->id) == expected, "wrong reply");
    if (!has_error(CLIENT_READS_AFTER_RELEASE))
        tfa_ring_release(&client);
}

static bool may_send(void)
{
    if (client.sent == ring_under_test.requests)
        return false;
    return has_error(CLIENT_IGNORES_FULL) ||
           (client.sent - client.received < ring_under_test.outstanding && !tfa_ring_full(&client));
}

void ring_client_body(void *argument)
{
    (void)argument;
    while (client.received < ring_under_test.requests) {
        while (may_send())
            send_request();
        if (!has_error(CLIENT_READS_EARLY))
            wait_for_reply();
        read_reply();
    }
}

/* ---- worker: begin_request, finish_request, tfa_worker_sleep ---- */

static bool publish_after_flag(void)
{
    tfa_wire_reply *line = tfa_ring_reply(&server);
    const tfa_ring_client_flags *flags = (const void *)server.requests;
    const bool asleep = atomic_load_explicit(&flags->asleep, memory_order_seq_cst) != 0;
    atomic_store_explicit(&line->seq, ++server.next, memory_order_seq_cst);
    return asleep;
}

static void read_request(const tfa_wire_request *line, uint64_t expected)
{
    explorer_check(explorer_data_read(&line->id) == expected, "wrong request");
}

static void answer_request(void)
{
    const tfa_wire_request *request = tfa_ring_request(&server);
    tfa_wire_reply *slot = tfa_ring_reply(&server);
    const uint64_t index = server.next;
    if (!has_error(WORKER_READS_AFTER_PUBLISH))
        read_request(request, 100 + index);
    if (!has_error(WORKER_WRITES_AFTER_PUBLISH))
        explorer_data_write(&slot->id, 200 + index);
    const bool asleep = has_error(WORKER_FLAG_READ_BEFORE_PUBLISH) ? publish_after_flag()
                                                                   : tfa_ring_publish(&server);
    if (has_error(WORKER_READS_AFTER_PUBLISH))
        read_request(request, 100 + index);
    if (has_error(WORKER_WRITES_AFTER_PUBLISH))
        explorer_data_write(&slot->id, 200 + index);
    if (asleep && !has_error(WORKER_NO_WAKE))
        explorer_futex_wake(tfa_ring_futex_word(slot));
}

static _Atomic uint32_t *asleep_flag(void)
{
    return &tfa_ring_worker_status_of(&server)->asleep;
}

/* The two values of show_asleep in worker.c, apart because the clearing has another purpose */
static void set_asleep(void)
{
    if (!has_error(WORKER_NO_FLAG))
        atomic_store_explicit(asleep_flag(), 1, memory_order_seq_cst); /* A3 */
}

static void clear_asleep(void)
{
    atomic_store_explicit(asleep_flag(), 0, memory_order_seq_cst); /* A3 */
}

static bool has_work(void)
{
    if (has_error(WORKER_NO_RECHECK))
        return false;
    return (has_error(WORKER_RECHECK_ACQUIRE) ? tfa_ring_poll(&server)
                                              : tfa_ring_poll_last(&server)) != TFA_RING_EMPTY;
}

static void worker_sleep(void)
{
    if (has_error(WORKER_FLAG_AFTER_RECHECK)) {
        const bool work = has_work();
        set_asleep();
        if (!work)
            explorer_doorbell_wait();
    } else {
        set_asleep();
        if (!has_work())
            explorer_doorbell_wait();
    }
    clear_asleep();
}

void ring_worker_body(void *argument)
{
    uint32_t polls = 0;
    (void)argument;
    while (server.next < ring_under_test.requests) {
        const tfa_ring_state state = tfa_ring_poll(&server);
        explorer_check(state != TFA_RING_BROKEN, "sequence number outside the window");
        if (state == TFA_RING_READY) {
            answer_request();
            polls = 0;
        } else if (!ring_under_test.worker_sleeps) {
            explorer_spin();
        } else if (polls++ >= ring_under_test.worker_polls) {
            worker_sleep();
            polls = 0;
        }
    }
}

const char *ring_error_text(ring_error error)
{
    static const char *const texts[RING_ERRORS] = {
        [ERROR_NONE] = "none",
        [CLIENT_FLAG_AFTER_RECHECK] = "client: flag (A4) after the recheck (R2)",
        [CLIENT_NO_RECHECK] = "client: no recheck (R2) after the flag",
        [CLIENT_RECHECK_ACQUIRE] = "client: recheck (R2) by an acquire load",
        [CLIENT_NO_FLAG] = "client: no flag (A4)",
        [CLIENT_FLAG_READ_BEFORE_SEND] = "client: worker's flag (R3) read before A1",
        [CLIENT_NO_DOORBELL] = "client: no doorbell",
        [CLIENT_WRITES_AFTER_SEND] = "client: writes the request after A1",
        [CLIENT_READS_AFTER_RELEASE] = "client: sends again, then reads the reply",
        [CLIENT_IGNORES_FULL] = "client: sends into a full ring",
        [CLIENT_READS_EARLY] = "client: reads without waiting (R2)",
        [WORKER_FLAG_AFTER_RECHECK] = "worker: flag (A3) after the recheck (R1)",
        [WORKER_NO_RECHECK] = "worker: no recheck (R1) after the flag",
        [WORKER_RECHECK_ACQUIRE] = "worker: recheck (R1) by tfa_ring_poll",
        [WORKER_NO_FLAG] = "worker: no flag (A3)",
        [WORKER_FLAG_READ_BEFORE_PUBLISH] = "worker: client's flag (R4) read before A2",
        [WORKER_NO_WAKE] = "worker: no wake-up",
        [WORKER_WRITES_AFTER_PUBLISH] = "worker: writes the reply after A2",
        [WORKER_READS_AFTER_PUBLISH] = "worker: reads the request after A2",
    };
    return texts[error];
}
