/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Snapshots of statistics: copies, and sums of clients. Numbers from the segment that choose
 * memory are checked.
 */
#include <stdlib.h>
#include <string.h>

#include "client/client_statistics.h"

#include "client/client.h"
#include "ipc/wire_blocks.h"

/* A tally with its histograms is copied so often to be of one moment; then they may be ahead. */
#define WHOLE_TRIES 4
/* A worker whose clients come and go is read so often. */
#define ATTACHMENT_TRIES 100

typedef uint64_t bucket_row[TFA_STATISTICS_BUCKETS];

/* What a snapshot has room for, in one block with it. */
typedef struct snapshot_memory {
    tfa_snapshot snapshot; /* first: freed by it */
    uint32_t robots, clients;
} snapshot_memory;

/* ---- memory ---- */

static void make_histograms(tfa_tally *t, bucket_row **buckets)
{
    tfa_histogram *const all[TFA_TIMES] = {&t->queue, &t->compute, &t->total};
    for (int k = 0; k < TFA_TIMES; k++)
        *all[k] = (tfa_histogram){.bits = TFA_STATISTICS_BITS,
                                  .bucket_count = TFA_STATISTICS_BUCKETS,
                                  .buckets = *(*buckets)++};
}

/* Pages that no robot and no client uses are never touched. */
int tfa_snapshot_create(const tfa_statistics *s, tfa_snapshot **snapshot)
{
    const size_t robots = s->robots,
                 clients = (size_t)s->workers * s->clients + TFA_GATEWAY_SOURCES * robots;
    const size_t tallies = 2 * robots + clients;
    const size_t head = sizeof(snapshot_memory) + robots * sizeof(tfa_robot_statistics) +
                        clients * sizeof(tfa_client_statistics);
    *snapshot = NULL;
    snapshot_memory *m = calloc(1, head + tallies * TFA_TIMES * sizeof(bucket_row));
    if (!m)
        return TFA_E_MEMORY;
    m->robots = s->robots;
    m->clients = (uint32_t)clients;
    m->snapshot.robots = (tfa_robot_statistics *)(m + 1);
    m->snapshot.clients = (tfa_client_statistics *)(m->snapshot.robots + robots);
    bucket_row *buckets = (bucket_row *)(void *)(m->snapshot.clients + clients);
    for (size_t i = 0; i < robots; i++) {
        make_histograms(&m->snapshot.robots[i].total, &buckets);
        make_histograms(&m->snapshot.robots[i].departed, &buckets);
    }
    for (size_t i = 0; i < clients; i++)
        make_histograms(&m->snapshot.clients[i].tally, &buckets);
    *snapshot = &m->snapshot;
    return TFA_OK;
}

void tfa_snapshot_free(tfa_snapshot *snapshot)
{
    free(snapshot);
}

/* ---- one tally ---- */

static uint64_t relaxed(const tfa_counter *word)
{
    return atomic_load_explicit(word, memory_order_relaxed);
}

static void copy_buckets(const tfa_counter *words, tfa_histogram *h)
{
    for (uint32_t i = 0; i < TFA_STATISTICS_BUCKETS; i++)
        h->buckets[i] = atomic_load_explicit(&words[i], memory_order_acquire); /* T2 */
}

/* Count and lowest follow from the buckets. */
static void set_histogram(tfa_histogram *h, uint64_t sum, uint64_t highest)
{
    h->count = h->lowest = h->highest_index = 0;
    for (uint32_t i = TFA_STATISTICS_BUCKETS; i-- > 0;)
        if (h->buckets[i]) {
            h->count += h->buckets[i];
            h->lowest = i ? tfa_histogram_top(h, i - 1) + 1 : 0;
        }
    h->sum = (double)sum;
    h->highest = highest;
    if (h->lowest > highest)
        h->lowest = highest;
}

