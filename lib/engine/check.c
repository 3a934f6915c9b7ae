/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Validation of a request: choices, sizes, indices. Names the invalid field. Numbers:
 * check_numbers.c.
 */
#include <math.h>

#include "engine/check_numbers.h"
#include "engine/methods.h"
#include "interface/traits.h"
#include "model/model.h"
#include "model/payload.h"

static int check_frames(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    if (r->tip_count > TFA_MAX_TIPS)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_TIPS, r->tip_count, 0);
    if (r->wrench_count > TFA_MAX_WRENCHES)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_WRENCHES, r->wrench_count, 0);
    for (uint32_t t = 0; t < r->tip_count; t++)
        if (r->tips[t] >= m->frames)
            return tfa_set_error(reply, TFA_E_LINK, TFA_FIELD_TIPS, t, 0);
    for (uint32_t t = 0; t < r->wrench_count; t++)
        if (r->wrench_frames[t] >= m->frames)
            return tfa_set_error(reply, TFA_E_LINK, TFA_FIELD_WRENCHES, t, 0);
    return TFA_OK;
}

static int check_payloads(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    if (r->payload_count > TFA_MAX_PAYLOADS)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_PAYLOADS, r->payload_count, 0);
    if (r->payload_count && !r->payloads)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_PAYLOADS, 0, 0);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        const double *numbers = r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k;
        if (r->payload_frames[k] >= m->frames)
            return tfa_set_error(reply, TFA_E_LINK, TFA_FIELD_PAYLOADS, k, 0);
        if (m->frame[r->payload_frames[k]].part || tfa_frame_is_flexible(m, r->payload_frames[k]))
            return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_PAYLOADS, k, 0);
        for (uint32_t e = 0; e < TFA_PAYLOAD_NUMBERS; e++)
            if (!isfinite(numbers[e]))
                return tfa_set_error(reply, TFA_E_VALUE, TFA_FIELD_PAYLOADS, k, 0);
        if (!tfa_payload_is_physical(numbers))
            return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_PAYLOADS, k, 0);
    }
    return TFA_OK;
}

/* Checks joint indices; duplicates are allowed. */
static int check_joints(const struct tfa_model *m, const uint32_t *joints, uint32_t count,
                        tfa_field field, tfa_reply *reply)
{
    if (count > m->joints)
        return tfa_set_error(reply, TFA_E_SIZE, field, count, 0);
    if (count && !joints)
        return tfa_set_error(reply, TFA_E_ARGUMENT, field, 0, 0);
    for (uint32_t k = 0; k < count; k++)
        if (joints[k] >= m->joints)
            return tfa_set_error(reply, TFA_E_JOINT, field, k, 0);
    return TFA_OK;
}

static int refuses(tfa_method method, unsigned what)
{
    const tfa_method_info *row = tfa_method_describe((uint32_t)method);
    return row && row->refuses & what;
}

/* Locked joints are supported by the articulated-body algorithm and methods on its factors. */
static int check_locks(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    const int status = check_joints(m, r->locked, r->locked_count, TFA_FIELD_LOCKED, reply);
    if (status != TFA_OK)
        return status;
    if (r->locked_count && refuses(r->method, TFA_REFUSES_LOCKED))
        return tfa_set_error(reply, TFA_E_METHOD, TFA_FIELD_LOCKED, 0, 0);
    if (r->locked_count && (r->op == TFA_OP_MASS_MATRIX || m->massless_followers || m->modes))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_LOCKED, 0, 0);
    return TFA_OK;
}

/* 1: the request names no frame, payload or joint */
static int has_no_scene(const tfa_request *r)
{
    return !(traits_of(r) & TRAITS_SCENE);
}

static int check_scene(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    int status = check_frames(m, r, reply);
    if (status == TFA_OK)
        status = check_payloads(m, r, reply);
    if (status == TFA_OK)
        status = check_locks(m, r, reply);
    if (status == TFA_OK && r->tip_count && refuses(r->method, TFA_REFUSES_TIPS))
        status = tfa_set_error(reply, TFA_E_METHOD, TFA_FIELD_TIPS, 0, 0);
    return status;
}

static int has_armature(const struct tfa_model *m, const struct tfa_chain *chain)
{
    for (uint32_t k = 0; k < chain->length; k++) {
        const struct tfa_body *b = &m->body[chain->body[k]];
        for (uint32_t j = 0; j < b->n; j++)
            if (m->armature[b->v + j] > 0)
                return 1;
    }
    return 0;
}

/* Checks armature and length of the main chains; the limit of length goes to `index`. */
static int check_chains(const struct tfa_model *m, unsigned refuses_what, uint32_t *index)
{
    for (uint32_t t = 0; t < m->trees; t++) {
        if (refuses_what & TFA_REFUSES_ARMATURE && has_armature(m, &m->chain[t]))
            return TFA_E_METHOD;
        if (refuses_what & TFA_REFUSES_LENGTH && m->chain[t].length > TFA_HESSENBERG_LONGEST) {
            *index = TFA_HESSENBERG_LONGEST;
            return TFA_E_UNSUPPORTED;
        }
    }
    return TFA_OK;
}

