/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kernels and memory of a workspace.
 */
#ifndef TFA_ENGINE_WORKSPACE_H
#define TFA_ENGINE_WORKSPACE_H

#include "engine/methods.h"
#include "interface/kernel_table.h"
#include "interface/parallel_for.h"
#include "interface/specialised_abi.h"

/* Rows of the table of strategies */
#define TFA_STRATEGIES 6
struct strategy;
struct tfa_last;

struct tfa_workspace {
    const struct tfa_model *model;
    struct tfa_reserved reserved;
    struct tfa_executor *executor;   /* of the request under way; NULL: the caller alone */
    tfa_precision precision;         /* of the factors */
    const struct tfa_kernel *kernel; /* of one state at a time: doubles around factors in float */
    struct state *state;
    /* of the residual; no kernel: that of the factors */
    struct tfa_residual_kernel residual_kernel;
    const struct tfa_kernel *batch; /* NULL: one state at a time */
    struct state *batch_state;
    uint32_t batch_max;                             /* largest batch */
    uint32_t batch_min, batch_min_body_lanes;       /* fewer go one at a time; with body lanes */
    const struct tfa_body_lanes_kernel *body_lanes; /* NULL: one body at a time */
    struct state *body_lanes_state;
    struct tfa_factor_buffers factors; /* buffers of `kernel` for factors from body lanes, for
                                          tips */
    uint32_t
        /* bodies of the trees of tips from which their factors come from body lanes */
        body_lanes_min_bodies;
    const struct tfa_segment_lanes_kernel *segment_lanes; /* NULL: chains one body at a time */
    struct segment_lanes *segment_lanes_state;
    const struct tfa_specialised_kernel *specialised; /* NULL: the robot has no kernel of its own */
    struct tfa_host_api host;                         /* its host interface */
    double *spectrum;                                 /* scratch of the eigenvalues */
    double *loop; /* scratch of tfa_close_loops: two sets of base_twist and v */
    const struct strategy *strategy[TFA_STRATEGIES];  /* rows that this workspace can run, in
                                                         order */
    uint32_t strategies;
    struct tfa_last *last; /* by op */
};

#endif
