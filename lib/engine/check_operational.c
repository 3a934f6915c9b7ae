/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Validation of flags and of the inputs of ops with tips.
 */
#include <math.h>

#include "engine/check_numbers.h"
#include "engine/methods.h"
#include "interface/fields.h"
#include "interface/traits.h"

/* Flags that need tips, and flags that need an op with lambda_inv */
#define FLAGS_OF_LAMBDA_INV (FLAGS_LAMBDA | TFA_WANT_SPECTRUM)
#define FLAGS_OF_TIPS                                                                              \
    (FLAGS_OF_LAMBDA_INV | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION)

static int check_flags(const tfa_request *r, tfa_reply *reply)
{
    const uint32_t op = TFA_OP_BIT(r->op);
    if (r->flags & ~TFA_WANT_ALL)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_FLAGS, r->flags & ~TFA_WANT_ALL, 0);
    if (r->flags & FLAGS_OF_LAMBDA_INV && !(op & TRAITS_LAMBDA_INV))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, 0, 0);
    if (r->flags & TFA_WANT_JOINT_FORCES && !(op & (TRAIT_FD | TRAIT_ID)))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, 0, 0);
    if (r->flags & TFA_WANT_DELASSUS && !(op & TFA_OPS_CONSTRAINED_SOLVE))
        return tfa_set_error(reply, TFA_E_UNSUPPORTED, TFA_FIELD_OP, 0, 0);
    if ((r->flags & FLAGS_OF_TIPS || op & (TRAIT_OSIM | TRAIT_TASK | TRAIT_REGRESSOR)) &&
        r->tip_count == 0)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_TIPS, 0, 0);
    return TFA_OK;
}

static int check_length(const tfa_request *r, tfa_reply *reply)
{
    if (!r->characteristic_length)
        return TFA_OK;
    if (!isfinite(*r->characteristic_length))
        return tfa_set_error(reply, TFA_E_VALUE, TFA_FIELD_CHARACTERISTIC_LENGTH, 0, 0);
    if (*r->characteristic_length <= 0)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_CHARACTERISTIC_LENGTH, 0, 0);
    return TFA_OK;
}

static int check_rank(const tfa_request *r, tfa_reply *reply)
{
    if ((unsigned)r->rank_loss > TFA_RANK_REFUSE)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_RANK_LOSS, 0, 0);
    const int status = check_length(r, reply);
    if (status != TFA_OK)
        return status;
    if (!r->rank_threshold)
        return TFA_OK;
    if (!isfinite(*r->rank_threshold))
        return tfa_set_error(reply, TFA_E_VALUE, TFA_FIELD_RANK_THRESHOLD, 0, 0);
    if (*r->rank_threshold <= 0 || *r->rank_threshold >= 1)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_RANK_THRESHOLD, 0, 0);
    return TFA_OK;
}

/* What a constraint is wanted to do */
static int check_wanted(const tfa_request *r, tfa_reply *reply)
{
    const int status =
        tfa_check_finite(reply, TFA_FIELD_CONSTRAINT_ACCELERATION, r->constraint_acceleration,
                         tfa_constraint_numbers(r), r->count);
    if (status != TFA_OK || !r->stabilisation)
        return status;
    for (uint32_t k = 0; k < 2; k++) {
        if (!isfinite(r->stabilisation[k]))
            return tfa_set_error(reply, TFA_E_VALUE, TFA_FIELD_STABILISATION, k, 0);
        if (r->stabilisation[k] < 0)
            return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_STABILISATION, k, 0);
    }
    return TFA_OK;
}

int tfa_check_operational(const tfa_request *r, tfa_reply *reply)
{
    if ((unsigned)r->rows > TFA_ROWS_POINT)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_ROWS, 0, 0);
    if (r->tip_count > TFA_MAX_TIPS)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_TIPS, r->tip_count, 0);
    int status = check_flags(r, reply);
    if (status == TFA_OK)
        status = check_rank(r, reply);
    if (status == TFA_OK && TFA_OP_BIT(r->op) & TRAITS_CONSTRAINED)
        return check_wanted(r, reply);
    if (status != TFA_OK || r->op != TFA_OP_TASK_TORQUES)
        return status;
    if (!r->task_acceleration)
        return tfa_set_error(reply, TFA_E_ARGUMENT, TFA_FIELD_TASK_ACCELERATION, 0, 0);
    return tfa_check_finite(reply, TFA_FIELD_TASK_ACCELERATION, r->task_acceleration,
                            (size_t)rows_of(r) * r->tip_count, r->count);
}
