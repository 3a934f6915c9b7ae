/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Topic /diagnostics: the condition of each robot's inputs, model and answers, once a second.
 * Levels are about the time since the last message; counts are since the start.
 */
#include "dds/ros2/ros2_internal.h"

#include "platform/log.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LEVEL_OK, LEVEL_WARN, LEVEL_ERROR, LEVEL_STALE };

/* Publications that are looked at for a wrong type: a bound on the time that it takes */
#define PUBLICATIONS_MAX 256
#define VALUES_MAX 16
#define VALUE_LENGTH 176
#define NAME_LENGTH (2 * TFA_ROS2_NAME_MAX + 8)

/* The texts of one status. */
typedef struct texts {
    char name[NAME_LENGTH], message[256];
    char value[VALUES_MAX][VALUE_LENGTH];
    diagnostic_msgs_msg_dds__KeyValue_ pairs[VALUES_MAX];
} texts;

struct ros2_report {
    diagnostic_msgs_msg_dds__DiagnosticArray_ message;
    diagnostic_msgs_msg_dds__DiagnosticStatus_ *status;
    texts *texts;
    int64_t last;                         /* ns, when one was published */
    double seconds;                       /* since then */
    void *publications[PUBLICATIONS_MAX]; /* of the domain, on loan from Cyclone */
    dds_return_t publication_count;
};

void ros2_report_free(struct ros2_report *report)
{
    if (!report)
        return;
    free(report->status);
    free(report->texts);
    free(report);
}

struct ros2_report *ros2_report_create(const tfa_ros2 *gateway)
{
    struct ros2_report *report = calloc(1, sizeof *report);
    size_t count = 0;
    if (!report)
        return NULL;
    for (uint32_t i = 0; i < gateway->robot_count; i++)
        count += gateway->robots[i].input_count + 2u;
    report->status = calloc(count, sizeof *report->status);
    report->texts = calloc(count, sizeof *report->texts);
    if (report->status && report->texts)
        return report;
    ros2_report_free(report);
    return NULL;
}

/* ---- one status ---- */

typedef struct writer {
    diagnostic_msgs_msg_dds__DiagnosticStatus_ *status;
    texts *texts;
} writer;

static writer begin_status(struct ros2_report *r, const ros2_robot *robot, const char *what)
{
    const uint32_t k = r->message.status._length++;
    const writer w = {&r->status[k], &r->texts[k]};
    snprintf(w.texts->name, sizeof w.texts->name, "%s/%s: %s",
             strcmp(robot->node_namespace, "/") == 0 ? "" : robot->node_namespace, robot->node,
             what);
    *w.status = (diagnostic_msgs_msg_dds__DiagnosticStatus_){
        .name = w.texts->name,
        .message = w.texts->message,
        .hardware_id = (char *)(uintptr_t)robot->name, /* only read */
        .values._buffer = w.texts->pairs,
    };
    snprintf(w.texts->message, sizeof w.texts->message, "ok");
    return w;
}

__attribute__((format(printf, 3, 4))) static void add_value(const writer *w, const char *key,
                                                            const char *format, ...)
{
    const uint32_t k = w->status->values._length++;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(w->texts->value[k], VALUE_LENGTH, format, arguments);
    va_end(arguments);
    w->texts->pairs[k].key = (char *)(uintptr_t)key; /* only read */
    w->texts->pairs[k].value = w->texts->value[k];
}

/* The first thing that is wrong is said. */
__attribute__((format(printf, 3, 4))) static void set_level(const writer *w, uint8_t level,
                                                            const char *format, ...)
{
    va_list arguments;
    if (w->status->level != LEVEL_OK)
        return;
    w->status->level = level;
    va_start(arguments, format);
    vsnprintf(w->texts->message, sizeof w->texts->message, format, arguments);
    va_end(arguments);
}

static const char *policy_name(uint32_t id)
{
    switch (id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
        return "durability";
    case DDS_RELIABILITY_QOS_POLICY_ID:
        return "reliability";
    case DDS_OWNERSHIP_QOS_POLICY_ID:
        return "ownership";
    case DDS_DEADLINE_QOS_POLICY_ID:
        return "deadline";
    case DDS_LIVELINESS_QOS_POLICY_ID:
        return "liveliness";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
        return "data representation";
    case DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID:
        return "type consistency";
    default:
        return "another policy";
    }
}

/* ---- inputs ---- */

/* A publisher of another type does not match, and no status of the reader tells; it may be there
 * beside a right one. */
