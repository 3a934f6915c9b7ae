/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The form of a request: all that it says besides its numbers and their count. What follows from it
 * is checked and chosen once, for a prepared request and, by a workspace, for the last one of each
 * op. Numbers are checked on every call.
 */
#ifndef TFA_ENGINE_FORM_H
#define TFA_ENGINE_FORM_H

#include "engine/check_numbers.h"
#include "engine/strategy.h"

struct tfa_form {
    struct tfa_inputs inputs;
    struct call call;
};

/* The last request of an op, and its form */
struct tfa_last {
    int is_valid;
    tfa_request request; /* its arrays and count mean nothing */
    struct tfa_form form;
};

/* The form of a request that tfa_request_check and tfa_reserved_check passed */
void tfa_form_init(struct tfa_form *form, const tfa_workspace *w, const tfa_request *r);

/* As tfa_compute, of a request of this form */
int tfa_compute_form(tfa_workspace *w, struct tfa_form *form, const tfa_request *r,
                     tfa_reply *reply);

#endif
