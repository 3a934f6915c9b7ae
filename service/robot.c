/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots: from the configuration to models, names and workspaces.
 */
#include "robot.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"

#define ALIGNMENT 64
#define SELF_TEST_NS 100000000u
#define SELF_TEST_TRIES 100 /* 10 s: a loaded machine may be slow, a robot may be large */

/* ---- loading ---- */

static void log_report(const tfa_report *report)
{
    char text[512];
    for (size_t i = 0; i < report->count; i++) {
        const tfa_severity severity = report->messages[i].severity;
        (void)tfa_report_format(report, i, text, sizeof text);
        tfa_log(severity == TFA_ERROR     ? TFA_LOG_ERROR
                : severity == TFA_WARNING ? TFA_LOG_WARNING
                                          : TFA_LOG_DEBUG,
                "%s", text);
    }
}

static int set_armature(const config_robot *from, tfa_description *description)
{
    for (size_t i = 0; i < from->armature_count; i++) {
        const config_armature *a = &from->armature[i];
        size_t joint = 0;
        while (joint < description->joint_count &&
               strcmp(description->joints[joint].name, a->joint) != 0)
            joint++;
        if (joint == description->joint_count) {
            tfa_log(TFA_LOG_ERROR, "robot '%s': armature: the robot has no joint '%s'", from->name,
                    a->joint);
            return TFA_E_JOINT;
        }
        description->joints[joint].armature = a->value;
    }
    return TFA_OK;
}

static int compile(const config_robot *from, const char *path, tfa_report *report,
                   tfa_model **model)
{
    const tfa_model_options options = {.base = (tfa_base)from->base,
                                       .gravity = from->gravity_count ? from->gravity : NULL,
                                       .rotor_inertia = from->rotor_inertia};
    tfa_description *description;
    int status = tfa_urdf_load(path, &description, report);
    if (status != TFA_OK)
        return status;
    status = set_armature(from, description);
    if (status == TFA_OK)
        status = tfa_model_create(description, &options, report, model);
    tfa_description_free(description);
    return status;
}

/* ---- names: types, joint names, frame names ---- */

static size_t names_size(const tfa_model *model)
{
    const uint32_t joints = tfa_model_joint_count(model), frames = tfa_model_frame_count(model);
    size_t size = joints * sizeof(uint32_t);
    for (uint32_t i = 0; i < joints; i++)
        size += strlen(tfa_model_joint(model, i).name) + 1;
    for (uint32_t i = 0; i < frames; i++)
        size += strlen(tfa_model_frame(model, i).name) + 1;
    return size;
}

static int write_names(const config *settings, tfa_robot *robot)
{
    const tfa_model *model = robot->model;
    const uint32_t joints = tfa_model_joint_count(model), frames = tfa_model_frame_count(model);
    const size_t size = names_size(model);
    int status =
        tfa_segment_create((config_backend)settings->backend, size ? size : 1, &robot->names);
    if (status != TFA_OK)
        return status;
    uint32_t *types = robot->names.memory;
    char *at = (char *)(types + joints);
    for (uint32_t i = 0; i < joints; i++) {
        const tfa_joint_info joint = tfa_model_joint(model, i);
        types[i] = (uint32_t)joint.type;
        at = stpcpy(at, joint.name) + 1;
    }
    for (uint32_t i = 0; i < frames; i++)
        at = stpcpy(at, tfa_model_frame(model, i).name) + 1;
    return TFA_OK;
}

int tfa_robot_load(const config *settings, const config_robot *from, tfa_robot *robot)
{
    tfa_report report = {0};
    *robot = (tfa_robot){.config = from, .names = TFA_SEGMENT_NONE};
    char *path = config_urdf_path(settings, from);
    if (!path)
        return TFA_E_MEMORY;
    int status = compile(from, path, &report, &robot->model);
    log_report(&report);
    tfa_report_free(&report);
    if (status == TFA_OK) {
        robot->shape = (tfa_wire_shape){.q_count = tfa_model_q_count(robot->model),
                                        .v_count = tfa_model_v_count(robot->model),
                                        .base_freedoms = tfa_model_base_freedoms(robot->model),
                                        .max_batch = from->max_batch};
        status = write_names(settings, robot);
    }
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "robot '%s' (%s): %s: %s", from->name, path, tfa_status_text(status),
                tfa_status_cause(status));
        tfa_robot_unload(robot);
    }
    free(path);
    return status;
}

