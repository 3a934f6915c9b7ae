/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The measuring loops against a scripted responder whose clock is virtual: every figure equals the
 * script's, computed here from sorted lists, within the histogram's resolution. And one run against
 * a process that is stopped for a while, with loose bounds.
 */
#include "latency/latency.h"

#include "latency_script.h"
#include "test.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#define US UINT64_C(1000)
#define MS UINT64_C(1000000)
#define SECOND UINT64_C(1000000000)

enum { COUNT = 20000, SLOTS = 16 };

/* Numbers of a fixed sequence */
static uint64_t draw(uint64_t *seed, uint64_t below)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (*seed >> 33) % below;
}

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Nearest rank of a list. */
static uint64_t rank(const uint64_t *sorted, uint64_t count, double quantile)
{
    uint64_t k = (uint64_t)ceil(quantile * (double)count);
    return sorted[(k ? k : 1) - 1];
}

/* The histogram holds these values. */
static void check_times(const tfa_histogram *h, const uint64_t *values, uint64_t count)
{
    static const double quantiles[] = {0.5, 0.9, 0.99, 0.999, 0.9999};
    uint64_t *sorted = malloc((count + 1) * sizeof *sorted);
    double sum = 0;
    assert_non_null(sorted);
    memcpy(sorted, values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_value);
    for (uint64_t i = 0; i < count; i++)
        sum += (double)values[i];
    assert_int_equal(h->count, count);
    assert_int_equal(h->lowest, sorted[0]);
    assert_int_equal(h->highest, sorted[count - 1]);
    assert_true(fabs(tfa_histogram_mean(h) - sum / (double)count) <= 1e-9 * sum / (double)count);
    for (size_t i = 0; i < sizeof quantiles / sizeof quantiles[0]; i++) {
        const uint64_t true_value = rank(sorted, count, quantiles[i]);
        const uint64_t found = tfa_histogram_quantile(h, quantiles[i]);
        if (found < true_value || (double)found > (double)true_value * (1 + 1.0 / 128))
            fail_msg("p%g: %lu, the script has %lu", 100 * quantiles[i], (unsigned long)found,
                     (unsigned long)true_value);
    }
    free(sorted);
}

/* Runs a load from the script's present on. */
static tally *run(script *s, const load_shape *shape)
{
    tally *t = tally_create(shape->count);
    loop *l = loop_create(&s->base, loop_window(shape, s->slots));
    assert_non_null(t);
    assert_non_null(l);
    assert_int_equal(loop_run(l, shape, s->now, t), TFA_OK);
    assert_int_equal(t->done, t->sent);
    loop_free(l);
    return t;
}

/* Delays of 1 to 21 us, now and then far more. */
static script_line *delays(uint64_t count)
{
    script_line *lines = calloc(count, sizeof *lines);
    uint64_t seed = 7;
    assert_non_null(lines);
    for (uint64_t i = 0; i < count; i++) {
        lines[i].delay = 1 * US + draw(&seed, 20 * US);
        if (draw(&seed, 400) == 0)
            lines[i].delay += draw(&seed, 3 * MS);
    }
    return lines;
}

/* Rows of the breakdown: every power of two in 32. */
static uint64_t row_of(uint64_t value)
{
    uint64_t octave = 0;
    while (value >> octave >= 64)
        octave++;
    return (octave << 32) + (value >> octave);
}

/* Mean parts of the samples in the row of a percentile. */
static void check_breakdown(const tally *t, double quantile)
{
    const uint64_t value = tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, quantile);
    double means[PART_COUNT], sums[PART_COUNT] = {0};
    uint64_t count = 0;
    for (uint64_t i = 0; i < t->sample_count; i++) {
        const uint64_t *parts = t->samples[i].parts;
        uint64_t sum = 0;
        for (int k = 1; k < PART_COUNT; k++)
            sum += parts[k];
        assert_int_equal(sum, parts[PART_ROUND_TRIP]);
        if (row_of(parts[PART_ROUND_TRIP]) != row_of(value))
            continue;
        count++;
        for (int k = 0; k < PART_COUNT; k++)
            sums[k] += (double)parts[k];
    }
    assert_int_equal(breakdown_at(t->breakdown, value, means), count);
    assert_true(count > 0);
    for (int k = 0; k < PART_COUNT; k++)
        assert_true(fabs(means[k] - sums[k] / (double)count) <= 1e-9 * (means[k] + 1));
    assert_true(fabs(means[PART_ROUND_TRIP] - (double)value) <= (double)value / 32);
}

