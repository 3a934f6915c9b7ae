/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Validation of a request's numbers: finiteness, quaternions. Runs on every call.
 */
#include "engine/check_numbers.h"

#include <math.h>

#include "engine/methods.h"
#include "interface/traits.h"
#include "model/model.h"

/* Tolerance of a quaternion's norm: more is an error of the sender, not rounding. */
#define QUATERNION_TOLERANCE 1e-3

int tfa_check_finite(tfa_reply *reply, tfa_field field, const double *x, size_t width, size_t count)
{
    for (size_t k = 0; x && k < width * count; k++)
        if (!isfinite(x[k]))
            return tfa_set_error(reply, TFA_E_VALUE, field, (uint32_t)(k % width),
                                 (uint32_t)(k / width));
    return TFA_OK;
}

static inline int is_unit(const double *quat)
{
    const double n = quat[0] * quat[0] + quat[1] * quat[1] + quat[2] * quat[2] + quat[3] * quat[3];
    return n >= (1 - QUATERNION_TOLERANCE) * (1 - QUATERNION_TOLERANCE) &&
           n <= (1 + QUATERNION_TOLERANCE) * (1 + QUATERNION_TOLERANCE);
}

static int check_joint_quaternions(const struct tfa_model *m, const tfa_request *r,
                                   tfa_reply *reply)
{
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

static __attribute__((noinline)) int check_quaternions(const struct tfa_model *m,
                                                       const tfa_request *r, tfa_reply *reply)
{
    for (uint32_t k = 0; m->base_freedoms && k < r->count; k++)
        if (!is_unit(r->base_pose + 7 * (size_t)k + 3))
            return tfa_set_error(reply, TFA_E_QUATERNION, TFA_FIELD_BASE_POSE, 3, k);
    /* the base is the only joint with several freedoms, or one of them has a quaternion */
    return m->joints_nd == m->base_freedoms / 6 ? TFA_OK : check_joint_quaternions(m, r, reply);
}

static void add_input(struct tfa_inputs *to, int read, tfa_field field, size_t member, size_t width,
                      int every_state)
{
    if (read && width)
        to->input[to->count++] = (struct tfa_input){(uint16_t)member, (uint8_t)field,
                                                    (uint8_t)every_state, (uint32_t)width};
}

void tfa_inputs_of(const tfa_model *m, const tfa_request *r, struct tfa_inputs *out)
{
    const uint32_t op = TFA_OP_BIT(r->op);
    const int v = reads_velocity(r), tau = (op & TRAITS_FORWARD) != 0,
              qdd = (op & TRAITS_INVERSE) != 0;
    const size_t nj = m->v_count, base = m->base_freedoms;
    out->count = 0;
#define INPUT(read, FIELD, member, width, every_state)                                             \
    add_input(out, read, TFA_FIELD_##FIELD, offsetof(tfa_request, member), width, every_state);
    INPUT(1, Q, q, m->q_count, 1)
    INPUT(v, V, v, nj, 1)
    INPUT(tau, TAU, tau, nj, 1)
    INPUT(qdd, QDD, qdd, nj, 1)
    INPUT(1, BASE_POSE, base_pose, base ? 7 : 0, 1)
    INPUT(v, BASE_TWIST, base_twist, base, 1)
    INPUT(tau, BASE_WRENCH, base_wrench, base, 1)
    INPUT(qdd, BASE_ACCELERATION, base_acceleration, base, 1)
    INPUT(reads_wrenches(r), WRENCHES, wrenches, (size_t)6 * r->wrench_count, 1)
    INPUT(reads_gravity(r), GRAVITY, gravity, 3, 0)
    INPUT(1, MODES, modes, m->modes, 1)
    INPUT(v, MODE_VELOCITIES, mode_velocities, m->modes, 1)
#undef INPUT
}

/* Sets the error of the first number that is not finite. */
static __attribute__((noinline)) int
set_array_error(const tfa_request *r, const struct tfa_inputs *inputs, tfa_reply *reply)
{
    int status = TFA_OK;
    for (uint32_t k = 0; status == TFA_OK && k < inputs->count; k++) {
        const struct tfa_input *in = &inputs->input[k];
        status = tfa_check_finite(reply, (tfa_field)in->field, input_array(r, in), in->width,
                                  input_states(r, in));
    }
    return status;
}

/* Weights of squared torques: above 0 */
static __attribute__((noinline)) int check_weights(const struct tfa_model *m, const double *weights,
                                                   tfa_reply *reply)
{
    const int status = tfa_check_finite(reply, TFA_FIELD_TORQUE_WEIGHTS, weights, m->v_count, 1);
    for (uint32_t k = 0; status == TFA_OK && k < m->v_count; k++)
        if (weights[k] <= 0)
            return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_TORQUE_WEIGHTS, k, 0);
    return status;
}

int tfa_check_numbers(const tfa_model *m, const tfa_request *r, const struct tfa_inputs *inputs,
                      double zero, tfa_reply *reply)
{
    if (r->wrench_count && !r->wrenches)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_WRENCHES, 0, 0);
    if (!r->q && m->q_count)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_Q, 0, 0);
    if (!r->base_pose && m->base_freedoms)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_BASE_POSE, 0, 0);
    if (zero != 0)
        return set_array_error(r, inputs, reply);
    if (r->op == TFA_OP_CONSTRAINED_INVERSE_DYNAMICS && r->torque_weights) {
        const int status = check_weights(m, r->torque_weights, reply);
        if (status != TFA_OK)
            return status;
    }
    return m->joints_nd ? check_quaternions(m, r, reply) : TFA_OK;
}
