/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Builds the table of names from a model or from a daemon's description.
 */
#include "robot_names.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* Joints named in a message before it says "...": long enough for an arm, short for a chain. */
enum { NAMES_LISTED_MAX = 8 };

static int add(json_t *lookup, const char *name, uint32_t index)
{
    return json_object_set_new_nocheck(lookup, name, json_integer(index)) ? TFA_E_MEMORY : TFA_OK;
}

static int allocate(robot_names *names)
{
    names->joints = calloc(names->joint_count ? names->joint_count : 1, sizeof *names->joints);
    names->joint_lookup = json_object();
    names->frame_lookup = json_object();
    return names->joints && names->joint_lookup && names->frame_lookup ? TFA_OK : TFA_E_MEMORY;
}

static int fill_from_model(robot_names *names, const tfa_model *model)
{
    int status = allocate(names);
    for (uint32_t i = 0; status == TFA_OK && i < names->joint_count; i++) {
        tfa_joint_info joint = tfa_model_joint(model, i);
        names->joints[i] =
            (robot_joint){joint.name,    tfa_joint_type_describe(joint.type).quaternion,
                          joint.q_index, joint.q_count,
                          joint.v_index, joint.v_count};
        status = add(names->joint_lookup, joint.name, i);
    }
    for (uint32_t i = 0; status == TFA_OK && i < names->frame_count; i++)
        status = add(names->frame_lookup, tfa_model_frame(model, i).name, i);
    return status;
}

int robot_names_from_model(robot_names *names, const tfa_model *model)
{
    *names = (robot_names){.robot = tfa_model_name(model),
                           .q_count = tfa_model_q_count(model),
                           .v_count = tfa_model_v_count(model),
                           .base_freedoms = tfa_model_base_freedoms(model),
                           .joint_count = tfa_model_joint_count(model),
                           .frame_count = tfa_model_frame_count(model),
                           .model = model};
    int status = fill_from_model(names, model);
    if (status != TFA_OK)
        robot_names_free(names);
    return status;
}

static int fill_from_info(robot_names *names, const tfa_client_info *info)
{
    int status = allocate(names);
    uint32_t q = 0, v = 0;
    for (uint32_t i = 0; status == TFA_OK && i < names->joint_count; i++) {
        const tfa_joint_type_info type =
            tfa_joint_type_describe(info->joint_types ? info->joint_types[i] : TFA_JOINT_REVOLUTE);
        names->joints[i] = (robot_joint){
            info->joint_names[i], type.quaternion, q, type.coordinates, v, type.freedoms};
        q += type.coordinates;
        v += type.freedoms;
        status = add(names->joint_lookup, info->joint_names[i], i);
    }
    for (uint32_t i = 0; status == TFA_OK && i < names->frame_count; i++)
        status = add(names->frame_lookup, info->frame_names[i], i);
    if (status == TFA_OK && (q != names->q_count || v != names->v_count))
        status = TFA_E_PROTOCOL;
    return status;
}

int robot_names_from_info(robot_names *names, const char *robot, const tfa_client_info *info)
{
    *names = (robot_names){.robot = robot,
                           .q_count = info->q_count,
                           .v_count = info->v_count,
                           .base_freedoms = info->base_freedoms,
                           .joint_count = info->joint_count,
                           .frame_count = info->frame_count,
                           .frame_names = info->frame_names};
    int status = fill_from_info(names, info);
    if (status != TFA_OK)
        robot_names_free(names);
    return status;
}

void robot_names_free(robot_names *names)
{
    free(names->joints);
    json_decref(names->joint_lookup);
    json_decref(names->frame_lookup);
    *names = (robot_names){0};
}

static int64_t find_index(const json_t *lookup, const char *name)
{
    const json_t *index = json_object_get(lookup, name);
    return index ? json_integer_value(index) : -1;
}

int64_t robot_names_joint(const robot_names *names, const char *name)
{
    return find_index(names->joint_lookup, name);
}

int64_t robot_names_frame(const robot_names *names, const char *name)
{
    return find_index(names->frame_lookup, name);
}

static const char *joint_name(const void *joints, size_t index)
{
    return ((const robot_joint *)joints)[index].name;
}

static const char *frame_name(const void *names, size_t index)
{
    return robot_names_frame_name(names, (uint32_t)index);
}

void robot_names_suggest_joints(const robot_names *names, const char *wrong, char *text,
                                size_t size)
{
    tfa_suggest(wrong, names->joints, names->joint_count, joint_name, text, size);
}

void robot_names_suggest_frames(const robot_names *names, const char *wrong, char *text,
                                size_t size)
{
    tfa_suggest(wrong, names, names->frame_count, frame_name, text, size);
}

const char *robot_names_frame_name(const robot_names *names, uint32_t frame)
{
    if (frame >= names->frame_count)
        return "?";
    return names->model ? tfa_model_frame(names->model, frame).name : names->frame_names[frame];
}

const robot_joint *robot_names_owner(const robot_names *names, int of_q, uint32_t index)
{
    for (uint32_t i = 0; i < names->joint_count; i++) {
        const robot_joint *joint = &names->joints[i];
        uint32_t first = of_q ? joint->q_index : joint->v_index;
        uint32_t count = of_q ? joint->q_count : joint->v_count;
        if (index >= first && index - first < count)
            return joint;
    }
    return NULL;
}

void robot_names_describe(const robot_names *names, int of_q, char *buffer, size_t size)
{
    uint32_t numbers = of_q ? names->q_count : names->v_count;
    FILE *out = fmemopen(buffer, size, "w");
    if (!out) {
        if (size)
            buffer[0] = '\0';
        return;
    }
    if (numbers != names->joint_count)
        fprintf(out, "%u %s in ", numbers, of_q ? "coordinates" : "freedoms");
    fprintf(out, "%u joint%s", names->joint_count, names->joint_count == 1 ? "" : "s");
    for (uint32_t i = 0; i < names->joint_count && i < NAMES_LISTED_MAX; i++)
        fprintf(out, "%s%s", i ? ", " : " (", names->joints[i].name);
    if (names->joint_count)
        fputs(names->joint_count > NAMES_LISTED_MAX ? ", ...)" : ")", out);
    fclose(out);
    buffer[size - 1] = '\0';
}
