/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ROS 2 gateway in one domain: joins it, runs its thread, ends.
 */
#include "dds/ros2/ros2_internal.h"

#include "dds/common/ros_domain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_MS INT64_C(1000000)
#define READY_MAX 64 /* inputs that one wake-up tells */
#define SERVICE "~/forward_dynamics"
#define DIAGNOSTICS_NS (1000 * NS_PER_MS) /* as diagnostic_updater of ROS */

/* ---- robots: what the configuration says, copied ---- */

static void free_texts(ros2_texts *t)
{
    for (uint32_t k = 0; t->text && k < t->count; k++)
        free(t->text[k]);
    free(t->text);
}

static bool copy_texts(ros2_texts *to, const char *const *from, size_t count)
{
    to->text = calloc(count + 1, sizeof *to->text);
    bool good = to->text != NULL;
    for (; good && to->count < count; to->count++) {
        to->text[to->count] = strdup(from[to->count]);
        good = to->text[to->count] != NULL;
    }
    return good;
}

static bool copy_wrench_links(ros2_texts *to, const config_robot_ros2 *from)
{
    const char *links[TFA_MAX_WRENCHES];
    for (size_t k = 0; k < from->wrenches_count; k++)
        links[k] = from->wrenches[k].link;
    return copy_texts(to, links, from->wrenches_count);
}

/* `name` NULL: this input is not wanted. */
static bool add_input(ros2_robot *robot, ros2_input_kind kind, uint32_t index, const char *name)
{
    if (!name)
        return true;
    ros2_input *in = &robot->inputs[robot->input_count++];
    in->kind = kind;
    in->index = index;
    in->robot = robot;
    in->sample = calloc(1, ros2_input_type(kind)->m_size);
    return in->sample && tfa_ros2_full_name(robot->node_namespace, robot->node, name, in->name);
}

/* In the order of the kinds, in which they are read. */
static bool add_inputs(ros2_robot *robot, const config_robot_ros2 *c)
{
    const char *state = c->joint_states ? c->joint_states : "joint_states";
    const char *low_state = c->unitree.topic ? c->unitree.topic : "/lowstate";
    const uint32_t unitree = c->unitree.type;
    bool good =
        add_input(robot, ROS2_ROBOT_DESCRIPTION, 0, c->robot_description) &&
        add_input(robot, ROS2_JOINT_STATES, 0, unitree ? NULL : state) &&
        add_input(robot, ROS2_LOW_STATE_GO, 0, unitree == CONFIG_UNITREE_GO ? low_state : NULL) &&
        add_input(robot, ROS2_LOW_STATE_HG, 0, unitree == CONFIG_UNITREE_HG ? low_state : NULL) &&
        add_input(robot, ROS2_ODOMETRY, 0, c->odometry);
    for (uint32_t k = 0; good && k < c->wrenches_count; k++)
        good = add_input(robot, ROS2_WRENCH, k, c->wrenches[k].topic);
    return good && add_input(robot, ROS2_CONSTRAINTS, 0, c->active_constraints) &&
           add_input(robot, ROS2_EFFORT_COMMANDS, 0, c->effort_commands) &&
           add_input(robot, ROS2_JOINT_EFFORTS, 0, c->joint_efforts) &&
           add_input(robot, ROS2_TRAJECTORY, 0, c->trajectory) &&
           add_input(robot, ROS2_FORWARD_DYNAMICS, 0, c->services ? SERVICE : NULL);
}

static void set_arrays(ros2_robot *robot, ros2_arrays *arrays)
{
    robot->arrays = arrays;
    for (uint32_t k = 0; arrays && k < robot->input_count; k++)
        atomic_store_explicit(&robot->inputs[k].name_limit, ros2_name_limit(arrays->joints),
                              memory_order_relaxed);
}

static void set_observer(ros2_robot *robot, const config_observer *c)
{
    robot->state_values = ROS2_STATE_VALUES;
    robot->observed.start = "first sample";
    if (!(c->gain > 0))
        return;
    robot->state_values = ROS2_OBSERVED_VALUES;
    robot->observer = (tfa_observer_options){c->gain, c->max_gap > 0 ? c->max_gap : 5 / c->gain};
}

