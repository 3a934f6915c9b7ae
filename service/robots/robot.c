/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots and their scenes: from the configuration to models and names.
 */
#include "robot.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/log.h"

#define CODES 16 /* different warnings that are counted in the log */

/* ---- its log lines ---- */

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

/* Warnings by code. */
typedef struct tally {
    const char *code[CODES];
    uint32_t count[CODES];
    uint32_t codes, others;
} tally;

static void add_warnings(tally *t, const tfa_report *report)
{
    for (size_t i = 0; i < report->count; i++) {
        const tfa_message *m = &report->messages[i];
        uint32_t k = 0;
        if (m->severity != TFA_WARNING)
            continue;
        while (k < t->codes && strcmp(t->code[k], m->code) != 0)
            k++;
        if (k == CODES) {
            t->others += m->count;
            continue;
        }
        if (k == t->codes)
            t->code[t->codes++] = m->code;
        t->count[k] += m->count;
    }
}

static void write_warnings(const tally *t, char *text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "%s", t->codes ? "warnings:" : "no warnings");
    for (uint32_t k = 0; k < t->codes && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s %s %u", k ? "," : "", t->code[k],
                                 t->count[k]);
    if (t->others && used < size)
        snprintf(text + used, size - used, ", others %u", t->others);
}

/* Two lines: the interface for clients, and the reductions of the file. */
static void log_summary(const tfa_robot *robot, const tfa_report *of_file,
                        const tfa_report *of_model)
{
    const tfa_model_summary s = tfa_model_summarise(robot->model);
    tally warnings = {0};
    char text[160];
    add_warnings(&warnings, of_file);
    add_warnings(&warnings, of_model);
    write_warnings(&warnings, text, sizeof text);
    tfa_log(TFA_LOG_INFO, "robot '%s': %u joints, %u freedoms%s, model %.16s%s", robot->name,
            tfa_model_joint_count(robot->model), robot->shape.v_count,
            robot->shape.base_freedoms ? " and a floating base" : "",
            tfa_model_hash_text(robot->model),
            robot->shared->origin ? ", shares its constants with another of this robot" : "");
    tfa_log(TFA_LOG_INFO,
            "robot '%s': %u links, %u bodies, %.6g kg (%.6g moving); joints: %u fixed, %u locked, "
            "%u fused, %u follow, %u absent; %s",
            robot->name, s.links, s.bodies, s.total_mass, s.moving_mass, s.fixed, s.locked, s.fused,
            s.follows, s.absent, text);
}

/* ---- names: types, frames of modes, names of joints, frames, constraints ---- */

static size_t names_size(const tfa_model *model)
{
    const uint32_t joints = tfa_model_joint_count(model), frames = tfa_model_frame_count(model);
    size_t size = ((size_t)joints + tfa_model_mode_count(model)) * sizeof(uint32_t);
    for (uint32_t i = 0; i < joints; i++)
        size += strlen(tfa_model_joint(model, i).name) + 1;
    for (uint32_t i = 0; i < frames; i++)
        size += strlen(tfa_model_frame(model, i).name) + 1;
    for (uint32_t i = 0; i < tfa_model_constraint_count(model); i++)
        size += strlen(tfa_model_constraint(model, i).name) + 1;
    return size;
}

static int write_names(tfa_robot *robot)
{
    const tfa_model *model = robot->model;
    const uint32_t joints = tfa_model_joint_count(model), frames = tfa_model_frame_count(model);
    const uint32_t modes = tfa_model_mode_count(model);
    const size_t size = names_size(model);
    uint32_t *types = calloc(1, size ? size : 1);
    if (!types)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < modes; i++)
        types[joints + i] = (uint32_t)tfa_model_find_frame(model, tfa_model_mode(model, i).link);
    char *at = (char *)(types + joints + modes);
    for (uint32_t i = 0; i < joints; i++) {
        const tfa_joint_info joint = tfa_model_joint(model, i);
        types[i] = (uint32_t)joint.type;
        at = stpcpy(at, joint.name) + 1;
    }
    for (uint32_t i = 0; i < frames; i++)
        at = stpcpy(at, tfa_model_frame(model, i).name) + 1;
    for (uint32_t i = 0; i < tfa_model_constraint_count(model); i++)
        at = stpcpy(at, tfa_model_constraint(model, i).name) + 1;
    const int status = tfa_segment_create_constant(types, size ? size : 1, &robot->names);
    free(types);
    return status;
}

/* Everything that a client learns is in the shape or among the names. */
bool tfa_robot_same_shape(const tfa_robot *a, const tfa_robot *b)
{
    return memcmp(&a->shape, &b->shape, sizeof a->shape) == 0 &&
           tfa_model_joint_count(a->model) == tfa_model_joint_count(b->model) &&
           tfa_model_frame_count(a->model) == tfa_model_frame_count(b->model) &&
           a->names.size == b->names.size &&
           memcmp(a->names.memory, b->names.memory, a->names.size) == 0;
}

/* ---- loading ---- */

size_t tfa_robot_count(const config_robot *from)
{
    return 1 + from->scenes_count;
}

void tfa_robot_unload(tfa_robot *robot)
{
    tfa_segment_destroy(&robot->names);
    tfa_segment_destroy(&robot->description);
    tfa_batch_pool_free(robot->pool);
    robot->pool = NULL;
    free(robot->parts);
    robot->parts = NULL;
    tfa_specialised_free(robot->specialised);
    robot->specialised = NULL;
    tfa_shared_model_drop(robot->shared);
    robot->shared = NULL;
    robot->model = NULL;
}

