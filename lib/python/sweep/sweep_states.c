/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout of the records of states, and the ranges of their numbers.
 */
#include "sweep_states.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers of the generator are those of the whole record, whatever the op reads of it: q of a state
 * is the same for every op. */
static void lay_out(state_record *r, const tfa_model *model, tfa_op op)
{
    const int moves = op == TFA_OP_FORWARD_DYNAMICS || op == TFA_OP_INVERSE_DYNAMICS;
    const int floats = tfa_model_base_freedoms(model) > 0;
    const uint32_t q = tfa_model_q_count(model), v = tfa_model_v_count(model);
    const uint32_t sizes[STATE_FIELDS] = {floats ? 7 : 0,          floats && moves ? 6 : 0,
                                          floats && moves ? 6 : 0, q,
                                          moves ? v : 0,           moves ? v : 0};
    r->width = 0;
    for (int field = 0; field < STATE_FIELDS; field++) {
        r->at[field] = r->width;
        r->size[field] = sizes[field];
        r->width += sizes[field];
    }
}

static int allocate(state_record *r, const tfa_model *model)
{
    r->counter = calloc(r->width + 1, sizeof *r->counter);
    r->low = calloc(r->width + 1, sizeof *r->low);
    r->span = calloc(r->width + 1, sizeof *r->span);
    r->quaternion = calloc(tfa_model_joint_count(model) + 1, sizeof *r->quaternion);
    return r->counter && r->low && r->span && r->quaternion ? TFA_OK : TFA_E_MEMORY;
}

static void set_range(state_record *r, uint32_t at, double low, double high)
{
    r->low[at] = low;
    r->span[at] = high - low;
}

static void set_range_of(state_record *r, state_field field, double half)
{
    for (uint32_t k = 0; k < r->size[field]; k++)
        set_range(r, r->at[field] + k, -half, half);
}

/* Lengths and quaternions within 1, angles in rad within pi, unless the file has limits. */
static double half_range(const tfa_joint_info *joint, uint32_t coordinate)
{
    const tfa_joint_type_info type = tfa_joint_type_describe(joint->type);
    return coordinate < type.lengths || type.quaternion >= 0 ? 1.0 : M_PI;
}

static void set_joint(state_record *r, const tfa_joint_info *joint, const tfa_joint_limits *limits)
{
    const uint32_t at = r->at[STATE_Q] + joint->q_index;
    for (uint32_t k = 0; k < joint->q_count; k++)
        set_range(r, at + k, -half_range(joint, k), half_range(joint, k));
    if (limits && limits->limited && joint->q_count == 1)
        set_range(r, at, limits->lower, limits->upper);
    const int32_t quaternion = tfa_joint_type_describe(joint->type).quaternion;
    if (quaternion >= 0)
        r->quaternion[r->quaternion_count++] = at + (uint32_t)quaternion;
}

static void set_counters(state_record *r)
{
    for (int field = 0; field < STATE_FIELDS; field++)
        for (uint32_t k = 0; k < r->size[field]; k++)
            r->counter[r->at[field] + k] =
                ((uint64_t)field << 28 | k) * UINT64_C(0xd1342543de82ef95);
}

int state_record_make(state_record *r, const tfa_model *model, tfa_op op,
                      const tfa_joint_limits *limits, const state_ranges *ranges)
{
    *r = (state_record){0};
    lay_out(r, model, op);
    if (allocate(r, model) != TFA_OK) {
        state_record_free(r);
        return TFA_E_MEMORY;
    }
    const double force = op == TFA_OP_INVERSE_DYNAMICS ? ranges->acceleration : ranges->force;
    set_counters(r);
    set_range_of(r, STATE_BASE_POSE, 1.0);
    set_range_of(r, STATE_BASE_TWIST, ranges->velocity);
    set_range_of(r, STATE_BASE_FORCE, force);
    set_range_of(r, STATE_V, ranges->velocity);
    set_range_of(r, STATE_FORCE, force);
    if (r->size[STATE_BASE_POSE])
        r->quaternion[r->quaternion_count++] = r->at[STATE_BASE_POSE] + 3;
    for (uint32_t j = 0; j < tfa_model_joint_count(model); j++) {
        const tfa_joint_info joint = tfa_model_joint(model, j);
        set_joint(r, &joint, limits ? &limits[j] : NULL);
    }
    return TFA_OK;
}

void state_record_free(state_record *r)
{
    free(r->counter);
    free(r->low);
    free(r->span);
    free(r->quaternion);
    *r = (state_record){0};
}

void state_record_scatter(const state_record *r, const double *records, uint32_t count,
                          double *const fields[STATE_FIELDS])
{
    for (int field = 0; field < STATE_FIELDS; field++) {
        const uint32_t size = r->size[field];
        const double *from = records + r->at[field];
        double *to = fields[field];
        for (uint32_t s = 0; size && s < count; s++, from += r->width, to += size)
            for (uint32_t k = 0; k < size; k++)
                to[k] = from[k];
    }
}
