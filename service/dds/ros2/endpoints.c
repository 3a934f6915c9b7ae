/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Readers and writers with the names, QoS, encoding and user data of rmw_cyclonedds.
 *
 * Inputs are asked for best effort, which matches publishers of either kind; robot_description is
 * transient local as robot_state_publisher offers it. Answers are offered reliable, which matches
 * subscribers of either kind; writers keep the last samples, and so never wait.
 */
#include "dds/ros2/ros2_internal.h"

#include "dds/ros2/type_hash.h"

#include <stdio.h>
#include <string.h>

#define STATE_DEPTH 32  /* messages of several publishers until the gateway's thread runs */
#define ANSWER_DEPTH 10 /* default of ROS 2 */
/* Names that a message may have besides four for each joint of the robot: other robots share its
 * topic. */
#define NAMES_MORE 256
#define NAME_LENGTH_MAX 256

typedef struct endpoint {
    const dds_topic_descriptor_t *type;
    bool reliable, transient_local;
    int32_t depth;
} endpoint;

static const endpoint inputs[ROS2_INPUT_KINDS] = {
    [ROS2_ROBOT_DESCRIPTION] = {&std_msgs_msg_dds__String__desc, true, true, 1},
    [ROS2_JOINT_STATES] = {&sensor_msgs_msg_dds__JointState__desc, false, false, STATE_DEPTH},
    [ROS2_LOW_STATE_GO] = {&unitree_go_msg_dds__LowState__desc, false, false, 1},
    [ROS2_LOW_STATE_HG] = {&unitree_hg_msg_dds__LowState__desc, false, false, 1},
    [ROS2_ODOMETRY] = {&nav_msgs_msg_dds__Odometry__desc, false, false, 1},
    [ROS2_WRENCH] = {&geometry_msgs_msg_dds__WrenchStamped__desc, false, false, 1},
    [ROS2_CONSTRAINTS] = {&std_msgs_msg_dds__String__desc, false, false, 1},
    [ROS2_EFFORT_COMMANDS] = {&std_msgs_msg_dds__Float64MultiArray__desc, false, false,
                              STATE_DEPTH},
    [ROS2_JOINT_EFFORTS] = {&sensor_msgs_msg_dds__JointState__desc, false, false, STATE_DEPTH},
    [ROS2_FORWARD_DYNAMICS] = {&totalforce_msgs_srv_dds__ForwardDynamics_Request__desc, true, false,
                               ANSWER_DEPTH},
    [ROS2_TRAJECTORY] = {&trajectory_msgs_msg_dds__JointTrajectory__desc, false, false, 4},
};

static const endpoint outputs[ROS2_OUTPUT_KINDS] = {
    [ROS2_ACCELERATIONS] = {&trajectory_msgs_msg_dds__JointTrajectory__desc, true, false,
                            ANSWER_DEPTH},
    [ROS2_CONSTRAINT_WRENCHES] = {&sensor_msgs_msg_dds__MultiDOFJointState__desc, true, false,
                                  ANSWER_DEPTH},
    [ROS2_GRAVITY_TORQUES] = {&sensor_msgs_msg_dds__JointState__desc, true, false, ANSWER_DEPTH},
    [ROS2_EXTERNAL_TORQUES] = {&sensor_msgs_msg_dds__JointState__desc, true, false, ANSWER_DEPTH},
    [ROS2_EXTERNAL_BASE_WRENCH] = {&geometry_msgs_msg_dds__WrenchStamped__desc, true, false,
                                   ANSWER_DEPTH},
    [ROS2_EXTERNAL_WRENCH] = {&geometry_msgs_msg_dds__WrenchStamped__desc, true, false,
                              ANSWER_DEPTH},
    [ROS2_LAMBDA_INV] = {&std_msgs_msg_dds__Float64MultiArray__desc, true, false, ANSWER_DEPTH},
    [ROS2_JACOBIAN] = {&std_msgs_msg_dds__Float64MultiArray__desc, true, false, ANSWER_DEPTH},
    [ROS2_BIAS_ACCELERATION] = {&std_msgs_msg_dds__Float64MultiArray__desc, true, false,
                                ANSWER_DEPTH},
};

uint32_t ros2_name_limit(uint32_t joints)
{
    return 4 * joints + NAMES_MORE;
}

const dds_topic_descriptor_t *ros2_input_type(ros2_input_kind kind)
{
    return inputs[kind].type;
}

/* ---- filters: in Cyclone's receiving thread ---- */

static bool have_few_names(char *const *name, uint32_t count, uint32_t limit)
{
    if (count > limit)
        return false;
    for (uint32_t k = 0; k < count; k++)
        if (strnlen(name[k], NAME_LENGTH_MAX + 1) > NAME_LENGTH_MAX)
            return false;
    return true;
}

static bool is_short_state(const sensor_msgs_msg_dds__JointState_ *m, uint32_t limit)
{
    return have_few_names(m->name._buffer, m->name._length, limit) &&
           m->position._length <= limit && m->velocity._length <= limit &&
           m->effort._length <= limit;
}

static bool is_short_array(const std_msgs_msg_dds__Float64MultiArray_ *m, uint32_t limit)
{
    if (m->layout.dim._length > 8)
        return false;
    for (uint32_t k = 0; k < m->layout.dim._length; k++)
        if (strlen(m->layout.dim._buffer[k].label) > (size_t)limit * NAME_LENGTH_MAX)
            return false;
    return m->data._length <= limit;
}