static int make_robot(ros2_robot *robot, const gateway_context *from, uint32_t index)
{
    const tfa_robot *served = &from->robots[index];
    const config_robot_ros2 *c = &served->config->ros2;
    robot->index = index;
    robot->config_number = (size_t)(served->config - from->settings->robots);
    snprintf(robot->name, sizeof robot->name, "%s", served->name);
    snprintf(robot->node_namespace, sizeof robot->node_namespace, "%s",
             c->namespace ? c->namespace : TFA_ROS2_DEFAULT_NAMESPACE);
    snprintf(robot->node, sizeof robot->node, "%s", c->node ? c->node : TFA_ROS2_DEFAULT_NODE);
    robot->own.statistics = &from->statistics[index];
    robot->own.state = &from->states[index];
    robot->state_age = NS_PER_MS * c->state_age_ms;
    robot->command_age = NS_PER_MS * c->command_age_ms;
    robot->constrained = c->op == CONFIG_ROS2_CONSTRAINED_DYNAMICS;
    set_observer(robot, &c->observer);
    if (!copy_texts(&robot->joints, c->joints, c->joints_count) ||
        !copy_texts(&robot->tips, c->tips, c->tips_count) ||
        !copy_texts(&robot->constraints, c->constraints, c->constraints_count) ||
        !copy_texts(&robot->motors, c->unitree.motors, c->unitree.motors_count) ||
        !copy_texts(&robot->observer_tip, &c->observer.tip, c->observer.tip != NULL) ||
        !copy_wrench_links(&robot->wrench_links, c) || !add_inputs(robot, c))
        return TFA_E_MEMORY;
    set_arrays(robot, ros2_arrays_create(robot, served->model));
    return robot->arrays ? TFA_OK : TFA_E_MEMORY;
}

static bool is_in(const tfa_robot *robot, const tfa_ros2_options *options)
{
    return tfa_ros2_serves(robot) && robot->config->ros2.enabled &&
           tfa_ros2_domain_of(robot->config, options->common) == options->domain;
}

static int make_robots(tfa_ros2 *gateway, const tfa_ros2_options *options)
{
    const gateway_context *c = options->context;
    int status = TFA_OK;
    gateway->robots = calloc(c->robot_count, sizeof *gateway->robots);
    if (!gateway->robots)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < c->robot_count && status == TFA_OK; i++) {
        if (!is_in(&c->robots[i], options))
            continue;
        ros2_robot *robot = &gateway->robots[gateway->robot_count++];
        robot->gateway = gateway;
        pthread_mutex_init(&robot->mutex, NULL);
        status = make_robot(robot, c, i);
    }
    gateway->report = status == TFA_OK ? ros2_report_create(gateway) : NULL;
    return status == TFA_OK && !gateway->report ? TFA_E_MEMORY : status;
}

static void free_robot(ros2_robot *robot)
{
    for (uint32_t k = 0; k < robot->input_count; k++)
        if (robot->inputs[k].sample)
            dds_sample_free(robot->inputs[k].sample, ros2_input_type(robot->inputs[k].kind),
                            DDS_FREE_ALL);
    free_texts(&robot->joints);
    free_texts(&robot->tips);
    free_texts(&robot->constraints);
    free_texts(&robot->motors);
    free_texts(&robot->observer_tip);
    free_texts(&robot->wrench_links);
    ros2_arrays_free(robot->arrays);
    pthread_mutex_destroy(&robot->mutex);
}

/* ---- entities ---- */

/* Where the service is read, it is the last input. */
static bool make_reply_writer(const tfa_ros2 *gateway, ros2_robot *robot)
{
    const ros2_input *last = robot->input_count ? &robot->inputs[robot->input_count - 1] : NULL;
    if (!last || last->kind != ROS2_FORWARD_DYNAMICS)
        return true;
    robot->reply_writer = ros2_make_reply_writer(gateway->member.participant, last->name);
    return !tfa_dds_failed(robot->reply_writer, last->name);
}