static bool find_other_type(const struct ros2_report *r, const ros2_input *in, char *type,
                            size_t size)
{
    const char *own = ros2_input_type(in->kind)->m_typename;
    bool found = false;
    for (int k = 0; k < r->publication_count && !found; k++) {
        const dds_builtintopic_endpoint_t *e = r->publications[k];
        if (strncmp(e->topic_name, "rt", 2) != 0 || strcmp(e->topic_name + 2, in->name) != 0 ||
            strcmp(e->type_name, own) == 0)
            continue;
        snprintf(type, size, "%.100s", e->type_name);
        found = true;
    }
    return found;
}

static uint32_t report_publishers(const tfa_ros2 *gateway, const writer *w, ros2_input *in)
{
    dds_subscription_matched_status_t matched = {0};
    dds_requested_incompatible_qos_status_t qos = {0};
    char type[128];
    (void)dds_get_subscription_matched_status(in->reader, &matched);
    (void)dds_get_requested_incompatible_qos_status(in->reader, &qos);
    in->publishers = matched.current_count;
    add_value(w, "publishers", "%u", matched.current_count);
    add_value(w, "incompatible publishers so far", "%u%s%s", qos.total_count,
              qos.total_count ? ", last by its QoS: " : "",
              qos.total_count ? policy_name(qos.last_policy_id) : "");
    if (qos.total_count_change || (qos.total_count && !matched.current_count))
        set_level(w, LEVEL_WARN, "a publisher offers a QoS that does not match: %s",
                  policy_name(qos.last_policy_id));
    if (find_other_type(gateway->report, in, type, sizeof type))
        set_level(w, LEVEL_WARN, "a publisher has the type %s; %s is expected", type,
                  ros2_input_type(in->kind)->m_typename);
    return matched.current_count;
}

/* The oldest value of all joints. */
static void report_ages(const writer *w, const ros2_robot *robot, int64_t now)
{
    static const char *const values[] = {"position", "velocity", "effort"};
    const ros2_arrays *a = robot->arrays;
    int64_t oldest = -1;
    uint32_t joint = 0, value = 0;
    for (uint32_t j = 0; j < a->joints; j++)
        for (uint32_t v = 0; v < TFA_JOINT_VALUE_COUNT && robot->state_values >> v & 1; v++) {
            const int64_t age = tfa_joint_inputs_age(a->state, j, (tfa_joint_value)v, now);
            if (age < 0) {
                set_level(w, LEVEL_ERROR, "joint '%s': no %s was received", a->names[j], values[v]);
            } else if (age > oldest) {
                oldest = age;
                joint = j;
                value = v;
            }
        }
    if (oldest < 0)
        return;
    if (oldest > robot->state_age)
        set_level(w, LEVEL_STALE, "joint '%s': %s is %.0f ms old, the limit is %.0f ms",
                  a->names[joint], values[value], 1e-6 * (double)oldest,
                  1e-6 * (double)robot->state_age);
    add_value(w, "oldest value", "%s of '%s', %.1f ms", values[value], a->names[joint],
              1e-6 * (double)oldest);
}

static void report_unknown(const writer *w, const tfa_joint_inputs *inputs)
{
    const tfa_joint_fault_record *f = tfa_joint_inputs_fault(inputs, TFA_JOINT_FAULT_UNKNOWN);
    add_value(w, "unknown joints", "%" PRIu64 "%s%s", f->count, f->count ? ", last: " : "",
              f->joint);
}

static bool gives_joint_states(ros2_input_kind kind)
{
    return kind == ROS2_JOINT_STATES || kind == ROS2_LOW_STATE_GO || kind == ROS2_LOW_STATE_HG;
}

