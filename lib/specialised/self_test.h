/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests with random states, the same each time, that a kernel is tested and timed with.
 */
#ifndef TFA_SPECIALISED_SELF_TEST_H
#define TFA_SPECIALISED_SELF_TEST_H

#include "interface/kernel_table.h"
#include "model/model.h"
#include "specialised/specialised_internal.h"

#define SELF_TEST_STATES 64
#define SELF_TEST_GUARD 16 /* guard numbers behind each array */

enum self_test_option {
    SELF_TEST_GRAVITY = 1,
    SELF_TEST_PAYLOAD = 2,
    SELF_TEST_WRENCH = 4,
    SELF_TEST_LOCKED = 8,
    SELF_TEST_AT_REST = 16 /* velocities and forces NULL */
};

struct self_test_case {
    const char *name;
    tfa_op op;
    uint32_t tips; /* 0 to 2 */
    tfa_reference_frame frame;
    uint32_t flags;
    unsigned options; /* enum self_test_option */
};

/* Buffers of an answer */
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
    uint32_t compared, unanswered; /* states asked, and those without an answer */
};

/* Entries of a mass matrix */
static inline size_t self_test_mass(const tfa_model *m)
{
    const size_t n = m->base_freedoms + m->v_count;
    return n * n;
}

/* and of each matrix of derivatives */
static inline size_t self_test_derivatives(const tfa_model *m)
{
    const int has_them = !m->base_freedoms && m->freedoms <= TFA_SPECIALISED_DERIVATIVES_MAX;
    return has_them ? self_test_mass(m) : 0;
}

/* Memory for requests and answers, and the generic workspace; to be closed after an error, too */
int self_test_open(struct self_test *t, const tfa_model *model);
void self_test_close(struct self_test *t);

/* Sets t->request. tip: the body whose link is the first tip */
void self_test_request(struct self_test *t, const struct self_test_case *q, uint32_t tip);

/* 1: all requests have the same bits for one state and for states in lanes */
int self_test_same_bits(const tfa_model *model, const struct tfa_specialised_kernel *kernel);

#endif
