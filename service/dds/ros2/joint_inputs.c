/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See joint_inputs.h.
 */
#include "dds/ros2/joint_inputs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

struct joint {
    char *name;
    double value[TFA_JOINT_VALUE_COUNT];
    int64_t received[TFA_JOINT_VALUE_COUNT];
    uint32_t has;     /* bits 1 << tfa_joint_value */
    uint32_t renewed; /* those received since tfa_joint_inputs_renewed was true */
    uint64_t seen;    /* number of the last message that names it */
};

struct tfa_joint_inputs {
    uint32_t count;
    struct joint *joint;
    uint32_t *sorted; /* joints by name */
    uint32_t *order; /* joint at each place of the last message, as many as joints; NONE: another */
    uint64_t messages;
    tfa_joint_outcome outcome;
    tfa_joint_fault_record fault[TFA_JOINT_FAULT_COUNT];
};

/* ---- the joints ---- */

static int by_name(const void *a, const void *b, void *joints)
{
    const struct joint *joint = joints;
    return strcmp(joint[*(const uint32_t *)a].name, joint[*(const uint32_t *)b].name);
}

tfa_joint_inputs *tfa_joint_inputs_create(const char *const *name, uint32_t count)
{
    tfa_joint_inputs *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->count = count;
    s->joint = calloc(count, sizeof *s->joint);
    s->sorted = calloc(count, sizeof *s->sorted);
    s->order = calloc(count, sizeof *s->order);
    bool made = count == 0 || (s->joint && s->sorted && s->order);
    for (uint32_t j = 0; made && j < count; j++) {
        s->joint[j].name = strdup(name[j]);
        s->sorted[j] = j;
        s->order[j] = NONE;
        made = s->joint[j].name != NULL;
    }
    if (!made) {
        tfa_joint_inputs_free(s);
        return NULL;
    }
    qsort_r(s->sorted, count, sizeof *s->sorted, by_name, s->joint);
    return s;
}

void tfa_joint_inputs_free(tfa_joint_inputs *s)
{
    if (!s)
        return;
    for (uint32_t j = 0; s->joint && j < s->count; j++)
        free(s->joint[j].name);
    free(s->joint);
    free(s->sorted);
    free(s->order);
    free(s);
}

static uint32_t search(const tfa_joint_inputs *s, const char *name)
{
    uint32_t first = 0, end = s->count;
    while (first < end) {
        const uint32_t middle = first + (end - first) / 2;
        const int order = strcmp(name, s->joint[s->sorted[middle]].name);
        if (order == 0)
            return s->sorted[middle];
        if (order < 0)
            end = middle;
        else
            first = middle + 1;
    }
    return NONE;
}

/* The joint at a place of a message: most messages have the order of the last one. */
static uint32_t joint_at(tfa_joint_inputs *s, uint32_t place, const char *name)
{
    if (place >= s->count)
        return search(s, name);
    const uint32_t last = s->order[place];
    if (last == NONE || strcmp(s->joint[last].name, name) != 0)
        s->order[place] = search(s, name);
    return s->order[place];
}

/* ---- faults ---- */

static bool refuse(tfa_joint_inputs *s, tfa_joint_fault fault, tfa_joint_value value,
                   const char *joint)
{
    tfa_joint_fault_record *f = &s->fault[fault];
    f->count++;
    f->value = value;
    if (fault != TFA_JOINT_FAULT_UNKNOWN)
        s->outcome.fault = fault;
    snprintf(f->joint, sizeof f->joint, "%s", joint);
    return false;
}

tfa_joint_outcome tfa_joint_inputs_outcome(const tfa_joint_inputs *s)
{
    return s->outcome;
}

const tfa_joint_fault_record *tfa_joint_inputs_fault(const tfa_joint_inputs *s,
                                                     tfa_joint_fault fault)
{
    return &s->fault[fault];
}

/* ---- messages in ---- */

static bool check_lengths(tfa_joint_inputs *s, const tfa_joint_message *m)
{
    for (int v = 0; v < TFA_JOINT_VALUE_COUNT; v++)
        if (m->value_count[v] != 0 && m->value_count[v] != m->name_count)
            return refuse(s, TFA_JOINT_FAULT_LENGTH, (tfa_joint_value)v, "");
    return true;
}

