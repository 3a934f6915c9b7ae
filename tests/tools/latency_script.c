/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A responder with a scripted pattern.
 */
#include "latency_script.h"

#include <stdlib.h>
#include <string.h>

static script *own(transport *t)
{
    return (script *)(void *)t;
}

static uint64_t clock_now(transport *t)
{
    return own(t)->now;
}

static void schedule(script *s, uint64_t at, transport_answer answer, int frees)
{
    if (s->reply_count == s->reply_room) {
        s->reply_room = 2 * s->reply_room + 16;
        s->replies = realloc(s->replies, s->reply_room * sizeof *s->replies);
        if (!s->replies)
            abort();
    }
    uint64_t k = s->reply_count++;
    for (; k > 0 && s->replies[k - 1].at > at; k--)
        s->replies[k] = s->replies[k - 1];
    s->replies[k].at = at;
    s->replies[k].answer = answer;
    s->replies[k].frees = frees;
}

/* When a queue has done with a request of this service time. */
static uint64_t served(script *s, uint64_t service)
{
    uint64_t start = s->now > s->busy_until ? s->now : s->busy_until;
    if (start >= s->stall.begin && start < s->stall.end)
        start = s->stall.end;
    s->busy_until = start + service;
    return s->busy_until;
}

static int send_request(transport *t, uint64_t id, uint64_t index)
{
    script *s = own(t);
    const script_line *line = &s->lines[index % s->count];
    if (s->outstanding == s->slots)
        return TFA_E_AGAIN;
    if (s->hang_ups && s->sent >= s->hang_ups) {
        s->hang_ups = 0;
        return TFA_E_DISCONNECTED;
    }
    s->sent++;
    if (line->lost)
        return TFA_OK;
    const uint64_t done = s->queue ? served(s, line->delay) : s->now + line->delay;
    const uint64_t took = done - s->now;
    const transport_answer answer = {.id = id,
                                     .status = line->status,
                                     .method = TFA_METHOD_ABA,
                                     .t_received = s->now + took / 10,
                                     .t_start = s->now + 3 * (took / 10),
                                     .t_done = s->now + 6 * (took / 10)};
    s->outstanding++;
    schedule(s, done, answer, 1);
    if (line->repeat)
        schedule(s, done + line->repeat, answer, 0);
    return TFA_OK;
}

static int receive(transport *t, uint64_t until, transport_answer *answer)
{
    script *s = own(t);
    if (s->reply_count == 0 || s->replies[0].at > until) {
        s->now = until > s->now ? until : s->now;
        return TFA_E_TIMEOUT;
    }
    s->now = s->replies[0].at > s->now ? s->replies[0].at : s->now;
    *answer = s->replies[0].answer;
    s->outstanding -= (uint32_t)s->replies[0].frees;
    memmove(s->replies, s->replies + 1, --s->reply_count * sizeof *s->replies);
    return TFA_OK;
}

static void idle(transport *t, uint64_t until)
{
    script *s = own(t);
    s->now = until > s->now ? until : s->now;
}

static int reconnect(transport *t)
{
    script *s = own(t);
    s->reply_count = 0;
    s->outstanding = 0;
    s->reconnections++;
    return TFA_OK;
}

static void close_transport(transport *t)
{
    (void)t;
}

static const transport_operations operations = {.now = clock_now,
                                                .send = send_request,
                                                .receive = receive,
                                                .idle = idle,
                                                .reconnect = reconnect,
                                                .close = close_transport};

void script_init(script *s, const script_line *lines, uint64_t count, uint32_t slots)
{
    *s = (script){.base.ops = &operations, .lines = lines, .count = count, .slots = slots};
    s->now = SECOND;
}

void script_free(script *s)
{
    free(s->replies);
}

uint64_t script_draw(uint64_t *seed, uint64_t below)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (*seed >> 33) % below;
}

script_line *script_delays(uint64_t count)
{
    script_line *lines = calloc(count, sizeof *lines);
    uint64_t seed = 7;
    if (!lines)
        abort();
    for (uint64_t i = 0; i < count; i++) {
        lines[i].delay = 1 * US + script_draw(&seed, 20 * US);
        if (script_draw(&seed, 400) == 0)
            lines[i].delay += script_draw(&seed, 3 * MS);
    }
    return lines;
}

uint64_t script_slowest(const script_line *lines, uint64_t count)
{
    uint64_t slowest = 0;
    for (uint64_t i = 1; i < count; i++)
        if (lines[i].delay > lines[slowest].delay)
            slowest = i;
    return slowest;
}
