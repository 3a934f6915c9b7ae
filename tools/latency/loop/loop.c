/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The load of one client, measured.
 */
#include "loop.h"

#include "common/daemon.h"

#include <stdlib.h>

/* After so many misses in a row the other side is taken for gone. */
enum { MISSES_IN_A_ROW = 100 };
/* Pause of a client that has no room and awaits nothing */
static const uint64_t no_room_ns = 1000000;
enum { WINDOW_MAX = 1 << 17 };

typedef enum outcome { WAITING, GOOD, LATE, MISSED, LOST } outcome;

/* One request under way, or remembered */
typedef struct entry {
    uint64_t id, index, intended, sent;
    outcome outcome;
} entry;

struct loop {
    transport *t;
    const load_shape *shape;
    tally *tally;
    uint64_t started, limit; /* limit: expected number, for slices; 0: by time */
    entry *entries;          /* of id, by id mod window */
    uint64_t window;
    uint64_t first, next; /* ids: the oldest without an outcome; of the next request */
    uint64_t highest;     /* id received */
    uint64_t misses_in_a_row;
    int miss; /* status of the last miss */
};

loop *loop_create(transport *t, uint64_t window)
{
    loop *l = calloc(1, sizeof *l);
    if (!l)
        return NULL;
    *l = (loop){.t = t, .window = window, .first = 1, .next = 1};
    l->entries = calloc(window, sizeof *l->entries);
    if (!l->entries) {
        free(l);
        return NULL;
    }
    memory_touch(l->entries, window * sizeof *l->entries);
    return l;
}

void loop_free(loop *l)
{
    if (l)
        free(l->entries);
    free(l);
}

uint64_t loop_window(const load_shape *shape, uint32_t slots)
{
    double wanted = 4.0 * slots + shape->rate * (double)shape->timeout_ns / 1e9;
    uint64_t window = 64;
    while (window < WINDOW_MAX && (double)window < wanted)
        window *= 2;
    return window;
}

/* ---- times ---- */

