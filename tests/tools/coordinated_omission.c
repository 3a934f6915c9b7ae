/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coordinated omission: a stall of the responder is in the percentiles of an open loop and hidden
 * from those of a closed one. In virtual time against a queue, with exact figures; in real time
 * against a process that is stopped when the run begins, and goes on when it likes.
 */
#include "latency/transports/open.h"

#include "latency_figures.h"
#include "support/wait.h"
#include "test.h"

#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- a queue, virtual time ---- */

/* Each request is served in 50 us, and nothing from 5 s to 5.1 s: 10 s at 1 kHz. */
enum { REQUESTS = 10000, STALLED = 5000, SLOTS = 16 };
#define SERVICE (50 * US)
#define STALL (100 * MS)

static void make_queue(script *s, script_line *line, uint32_t slots)
{
    *line = (script_line){.delay = SERVICE};
    script_init(s, line, 1, slots);
    s->queue = 1;
    s->stall = (script_stall){s->now + STALLED * MS, s->now + STALLED * MS + STALL};
}

/* Round trips by the rule of a queue: done = max(due, done before, end of the stall) + service. */
static uint64_t *queue_times(uint64_t *full, uint32_t slots)
{
    uint64_t *trips = calloc(REQUESTS, sizeof *trips), *done = calloc(REQUESTS, sizeof *done);
    assert_non_null(trips);
    assert_non_null(done);
    *full = 0;
    for (uint64_t i = 0; i < REQUESTS; i++) {
        const uint64_t due = i * MS;
        uint64_t start = i && done[i - 1] > due ? done[i - 1] : due;
        if (start >= STALLED * MS && start < STALLED * MS + STALL)
            start = STALLED * MS + STALL;
        done[i] = start + SERVICE;
        trips[i] = done[i] - due;
        *full += i >= slots && done[i - slots] > due;
    }
    free(done);
    return trips;
}

TEST(test_coordinated_omission)
{
    script s;
    script_line line;
    uint64_t full = 0;
    uint64_t *trips = queue_times(&full, SLOTS);
    load_shape shape = {.open = 1, .rate = 1000, .count = REQUESTS, .timeout_ns = SECOND};

    /* open: each request that should have been sent in the stall waits for its end */
    make_queue(&s, &line, SLOTS);
    tally *t = script_measure(&s, &shape);
    assert_times(&t->parts[PART_ROUND_TRIP].h, trips, REQUESTS);
    assert_int_equal(t->slowest.index, STALLED);
    assert_int_equal(t->full, full);
    assert_true(full > 80 && full < 110);
    const uint64_t open_p99 = tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, 0.99);
    const uint64_t open_p999 = tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, 0.999);
    /* what waits for room waits in the client */
    assert_true(t->parts[PART_CLIENT].h.highest > 80 * MS);
    assert_true(open_p99 > 4 * MS && open_p999 > 90 * MS);
    tally_free(t);
    script_free(&s);

    /* closed: one round trip is slow, the stall hides all others */
    make_queue(&s, &line, SLOTS);
    shape.open = 0;
    t = script_measure(&s, &shape);
    for (uint64_t i = 0; i < REQUESTS; i++)
        trips[i] = i == STALLED ? STALL + SERVICE : SERVICE;
    assert_times(&t->parts[PART_ROUND_TRIP].h, trips, REQUESTS);
    assert_int_equal(tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, 0.999) / US,
                     SERVICE / US);
    assert_int_equal(t->full, 0);
    tally_free(t);
    script_free(&s);
    free(trips);
}

/* ---- a process, real time ---- */

enum { TRIPS = 300, STOPPED_MS = 60 };

static pid_t only_child(void)
{
    int child = 0;
    FILE *file = fopen("/proc/thread-self/children", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%d", &child), 1);
    fclose(file);
    return child;
}

typedef struct stop {
    pid_t child;
    uint64_t start, end; /* of the run; before the child goes on */
} stop;

static void *go_on_later(void *arg)
{
    stop *s = arg;
    sleep_ms(STOPPED_MS); /* of the run: however long it is, the figures are judged by its end */
    s->end = clock_ns();
    kill(s->child, SIGCONT);
    return NULL;
}

/* Requests at 1 kHz, the first while the echo stands still. */
static tally *run_real(int open, stop *s)
{
    const latency_options options = {.batch = 1, .known = {.q_count = 7, .v_count = 7}};
    latency_states states = {0};
    transport_facts facts = {0};
    transport *t = NULL;
    pthread_t thread;
    load_shape shape = {.open = open, .rate = 1000, .count = TRIPS, .timeout_ns = WAIT_NS};
    siginfo_t info;
    assert_int_equal(transport_socket_open(&options, &states, &t, &facts), TFA_OK);
    s->child = only_child();
    loop *l = loop_create(t, 32768);
    tally *figures = tally_create(shape.count);
    assert_int_equal(kill(s->child, SIGSTOP), 0);
    assert_int_equal(waitid(P_PID, (id_t)s->child, &info, WSTOPPED), 0);
    s->start = clock_ns();
    assert_int_equal(pthread_create(&thread, NULL, go_on_later, s), 0);
    assert_int_equal(loop_run(l, &shape, s->start, figures), TFA_OK);
    pthread_join(thread, NULL);
    loop_free(l);
    t->ops->close(t);
    return figures;
}

/* Round trips that begin while the echo stands still; each ends after that. */
static uint64_t waited(const tally *t, const stop *s)
{
    uint64_t count = 0;
    for (uint64_t i = 0; i < t->sample_count; i++) {
        const latency_sample *sample = &t->samples[i];
        if (s->start + sample->at >= s->end)
            continue;
        assert_true(s->start + sample->at + sample->parts[PART_ROUND_TRIP] >= s->end);
        count++;
    }
    return count;
}

TEST(test_process_that_stands_still)
{
    if (access("/proc/thread-self/children", R_OK) != 0)
        skip();
    stop while_open, while_closed;
    tally *open = run_real(1, &while_open), *closed = run_real(0, &while_closed);
    assert_int_equal(open->lost + open->rejected + open->duplicates + open->reordered, 0);
    assert_int_equal(open->sample_count, TRIPS);
    assert_int_equal(closed->sample_count, TRIPS);
    /* open: a request for each millisecond of the stop sees it; closed: one */
    const uint64_t due = (while_open.end - while_open.start + MS - 1) / MS;
    assert_int_equal(waited(open, &while_open), due < TRIPS ? due : TRIPS);
    assert_true(due >= STOPPED_MS);
    assert_in_range(waited(closed, &while_closed), 0, 1);
    tally_free(open);
    tally_free(closed);
}
