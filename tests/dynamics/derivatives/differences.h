/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Central differences of forward and inverse dynamics in quadruple precision along the tangent
 * directions of docs/conventions.md, extrapolated to a step of zero.
 */
#ifndef TESTS_DYNAMICS_DERIVATIVES_DIFFERENCES_H
#define TESTS_DYNAMICS_DERIVATIVES_DIFFERENCES_H

#include <totalforce/totalforce.h>

#define DIFFERENCE_MAX 512 /* freedoms */

typedef struct difference_robot {
    const char *name;
    const tfa_model *model;
    tfa_workspace *quad;
    uint32_t n, six, nq, nv; /* rows of M, freedoms of the base, lengths of q and v */
} difference_robot;

/** Accelerations by q, v, tau; forces of inverse dynamics by q, v */
typedef enum difference_by { BY_Q, BY_V, BY_TAU, ID_BY_Q, ID_BY_V, BY_ALL } difference_by;

/** Column `freedom` of a derivative, base first: n numbers. `r` is one state with q, v, tau, qdd
 *  and all of a floating base. */
void difference_column(const difference_robot *robot, const tfa_request *r, difference_by by,
                       uint32_t freedom, double *column);

/** What errors of an n x n derivative are relative to: its largest entry, or where that is smaller
 *  a hundredth of the accelerations, or forces. */
double difference_size(const difference_robot *robot, const tfa_request *r, difference_by by,
                       const double *matrix);

/** The largest of n absolute values; NaN if one of them is */
double difference_largest(const double *x, size_t n);

#endif
