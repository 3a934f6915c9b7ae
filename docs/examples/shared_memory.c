/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Calls a running daemon over shared memory: one request, its answer and its time.
 *
 *     cc shared_memory.c -o shared_memory $(pkg-config --cflags --libs totalforce)
 *     ./shared_memory arm7
 */
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

int main(int argc, char **argv)
{
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
    status =
        q && qdd ? tfa_client_call(client, &request, &reply, 1000000000, &times) : TFA_E_MEMORY;
    if (status == TFA_OK) {
        for (uint32_t k = 0; k < info->v_count; k++)
            printf("qdd[%u] %+.6f\n", (unsigned)k, qdd[k]);
        printf("round trip %llu ns, of which computing %llu ns\n",
               (unsigned long long)(times.t_reply - times.t_sent),
               (unsigned long long)(times.t_done - times.t_start));
    } else {
        fprintf(stderr, "%s; %s\n", tfa_status_text(status), tfa_status_cause(status));
    }
    free(qdd);
    free(q);
    tfa_client_close(client);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
