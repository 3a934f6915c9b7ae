/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inputs of the ROS 2 gateway: from messages to values of joints, base, wrenches and constraints. A
 * message that is refused changes nothing; each refusal is counted at its topic, with its reason.
 */
#include "dds/ros2/ros2_internal.h"

#include "dds/common/ros_domain.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define COMMAND_VALUES (1u << TFA_JOINT_EFFORT)

/* ---- refusals ---- */

void ros2_refuse(ros2_input *in, const char *format, ...)
{
    va_list arguments;
    in->refused++;
    va_start(arguments, format);
    vsnprintf(in->error, sizeof in->error, format, arguments);
    va_end(arguments);
}

void ros2_fault_text(const tfa_joint_inputs *inputs, char *text, size_t size)
{
    static const char *const values[] = {"position", "velocity", "effort"};
    const tfa_joint_fault fault = tfa_joint_inputs_outcome(inputs).fault;
    const tfa_joint_fault_record *f = tfa_joint_inputs_fault(inputs, fault);
    switch (fault) {
    case TFA_JOINT_FAULT_LENGTH:
        snprintf(text, size, "%s: neither empty nor as long as the names", values[f->value]);
        return;
    case TFA_JOINT_FAULT_TWICE:
        snprintf(text, size, "joint '%s' is named twice", f->joint);
        return;
    case TFA_JOINT_FAULT_NOT_FINITE:
        snprintf(text, size, "joint '%s': %s is not finite", f->joint, values[f->value]);
        return;
    case TFA_JOINT_FAULT_MISSING:
        snprintf(text, size, "joint '%s': no %s was received", f->joint, values[f->value]);
        return;
    default:
        snprintf(text, size, "joint '%s': %s is too old", f->joint, values[f->value]);
        return;
    }
}

bool ros2_merge(ros2_input *in, tfa_joint_inputs *into, const tfa_joint_message *m, uint32_t values,
                int64_t now)
{
    const bool taken = tfa_joint_inputs_merge(into, m, values, now);
    if (tfa_joint_inputs_outcome(into).fault != TFA_JOINT_FAULT_COUNT) {
        in->refused++;
        ros2_fault_text(into, in->error, sizeof in->error);
    }
    return taken;
}

/* ---- messages ---- */

static ros2_header header_of(const std_msgs_msg_dds__Header_ *h)
{
    ros2_header header = {.sec = h->stamp.sec, .nanosec = h->stamp.nanosec};
    const size_t length = strnlen(h->frame_id, ROS2_FRAME_MAX);
    memcpy(header.frame, h->frame_id, length);
    return header;
}

tfa_joint_message ros2_message_of(const sensor_msgs_msg_dds__JointState_ *m)
{
    return (tfa_joint_message){
        .name = (const char *const *)m->name._buffer,
        .name_count = m->name._length,
        .value = {m->position._buffer, m->velocity._buffer, m->effort._buffer},
        .value_count = {m->position._length, m->velocity._length, m->effort._length},
    };
}

void ros2_take_state(ros2_robot *robot, const ros2_header *header, int64_t now)
{
    robot->state_header = *header;
    robot->state_is_new = true;
    if (robot->arrays->observer)
        ros2_observe(robot, now);
}

static void read_joint_state(ros2_input *in, const void *sample, int64_t now)
{
    const sensor_msgs_msg_dds__JointState_ *m = sample;
    ros2_robot *robot = in->robot;
    const tfa_joint_message message = ros2_message_of(m);
    if (!ros2_merge(in, robot->arrays->state, &message, robot->state_values, now))
        return;
    const ros2_header header = header_of(&m->header);
    ros2_take_state(robot, &header, now);
}

/* An answer bears the header of its command: one that is refused, or is of another robot, has none,
 * for it would be of the efforts before. */
static void read_command(ros2_input *in, const tfa_joint_message *message,
                         const ros2_header *header, int64_t now)
{
    tfa_joint_inputs *command = in->robot->arrays->command;
    (void)ros2_merge(in, command, message, COMMAND_VALUES, now);
    const tfa_joint_outcome outcome = tfa_joint_inputs_outcome(command);
    if (outcome.fault == TFA_JOINT_FAULT_COUNT && outcome.taken > 0)
        ros2_answer_command(in->robot, header, now);
}

