/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads a robot with its answers in quadruple precision.
 */
#include "reference_robot.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

static int numbers(const json_t *state, const char *key, uint32_t count, double *out)
{
    const json_t *list = json_object_get(state, key);
    if (json_array_size(list) != count) {
        printf("%s: %zu values, wanted %u\n", key, json_array_size(list), count);
        return -1;
    }
    for (uint32_t i = 0; i < count; i++)
        out[i] = json_number_value(json_array_get(list, i));
    return 0;
}

/* The reference's joint i is the library's joint places[i]. */
static int joints(const json_t *state, const char *key, const uint32_t *places, uint32_t count,
                  double **out)
{
    double *raw = calloc(count + 1, sizeof *raw);
    *out = calloc(count + 1, sizeof **out);
    int bad = !raw || !*out || numbers(state, key, count, raw) != 0;
    for (uint32_t i = 0; !bad && i < count; i++)
        (*out)[places[i]] = raw[i];
    free(raw);
    return bad ? -1 : 0;
}

static int read_base(const json_t *json, reference_state *state)
{
    int bad = numbers(json, "base_pos", 3, state->base_pose);
    bad |= numbers(json, "base_quat_xyzw", 4, state->base_pose + 3);
    bad |= numbers(json, "base_twist", 6, state->base_twist);
    bad |= numbers(json, "base_wrench", 6, state->base_wrench);
    bad |= numbers(json, "base_acc", 6, state->base_acc);
    bad |= numbers(json, "base_nle", 6, state->base_nle);
    return bad;
}

static int read_state(const json_t *json, const uint32_t *places, const reference_robot *robot,
                      reference_state *state)
{
    int bad = joints(json, "q", places, robot->joints, &state->q);
    bad |= joints(json, "v", places, robot->joints, &state->v);
    bad |= joints(json, "tau", places, robot->joints, &state->tau);
    bad |= joints(json, "qdd", places, robot->joints, &state->qdd);
    bad |= joints(json, "nle", places, robot->joints, &state->nle);
    bad |= numbers(json, "lambda_inv", 36, state->lambda_inv);
    return robot->floating ? bad | read_base(json, state) : bad;
}

static int read_states(reference_robot *robot, const json_t *root)
{
    const json_t *names = json_object_get(root, "joints"), *list = json_object_get(root, "states");
    uint32_t *places = calloc(robot->joints + 1, sizeof *places);
    int bad = !places || json_array_size(names) != robot->joints;
    if (bad)
        printf("%zu joints in the reference, %u in the model\n", json_array_size(names),
               robot->joints);
    for (uint32_t i = 0; !bad && i < robot->joints; i++) {
        const char *name = json_string_value(json_array_get(names, i));
        int32_t joint = tfa_model_find_joint(robot->model, name);
        bad = joint < 0;
        if (bad)
            printf("joint %s is not in the model\n", name);
        else
            places[i] = tfa_model_joint(robot->model, (uint32_t)joint).v_index;
    }
    robot->count = (uint32_t)json_array_size(list);
    robot->states = calloc(robot->count + 1, sizeof *robot->states);
    bad |= !robot->states;
    for (uint32_t k = 0; !bad && k < robot->count; k++)
        bad = read_state(json_array_get(list, k), places, robot, &robot->states[k]);
    free(places);
    return bad ? -1 : 0;
}

static int load_model(reference_robot *robot, const json_t *root, const char *robots)
{
    char path[1024];
    double gravity[3];
    tfa_report report = {0};
    tfa_model_options options = {.gravity = gravity};
    robot->floating = strcmp(json_string_value(json_object_get(root, "base")), "floating") == 0;
    options.base = robot->floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
    snprintf(path, sizeof path, "%s/%s", robots, json_string_value(json_object_get(root, "urdf")));
    if (numbers(root, "gravity", 3, gravity) != 0)
        return -1;
    int status = tfa_model_load(path, &options, &report, &robot->model);
    if (status == TFA_OK) {
        const tfa_workspace_options own = {.specialised = kernels_find(robot->model)};
        status = tfa_workspace_create(robot->model, &own, &robot->workspace);
    }
    for (size_t i = 0; status != TFA_OK && i < report.count; i++) {
        char text[1024];
        tfa_report_format(&report, i, text, sizeof text);
        printf("%s\n", text);
    }
    tfa_report_free(&report);
    if (status != TFA_OK) {
        printf("%s: %s\n", path, tfa_status_text(status));
        return -1;
    }
    robot->joints = tfa_model_v_count(robot->model);
    const char *tip = json_string_value(json_object_get(root, "tip_link"));
    int32_t frame = tfa_model_find_frame(robot->model, tip);
    if (frame < 0)
        printf("link %s is not in the model\n", tip);
    robot->tip = (uint32_t)frame;
    return frame < 0 ? -1 : 0;
}

int reference_load(reference_robot *robot, const char *path, const char *robots)
{
    json_error_t why;
    *robot = (reference_robot){0};
    json_t *root = json_load_file(path, 0, &why);
    if (!root) {
        printf("%s: %s\n", path, why.text);
        return -1;
    }
    int bad = load_model(robot, root, robots);
    if (!bad)
        bad = read_states(robot, root);
    json_decref(root);
    if (bad)
        reference_free(robot);
    return bad;
}

void reference_free(reference_robot *robot)
{
    for (uint32_t k = 0; robot->states && k < robot->count; k++) {
        reference_state *state = &robot->states[k];
        free(state->q);
        free(state->v);
        free(state->tau);
        free(state->qdd);
        free(state->nle);
    }
    free(robot->states);
    tfa_workspace_free(robot->workspace);
    tfa_model_free(robot->model);
    *robot = (reference_robot){0};
}