/* splitmix64 of a number, 0 .. 1 */
static double uniform_of(uint64_t z)
{
    z *= 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

uint64_t load_time(const load_shape *shape, uint64_t index)
{
    const uint64_t burst = shape->burst ? shape->burst : 1;
    const uint64_t tick = index / burst;
    const double period = (double)burst * 1e9 / shape->rate;
    uint64_t at = shape->offset_ns + (uint64_t)((double)tick * period);
    if (shape->jitter_ns)
        at += (uint64_t)(uniform_of(shape->seed + tick + 1) * (double)shape->jitter_ns);
    return at;
}

uint64_t load_count(const load_shape *shape)
{
    if (shape->duration_ns == 0 || !(shape->rate > 0))
        return shape->count;
    const uint64_t burst = shape->burst ? shape->burst : 1;
    const double ticks = (double)shape->duration_ns * shape->rate / ((double)burst * 1e9);
    const uint64_t fits = (uint64_t)(ticks + 1e-9) * burst;
    return shape->count && shape->count < fits ? shape->count : fits ? fits : 1;
}

static uint64_t now(const loop *l)
{
    return l->t->ops->now(l->t);
}

static int stopped(const loop *l)
{
    return l->shape->stop && atomic_load_explicit(l->shape->stop, memory_order_relaxed);
}

/* ---- outcomes ---- */

/* Tenth of the run in which a request was due */
static unsigned slice_of(const loop *l, const entry *e)
{
    if (l->limit)
        return (unsigned)(e->index * TALLY_SLICES / l->limit);
    const uint64_t at = e->intended > l->started ? e->intended - l->started : 0;
    return (unsigned)(at * TALLY_SLICES / (l->shape->duration_ns | 1));
}

/* A stamp brought between two others. The daemon may stamp a burst once, before our request left,
 * and DDS times are translated: what is out of order counts as at once, and the parts add up. */
static uint64_t between(uint64_t low, uint64_t stamp, uint64_t high)
{
    return stamp < low ? low : stamp > high ? high : stamp;
}

static void record(loop *l, const entry *e, uint64_t back, const transport_answer *a)
{
    const uint64_t received = between(e->sent, a->t_received, back);
    const uint64_t start = between(received, a->t_start, back);
    const uint64_t done = between(start, a->t_done, back);
    const latency_sample sample = {.index = e->index,
                                   .at = e->intended > l->started ? e->intended - l->started : 0,
                                   .parts = {back - e->intended, e->sent - e->intended,
                                             received - e->sent, start - received, done - start,
                                             back - done}};
    tally_add(l->tally, &sample, slice_of(l, e));
    l->tally->method = a->method;
}

/* Counts the requests whose outcome is known, by order of sending. */
static void settle(loop *l)
{
    while (l->first < l->next) {
        const entry *e = &l->entries[l->first & (l->window - 1)];
        if (e->outcome == WAITING)
            return;
        if (l->tally)
            tally_outcome(l->tally, e->outcome != GOOD);
        l->first++;
    }
}

static void missed(loop *l, entry *e, int status)
{
    const int lost = status == TFA_E_LOST || daemon_lost(status);
    e->outcome = lost ? LOST : MISSED;
    l->miss = status;
    l->misses_in_a_row++;
    if (l->tally && lost)
        l->tally->lost++;
    else if (l->tally)
        tally_reject(l->tally, status);
}

static void good(loop *l, entry *e, uint64_t back, const transport_answer *a)
{
    const uint64_t deadline = l->shape->deadline_ns;
    const int late = deadline && back - e->intended > deadline;
    e->outcome = late ? LATE : GOOD;
    l->misses_in_a_row = 0;
    if (!l->tally)
        return;
    l->tally->late += (uint64_t)late;
    record(l, e, back, a);
}

/* Matches a reply with its request. */
static void take(loop *l, const transport_answer *a)
{
    const uint64_t back = now(l);
    entry *e = &l->entries[a->id & (l->window - 1)];
    const int known = e->id == a->id && a->id != 0;
    if (known && e->outcome == WAITING) {
        if (l->tally && a->id < l->highest)
            l->tally->reordered++;
        l->highest = a->id > l->highest ? a->id : l->highest;
        if (a->status == TFA_OK)
            good(l, e, back, a);
        else
            missed(l, e, a->status);
        settle(l);
        return;
    }
    if (l->tally && known && e->outcome == LOST)
        l->tally->stale++;
    else if (l->tally)
        l->tally->duplicates++;
    if (known && e->outcome == LOST)
        e->outcome = MISSED; /* one more is a duplicate */
}

/* Gives up the requests that waited too long. @return when the next would, UINT64_MAX: none */
static uint64_t expire(loop *l, uint64_t at)
{
    while (l->first < l->next) {
        entry *e = &l->entries[l->first & (l->window - 1)];
        if (e->sent + l->shape->timeout_ns > at)
            return e->sent + l->shape->timeout_ns;
        missed(l, e, TFA_E_TIMEOUT);
        settle(l);
    }
    return UINT64_MAX;
}

/* The connection is of no more use: what is under way is lost. */
static int reconnect(loop *l, int status)
{
    for (uint64_t id = l->first; id < l->next; id++) {
        entry *e = &l->entries[id & (l->window - 1)];
        if (e->outcome == WAITING)
            missed(l, e, status);
    }
    settle(l);
    if (!l->tally || l->misses_in_a_row >= MISSES_IN_A_ROW)
        return status;
    const int result = l->t->ops->reconnect(l->t);
    l->tally->reconnects += result == TFA_OK;
    return result;
}

/* Ends a warm-up after a miss, a measurement after many in a row. */
static int go_on(const loop *l)
{
    const uint64_t most = l->tally ? MISSES_IN_A_ROW : 1;
    return l->misses_in_a_row >= most ? l->miss : TFA_OK;
}

/* ---- sending ---- */

static entry *enter(loop *l, uint64_t index, uint64_t intended, uint64_t sent)
{
    const uint64_t id = l->next++;
    entry *e = &l->entries[id & (l->window - 1)];
    *e = (entry){.id = id, .index = index, .intended = intended, .sent = sent};
    if (l->tally)
        l->tally->sent++;
    return e;
}

/* Sends request `index`, due at `intended` (0: when it leaves). @return TFA_OK: it has an entry;
 * TFA_E_AGAIN: no room; otherwise the run ends */
static int send_one(loop *l, uint64_t index, uint64_t intended)
{
    if (l->next - l->first >= l->window)
        return TFA_E_AGAIN;
    const uint64_t sent = now(l);
    const int status = l->t->ops->send(l->t, l->next, index);
    if (status == TFA_E_AGAIN)
        return status;
    entry *e = enter(l, index, intended ? intended : sent, sent);
    if (status == TFA_OK)
        return TFA_OK;
    missed(l, e, status);
    settle(l);
    return daemon_lost(status) ? reconnect(l, status) : TFA_OK;
}

/* ---- closed loop ---- */

static void wait_until_due(loop *l, uint64_t index, uint64_t last)
{
    uint64_t due = 0;
    if (l->shape->rate > 0)
        due = l->started + load_time(l->shape, index);
    if (l->shape->think_ns && last && last + l->shape->think_ns > due)
        due = last + l->shape->think_ns;
    if (due && due > now(l))
        l->t->ops->idle(l->t, due);
}

/* Waits until the requests under way have an outcome. */
static int receive_all(loop *l)
{
    while (l->first < l->next) {
        transport_answer answer = {0};
        const uint64_t until = expire(l, now(l));
        if (until == UINT64_MAX)
            break;
        int status = l->t->ops->receive(l->t, until, &answer);
        if (status == TFA_OK)
            take(l, &answer);
        else if (status != TFA_E_TIMEOUT && (status = reconnect(l, status)) != TFA_OK)
            return status;
    }
    return TFA_OK;
}

/* As one call, the way programs do it. */
static int call_one(loop *l, uint64_t index)
{
    transport_answer answer = {0};
    const uint64_t sent = now(l);
    const uint64_t id = l->next;
    int status = l->t->ops->call(l->t, id, index, &answer);
    const uint64_t back = now(l);
    entry *e = enter(l, index, sent, sent);
    if (status == TFA_OK && answer.status == TFA_OK) {
        l->highest = id;
        good(l, e, back, &answer);
        settle(l);
        return TFA_OK;
    }
    missed(l, e, status == TFA_OK ? answer.status : status);
    settle(l);
    return daemon_lost(status) ? reconnect(l, status) : TFA_OK;
}

static int exchange_one(loop *l, uint64_t index)
{
    if (l->t->ops->call)
        return call_one(l, index);
    int status = send_one(l, index, 0);
    if (status == TFA_E_AGAIN) { /* replies that were given up hold the room */
        if (l->tally)
            l->tally->full++;
        l->t->ops->idle(l->t, now(l) + no_room_ns);
        status = TFA_OK;
    }
    return status == TFA_OK ? receive_all(l) : status;
}

static int run_closed(loop *l, uint64_t count)
{
    const uint64_t end = l->shape->duration_ns ? l->started + l->shape->duration_ns : UINT64_MAX;
    int status = TFA_OK;
    uint64_t last = 0;
    for (uint64_t i = 0; (count == 0 || i < count) && status == TFA_OK; i++) {
        wait_until_due(l, i, last);
        if (stopped(l) || (end != UINT64_MAX && now(l) >= end))
            break;
        status = exchange_one(l, i);
        if (l->shape->think_ns)
            last = now(l);
        if (status == TFA_OK)
            status = go_on(l);
    }
    return status;
}

/* ---- open loop ---- */

/* Progress of an open loop */
typedef struct schedule {
    uint64_t index, count; /* of the next request, of all */
    uint64_t due;          /* of the next one; UINT64_MAX: none left */
    int blocked;           /* the last send found no room */
} schedule;

static void next_due(const loop *l, schedule *s)
{
    uint64_t due = UINT64_MAX;
    if (s->index < s->count) {
        due = l->started + load_time(l->shape, s->index);
        if (s->index && s->due != UINT64_MAX && due < s->due)
            due = s->due; /* jitter beyond the period does not change the order */
    }
    s->due = due;
}

/* Sends what is due. */
static int send_due(loop *l, schedule *s, uint64_t at)
{
    const int was_blocked = s->blocked;
    s->blocked = 0;
    for (int first = 1; s->due <= at; first = 0) {
        const int status = send_one(l, s->index, s->due);
        if (status == TFA_E_AGAIN) {
            s->blocked = 1;
            if (l->tally && !(was_blocked && first)) /* each request once */
                l->tally->full++;
            return TFA_OK;
        }
        if (status != TFA_OK)
            return status;
        s->index++;
        next_due(l, s);
    }
    return TFA_OK;
}

/* Waits for the next event: a reply, a time to send, the loss of a request. */
static int await(loop *l, schedule *s, uint64_t lost_at)
{
    transport_answer answer = {0};
    uint64_t until = s->due < lost_at ? s->due : lost_at;
    if (s->blocked) {
        const uint64_t retry = now(l) + no_room_ns;
        until = lost_at < retry ? lost_at : retry;
    } else if (l->first == l->next) {
        l->t->ops->idle(l->t, until);
        return TFA_OK;
    }
    const int status = l->t->ops->receive(l->t, until, &answer);
    if (status == TFA_OK)
        take(l, &answer);
    else if (status != TFA_E_TIMEOUT)
        return reconnect(l, status);
    return TFA_OK;
}

static int run_open(loop *l, uint64_t count)
{
    schedule s = {.count = count};
    int status = TFA_OK;
    next_due(l, &s);
    while (status == TFA_OK && (s.index < s.count || l->first < l->next)) {
        if (stopped(l)) {
            s = (schedule){.due = UINT64_MAX};
            if (l->first == l->next)
                break;
        }
        const uint64_t at = now(l);
        const uint64_t lost_at = expire(l, at);
        if (s.due <= at) {
            status = send_due(l, &s, at);
            if (status == TFA_OK)
                status = await(l, &s, expire(l, at));
        } else {
            status = await(l, &s, lost_at);
        }
        if (status == TFA_OK)
            status = go_on(l);
    }
    return status;
}

int loop_run(loop *l, const load_shape *shape, uint64_t start, tally *t)
{
    const uint64_t count = load_count(shape);
    l->shape = shape;
    l->tally = t;
    l->started = start;
    l->limit = count;
    l->misses_in_a_row = 0;
    l->miss = TFA_OK;
    const int status = shape->open ? run_open(l, count) : run_closed(l, count);
    if (t)
        t->elapsed_ns = now(l) - start;
    return status;
}
