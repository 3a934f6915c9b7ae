/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transport over topics of ROS 2: a request is a joint state and efforts by name, with the number
 * of the request as their stamp; the answer has the stamp of its efforts. The daemon's times are
 * not told: the whole round trip counts as reply.
 */
#include "open.h"

#include <dds/dds.h>
#include <idl/ros2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Discovery of the daemon's node, and of this one by the daemon */
static const uint64_t discovery_ns = 5000000000, pause_ns = 10000000, probe_ns = 1000000000;
static const uint32_t second = 1000000000;
enum { QUEUE_DEPTH = 10 };

typedef sensor_msgs_msg_dds__JointState_ joint_state;
typedef trajectory_msgs_msg_dds__JointTrajectory_ trajectory;

typedef struct ros2_transport {
    transport base;
    const latency_states *states;
    tfa_wait wait;
    dds_entity_t participant, state_writer, effort_writer, reader, waitset;
    joint_state state, efforts; /* their arrays belong to the states, but for the names */
    trajectory *answer;
    uint32_t joints;
    char **names;
    char frame[32]; /* of our messages, by which we know the answers to them */
} ros2_transport;

static ros2_transport *own(transport *t)
{
    return (ros2_transport *)(void *)t;
}

static void set_array(dds_sequence_double *array, const double *numbers, uint32_t count)
{
    *array = (dds_sequence_double){._maximum = count,
                                   ._length = count,
                                   ._buffer = (double *)(uintptr_t)numbers,
                                   ._release = false};
}

static int send_request(transport *t, uint64_t id, uint64_t index)
{
    ros2_transport *r = own(t);
    const tfa_request *request = &r->states->requests[index % r->states->sets];
    const builtin_interfaces_msg_dds__Time_ stamp = {.sec = (int32_t)(id / second),
                                                     .nanosec = (uint32_t)(id % second)};
    r->state.header.stamp = r->efforts.header.stamp = stamp;
    set_array(&r->state.position, request->q, r->joints);
    set_array(&r->state.velocity, request->v, r->joints);
    set_array(&r->efforts.effort, request->tau, r->joints);
    if (dds_write(r->state_writer, &r->state) != DDS_RETCODE_OK ||
        dds_write(r->effort_writer, &r->efforts) != DDS_RETCODE_OK)
        return TFA_E_SYSTEM;
    return TFA_OK;
}

static int take(ros2_transport *r, transport_answer *answer)
{
    void *sample[1] = {r->answer};
    dds_sample_info_t info;
    do
        if (dds_take(r->reader, sample, &info, 1, 1) != 1)
            return 0;
    while (!info.valid_data || strcmp(r->answer->header.frame_id, r->frame) != 0);
    const builtin_interfaces_msg_dds__Time_ *stamp = &r->answer->header.stamp;
    *answer = (transport_answer){.id = (uint64_t)stamp->sec * second + stamp->nanosec};
    return 1;
}

static int receive(transport *t, uint64_t until, transport_answer *answer)
{
    ros2_transport *r = own(t);
    for (;;) {
        if (take(r, answer))
            return TFA_OK;
        const uint64_t at = clock_ns();
        if (at >= until)
            return TFA_E_TIMEOUT;
        if (r->wait != TFA_WAIT_SPIN)
            (void)dds_waitset_wait(r->waitset, NULL, 0, (dds_duration_t)(until - at));
    }
}

static void idle(transport *t, uint64_t until)
{
    transport_sleep(own(t)->wait, until);
}

static int reconnect(transport *t)
{
    (void)t;
    return TFA_OK; /* topics have no connection */
}

static void close_transport(transport *t)
{
    ros2_transport *r = own(t);
    if (r->participant > 0)
        dds_delete(r->participant);
    for (uint32_t i = 0; r->names && i < r->joints; i++)
        free(r->names[i]);
    free(r->names);
    if (r->answer)
        dds_sample_free(r->answer, &trajectory_msgs_msg_dds__JointTrajectory__desc, DDS_FREE_ALL);
    free(r);
}

static const transport_operations operations = {.now = transport_clock,
                                                .send = send_request,
                                                .receive = receive,
                                                .idle = idle,
                                                .reconnect = reconnect,
                                                .close = close_transport};

/* ---- endpoints ---- */

static dds_qos_t *make_qos(void)
{
    static const dds_data_representation_id_t xcdr1[] = {DDS_DATA_REPRESENTATION_XCDR1};
    dds_qos_t *qos = dds_create_qos();
    if (!qos)
        return NULL;
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, QUEUE_DEPTH);
    dds_qset_writer_data_lifecycle(qos, false);
    dds_qset_data_representation(qos, 1, xcdr1);
    return qos;
}

static dds_entity_t make_topic(const ros2_transport *r, const dds_topic_descriptor_t *type,
                               const char *robot, const char *name)
{
    char topic[256];
    snprintf(topic, sizeof topic, "rt/%s/%s", robot, name);
    return dds_create_topic(r->participant, type, topic, NULL, NULL);
}

/* @return 0: one could not be made */
static int make_endpoints(ros2_transport *r, const char *robot)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    const dds_topic_descriptor_t *answer = &trajectory_msgs_msg_dds__JointTrajectory__desc;
    dds_qos_t *qos = make_qos();
    if (!qos)
        return 0;
    r->state_writer =
        dds_create_writer(r->participant, make_topic(r, state, robot, "joint_states"), qos, NULL);
    r->effort_writer =
        dds_create_writer(r->participant, make_topic(r, state, robot, "joint_efforts"), qos, NULL);
    r->reader = dds_create_reader(
        r->participant, make_topic(r, answer, robot, "totalforce/accelerations"), qos, NULL);
    dds_delete_qos(qos);
    r->waitset = dds_create_waitset(r->participant);
    r->answer = dds_alloc(sizeof *r->answer);
    if (r->state_writer <= 0 || r->effort_writer <= 0 || r->reader <= 0 || r->waitset <= 0 ||
        !r->answer)
        return 0;
    memset(r->answer, 0, sizeof *r->answer);
    const dds_entity_t condition = dds_create_readcondition(r->reader, DDS_ANY_STATE);
    return condition > 0 && dds_waitset_attach(r->waitset, condition, condition) == DDS_RETCODE_OK;
}

