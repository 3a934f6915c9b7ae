/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One question of each kind that the kernels answer, and all numbers of the answers: for tests in
 * which two ways through the library must give the same bits.
 */
#ifndef TESTS_SUPPORT_QUESTIONS_H
#define TESTS_SUPPORT_QUESTIONS_H

#include "fixture.h"

typedef struct question {
    const char *name;
    tfa_op op;
    tfa_method method;
    tfa_estimate estimate;
    uint32_t refine, tips, flags;
    bool wrenches, resting, payload, locked;
    tfa_reference_frame frame;
} question;

extern const question questions[];
extern const size_t question_count;

/** Whether the library takes this question about this robot */
bool question_fits(const test_robot *robot, const question *q);

/** The request with the first `count` of these states. */
tfa_request question_request(const test_robot *robot, const question *q, const random_states *x,
                             uint32_t count);

/** All that a workspace answers about up to `count` states; what nothing was written to is NaN. */
typedef struct answers {
    uint32_t count, n, nv, frames, closed; /**< closed: six for each constraint of the robot */
    size_t numbers; /**< of one state */
    double *qdd, *tau, *base_acceleration, *base_wrench, *lambda_inv, *mass_matrix, *poses;
    double *joint_forces;
    double *constraints, *v, *base_twist;
    double *derivatives; /**< dqdd/dq of all states, dqdd/dv, dqdd/dtau, dtau/dq, dtau/dv */
    tfa_answer *each;
    double *memory;
} answers;

answers *answers_create(const test_robot *robot, uint32_t count);
void answers_free(answers *a);
/** A reply that fills all of `a` from state k on, for requests with so many tips. */
tfa_reply answers_reply(const answers *a, uint32_t k, uint32_t tips);
/** Makes it as if nothing had been written. */
void answers_clear(answers *a);
void answers_ask(answers *a, tfa_workspace *w, const tfa_request *r);

/** Fails unless both hold the same bits, naming robot, question and `what`. */
void assert_same_answers(const test_robot *robot, const question *q, const char *what,
                         const answers *x, const answers *y);

#endif
