/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The self-test of a kernel: questions about random states, asked of it and of the generic kernel.
 */
#ifndef TFA_SPECIALISED_SELF_TEST_H
#define TFA_SPECIALISED_SELF_TEST_H

#include "specialised/specialised_internal.h"

#define SELF_TEST_STATES 64
#define SELF_TEST_GUARD 16 /* numbers behind each array that nobody may touch */

enum self_test_option {
    SELF_TEST_GRAVITY = 1,
    SELF_TEST_PAYLOAD = 2,
    SELF_TEST_WRENCH = 4,
    SELF_TEST_LOCKED = 8,
    SELF_TEST_AT_REST = 16 /* no velocity and no force: NULL */
};

struct self_test_case {
    const char *name;
    tfa_op op;
    uint32_t tips; /* 0 to 2 */
    tfa_reference_frame frame;
    uint32_t flags;
    unsigned options; /* enum self_test_option */
};

/* The questions; NULL behind the last. */
const struct self_test_case *self_test_case(uint32_t index);

/* Both answers, in one block of memory */
struct self_test_reply {
    tfa_reply reply;
    tfa_answer answers[SELF_TEST_STATES];
};

struct self_test {
    const tfa_model *model;
    struct tfa_host_api host;
    tfa_workspace *generic;
    tfa_request request;
    double *inputs, *outputs; /* memory */
    size_t outputs_count;     /* numbers of both answers */
    struct self_test_reply tested, reference;
    uint32_t compared,
        unanswered; /* states that it should have answered, and those that it did not */
};

/* @return TFA_OK, TFA_E_MEMORY, or as tfa_workspace_create */
int self_test_open(struct self_test *t, const tfa_model *model);
void self_test_close(struct self_test *t);
/* Makes the request with a tip on body `tip`, and has the generic kernel answer. */
void self_test_make_request(struct self_test *t, const struct self_test_case *q, uint32_t tip);
/* Every number of both answers becomes one that no answer is. */
void self_test_poison(struct self_test *t);
/* The numbers behind the arrays are as they were. */
int self_test_guards_intact(const struct self_test *t);

#endif
