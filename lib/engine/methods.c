/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of methods, and the names of request fields.
 */
#include "engine/methods.h"

#include <string.h>

#include "model/model.h"

static const tfa_method_info method_table[] = {
#define METHOD_ROW(name, number, text, ops, factors, cost, refuses, summary)                       \
    [number] = {TFA_METHOD_##name,                                                                 \
                text,                                                                              \
                ops,                                                                               \
                ((ops)&TFA_OPS_FD) != 0,                                                           \
                ((ops)&TFA_OPS_OSIM) != 0,                                                         \
                TFA_METHOD_##factors,                                                              \
                cost,                                                                              \
                refuses,                                                                           \
                summary},
    TFA_METHOD_LIST(METHOD_ROW)
#undef METHOD_ROW
};

const tfa_method_info *tfa_method_describe(uint32_t method)
{
    return method < sizeof method_table / sizeof *method_table ? &method_table[method] : NULL;
}

const char *tfa_refusal_text(unsigned refusal)
{
    switch (refusal) {
    case TFA_REFUSES_NO_INVERSE:
        return "a body of a main chain whose inertia has no inverse";
    case TFA_REFUSES_ARMATURE:
        return "rotor inertia on a main chain";
    case TFA_REFUSES_LENGTH:
        return "a main chain of more than 130 bodies";
    case TFA_REFUSES_SIZE:
        return "robots whose M has more than 4 Mi entries";
    case TFA_REFUSES_LOCKED:
        return "joints locked by the request";
    case TFA_REFUSES_MIMICS:
        return "mimic joints that are projected";
    case TFA_REFUSES_MASSLESS_FOLLOWER:
        return "mimic joints that move no mass of their own";
    case TFA_REFUSES_TIPS:
        return "tips";
    case TFA_REFUSES_MODES:
        return "flexible links";
    default:
        return "";
    }
}

const char *tfa_limit_text(const tfa_reply *reply)
{
    if (reply->status != TFA_E_UNSUPPORTED)
        return "";
    switch (reply->index) {
    case TFA_DERIVATIVES_FREEDOMS_MAX:
        return "the limit is 256 freedoms; differences of forward_dynamics, or a scene with fewer "
               "joints, answer";
    case TFA_MASS_ENTRIES_MAX:
        return "the limit is 4 Mi entries of M (a chain of 2895 bodies); aba and rnea need no M";
    case TFA_HESSENBERG_LONGEST:
        return "the limit is a main chain of 130 bodies; tfa and auto answer";
    default:
        return "";
    }
}

int32_t tfa_method_find(const char *name)
{
    for (size_t k = 0; k < sizeof method_table / sizeof *method_table; k++)
        if (strcmp(method_table[k].name, name) == 0)
            return (int32_t)method_table[k].method;
    return -1;
}

const char *tfa_method_name(uint32_t method)
{
    const tfa_method_info *row = tfa_method_describe(method);
    return row ? row->name : "unknown";
}

const char *tfa_fallback_text(unsigned flags)
{
    if (!(flags & TFA_ANSWER_FALLBACK))
        return "";
    return flags & TFA_ANSWER_NOT_FINITE   ? "not finite"
           : flags & TFA_ANSWER_INACCURATE ? "inaccurate"
           : flags & TFA_ANSWER_STALLED    ? "stalled"
                                           : "not there";
}

const char *tfa_field_name(tfa_field field)
{
    static const char *const names[] = {
        [TFA_FIELD_NONE] = "",
        [TFA_FIELD_OP] = "op",
        [TFA_FIELD_METHOD] = "method",
        [TFA_FIELD_COUNT] = "count",
        [TFA_FIELD_TIPS] = "tips",
        [TFA_FIELD_WRENCHES] = "wrench",
        [TFA_FIELD_Q] = "q",
        [TFA_FIELD_V] = "v",
        [TFA_FIELD_TAU] = "tau",
        [TFA_FIELD_QDD] = "qdd",
        [TFA_FIELD_BASE_POSE] = "base_pose",
        [TFA_FIELD_BASE_TWIST] = "base_twist",
        [TFA_FIELD_BASE_WRENCH] = "base_wrench",
        [TFA_FIELD_BASE_ACCELERATION] = "base_acceleration",
        [TFA_FIELD_GRAVITY] = "gravity",
        [TFA_FIELD_REFINE] = "refine",
        [TFA_FIELD_FRAME] = "frame",
        [TFA_FIELD_ESTIMATE] = "estimate",
        [TFA_FIELD_LOCKED] = "locked",
        [TFA_FIELD_PAYLOADS] = "payload",
        [TFA_FIELD_ROWS] = "rows",
        [TFA_FIELD_RANK_LOSS] = "rank_loss",
        [TFA_FIELD_RANK_THRESHOLD] = "rank_threshold",
        [TFA_FIELD_CHARACTERISTIC_LENGTH] = "characteristic_length",
        [TFA_FIELD_TASK_ACCELERATION] = "acceleration",
        [TFA_FIELD_FLAGS] = "want",
        [TFA_FIELD_MODES] = "modes",
        [TFA_FIELD_MODE_VELOCITIES] = "mode_velocities",
        [TFA_FIELD_BODY] = "body",
        [TFA_FIELD_COST] = "cost",
        [TFA_FIELD_CONSTRAINTS] = "constraints",
        [TFA_FIELD_CONSTRAINT_ACCELERATION] = "constraint_acceleration",
        [TFA_FIELD_STABILISATION] = "stabilisation",
        [TFA_FIELD_TORQUE_WEIGHTS] = "torque_weights",
    };
    if ((unsigned)field >= sizeof names / sizeof *names)
        return "";
    return names[field];
}

const char *tfa_base_field_name(const char *joint_field)
{
    if (strcmp(joint_field, "posture_torques") == 0)
        joint_field = tfa_field_name(TFA_FIELD_TAU);
    for (int k = TFA_FIELD_Q; k <= TFA_FIELD_QDD; k++)
        if (strcmp(joint_field, tfa_field_name((tfa_field)k)) == 0)
            return tfa_field_name((tfa_field)(k + TFA_FIELD_BASE_POSE - TFA_FIELD_Q));
    return "";
}
