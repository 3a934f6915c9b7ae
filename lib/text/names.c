/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names and sizes of a robot, from its model or from a daemon's description.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* Joints named in a message before it says "...": long enough for an arm, short for a chain. */
enum { NAMES_LISTED_MAX = 8 };

static int allocate(tfa_names *names)
{
    names->joints = calloc(names->joint_count + (size_t)1, sizeof *names->joints);
    names->frames = calloc(names->frame_count + (size_t)1, sizeof *names->frames);
    names->by_name =
        calloc((size_t)names->joint_count + names->frame_count + 1, sizeof *names->by_name);
    names->mode_frames = calloc(names->mode_count + (size_t)1, sizeof *names->mode_frames);
    names->constraints = calloc(names->constraint_count + (size_t)1, sizeof *names->constraints);
    if (names->joints && names->frames && names->by_name && names->mode_frames &&
        names->constraints)
        return TFA_OK;
    tfa_names_free(names);
    return TFA_E_MEMORY;
}

/* ---- by name ---- */

static const char *joint_name(const void *names, size_t index)
{
    return ((const tfa_names *)names)->joints[index].name;
}

static const char *frame_name(const void *names, size_t index)
{
    return ((const tfa_names *)names)->frames[index];
}

static const char *constraint_name(const void *names, size_t index)
{
    return ((const tfa_names *)names)->constraints[index];
}

static int compare_joints(const void *a, const void *b, void *names)
{
    return strcmp(joint_name(names, *(const uint32_t *)a), joint_name(names, *(const uint32_t *)b));
}

static int compare_frames(const void *a, const void *b, void *names)
{
    return strcmp(frame_name(names, *(const uint32_t *)a), frame_name(names, *(const uint32_t *)b));
}

static void sort(tfa_names *names)
{
    uint32_t *frames = names->by_name + names->joint_count;
    for (uint32_t k = 0; k < names->joint_count; k++)
        names->by_name[k] = k;
    for (uint32_t k = 0; k < names->frame_count; k++)
        frames[k] = k;
    qsort_r(names->by_name, names->joint_count, sizeof *frames, compare_joints, names);
    qsort_r(frames, names->frame_count, sizeof *frames, compare_frames, names);
}

static int32_t find(const tfa_names *names, const uint32_t *order, uint32_t count,
                    tfa_list_name name_of, const char *name)
{
    uint32_t first = 0;
    while (first < count) {
        const uint32_t middle = first + (count - first) / 2;
        const int order_of_name = strcmp(name, name_of(names, order[middle]));
        if (order_of_name == 0)
            return (int32_t)order[middle];
        if (order_of_name < 0)
            count = middle;
        else
            first = middle + 1;
    }
    return -1;
}

int32_t tfa_names_joint(const tfa_names *names, const char *name)
{
    return find(names, names->by_name, names->joint_count, joint_name, name);
}

int32_t tfa_names_link(const tfa_names *names, const char *name)
{
    return find(names, names->by_name + names->joint_count, names->frame_count, frame_name, name);
}

int32_t tfa_names_constraint(const tfa_names *names, const char *name)
{
    for (uint32_t k = 0; k < names->constraint_count; k++)
        if (strcmp(names->constraints[k], name) == 0)
            return (int32_t)k;
    return -1;
}

void tfa_names_unknown_joint(const tfa_names *names, const char *wrong, char *text, size_t size)
{
    char nearest[200], robot[600];
    tfa_suggest(wrong, names, names->joint_count, joint_name, nearest, sizeof nearest);
    (void)tfa_names_describe(names, 0, robot, sizeof robot);
    snprintf(text, size, "no moving joint '%.200s'; nearest: %s; the robot has %s", wrong, nearest,
             robot);
}

void tfa_names_unknown_link(const tfa_names *names, const char *wrong, char *text, size_t size)
{
    char nearest[200];
    tfa_suggest(wrong, names, names->frame_count, frame_name, nearest, sizeof nearest);
    snprintf(text, size, "no link '%.200s' in the robot; nearest: %s", wrong, nearest);
}

void tfa_names_unknown_constraint(const tfa_names *names, const char *wrong, char *text,
                                  size_t size)
{
    char nearest[200], robot[600];
    tfa_suggest(wrong, names, names->constraint_count, constraint_name, nearest, sizeof nearest);
    (void)tfa_names_describe_constraints(names, robot, sizeof robot);
    snprintf(text, size, "no constraint '%.200s'%s%s; the robot has %s", wrong,
             names->constraint_count ? "; nearest: " : "", names->constraint_count ? nearest : "",
             robot);
}

/* ---- from a model, from a daemon ---- */

