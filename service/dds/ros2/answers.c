/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers of the ROS 2 gateway. Every input that an answer needs must have been received within its
 * limit of age: nothing is extrapolated, and a refusal names the joint, link or topic.
 */
#include "dds/ros2/ros2_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- inputs of a request ---- */

/* Counts why an answer is not given. @return false */
__attribute__((format(printf, 2, 3))) static bool refuse(ros2_robot *robot, const char *format, ...)
{
    va_list arguments;
    robot->counts.refused++;
    va_start(arguments, format);
    vsnprintf(robot->counts.refusal, sizeof robot->counts.refusal, format, arguments);
    va_end(arguments);
    return false;
}

/* Joint values that an answer reads. */
typedef struct joint_source {
    tfa_joint_inputs *inputs;
    int64_t age; /* ns, at most */
} joint_source;

/* Reads one value of all joints. */
static bool read_joints(ros2_robot *robot, const joint_source *from, tfa_joint_value value,
                        int64_t now, double *out)
{
    if (tfa_joint_inputs_read(from->inputs, value, now, from->age, out))
        return true;
    robot->counts.refused++;
    ros2_fault_text(from->inputs, robot->counts.refusal, sizeof robot->counts.refusal);
    return false;
}

static bool is_fresh(int64_t received, int64_t age, int64_t now)
{
    return received != 0 && now - received <= age;
}

static bool read_base(ros2_robot *robot, int64_t now, tfa_request *request)
{
    const ros2_base *base = &robot->base;
    if (!robot->arrays->base)
        return true;
    if (!is_fresh(base->received, robot->state_age, now))
        return refuse(robot, "floating base: pose and twist %s",
                      base->received ? "are too old" : "were never received");
    request->base_pose = base->pose;
    request->base_twist = base->twist;
    return true;
}

static bool read_wrenches(ros2_robot *robot, int64_t now, tfa_request *request,
                          double wrenches[TFA_MAX_WRENCHES][6])
{
    const uint32_t count = robot->wrench_links.count;
    for (uint32_t k = 0; k < count; k++) {
        const ros2_wrench *w = &robot->wrenches[k];
        if (!is_fresh(w->received, robot->state_age, now))
            return refuse(robot, "link '%.60s': wrench %s", robot->wrench_links.text[k],
                          w->received ? "is too old" : "was never received");
        memcpy(wrenches[k], w->value, sizeof w->value);
        request->wrench_frames[k] = robot->arrays->wrench_frames[k];
    }
    request->wrench_count = count;
    request->wrenches = count ? wrenches[0] : NULL;
    return true;
}

/* Without active ones it is forward dynamics: a robot in flight. */
static bool read_constraints(ros2_robot *robot, int64_t now, tfa_request *request)
{
    const ros2_active *active = &robot->active;
    ros2_arrays *a = robot->arrays;
    if (!robot->constrained)
        return true;
    if (active->received && !is_fresh(active->received, robot->state_age, now))
        return refuse(robot, "active constraints: the last message is too old");
    a->constraints = active->received ? active->bits : a->default_constraints;
    request->constraints = a->constraints;
    if (a->constraints)
        request->op = TFA_OP_CONSTRAINED_DYNAMICS;
    return true;
}

/* ---- computing and writing ---- */

static void record_answer(ros2_counts *counts, const tfa_answer *answer)
{
    counts->method = answer->method;
    if (answer->flags & TFA_ANSWER_FALLBACK)
        counts->fallbacks++;
    if (answer->flags & TFA_ANSWER_ESTIMATED) {
        counts->estimates++;
        if (answer->error_estimate > counts->largest_estimate)
            counts->largest_estimate = answer->error_estimate;
    }
}

static bool solve(ros2_robot *robot, tfa_request *request, const tfa_reply *reply, int64_t now)
{
    const gateway_stamps stamps = {.received = (uint64_t)now};
    tfa_worker_call call = {.reply = *reply};
    tfa_answer answer;
    if (!reply->answers)
        call.reply.answers = &answer; /* for the statistics */
    const int status = gateway_solve(&robot->own, request, &stamps, &call);
    gateway_count(&robot->own, TFA_SOURCE_ROS2, request, &stamps, &call);
    if (status != TFA_OK)
        return refuse(robot, "%s%s%s", tfa_status_text(status), call.reply.field ? ": " : "",
                      tfa_field_name(call.reply.field));
    if (reply->answers)
        record_answer(&robot->counts, reply->answers);
    return true;
}