static bool check_names(tfa_joint_inputs *s, const tfa_joint_message *m)
{
    s->messages++;
    for (uint32_t k = 0; k < m->name_count; k++) {
        const uint32_t j = joint_at(s, k, m->name[k]);
        if (j == NONE)
            continue;
        if (s->joint[j].seen == s->messages)
            return refuse(s, TFA_JOINT_FAULT_TWICE, TFA_JOINT_POSITION, m->name[k]);
        s->joint[j].seen = s->messages;
    }
    return true;
}

/* Each value by itself. @return false: none was finite */
static bool take_values(tfa_joint_inputs *s, uint32_t joint, const tfa_joint_message *m,
                        uint32_t place, uint32_t values, int64_t now)
{
    struct joint *j = &s->joint[joint];
    uint32_t asked = 0, taken = 0;
    for (int v = 0; v < TFA_JOINT_VALUE_COUNT; v++) {
        if (!(values & 1u << v) || !m->value_count[v])
            continue;
        asked++;
        if (!isfinite(m->value[v][place])) {
            (void)refuse(s, TFA_JOINT_FAULT_NOT_FINITE, (tfa_joint_value)v, m->name[place]);
            continue;
        }
        taken++;
        j->value[v] = m->value[v][place];
        j->received[v] = now;
        j->has |= 1u << v;
        j->renewed |= 1u << v;
    }
    return taken || !asked;
}

bool tfa_joint_inputs_merge(tfa_joint_inputs *s, const tfa_joint_message *m, uint32_t values,
                            int64_t now)
{
    s->outcome = (tfa_joint_outcome){.fault = TFA_JOINT_FAULT_COUNT};
    if (!check_lengths(s, m) || !check_names(s, m))
        return false;
    for (uint32_t k = 0; k < m->name_count; k++) {
        const uint32_t j = joint_at(s, k, m->name[k]);
        if (j == NONE)
            (void)refuse(s, TFA_JOINT_FAULT_UNKNOWN, TFA_JOINT_POSITION, m->name[k]);
        else
            s->outcome.taken += take_values(s, j, m, k, values, now);
    }
    return true;
}

void tfa_joint_inputs_adopt(tfa_joint_inputs *s, const tfa_joint_inputs *before)
{
    for (uint32_t j = 0; j < s->count; j++) {
        const uint32_t k = search(before, s->joint[j].name);
        if (k == NONE)
            continue;
        memcpy(s->joint[j].value, before->joint[k].value, sizeof s->joint[j].value);
        memcpy(s->joint[j].received, before->joint[k].received, sizeof s->joint[j].received);
        s->joint[j].has = before->joint[k].has;
    }
    memcpy(s->fault, before->fault, sizeof s->fault);
}

void tfa_joint_inputs_forget(tfa_joint_inputs *s)
{
    for (uint32_t j = 0; j < s->count; j++)
        s->joint[j].has = 0;
}

/* ---- values out ---- */

bool tfa_joint_inputs_renewed(tfa_joint_inputs *s, uint32_t values)
{
    for (uint32_t j = 0; j < s->count; j++)
        if (values & ~s->joint[j].renewed)
            return false;
    for (uint32_t j = 0; j < s->count; j++)
        s->joint[j].renewed = 0;
    return true;
}

int64_t tfa_joint_inputs_age(const tfa_joint_inputs *s, uint32_t joint, tfa_joint_value value,
                             int64_t now)
{
    const struct joint *j = &s->joint[joint];
    return j->has & 1u << value ? now - j->received[value] : -1;
}

bool tfa_joint_inputs_read(tfa_joint_inputs *s, tfa_joint_value value, int64_t now, int64_t age_max,
                           double *out)
{
    s->outcome = (tfa_joint_outcome){.fault = TFA_JOINT_FAULT_COUNT};
    for (uint32_t j = 0; j < s->count; j++) {
        if (!(s->joint[j].has & 1u << value))
            return refuse(s, TFA_JOINT_FAULT_MISSING, value, s->joint[j].name);
        if (now - s->joint[j].received[value] > age_max)
            return refuse(s, TFA_JOINT_FAULT_STALE, value, s->joint[j].name);
    }
    for (uint32_t j = 0; j < s->count; j++)
        out[j] = s->joint[j].value[value];
    return true;
}