static void report_input(const tfa_ros2 *gateway, ros2_input *in, int64_t now)
{
    const ros2_robot *robot = in->robot;
    struct ros2_report *r = gateway->report;
    const bool needed = !ros2_is_command(in->kind) && in->kind != ROS2_ROBOT_DESCRIPTION;
    const writer w = begin_status(r, robot, in->name);
    const uint64_t oversized = atomic_load_explicit(&in->oversized, memory_order_relaxed);
    const uint32_t publishers = report_publishers(gateway, &w, in);
    const uint8_t absent = needed ? LEVEL_STALE : LEVEL_OK;
    if (in->refused != in->refused_before)
        set_level(&w, LEVEL_WARN, "refused: %s", in->error);
    if (oversized != in->oversized_before)
        set_level(&w, LEVEL_WARN, "too long: more than %u names or numbers, or a name of 256 bytes",
                  atomic_load_explicit(&in->name_limit, memory_order_relaxed));
    if (!publishers)
        set_level(&w, absent, "no publisher");
    else if (!in->received)
        set_level(&w, absent, "no message that can be read");
    if (in->received && gives_joint_states(in->kind) && robot->arrays)
        report_ages(&w, robot, now);
    if (needed && in->received && now - in->last > robot->state_age)
        set_level(&w, LEVEL_STALE, "the last message is %.0f ms old, the limit is %.0f ms",
                  1e-6 * (double)(now - in->last), 1e-6 * (double)robot->state_age);
    add_value(&w, "messages", "%" PRIu64, in->received);
    add_value(&w, "rate, Hz", "%.1f", (double)(in->received - in->received_before) / r->seconds);
    add_value(&w, "refused", "%" PRIu64, in->refused);
    add_value(&w, "last refusal", "%s", in->error);
    add_value(&w, "too long", "%" PRIu64, oversized);
    if (robot->arrays && gives_joint_states(in->kind))
        report_unknown(&w, robot->arrays->state);
    if (robot->arrays && ros2_is_command(in->kind))
        report_unknown(&w, robot->arrays->command);
    in->received_before = in->received;
    in->refused_before = in->refused;
    in->oversized_before = oversized;
}

/* ---- model and answers ---- */

static void report_model(const tfa_ros2 *gateway, const ros2_robot *robot)
{
    const writer w = begin_status(gateway->report, robot, "model");
    if (!robot->arrays)
        set_level(&w, LEVEL_ERROR, "no memory for the model's arrays: nothing is answered");
    if (robot->description_error[0])
        set_level(&w, LEVEL_ERROR, "robot_description refused, the model before it stays: %s",
                  robot->description_error);
    if (robot->arrays) {
        add_value(&w, "model", "%.16s", tfa_model_hash_text(robot->arrays->model));
        add_value(&w, "joints", "%u", robot->arrays->joints);
    }
    add_value(&w, "descriptions", "%" PRIu64, robot->descriptions);
    add_value(&w, "descriptions refused", "%" PRIu64, robot->descriptions_refused);
}

static void report_subscribers(const writer *w, ros2_robot *robot)
{
    static const char *const names[] = {ROS2_OUTPUT_NAMES};
    robot->subscribers = 0;
    for (int k = 0; k < ROS2_OUTPUT_KINDS; k++) {
        dds_offered_incompatible_qos_status_t qos = {0};
        dds_publication_matched_status_t matched = {0};
        if (robot->writers[k] <= 0)
            continue;
        (void)dds_get_publication_matched_status(robot->writers[k], &matched);
        robot->subscribers += matched.current_count;
        (void)dds_get_offered_incompatible_qos_status(robot->writers[k], &qos);
        if (qos.total_count_change)
            set_level(w, LEVEL_WARN, "a subscriber of %s asks for a QoS that does not match: %s",
                      names[k], policy_name(qos.last_policy_id));
    }
}

static void log_restarts(const ros2_robot *robot)
{
    const ros2_observed *w = &robot->observed;
    char gap[64] = "";
    if (w->gap != 0)
        snprintf(gap, sizeof gap, ", %.6g s after the state before", w->gap);
    tfa_log(w->event == TFA_OBSERVER_STARTED ? TFA_LOG_INFO : TFA_LOG_WARNING,
            "ros2: robot '%s': the observer restarted: %s%s; restart %" PRIu64, robot->name,
            w->reason, gap, w->restarts);
}

/* Once, until it has samples again. */
static void log_lack(ros2_robot *robot, int64_t now)
{
    tfa_joint_inputs *state = robot->arrays->state;
    char fault[160];
    for (int v = TFA_JOINT_VELOCITY; v <= TFA_JOINT_EFFORT && !robot->observed.lacking; v++) {
        if (tfa_joint_inputs_read(state, (tfa_joint_value)v, now, robot->state_age,
                                  robot->arrays->tau))
            continue;
        ros2_fault_text(state, fault, sizeof fault);
        tfa_log(TFA_LOG_WARNING, "ros2: robot '%s': the observer does not run: %s", robot->name,
                fault);
        robot->observed.lacking = true;
    }
}

