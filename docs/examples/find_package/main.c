/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A consumer in C: loads the robot named on the command line and prints a summary.
 */
#include <stdio.h>
#include <totalforce/totalforce.h>

int main(int argc, char **argv)
{
    tfa_report report = {0};
    tfa_model *model = NULL;
    int status = argc == 2 ? tfa_model_load(argv[1], NULL, &report, &model) : TFA_E_ARGUMENT;
    tfa_report_free(&report);
    if (status != TFA_OK) {
        fprintf(stderr, "%s\n", tfa_status_text(status));
        return 1;
    }
    tfa_model_summary s = tfa_model_summarise(model);
    printf("%s: %u links became %u bodies, %.3f kg move\n", tfa_model_name(model),
           (unsigned)s.links, (unsigned)s.bodies, s.moving_mass);
    tfa_model_free(model);
    return 0;
}
