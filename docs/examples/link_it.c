/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Links the library: accelerations of an arm under gravity, at rest and without torques.
 *
 *     cc link_it.c -o link_it $(pkg-config --cflags --libs totalforce)
 *     ./link_it config/robots/arm7.urdf
 */
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

int main(int argc, char **argv)
{
    tfa_report report = {0};
    tfa_model *model;
    tfa_workspace *workspace;
    int status = tfa_model_load(argc > 1 ? argv[1] : "arm7.urdf", NULL, &report, &model);
    for (size_t k = 0; k < report.count; k++) { /* errors and warnings */
        char line[512];
        tfa_report_format(&report, k, line, sizeof line);
        fprintf(stderr, "%s\n", line);
    }
    tfa_report_free(&report);
    if (status != TFA_OK || tfa_workspace_create(model, NULL, &workspace) != TFA_OK)
        return EXIT_FAILURE;

    /* all joints at zero and at rest; zero is a value for every joint but a floating one */
    double *q = calloc(tfa_model_q_count(model) + 1, sizeof *q);
    double *qdd = calloc(tfa_model_v_count(model) + 1, sizeof *qdd);
    tfa_request request = {
        .op = TFA_OP_FORWARD_DYNAMICS, .refine = TFA_REFINE_DEFAULT, .count = 1, .q = q};
    tfa_reply reply = {.qdd = qdd};
    if (q && qdd && (status = tfa_compute(workspace, &request, &reply)) == TFA_OK)
        for (uint32_t j = 0; j < tfa_model_joint_count(model); j++)
            printf("%-12s %+.6f\n", tfa_model_joint(model, j).name,
                   qdd[tfa_model_joint(model, j).v_index]);
    else
        fprintf(stderr, "%s: %s\n", tfa_status_text(status), tfa_field_name(reply.field));
    free(qdd);
    free(q);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