static void report_observer(const writer *w, ros2_robot *robot, int64_t now)
{
    ros2_observed *o = &robot->observed;
    const ros2_observed *before = &robot->observed_before;
    if (!robot->arrays || !robot->arrays->observer)
        return;
    if (o->samples != before->samples)
        o->lacking = false;
    else if (o->states != before->states)
        log_lack(robot, now);
    if (o->restarts != before->restarts)
        log_restarts(robot);
    if (o->restarts != before->restarts && o->event != TFA_OBSERVER_STARTED)
        set_level(w, LEVEL_WARN, "the observer restarted: %s", o->reason);
    add_value(w, "observer's samples", "%" PRIu64, o->samples);
    add_value(w, "observer's restarts", "%" PRIu64 "%s%s", o->restarts,
              o->restarts ? ", last: " : "", o->restarts ? o->reason : "");
    robot->observed_before = *o;
}

static void report_answers(const tfa_ros2 *gateway, ros2_robot *robot, int64_t now)
{
    const writer w = begin_status(gateway->report, robot, "answers");
    const ros2_counts *c = &robot->counts, *before = &robot->counts_before;
    const double seconds = gateway->report->seconds;
    if (c->refused != before->refused)
        set_level(&w,
                  c->answers + c->states == before->answers + before->states ? LEVEL_ERROR
                                                                             : LEVEL_WARN,
                  "refused: %s", c->refusal);
    if (c->dropped != before->dropped)
        set_level(&w, LEVEL_ERROR, "%" PRIu64 " answers were not taken by DDS",
                  c->dropped - before->dropped);
    report_subscribers(&w, robot);
    if (c->fallbacks != before->fallbacks)
        set_level(&w, LEVEL_WARN, "%" PRIu64 " answers by another method (fallback)",
                  c->fallbacks - before->fallbacks);
    add_value(&w, "accelerations", "%" PRIu64, c->answers);
    add_value(&w, "rate, Hz", "%.1f", (double)(c->answers - before->answers) / seconds);
    add_value(&w, "states", "%" PRIu64, c->states);
    add_value(&w, "refused", "%" PRIu64, c->refused);
    add_value(&w, "last refusal", "%s", c->refusal);
    add_value(&w, "fallbacks", "%" PRIu64, c->fallbacks);
    add_value(&w, "error estimates", "%" PRIu64, c->estimates);
    add_value(&w, "largest error estimate", "%.1e", c->largest_estimate);
    add_value(&w, "method", "%s", c->answers + c->states ? tfa_method_name(c->method) : "");
    add_value(&w, "dropped", "%" PRIu64, c->dropped);
    report_observer(&w, robot, now);
    robot->counts_before = robot->counts;
}

/* ---- the message ---- */

static void set_stamp(diagnostic_msgs_msg_dds__DiagnosticArray_ *message)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    message->header.stamp.sec = (int32_t)now.tv_sec;
    message->header.stamp.nanosec = (uint32_t)now.tv_nsec;
    message->header.frame_id = (char *)(uintptr_t) ""; /* only read */
}

static void borrow_publications(const tfa_ros2 *gateway)
{
    struct ros2_report *r = gateway->report;
    dds_sample_info_t info[PUBLICATIONS_MAX];
    r->publications[0] = NULL; /* Cyclone's memory */
    r->publication_count = dds_read_mask(
        gateway->publications, r->publications, info, PUBLICATIONS_MAX, PUBLICATIONS_MAX,
        DDS_ALIVE_INSTANCE_STATE | DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE);
}

static void report_robot(const tfa_ros2 *gateway, ros2_robot *robot, int64_t now)
{
    if (!ros2_leads(robot))
        return;
    pthread_mutex_lock(&robot->mutex);
    for (uint32_t k = 0; k < robot->input_count; k++)
        report_input(gateway, &robot->inputs[k], now);
    report_model(gateway, robot);
    report_answers(gateway, robot, now);
    ros2_publish_statistics(robot);
    pthread_mutex_unlock(&robot->mutex);
}

void ros2_publish_diagnostics(tfa_ros2 *gateway, int64_t now)
{
    struct ros2_report *r = gateway->report;
    r->seconds = r->last && now > r->last ? 1e-9 * (double)(now - r->last) : 1;
    r->last = now;
    r->message.status._length = 0;
    r->message.status._buffer = r->status;
    borrow_publications(gateway);
    for (uint32_t i = 0; i < gateway->robot_count; i++)
        report_robot(gateway, &gateway->robots[i], now);
    if (r->publication_count > 0)
        (void)dds_return_loan(gateway->publications, r->publications, r->publication_count);
    set_stamp(&r->message);
    if (r->message.status._length)
        (void)dds_write(gateway->diagnostics_writer, &r->message);
}