int tfa_names_of_model(tfa_names *names, const tfa_model *model)
{
    *names = (tfa_names){.robot = tfa_model_name(model),
                         .q_count = tfa_model_q_count(model),
                         .v_count = tfa_model_v_count(model),
                         .base_freedoms = tfa_model_base_freedoms(model),
                         .joint_count = tfa_model_joint_count(model),
                         .frame_count = tfa_model_frame_count(model),
                         .mode_count = tfa_model_mode_count(model),
                         .constraint_count = tfa_model_constraint_count(model)};
    if (allocate(names) != TFA_OK)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < names->joint_count; k++) {
        const tfa_joint_info joint = tfa_model_joint(model, k);
        names->joints[k] =
            (tfa_joint_span){joint.name,    tfa_joint_type_describe(joint.type).quaternion,
                             joint.q_index, joint.q_count,
                             joint.v_index, joint.v_count};
    }
    for (uint32_t k = 0; k < names->frame_count; k++)
        names->frames[k] = tfa_model_frame(model, k).name;
    for (uint32_t k = 0; k < names->mode_count; k++)
        names->mode_frames[k] =
            (uint32_t)tfa_model_find_frame(model, tfa_model_mode(model, k).link);
    for (uint32_t k = 0; k < names->constraint_count; k++)
        names->constraints[k] = tfa_model_constraint(model, k).name;
    sort(names);
    return TFA_OK;
}

int tfa_names_of_info(tfa_names *names, const char *robot, const tfa_client_info *info)
{
    uint32_t q = 0, v = 0;
    *names = (tfa_names){.robot = robot,
                         .q_count = info->q_count,
                         .v_count = info->v_count,
                         .base_freedoms = info->base_freedoms,
                         .joint_count = info->joint_count,
                         .frame_count = info->frame_count,
                         .mode_count = info->mode_count,
                         .constraint_count = info->constraint_count};
    if (info->constraint_count > TFA_MAX_CONSTRAINTS) {
        *names = (tfa_names){0};
        return TFA_E_PROTOCOL;
    }
    if (allocate(names) != TFA_OK)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < names->joint_count; k++) {
        const tfa_joint_type_info type =
            tfa_joint_type_describe(info->joint_types ? info->joint_types[k] : TFA_JOINT_REVOLUTE);
        names->joints[k] = (tfa_joint_span){
            info->joint_names[k], type.quaternion, q, type.coordinates, v, type.freedoms};
        q += type.coordinates;
        v += type.freedoms;
    }
    for (uint32_t k = 0; k < names->frame_count; k++)
        names->frames[k] = info->frame_names[k];
    for (uint32_t k = 0; k < names->mode_count; k++)
        names->mode_frames[k] = info->mode_frames[k];
    for (uint32_t k = 0; k < names->constraint_count; k++)
        names->constraints[k] = info->constraint_names[k];
    sort(names);
    if (q == names->q_count && v == names->v_count)
        return TFA_OK;
    tfa_names_free(names);
    return TFA_E_PROTOCOL;
}

void tfa_names_free(tfa_names *names)
{
    free(names->joints);
    free(names->frames);
    free(names->by_name);
    free(names->mode_frames);
    free(names->constraints);
    *names = (tfa_names){0};
}

/* ---- owners ---- */

const char *tfa_names_frame(const tfa_names *names, uint32_t frame)
{
    return frame < names->frame_count ? names->frames[frame] : "?";
}

const char *tfa_names_active(const tfa_names *names, uint32_t constraints, uint32_t k)
{
    for (; k && constraints; k--)
        constraints &= constraints - 1;
    const uint32_t at = constraints ? (uint32_t)__builtin_ctz(constraints) : UINT32_MAX;
    return at < names->constraint_count ? names->constraints[at] : "?";
}

const tfa_joint_span *tfa_names_owner(const tfa_names *names, int of_q, uint32_t index)
{
    for (uint32_t k = 0; k < names->joint_count; k++) {
        const tfa_joint_span *joint = &names->joints[k];
        const uint32_t first = of_q ? joint->q_index : joint->v_index;
        const uint32_t count = of_q ? joint->q_count : joint->v_count;
        if (index >= first && index - first < count)
            return joint;
    }
    return NULL;
}

size_t tfa_names_describe(const tfa_names *names, int of_q, char *text, size_t size)
{
    const uint32_t numbers = of_q ? names->q_count : names->v_count, joints = names->joint_count;
    size_t used = 0;
#define REST used < size ? text + used : NULL, used < size ? size - used : 0
    if (numbers != joints)
        used += (size_t)snprintf(REST, "%u %s in ", numbers, of_q ? "coordinates" : "freedoms");
    used += (size_t)snprintf(REST, "%u joint%s", joints, joints == 1 ? "" : "s");
    for (uint32_t k = 0; k < joints && k < NAMES_LISTED_MAX; k++)
        used += (size_t)snprintf(REST, "%s%s", k ? ", " : " (", names->joints[k].name);
    if (joints)
        used += (size_t)snprintf(REST, "%s", joints > NAMES_LISTED_MAX ? ", ...)" : ")");
    return used;
}

size_t tfa_names_describe_constraints(const tfa_names *names, char *text, size_t size)
{
    const uint32_t count = names->constraint_count;
    size_t used = 0;
    if (!count)
        return (size_t)snprintf(text, size,
                                "no constraints; `constraints` of its scene give it some");
    used += (size_t)snprintf(REST, "%u constraint%s", count, count == 1 ? "" : "s");
    for (uint32_t k = 0; k < count && k < NAMES_LISTED_MAX; k++)
        used += (size_t)snprintf(REST, "%s%s", k ? ", " : " (", names->constraints[k]);
    used += (size_t)snprintf(REST, "%s", count > NAMES_LISTED_MAX ? ", ...)" : ")");
    return used;
}
