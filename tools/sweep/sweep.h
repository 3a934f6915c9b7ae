/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce sweep`: one operation of one robot for many states. Blocks of states are the unit of
 * work, of the resume file and of what threads, ranks and parts share.
 */
#ifndef TOOLS_SWEEP_SWEEP_H
#define TOOLS_SWEEP_SWEEP_H

#include "common/scene_options.h"
#include "statistics.h"
#include "sweep_ranks.h"
#include "sweep_states.h"

#include <totalforce/dynamics.h>

/* 2^16 states of an arm are 5 ms of a core: a block costs nothing to hand out, and its line in the
 * resume file is short beside its work. */
enum { SWEEP_BLOCK = 65536, SWEEP_BLOCK_MAX = 1 << 24, SWEEP_BLOCKS_MAX = 1 << 30 };
enum { SWEEP_THREADS_MAX = 256, SWEEP_PARTS_MAX = 100000 };

typedef struct sweep_options {
    const char *file;
    scene_options scene;
    tfa_workspace_options workspace;
    tfa_op op;
    tfa_method method;
    tfa_estimate estimate;
    uint32_t refine;
    char *tips;         /**< names with commas between; NULL: none */
    const char *states; /**< file of records; NULL: drawn from `seed` */
    uint64_t count;     /**< 0: all of the file from `offset` on */
    uint64_t offset, seed;
    state_ranges ranges;
    uint32_t threads; /**< of each rank; 0: one for each processor */
    uint32_t block;
    uint32_t part, parts; /**< 1 .. parts; 0: the whole */
    const char *resume;   /**< prefix of the files of finished blocks */
    const char *out, *out_states;
    uint64_t reference;  /**< every how many states; 0: none */
    double expect_error; /**< 0: nothing expected */
    int merge, json, quiet;
} sweep_options;

/** Fills in the options; a usage error ends the program. @return 0 or an errno */
int sweep_parse(int argc, char **argv, sweep_options *options);

/** What is computed: the options, with the robot. Shared by the threads. Release with
 *  sweep_plan_free. */
typedef struct sweep_plan {
    const sweep_options *options;
    tfa_model *model;
    tfa_request request; /**< op, method, policies and tips */
    state_record record;
    uint32_t base, joint, matrix; /**< doubles of an answer: base and joints, or a matrix */
    uint32_t answer;              /**< their sum */
    uint64_t first, count, blocks;
    int states;     /**< file, or -1 */
    char *identity; /**< all that decides the answers, in one line */
} sweep_plan;

/** Rank 0 reads the files, the others get them from it. @return an exit status; the reason stands
 *  on stderr */
int sweep_plan_make(sweep_plan *plan, sweep_options *options, sweep_ranks *ranks);
void sweep_plan_free(sweep_plan *plan);

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
    sweep_ranks *ranks;
    tfa_workspace *workspace, *reference;
    uint32_t chunk; /**< states of a request */
    double *memory, *records, *fields[STATE_FIELDS];
    double *base, *joint, *matrix; /**< answers of a chunk */
    double *exact, *packed;        /**< one answer; answers of a chunk as records */
    tfa_answer *answers;
    tfa_request request;
    tfa_reply reply;
    statistics statistics; /**< of the last block */
    double groups[4];      /**< of STATISTICS_SERIES */
    double seconds[SWEEP_TIMES];
    char error[256];
} sweep_worker;

/** @return TFA_OK or a status of tfa_workspace_create; sweep_worker_close is due in both cases */
int sweep_worker_open(sweep_worker *worker, const sweep_plan *plan, sweep_ranks *ranks);
void sweep_worker_close(sweep_worker *worker);
/** Answers one state, so that a request which no state can have answered is found before the work.
 *  @return the status of the request if it is of that kind, TFA_OK otherwise */
int sweep_worker_try(sweep_worker *worker);
/** Computes a block; writes its states and answers where the options say so.
 *  @return 0, or -1 with the reason in `error` */
int sweep_worker_block(sweep_worker *worker, uint64_t block);

/** Statistics of the states from..from + count - 1 of a chunk, whose first state is number `state`
 *  of the sweep. */
void sweep_worker_count(sweep_worker *worker, uint64_t state, uint32_t count);

/** States of a block: all but the last have options->block. */
uint64_t sweep_block_count(const sweep_plan *plan, uint64_t block);

/** Results of a run, on rank 0 those of all ranks */
typedef struct sweep_results {
    statistics statistics;
    uint8_t *done;            /**< bit set of finished blocks */
    uint64_t finished, found; /**< blocks; those of the resume files */
    uint64_t states;          /**< computed in this run */
    double elapsed;           /**< s, of this run */
    double seconds[SWEEP_TIMES];
    uint32_t threads;
    int interrupted;
} sweep_results;

/** Computes what is not finished yet. @return an exit status; the reason stands on stderr */
int sweep_run(const sweep_plan *plan, sweep_ranks *ranks, sweep_results *results);
void sweep_results_free(sweep_results *results);

static inline int sweep_is_done(const uint8_t *done, uint64_t block)
{
    return done[block / 8] >> block % 8 & 1;
}

static inline void sweep_set_done(uint8_t *done, uint64_t block)
{
    done[block / 8] |= (uint8_t)(1u << block % 8);
}

/** Says which blocks are missing and what computes them. */
void sweep_print_missing(const sweep_plan *plan, const sweep_results *results);
/** Rate and shares of this run, on stderr. */
void sweep_print_rate(const sweep_results *results, int ranks);
/** Statistics on standard output. @return an exit status */
int sweep_print(const sweep_plan *plan, const sweep_results *results, int ranks);

/** The whole command; `ranks` is its way to the other ranks. */
int sweep_main(int argc, char **argv, sweep_ranks *ranks);

#endif
