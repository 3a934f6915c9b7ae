/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes as a line. What is accepted is finite and within the robot's sizes,
 * what is refused has a sentence, and either reply is JSON.
 */
#include "interface/fields.h"
#include "jsonl/jsonl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const joints[] = {"hinge", "plane", "free"};
static const uint32_t types[] = {TFA_JOINT_REVOLUTE, TFA_JOINT_PLANAR, TFA_JOINT_FLOATING};
static const uint32_t modes[] = {1, 1, 0};
static const char *const links[] = {"base", "tip"};
static const char *const constraints[] = {"loop", "foot"};
static const tfa_client_info robots[] = {
    {.q_count = 11,
     .v_count = 10,
     .joint_count = 3,
     .frame_count = 2,
     .joint_names = joints,
     .joint_types = types,
     .frame_names = links,
     .constraint_count = 2,
     .constraint_names = constraints},
    {.q_count = 1,
     .v_count = 1,
     .base_freedoms = 6,
     .joint_count = 1,
     .frame_count = 2,
     .joint_names = joints,
     .frame_names = links,
     .mode_count = 3,
     .mode_frames = modes},
};

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void require(int condition)
{
    if (!condition)
        abort();
}

static void check_reply(const char *text)
{
    json_t *reply = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    require(reply && json_is_string(json_object_get(reply, "status")));
    require(strchr(text, '\n') == text + strlen(text) - 1);
    json_decref(reply);
}

/* Joints that exist, each once. */
static void check_joints(const uint32_t *list, uint32_t count, const tfa_names *names)
{
    require(count <= names->joint_count);
    for (uint32_t i = 0; i < count; i++) {
        require(list[i] < names->joint_count);
        for (uint32_t k = 0; k < i; k++)
            require(list[k] != list[i]);
    }
}

/* Flags, rows and ranks that exist; finite accelerations of all tips. */
static void check_task(const tfa_request *request)
{
    require((request->flags & ~TFA_WANT_ALL) == 0);
    require((unsigned)request->rows <= TFA_ROWS_POINT);
    require((unsigned)request->rank_loss <= TFA_RANK_REFUSE);
    if (request->rank_threshold)
        require(*request->rank_threshold > 0 && *request->rank_threshold < 1);
    if (request->op != TFA_OP_TASK_TORQUES)
        return;
    require(request->tip_count > 0 && request->task_acceleration);
    const uint32_t rows = request->rows == TFA_ROWS_POINT ? 3 : 6;
    for (uint32_t i = 0; i < rows * request->tip_count; i++)
        require(isfinite(request->task_acceleration[i]));
}

/* Constraints that exist; finite accelerations, gains and weights. */
static void check_constraints(const tfa_request *request, const tfa_names *names)
{
    require((request->constraints & ~tfa_all_constraints(names->constraint_count)) == 0);
    const size_t count = tfa_constraint_numbers(request);
    for (size_t i = 0; request->constraint_acceleration && i < count; i++)
        require(isfinite(request->constraint_acceleration[i]));
    for (size_t i = 0; request->stabilisation && i < 2; i++)
        require(isfinite(request->stabilisation[i]));
    for (size_t i = 0; request->torque_weights && i < names->v_count; i++)
        require(isfinite(request->torque_weights[i]));
}

static void check_request(const tfa_request *request, const tfa_names *names)
{
    require(request->count == 1 && request->tip_count <= TFA_MAX_TIPS);
    require(request->wrench_count <= TFA_MAX_WRENCHES);
    for (uint32_t i = 0; i < names->q_count; i++)
        require(isfinite(request->q[i]));
    for (uint32_t i = 0; i < request->tip_count; i++)
        require(request->tips[i] < names->frame_count);
    require(request->payload_count <= TFA_MAX_PAYLOADS);
    for (uint32_t i = 0; i < request->payload_count; i++)
        require(request->payload_frames[i] < names->frame_count);
    for (uint32_t i = 0; i < request->payload_count * TFA_PAYLOAD_NUMBERS; i++)
        require(isfinite(request->payloads[i]));
    check_joints(request->locked, request->locked_count, names);
    check_task(request);
    check_constraints(request, names);
}

static void answer_line(const tfa_client_info *info, const char *line, size_t size)
{
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    tfa_names names;
    jsonl_buffers buffers;
    json_t *object = NULL;
    tfa_request request;
    tfa_reply reply;
    jsonl_error error = {0};
    char *text = NULL;
    size_t length = 0;
    require(tfa_names_of_info(&names, "robot", info) == TFA_OK);
    require(jsonl_buffers_init(&buffers, &names) == TFA_OK);
    int status = jsonl_load(line, size, 1, &object, &error);
    if (status == TFA_OK)
        status = jsonl_read(object, &names, &defaults, &buffers, &request, &reply, &error);
    FILE *out = open_memstream(&text, &length);
    require(out != NULL);
    if (status == TFA_OK) {
        check_request(&request, &names);
        jsonl_print_reply(out, NULL, &names, &buffers, &request, &reply);
    } else {
        require(error.status == status && error.text[0]);
        jsonl_print_error(out, NULL, &error);
    }
    fclose(out);
    check_reply(text);
    free(text);
    json_decref(object);
    jsonl_buffers_free(&buffers);
    tfa_names_free(&names);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char *line = malloc(size + 1);
    require(line != NULL);
    memcpy(line, bytes, size);
    line[size] = '\0';
    answer_line(&robots[0], line, size);
    answer_line(&robots[1], line, size);
    free(line);
    return 0;
}
