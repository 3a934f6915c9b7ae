/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Validation of a request: sizes, indices, finiteness, quaternions. Names the invalid field.
 */
#include <math.h>
#include <string.h>

#include "engine/methods.h"
#include "interface/traits.h"
#include "model/model.h"
#include "model/payload.h"

/* Tolerance of a quaternion's norm: more is an error of the sender, not rounding. */
#define QUATERNION_TOLERANCE 1e-3

int tfa_set_error(tfa_reply *reply, int status, tfa_field field, uint32_t index, uint32_t state)
{
    reply->status = status;
    reply->field = field;
    reply->index = index;
    reply->state = state;
    return status;
}

typedef double pair __attribute__((vector_size(2 * sizeof(double))));

static pair nonfinite_pair(const double *x)
{
    pair p;
    memcpy(&p, x, sizeof p);
    return p - p;
}

/* 0 if all numbers are finite, else NaN: the sum of x - x without branches, four at a time; the
 * last four overlap if necessary. */
static double nonfinite_sum(const double *x, size_t n)
{
    pair sum = {0}, more = {0};
    if (!x)
        return 0;
    if (n < 4) {
        for (size_t k = 0; k < n; k++)
            sum[0] += x[k] - x[k];
        return sum[0];
    }
    const double *const last = x + (n - 4);
    for (; x <= last; x += 4) {
        sum += nonfinite_pair(x);
        more += nonfinite_pair(x + 2);
    }
    if (x != last + 4) {
        sum += nonfinite_pair(last);
        more += nonfinite_pair(last + 2);
    }
    sum += more;
    return sum[0] + sum[1];
}

int tfa_check_finite(tfa_reply *reply, tfa_field field, const double *x, size_t width, size_t count)
{
    for (size_t k = 0; x && k < width * count; k++)
        if (!isfinite(x[k]))
            return tfa_set_error(reply, TFA_E_VALUE, field, (uint32_t)(k % width),
                                 (uint32_t)(k / width));
    return TFA_OK;
}

static int is_unit(const double *quat)
{
    double n = quat[0] * quat[0] + quat[1] * quat[1] + quat[2] * quat[2] + quat[3] * quat[3];
    return fabs(sqrt(n) - 1) <= QUATERNION_TOLERANCE;
}

static int check_quaternions(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    for (uint32_t k = 0; r->base_pose && m->base_freedoms && k < r->count; k++)
        if (!is_unit(r->base_pose + 7 * (size_t)k + 3))
            return tfa_set_error(reply, TFA_E_QUATERNION, TFA_FIELD_BASE_POSE, 3, k);
    if (m->joints_nd == m->base_freedoms / 6)
        return TFA_OK; /* no joint has a quaternion */
    for (uint32_t j = 0; j < m->joints; j++) {
        if (m->joint[j].q_count == m->joint[j].v_count)
            continue; /* a quaternion is one number more than its freedoms */
        const uint32_t at =
            m->joint[j].q_index + (uint32_t)tfa_joint_type_describe(m->joint[j].type).quaternion;
        for (uint32_t k = 0; k < r->count; k++)
            if (!is_unit(r->q + (size_t)m->q_count * k + at))
                return tfa_set_error(reply, TFA_E_QUATERNION, TFA_FIELD_Q, at, k);
    }
    return TFA_OK;
}

static int check_frames(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    if (r->tip_count > TFA_MAX_TIPS)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_TIPS, r->tip_count, 0);
    if (r->wrench_count > TFA_MAX_WRENCHES)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_WRENCHES, r->wrench_count, 0);
    if (r->wrench_count && !r->wrenches)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_WRENCHES, 0, 0);
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
                   refused = TFA_WANT_JOINT_FORCES | FLAGS_LAMBDA;
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
    if (r->op == TFA_OP_DERIVATIVES && m->freedoms > TFA_DERIVATIVES_FREEDOMS_MAX)
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, TFA_DERIVATIVES_FREEDOMS_MAX,
                             0);
    if (m->mass_entries > TFA_MASS_ENTRIES_MAX && needs_mass_matrix(m, r, row))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED,
                             r->op == TFA_OP_MASS_MATRIX ? TFA_FIELD_OP : TFA_FIELD_METHOD,
                             (uint32_t)TFA_MASS_ENTRIES_MAX, 0);
    return TFA_OK;
}

/* 1: the op reads tau */
static int reads_forces(const tfa_request *r)
{
    return (TFA_OP_BIT(r->op) & TRAITS_FORWARD) != 0;
}

/* 1: the op reads qdd */
static int reads_accelerations(const tfa_request *r)
{
    return r->op == TFA_OP_INVERSE_DYNAMICS || r->op == TFA_OP_BIAS;
}

