/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A leg with rods, as Cassie's, once each millisecond: what the encoders do not measure comes from
 * the loops, then accelerations under the constraints. A file beside the URDF has the loops.
 *
 *     cc leg_with_rods.c -o leg_with_rods $(pkg-config --cflags --libs totalforce) -lm
 *     ./leg_with_rods config/robots/loops/rod_leg.urdf config/robots/loops/rod_leg.yaml
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/totalforce.h>

enum { N = 16, ROWS = 6 * 4 }; /* joints and rows, at most */

/* Joints with an encoder, and where they are at time t */
static const char *const measured[] = {"hip_roll", "hip_yaw",     "hip_pitch",
                                       "knee",     "shin_spring", "toe_crank"};
enum { MEASURED = sizeof measured / sizeof *measured };
static const double amplitude[MEASURED] = {0.05, 0.1, 0.3, -0.4, 0.02, 0.2}; /* rad */

/* One millisecond: q and v of all joints, then their accelerations without torques.
 * @return status; `open` and `residual` get the worst errors so far, `iterations` their sum */
static int step(tfa_workspace *workspace, const tfa_model *model, const uint32_t *locked, double t,
                double *q, double *v, double *open, double *residual, uint32_t *iterations)
{
    double qdd[N], rest[ROWS];
    for (int k = 0; k < MEASURED; k++) {
        const tfa_joint_info joint = tfa_model_joint(model, locked[k]);
        q[joint.q_index] = amplitude[k] * sin(6 * t);
        v[joint.v_index] = amplitude[k] * 6 * cos(6 * t);
    }
    tfa_request request = {.op = TFA_OP_CONSTRAINED_DYNAMICS,
                           .count = 1,
                           .refine = TFA_REFINE_DEFAULT,
                           .constraints = (1u << tfa_model_constraint_count(model)) - 1,
                           .locked = locked,
                           .locked_count = MEASURED,
                           .q = q,
                           .v = v};
    tfa_posture posture = {.q = q, .v = v}; /* of the last millisecond: the search begins there */
    int status = tfa_close_loops(workspace, &request, NULL, &posture);
    if (status != TFA_OK)
        return status;
    *open = fmax(*open, fmax(posture.position, posture.velocity));
    *iterations += posture.iterations;

    request.locked_count = 0; /* now all joints move */
    tfa_reply reply = {.qdd = qdd, .constraint_residual = rest};
    status = tfa_compute(workspace, &request, &reply);
    for (uint32_t k = 0; status == TFA_OK && k < 6 * tfa_model_constraint_count(model); k++)
        *residual = fmax(*residual, fabs(rest[k]));
    return status;
}

/* The robot with the constraints and motors of a side file. @return status */
static int load(const char *urdf, const char *side_file, tfa_model **model)
{
    tfa_constraints loops = {0};
    tfa_report report = {0};
    int status = tfa_constraints_load(side_file, &loops, &report);
    const tfa_scene scene = {.constraints = loops.list,
                             .constraint_count = loops.count,
                             .actuated = loops.actuated,
                             .actuated_count = loops.actuated_count};
    if (status == TFA_OK)
        status = tfa_model_load(urdf, &(tfa_model_options){.scene = &scene}, &report, model);
    for (size_t k = 0; k < report.count; k++) { /* errors and warnings */
        char line[512];
        tfa_report_format(&report, k, line, sizeof line);
        fprintf(stderr, "%s\n", line);
    }
    tfa_report_free(&report);
    tfa_constraints_free(&loops); /* the model has copied them */
    return status;
}

int main(int argc, char **argv)
{
    tfa_model *model = NULL;
    tfa_workspace *workspace = NULL;
    uint32_t locked[MEASURED], iterations = 0;
    double q[N] = {0}, v[N] = {0}, open = 0, residual = 0;
    int status = argc == 3 ? load(argv[1], argv[2], &model) : TFA_E_ARGUMENT;
    if (status == TFA_OK)
        status = tfa_workspace_create(model, NULL, &workspace);
    for (int k = 0; status == TFA_OK && k < MEASURED; k++) {
        const int32_t joint = tfa_model_find_joint(model, measured[k]);
        locked[k] = (uint32_t)joint;
        if (joint < 0 || tfa_model_v_count(model) > N)
            status = TFA_E_JOINT;
    }
    for (int k = 0; status == TFA_OK && k < 1000; k++)
        status = step(workspace, model, locked, 1e-3 * k, q, v, &open, &residual, &iterations);
    if (status == TFA_OK)
        printf("1000 postures, %u iterations: loops open by %.1e, worst residual %.1e\n",
               (unsigned)iterations, open, residual);
    else
        fprintf(stderr, "%s; %s\n", tfa_status_text(status), tfa_status_cause(status));
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return status == TFA_OK ? EXIT_SUCCESS : EXIT_FAILURE;
}
