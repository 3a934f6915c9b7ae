/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the ROS 2 gateway needs for one model: arrays, indices, and messages that point at them, so
 * that an answer is written without building anything.
 */
#include "dds/ros2/ros2_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROWS 6 /* of a tip: linear, then angular */

/* DDS types have no const: the strings are only read. */
static char *alias_text(const char *text)
{
    return (char *)(uintptr_t)text;
}

static dds_sequence_double sequence_of(double *numbers, uint32_t count)
{
    return (dds_sequence_double){count, count, numbers, false};
}

/* ---- memory ---- */

void ros2_arrays_free(ros2_arrays *a)
{
    if (!a)
        return;
    tfa_joint_inputs_free(a->state);
    tfa_joint_inputs_free(a->command);
    tfa_joint_inputs_free(a->call);
    tfa_observer_free(a->observer);
    free(a->names);
    free(a->command_names);
    free(a->numbers);
    free(a->row_label);
    free(a->column_label);
    free(a);
}

/* One block, cut into the arrays. */
static bool make_numbers(ros2_arrays *a)
{
    const size_t v = a->joints, n = v + a->base, rows = (size_t)ROWS * a->tip_count;
    double *at = calloc(4 * v + n + rows * rows + rows * n + rows + 1, sizeof *at);
    a->numbers = at;
    if (!at)
        return false;
    a->q = at;
    a->v = a->q + v;
    a->tau = a->v + v;
    a->qdd = a->tau + v;
    a->gravity = a->qdd + v;
    a->lambda_inv = a->gravity + n;
    a->jacobian = a->lambda_inv + rows * rows;
    a->bias = a->jacobian + rows * n;
    return true;
}

static bool make_names(const ros2_robot *robot, ros2_arrays *a)
{
    a->names = calloc(a->joints + 1u, sizeof *a->names);
    a->command_count = robot->joints.count ? robot->joints.count : a->joints;
    a->command_names = calloc(a->command_count + 1u, sizeof *a->command_names);
    if (!a->names || !a->command_names)
        return false;
    for (uint32_t j = 0; j < a->joints; j++)
        a->names[j] = tfa_model_joint(a->model, j).name;
    for (uint32_t j = 0; j < a->command_count; j++)
        a->command_names[j] = robot->joints.count ? robot->joints.text[j] : a->names[j];
    a->state = tfa_joint_inputs_create(a->names, a->joints);
    a->command = tfa_joint_inputs_create(a->names, a->joints);
    a->call = tfa_joint_inputs_create(a->names, a->joints);
    return a->state && a->command && a->call;
}

static bool make_observer(const ros2_robot *robot, ros2_arrays *a)
{
    return !(robot->observer.gain > 0) ||
           tfa_observer_create(a->base, a->joints, &robot->observer, &a->observer) == TFA_OK;
}

/* Links, joints and constraints exist: tfa_ros2_check. */
static void find_indices(const ros2_robot *robot, ros2_arrays *a)
{
    for (uint32_t k = 0; k < a->tip_count; k++)
        a->tips[k] = (uint32_t)tfa_model_find_frame(a->model, robot->tips.text[k]);
    if (robot->observer_tip.count)
        a->observer_tip = (uint32_t)tfa_model_find_frame(a->model, robot->observer_tip.text[0]);
    for (uint32_t k = 0; k < robot->wrench_links.count; k++)
        a->wrench_frames[k] = (uint32_t)tfa_model_find_frame(a->model, robot->wrench_links.text[k]);
    for (uint32_t k = 0; k < robot->motors.count; k++)
        a->motor_joint[k] = tfa_model_find_joint(a->model, robot->motors.text[k]);
    for (uint32_t k = 0; k < robot->constraints.count; k++)
        a->default_constraints |=
            UINT32_C(1) << tfa_model_find_constraint(a->model, robot->constraints.text[k]);
    for (uint32_t k = 0; k < tfa_model_constraint_count(a->model) && !robot->constraints.count; k++)
        a->default_constraints |= UINT32_C(1) << k;
}

/* ---- labels of the layouts ---- */

static void write_axes(FILE *out, const char *name)
{
    static const char *const axes[ROWS] = {"x", "y", "z", "rx", "ry", "rz"};
    for (int k = 0; k < ROWS; k++)
        fprintf(out, " %s.%s", name, axes[k]);
}