void tfa_robot_unload(tfa_robot *robot)
{
    tfa_segment_destroy(&robot->names);
    tfa_model_free(robot->model);
    robot->model = NULL;
}

/* ---- solving ---- */

int tfa_robot_solver_init(const tfa_robot *robot, tfa_robot_solver *solver)
{
    const size_t size = tfa_workspace_size(robot->model, NULL);
    *solver = (tfa_robot_solver){.estimate = robot->config->estimate,
                                 .every = robot->config->estimate_every,
                                 .until_next = robot->config->estimate_every};
    if (!size)
        return TFA_E_UNSUPPORTED;
    solver->memory = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (!solver->memory)
        return TFA_E_MEMORY;
    memset(solver->memory, 0, size); /* every page is there before the first request */
    int status = tfa_workspace_init(solver->memory, size, robot->model, NULL, &solver->workspace);
    if (status != TFA_OK)
        tfa_robot_solver_free(solver);
    return status;
}

void tfa_robot_solver_free(tfa_robot_solver *solver)
{
    free(solver->memory);
    *solver = (tfa_robot_solver){0};
}

/* What a request gets that leaves the estimate open. DEFAULT is the library's: always for TFA. */
static tfa_estimate policy(tfa_robot_solver *solver)
{
    if (solver->estimate == CONFIG_ESTIMATE_NEVER)
        return TFA_ESTIMATE_NEVER;
    if (solver->estimate == CONFIG_ESTIMATE_ALWAYS)
        return TFA_ESTIMATE_ALWAYS;
    if (--solver->until_next)
        return TFA_ESTIMATE_DEFAULT;
    solver->until_next = solver->every;
    return TFA_ESTIMATE_ALWAYS;
}

int tfa_robot_solve(void *self, const tfa_request *request, tfa_reply *reply)
{
    tfa_robot_solver *solver = self;
    if (request->estimate != TFA_ESTIMATE_DEFAULT)
        return tfa_compute(solver->workspace, request, reply);
    tfa_request decided = *request;
    decided.estimate = policy(solver);
    return tfa_compute(solver->workspace, &decided, reply);
}

/* ---- self-test ---- */

/* q = 0, but quaternions are 0 0 0 1. */
static void set_zero(const tfa_robot *robot, double *q)
{
    memset(q, 0, robot->shape.q_count * sizeof *q);
    for (uint32_t i = 0; i < tfa_model_joint_count(robot->model); i++) {
        const tfa_joint_info joint = tfa_model_joint(robot->model, i);
        if (joint.type == TFA_JOINT_FLOATING)
            q[joint.q_index + 6] = 1;
    }
}

static int ask(tfa_port *port, const double *q)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = q,
                                 .base_pose = port->shape.base_freedoms ? pose : NULL};
    tfa_wire_ask asked;
    tfa_reply reply;
    int status = tfa_wire_encode_request(&port->shape, &request, tfa_wire_want(&request, NULL), 1,
                                         0, tfa_ring_next_request(&port->ring), &asked);
    if (status != TFA_OK)
        return status;
    tfa_port_send(port);
    int tries = 0;
    while (!tfa_port_wait(port, 0, SELF_TEST_NS))
        if (++tries == SELF_TEST_TRIES)
            return TFA_E_TIMEOUT;
    (void)tfa_wire_decode_reply(tfa_ring_oldest_reply(&port->ring), &reply);
    /* a robot may be singular at q = 0; it was answered all the same */
    return tfa_wire_has_answers(reply.status) ? TFA_OK : reply.status;
}

int tfa_robot_self_test(const tfa_robot *robot, tfa_worker *worker, uint32_t index)
{
    tfa_port port;
    double *q = malloc((robot->shape.q_count + 1) * sizeof *q);
    if (!q)
        return TFA_E_MEMORY;
    set_zero(robot, q);
    int status = tfa_port_open(worker, index, 1, 1, &port);
    if (status == TFA_OK) {
        status = ask(&port, q);
        tfa_port_close(&port);
    }
    free(q);
    return status;
}