static void check_parts(const tally *t, const script_line *lines)
{
    uint64_t *values = calloc(COUNT, sizeof *values);
    assert_non_null(values);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = lines[i].delay;
    check_times(&t->parts[PART_ROUND_TRIP].h, values, COUNT);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = lines[i].delay / 10;
    check_times(&t->parts[PART_REQUEST].h, values, COUNT);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = 2 * (lines[i].delay / 10);
    check_times(&t->parts[PART_QUEUE].h, values, COUNT);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = 3 * (lines[i].delay / 10);
    check_times(&t->parts[PART_COMPUTE].h, values, COUNT);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = lines[i].delay - 6 * (lines[i].delay / 10);
    check_times(&t->parts[PART_REPLY].h, values, COUNT);
    assert_int_equal(t->parts[PART_CLIENT].h.highest, 0);
    check_breakdown(t, 0.5);
    check_breakdown(t, 0.9);
    check_breakdown(t, 0.99);
    check_breakdown(t, 0.999);
    free(values);
}

static uint64_t slowest_of(const script_line *lines)
{
    uint64_t slowest = 0;
    for (uint64_t i = 1; i < COUNT; i++)
        if (lines[i].delay > lines[slowest].delay)
            slowest = i;
    return slowest;
}

TEST(test_closed)
{
    script s;
    script_line *lines = delays(COUNT);
    const uint64_t slowest = slowest_of(lines);
    const load_shape shape = {.count = COUNT, .timeout_ns = SECOND};
    uint64_t at = 0;
    script_init(&s, lines, COUNT, SLOTS);
    tally *t = run(&s, &shape);
    check_parts(t, lines);
    for (uint64_t i = 0; i < slowest; i++)
        at += lines[i].delay;
    assert_int_equal(t->slowest.index, slowest);
    assert_int_equal(t->slowest.at, at);
    assert_int_equal(t->lost + t->rejected + t->late + t->longest_run + t->full, 0);
    assert_int_equal(t->elapsed_ns, s.now - SECOND);
    uint64_t in_slices = 0;
    for (int i = 0; i < TALLY_SLICES; i++) {
        assert_int_equal(t->slices[i].h.count, COUNT / TALLY_SLICES);
        in_slices += t->slices[i].h.count;
    }
    assert_int_equal(in_slices, COUNT);
    tally_free(t);
    script_free(&s);
    free(lines);
}

TEST(test_pauses)
{
    script s;
    script_line *lines = delays(COUNT);
    const load_shape think = {.count = 1000, .timeout_ns = SECOND, .think_ns = 30 * US};
    const load_shape paced = {.count = 1000, .timeout_ns = SECOND, .rate = 100};
    uint64_t sum = 0;
    for (int i = 0; i < 1000; i++)
        sum += lines[i].delay;
    script_init(&s, lines, COUNT, SLOTS);
    tally *t = run(&s, &think);
    assert_int_equal(t->elapsed_ns, sum + 999 * 30 * US);
    tally_free(t);
    t = run(&s, &paced);
    assert_int_equal(t->elapsed_ns, 999 * 10 * MS + lines[999].delay);
    assert_int_equal(t->samples[500].at, 500 * 10 * MS);
    tally_free(t);
    script_free(&s);
    free(lines);
}

/* All at once: each round trip is the delay of its line, whatever the others take. */
TEST(test_open)
{
    script s;
    script_line *lines = delays(COUNT);
    const load_shape shape = {
        .open = 1, .rate = 10000, .count = COUNT, .timeout_ns = SECOND, .offset_ns = 7 * US};
    script_init(&s, lines, COUNT, 1024);
    tally *t = run(&s, &shape);
    check_parts(t, lines);
    assert_int_equal(t->slowest.index, slowest_of(lines));
    assert_int_equal(t->slowest.at, 7 * US + slowest_of(lines) * 100 * US);
    assert_true(t->reordered > 0);
    tally_free(t);
    script_free(&s);
    free(lines);
}