/* Forward elimination sees one tip's support, not the mimic joints. With followers without mass of
 * their own only T^T M T is regular, which crba solves. Armature is no force between bodies, so
 * constraint forces cannot include it along a main chain; side branches are reduced with theirs.
 * The block Hessenberg matrix is dense: no memory for long chains. */
static int check_method(const struct tfa_model *m, const tfa_request *r, const tfa_method_info *row,
                        tfa_reply *reply)
{
    uint32_t index = (uint32_t)r->method;
    int status = row && row->ops & TFA_OP_BIT(r->op) ? TFA_OK : TFA_E_METHOD;
    if (status == TFA_OK &&
        ((m->mimics && row->refuses & TFA_REFUSES_MIMICS) ||
         (m->massless_followers && row->refuses & TFA_REFUSES_MASSLESS_FOLLOWER)))
        status = TFA_E_METHOD;
    if (status == TFA_OK && row->refuses & (TFA_REFUSES_ARMATURE | TFA_REFUSES_LENGTH))
        status = check_chains(m, row->refuses, &index);
    return status == TFA_OK ? TFA_OK : tfa_set_error(reply, status, TFA_FIELD_METHOD, index, 0);
}

/* A robot with flexible links: what modes are part of, and what not yet */
static int check_modes(const tfa_request *r, const tfa_method_info *row, tfa_reply *reply)
{
    const uint32_t served = TRAIT_FD | TRAIT_OSIM | TRAIT_KINEMATICS,
                   refused = TFA_WANT_JOINT_FORCES | FLAGS_LAMBDA | TFA_WANT_GENERALISED_MOMENTUM;
    if (!(TFA_OP_BIT(r->op) & served))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, 0, 0);
    if (row->refuses & TFA_REFUSES_MODES)
        return tfa_set_error(reply, TFA_E_METHOD, TFA_FIELD_METHOD, (uint32_t)r->method, 0);
    if (r->flags & refused)
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_FLAGS, r->flags & refused, 0);
    return TFA_OK;
}

/* 1: the answer needs M itself */
static int needs_mass_matrix(const struct tfa_model *m, const tfa_request *r,
                             const tfa_method_info *row)
{
    return r->op == TFA_OP_MASS_MATRIX ||
           (!(TFA_OP_BIT(r->op) & TFA_OPS_RNEA) &&
            (row->refuses & TFA_REFUSES_SIZE ||
             (m->massless_followers && !(row->refuses & TFA_REFUSES_MASSLESS_FOLLOWER))));
}

static int check_choices(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    if ((int)r->op < TFA_OP_FORWARD_DYNAMICS || r->op > TFA_OP_LAST)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_OP, 0, 0);
    if (r->count == 0)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_COUNT, 0, 0);
    if ((unsigned)r->frame > TFA_FRAME_WORLD)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_FRAME, 0, 0);
    if ((unsigned)r->estimate > TFA_ESTIMATE_ALWAYS)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_ESTIMATE, 0, 0);
    if (r->refine > TFA_MAX_REFINE && r->refine != TFA_REFINE_DEFAULT)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_REFINE, 0, 0);
    const tfa_method_info *row = tfa_method_describe((uint32_t)r->method);
    int status = check_method(m, r, row, reply);
    if (status == TFA_OK && m->modes)
        status = check_modes(r, row, reply);
    if (status != TFA_OK)
        return status;
    if (TFA_OP_BIT(r->op) & TRAITS_DERIVATIVES && m->freedoms > TFA_DERIVATIVES_FREEDOMS_MAX)
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, TFA_DERIVATIVES_FREEDOMS_MAX,
                             0);
    if (m->mass_entries > TFA_MASS_ENTRIES_MAX && needs_mass_matrix(m, r, row))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED,
                             r->op == TFA_OP_MASS_MATRIX ? TFA_FIELD_OP : TFA_FIELD_METHOD,
                             (uint32_t)TFA_MASS_ENTRIES_MAX, 0);
    return TFA_OK;
}

/* Active ones that the model has, at least one */
static int check_constraints(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    const uint32_t unknown = m->constraints < 32 ? r->constraints >> m->constraints : 0;
    if (unknown)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_CONSTRAINTS,
                             m->constraints + (uint32_t)__builtin_ctz(unknown), 0);
    return r->constraints ? TFA_OK : tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_CONSTRAINTS, 0, 0);
}

int tfa_request_check(const tfa_model *model, const tfa_request *request, tfa_reply *reply)
{
    tfa_reply_begin(model, reply);
    int status = check_choices(model, request, reply);
    if (status == TFA_OK && tfa_is_operational(request))
        status = tfa_check_operational(request, reply);
    if (status == TFA_OK && TFA_OP_BIT(request->op) & TRAITS_CONSTRAINED)
        status = check_constraints(model, request, reply);
    if (status == TFA_OK && !has_no_scene(request))
        status = check_scene(model, request, reply);
    if (status != TFA_OK)
        return status;
    struct tfa_inputs inputs;
    tfa_inputs_of(model, request, &inputs);
    return tfa_check_numbers(model, request, &inputs, zero_of_inputs(request, &inputs), reply);
}
