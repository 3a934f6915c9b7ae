/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loops where all joints are at 0: most files are written so that they are closed there.
 */
#include "model_loops.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double origin[7] = {0, 0, 0, 0, 0, 0, 1};

/* All coordinates 0; quaternions that turn nothing */
static void set_zero(const tfa_model *model, double *q)
{
    for (uint32_t k = 0; k < tfa_model_joint_count(model); k++) {
        const tfa_joint_info joint = tfa_model_joint(model, k);
        const int32_t quaternion = tfa_joint_type_describe(joint.type).quaternion;
        for (uint32_t e = 0; e < joint.q_count; e++)
            q[joint.q_index + e] = quaternion >= 0 && e == (uint32_t)quaternion + 3;
    }
}

static double norm(const double *x, uint32_t rows)
{
    double sum = 0;
    for (uint32_t e = 0; e < 3; e++)
        sum += rows >> e & 1 ? x[e] * x[e] : 0;
    return sqrt(sum);
}

static uint32_t loops_of(const tfa_model *model)
{
    uint32_t bits = 0;
    for (uint32_t k = 0; k < tfa_model_constraint_count(model); k++) {
        const tfa_constraint_info c = tfa_model_constraint(model, k);
        const int is_inner = c.frame[0] >= 0 && c.frame[1] >= 0;
        if (!c.unilateral && (is_inner || !tfa_model_base_freedoms(model)))
            bits |= 1u << k;
    }
    return bits;
}

/* One at a time, so that an inertia or the tips of a workspace set no limit to all */
static void measure(const tfa_model *model, tfa_workspace *workspace, const double *q,
                    model_loops *loops)
{
    for (uint32_t k = 0; k < tfa_model_constraint_count(model); k++) {
        const uint32_t rows = tfa_model_constraint(model, k).rows;
        double position[6];
        const tfa_request request = {.op = TFA_OP_CONSTRAINED_INVERSE_DYNAMICS,
                                     .count = 1,
                                     .constraints = 1u << k,
                                     .q = q,
                                     .base_pose = origin};
        tfa_reply reply = {.constraint_position = position};
        if (!(loops->checked >> k & 1))
            continue;
        if (tfa_compute(workspace, &request, &reply) != TFA_OK) {
            loops->checked &= ~(1u << k);
            continue;
        }
        loops->error[k][0] = norm(position, rows);
        loops->error[k][1] = norm(position + 3, rows >> 3);
        if (fmax(loops->error[k][0], loops->error[k][1]) > MODEL_LOOP_OPEN)
            loops->open |= 1u << k;
    }
}

static void close_loops(const tfa_model *model, tfa_workspace *workspace, const double *q,
                        double *closed, model_loops *loops)
{
    double pose[7];
    const tfa_request request = {.constraints = loops->checked, .q = q, .base_pose = origin};
    tfa_posture posture = {.q = closed, .base_pose = pose};
    loops->status = tfa_close_loops(workspace, &request, NULL, &posture);
    loops->iterations = posture.iterations;
    loops->left = posture.position;
    if (loops->status != TFA_OK && loops->status != TFA_E_OPEN)
        return;
    for (uint32_t k = 0; k < tfa_model_joint_count(model); k++) {
        const tfa_joint_info joint = tfa_model_joint(model, k);
        for (uint32_t e = joint.q_index; e < joint.q_index + joint.q_count; e++)
            if (fabs(closed[e] - q[e]) > fabs(loops->change)) {
                loops->joint = k;
                loops->change = closed[e] - q[e];
            }
    }
}

int model_loops_check(const tfa_model *model, model_loops *loops)
{
    const uint32_t n = tfa_model_q_count(model);
    const tfa_workspace_options options = {.states = TFA_STATES_ONE, .max_tips = TFA_MAX_TIPS};
    tfa_workspace *workspace = NULL;
    *loops = (model_loops){.checked = loops_of(model)};
    if (!loops->checked)
        return TFA_OK;
    double *q = calloc(2 * (size_t)n + 1, sizeof *q);
    const int status = q ? tfa_workspace_create(model, &options, &workspace) : TFA_E_MEMORY;
    if (status == TFA_OK) {
        set_zero(model, q);
        measure(model, workspace, q, loops);
    }
    if (status == TFA_OK && loops->open)
        close_loops(model, workspace, q, q + n, loops);
    if (status != TFA_OK)
        loops->checked = 0;
    tfa_workspace_free(workspace);
    free(q);
    return status;
}

int model_loops_text(const tfa_model *model, const model_loops *loops, uint32_t constraint,
                     char *text, size_t size)
{
    return snprintf(text, size,
                    "loop '%s' is open by %.3g m, %.3g rad at the zero posture; correct its frames "
                    "if the file means it to be closed there, otherwise let close_loops find "
                    "postures",
                    tfa_model_constraint(model, constraint).name, loops->error[constraint][0],
                    loops->error[constraint][1]);
}

void model_loops_warn(const tfa_model *model, const model_loops *loops, const char *file)
{
    char text[1024];
    for (uint32_t k = 0; k < tfa_model_constraint_count(model); k++)
        if (loops->open >> k & 1) {
            (void)model_loops_text(model, loops, k, text, sizeof text);
            fprintf(stderr, "%s: warning: %s [" MODEL_LOOP_CODE "]\n", file, text);
        }
}