TEST(test_jitter_and_bursts)
{
    script s;
    script_line line = {.delay = 5 * US};
    const load_shape shape = {.open = 1,
                              .rate = 1000,
                              .count = 4000,
                              .burst = 4,
                              .jitter_ns = 200 * US,
                              .timeout_ns = SECOND};
    script_init(&s, &line, 1, 64);
    free(s.replies);
    s.replies = calloc(100, sizeof *s.replies);
    tally *t = run(&s, &shape);
    uint64_t earliest = UINT64_MAX, latest = 0;
    for (uint64_t i = 0; i < 4000; i++) {
        const uint64_t tick = i / 4 * 4 * MS, off = t->samples[i].at - tick;
        assert_true(off < 200 * US);
        assert_int_equal(t->samples[i].at, t->samples[i / 4 * 4].at);
        earliest = off < earliest ? off : earliest;
        latest = off > latest ? off : latest;
    }
    assert_true(earliest < 10 * US && latest > 190 * US);
    assert_int_equal(t->parts[PART_ROUND_TRIP].h.highest, 5 * US);
    tally_free(t);
    script_free(&s);
}

/* ---- losses, duplicates, reorderings, refusals ---- */

/* What the counters should say, by order of sending and of arrival */
typedef struct expected {
    uint64_t lost, rejected, late, longest_run, duplicates, stale, reordered, answered;
} expected;

/* One reply */
typedef struct arrival {
    uint64_t at, index;
} arrival;

