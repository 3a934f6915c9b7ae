/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Calls a running daemon over shared memory: a request, its answer, and the median time of 1000
 * calls. The first ones are slower: they touch memory, and wake the daemon's worker.
 *
 *     cc shared_memory.c -o shared_memory $(pkg-config --cflags --libs totalforce)
 *     ./shared_memory arm7
 */
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

enum { CALLS = 1000 };

static int by_size(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
    static uint64_t round_trip[CALLS], computing[CALLS]; /* ns */
    const tfa_client_options options = {.robot = argc > 1 ? argv[1] : "arm7"};
    tfa_client *client;
    int status = tfa_client_connect(&options, &client);
    if (status != TFA_OK) {
        char why[256];
        tfa_client_explain(&options, status, why, sizeof why);
        fprintf(stderr, "%s\n", why);
        return EXIT_FAILURE;
    }
    const tfa_client_info *info = tfa_client_get_info(client);
    double *q = calloc(info->q_count + 1, sizeof *q);
    double *qdd = calloc(info->v_count + 1, sizeof *qdd);
    const double pose[7] = {[6] = 1}; /* read when the base floats: at the origin, not turned */
    tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = 1,
                           .q = q,
                           .base_pose = pose};
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange times = {0};
    status = q && qdd ? TFA_OK : TFA_E_MEMORY;
    for (int k = 0; k < CALLS && status == TFA_OK; k++) {
        status = tfa_client_call(client, &request, &reply, 1000000000, &times);
        round_trip[k] = times.t_reply - times.t_sent;
        computing[k] = times.t_done - times.t_start;
    }
    if (status == TFA_OK) {
        for (uint32_t k = 0; k < info->v_count; k++)
            printf("qdd[%u] %+.6f\n", (unsigned)k, qdd[k]);
        qsort(round_trip, CALLS, sizeof *round_trip, by_size);
        qsort(computing, CALLS, sizeof *computing, by_size);
        printf("medians of %d calls: round trip %llu ns, of which computing %llu ns\n", CALLS,
               (unsigned long long)round_trip[CALLS / 2], (unsigned long long)computing[CALLS / 2]);
    } else {
        fprintf(stderr, "%s; %s\n", tfa_status_text(status), tfa_status_cause(status));
    }
    free(qdd);
    free(q);
    tfa_client_close(client);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
