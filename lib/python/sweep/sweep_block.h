/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One operation of one robot for a block of states: draws or reads them, solves them in batches,
 * counts. Which blocks there are, and who computes them: totalforce_tools/sweep.py.
 */
#ifndef PYTHON_SWEEP_BLOCK_H
#define PYTHON_SWEEP_BLOCK_H

#include "sweep_states.h"
#include "sweep_statistics.h"

/** What is computed. Shared by the workers. Release with sweep_plan_free. */
typedef struct sweep_plan {
    const tfa_model *model;
    tfa_request request; /**< op, method, policies and tips */
    tfa_workspace_options workspace;
    state_record record;
    uint32_t base, joint, matrix; /**< doubles of an answer: base and joints, or a matrix */
    uint32_t answer;              /**< their sum */
    uint64_t seed;                /**< of drawn states */
    uint64_t first;               /**< state at the begin of the files that are written */
    uint64_t reference;           /**< every how many states; 0: none */
} sweep_plan;

/** Completes a plan of which model, request, workspace.precision, workspace.residual and the
 *  numbers are set. `text`, of `length` bytes: the URDF with the limits of the joints; NULL: none.
 *  @return TFA_OK or a status of tfa_urdf_limits */
int sweep_plan_complete(sweep_plan *plan, const state_ranges *ranges, const char *text,
                        size_t length);
void sweep_plan_free(sweep_plan *plan);

typedef struct sweep_file {
    int number; /**< descriptor; -1: none */
    const char *path;
} sweep_file;

/** Parts of a worker's time */
typedef enum sweep_time {
    SWEEP_TIME_STATES,
    SWEEP_TIME_DYNAMICS,
    SWEEP_TIME_STATISTICS,
    SWEEP_TIME_REFERENCE,
    SWEEP_TIME_OUTPUT,
    SWEEP_TIMES
} sweep_time;

/** One thread's memory. Release with sweep_worker_close. */
typedef struct sweep_worker {
    const sweep_plan *plan;
    tfa_workspace *workspace, *reference;
    sweep_file states, out, out_states; /**< read; written: answers and states */
    uint32_t chunk;                     /**< states of a request */
    double *memory, *records, *fields[STATE_FIELDS];
    double *base, *joint, *matrix; /**< answers of a chunk */
    double *exact, *packed;        /**< one answer; answers of a chunk as records */
    tfa_answer *answers;
    tfa_request request;
    tfa_reply reply;
    statistics statistics; /**< of the last block */
    double groups[SERIES];
    double seconds[SWEEP_TIMES];
    char error[256];
    int busy; /**< 1: a thread computes with it */
} sweep_worker;

/** @return TFA_OK or a status of tfa_workspace_create; sweep_worker_close is due in both cases */
int sweep_worker_open(sweep_worker *worker, const sweep_plan *plan);
void sweep_worker_close(sweep_worker *worker);
/** Answers one state, so that a request which no state can have answered is found before the work.
 *  @return the status of the request if it is of that kind, TFA_OK otherwise */
int sweep_worker_try(sweep_worker *worker);
/** Computes states first .. first + count - 1, `first` at a multiple of STATISTICS_GROUP behind the
 *  plan's; writes states and answers into the files that there are.
 *  @return 0, or -1 with the reason in `error` */
int sweep_worker_block(sweep_worker *worker, uint64_t first, uint64_t count);

/** Statistics of the first `count` states of a chunk, whose first state is number `state`. */
void sweep_worker_count(sweep_worker *worker, uint64_t state, uint32_t count);

#endif