static void publish(ros2_robot *robot, ros2_output_kind kind, const void *message)
{
    if (dds_write(robot->writers[kind], message) != DDS_RETCODE_OK)
        robot->counts.dropped++;
}

static void set_header(std_msgs_msg_dds__Header_ *to, const ros2_header *from)
{
    to->stamp.sec = from->sec;
    to->stamp.nanosec = from->nanosec;
    to->frame_id = (char *)(uintptr_t)from->frame; /* only read */
}

/* ---- commands ---- */

static bool compute_accelerations(ros2_robot *robot, const joint_source *state,
                                  const joint_source *command, int64_t now)
{
    ros2_arrays *a = robot->arrays;
    double wrenches[TFA_MAX_WRENCHES][6];
    tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .refine = TFA_REFINE_DEFAULT,
                           .frame = TFA_FRAME_LOCAL,
                           .count = 1,
                           .q = a->q,
                           .v = a->v,
                           .tau = a->tau};
    const tfa_reply reply = {.qdd = a->qdd,
                             .base_acceleration = a->base ? a->base_acceleration : NULL,
                             .constraint_wrenches = a->constraint_wrench[0],
                             .answers = &a->answer};
    return read_joints(robot, state, TFA_JOINT_POSITION, now, a->q) &&
           read_joints(robot, state, TFA_JOINT_VELOCITY, now, a->v) &&
           read_joints(robot, command, TFA_JOINT_EFFORT, now, a->tau) &&
           read_base(robot, now, &request) && read_wrenches(robot, now, &request, wrenches) &&
           read_constraints(robot, now, &request) && solve(robot, &request, &reply, now);
}

static void publish_constraint_wrenches(ros2_robot *robot, const ros2_header *header)
{
    ros2_arrays *a = robot->arrays;
    uint32_t count = 0;
    for (uint32_t left = a->constraints; left; left &= left - 1)
        a->constraint_name[count++] =
            (char *)(uintptr_t)tfa_model_constraint(a->model, (uint32_t)__builtin_ctz(left)).name;
    a->constraint_wrenches.joint_names._length = a->constraint_wrenches.wrench._length = count;
    set_header(&a->constraint_wrenches.header, header);
    publish(robot, ROS2_CONSTRAINT_WRENCHES, &a->constraint_wrenches);
}

void ros2_answer_command(ros2_robot *robot, const ros2_header *header, int64_t now)
{
    const joint_source state = {robot->arrays->state, robot->state_age};
    const joint_source command = {robot->arrays->command, robot->command_age};
    if (!ros2_leads(robot) || !compute_accelerations(robot, &state, &command, now))
        return;
    set_header(&robot->arrays->accelerations.header, header);
    publish(robot, ROS2_ACCELERATIONS, &robot->arrays->accelerations);
    if (robot->constrained)
        publish_constraint_wrenches(robot, header);
    robot->counts.answers++;
}

/* ---- the service ---- */

/* State and efforts come with the call; base, wrenches and constraints are those of the topics. */
void ros2_answer_call(ros2_input *in, const void *sample, int64_t now)
{
    const totalforce_msgs_srv_dds__ForwardDynamics_Request_ *call = sample;
    ros2_robot *robot = in->robot;
    ros2_arrays *a = robot->arrays;
    const joint_source source = {a->call, 0};
    const tfa_joint_message message = ros2_message_of(&call->state);
    totalforce_msgs_srv_dds__ForwardDynamics_Response_ reply = {
        .guid = call->guid, .seq = call->seq, .message = robot->counts.refusal};
    if (!ros2_leads(robot))
        return;
    tfa_joint_inputs_forget(a->call); /* of the call before */
    (void)ros2_merge(in, a->call, &message, ROS2_STATE_VALUES | 1u << TFA_JOINT_EFFORT, now);
    if (tfa_joint_inputs_outcome(a->call).fault != TFA_JOINT_FAULT_COUNT) {
        reply.message = in->error;
    } else if (compute_accelerations(robot, &source, &source, now)) {
        reply.success = true;
        reply.message = (char *)(uintptr_t) ""; /* only read */
        reply.name = a->accelerations.joint_names;
        reply.acceleration = a->point.accelerations;
        robot->counts.answers++;
    }
    if (dds_write(robot->reply_writer, &reply) != DDS_RETCODE_OK)
        robot->counts.dropped++;
}