/* Whether the daemon's node is found, all three of its endpoints */
static int await_discovery(const ros2_transport *r, uint64_t end)
{
    while (clock_ns() < end) {
        dds_publication_matched_status_t states = {0}, efforts = {0};
        dds_subscription_matched_status_t answers = {0};
        (void)dds_get_publication_matched_status(r->state_writer, &states);
        (void)dds_get_publication_matched_status(r->effort_writer, &efforts);
        (void)dds_get_subscription_matched_status(r->reader, &answers);
        if (states.current_count && efforts.current_count && answers.current_count)
            return 1;
        transport_sleep(TFA_WAIT_BLOCK, clock_ns() + pause_ns);
    }
    return 0;
}

/* Waits for the daemon's node; timeout_ns 0: the default. It may find this one later than it is
 * found, and messages until then are lost: states in another frame are sent until one is
 * answered. */
static int await_daemon(ros2_transport *r, uint64_t timeout_ns)
{
    const uint64_t end = clock_ns() + (timeout_ns ? timeout_ns : discovery_ns);
    transport_answer answer;
    int answered = 0;
    snprintf(r->frame, sizeof r->frame, "probe-%d-%x", (int)getpid(), (unsigned)(uintptr_t)r);
    for (int found = await_discovery(r, end); found && !answered && clock_ns() < end;)
        answered = send_request(&r->base, clock_ns(), 0) == TFA_OK &&
                   receive(&r->base, clock_ns() + probe_ns, &answer) == TFA_OK;
    snprintf(r->frame, sizeof r->frame, "latency-%d-%x", (int)getpid(), (unsigned)(uintptr_t)r);
    return answered;
}

/* ---- the robot ---- */

/* Names of the joints for the messages. */
static int copy_names(ros2_transport *r, const tfa_client_info *info)
{
    r->names = calloc(info->joint_count + 1, sizeof *r->names);
    if (!r->names)
        return TFA_E_MEMORY;
    for (r->joints = 0; r->joints < info->joint_count; r->joints++)
        if (!(r->names[r->joints] = strdup(info->joint_names[r->joints])))
            return TFA_E_MEMORY;
    const dds_sequence_string names = {
        ._maximum = r->joints, ._length = r->joints, ._buffer = r->names, ._release = false};
    r->state.header.frame_id = r->efforts.header.frame_id = r->frame;
    r->state.name = r->efforts.name = names;
    return TFA_OK;
}

/* The robot as the daemon describes it over shared memory; draws the states by it. */
static int describe(ros2_transport *r, const latency_options *options, latency_states *states,
                    transport_facts *facts)
{
    daemon_link *link = NULL;
    char text[512];
    int status = daemon_connect(&options->daemon, DAEMON_SHM, &link);
    if (status != TFA_OK) {
        daemon_explain(&options->daemon, DAEMON_SHM, status, text, sizeof text);
        fprintf(stderr, "totalforce latency: %s\n", text);
        return status;
    }
    const tfa_client_info *info = daemon_info(link);
    if (info->base_freedoms || info->q_count != info->joint_count || options->batch != 1)
        status = TFA_E_UNSUPPORTED;
    if (status == TFA_OK && !states->requests)
        status = latency_states_init(states, options, info);
    if (status == TFA_OK)
        status = copy_names(r, info);
    facts->info = *info;
    snprintf(facts->hash, sizeof facts->hash, "%s", info->model_hash ? info->model_hash : "");
    facts->info.joint_names = facts->info.frame_names = NULL;
    facts->info.joint_types = NULL;
    facts->info.model_hash = NULL;
    facts->info.slots = QUEUE_DEPTH;
    daemon_close(link);
    if (status == TFA_E_UNSUPPORTED)
        fputs("totalforce latency: --via ros2: one state at a time, a fixed base and joints of one "
              "freedom only\n",
              stderr);
    return status;
}

int transport_ros2_open(const latency_options *options, latency_states *states, transport **t,
                        transport_facts *facts)
{
    ros2_transport *r = calloc(1, sizeof *r);
    if (!r)
        return TFA_E_MEMORY;
    *r = (ros2_transport){.base.ops = &operations, .states = states};
    int status = describe(r, options, states, facts);
    r->wait = facts->info.wait = options->daemon.wait ? options->daemon.wait : TFA_WAIT_BLOCK;
    if (status == TFA_OK) {
        r->participant = dds_create_participant(options->daemon.domain, NULL, NULL);
        status =
            r->participant > 0 && make_endpoints(r, options->daemon.robot) ? TFA_OK : TFA_E_SYSTEM;
        if (status == TFA_OK && !await_daemon(r, options->daemon.timeout_ns))
            status = TFA_E_TIMEOUT;
        if (status != TFA_OK)
            fprintf(
                stderr,
                "totalforce latency: --via ros2: no daemon answers on the topics /%s/joint_states, "
                "/%s/joint_efforts and /%s/totalforce/accelerations in domain %u\n",
                options->daemon.robot, options->daemon.robot, options->daemon.robot,
                options->daemon.domain);
    }
    if (status == TFA_OK)
        *t = &r->base;
    else
        close_transport(&r->base);
    return status;
}
