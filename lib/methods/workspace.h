/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who computes in a workspace.
 */
#ifndef TFA_METHODS_WORKSPACE_H
#define TFA_METHODS_WORKSPACE_H

#include "kernel/table.h"
#include "methods/methods.h"

struct tfa_workspace {
    const struct tfa_model *model;
    const struct tfa_kernel *kernel;
    struct state *state;
    struct tfa_wider wider;        /* of the residual; no kernel: that of the factors */
    const struct tfa_lanes *lanes; /* NULL: one state at a time */
    struct state *lane_state;
    double *spectrum; /* scratch of the eigenvalues */
};

#endif
