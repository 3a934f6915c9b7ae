/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ring between a client and a worker (ring.h), under test.
 */
#include "ring_sides.h"
#include "subject.h"

/* name, slots, requests, outstanding, then the polls before a side sleeps */
#define SPIN .spin = true
#define CLIENT(polls) .client_sleeps = true, .client_polls = (polls)
#define WORKER(polls) .worker_sleeps = true, .worker_polls = (polls)

/* clang-format off */
static const ring_case cases[] = {
    {"spin, 1 slot, 4 requests", 1, 4, 1, SPIN},
    {"spin, 2 slots, full ring, 4 requests", 2, 4, 2, SPIN},
    {"spin, 4 slots, full ring, 6 requests", 4, 6, 4, SPIN},
    {"worker sleeps, 1 slot, 3 requests", 1, 3, 1, WORKER(0)},
    {"worker sleeps, 2 slots, full ring, 3", 2, 3, 2, WORKER(0)},
    {"worker polls, then sleeps, 1 slot, 2", 1, 2, 1, WORKER(1)},
    {"client sleeps, 1 slot, 3 requests", 1, 3, 1, CLIENT(0)},
    {"client sleeps, 2 slots, full ring, 3", 2, 3, 2, CLIENT(0)},
    {"client polls, then sleeps, 1 slot, 2", 1, 2, 1, CLIENT(1)},
    {"client sleeps for its newest request, 2, 3", 2, 3, 2, CLIENT(0), .waits_for_last = true},
    {"both sleep, 1 slot, 2 requests", 1, 2, 1, CLIENT(0), WORKER(0)},
    {"both sleep, 2 slots, 2 requests", 2, 2, 2, CLIENT(0), WORKER(0)},
    {"both sleep, interrupted, 1 slot, 2", 1, 2, 1, CLIENT(0), WORKER(0), .interruptions = 1},
    {"worker sleeps, 2, full, 3, weak S", 2, 3, 2, WORKER(0), .weak_sc = true},
    {"client sleeps, 2, full, 3, weak S", 2, 3, 2, CLIENT(0), .weak_sc = true},
    {"both sleep, 2, full, 3, weak S", 2, 3, 2, CLIENT(0), WORKER(0), .weak_sc = true},
    {"both sleep, 2 slots, full ring, 3", 2, 3, 2, CLIENT(0), WORKER(0)},
    {"client sleeps, 2 slots, full ring, 4", 2, 4, 2, CLIENT(0)},
    {"worker sleeps, 2 slots, full ring, 4", 2, 4, 2, WORKER(0)},
    {"both sleep, 1 slot, 3 requests", 1, 3, 1, CLIENT(0), WORKER(0)},
};
/* clang-format on */
#define CASES (int)(sizeof cases / sizeof *cases)

static explorer_result explore(int number)
{
    const ring_case *c = &cases[number];
    const explorer_program program = {.name = c->name,
                                      .reset = ring_reset,
                                      .body = {ring_client_body, ring_worker_body},
                                      .interruptions = c->interruptions,
                                      .weak_sc = c->weak_sc};
    ring_under_test = *c;
    return explorer_run(&program);
}

static const char *name_of(int number)
{
    return cases[number].name;
}

static const subject_label labels[] = {
    {"tfa_ring_send", SITE_STORE, "A1"},
    {"tfa_ring_send", SITE_LOAD, "R3"},
    {"tfa_ring_reply_ready", SITE_LOAD, "R2"},
    {"tfa_ring_client_prepare_wait", SITE_STORE, "A4"},
    {"tfa_ring_client_prepare_wait", SITE_LOAD, "R2"},
    {"tfa_ring_client_end_wait", SITE_STORE, "A4"},
    {"tfa_ring_poll", SITE_LOAD, "R1"},
    {"tfa_ring_poll_last", SITE_LOAD, "R1"},
    {"tfa_ring_publish", SITE_STORE, "A2"},
    {"tfa_ring_publish", SITE_LOAD, "R4"},
    {"sleep_for", SITE_LOAD, "R2"},   /* local clients */
    {"set_asleep", SITE_STORE, "A3"}, /* show_asleep of worker.c */
    {"clear_asleep", SITE_STORE, "A3"},
    {NULL, 0, NULL},
};

static const subject_harmless harmless[] = {
    {"clear_asleep", SITE_STORE, memory_order_relaxed,
     "a flag that stays set costs one needless wake-up"},
    {NULL, 0, 0, NULL},
};

static void make_error(int error)
{
    ring_error_made = (ring_error)error;
}

static const char *error_text(int error)
{
    return ring_error_text((ring_error)error);
}

const subject ring_subject = {.name = "ring",
                              .files = {"ring.h", "ring_sides.c"},
                              .labels = labels,
                              .harmless = harmless,
                              .scenarios = CASES,
                              .scenario_name = name_of,
                              .explore = explore,
                              .errors = RING_ERRORS,
                              .make_error = make_error,
                              .error_text = error_text};