static double double_of(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void set_tally(tfa_tally *t, const uint64_t words[TFA_TALLY_WORDS])
{
    const uint64_t *flags = &words[TFA_TALLY_FLAGS];
    tfa_histogram *const all[TFA_TIMES] = {&t->queue, &t->compute, &t->total};
    memcpy(t->statuses, &words[TFA_TALLY_STATUSES], sizeof t->statuses);
    memcpy(t->methods, &words[TFA_TALLY_METHODS], sizeof t->methods);
    memcpy(t->estimate_decades, &words[TFA_TALLY_DECADES], sizeof t->estimate_decades);
    t->requests = t->rejected = 0;
    for (int i = 0; i < TFA_STATISTICS_STATUSES; i++) {
        t->requests += t->statuses[i];
        t->rejected += tfa_wire_has_answers(-i) ? 0 : t->statuses[i];
    }
    t->late = t->statuses[-TFA_E_LATE];
    t->states = t->requests - t->rejected + words[TFA_TALLY_MORE_STATES];
    t->busy_ns = words[TFA_TALLY_SUMS + TFA_TIME_COMPUTE] - words[TFA_TALLY_PAUSES];
    t->refined = words[TFA_TALLY_REFINED];
#define FLAG(name) flags[__builtin_ctz(TFA_ANSWER_##name)]
    t->estimates = FLAG(ESTIMATED);
    t->fallbacks = FLAG(FALLBACK);
    t->inaccurate = FLAG(INACCURATE);
    t->stalled = FLAG(STALLED);
    t->not_finite = FLAG(NOT_FINITE);
    t->residual_precision = FLAG(RESIDUAL_PRECISION);
    t->sentinel = FLAG(SENTINEL);
#undef FLAG
    t->largest_estimate = double_of(words[TFA_TALLY_LARGEST]);
    for (int k = 0; k < TFA_TIMES; k++)
        set_histogram(all[k], words[TFA_TALLY_SUMS + k], words[TFA_TALLY_MAXIMA + k]);
}

/* @return false: it was being written all the time */
static bool read_tally(const tfa_shared_tally *from, tfa_tally *t)
{
    uint64_t words[TFA_TALLY_WORDS];
    tfa_histogram *const all[TFA_TIMES] = {&t->queue, &t->compute, &t->total};
    for (int i = 0; i < WHOLE_TRIES; i++) {
        const uint64_t began = tfa_record_version(&from->version);
        if (!tfa_record_read(&from->version, from->words, words, sizeof words))
            return false;
        for (int k = 0; k < TFA_TIMES; k++)
            copy_buckets(from->buckets[k], all[k]);
        if (tfa_record_is_valid(&from->version, began))
            break;
    }
    set_tally(t, words);
    return true;
}

static void clear_tally(tfa_tally *t)
{
    static const uint64_t none[TFA_TALLY_WORDS];
    tfa_histogram *const all[TFA_TIMES] = {&t->queue, &t->compute, &t->total};
    for (int k = 0; k < TFA_TIMES; k++)
        tfa_histogram_clear(all[k]);
    set_tally(t, none);
}

/* ---- sums ---- */

static void add_all(uint64_t *sum, const uint64_t *more, int count)
{
    for (int i = 0; i < count; i++)
        sum[i] += more[i];
}

static void add_tally(tfa_tally *t, const tfa_tally *more)
{
    /* counters from `requests` to before `largest_estimate` are one array */
    const size_t counters = offsetof(tfa_tally, largest_estimate) / sizeof(uint64_t);
    add_all(&t->requests, &more->requests, (int)counters);
    add_all(t->estimate_decades, more->estimate_decades, TFA_STATISTICS_DECADES);
    if (more->largest_estimate > t->largest_estimate)
        t->largest_estimate = more->largest_estimate;
    (void)!tfa_histogram_merge(&t->queue, &more->queue);
    (void)!tfa_histogram_merge(&t->compute, &more->compute);
    (void)!tfa_histogram_merge(&t->total, &more->total);
}

/* ---- workers and their clients ---- */

/* Most robots have none. */
static bool read_departed(const tfa_shared_tally *from, tfa_tally *t)
{
    if (relaxed(&from->version))
        return read_tally(from, t);
    clear_tally(t);
    return true;
}

/* The clients of a worker and the departed ones: one attempt. `departed` is added up later.
 * @return false: a client came or left meanwhile */
static bool read_attachments(const tfa_statistics *s, uint32_t worker, tfa_snapshot *snapshot)
{
    const tfa_shared_worker *w = &s->view.workers[worker];
    const tfa_shared_client *clients = &s->view.clients[(size_t)worker * s->clients];
    const uint64_t began = tfa_record_version(&w->version);
    const uint64_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* T2 */
    for (uint32_t i = 0; i < s->clients && i < used; i++) {
        tfa_client_statistics *c = &snapshot->clients[snapshot->client_count];
        uint64_t words[TFA_WORDS_OF(tfa_served_client)];
        for (size_t k = 0; k < TFA_WORDS_OF(tfa_served_client); k++)
            words[k] = atomic_load_explicit(&clients[i].served[k], memory_order_acquire); /* T2 */
        memcpy(&c->served, words, sizeof c->served);
        if (c->served.kind == TFA_CLIENT_NONE || c->served.robot >= s->robots)
            continue;
        c->slot = i;
        c->queued = (uint32_t)relaxed(&clients[i].queued);
        if (!read_tally(&clients[i].tally, &c->tally))
            return false;
        snapshot->client_count++;
    }
    for (uint32_t i = 0; i < s->robots; i++)
        /* the total is made later: here it holds this worker's part */
        if (!read_departed(&s->view.departed[(size_t)worker * s->robots + i],
                           &snapshot->robots[i].total))
            return false;
    return tfa_record_is_valid(&w->version, began) && began % 2 == 0;
}

static bool read_worker(const tfa_statistics *s, uint32_t worker, tfa_snapshot *snapshot)
{
    const uint32_t before = snapshot->client_count;
    for (int i = 0; i < ATTACHMENT_TRIES; i++) {
        snapshot->client_count = before;
        if (read_attachments(s, worker, snapshot)) {
            for (uint32_t k = 0; k < s->robots; k++)
                add_tally(&snapshot->robots[k].departed, &snapshot->robots[k].total);
            return true;
        }
    }
    return false;
}

/* ---- robots ---- */

static void read_last_state(const tfa_statistics *s, uint32_t robot, tfa_robot_state *state)
{
    const uint32_t sources = s->workers + TFA_GATEWAY_SOURCES;
    const tfa_shared_state *newest = NULL;
    uint64_t time = 0;
    for (uint32_t i = 0; i < sources; i++) {
        const tfa_shared_state *from = &s->view.states[(size_t)i * s->robots + robot];
        if (relaxed(&from->words[0]) > time) {
            time = relaxed(&from->words[0]);
            newest = from;
        }
    }
    if (!newest || !tfa_record_read(&newest->version, newest->words, state, sizeof *state) ||
        state->q_count > TFA_STATISTICS_Q_MAX)
        memset(state, 0, sizeof *state);
}

/* The requests that a gateway answers itself, as a client. */
static bool read_gateway(const tfa_statistics *s, uint32_t robot, uint32_t source,
                         tfa_snapshot *snapshot)
{
    tfa_client_statistics *c = &snapshot->clients[snapshot->client_count];
    c->served =
        (tfa_served_client){.kind = source == TFA_SOURCE_DDS ? TFA_CLIENT_DDS : TFA_CLIENT_ROS2,
                            .robot = robot,
                            .worker = -1,
                            .process = snapshot->process,
                            .since = snapshot->start};
    c->queued = 0;
    c->slot = source;
    snapshot->client_count++;
    return read_tally(&s->view.robots[robot].gateway[source], &c->tally);
}

#define TERMINATE(text) ((text)[sizeof(text) - 1] = 0)

/* Whatever the segment holds, texts end and counts are within their bounds. */
static void bound_robot(tfa_robot_statistics *r)
{
    TERMINATE(r->served.name);
    TERMINATE(r->served.model_hash);
    TERMINATE(r->served.kernel_isa);
    TERMINATE(r->served.kernel_file);
    TERMINATE(r->served.precision);
    TERMINATE(r->served.ros2_namespace);
    TERMINATE(r->served.ros2_node);
    TERMINATE(r->ros2.refusal);
    if (r->ros2.input_count > TFA_STATISTICS_INPUTS_MAX)
        r->ros2.input_count = 0;
    for (uint32_t i = 0; i < r->ros2.input_count; i++)
        TERMINATE(r->ros2.inputs[i].name);
}

static bool read_robot(const tfa_statistics *s, uint32_t robot, tfa_snapshot *snapshot)
{
    const tfa_shared_robot *from = &s->view.robots[robot];
    tfa_robot_statistics *r = &snapshot->robots[robot];
    if (!tfa_record_read(&from->served.version, from->served.words, &r->served, sizeof r->served) ||
        !tfa_record_read(&from->ros2.version, from->ros2.words, &r->ros2, sizeof r->ros2))
        return false;
    bound_robot(r);
    r->dds_request = relaxed(&from->dds_request);
    r->dds_torques = relaxed(&from->dds_torques);
    r->clients = r->queued = 0;
    clear_tally(&r->departed);
    read_last_state(s, robot, &r->state);
    if (r->served.dds && !read_gateway(s, robot, TFA_SOURCE_DDS, snapshot))
        return false;
    return !r->served.ros2_node[0] || read_gateway(s, robot, TFA_SOURCE_ROS2, snapshot);
}

static void add_clients(tfa_snapshot *snapshot)
{
    for (uint32_t i = 0; i < snapshot->robot_count; i++) {
        clear_tally(&snapshot->robots[i].total);
        add_tally(&snapshot->robots[i].total, &snapshot->robots[i].departed);
    }
    for (uint32_t i = 0; i < snapshot->client_count; i++) {
        const tfa_client_statistics *c = &snapshot->clients[i];
        tfa_robot_statistics *r = &snapshot->robots[c->served.robot];
        if (c->served.kind == TFA_CLIENT_SELF)
            continue;
        add_tally(&r->total, &c->tally);
        r->clients += c->served.kind == TFA_CLIENT_SHM;
        r->queued += c->queued;
    }
}

/* ---- the whole ---- */

static void read_dds(const tfa_shared_dds *from, tfa_dds_statistics *to)
{
    const tfa_counter *const words[] = {&from->requests,
                                        &from->torques,
                                        &from->replies,
                                        &from->rejected,
                                        &from->late,
                                        &from->unknown,
                                        &from->dropped,
                                        &from->handovers,
                                        &from->standby,
                                        &from->request_writers,
                                        &from->reply_readers,
                                        &from->torque_writers,
                                        &from->acceleration_readers};
    uint64_t values[sizeof words / sizeof *words];
    _Static_assert(sizeof values == sizeof *to, "one word for each counter");
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        values[i] = relaxed(words[i]);
    memcpy(to, values, sizeof *to);
}

static void read_daemon(const tfa_statistics *s, tfa_snapshot *snapshot)
{
    const tfa_shared_header *h = s->view.header;
    snapshot->time = tfa_clock_ns();
    snapshot->start = h->start;
    snapshot->process = h->process;
    memcpy(snapshot->version, h->version, sizeof h->version);
    snapshot->version[sizeof h->version] = 0;
    memcpy(snapshot->runtime_dir, h->runtime_dir, sizeof h->runtime_dir);
    snapshot->runtime_dir[sizeof h->runtime_dir] = 0;
    snapshot->dds_on = h->dds;
    snapshot->connections = relaxed(&h->connections);
    snapshot->refused = relaxed(&h->refused);
    snapshot->reloads = relaxed(&h->reloads);
    snapshot->stopped = (uint32_t)relaxed(&h->stopped);
    snapshot->heartbeat = 0;
    for (uint32_t i = 0; i < s->workers; i++)
        snapshot->heartbeat += relaxed(&s->view.workers[i].heartbeat);
    read_dds(&h->dds_messages, &snapshot->dds);
    snapshot->worker_count = s->workers;
    snapshot->robot_count = s->robots;
    snapshot->client_count = 0;
}

int tfa_statistics_read(const tfa_statistics *s, tfa_snapshot *snapshot)
{
    const snapshot_memory *room = (const snapshot_memory *)(const void *)snapshot;
    if (room->robots < s->robots ||
        room->clients < s->workers * s->clients + TFA_GATEWAY_SOURCES * s->robots)
        return TFA_E_SIZE;
    read_daemon(s, snapshot);
    for (uint32_t i = 0; i < s->robots; i++)
        if (!read_robot(s, i, snapshot))
            return TFA_E_BUSY;
    for (uint32_t i = 0; i < s->workers; i++)
        if (!read_worker(s, i, snapshot))
            return TFA_E_BUSY;
    add_clients(snapshot);
    return TFA_OK;
}
