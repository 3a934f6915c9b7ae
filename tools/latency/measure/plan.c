/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Runs of a session: each way to an answer, at each value of a sweep.
 */
#include "run.h"

#include "common/commands.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_MAX = 256 };

/* Whole number from 1 to `highest`; 0: not one. */
static uint32_t whole(const char *text, unsigned long highest)
{
    char *end;
    errno = 0;
    const unsigned long value = strtoul(text, &end, 10);
    return errno || *end || end == text || value > highest ? 0 : (uint32_t)value;
}

static int set_wait(latency_options *options, const char *value)
{
    const int32_t wait = tfa_word_find(TFA_WORDS_WAIT, value);
    if (wait >= 0)
        options->daemon.wait = (tfa_wait)wait;
    return wait >= 0;
}

static int set_rate(latency_options *options, const char *value)
{
    char *end;
    options->rate = strtod(value, &end);
    return *end == '\0' && options->rate > 0 && options->rate < 1e9;
}

/* @return 0: no such key or value */
static int set(latency_options *options, const char *key, const char *value)
{
    if (strcmp(key, "rate") == 0)
        return set_rate(options, value);
    if (strcmp(key, "batch") == 0)
        return (options->daemon.max_batch = options->batch = whole(value, 1 << 20)) > 0;
    if (strcmp(key, "clients") == 0)
        return (options->clients = whole(value, CLIENTS_MAX)) > 0;
    if (strcmp(key, "wait") == 0)
        return set_wait(options, value);
    if (strcmp(key, "robots") == 0) {
        options->daemon.robot = value;
        return *value != '\0';
    }
    return 0;
}

static int add(const latency_options *options, const char *swept, latency_run *runs, int count)
{
    for (int via = 0; via < VIA_COUNT; via++)
        if (options->vias & (1u << via)) {
            runs[count].options = *options;
            runs[count].via = (latency_via)via;
            runs[count++].swept = swept;
        }
    return count;
}

int latency_plan(const latency_options *options, latency_run **runs)
{
    int count = 0;
    *runs = calloc((size_t)ROWS_MAX * VIA_COUNT, sizeof **runs);
    if (!*runs) {
        fprintf(stderr, "totalforce latency: %s\n", tfa_status_text(TFA_E_MEMORY));
        return 0;
    }
    if (!options->sweep)
        return add(options, NULL, *runs, 0);
    char *values = strchr(options->sweep, '=');
    if (values)
        *values++ = '\0';
    for (char *value = strsep(&values, ","); value && count < ROWS_MAX;
         value = strsep(&values, ",")) {
        latency_options row = *options;
        if (!set(&row, options->sweep, value)) {
            count = 0;
            break;
        }
        count = add(&row, value, *runs, count);
    }
    if (count == 0)
        fprintf(stderr,
                "totalforce latency: --sweep: '%s' is not rate, batch, clients, wait or "
                "robots with values of it\n",
                options->sweep);
    return count;
}

void latency_runs_free(latency_run *runs, int count)
{
    for (int i = 0; runs && i < count; i++) {
        for (uint32_t k = 0; runs[i].clients && k < runs[i].client_count; k++)
            tally_free(runs[i].clients[k].figures);
        free(runs[i].clients);
        tally_free(runs[i].total);
        latency_states_free(&runs[i].states);
    }
    free(runs);
}
