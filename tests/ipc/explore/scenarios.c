/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scenarios: each explored to its end without a finding.
 */
#include <stdio.h>

#include "parts.h"
#include "ring_sides.h"

/* One client, one worker */
static const ring_case cases[] = {
    {.name = "spin, 1 slot", .slots = 1, .requests = 4, .outstanding = 1, .spin = true},
    {.name = "spin, 2 slots, full ring", .slots = 2, .requests = 4, .outstanding = 2, .spin = true},
    {.name = "spin, 4 slots, full ring", .slots = 4, .requests = 6, .outstanding = 4, .spin = true},
    {.name = "worker sleeps, 1 slot",
     .slots = 1,
     .requests = 3,
     .outstanding = 1,
     .worker_sleeps = true},
    {.name = "worker sleeps, 2 slots, full ring",
     .slots = 2,
     .requests = 3,
     .outstanding = 2,
     .worker_sleeps = true},
    {.name = "worker sleeps, 2 slots, full ring, 4",
     .slots = 2,
     .requests = 4,
     .outstanding = 2,
     .worker_sleeps = true},
    {.name = "worker polls twice, then sleeps, 1 slot",
     .slots = 1,
     .requests = 2,
     .outstanding = 1,
     .worker_sleeps = true,
     .worker_polls = 1},
    {.name = "client sleeps, 1 slot",
     .slots = 1,
     .requests = 3,
     .outstanding = 1,
     .client_sleeps = true},
    {.name = "client sleeps, 2 slots, full ring",
     .slots = 2,
     .requests = 3,
     .outstanding = 2,
     .client_sleeps = true},
    {.name = "client sleeps, 2 slots, full ring 4",
     .slots = 2,
     .requests = 4,
     .outstanding = 2,
     .client_sleeps = true},
    {.name = "client polls twice, then sleeps, 1 slot",
     .slots = 1,
     .requests = 2,
     .outstanding = 1,
     .client_sleeps = true,
     .client_polls = 1},
    {.name = "client sleeps for the last reply, 2 slots",
     .slots = 2,
     .requests = 3,
     .outstanding = 2,
     .client_sleeps = true,
     .waits_for_last = true},
    {.name = "both sleep, 1 slot",
     .slots = 1,
     .requests = 2,
     .outstanding = 1,
     .client_sleeps = true,
     .worker_sleeps = true},
    {.name = "both sleep, 1 slot, 3",
     .slots = 1,
     .requests = 3,
     .outstanding = 1,
     .client_sleeps = true,
     .worker_sleeps = true},
    {.name = "both sleep, 2 slots",
     .slots = 2,
     .requests = 2,
     .outstanding = 2,
     .client_sleeps = true,
     .worker_sleeps = true},
    {.name = "both sleep, 2 slots, full ring",
     .slots = 2,
     .requests = 3,
     .outstanding = 2,
     .client_sleeps = true,
     .worker_sleeps = true},
    {.name = "both interrupted, 1 slot",
     .slots = 1,
     .requests = 2,
     .outstanding = 1,
     .client_sleeps = true,
     .worker_sleeps = true,
     .interruptions = 1},
};
#define CASES (int)(sizeof cases / sizeof *cases)

static explorer_result explore(const ring_case *c)
{
    const explorer_program program = {.name = c->name,
                                      .reset = ring_reset,
                                      .body = {ring_client_body, ring_worker_body},
                                      .interruptions = c->interruptions};
    ring_under_test = *c;
    return explorer_run(&program);
}

int scenarios_run(void)
{
    int failures = 0;
    printf("\n%-44s %11s %11s %8s\n", "scenario", "executions", "states", "seconds");
    for (int k = 0; k < CASES; k++) {
        const explorer_result r = explore(&cases[k]);
        printf("%-44s %11llu %11llu %8.2f%s%s\n", cases[k].name, (unsigned long long)r.executions,
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
        const explorer_result r = explore(&cases[at]);
        if (r.finding) {
            *finding = r.finding;
            *hint = at;
            return cases[at].name;
        }
    }
    return NULL;
}
