/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The self-test of a kernel: questions about random states, asked of it and of the generic kernel.
 */
#ifndef TFA_OWN_VERIFY_H
#define TFA_OWN_VERIFY_H

#include "own/own.h"

#define TRIAL_STATES 64
#define TRIAL_GUARD 16 /* numbers behind each array that nobody may touch */

enum trial_extra {
    TRIAL_GRAVITY = 1,
    TRIAL_PAYLOAD = 2,
    TRIAL_WRENCH = 4,
    TRIAL_LOCKED = 8,
    TRIAL_REST = 16 /* no velocity and no force: NULL */
};

struct trial_question {
    const char *name;
    tfa_op op;
    uint32_t tips; /* 0 to 2 */
    tfa_reference_frame frame;
    uint32_t flags;
    unsigned extra; /* enum trial_extra */
};

/* The questions; NULL behind the last. */
const struct trial_question *trial_question(uint32_t index);

/* Both answers, in one block of memory */
struct trial_answer {
    tfa_reply reply;
    tfa_answer answers[TRIAL_STATES];
};

struct trial {
    const tfa_model *model;
    struct tfa_own_host host;
    tfa_workspace *generic;
    tfa_request request;
    double *inputs, *outputs; /* memory */
    size_t outputs_count;     /* numbers of both answers */
    struct trial_answer own, other;
    uint32_t asked, left; /* states that it should have answered, and those that it did not */
};

/* @return TFA_OK, TFA_E_MEMORY, or as tfa_workspace_create */
int trial_open(struct trial *t, const tfa_model *model);
void trial_close(struct trial *t);
/* Makes the request with a tip on body `tip`, and has the generic kernel answer. */
void trial_ask(struct trial *t, const struct trial_question *q, uint32_t tip);
/* Every number of both answers becomes one that no answer is. */
void trial_spoil(struct trial *t);
/* The numbers behind the arrays are as they were. */
int trial_guards_hold(const struct trial *t);

#endif
