/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lost, late, repeated, reordered and refused replies in the measuring loops: the counters are the
 * script's. A connection that ends; a responder that is gone.
 */
#include "latency_figures.h"
#include "test.h"

enum { COUNT = 20000, SLOTS = 16 };

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
    script_line *lines = script_delays(COUNT);
    uint64_t seed = 11;
    for (uint64_t i = 0; i < COUNT - 1000; i++) {
        const uint64_t fate = script_draw(&seed, 200);
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
    tally *t = script_measure(&s, &shape);
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
    tally *t = script_measure(&s, &closed);
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
    s.hang_ups = 50;
    tally *t = script_measure(&s, &shape);
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
