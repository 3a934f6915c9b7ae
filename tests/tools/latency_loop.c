/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The measuring loops against a scripted responder: closed and open, with pauses, jitter, bursts
 * and a duration; tallies of two runs merged. Every figure equals the script's.
 */
#include "latency_figures.h"
#include "test.h"

enum { COUNT = 20000, SLOTS = 16 };

TEST(test_closed)
{
    script s;
    script_line *lines = script_delays(COUNT);
    const uint64_t slowest = script_slowest(lines, COUNT);
    const load_shape shape = {.count = COUNT, .timeout_ns = SECOND};
    uint64_t at = 0;
    script_init(&s, lines, COUNT, SLOTS);
    tally *t = script_measure(&s, &shape);
    assert_parts(t, lines, COUNT);
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
    script_line *lines = script_delays(COUNT);
    const load_shape think = {.count = 1000, .timeout_ns = SECOND, .think_ns = 30 * US};
    const load_shape paced = {.count = 1000, .timeout_ns = SECOND, .rate = 100};
    uint64_t sum = 0;
    for (int i = 0; i < 1000; i++)
        sum += lines[i].delay;
    script_init(&s, lines, COUNT, SLOTS);
    tally *t = script_measure(&s, &think);
    assert_int_equal(t->elapsed_ns, sum + 999 * 30 * US);
    tally_free(t);
    t = script_measure(&s, &paced);
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
    script_line *lines = script_delays(COUNT);
    const load_shape shape = {
        .open = 1, .rate = 10000, .count = COUNT, .timeout_ns = SECOND, .offset_ns = 7 * US};
    script_init(&s, lines, COUNT, 1024);
    tally *t = script_measure(&s, &shape);
    assert_parts(t, lines, COUNT);
    assert_int_equal(t->slowest.index, script_slowest(lines, COUNT));
    assert_int_equal(t->slowest.at, 7 * US + script_slowest(lines, COUNT) * 100 * US);
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
    tally *t = script_measure(&s, &shape);
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

TEST(test_duration)
{
    script s;
    script_line line = {.delay = 100 * US};
    load_shape shape = {.duration_ns = 10 * MS, .timeout_ns = SECOND};
    script_init(&s, &line, 1, SLOTS);
    tally *t = script_measure(&s, &shape);
    assert_int_equal(t->sent, 100);
    tally_free(t);
    shape = (load_shape){.open = 1, .rate = 2000, .duration_ns = 10 * MS, .timeout_ns = SECOND};
    t = script_measure(&s, &shape);
    assert_int_equal(t->sent, 20);
    shape.count = 5;
    assert_int_equal(load_count(&shape), 5);
    tally_free(t);
    script_free(&s);
}

TEST(test_merge)
{
    script s;
    script_line *lines = script_delays(COUNT);
    const load_shape shape = {.count = COUNT / 2, .timeout_ns = SECOND, .deadline_ns = MS};
    uint64_t *values = calloc(COUNT, sizeof *values);
    tally *all = tally_create(0);
    script_init(&s, lines, COUNT / 2, SLOTS);
    tally *a = script_measure(&s, &shape);
    s.lines = lines + COUNT / 2;
    tally *b = script_measure(&s, &shape);
    tally_merge(all, a);
    tally_merge(all, b);
    for (uint64_t i = 0; i < COUNT; i++)
        values[i] = lines[i].delay;
    assert_times(&all->parts[PART_ROUND_TRIP].h, values, COUNT);
    assert_int_equal(all->late, a->late + b->late);
    assert_int_equal(all->slowest.parts[0], lines[script_slowest(lines, COUNT)].delay);
    assert_int_equal(all->slices[3].h.count, COUNT / TALLY_SLICES);
    tally_free(a);
    tally_free(b);
    tally_free(all);
    script_free(&s);
    free(values);
    free(lines);
}