/* "rows tool0.x tool0.y ..." */
static char *label_rows(const ros2_robot *robot)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("rows", out);
    for (uint32_t k = 0; k < robot->tips.count; k++)
        write_axes(out, robot->tips.text[k]);
    return fclose(out) == 0 ? text : NULL;
}

/* "columns base.x ... joint_1 ..." */
static char *label_columns(const ros2_arrays *a)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("columns", out);
    if (a->base)
        write_axes(out, "base");
    for (uint32_t j = 0; j < a->joints; j++)
        fprintf(out, " %s", a->names[j]);
    return fclose(out) == 0 ? text : NULL;
}

/* ---- messages ---- */

/* The stamp's dimension, then rows, then, if there are any, columns. */
static void make_array(ros2_arrays *a, ros2_output_kind kind, double *data, uint32_t columns,
                       const char *column_label)
{
    const uint32_t rows = ROWS * a->tip_count, size = rows * (columns ? columns : 1);
    std_msgs_msg_dds__MultiArrayDimension_ *d = a->dimensions[kind];
    std_msgs_msg_dds__Float64MultiArray_ *m = &a->array[kind];
    d[0] = (std_msgs_msg_dds__MultiArrayDimension_){a->stamp_label, 1, size};
    d[1] = (std_msgs_msg_dds__MultiArrayDimension_){a->row_label, rows, size};
    d[2] = (std_msgs_msg_dds__MultiArrayDimension_){alias_text(column_label), columns, columns};
    m->layout.dim._buffer = d;
    m->layout.dim._length = m->layout.dim._maximum = columns ? 3 : 2;
    m->data = sequence_of(data, size);
}

static void make_messages(const ros2_robot *robot, ros2_arrays *a)
{
    char **names = (char **)(uintptr_t)a->names;
    a->point = (trajectory_msgs_msg_dds__JointTrajectoryPoint_){
        .positions = sequence_of(a->q, a->joints),
        .velocities = sequence_of(a->v, a->joints),
        .accelerations = sequence_of(a->qdd, a->joints),
        .effort = sequence_of(a->tau, a->joints),
    };
    a->accelerations = (trajectory_msgs_msg_dds__JointTrajectory_){
        .joint_names = {a->joints, a->joints, names, false},
        .points = {1, 1, &a->point, false},
    };
    a->gravity_torques = (sensor_msgs_msg_dds__JointState_){
        .name = {a->joints, a->joints, names, false},
        .position = sequence_of(a->q, a->joints),
        .effort = sequence_of(a->gravity + a->base, a->joints),
    };
    a->external_torques.name = a->gravity_torques.name;
    if (a->observer) {
        double *torques = (double *)(uintptr_t)tfa_observer_torques(a->observer); /* only read */
        a->external_torques.effort = sequence_of(torques + a->base, a->joints);
    }
    a->external_base_wrench.header.frame_id = alias_text(tfa_model_frame(a->model, 0).name);
    if (robot->observer_tip.count)
        a->external_wrench.header.frame_id = robot->observer_tip.text[0];
    _Static_assert(sizeof(geometry_msgs_msg_dds__Wrench_) == sizeof a->constraint_wrench[0], "");
    a->constraint_wrenches.joint_names._buffer = a->constraint_name;
    a->constraint_wrenches.wrench._buffer = (void *)a->constraint_wrench;
    make_array(a, ROS2_LAMBDA_INV, a->lambda_inv, ROWS * a->tip_count, a->row_label);
    make_array(a, ROS2_JACOBIAN, a->jacobian, a->joints + a->base, a->column_label);
    make_array(a, ROS2_BIAS_ACCELERATION, a->bias, 0, "");
}

ros2_arrays *ros2_arrays_create(const ros2_robot *robot, const tfa_model *model)
{
    ros2_arrays *a = calloc(1, sizeof *a);
    if (!a)
        return NULL;
    a->model = model;
    a->joints = tfa_model_joint_count(model);
    a->base = tfa_model_base_freedoms(model);
    a->tip_count = robot->tips.count;
    if (!make_names(robot, a) || !make_numbers(a) || !make_observer(robot, a)) {
        ros2_arrays_free(a);
        return NULL;
    }
    find_indices(robot, a);
    a->row_label = label_rows(robot);
    a->column_label = label_columns(a);
    if (!a->row_label || !a->column_label) {
        ros2_arrays_free(a);
        return NULL;
    }
    make_messages(robot, a);
    return a;
}
