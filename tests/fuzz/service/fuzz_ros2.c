/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: messages of ROS 2 as Cyclone hands them over, with names, lengths and numbers
 * from any bytes, in any order and at any time. Whatever comes, an answer is computed from finite
 * numbers that are young enough, or not at all, and every message is counted.
 */
#include <math.h>
#include <string.h>

#include "dds/ros2/ros2_internal.h"
#include "fuzz_service.h"

#define JOINTS 7
#define NAMES 9 /* of a message at most */
#define AGE 100

typedef struct bytes {
    const uint8_t *at;
    size_t left;
} bytes;

static uint32_t next(bytes *b)
{
    if (b->left == 0)
        return 0;
    b->left--;
    return *b->at++;
}

static char *names[] = {"joint_1", "joint_2", "joint_3", "joint_4",  "joint_5", "joint_6",
                        "joint_7", "gripper", "",        "joint_1 ", "joint_10"};
static char *frames[] = {"", "tool0", "base", "link_4"};

static char *make_name(bytes *b)
{
    return names[next(b) % (sizeof names / sizeof *names)];
}

/* As many as there are names, or not. */
static dds_sequence_double make_numbers(bytes *b, double *numbers, uint32_t expected)
{
    static const double odd[] = {0, -0.0, 1e-320, 1e300, INFINITY, -INFINITY, NAN};
    const uint32_t choice = next(b);
    const uint32_t length = choice < 160 ? expected : choice < 224 ? 0 : choice % (NAMES + 1);
    for (uint32_t k = 0; k < length; k++) {
        const uint32_t x = next(b);
        numbers[k] = x < 240 ? 0.02 * ((double)x - 120) : odd[x % (sizeof odd / sizeof *odd)];
    }
    return (dds_sequence_double){length, length, length ? numbers : NULL, false};
}

static dds_sequence_string make_names(bytes *b, char **name)
{
    const uint32_t length = next(b) % (NAMES + 1);
    const bool in_order = next(b) % 4 != 0;
    for (uint32_t k = 0; k < length; k++)
        name[k] = in_order ? names[k] : make_name(b);
    return (dds_sequence_string){length, length, length ? name : NULL, false};
}

static std_msgs_msg_dds__Header_ make_header(bytes *b)
{
    return (std_msgs_msg_dds__Header_){{(int32_t)next(b), next(b)}, frames[next(b) % 4]};
}

static void read_state(bytes *b, ros2_input *in, int64_t now)
{
    static char *name[NAMES];
    static double q[NAMES], v[NAMES], tau[NAMES];
    sensor_msgs_msg_dds__JointState_ m = {.header = make_header(b), .name = make_names(b, name)};
    m.position = make_numbers(b, q, m.name._length);
    m.velocity = make_numbers(b, v, m.name._length);
    m.effort = make_numbers(b, tau, m.name._length);
    ros2_read_message(in, &m, now);
}

static void read_efforts(bytes *b, ros2_input *in, int64_t now)
{
    static double tau[NAMES];
    std_msgs_msg_dds__Float64MultiArray_ m = {.data = make_numbers(b, tau, JOINTS)};
    m.layout.data_offset = next(b) < 250 ? 0 : 1;
    ros2_read_message(in, &m, now);
}

static void read_trajectory(bytes *b, ros2_input *in, int64_t now)
{
    static char *name[NAMES];
    static double tau[NAMES];
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ point = {0};
    trajectory_msgs_msg_dds__JointTrajectory_ m = {.header = make_header(b),
                                                   .joint_names = make_names(b, name)};
    point.effort = make_numbers(b, tau, m.joint_names._length);
    m.points._length = m.points._maximum = next(b) < 250;
    m.points._buffer = m.points._length ? &point : NULL;
    ros2_read_message(in, &m, now);
}

static void read_wrench(bytes *b, ros2_input *in, int64_t now)
{
    double number[NAMES] = {0};
    geometry_msgs_msg_dds__WrenchStamped_ m = {.header = make_header(b)};
    (void)make_numbers(b, number, 6);
    m.wrench.force = (geometry_msgs_msg_dds__Vector3_){number[0], number[1], number[2]};
    m.wrench.torque = (geometry_msgs_msg_dds__Vector3_){number[3], number[4], number[5]};
    ros2_read_message(in, &m, now);
}

/* Every message in turn, some time after the one before. */
static void play(bytes *b, ros2_robot *robot)
{
    int64_t now = 1;
    while (b->left > 0) {
        ros2_input *in = &robot->inputs[next(b) % robot->input_count];
        now += next(b);
        switch (in->kind) {
        case ROS2_EFFORT_COMMANDS:
            read_efforts(b, in, now);
            break;
        case ROS2_TRAJECTORY:
            read_trajectory(b, in, now);
            break;
        case ROS2_WRENCH:
            read_wrench(b, in, now);
            break;
        default:
            read_state(b, in, now);
        }
        if (robot->state_is_new)
            ros2_answer_state(robot, now);
        robot->state_is_new = false;
    }
}

/* The solver sees only finite numbers. */
static int solve(void *workspace, tfa_request *request, tfa_reply *reply, uint32_t first,
                 uint32_t count)
{
    require(first == 0 && count == 1 && request->count == 1);
    for (uint32_t j = 0; j < JOINTS; j++) {
        require(isfinite(request->q[j]));
        require(!request->v || isfinite(request->v[j]));
        require(!request->tau || isfinite(request->tau[j]));
    }
    for (uint32_t k = 0; k < 6 * request->wrench_count; k++)
        require(isfinite(request->wrenches[k]));
    return tfa_compute(workspace, request, reply);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static tfa_workspace *workspace;
    const tfa_model *model = fuzz_model();
    static char tool[] = "tool0", *links[] = {tool};
    static const ros2_input_kind kinds[] = {ROS2_JOINT_STATES, ROS2_WRENCH, ROS2_EFFORT_COMMANDS,
                                            ROS2_JOINT_EFFORTS, ROS2_TRAJECTORY};
    static ros2_robot robot;
    static struct tfa_ros2 gateway;
    bytes b = {data, size};
    if (!workspace)
        require(tfa_workspace_create(model, NULL, &workspace) == TFA_OK);
    robot = (ros2_robot){.gateway = &gateway,
                         .state_age = AGE,
                         .command_age = AGE,
                         .wrench_links = {links, 1},
                         .input_count = sizeof kinds / sizeof *kinds,
                         .own.solver = {.solve = solve, .self = workspace}};
    for (uint32_t k = 0; k < robot.input_count; k++) {
        robot.inputs[k].kind = kinds[k];
        robot.inputs[k].robot = &robot;
    }
    robot.arrays = ros2_arrays_create(&robot, model);
    require(robot.arrays != NULL);
    play(&b, &robot);
    for (uint32_t k = 0; k < robot.input_count; k++)
        require(robot.inputs[k].refused <= robot.inputs[k].received);
    require(robot.counts.answers == robot.counts.dropped); /* there is no writer */
    ros2_arrays_free(robot.arrays);
    return 0;
}
