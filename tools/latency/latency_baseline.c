/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The baseline of round trips: the same requests solved in process.
 */
#include "common/commands.h"
#include "latency.h"
#include "pingpong.h"

#include <stdio.h>
#include <string.h>
#include <totalforce/totalforce.h>

/* Solves of one process settle long before this; more would only take the user's time. */
enum { SOLVES_MAX = 100000 };

void latency_baseline_init(latency_baseline *baseline)
{
    tfa_histogram *const all[] = {&baseline->pingpong, &baseline->same_size, &baseline->solve};
    for (int i = 0; i < 3; i++)
        (void)!tfa_histogram_init(all[i], LATENCY_BITS, 64, baseline->buckets[i]);
}

static int solve_all(const latency_options *options, const latency_states *states,
                     tfa_workspace *workspace, tfa_reply *reply, tfa_histogram *h)
{
    uint64_t count = options->count < SOLVES_MAX ? options->count : SOLVES_MAX;
    uint64_t warmup = options->warmup < count ? options->warmup : count;
    for (uint64_t i = 0; i < warmup + count; i++) {
        uint64_t start = clock_ns();
        int status = tfa_compute(workspace, &states->requests[i % states->sets], reply);
        uint64_t end = clock_ns();
        if (status != TFA_OK)
            return status;
        if (i >= warmup)
            tfa_histogram_add(h, end - start);
    }
    return TFA_OK;
}

int latency_solve(const latency_options *options, const latency_run *run, tfa_histogram *h)
{
    tfa_model_options model_options = {.base = run->info.base_freedoms ? TFA_BASE_FLOATING
                                                                       : TFA_BASE_FIXED};
    tfa_report report = {0};
    tfa_workspace *workspace = NULL;
    tfa_reply reply = {0};
    tfa_model *model = load_model(options->urdf, &model_options, TFA_ERROR, &report);
    tfa_report_free(&report);
    if (!model)
        return TFA_E_MODEL;
    int status = TFA_E_SIZE;
    if (tfa_model_q_count(model) == run->info.q_count &&
        tfa_model_v_count(model) == run->info.v_count)
        status = tfa_workspace_create(model, NULL, &workspace);
    if (status == TFA_OK)
        status = latency_reply_init(&reply, options, &run->info);
    if (status == TFA_OK)
        status = solve_all(options, &run->states, workspace, &reply, h);
    if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: --urdf %s: %s: %s\n", options->urdf,
                tfa_status_text(status), tfa_status_cause(status));
    else if (strcmp(tfa_model_hash_text(model), run->hash) != 0)
        fprintf(stderr,
                "totalforce latency: note: %s has another hash than the daemon's robot: same "
                "sizes, other masses, gravity or options\n",
                options->urdf);
    latency_reply_free(&reply);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return status;
}
