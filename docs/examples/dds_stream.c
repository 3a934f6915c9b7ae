/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Streams joint torques to totalforced over DDS and prints the accelerations that come back.
 * Needs idl/totalforce.idl and Cyclone DDS, nothing else of totalforce:
 *
 *   idlc idl/totalforce.idl
 *   cc docs/examples/dds_stream.c totalforce.c -I. -lddsc -lm -o dds_stream
 *   ./dds_stream ROBOT JOINTS [SAMPLES]        (a fixed base, one freedom a joint)
 */
#include <dds/dds.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "totalforce.h"

int main(int argc, char **argv)
{
    if (argc < 3)
        return fprintf(stderr, "usage: dds_stream ROBOT JOINTS [SAMPLES]\n"), 3;
    const char *robot = argv[1];
    const uint32_t n = (uint32_t)atoi(argv[2]);
    const int samples = argc > 3 ? atoi(argv[3]) : 1000;
    const dds_entity_t domain = dds_create_participant(DDS_DOMAIN_DEFAULT, NULL, NULL);
    const dds_entity_t torques =
        dds_create_writer(domain,
                          dds_create_topic(domain, &totalforce_dds_JointTorques_desc,
                                           "totalforce/joint_torques", NULL, NULL),
                          NULL, NULL);
    const dds_entity_t accelerations =
        dds_create_reader(domain,
                          dds_create_topic(domain, &totalforce_dds_JointAccelerations_desc,
                                           "totalforce/joint_accelerations", NULL, NULL),
                          NULL, NULL);
    double *q = calloc(3 * (size_t)n, sizeof *q), *v = q + n, *tau = v + n;
    if (accelerations < 0 || torques < 0 || q == NULL)
        return fprintf(stderr, "cannot join the DDS domain\n"), 2;

    /* q, v and tau are borrowed: Cyclone copies them when it writes. */
    totalforce_dds_JointTorques out = {
        .q = {n, n, q, false}, .v = {n, n, v, false}, .tau = {n, n, tau, false}};
    snprintf(out.robot, sizeof out.robot, "%s", robot);

    for (int k = 0; k < samples; k++, dds_sleepfor(DDS_MSECS(1))) {
        for (uint32_t i = 0; i < n; i++)
            q[i] = 0.5 * sin(0.001 * k + i);
        out.seq = (uint64_t)k;
        out.stamp = dds_time(); /* ROS time: ns since 1970 */
        dds_write(torques, &out);

        void *sample[1] = {NULL};
        dds_sample_info_t state;
        while (dds_take(accelerations, sample, &state, 1, 1) == 1) {
            const totalforce_dds_JointAccelerations *in = sample[0];
            if (state.valid_data && strcmp(in->robot, robot) == 0)
                printf("seq %llu: status %d, qdd[0] = %g rad/s^2, after %.1f us\n",
                       (unsigned long long)in->seq, in->status,
                       in->qdd._length > 0 ? in->qdd._buffer[0] : NAN,
                       1e-3 * (double)(in->t_done - in->stamp));
            dds_return_loan(accelerations, sample, 1);
        }
    }
    free(q);
    return dds_delete(domain) == DDS_RETCODE_OK ? 0 : 2;
}
