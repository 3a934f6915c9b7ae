/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sizes of answers and records of a sweep.
 */
#include "sweep_block.h"

#include <stdlib.h>

static void set_answer(sweep_plan *plan)
{
    const uint32_t base = tfa_model_base_freedoms(plan->model);
    const uint32_t freedoms = tfa_model_v_count(plan->model);
    const uint32_t rows = 6 * plan->request.tip_count, n = base + freedoms;
    switch (plan->request.op) {
    case TFA_OP_OPERATIONAL_INERTIA:
        plan->matrix = rows * rows;
        break;
    case TFA_OP_MASS_MATRIX:
        plan->matrix = n * n;
        break;
    default:
        plan->base = base;
        plan->joint = freedoms;
    }
    plan->answer = plan->base + plan->joint + plan->matrix;
}

int sweep_plan_complete(sweep_plan *plan, const state_ranges *ranges, const char *text,
                        size_t length)
{
    const uint32_t joints = tfa_model_joint_count(plan->model);
    const char **names = calloc(joints + 1, sizeof *names);
    tfa_joint_limits *limits = calloc(joints + 1, sizeof *limits);
    int status = names && limits ? TFA_OK : TFA_E_MEMORY;
    set_answer(plan);
    for (uint32_t j = 0; status == TFA_OK && j < joints; j++)
        names[j] = tfa_model_joint(plan->model, j).name;
    if (status == TFA_OK && text)
        status = tfa_urdf_limits(text, length, names, joints, limits);
    if (status == TFA_OK)
        status = state_record_make(&plan->record, plan->model, plan->request.op, limits, ranges);
    free(names);
    free(limits);
    return status;
}

void sweep_plan_free(sweep_plan *plan)
{
    state_record_free(&plan->record);
}
