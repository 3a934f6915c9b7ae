/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scenarios of a subject.
 */
#include <stdio.h>

#include "subject.h"

int scenarios_run(const subject *s)
{
    int failures = 0;
    printf("\n%-44s %11s %11s %11s %8s\n", s->name, "executions", "branches", "states", "seconds");
    for (int k = 0; k < s->scenarios; k++) {
        const explorer_result r = s->explore(k);
        printf("%-44s %11llu %11llu %11llu %8.2f%s%s\n", s->scenario_name(k),
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

const char *scenarios_find(const subject *s, const char **finding, int *hint)
{
    for (int k = -1; k < s->scenarios; k++) {
        const int at = k < 0 ? *hint : k;
        if (k == *hint)
            continue;
        const explorer_result r = s->explore(at);
        if (r.finding) {
            *finding = r.finding;
            *hint = at;
            return s->scenario_name(at);
        }
    }
    return NULL;
}
