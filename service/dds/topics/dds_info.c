/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway tells the domain which robots it leads: RobotInfo.
 */
#include "dds/topics/dds_internal.h"

#include <stdlib.h>
#include <string.h>

/* DDS types have no const: the strings are only read. */
static char *alias_text(const char *text)
{
    return (char *)(uintptr_t)text;
}

static totalforce_dds_Joint describe_joint(const tfa_model *model, uint32_t index)
{
    const tfa_joint_info joint = tfa_model_joint(model, index);

    return (totalforce_dds_Joint){
        .name = alias_text(joint.name),
        .type = (uint32_t)joint.type,
        .q_index = joint.q_index,
        .q_count = joint.q_count,
        .v_index = joint.v_index,
        .v_count = joint.v_count,
    };
}

dds_return_t tfa_dds_write_info(tfa_dds *gateway, const dds_robot *robot)
{
    const tfa_model_summary summary = tfa_model_summarise(robot->model);
    const uint32_t joints = tfa_model_joint_count(robot->model);
    const uint32_t frames = tfa_model_frame_count(robot->model);
    totalforce_dds_Joint *joint = calloc(joints + 1u, sizeof *joint);
    char **frame = calloc(frames + 1u, sizeof *frame);
    const uint32_t modes = robot->shape.modes;
    uint32_t *mode = calloc(modes + 1u, sizeof *mode);
    char *constraint[TFA_MAX_CONSTRAINTS];
    const uint32_t constraints = tfa_model_constraint_count(robot->model);
    totalforce_dds_RobotInfo info = {
        .q_count = robot->shape.q_count,
        .v_count = robot->shape.v_count,
        .base_freedoms = robot->shape.base_freedoms,
        .max_batch = robot->shape.max_batch,
        .max_tips = robot->shape.max_tips,
        .joints = {joints, joints, joint, false},
        .frames = {frames, frames, frame, false},
        .modes = {modes, modes, mode, false},
        .constraints = {constraints, constraints, constraint, false},
    };
    dds_return_t code = DDS_RETCODE_OUT_OF_RESOURCES;

    if (joint != NULL && frame != NULL && mode != NULL) {
        memcpy(info.robot, robot->name, sizeof info.robot);
        memcpy(info.model_hash, robot->hash, sizeof info.model_hash);
        memcpy(info.gravity, summary.gravity, sizeof info.gravity);
        for (uint32_t i = 0; i < joints; i++)
            joint[i] = describe_joint(robot->model, i);
        for (uint32_t i = 0; i < frames; i++)
            frame[i] = alias_text(tfa_model_frame(robot->model, i).name);
        for (uint32_t i = 0; i < modes; i++)
            mode[i] =
                (uint32_t)tfa_model_find_frame(robot->model, tfa_model_mode(robot->model, i).link);
        for (uint32_t i = 0; i < constraints; i++)
            constraint[i] = alias_text(tfa_model_constraint(robot->model, i).name);
        code = dds_write(gateway->info_writer, &info);
    }
    free(joint);
    free(frame);
    free(mode);
    return code;
}

void tfa_dds_withdraw_info(tfa_dds *gateway, const dds_robot *robot)
{
    totalforce_dds_RobotInfo info = {0};

    memcpy(info.robot, robot->name, sizeof info.robot);
    (void)dds_unregister_instance(gateway->info_writer, &info);
}
