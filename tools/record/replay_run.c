/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Plays the requests of a recording and compares the answers.
 */
#include "replay.h"

#include "common/commands.h"
#include "common/environment.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define ALIGNMENT 64
#define PROGRESS_NS 500000000u

/* ---- records ---- */

/* Whether the daemon answered so for the time it was, not for the request. */
static int is_of_time(int status)
{
    return status == TFA_E_LATE || status == TFA_E_AGAIN || status == TFA_E_BUSY ||
           status == TFA_E_TIMEOUT;
}

/* A daemon that samples estimates counts open requests anew: which it estimates is chance. */
static int is_sampled(const replay *r, const recorded *from)
{
    return r->options->robot && r->robot.sampled && from->head->estimate == TFA_ESTIMATE_DEFAULT &&
           from->request->estimate == TFA_ESTIMATE_DEFAULT;
}

replay_kind replay_decode(const replay *r, const recorded *from, replay_request *out)
{
    const tfa_tap_record *head = from->head;
    const tfa_wire_reply *reply = from->reply;
    *out = (replay_request){.from = *from, .shape = r->robot.shape};
    if (head->max_batch < 1 || head->max_batch > out->shape.max_batch || head->max_tips < 1 ||
        head->max_tips > out->shape.max_tips)
        return REPLAY_DAMAGED;
    out->shape.max_batch = head->max_batch;
    out->shape.max_tips = head->max_tips;
    if (tfa_wire_copied_bytes(&out->shape, from->request) != head->request_bytes)
        return REPLAY_DAMAGED;
    if (is_of_time(reply->status) || is_sampled(r, from))
        return REPLAY_OF_TIME;
    out->status = tfa_wire_decode_request(&out->shape, from->request, &out->request,
                                          &out->reply_shape, &out->field);
    const int answered = tfa_wire_has_answers(reply->status);
    if (answered && out->status != TFA_OK)
        return REPLAY_DAMAGED;
    if (reply->want != (answered ? out->reply_shape.want : 0))
        return REPLAY_DAMAGED;
    const size_t bytes =
        answered ? tfa_wire_reply_bytes(&out->shape, &out->reply_shape) : TFA_WIRE_LINE;
    if (bytes != head->reply_bytes)
        return REPLAY_DAMAGED;
    return reply->status == TFA_E_REFUSED && !r->options->robot ? REPLAY_REFUSED : REPLAY_PLAYED;
}

/* ---- one request ---- */

/* Room for a reply. @return TFA_OK, TFA_E_MEMORY */
static int make_room(replay *r, size_t bytes)
{
    if (bytes <= r->reply_bytes)
        return TFA_OK;
    const size_t size = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    free(r->reply);
    r->reply = aligned_alloc(ALIGNMENT, size);
    r->reply_bytes = r->reply ? size : 0;
    if (!r->reply)
        return TFA_E_MEMORY;
    memset(r->reply, 0, size);
    return TFA_OK;
}

/* @return TFA_OK: there is an answer, of whatever status; else why there is none */
static int solve(replay *r, const replay_request *q, tfa_reply *reply, uint64_t *ns)
{
    tfa_exchange times = {0};
    if (!r->daemon) {
        const uint64_t start = clock_ns();
        (void)tfa_compute(r->workspace, &q->request, reply);
        *ns = clock_ns() - start;
        return TFA_OK;
    }
    const int status = daemon_call(r->daemon, &q->request, reply, &times);
    *ns = times.t_done - times.t_start;
    return daemon_lost(status) ? status : TFA_OK;
}

static int answer_again(replay *r, const replay_request *q, uint64_t *ns)
{
    tfa_reply reply = {.status = q->status, .field = q->field};
    *ns = 0;
    int status = make_room(r, tfa_wire_reply_bytes(&q->shape, &q->reply_shape));
    if (status != TFA_OK)
        return status;
    if (q->status != TFA_OK) {
        reply.index = tfa_wire_refused_index(&q->request, q->field);
    } else {
        tfa_wire_reply_buffers(&q->shape, &q->reply_shape, r->reply, &reply);
        status = solve(r, q, &reply, ns);
    }
    memset(r->reply, 0, TFA_WIRE_LINE);
    tfa_wire_encode_reply(&reply, q->reply_shape.want, r->reply);
    return status;
}