/* Answers about tips, constraints and external forces only where there are any. */
static bool is_offered(const ros2_robot *robot, int kind)
{
    switch (kind) {
    case ROS2_CONSTRAINT_WRENCHES:
        return robot->constrained;
    case ROS2_EXTERNAL_TORQUES:
        return robot->observer.gain > 0;
    case ROS2_EXTERNAL_BASE_WRENCH:
        return robot->observer.gain > 0 && robot->arrays->base;
    case ROS2_EXTERNAL_WRENCH:
        return robot->observer_tip.count > 0;
    default:
        return kind < ROS2_LAMBDA_INV || robot->tips.count > 0;
    }
}

static bool make_writers(const tfa_ros2 *gateway, ros2_robot *robot)
{
    static const char *const names[] = {ROS2_OUTPUT_NAMES};
    char name[TFA_ROS2_NAME_MAX + 1], relative[32];
    for (int k = 0; k < ROS2_OUTPUT_KINDS; k++) {
        if (!is_offered(robot, k))
            continue;
        snprintf(relative, sizeof relative, "~/%s", names[k]);
        if (!tfa_ros2_full_name(robot->node_namespace, robot->node, relative, name)) {
            tfa_dds_set_error("robot '%s': namespace and node are too long", robot->name);
            return false;
        }
        robot->writers[k] =
            ros2_make_writer(gateway->member.participant, (ros2_output_kind)k, name);
        if (tfa_dds_failed(robot->writers[k], name))
            return false;
    }
    return make_reply_writer(gateway, robot);
}

static int make_entities(tfa_ros2 *gateway)
{
    gateway->waitset = dds_create_waitset(gateway->member.participant);
    gateway->stop = dds_create_guardcondition(gateway->member.participant);
    gateway->diagnostics_writer = ros2_make_diagnostics_writer(gateway->member.participant);
    gateway->graph_writer = ros2_make_graph_writer(gateway->member.participant, gateway->humble);
    gateway->publications = dds_create_reader(gateway->member.participant,
                                              DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL);
    if (tfa_dds_failed(gateway->waitset, "waitset") ||
        tfa_dds_failed(gateway->stop, "guard condition") ||
        tfa_dds_failed(gateway->diagnostics_writer, "diagnostics writer") ||
        tfa_dds_failed(gateway->graph_writer, "ros_discovery_info writer") ||
        tfa_dds_failed(gateway->publications, "reader of publications") ||
        tfa_dds_failed(dds_waitset_attach(gateway->waitset, gateway->stop, 0), "guard condition"))
        return TFA_E_SYSTEM;
    for (uint32_t i = 0; i < gateway->robot_count; i++)
        if (!make_writers(gateway, &gateway->robots[i]))
            return TFA_E_SYSTEM;
    return TFA_OK;
}

int tfa_ros2_create(const tfa_ros2_options *options, tfa_ros2 **result)
{
    *result = NULL;
    tfa_ros2 *gateway = calloc(1, sizeof *gateway);
    if (!gateway)
        return TFA_E_MEMORY;
    gateway->id = options->domain;
    gateway->humble = tfa_ros2_is_humble(&options->context->settings->ros2);
    gateway->context = *options->context;
    int status = make_robots(gateway, options);
    if (status == TFA_OK)
        status = tfa_dds_join(options->domain, options->settings,
                              options->settings ? TFA_ROS2_SAMPLE_MAX : 0, "enclave=/;",
                              &gateway->member); /* as rmw: no enclave but the root */
    if (status == TFA_OK)
        status = make_entities(gateway);
    if (status == TFA_OK)
        *result = gateway;
    else
        tfa_ros2_stop(gateway);
    return status;
}

/* ---- the thread ---- */

static void serve(ros2_robot *robot, int64_t now)
{
    pthread_mutex_lock(&robot->mutex);
    ros2_read_inputs(robot, now);
    ros2_publish_statistics(robot);
    pthread_mutex_unlock(&robot->mutex);
}

/* Robots with new messages, each once; more inputs than fit come with the next wake-up. */
static void serve_ready(const dds_attach_t *ready, dds_return_t count, int64_t now)
{
    for (dds_return_t k = 0; k < count; k++) {
        ros2_robot *robot = (ros2_robot *)ready[k]; /* NULL: the guard condition */
        dds_return_t before = 0;
        while (before < k && ready[before] != ready[k])
            before++;
        if (robot && before == k)
            serve(robot, now);
    }
}

static bool is_stopped(const tfa_ros2 *gateway)
{
    bool stopped = false;
    return dds_read_guardcondition(gateway->stop, &stopped) != DDS_RETCODE_OK || stopped;
}