/* Sets the error of the first number that is not finite. */
static int set_array_error(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    const size_t n = r->count, nj = m->v_count;
    const int base = m->base_freedoms > 0, v = reads_velocity(r), tau = reads_forces(r),
              qdd = reads_accelerations(r);
    const struct {
        int read;
        tfa_field field;
        const double *x;
        size_t width, count;
    } arrays[] = {
        {1, TFA_FIELD_Q, r->q, m->q_count, n},
        {v, TFA_FIELD_V, r->v, nj, n},
        {tau, TFA_FIELD_TAU, r->tau, nj, n},
        {qdd, TFA_FIELD_QDD, r->qdd, nj, n},
        {base, TFA_FIELD_BASE_POSE, r->base_pose, 7, n},
        {base && v, TFA_FIELD_BASE_TWIST, r->base_twist, 6, n},
        {base && tau, TFA_FIELD_BASE_WRENCH, r->base_wrench, 6, n},
        {base && qdd, TFA_FIELD_BASE_ACCELERATION, r->base_acceleration, 6, n},
        {reads_wrenches(r) && r->wrench_count, TFA_FIELD_WRENCHES, r->wrenches,
         (size_t)6 * r->wrench_count, n},
        {reads_gravity(r), TFA_FIELD_GRAVITY, r->gravity, 3, 1},
        {1, TFA_FIELD_MODES, r->modes, m->modes, n},
        {v, TFA_FIELD_MODE_VELOCITIES, r->mode_velocities, m->modes, n},
    };
    int status = TFA_OK;
    for (size_t k = 0; status == TFA_OK && k < sizeof arrays / sizeof *arrays; k++)
        if (arrays[k].read)
            status = tfa_check_finite(reply, arrays[k].field, arrays[k].x, arrays[k].width,
                                      arrays[k].count);
    return status;
}

static double nonfinite_base(const tfa_request *r)
{
    const size_t n = r->count;
    double sum = nonfinite_sum(r->base_pose, 7 * n);
    if (reads_velocity(r))
        sum += nonfinite_sum(r->base_twist, 6 * n);
    if (reads_forces(r))
        sum += nonfinite_sum(r->base_wrench, 6 * n);
    if (reads_accelerations(r))
        sum += nonfinite_sum(r->base_acceleration, 6 * n);
    return sum;
}

static double nonfinite_motion(const struct tfa_model *m, const tfa_request *r)
{
    const size_t n = r->count, nj = m->v_count;
    double sum = 0;
    if (reads_velocity(r))
        sum += nonfinite_sum(r->v, nj * n);
    if (reads_forces(r))
        sum += nonfinite_sum(r->tau, nj * n);
    if (reads_accelerations(r))
        sum += nonfinite_sum(r->qdd, nj * n);
    if (r->gravity && reads_gravity(r))
        sum += nonfinite_sum(r->gravity, 3);
    if (r->wrench_count && reads_wrenches(r))
        sum += nonfinite_sum(r->wrenches, (size_t)6 * r->wrench_count * n);
    return sum;
}

static double nonfinite_modes(const struct tfa_model *m, const tfa_request *r)
{
    const size_t n = (size_t)m->modes * r->count;
    return nonfinite_sum(r->modes, n) +
           (reads_velocity(r) ? nonfinite_sum(r->mode_velocities, n) : 0);
}

static int check_arrays(const struct tfa_model *m, const tfa_request *r, tfa_reply *reply)
{
    if (!r->q && m->q_count)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_Q, 0, 0);
    if (!r->base_pose && m->base_freedoms)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_BASE_POSE, 0, 0);
    double sum = nonfinite_sum(r->q, (size_t)m->q_count * r->count) + nonfinite_motion(m, r);
    if (m->base_freedoms)
        sum += nonfinite_base(r);
    if (m->modes)
        sum += nonfinite_modes(m, r);
    return sum == 0 ? TFA_OK : set_array_error(m, r, reply);
}

int tfa_request_check(const tfa_model *model, const tfa_request *request, tfa_reply *reply)
{
    reply->status = TFA_OK;
    reply->field = TFA_FIELD_NONE;
    reply->index = 0;
    reply->state = 0;
    reply->model = tfa_model_tag(model);
    int status = check_choices(model, request, reply);
    if (status == TFA_OK && tfa_is_operational(request))
        status = tfa_check_operational(request, reply);
    if (status == TFA_OK && !has_no_scene(request))
        status = check_scene(model, request, reply);
    if (status == TFA_OK)
        status = check_arrays(model, request, reply);
    if (status == TFA_OK)
        status = check_quaternions(model, request, reply);
    return status;
}
