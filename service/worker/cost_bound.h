/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bound on the time of one state of a kind that was not asked for yet: measured times of parts of
 * requests to the same robot, added up. Measured are each op by each method plain, refined and
 * estimated, and each group of flags, wrenches, payloads and locked joints by auto, all with 0, 1,
 * 3, TFA_DEFAULT_TIPS and the most tips, deep in the tree and all over it; between these lies a
 * line. Half as much is added for what parts cost each other. How near it comes: docs/tuning.md.
 *
 * The bound is one for ordinary states: an answer that trips the sentinel or falls back takes
 * longer than its kind (tfa_cost_debt).
 */
#ifndef TFA_SERVICE_WORKER_COST_BOUND_H
#define TFA_SERVICE_WORKER_COST_BOUND_H

#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>

#include "worker/worker.h"

#define TFA_COST_POINTS 5     /* numbers of tips */
#define TFA_COST_ADDITIONS 11 /* groups of flags, wrenches, payloads, locked joints */
#define TFA_COST_METHODS 17   /* numbers of tfa_method */

/** ns by the number of tips; UINT32_MAX: longer than CONFIG_STATE_US_MOST; 0: refused */
typedef struct tfa_cost_curve {
    uint32_t at[TFA_COST_POINTS];
} tfa_cost_curve;

typedef struct tfa_cost_parts {
    uint32_t tips[TFA_COST_POINTS]; /**< ascending */
    struct {
        tfa_cost_curve plain, refined /**< by TFA_MAX_REFINE steps */, estimated;
    } of[TFA_OP_LAST + 1][TFA_COST_METHODS];
    tfa_cost_curve added[TFA_OP_LAST + 1][TFA_COST_ADDITIONS]; /**< to a plain request */
} tfa_cost_parts;

/**
 * Measures a robot's parts by the processor time of this thread: some 500 requests, two or three
 * times each, before anybody is served.
 * @param robot  its solver is used by nobody else meanwhile
 * @return TFA_OK; TFA_E_MEMORY
 */
TFA_CHECKED int tfa_cost_measure(const tfa_model *model, const tfa_worker_robot *robot,
                                 tfa_cost_parts *parts);

/** Bound on one state of a request, ns, at least 1. An op or method that does not exist: 1, its
 *  refusal is short. @param parts  NULL: UINT32_MAX. Any thread. */
uint32_t tfa_cost_bound(const tfa_cost_parts *parts, const tfa_request *request);

#endif
