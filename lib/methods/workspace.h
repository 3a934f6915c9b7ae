/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who computes in a workspace.
 */
#ifndef TFA_METHODS_WORKSPACE_H
#define TFA_METHODS_WORKSPACE_H

#include "kernel/crew.h"
#include "kernel/own_abi.h"
#include "kernel/table.h"
#include "methods/methods.h"

/* Rows of the table of strategies */
#define TFA_STRATEGIES 7
struct strategy;

/* Methods of a batch: neither those that search nor those that fill lanes themselves (variant.c) */
#define TFA_BATCH_METHODS                                                                          \
    ~(TFA_METHOD_BIT(TFA_METHOD_HESSENBERG) | TFA_METHOD_BIT(TFA_METHOD_SCAN) |                    \
      TFA_METHOD_BIT(TFA_METHOD_SCAN_TWO_PASS))

struct tfa_workspace {
    const struct tfa_model *model;
    uint32_t methods;                /* there is room for: bits 1u << tfa_method */
    struct tfa_crew *crew;           /* of the request under way; NULL: the caller alone */
    tfa_precision precision;         /* of the factors */
    const struct tfa_kernel *kernel; /* of one state at a time: doubles around factors in float */
    struct state *state;
    struct tfa_wider wider;         /* of the residual; no kernel: that of the factors */
    const struct tfa_kernel *batch; /* NULL: one state at a time */
    struct state *batch_state;
    uint32_t batch_max;                  /* states at a time */
    uint32_t batch_min, batch_min_limbs; /* fewer go one at a time; where limbs go side by side */
    const struct tfa_limbs *limbs;       /* NULL: one body at a time */
    struct state *limb_state;
    struct tfa_factors factors; /* where `kernel` has those that tips take from limbs */
    uint32_t limbs_from; /* bodies of the trees of tips from which their factors come from limbs */
    const struct tfa_pieces *pieces; /* NULL: no chain in pieces */
    struct pieces *piece_state;
    const struct tfa_strips_kernel *strips; /* NULL: chains one body at a time */
    struct strips *strips_state;
    const struct tfa_own_kernel *own;                /* NULL: the robot has no kernel of its own */
    struct tfa_own_host host;                        /* what that is given */
    double *spectrum;                                /* scratch of the eigenvalues */
    const struct strategy *strategy[TFA_STRATEGIES]; /* that this workspace can run, in order */
    uint32_t strategies;
};

#endif