static int by_time(const void *a, const void *b)
{
    const arrival *x = a, *y = b;
    if (x->at != y->at)
        return x->at < y->at ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

static expected expect(const script_line *lines, uint64_t count, const load_shape *shape)
{
    expected e = {0};
    uint64_t misses = 0, highest = 0, arrived = 0;
    arrival *arrivals = calloc(count, sizeof *arrivals);
    assert_non_null(arrivals);
    for (uint64_t i = 0; i < count; i++) {
        const script_line *line = &lines[i];
        const int lost = line->lost || line->delay >= shape->timeout_ns;
        const int rejected = !lost && line->status != TFA_OK;
        const int late = !lost && !rejected && line->delay > shape->deadline_ns;
        e.lost += (uint64_t)lost;
        e.rejected += (uint64_t)rejected;
        e.late += (uint64_t)late;
        e.stale += !line->lost && lost;
        e.duplicates += !lost && line->repeat != 0;
        e.answered += !lost && !rejected;
        misses = lost || rejected || late ? misses + 1 : 0;
        e.longest_run = misses > e.longest_run ? misses : e.longest_run;
        if (!lost)
            arrivals[arrived++] =
                (arrival){i * SECOND / (uint64_t)shape->rate + line->delay, i + 1};
    }
    qsort(arrivals, arrived, sizeof *arrivals, by_time);
    for (uint64_t i = 0; i < arrived; i++) {
        e.reordered += arrivals[i].index < highest;
        highest = arrivals[i].index > highest ? arrivals[i].index : highest;
    }
    free(arrivals);
    return e;
}

static void check_counters(const tally *t, const expected *e)
{
    assert_int_equal(t->lost, e->lost);
    assert_int_equal(t->rejected, e->rejected);
    assert_int_equal(t->late, e->late);
    assert_int_equal(t->longest_run, e->longest_run);
    assert_int_equal(t->duplicates, e->duplicates);
    assert_int_equal(t->stale, e->stale);
    assert_int_equal(t->parts[PART_ROUND_TRIP].h.count, e->answered);
    assert_int_equal(t->statuses[0].count + t->statuses[1].count, e->rejected);
}

static script_line *troubles(void)
{
    script_line *lines = delays(COUNT);
    uint64_t seed = 11;
    for (uint64_t i = 0; i < COUNT - 1000; i++) {
        const uint64_t fate = draw(&seed, 200);
        lines[i].lost = fate == 0;
        lines[i].repeat = fate == 1 ? 3 * US : 0;
        lines[i].status = fate == 2 ? TFA_E_LATE : fate == 3 ? TFA_E_SIZE : TFA_OK;
        if (fate == 4)
            lines[i].delay = 60 * MS; /* beyond the timeout */
        if (i >= 5000 && i < 5023)
            lines[i].lost = 1;
        if (i >= 7000 && i < 7030) /* the longest run, of all kinds */
            lines[i] = (script_line){
                .delay = 2 * MS, .lost = i % 3 == 0, .status = i % 3 == 1 ? TFA_E_LATE : TFA_OK};
    }
    return lines;
}

TEST(test_troubles_open)
{
    script s;
    script_line *lines = troubles();
    const load_shape shape = {
        .open = 1, .rate = 10000, .count = COUNT, .timeout_ns = 50 * MS, .deadline_ns = 1 * MS};
    const expected e = expect(lines, COUNT, &shape);
    assert_true(e.lost > 50 && e.rejected > 50 && e.late > 10 && e.stale > 50 &&
                e.duplicates > 50 && e.reordered > 20 && e.longest_run >= 30);
    script_init(&s, lines, COUNT, 4096);
    tally *t = run(&s, &shape);
    check_counters(t, &e);
    assert_int_equal(t->reordered, e.reordered);
    for (int i = 0; i < 2; i++)
        assert_true(t->statuses[i].status == TFA_E_LATE || t->statuses[i].status == TFA_E_SIZE);
    tally_free(t);
    script_free(&s);
    free(lines);
}

TEST(test_troubles_closed)
{
    script s;
    script_line *lines = troubles();
    /* the reply to a call that was given up comes in a later one */
    const load_shape shape = {
        .rate = 1, .count = COUNT, .timeout_ns = 50 * MS, .deadline_ns = 1 * MS};
    expected e = expect(lines, COUNT, &shape);
    load_shape closed = shape;
    closed.rate = 0;
    script_init(&s, lines, COUNT, 4096);
    tally *t = run(&s, &closed);
    check_counters(t, &e);
    assert_int_equal(t->reordered, 0);
    tally_free(t);
    script_free(&s);
    free(lines);
}

TEST(test_reconnect)
{
    script s;
    script_line line = {.delay = 2500 * US};
    const load_shape shape = {.open = 1, .rate = 1000, .count = 100, .timeout_ns = SECOND};
    script_init(&s, &line, 1, SLOTS);
    free(s.replies);
    s.replies = calloc(100, sizeof *s.replies);
    s.hang_ups = 50;
    tally *t = run(&s, &shape);
    /* at the time of number 50 those before it that were sent in the last 2.5 ms are under way */
    assert_int_equal(t->lost, 3);
    assert_int_equal(t->reconnects, 1);
    assert_int_equal(s.reconnections, 1);
    assert_int_equal(t->longest_run, 3);
    assert_int_equal(t->parts[PART_ROUND_TRIP].h.count, 97);
    tally_free(t);
    script_free(&s);
}

/* A side that never answers is given up after 100 misses. */
TEST(test_gone)
{
    script s;
    script_line line = {.lost = 1};
    load_shape shape = {.open = 1, .rate = 1000, .count = 100000, .timeout_ns = MS};
    script_init(&s, &line, 1, SLOTS);
    tally *t = tally_create(0);
    loop *l = loop_create(&s.base, 64);
    assert_int_equal(loop_run(l, &shape, s.now, t), TFA_E_TIMEOUT);
    assert_in_range(t->lost, 100, 110);
    assert_int_equal(loop_run(l, &shape, s.now, NULL), TFA_E_TIMEOUT);
    loop_free(l);
    tally_free(t);
    script_free(&s);
}

/* ---- coordinated omission ---- */

/* A queue that serves each request in 50 us and nothing from 5 s to 5.1 s: 10 s at 1 kHz. */
enum { REQUESTS = 10000, STALLED = 5000 };
#define SERVICE (50 * US)
#define STALL (100 * MS)

static void make_queue(script *s, script_line *line, uint32_t slots)
{
    *line = (script_line){.delay = SERVICE};
    script_init(s, line, 1, slots);
    free(s->replies);
    s->replies = calloc(4096, sizeof *s->replies);
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
    tally *t = run(&s, &shape);
    check_times(&t->parts[PART_ROUND_TRIP].h, trips, REQUESTS);
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
    t = run(&s, &shape);
    for (uint64_t i = 0; i < REQUESTS; i++)
        trips[i] = i == STALLED ? STALL + SERVICE : SERVICE;
    check_times(&t->parts[PART_ROUND_TRIP].h, trips, REQUESTS);
    assert_int_equal(tfa_histogram_quantile(&t->parts[PART_ROUND_TRIP].h, 0.999) / US,
                     SERVICE / US);
    assert_int_equal(t->full, 0);
    tally_free(t);
    script_free(&s);
    free(trips);
}

TEST(test_duration)
{
    script s;
    script_line line = {.delay = 100 * US};
    load_shape shape = {.duration_ns = 10 * MS, .timeout_ns = SECOND};
    script_init(&s, &line, 1, SLOTS);
    tally *t = run(&s, &shape);
    assert_int_equal(t->sent, 100);
    tally_free(t);
    shape = (load_shape){.open = 1, .rate = 2000, .duration_ns = 10 * MS, .timeout_ns = SECOND};
    t = run(&s, &shape);
    assert_int_equal(t->sent, 20);
    shape.count = 5;
    assert_int_equal(load_count(&shape), 5);
    tally_free(t);
    script_free(&s);
}

TEST(test_merge)
{
    script s;
    script_line *lines = delays(COUNT);
    const load_shape shape = {.count = COUNT / 2, .timeout_ns = SECOND, .deadline_ns = MS};
    uint64_t *values = calloc(COUNT, sizeof *values);
    tally *all = tally_create(0);
    script_init(&s, lines, COUNT / 2, SLOTS);
    tally *a = run(&s, &shape);
    s.lines = lines + COUNT / 2;
    tally *b = run(&s, &shape);
    tally_merge(all, a);
    tally_merge(all, b);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = lines[i].delay;
    check_times(&all->parts[PART_ROUND_TRIP].h, values, COUNT);
    assert_int_equal(all->late, a->late + b->late);
    assert_int_equal(all->slowest.parts[0], lines[slowest_of(lines)].delay);
    assert_int_equal(all->slices[3].h.count, COUNT / TALLY_SLICES);
    tally_free(a);
    tally_free(b);
    tally_free(all);
    script_free(&s);
    free(values);
    free(lines);
}

/* ---- a process, real time ---- */

static const uint64_t stopped_ns = 60 * MS;

static pid_t only_child(void)
{
    int child = 0;
    FILE *file = fopen("/proc/thread-self/children", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%d", &child), 1);
    fclose(file);
    return child;
}

static void *stop_for_a_while(void *arg)
{
    const pid_t child = *(const pid_t *)arg;
    usleep(50000);
    kill(child, SIGSTOP);
    usleep((useconds_t)(stopped_ns / 1000));
    kill(child, SIGCONT);
    return NULL;
}

/* 0.3 s at 1 kHz while the echo stands still for 60 ms. */
static tally *run_real(int open)
{
    const latency_options options = {.batch = 1, .known = {.q_count = 7, .v_count = 7}};
    latency_states states = {0};
    transport_facts facts = {0};
    transport *t = NULL;
    pthread_t stopper;
    load_shape shape = {.open = open, .rate = 1000, .count = 300, .timeout_ns = 20 * SECOND};
    assert_int_equal(transport_socket_open(&options, &states, &t, &facts), TFA_OK);
    pid_t child = only_child();
    loop *l = loop_create(t, 32768);
    tally *figures = tally_create(shape.count);
    assert_int_equal(pthread_create(&stopper, NULL, stop_for_a_while, &child), 0);
    assert_int_equal(loop_run(l, &shape, clock_ns(), figures), TFA_OK);
    pthread_join(stopper, NULL);
    loop_free(l);
    t->ops->close(t);
    return figures;
}

static uint64_t above(const tally *t, uint64_t limit)
{
    uint64_t count = 0;
    for (uint64_t i = 0; i < t->sample_count; i++)
        count += t->samples[i].parts[PART_ROUND_TRIP] > limit;
    return count;
}

TEST(test_process_that_stands_still)
{
    if (access("/proc/thread-self/children", R_OK) != 0)
        skip();
    tally *open = run_real(1), *closed = run_real(0);
    assert_int_equal(open->lost + open->rejected + open->duplicates + open->reordered, 0);
    assert_int_equal(open->sample_count, 300);
    assert_int_equal(closed->sample_count, 300);
    /* the stop is seen by both; open by a request each millisecond of it, closed by one */
    assert_true(open->slowest.parts[0] >= stopped_ns / 2);
    assert_true(closed->slowest.parts[0] >= stopped_ns / 2);
    assert_true(above(open, stopped_ns / 4) >= 20);
    assert_true(above(closed, stopped_ns / 4) < above(open, stopped_ns / 4));
    tally_free(open);
    tally_free(closed);
}
