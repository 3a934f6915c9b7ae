/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost of counting a request for the worker: alone, and between forward dynamics of a 7-joint arm
 * of clients that take turns, as the difference to the same without counting.
 *
 *   bench_tally URDF [ROUNDS]     CSV: clients, ns of a solve, ns of counting alone, ns added
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <totalforce/totalforce.h>

#include "ipc/statistics_layout.h"
#include "timing.h"

enum { CLIENTS_MAX = 64, CALLS = 4096, ROUNDS_MAX = 1001, JOINTS = 7, REQUESTS = 256 };

static tfa_shared_client clients[CLIENTS_MAX];
static tfa_workspace *workspace;
static volatile double ended;
static double q[CLIENTS_MAX][JOINTS], qdd[JOINTS];
static tfa_tally_request requests[REQUESTS];

/* Times that fall into other buckets of the histograms, as those of a daemon do. */
static uint64_t spread(uint64_t around)
{
    static uint64_t seed = 1;
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return around + (seed >> 33) % around;
}

static void make_requests(void)
{
    static const tfa_answer answer = {.method = TFA_METHOD_ABA};
    for (uint32_t i = 0; i < REQUESTS; i++) {
        const uint64_t sent = 1000000, received = sent + spread(150),
                       start = received + spread(100), done = start + spread(500);
        requests[i] = (tfa_tally_request){.status = TFA_OK,
                                          .has_answers = true,
                                          .states = 1,
                                          .answers = &answer,
                                          .busy_ns = done - start,
                                          .sent = sent,
                                          .received = received,
                                          .start = start,
                                          .done = done};
    }
}

static void solve(uint32_t client)
{
    const tfa_request request = {
        .op = TFA_OP_FORWARD_DYNAMICS, .refine = TFA_REFINE_DEFAULT, .count = 1, .q = q[client]};
    tfa_answer answer;
    tfa_reply reply = {.qdd = qdd, .answers = &answer};
    if (tfa_compute(workspace, &request, &reply) != TFA_OK)
        abort();
}

/* ns of a call, over calls of clients in turn */
static double time_turn(uint32_t client_count, bool solves, bool counts)
{
    const double start = time_ns(CLOCK_THREAD_CPUTIME_ID);
    for (uint32_t k = 0; k < CALLS; k++) {
        if (solves) {
            solve(k % client_count);
            ended = time_ns(CLOCK_MONOTONIC); /* as the worker does after each request */
        }
        if (counts)
            tfa_tally_count(&clients[k % client_count].tally, &requests[k % REQUESTS]);
    }
    return (time_ns(CLOCK_THREAD_CPUTIME_ID) - start) / CALLS;
}

static void measure(uint32_t client_count, int rounds)
{
    static double plain[ROUNDS_MAX], alone[ROUNDS_MAX], added[ROUNDS_MAX];
    for (int r = 0; r < rounds; r++) {
        plain[r] = time_turn(client_count, true, false);
        added[r] = time_turn(client_count, true, true) - plain[r];
        alone[r] = time_turn(client_count, false, true);
    }
    printf("%u,%.1f,%.1f,%.1f\n", client_count, median_of(plain, rounds), median_of(alone, rounds),
           median_of(added, rounds));
}

int main(int argc, char **argv)
{
    const int rounds = argc > 2 ? atoi(argv[2]) : 101;
    tfa_model *model;
    tfa_report report = {0};
    if (argc < 2 || rounds < 1 || rounds > ROUNDS_MAX) {
        fputs("bench_tally URDF [ROUNDS]\n", stderr);
        return 3;
    }
    if (tfa_model_load(argv[1], NULL, &report, &model) != TFA_OK ||
        tfa_model_q_count(model) != JOINTS ||
        tfa_workspace_create(model, NULL, &workspace) != TFA_OK)
        return 2;
    make_requests();
    puts("clients,solve_ns,alone_ns,added_ns");
    for (uint32_t n = 1; n <= CLIENTS_MAX; n *= 4)
        measure(n, rounds);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    tfa_report_free(&report);
    return 0;
}
