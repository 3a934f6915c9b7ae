/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Internal interface of the engine.
 */
#ifndef TFA_ENGINE_METHODS_H
#define TFA_ENGINE_METHODS_H

#include <totalforce/dynamics.h>

/* Rank and extreme eigenvalues of a symmetric n x n matrix, 1 <= n <= 6 TFA_MAX_TIPS: error 2 n eps
 * |A|, about 4/3 n^3 operations. Rank 0 and NaN where an entry is not finite. `scratch` holds n x n
 * doubles. */
tfa_spectrum tfa_spectrum_of(const double *matrix, uint32_t n, double *scratch);

/* Checks flags, rows and the inputs of task torques, ops and flags with tips. */
int tfa_check_operational(const tfa_request *request, tfa_reply *reply);

/* Sets the error of a reply. Returns `status`. */
static inline int tfa_set_error(tfa_reply *reply, int status, tfa_field field, uint32_t index,
                                uint32_t state)
{
    reply->status = status;
    reply->field = field;
    reply->index = index;
    reply->state = state;
    return status;
}

/* Begins a reply without an error. */
static inline void tfa_reply_begin(const tfa_model *model, tfa_reply *reply)
{
    tfa_set_error(reply, TFA_OK, TFA_FIELD_NONE, 0, 0);
    reply->model = tfa_model_tag(model);
}

struct tfa_executor;

/* 1: a parallel method answers the request, so that several threads can work on one state. */
int tfa_method_is_parallel(const tfa_model *model, const tfa_request *request);

/* Sets the executor of the workspace; NULL: the caller alone. The executor runs nothing else while
 * the workspace computes. */
void tfa_workspace_set_executor(tfa_workspace *workspace, struct tfa_executor *executor);

/* Refuses methods and numbers of tips for which the workspace has no memory. */
int tfa_reserved_check(const tfa_workspace *workspace, const tfa_request *request,
                       tfa_reply *reply);

/* tfa_compute of states first .. end - 1 of a request that tfa_request_check and
 * tfa_reserved_check passed; the reply is as they left it. */
int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                        uint32_t end, tfa_reply *reply);

#endif