/* ---- states ---- */

static bool is_read(const ros2_robot *robot, ros2_output_kind kind)
{
    dds_publication_matched_status_t status;
    return robot->writers[kind] > 0 &&
           dds_get_publication_matched_status(robot->writers[kind], &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
}

/* "stamp 12.000000034 frame base_link"; no formatted print: this is the path of an answer. */
static void write_label(char *label, const ros2_header *header)
{
    char digits[16], *at = stpcpy(label, "stamp ");
    int64_t sec = header->sec < 0 ? -(int64_t)header->sec : header->sec;
    int count = 0;
    if (header->sec < 0)
        *at++ = '-';
    do
        digits[count++] = (char)('0' + sec % 10);
    while ((sec /= 10) != 0);
    while (count > 0)
        *at++ = digits[--count];
    *at++ = '.';
    for (uint32_t unit = 100000000; unit > 0; unit /= 10)
        *at++ = (char)('0' + header->nanosec / unit % 10);
    stpcpy(stpcpy(at, " frame "), header->frame);
}

static void answer_gravity(ros2_robot *robot, int64_t now)
{
    ros2_arrays *a = robot->arrays;
    tfa_request request = {.op = TFA_OP_BIAS, .refine = TFA_REFINE_DEFAULT, .count = 1, .q = a->q};
    const tfa_reply reply = {.gravity_force = a->gravity};
    if (!read_base(robot, now, &request) || !solve(robot, &request, &reply, now))
        return;
    set_header(&a->gravity_torques.header, &robot->state_header);
    publish(robot, ROS2_GRAVITY_TORQUES, &a->gravity_torques);
}

/* Lambda^-1, the Jacobian and, where velocities are there, the bias acceleration of the tips. */
static void answer_tips(ros2_robot *robot, int64_t now)
{
    ros2_arrays *a = robot->arrays;
    const bool bias = is_read(robot, ROS2_BIAS_ACCELERATION);
    tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                           .refine = TFA_REFINE_DEFAULT,
                           .flags = TFA_WANT_JACOBIAN,
                           .count = 1,
                           .tip_count = a->tip_count,
                           .q = a->q};
    tfa_reply reply = {.lambda_inv = a->lambda_inv, .jacobian = a->jacobian, .answers = &a->answer};
    memcpy(request.tips, a->tips, sizeof request.tips);
    const joint_source state = {a->state, robot->state_age};
    if (bias && read_joints(robot, &state, TFA_JOINT_VELOCITY, now, a->v)) {
        request.flags |= TFA_WANT_BIAS_ACCELERATION;
        request.v = a->v;
        reply.bias_acceleration = a->bias;
    }
    if (!read_base(robot, now, &request) || !solve(robot, &request, &reply, now))
        return;
    write_label(a->stamp_label, &robot->state_header);
    publish(robot, ROS2_LAMBDA_INV, &a->array[ROS2_LAMBDA_INV]);
    publish(robot, ROS2_JACOBIAN, &a->array[ROS2_JACOBIAN]);
    if (reply.bias_acceleration)
        publish(robot, ROS2_BIAS_ACCELERATION, &a->array[ROS2_BIAS_ACCELERATION]);
}

void ros2_answer_state(ros2_robot *robot, int64_t now)
{
    const bool gravity = is_read(robot, ROS2_GRAVITY_TORQUES);
    const bool tips = is_read(robot, ROS2_LAMBDA_INV) || is_read(robot, ROS2_JACOBIAN) ||
                      is_read(robot, ROS2_BIAS_ACCELERATION);
    const joint_source state = {robot->arrays->state, robot->state_age};
    if ((!gravity && !tips) || !ros2_leads(robot) ||
        !read_joints(robot, &state, TFA_JOINT_POSITION, now, robot->arrays->q))
        return;
    if (gravity)
        answer_gravity(robot, now);
    if (tips)
        answer_tips(robot, now);
    robot->counts.states++;
}

/* ---- the observer ---- */

/* No request of a client: neither recorded nor counted. */
static void ask_for_observer(const ros2_robot *robot, tfa_request *request, tfa_reply *reply)
{
    request->estimate = TFA_ESTIMATE_NEVER;
    request->frame = TFA_FRAME_LOCAL;
    request->q = robot->arrays->q;
    reply->status = robot->own.solver.solve(robot->own.solver.self, request, reply, 0, 1);
}