/* Only the first point is read; a trajectory may have many. */
static bool is_short_trajectory(const trajectory_msgs_msg_dds__JointTrajectory_ *m, uint32_t limit)
{
    if (!have_few_names(m->joint_names._buffer, m->joint_names._length, limit) ||
        m->points._length > 1024)
        return false;
    for (uint32_t k = 0; k < m->points._length; k++) {
        const trajectory_msgs_msg_dds__JointTrajectoryPoint_ *p = &m->points._buffer[k];
        if (p->positions._length > limit || p->velocities._length > limit ||
            p->accelerations._length > limit || p->effort._length > limit)
            return false;
    }
    return true;
}

/* All constraints, each between blanks */
static bool is_short_text(const std_msgs_msg_dds__String_ *m)
{
    const size_t limit = (size_t)TFA_MAX_CONSTRAINTS * (NAME_LENGTH_MAX + 1);
    return strnlen(m->data, limit + 1) <= limit;
}

/* Others have a size of their own, or one message is kept: MaxSampleSize bounds it. */
static bool is_short(const ros2_input *input, const void *sample)
{
    const uint32_t limit = atomic_load_explicit(&input->name_limit, memory_order_relaxed);
    switch (input->kind) {
    case ROS2_JOINT_STATES:
    case ROS2_JOINT_EFFORTS:
        return is_short_state(sample, limit);
    case ROS2_CONSTRAINTS:
        return is_short_text(sample);
    case ROS2_EFFORT_COMMANDS:
        return is_short_array(sample, limit);
    case ROS2_TRAJECTORY:
        return is_short_trajectory(sample, limit);
    case ROS2_FORWARD_DYNAMICS:
        return is_short_state(
            &((const totalforce_msgs_srv_dds__ForwardDynamics_Request_ *)sample)->state, limit);
    default:
        return true;
    }
}

static bool filter(const void *sample, void *arg)
{
    ros2_input *input = arg;
    if (is_short(input, sample))
        return true;
    atomic_fetch_add_explicit(&input->oversized, 1, memory_order_relaxed);
    return false;
}

/* ---- entities ---- */

static dds_qos_t *make_qos(const endpoint *e)
{
    static const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
    const char *user_data = tfa_ros2_user_data(e->type->m_typename);
    dds_qos_t *qos = dds_create_qos();
    if (!qos)
        return NULL;
    dds_qset_reliability(qos, e->reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         0);
    dds_qset_durability(qos, e->transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL
                                                : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, e->depth);
    dds_qset_writer_data_lifecycle(qos, false);
    dds_qset_data_representation(qos, 1, &xcdr1);
    if (user_data)
        dds_qset_userdata(qos, user_data, strlen(user_data));
    return qos;
}

/* Topics are rt/NAME, services rq/NAMERequest and rr/NAMEReply; that of the graph has no prefix. */
static dds_entity_t make_topic(dds_entity_t participant, const endpoint *e, const char *prefix,
                               const char *name, const char *suffix)
{
    char topic[TFA_ROS2_NAME_MAX + 16];
    snprintf(topic, sizeof topic, "%s%s%s", prefix, name, suffix);
    return dds_create_topic(participant, e->type, topic, NULL, NULL);
}

/* The entity itself, or why it was not made. */
static dds_entity_t make_writer(dds_entity_t participant, const endpoint *e, const char *prefix,
                                const char *name, const char *suffix)
{
    const dds_entity_t topic = make_topic(participant, e, prefix, name, suffix);
    if (topic < 0)
        return topic;
    dds_qos_t *qos = make_qos(e);
    if (!qos)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    const dds_entity_t writer = dds_create_writer(participant, topic, qos, NULL);
    dds_delete_qos(qos);
    return writer;
}

dds_entity_t ros2_make_reader(dds_entity_t participant, ros2_input *input)
{
    const endpoint *e = &inputs[input->kind];
    const struct dds_topic_filter few = {
        .mode = DDS_TOPIC_FILTER_SAMPLE_ARG, .f.sample_arg = filter, .arg = input};
    const bool service = input->kind == ROS2_FORWARD_DYNAMICS;
    const dds_entity_t topic =
        make_topic(participant, e, service ? "rq" : "rt", input->name, service ? "Request" : "");
    if (topic < 0)
        return topic;
    const dds_return_t code = dds_set_topic_filter_extended(topic, &few);
    if (code < 0)
        return code;
    dds_qos_t *qos = make_qos(e);
    if (!qos)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
    dds_delete_qos(qos);
    return reader;
}

dds_entity_t ros2_make_writer(dds_entity_t participant, ros2_output_kind kind, const char *name)
{
    return make_writer(participant, &outputs[kind], "rt", name, "");
}

dds_entity_t ros2_make_reply_writer(dds_entity_t participant, const char *name)
{
    static const endpoint reply = {&totalforce_msgs_srv_dds__ForwardDynamics_Response__desc, true,
                                   false, ANSWER_DEPTH};
    return make_writer(participant, &reply, "rr", name, "Reply");
}

dds_entity_t ros2_make_diagnostics_writer(dds_entity_t participant)
{
    static const endpoint diagnostics = {&diagnostic_msgs_msg_dds__DiagnosticArray__desc, true,
                                         false, ANSWER_DEPTH};
    return make_writer(participant, &diagnostics, "rt", "/diagnostics", "");
}

dds_entity_t ros2_make_graph_writer(dds_entity_t participant, bool humble)
{
    dds_topic_descriptor_t type = humble
                                      ? rmw_dds_common_msg_dds__HumbleParticipantEntitiesInfo__desc
                                      : rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
    const endpoint graph = {&type, true, true, 1};
    type.m_typename = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc.m_typename;
    return make_writer(participant, &graph, "", "ros_discovery_info", "");
}