static void count_differences(replay *r, uint64_t record, const compared *c)
{
    r->differences += c->differences;
    if (c->differences) {
        if (r->differing++ == 0 || record < r->first.record)
            r->first = (replay_difference){record, c->first};
    } else if (c->largest.field) {
        r->within++;
    } else {
        r->same++;
    }
    if (c->largest.field && (!r->largest.at.field || c->largest.relative > r->largest.at.relative))
        r->largest = (replay_difference){record, c->largest};
}

/* @return TFA_OK; TFA_E_MEMORY; a status of a daemon that is gone */
static int play(replay *r, uint64_t k)
{
    char text[200];
    size_t at = r->records[k];
    recorded from;
    replay_request q;
    uint64_t ns;
    (void)recording_next(&r->file, &at, &from, text, sizeof text); /* it was checked */
    const replay_kind kind = replay_decode(r, &from, &q);
    if (kind != REPLAY_PLAYED) {
        *(kind == REPLAY_OF_TIME ? &r->of_time : &r->refused) += 1;
        return TFA_OK;
    }
    const int status = answer_again(r, &q, &ns);
    if (status != TFA_OK)
        return status;
    const tfa_wire_reply *reply = from.reply;
    tfa_wire_reply_shape shape = q.reply_shape;
    shape.want &= reply->want;
    const compared c = compare_replies(&q.shape, &shape, reply, r->reply, r->options->tolerance,
                                       r->options->any_model);
    count_differences(r, r->numbers[k], &c);
    if (tfa_wire_has_answers(reply->status)) {
        tfa_histogram_add(&r->recorded, reply->t_done - reply->t_start);
        tfa_histogram_add(&r->replayed, ns);
    }
    return TFA_OK;
}

/* ---- all of them ---- */

static uint64_t sent_at(const replay *r, uint64_t k)
{
    const tfa_tap_record *head = (const void *)(r->file.bytes + r->records[k]);
    return ((const tfa_wire_request *)(const void *)(head + 1))->t_sent;
}

static void wait_until(uint64_t due)
{
    const struct timespec at = {.tv_sec = (time_t)(due / 1000000000u),
                                .tv_nsec = (long)(due % 1000000000u)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
}

static void pace(const replay *r, uint64_t k, uint64_t start)
{
    const double hz = r->options->hz;
    if (hz > 0)
        wait_until(start + (uint64_t)(1e9 / hz * (double)k));
    else if (hz < 0 && sent_at(r, k) > sent_at(r, 0))
        wait_until(start + (sent_at(r, k) - sent_at(r, 0)));
}

static void show_progress(const replay *r, uint64_t k, uint64_t *shown)
{
    if (k % 64 != 0 || !isatty(STDERR_FILENO))
        return;
    const uint64_t now = clock_ns();
    if (now - *shown < PROGRESS_NS)
        return;
    *shown = now;
    fprintf(stderr, "\r\033[K%" PRIu64 " of %" PRIu64 " requests", k, r->count);
    fflush(stderr);
}

int replay_run(replay *r)
{
    const uint64_t start = clock_ns();
    uint64_t shown = start;
    int status = TFA_OK;
    for (uint64_t k = 0; k < r->count && status == TFA_OK; k++) {
        pace(r, k, start);
        status = play(r, k);
        show_progress(r, k, &shown);
        if (status != TFA_OK)
            fprintf(stderr, "totalforce replay: record %" PRIu64 ": %s: %s\n", r->numbers[k],
                    tfa_status_text(status), tfa_status_cause(status));
    }
    if (shown != start)
        fputs("\r\033[K", stderr);
    return status == TFA_OK ? EXIT_GOOD : EXIT_FAILED;
}
