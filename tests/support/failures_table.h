/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where theory says that a method fails, and what the service answers there: for the library
 * (failures.c) and for the daemon (tests/service/failures.c).
 */
#ifndef TESTS_SUPPORT_FAILURES_TABLE_H
#define TESTS_SUPPORT_FAILURES_TABLE_H

#include "hard_robot.h"

typedef struct failure {
    tfa_op op;
    tfa_method method;
    tfa_precision precision;
    /* what it fails on */
    mechanism_kind mechanism;
    uint32_t bodies;
    double radius, ratio;
    hard_rhs rhs;
    double least; /**< error that the bare method shows there, at least */
    /* what is asked instead, and what is answered */
    tfa_estimate estimate; /**< TFA_ESTIMATE_DEFAULT where the method's defaults look after it */
    uint32_t refine;
    tfa_residual residual;
    tfa_method answers; /**< who does */
    uint16_t flags;     /**< TFA_ANSWER_FALLBACK and the reason, or 0 */
    double bound;       /**< of the error of that answer */
} failure;

extern const failure failures[];
extern const uint32_t failure_count;

/** Makes the robot of a row, with its state and forces. */
void failure_open(const failure *row, hard_robot *robot);
/** The URDF of the robot, to be written to a file. */
mechanism_options failure_mechanism(const failure *row);

/** The bare method: neither refined nor estimated. */
tfa_request failure_unestimated(const failure *row, const hard_robot *robot);
/** What a user asks who leaves it to the service. */
tfa_request failure_by_default(const failure *row, const hard_robot *robot);

/** The exact answer: qdd, or lambda_inv; returns how many numbers. */
uint32_t failure_truth(const failure *row, hard_robot *robot, double *want);
/** A reply whose answer goes to `got`. */
tfa_reply failure_reply(const failure *row, double *got, tfa_answer *answer);

/** Is the guarded answer as the row says? Fails the test otherwise. */
void failure_check(const failure *row, const tfa_reply *reply, const double *got,
                   const double *want, uint32_t count, const char *where);

#endif
