/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * LowState of Unitree robots as a source of state: motors become joints by the configured order,
 * the IMU becomes orientation and angular velocity of a floating base. Read only: nothing is ever
 * written to a topic of the robot.
 */
#include "dds/ros2/ros2_internal.h"

#include "dds/ros2/unitree_crc.h"

#include <string.h>

/* What both kinds of LowState have. */
typedef struct low_state {
    uint32_t crc, expected; /* sent; of the contents */
    uint32_t tick;          /* ms */
    const float *quaternion, *gyroscope;
    uint32_t motors;
    double q[ROS2_MOTORS_MAX], v[ROS2_MOTORS_MAX], tau[ROS2_MOTORS_MAX];
} low_state;

/* The IMU sits in the root link, whose axes it has. Position and linear velocity are unknown; they
 * change neither joint accelerations nor inertias. Quaternion w x y z. */
static ros2_base base_of(const low_state *s, int64_t now)
{
    const float *o = s->quaternion, *w = s->gyroscope;
    return (ros2_base){.pose = {0, 0, 0, (double)o[1], (double)o[2], (double)o[3], (double)o[0]},
                       .twist = {0, 0, 0, (double)w[0], (double)w[1], (double)w[2]},
                       .received = now};
}

static void merge_motors(ros2_input *in, const low_state *s, int64_t now)
{
    const ros2_robot *robot = in->robot;
    const ros2_arrays *a = robot->arrays;
    const char *name[ROS2_MOTORS_MAX];
    double position[ROS2_MOTORS_MAX], velocity[ROS2_MOTORS_MAX], effort[ROS2_MOTORS_MAX];
    uint32_t count = 0;
    for (uint32_t k = 0; k < robot->motors.count && k < s->motors; k++) {
        if (a->motor_joint[k] < 0)
            continue;
        name[count] = a->names[a->motor_joint[k]];
        position[count] = s->q[k];
        velocity[count] = s->v[k];
        effort[count++] = s->tau[k];
    }
    const tfa_joint_message message = {.name = name,
                                       .name_count = count,
                                       .value = {position, velocity, effort},
                                       .value_count = {count, count, count}};
    (void)ros2_merge(in, a->state, &message, robot->state_values, now);
}

/* A robot that starts anew counts from 0: it was silent for longer than this. */
#define TICK_REST_NS INT64_C(1000000000)

/* Older than the last state, in a count that wraps: replayed, or overtaken on its way. */
static bool runs_backwards(const ros2_robot *robot, uint32_t tick, int64_t now)
{
    return robot->tick_received != 0 && now - robot->tick_received < TICK_REST_NS &&
           tick - robot->tick > UINT32_MAX / 2;
}

static void read_low_state(ros2_input *in, const low_state *s, int64_t now)
{
    ros2_robot *robot = in->robot;
    if (s->crc != s->expected) {
        ros2_refuse(in, "crc 0x%08x, its contents have 0x%08x", s->crc, s->expected);
        return;
    }
    if (runs_backwards(robot, s->tick, now)) {
        ros2_refuse(in, "tick %u after tick %u: an old state, or two robots on one topic", s->tick,
                    robot->tick);
        return;
    }
    robot->tick = s->tick;
    robot->tick_received = now;
    merge_motors(in, s, now);
    robot->base = base_of(s, now);
    /* the tick of the robot is the only time that there is */
    const ros2_header header = {.sec = (int32_t)(s->tick / 1000),
                                .nanosec = s->tick % 1000 * 1000000u};
    ros2_take_state(robot, &header, now);
}

/* A LowState of either kind as a low_state. */
#define LOW_STATE_OF(m, crc_of)                                                                    \
    {                                                                                              \
        .crc = (m)->crc, .expected = crc_of(m), .tick = (m)->tick,                                 \
        .quaternion = (m)->imu_state.quaternion, .gyroscope = (m)->imu_state.gyroscope,            \
        .motors = sizeof(m)->motor_state / sizeof(m)->motor_state[0],                              \
    }

void ros2_read_low_state_go(ros2_input *in, const void *sample, int64_t now)
{
    const unitree_go_msg_dds__LowState_ *m = sample;
    low_state s = LOW_STATE_OF(m, tfa_unitree_go_crc);
    for (uint32_t k = 0; k < s.motors; k++) {
        s.q[k] = (double)m->motor_state[k].q;
        s.v[k] = (double)m->motor_state[k].dq;
        s.tau[k] = (double)m->motor_state[k].tau_est;
    }
    read_low_state(in, &s, now);
}

void ros2_read_low_state_hg(ros2_input *in, const void *sample, int64_t now)
{
    const unitree_hg_msg_dds__LowState_ *m = sample;
    low_state s = LOW_STATE_OF(m, tfa_unitree_hg_crc);
    for (uint32_t k = 0; k < s.motors; k++) {
        s.q[k] = (double)m->motor_state[k].q;
        s.v[k] = (double)m->motor_state[k].dq;
        s.tau[k] = (double)m->motor_state[k].tau_est;
    }
    read_low_state(in, &s, now);
}
