/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scenarios: each explored to its end without a finding.
 */
#include <stdio.h>

#include "parts.h"
#include "ring_sides.h"

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

static explorer_result explore(const ring_case *c)
{
    const explorer_program program = {.name = c->name,
                                      .reset = ring_reset,
                                      .body = {ring_client_body, ring_worker_body},
                                      .interruptions = c->interruptions,
                                      .weak_sc = c->weak_sc};
    ring_under_test = *c;
    return explorer_run(&program);
}

int scenarios_run(void)
{
    int failures = 0;
    printf("\n%-44s %11s %11s %11s %8s\n", "scenario", "executions", "branches", "states",
           "seconds");
    for (int k = 0; k < CASES; k++) {
        const explorer_result r = explore(&cases[k]);
        printf("%-44s %11llu %11llu %11llu %8.2f%s%s\n", cases[k].name,
               (unsigned long long)r.executions, (unsigned long long)r.branches,
               (unsigned long long)r.states, r.seconds, r.finding ? "  FOUND: " : "",
               r.finding ? r.finding : "");
        if (r.finding)
            explorer_print_trace();
        failures += r.finding != NULL;
        fflush(stdout);
    }
    return failures;
}

const char *scenarios_find(const char **finding, int *hint)
{
    for (int k = -1; k < CASES; k++) {
        const int at = k < 0 ? *hint : k;
        if (k == *hint)
            continue;
        const explorer_result r = explore(&cases[at]);
        if (r.finding) {
            *finding = r.finding;
            *hint = at;
            return cases[at].name;
        }
    }
    return NULL;
}