static void name_robot(const tfa_robot_source *s, tfa_robot *robot)
{
    *robot = (tfa_robot){.config = s->robot,
                         .scene = s->scene,
                         .names = TFA_SEGMENT_NONE,
                         .description = TFA_SEGMENT_NONE};
    /* they fit: the configuration was checked */
    char *end = stpcpy(robot->name, s->robot->name);
    if (s->scene)
        stpcpy(stpcpy(end, "."), s->scene->name);
}

static int finish_robot(const tfa_robot_source *s, tfa_robot *robot)
{
    robot->model = robot->shared->model;
    robot->shape = (tfa_wire_shape){.q_count = tfa_model_q_count(robot->model),
                                    .v_count = tfa_model_v_count(robot->model),
                                    .base_freedoms = tfa_model_base_freedoms(robot->model),
                                    .frames = tfa_model_frame_count(robot->model),
                                    .modes = tfa_model_mode_count(robot->model),
                                    .max_batch = s->robot->max_batch,
                                    .max_tips = s->robot->max_tips};
    int status = write_names(robot);
    return status == TFA_OK ? tfa_robot_verify(robot) : status;
}

/* The first error of a robot that is not loaded. */
static void keep_error(tfa_robot_urdf *urdf, const tfa_report *report, int status)
{
    if (!urdf || urdf->error[0])
        return;
    for (size_t i = 0; i < report->count; i++)
        if (report->messages[i].severity == TFA_ERROR) {
            (void)tfa_report_format(report, i, urdf->error, sizeof urdf->error);
            return;
        }
    snprintf(urdf->error, sizeof urdf->error, "%s", tfa_status_text(status));
}

/* Compiles number `i`, of which the ones before are compiled. */
static int load_one(const tfa_robot_source *sources, size_t i, const tfa_description *description,
                    const tfa_report *of_file, tfa_robot_urdf *urdf, tfa_shared_model **models,
                    tfa_robot *robot)
{
    tfa_report report = {.syntax = TFA_SYNTAX_YAML};
    tfa_report_set_file(&report, of_file->file);
    int status =
        tfa_robot_source_compile(&sources[i], description, sources, models, i, &report, &models[i]);
    robot->shared = models[i];
    if (status == TFA_OK)
        status = finish_robot(&sources[i], robot);
    log_report(&report);
    if (status == TFA_OK) {
        log_summary(robot, of_file, &report);
        tfa_robot_find_kernel(sources[i].settings, robot);
    } else {
        tfa_log(TFA_LOG_ERROR, "robot '%s' (%s): %s: %s", robot->name, of_file->file,
                tfa_status_text(status), tfa_status_cause(status));
        keep_error(urdf, &report, status);
    }
    tfa_report_free(&report);
    return status;
}

/* @param path  of the file, or a name for the text */
static int load_all(const tfa_robot_source *sources, size_t count, const char *path,
                    tfa_robot_urdf *urdf, tfa_robot *robots)
{
    tfa_report report = {.syntax = TFA_SYNTAX_YAML};
    tfa_description *description = NULL;
    tfa_shared_model **models = calloc(count, sizeof *models);
    if (!models)
        return TFA_E_MEMORY;
    tfa_report_set_file(&report, path);
    int status = urdf && urdf->text
                     ? tfa_urdf_parse(urdf->text, strlen(urdf->text), path, &description, &report)
                     : tfa_urdf_load(path, &description, &report);
    const int error = errno;
    log_report(&report);
    if (status == TFA_OK)
        status = tfa_robot_source_set_armature(&sources[0], description);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "robot '%s' (%s): %s: %s", robots[0].name, path,
                tfa_status_text(status),
                status == TFA_E_FILE ? strerror(error) : tfa_status_cause(status));
        keep_error(urdf, &report, status);
    }
    for (size_t i = 0; i < count && status == TFA_OK; i++)
        status = load_one(sources, i, description, &report, urdf, models, &robots[i]);
    tfa_description_free(description);
    tfa_report_free(&report);
    free(models);
    return status;
}

/* Of the robot's file; of a text, its name in messages. */
static char *find_path(const config *settings, const config_robot *from, const tfa_robot_urdf *urdf)
{
    char *name;
    if (!urdf || !urdf->text)
        return config_file_path(settings, from->urdf);
    return asprintf(&name, "robot_description of '%s'", from->name) < 0 ? NULL : name;
}

int tfa_robot_load(const config *settings, const config_robot *from, tfa_robot_urdf *urdf,
                   tfa_robot *robots)
{
    const size_t count = tfa_robot_count(from);
    char *path = find_path(settings, from, urdf);
    tfa_robot_source *sources = calloc(count, sizeof *sources);
    int status = path && sources ? TFA_OK : TFA_E_MEMORY;
    if (status != TFA_OK)
        goto done;
    for (size_t i = 0; i < count; i++) {
        sources[i] = (tfa_robot_source){settings, from, i ? &from->scenes[i - 1] : NULL};
        name_robot(&sources[i], &robots[i]);
    }
    status = load_all(sources, count, path, urdf, robots);
    for (size_t i = count; status != TFA_OK && i > 0; i--)
        tfa_robot_unload(&robots[i - 1]);
done:
    free(sources);
    free(path);
    return status;
}
