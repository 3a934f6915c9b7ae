/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The tap between workers and a recorder (tap.h), and its way into a worker (robot_taps.h), under
 * test.
 */
#include "subject.h"
#include "tap_sides.h"

/* name, bytes of a ring, of the records, producers and looks of the recorder */
#define ONE(looks_) .looks = (looks_), .producers = 1
#define TWO(looks_) .looks = (looks_), .producers = 2

/* clang-format off */
static const tap_case cases[] = {
    {"one lap, 2 records", 128, {40, 40}, ONE(2)},
    {"filler of 8, full ring, 5 records", 128, {40, 40, 40, 40, 40}, ONE(3)},
    {"filler of 24, full ring, 5 records", 64, {40, 40, 40, 40, 40}, ONE(4)},
    {"no filler, full ring, 6 records", 64, {32, 32, 32, 32, 32, 32}, ONE(4)},
    {"larger than half a ring, 6 records", 64, {32, 56, 56, 56, 32, 56}, ONE(4)},
    {"larger than half a ring, 5 records", 128, {40, 96, 96, 40, 96}, ONE(4)},
    {"larger than the ring, 4 records", 64, {32, 72, 32, 32}, ONE(3)},
    {"two producers, 3 records each", 64, {40, 32, 32}, TWO(2)},
    {"recorder killed at each step, 5 records", 64, {40, 32, 40, 32, 56}, ONE(3), .killed = true},
    {"two producers, killed at each step", 64, {40, 40}, TWO(2), .killed = true},
    {"recorder lies, 3 records", 64, {40, 40, 40}, ONE(2), .lies = true},
    {"taken away, 3 requests", 64, {32, 40, 32}, ONE(2), .leaves = true},
    {"taken away, reload, 3 requests", 64, {32, 32, 32}, ONE(2), .leaves = true, .reload = true},
    {"taken away, another one, 3", 64, {32, 32, 40}, ONE(1), .leaves = true, .again = true},
    {"all sizes, 8 records", 128, {40, 56, 32, 64, 40, 48, 32, 128}, ONE(3)},
};
/* clang-format on */
#define CASES (int)(sizeof cases / sizeof *cases)

static const char *name_of(int number)
{
    return cases[number].name;
}

static explorer_result explore_once(const tap_case *c)
{
    explorer_program program = {.name = c->name,
                                .reset = tap_reset,
                                .finish = tap_finish,
                                .body = {tap_producer_body, tap_recorder_body}};
    if (c->producers == 2)
        program.body[2] = tap_second_producer_body;
    if (c->leaves) {
        program.body[0] = tap_worker_body;
        program.body[2] = tap_control_body;
    }
    if (c->again)
        program.body[3] = tap_second_recorder_body;
    return explorer_run(&program);
}

/* A recorder that is killed: at its first step, at its second ... until it has ended before. */
static explorer_result explore(int number)
{
    explorer_result sum = {0};
    tap_under_test = cases[number];
    tap_dies_at = 0;
    do {
        tap_died = false;
        tap_dies_at += tap_under_test.killed;
        const explorer_result r = explore_once(&tap_under_test);
        sum.finding = r.finding;
        sum.executions += r.executions;
        sum.states += r.states;
        sum.branches += r.branches;
        sum.seconds += r.seconds;
    } while (tap_died && !sum.finding);
    return sum;
}

static const subject_label labels[] = {
    {"tfa_tap_has_room", SITE_LOAD, "T2"},
    {"tfa_tap_drop", SITE_STORE, "T3"},
    {"tfa_tap_publish_position", SITE_STORE, "T1"},
    {"tfa_tap_look", SITE_LOAD, "T1"},
    {"tfa_tap_release", SITE_STORE, "T2"},
    {"tfa_tap_dropped", SITE_LOAD, "T3"},
    {"tfa_robot_taps_get", SITE_LOAD, "R14"},
    {"tfa_robot_taps_take", SITE_LOAD, "R15"}, /* and its own word */
    {"tfa_robot_taps_take", SITE_STORE, "A16"},
    {"tfa_robot_taps_set", SITE_STORE, "A14"},
    {"tfa_robot_taps_set", SITE_EXCHANGE, "A15"},
    {"tfa_robot_taps_are_taken", SITE_LOAD, "R16"}, /* and its own word */
    {"accept_offer", SITE_LOAD, "R12"},
    {"offer_solvers", SITE_STORE, "A12"},
    {"end_worker", SITE_STORE, "A10"},
    {"worker_has_ended", SITE_LOAD, "R10"},
    {"lie", SITE_STORE, NULL},
    {"hang_up", SITE_STORE, NULL},
    {"wait_for_hang_up", SITE_LOAD, NULL},
    {NULL, 0, NULL},
};

static void make_error(int error)
{
    tap_error_made = (tap_error)error;
}

static const char *error_text(int error)
{
    return tap_error_text((tap_error)error);
}

const subject tap_subject = {
    .name = "tap",
    .files = {"tap.h", "robot_taps.h", "tap_exchange.c"},
    .labels = labels,
    .scenarios = CASES,
    .scenario_name = name_of,
    .explore = explore,
    .errors = TAP_ERRORS,
    .make_error = make_error,
    .error_text = error_text,
};