/* Efforts in the configured order; the header is that of the state they belong to. */
static void read_effort_commands(ros2_input *in, const void *sample, int64_t now)
{
    const std_msgs_msg_dds__Float64MultiArray_ *m = sample;
    ros2_robot *robot = in->robot;
    const ros2_arrays *a = robot->arrays;
    const tfa_joint_message message = {.name = a->command_names,
                                       .name_count = a->command_count,
                                       .value[TFA_JOINT_EFFORT] = m->data._buffer,
                                       .value_count[TFA_JOINT_EFFORT] = m->data._length};
    if (m->layout.data_offset != 0 || m->data._length != a->command_count) {
        ros2_refuse(in, "%u numbers, data_offset %u; %u joints are commanded (%s, ...)",
                    m->data._length, m->layout.data_offset, a->command_count,
                    a->command_count ? a->command_names[0] : "none");
        return;
    }
    read_command(in, &message, &robot->state_header, now);
}

/* A command without efforts is refused: it would leave the former ones in force. */
static void read_named_efforts(ros2_input *in, const std_msgs_msg_dds__Header_ *h,
                               const tfa_joint_message *message, int64_t now)
{
    const ros2_header header = header_of(h);
    if (message->value_count[TFA_JOINT_EFFORT] == 0) {
        ros2_refuse(in, "no efforts");
        return;
    }
    read_command(in, message, &header, now);
}

static void read_joint_efforts(ros2_input *in, const void *sample, int64_t now)
{
    const sensor_msgs_msg_dds__JointState_ *m = sample;
    const tfa_joint_message message = ros2_message_of(m);
    read_named_efforts(in, &m->header, &message, now);
}

static void read_trajectory(ros2_input *in, const void *sample, int64_t now)
{
    const trajectory_msgs_msg_dds__JointTrajectory_ *m = sample;
    tfa_joint_message message = {.name = (const char *const *)m->joint_names._buffer,
                                 .name_count = m->joint_names._length};
    if (m->points._length > 0) {
        message.value[TFA_JOINT_EFFORT] = m->points._buffer[0].effort._buffer;
        message.value_count[TFA_JOINT_EFFORT] = m->points._buffer[0].effort._length;
    }
    read_named_efforts(in, &m->header, &message, now);
}

static bool are_finite(const double *number, int count)
{
    for (int k = 0; k < count; k++)
        if (!isfinite(number[k]))
            return false;
    return true;
}

static void read_wrench(ros2_input *in, const void *sample, int64_t now)
{
    const geometry_msgs_msg_dds__WrenchStamped_ *m = sample;
    const geometry_msgs_msg_dds__Vector3_ *f = &m->wrench.force, *t = &m->wrench.torque;
    const double value[6] = {f->x, f->y, f->z, t->x, t->y, t->z};
    const char *frame = m->header.frame_id, *link = in->robot->wrench_links.text[in->index];
    ros2_wrench *wrench = &in->robot->wrenches[in->index];
    if (*frame && strcmp(frame, link) != 0) {
        ros2_refuse(in, "frame_id '%.40s' where '%.40s' is expected", frame, link);
        return;
    }
    if (!are_finite(value, 6)) {
        ros2_refuse(in, "a number is not finite");
        return;
    }
    memcpy(wrench->value, value, sizeof value);
    wrench->received = now;
}

static int32_t find_constraint(const tfa_model *model, const char *name, size_t length)
{
    for (uint32_t k = 0; k < tfa_model_constraint_count(model); k++) {
        const char *own = tfa_model_constraint(model, k).name;
        if (strncmp(own, name, length) == 0 && !own[length])
            return (int32_t)k;
    }
    return -1;
}

/* Names between blanks; none: no constraint is active. */
static void read_constraints(ros2_input *in, const void *sample, int64_t now)
{
    static const char blanks[] = TFA_ROS2_BLANKS;
    const char *at = ((const std_msgs_msg_dds__String_ *)sample)->data;
    uint32_t bits = 0;
    while (*(at += strspn(at, blanks))) {
        const size_t length = strcspn(at, blanks);
        const int32_t k = find_constraint(in->robot->arrays->model, at, length);
        if (k < 0) {
            ros2_refuse(in, "the robot has no constraint '%.*s'", length < 60 ? (int)length : 60,
                        at);
            return;
        }
        bits |= UINT32_C(1) << k;
        at += length;
    }
    in->robot->active = (ros2_active){bits, now};
}