static void note_event(ros2_observed *w, tfa_observer_event event, double gap)
{
#define WORD(value, word) [value] = (word),
    static const char *const words[] = {TFA_OBSERVER_WORDS(WORD)};
    w->samples++;
    if (event != TFA_OBSERVER_UPDATED && (event != TFA_OBSERVER_STARTED || w->start)) {
        w->restarts++;
        w->event = event;
        w->reason = event == TFA_OBSERVER_STARTED ? w->start : words[event];
        w->gap = gap;
    }
    w->start = NULL;
}

/* A jump of the stamps restarts it however far it is: bounded, it costs later times no digits. */
static tfa_observer_event update_observer(ros2_robot *robot, const tfa_reply *reply)
{
    ros2_observed *w = &robot->observed;
    const ros2_header *h = &robot->state_header;
    const int64_t sent = INT64_C(1000000000) * h->sec + h->nanosec,
                  stamp = sent ? sent : tfa_dds_monotonic();
    const double step = 1e-9 * (double)(stamp - w->stamp), gap = w->samples ? step : 0;
    w->stamp = stamp;
    w->time += fmax(-1, fmin(step, 2 * robot->observer.max_gap));
    const tfa_observer_event event =
        tfa_observer_update(robot->arrays->observer, w->time, robot->arrays->tau, NULL, reply);
    note_event(w, event, gap);
    return event;
}

static void publish_wrench(ros2_robot *robot, ros2_output_kind kind, const double value[6],
                           geometry_msgs_msg_dds__WrenchStamped_ *message)
{
    message->header.stamp.sec = robot->state_header.sec;
    message->header.stamp.nanosec = robot->state_header.nanosec;
    memcpy(&message->wrench, value, sizeof message->wrench);
    publish(robot, kind, message);
}

/* 0 after a restart, even where the state has no answer. */
static void answer_wrench(ros2_robot *robot, tfa_observer_event event, int64_t now)
{
    ros2_arrays *a = robot->arrays;
    double wrench[6] = {0};
    tfa_request request;
    tfa_reply reply;
    tfa_observer_wrench_request(a->observer, a->observer_tip, &request, &reply);
    if (event == TFA_OBSERVER_UPDATED) {
        if (!read_base(robot, now, &request))
            return;
        request.base_twist = NULL; /* at rest */
        ask_for_observer(robot, &request, &reply);
        const int status = tfa_observer_wrench(a->observer, &reply, wrench);
        if (status != TFA_OK) {
            (void)refuse(robot, "external_wrench: %s", tfa_status_text(status));
            return;
        }
    }
    publish_wrench(robot, ROS2_EXTERNAL_WRENCH, wrench, &a->external_wrench);
}

static void take_sample(ros2_robot *robot, int64_t now)
{
    ros2_arrays *a = robot->arrays;
    const joint_source state = {a->state, robot->state_age};
    double wrenches[TFA_MAX_WRENCHES][6];
    tfa_request request;
    tfa_reply reply;
    tfa_observer_request(a->observer, &request, &reply);
    request.v = a->v;
    if (!read_joints(robot, &state, TFA_JOINT_POSITION, now, a->q) ||
        !read_joints(robot, &state, TFA_JOINT_VELOCITY, now, a->v) ||
        !read_joints(robot, &state, TFA_JOINT_EFFORT, now, a->tau) ||
        !read_base(robot, now, &request) || !read_wrenches(robot, now, &request, wrenches))
        return;
    ask_for_observer(robot, &request, &reply);
    const tfa_observer_event event = update_observer(robot, &reply);
    set_header(&a->external_torques.header, &robot->state_header);
    publish(robot, ROS2_EXTERNAL_TORQUES, &a->external_torques);
    if (a->base && is_read(robot, ROS2_EXTERNAL_BASE_WRENCH))
        publish_wrench(robot, ROS2_EXTERNAL_BASE_WRENCH, tfa_observer_torques(a->observer),
                       &a->external_base_wrench);
    if (is_read(robot, ROS2_EXTERNAL_WRENCH))
        answer_wrench(robot, event, now);
}

void ros2_observe(ros2_robot *robot, int64_t now)
{
    robot->observed.states++;
    if (!ros2_leads(robot)) {
        tfa_observer_restart(robot->arrays->observer);
        robot->observed.start = "takeover";
    } else if (tfa_joint_inputs_renewed(robot->arrays->state, ROS2_OBSERVED_VALUES)) {
        take_sample(robot, now);
    }
}
