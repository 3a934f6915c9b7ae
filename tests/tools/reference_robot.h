/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One robot with its answers in quadruple precision, read from ../shared and put into the order
 * of the library.
 */
#ifndef TFA_TESTS_REFERENCE_ROBOT_H
#define TFA_TESTS_REFERENCE_ROBOT_H

#include <stdint.h>
#include <totalforce/totalforce.h>

/** Joint arrays stand in the order of the library, base fields linear first. */
typedef struct reference_state {
    double *q, *v, *tau, *qdd, *nle;
    double base_pose[7], base_twist[6], base_wrench[6], base_acc[6], base_nle[6];
    double lambda_inv[36];
} reference_state;

typedef struct reference_robot {
    tfa_model *model;
    tfa_workspace *workspace;
    uint32_t joints; /**< each has one freedom */
    int floating;
    uint32_t tip; /**< frame */
    uint32_t count;
    reference_state *states;
} reference_robot;

/** Reads `path` and the URDF it names from `robots`. @return 0, or -1 after printing why not. */
int reference_load(reference_robot *robot, const char *path, const char *robots);
void reference_free(reference_robot *robot);

#endif