static void read_odometry(ros2_input *in, const void *sample, int64_t now)
{
    const nav_msgs_msg_dds__Odometry_ *m = sample;
    const geometry_msgs_msg_dds__Pose_ *p = &m->pose.pose;
    const geometry_msgs_msg_dds__Twist_ *t = &m->twist.twist;
    const double pose[7] = {p->position.x,    p->position.y,    p->position.z,   p->orientation.x,
                            p->orientation.y, p->orientation.z, p->orientation.w};
    const double twist[6] = {t->linear.x,  t->linear.y,  t->linear.z,
                             t->angular.x, t->angular.y, t->angular.z};
    ros2_base *base = &in->robot->base;
    const char *root = tfa_model_frame(in->robot->arrays->model, 0).name;
    if (*m->child_frame_id && strcmp(m->child_frame_id, root) != 0) {
        ros2_refuse(in, "child_frame_id '%.40s' where '%.40s', the root link, is expected",
                    m->child_frame_id, root);
        return;
    }
    if (!are_finite(pose, 7) || !are_finite(twist, 6)) {
        ros2_refuse(in, "a number is not finite");
        return;
    }
    memcpy(base->pose, pose, sizeof pose);
    memcpy(base->twist, twist, sizeof twist);
    base->received = now;
    if (in->robot->arrays->joints > 0)
        return; /* answers bear the stamp of joint states: one for each */
    const ros2_header header = header_of(&m->header);
    ros2_take_state(in->robot, &header, now);
}

static void read_description(ros2_input *in, const void *sample, int64_t now)
{
    const std_msgs_msg_dds__String_ *m = sample;
    ros2_robot *robot = in->robot;
    const gateway_context *c = &robot->gateway->context;
    (void)now;
    robot->descriptions++;
    if (strlen(m->data) > TFA_ROS2_DESCRIPTION_MAX) {
        ros2_refuse(in, "%zu bytes; at most %u are read", strlen(m->data),
                    TFA_ROS2_DESCRIPTION_MAX);
        return;
    }
    c->description(c->self, robot->config_number, m->data);
}

/* ---- all of them ---- */

typedef void (*reader_of)(ros2_input *in, const void *sample, int64_t now);

static const reader_of readers[ROS2_INPUT_KINDS] = {
    [ROS2_ROBOT_DESCRIPTION] = read_description,
    [ROS2_JOINT_STATES] = read_joint_state,
    [ROS2_LOW_STATE_GO] = ros2_read_low_state_go,
    [ROS2_LOW_STATE_HG] = ros2_read_low_state_hg,
    [ROS2_ODOMETRY] = read_odometry,
    [ROS2_WRENCH] = read_wrench,
    [ROS2_CONSTRAINTS] = read_constraints,
    [ROS2_EFFORT_COMMANDS] = read_effort_commands,
    [ROS2_JOINT_EFFORTS] = read_joint_efforts,
    [ROS2_TRAJECTORY] = read_trajectory,
    [ROS2_FORWARD_DYNAMICS] = ros2_answer_call,
};

/* A bound, so that one topic cannot hold up the others: more come with the next wake-up. */
#define MESSAGES_AT_ONCE 64

void ros2_read_message(ros2_input *in, const void *sample, int64_t now)
{
    in->received++;
    in->last = now;
    if (in->robot->arrays || in->kind == ROS2_ROBOT_DESCRIPTION)
        readers[in->kind](in, sample, now);
}

static void read_states(ros2_robot *robot, int64_t now);

/* A state that was published before a command has arrived when the command has: it is read before
 * the command is answered, even if both arrived after the last look at states. */
static void read_input(ros2_input *in, int64_t now)
{
    dds_sample_info_t info;
    for (int k = 0; k < MESSAGES_AT_ONCE; k++) {
        if (dds_take(in->reader, &in->sample, &info, 1, 1) <= 0)
            return;
        if (!info.valid_data)
            continue;
        if (ros2_is_command(in->kind))
            read_states(in->robot, now);
        ros2_read_message(in, in->sample, now);
    }
}

static void read_states(ros2_robot *robot, int64_t now)
{
    for (uint32_t k = 0; k < robot->input_count; k++)
        if (!ros2_is_command(robot->inputs[k].kind))
            read_input(&robot->inputs[k], now);
}

void ros2_read_inputs(ros2_robot *robot, int64_t now)
{
    robot->state_is_new = false;
    read_states(robot, now);
    for (uint32_t k = 0; k < robot->input_count; k++)
        if (ros2_is_command(robot->inputs[k].kind))
            read_input(&robot->inputs[k], now);
    if (robot->arrays && robot->state_is_new)
        ros2_answer_state(robot, now);
}