static void *ros2_thread(void *arg)
{
    tfa_ros2 *gateway = arg;
    int64_t now = tfa_dds_monotonic(), next = now + DIAGNOSTICS_NS;
    while (!is_stopped(gateway)) {
        dds_attach_t ready[READY_MAX];
        const dds_return_t count =
            dds_waitset_wait(gateway->waitset, ready, READY_MAX, next > now ? next - now : 0);
        now = tfa_dds_monotonic();
        serve_ready(ready, count < READY_MAX ? count : READY_MAX, now);
        if (now >= next) {
            ros2_publish_diagnostics(gateway, now);
            next = now + DIAGNOSTICS_NS;
        }
    }
    return NULL;
}

static int make_readers(tfa_ros2 *gateway, ros2_robot *robot)
{
    for (uint32_t k = 0; k < robot->input_count; k++) {
        ros2_input *in = &robot->inputs[k];
        in->reader = ros2_make_reader(gateway->member.participant, in);
        if (tfa_dds_failed(in->reader, in->name) ||
            tfa_dds_failed(dds_set_status_mask(in->reader, DDS_DATA_AVAILABLE_STATUS), in->name) ||
            tfa_dds_failed(dds_waitset_attach(gateway->waitset, in->reader, (dds_attach_t)robot),
                           in->name))
            return TFA_E_SYSTEM;
    }
    return TFA_OK;
}

int tfa_ros2_start(tfa_ros2 *gateway, const tfa_worker_robot *solvers)
{
    int status = TFA_OK;
    for (uint32_t i = 0; i < gateway->robot_count && status == TFA_OK; i++) {
        gateway->robots[i].own.solver = solvers[gateway->robots[i].index];
        status = make_readers(gateway, &gateway->robots[i]);
    }
    if (status == TFA_OK)
        status = ros2_publish_graph(gateway);
    if (status != TFA_OK)
        return status;
    const int code = pthread_create(&gateway->thread, NULL, ros2_thread, gateway);
    if (code != 0) {
        tfa_dds_set_error("thread: %s", strerror(code));
        return TFA_E_SYSTEM;
    }
    gateway->running = true;
    (void)pthread_setname_np(gateway->thread, "tfa-ros2");
    return TFA_OK;
}

/* ---- other models ---- */

/* Constraints stay active by their names. */
static uint32_t adopt_active(const tfa_model *next, const tfa_model *before, uint32_t bits)
{
    uint32_t adopted = 0;
    for (uint32_t k = 0; k < tfa_model_constraint_count(next); k++) {
        const int32_t at = tfa_model_find_constraint(before, tfa_model_constraint(next, k).name);
        if (at >= 0 && bits >> at & 1)
            adopted |= UINT32_C(1) << k;
    }
    return adopted;
}

int ros2_exchange(ros2_robot *robot, const tfa_model *model, const tfa_worker_robot *solver)
{
    ros2_arrays *next = ros2_arrays_create(robot, model);
    pthread_mutex_lock(&robot->mutex);
    ros2_arrays *before = robot->arrays;
    if (next && before) {
        tfa_joint_inputs_adopt(next->state, before->state);
        tfa_joint_inputs_adopt(next->command, before->command);
        robot->active.bits = adopt_active(model, before->model, robot->active.bits);
    }
    set_arrays(robot, next);
    robot->observed.start = ros2_leads(robot) ? "reload" : "takeover";
    robot->own.solver = *solver;
    pthread_mutex_unlock(&robot->mutex);
    ros2_arrays_free(before);
    return next ? TFA_OK : TFA_E_MEMORY;
}

/* ---- the end ---- */

void tfa_ros2_stop(tfa_ros2 *gateway)
{
    if (!gateway)
        return;
    if (gateway->running) {
        (void)dds_set_guardcondition(gateway->stop, true);
        pthread_join(gateway->thread, NULL);
    }
    tfa_dds_leave(&gateway->member);
    for (uint32_t i = 0; gateway->robots && i < gateway->robot_count; i++)
        free_robot(&gateway->robots[i]);
    free(gateway->robots);
    ros2_report_free(gateway->report);
    free(gateway);
}
