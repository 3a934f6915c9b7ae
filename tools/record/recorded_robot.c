/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Settings of a recording (written by service/robots/describe.c).
 */
#include "recorded_robot.h"

#include "common/commands.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/constraints.h>
#include <totalforce/modes.h>

#define BATCH_MAX 65536 /* of the daemon's configuration */

/* ---- JSON ---- */

static const char *text_of(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

static uint32_t number_of(const json_t *object, const char *key)
{
    const json_int_t n = json_integer_value(json_object_get(object, key));
    return n < 0 || n > UINT32_MAX ? UINT32_MAX : (uint32_t)n;
}

/* @return how many there are; only the first `most` are read */
static size_t numbers_of(const json_t *object, const char *key, double *out, size_t most)
{
    const json_t *list = json_object_get(object, key);
    const size_t count = json_array_size(list);
    for (size_t i = 0; i < count && i < most; i++)
        out[i] = json_number_value(json_array_get(list, i));
    return count;
}

/* ---- settings ---- */

static void read_shape(const json_t *json, recorded_robot *r)
{
    const json_t *shape = json_object_get(json, "shape");
    r->shape = (tfa_wire_shape){.q_count = number_of(shape, "q_count"),
                                .v_count = number_of(shape, "v_count"),
                                .base_freedoms = number_of(shape, "base_freedoms"),
                                .frames = number_of(shape, "frames"),
                                .modes = number_of(shape, "modes"),
                                .max_batch = number_of(shape, "max_batch"),
                                .max_tips = number_of(shape, "max_tips")};
    r->workspace = (tfa_workspace_options){
        .precision = (tfa_precision)number_of(json, "precision"),
        .residual = (tfa_residual)number_of(json, "residual"),
        .methods = json_is_true(json_object_get(json, "all_methods")) ? TFA_METHODS_ALL : 0,
        .max_tips = r->shape.max_tips};
}

int recorded_robot_read(const char *settings, size_t bytes, recorded_robot *r, char *text,
                        size_t size)
{
    json_error_t error;
    *r = (recorded_robot){.json = json_loadb(settings, bytes, 0, &error)};
    if (!r->json) {
        snprintf(text, size, "its settings are not JSON: line %d: %s", error.line, error.text);
        return -1;
    }
    r->robot = text_of(r->json, "robot");
    r->version = text_of(r->json, "version");
    r->urdf_name = text_of(r->json, "urdf");
    r->model_hash = text_of(r->json, "model");
    r->isa = text_of(r->json, "isa");
    r->specialised = text_of(json_object_get(r->json, "specialised"), "file");
    r->digest = text_of(json_object_get(r->json, "specialised"), "digest");
    const char *estimate = text_of(r->json, "estimate");
    r->sampled = estimate && strcmp(estimate, "sampled") == 0;
    read_shape(r->json, r);
    const char *missing =
        !r->robot                                                   ? "robot"
        : !r->version                                               ? "version"
        : !r->urdf_name                                             ? "urdf"
        : !r->model_hash                                            ? "model"
        : !r->isa                                                   ? "isa"
        : r->specialised && (!r->digest || strlen(r->digest) != 64) ? "specialised"
        : r->shape.max_batch < 1 || r->shape.max_batch > BATCH_MAX  ? "shape.max_batch"
        : r->shape.max_tips < 1 || r->shape.max_tips > TFA_MAX_TIPS ? "shape.max_tips"
                                                                    : NULL;
    if (!missing)
        return 0;
    snprintf(text, size, "its settings have no valid '%s'", missing);
    recorded_robot_free(r);
    return -1;
}

void recorded_robot_free(recorded_robot *r)
{
    json_decref(r->json);
    *r = (recorded_robot){0};
}

int recorded_robot_fits(const recorded_robot *r, const tfa_model *model)
{
    return tfa_model_q_count(model) == r->shape.q_count &&
           tfa_model_v_count(model) == r->shape.v_count &&
           tfa_model_base_freedoms(model) == r->shape.base_freedoms &&
           tfa_model_frame_count(model) == r->shape.frames &&
           tfa_model_mode_count(model) == r->shape.modes;
}

/* ---- the model ---- */

/* The lists that a tfa_scene points to. */
typedef struct scene_lists {
    tfa_scene scene;
    const char **tips;
    tfa_lock *locks;
    tfa_payload *payloads;
    tfa_rotor *rotors;
    tfa_modes modes;
    tfa_constraints constraints;
} scene_lists;

static void free_scene(scene_lists *s)
{
    free(s->tips);
    free(s->locks);
    free(s->payloads);
    free(s->rotors);
    tfa_modes_free(&s->modes);
    tfa_constraints_free(&s->constraints);
}

static const char *or_empty(const char *text)
{
    return text ? text : ""; /* no such link or joint: the report says so */
}

/* JSON is YAML: that of a side file. @return TFA_OK; errors of tfa_modes_parse */
static int read_modes(const json_t *json, tfa_modes *modes, tfa_report *report)
{
    char *text = json ? json_dumps(json, 0) : NULL;
    const int status =
        text   ? tfa_modes_parse(text, strlen(text), "modes of the recording", modes, report)
        : json ? TFA_E_MEMORY
               : TFA_OK;
    free(text);
    return status;
}

/* The same for constraints, which older recordings do not have */
static int read_constraints(const json_t *json, tfa_constraints *constraints, tfa_report *report)
{
    char *text = json ? json_dumps(json, 0) : NULL;
    const int status =
        text   ? tfa_constraints_parse(text, strlen(text), "constraints of the recording",
                                       constraints, report)
        : json ? TFA_E_MEMORY
               : TFA_OK;
    free(text);
    return status;
}

/* @return TFA_OK, TFA_E_MEMORY */
static int read_rotors(const json_t *list, scene_lists *s)
{
    const size_t count = json_array_size(list);
    s->rotors = calloc(count + 1, sizeof *s->rotors);
    if (!s->rotors)
        return TFA_E_MEMORY;
    for (size_t i = 0; i < count; i++) {
        const json_t *from = json_array_get(list, i);
        s->rotors[i].joint = or_empty(text_of(from, "joint"));
        s->rotors[i].inertia = json_number_value(json_object_get(from, "value"));
    }
    s->scene.rotors = s->rotors;
    s->scene.rotor_count = count;
    return TFA_OK;
}

/* @return TFA_OK, TFA_E_MEMORY */
static int read_scene(const json_t *json, scene_lists *s)
{
    const json_t *tips = json_object_get(json, "tips"), *locks = json_object_get(json, "locks"),
                 *payloads = json_object_get(json, "payloads");
    const size_t tip_count = json_array_size(tips), lock_count = json_array_size(locks),
                 payload_count = json_array_size(payloads);
    s->tips = calloc(tip_count + 1, sizeof *s->tips);
    s->locks = calloc(lock_count + 1, sizeof *s->locks);
    s->payloads = calloc(payload_count + 1, sizeof *s->payloads);
    if (!s->tips || !s->locks || !s->payloads)
        return TFA_E_MEMORY;
    for (size_t i = 0; i < tip_count; i++)
        s->tips[i] = or_empty(json_string_value(json_array_get(tips, i)));
    for (size_t i = 0; i < lock_count; i++) {
        const json_t *from = json_array_get(locks, i);
        s->locks[i].joint = or_empty(text_of(from, "joint"));
        (void)numbers_of(from, "q", s->locks[i].q, 7);
    }
    for (size_t i = 0; i < payload_count; i++) {
        const json_t *from = json_array_get(payloads, i);
        s->payloads[i].link = or_empty(text_of(from, "link"));
        s->payloads[i].mass = json_number_value(json_object_get(from, "mass"));
        (void)numbers_of(from, "com", s->payloads[i].com, 3);
        (void)numbers_of(from, "inertia", s->payloads[i].inertia, 6);
    }
    s->scene = (tfa_scene){.root = text_of(json, "root"),
                           .tips = s->tips,
                           .tip_count = tip_count,
                           .locks = s->locks,
                           .lock_count = lock_count,
                           .payloads = s->payloads,
                           .payload_count = payload_count,
                           .modes = s->modes.links,
                           .modes_count = s->modes.count,
                           .constraints = s->constraints.list,
                           .constraint_count = s->constraints.count,
                           .actuated = s->constraints.actuated,
                           .actuated_count = s->constraints.actuated_count};
    return TFA_OK;
}

static int set_armature(const json_t *list, tfa_description *description)
{
    size_t i;
    json_t *item;
    json_array_foreach(list, i, item)
    {
        const char *name = text_of(item, "joint");
        size_t k = 0;
        while (name && k < description->joint_count &&
               strcmp(description->joints[k].name, name) != 0)
            k++;
        if (!name || k == description->joint_count)
            return TFA_E_JOINT;
        description->joints[k].armature = json_number_value(json_object_get(item, "value"));
    }
    return TFA_OK;
}

static int compile(const json_t *json, tfa_description *description, tfa_report *report,
                   tfa_model **model)
{
    const json_t *scene = json_object_get(json, "scene");
    double gravity[3] = {0, 0, -9.80665};
    scene_lists lists = {0};
    (void)numbers_of(json, "gravity", gravity, 3);
    int status = set_armature(json_object_get(json, "armature"), description);
    if (status == TFA_OK && json_is_object(scene))
        status = read_modes(json_object_get(scene, "modes"), &lists.modes, report);
    if (status == TFA_OK && json_is_object(scene))
        status =
            read_constraints(json_object_get(scene, "constraints"), &lists.constraints, report);
    if (status == TFA_OK && json_is_object(scene))
        status = read_scene(scene, &lists);
    if (status == TFA_OK)
        status = read_rotors(json_object_get(json, "rotors"), &lists);
    const tfa_model_options options = {
        .base = (tfa_base)number_of(json, "base"),
        .gravity = gravity,
        .rotor_inertia = number_of(json, "rotor_inertia"),
        .damping = number_of(json, "damping"),
        .friction = number_of(json, "friction"),
        .friction_velocity = json_number_value(json_object_get(json, "friction_velocity")),
        .lock_massless_leaves = number_of(json, "lock_massless_leaves"),
        .inertia = (tfa_inertia_policy)number_of(json, "inertia"),
        .mimic = (tfa_mimic_policy)number_of(json, "mimic"),
        .snap = json_number_value(json_object_get(json, "snap")),
        .scene = &lists.scene};
    if (status == TFA_OK)
        status = tfa_model_create(description, &options, report, model);
    free_scene(&lists);
    return status;
}

static void print_errors(const tfa_report *report)
{
    char text[512];
    for (size_t i = 0; i < report->count; i++)
        if (report->messages[i].severity == TFA_ERROR) {
            (void)tfa_report_format(report, i, text, sizeof text);
            fprintf(stderr, "%s\n", text);
        }
}

tfa_model *recorded_robot_compile(const recorded_robot *r, const char *name, const char *urdf,
                                  size_t bytes)
{
    tfa_report report = {.syntax = TFA_SYNTAX_YAML};
    tfa_description *description = NULL;
    tfa_model *model = NULL;
    int status = tfa_urdf_parse(urdf, bytes, name, &description, &report);
    if (status == TFA_OK)
        status = compile(json_object_get(r->json, "options"), description, &report, &model);
    print_errors(&report);
    if (status != TFA_OK && report.errors == 0)
        fprintf(stderr, "%s: error: %s: %s\n", name, tfa_status_text(status),
                tfa_status_cause(status));
    tfa_description_free(description);
    tfa_report_free(&report);
    return model;
}
