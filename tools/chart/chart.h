/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of `totalforce chart`: cases, their data, and one row for each measurement.
 */
#ifndef TOOLS_CHART_CHART_H
#define TOOLS_CHART_CHART_H

#include "mechanism/mechanism.h"

#include <stdio.h>
#include <totalforce/totalforce.h>

enum {
    CHART_METHODS = 32,
    CHART_CASES = 32,
    CHART_SIZES = 16,
    CHART_STATES = 16,
    CHART_SEEDS = 16,
    CHART_REFINE = 3,
    CHART_THREADS = 8,        /* numbers of threads */
    CHART_BATCH_STATES = 512, /* states of a batch of robots up to 128 bodies */
    CHART_PEER = 24           /* the number of the first peer; smaller ones are tfa_method */
};

/* X(NAME, word, op, what) */
#define CHART_OP_LIST(X)                                                                           \
    X(FORWARD, "forward_dynamics", TFA_OP_FORWARD_DYNAMICS, "accelerations of the joints")         \
    X(LAMBDA, "operational_inertia", TFA_OP_OPERATIONAL_INERTIA,                                   \
      "Lambda^-1 of one link, 6 x 6, in f64 or f128; has no right-hand side")

typedef enum chart_op {
#define CHART_OP_ENUM(name, word, op, what) CHART_##name,
    CHART_OP_LIST(CHART_OP_ENUM)
#undef CHART_OP_ENUM
        CHART_OP_COUNT
} chart_op;

extern const char *const chart_op_words[CHART_OP_COUNT];
extern const tfa_op chart_ops[CHART_OP_COUNT];

/** Numbers of Lambda^-1 of one link */
#define CHART_LAMBDA_NUMBERS 36

/* X(NAME, word, what) */
#define CHART_RHS_LIST(X)                                                                          \
    X(QDD, "qdd", "torques of a random qdd, computed in f128 and rounded; moving")                 \
    X(TAU, "tau", "random torques N(0,1) N m; moving")                                             \
    X(GRAVITY, "gravity", "no torques, at rest under gravity")

typedef enum chart_rhs {
#define CHART_RHS_ENUM(name, word, what) CHART_##name,
    CHART_RHS_LIST(CHART_RHS_ENUM)
#undef CHART_RHS_ENUM
        CHART_RHS_COUNT
} chart_rhs;

extern const char *const chart_rhs_words[CHART_RHS_COUNT];

/* X(NAME, word, precision of the factors, of the residual, what) */
#define CHART_PRECISION_LIST(X)                                                                    \
    X(F64, "f64", TFA_F64, TFA_RESIDUAL_SAME, "double")                                            \
    X(F32, "f32", TFA_F32, TFA_RESIDUAL_SAME, "float")                                             \
    X(F32_F64, "f32+f64", TFA_F32, TFA_RESIDUAL_F64, "float; refined by residuals in double")      \
    X(F64_F128, "f64+f128", TFA_F64, TFA_RESIDUAL_F128,                                            \
      "double; refined by residuals in quadruple precision")                                       \
    X(F128, "f128", TFA_F128, TFA_RESIDUAL_SAME, "quadruple precision")

typedef enum chart_precision {
#define CHART_PRECISION_ENUM(name, word, precision, residual, what) CHART_##name,
    CHART_PRECISION_LIST(CHART_PRECISION_ENUM)
#undef CHART_PRECISION_ENUM
        CHART_PRECISION_COUNT
} chart_precision;

extern const char *const chart_precision_words[CHART_PRECISION_COUNT];
extern const tfa_workspace_options chart_precisions[CHART_PRECISION_COUNT];

/* X(NAME, word, batch, specialised, what) */
#define CHART_STRATEGY_LIST(X)                                                                     \
    X(SINGLE, "single", 0, 0, "one state a request")                                               \
    X(BATCH, "batch", 1, 0, "512 states a request (64 above 128 bodies)")                          \
    X(SPECIALISED, "specialised", 0, 1, "one state, by the specialised kernel in --kernels")       \
    X(SPECIALISED_BATCH, "specialised-batch", 1, 1, "512 states, by the specialised kernel")

typedef enum chart_strategy {
#define CHART_STRATEGY_ENUM(name, word, batch, specialised, what) CHART_##name,
    CHART_STRATEGY_LIST(CHART_STRATEGY_ENUM)
#undef CHART_STRATEGY_ENUM
        CHART_STRATEGY_COUNT
} chart_strategy;

extern const char *const chart_strategy_words[CHART_STRATEGY_COUNT];
int chart_is_batch(uint32_t strategy);
int chart_is_specialised(uint32_t strategy);

/** A mechanism, or a robot from a file. */
typedef struct chart_target {
    const char *label; /**< as on the command line: NAME, NAME:X or a file */
    const char *file;  /**< NULL: a mechanism */
    mechanism_kind kind;
    double value; /**< X: its mass ratio, taper or radius; 0: the default */
} chart_target;

typedef struct chart_options {
    chart_target targets[CHART_CASES];
    uint32_t target_count;
    uint32_t sizes[CHART_SIZES], size_count;
    uint32_t methods[CHART_METHODS], method_count;
    uint32_t precisions[CHART_PRECISION_COUNT], precision_count;
    uint32_t threads[CHART_THREADS], thread_count;
    uint32_t strategies[CHART_STRATEGY_COUNT], strategy_count;
    uint32_t ops;    /**< bit set of chart_op */
    uint32_t rhs;    /**< bit set of chart_rhs */
    uint32_t refine; /**< bit set of refinement steps */
    uint32_t states; /**< of each case, seed and right-hand side */
    uint32_t seeds;  /**< of each case: seed, seed + 1, ... */
    uint32_t budget; /**< CPU time for one row, ms */
    double turn;     /**< joint angles are drawn from +-turn rad; 0: as the target has it */
    uint64_t seed;
    tfa_base base; /**< of files */
    int json;
    const char *folder;  /**< for CSV and pictures; NULL: rows on standard output only */
    const char *html;    /**< file of the page; NULL: none */
    const char *kernels; /**< folder of specialised kernels; NULL: none */
    const char *scripts; /**< folder of the gnuplot scripts; NULL: beside the program */
    const char *tip;     /**< link of Lambda^-1; NULL: the one behind most joints */
    char *command;       /**< the command line, for the header */
} chart_options;

/** Fills in the options; a usage error ends the program. @return 0 or an errno */
int chart_parse(int argc, char **argv, chart_options *options);

struct argp_state;
/** For option_list_read: a number of bodies, a chart_precision. */
uint32_t chart_read_size(struct argp_state *state, const char *name, const char *word);
uint32_t chart_read_precision(struct argp_state *state, const char *name, const char *word);

/** The solver of a row: a method, or a peer, with all that it can be given. */
typedef struct chart_choice {
    uint32_t method; /**< tfa_method, or CHART_PEER and up */
    uint32_t refine;
    uint32_t precision; /**< chart_precision */
    uint32_t threads;   /**< more than 1: on a pool */
    uint32_t strategy;  /**< chart_strategy */
    uint32_t op;        /**< chart_op */
} chart_choice;

/** "aba", "mujoco". */
const char *chart_method_name(uint32_t method);
/** Method or peer of that name, or -1. */
int32_t chart_method_find(const char *name);

typedef struct chart_peer chart_peer;

/** Computes requests of one precision. */
typedef struct chart_solver {
    tfa_workspace *workspace; /**< one thread */
    tfa_batch_pool *pool;     /**< several threads; NULL: the workspace */
    int status;               /**< why there is neither */
} chart_solver;

/** A model with all that answers for it. */
typedef struct chart_case {
    char name[64];
    uint32_t bodies; /**< moving bodies of the file or mechanism, before merging */
    uint32_t threads, strategy;
    chart_op op;  /**< of the data that are made next */
    uint32_t tip; /**< frame of Lambda^-1 */
    tfa_model *model;
    tfa_workspace *f64, *f128;                   /**< one thread, generic */
    tfa_specialised *kernel;                     /**< NULL: none, or the strategy needs none */
    chart_solver solvers[CHART_PRECISION_COUNT]; /**< of this strategy, where asked for */
    tfa_thread_pool *thread_pool;                /**< of all pools; NULL: one thread */
    chart_solver baseline;                       /**< f64, these threads, generic: for aba */
    chart_peer *peers;                           /**< all that were asked for; NULL: none */
    tfa_model *neighbour;          /**< the same with the last bit of every number changed */
    tfa_workspace *neighbour_f128; /**< sines and cosines rounded to double */
    uint64_t random;
    double turn; /**< joint angles are drawn from +-turn rad, displacements from a tenth in m */
} chart_case;

/** @return TFA_OK; otherwise nothing is left to release and the reason stands on stderr */
int chart_case_open(chart_case *c, const chart_options *options, const chart_target *target,
                    uint32_t bodies, uint32_t threads, uint32_t strategy);
/** The same of any mechanism, for one thread and without peers. */
int chart_case_open_mechanism(chart_case *c, const mechanism_options *mechanism, const char *label);
void chart_case_close(chart_case *c);

/** Makes the solvers of the case's strategy and threads. A precision or a kernel that is not there
 * is noted in the rows. @return a tfa_status: of the baseline */
int chart_solvers_open(chart_case *c, const chart_options *options);
void chart_solvers_close(chart_case *c);
int chart_solve(const chart_solver *solver, const tfa_request *request, tfa_reply *reply);

/** Makes the neighbour of the robot, whose description is changed. @return a tfa_status */
int chart_floor_open(chart_case *c, tfa_description *description, const tfa_model_options *options);
void chart_floor_close(chart_case *c);

/** Makes the peers among the methods asked for: from the URDF file, or, where that is NULL, from
 * one that is written for them. Refusals are told in the rows. */
int chart_peers_open(chart_case *c, const chart_options *options, const char *file,
                     const mechanism_options *mechanism);
void chart_peers_close(chart_peer *peers);
/** Why the peer does not answer for this robot: one word or NULL; `about` gets its message. */
const char *chart_peer_refusal(const chart_case *c, uint32_t method, char *about, size_t size);

/** States of one case and right-hand side, one after the other, and the exact answers. */
typedef struct chart_data {
    chart_op op;
    chart_rhs rhs;
    tfa_method exact_method; /**< of the exact answers, in f128 */
    uint32_t tip;
    uint32_t answer;             /**< numbers of an answer */
    uint32_t states, q, v, base; /**< numbers of one state */
    double *block;               /**< all arrays below */
    double *coordinates, *velocity, *tau, *pose;
    double *exact; /**< qdd by aba in f128, base acceleration behind it; or Lambda^-1 */
    double *found; /**< of one state */
    double floor;  /**< median over the states */
} chart_data;

/** Draws the states and computes their exact answers and the floor. @return a tfa_status */
int chart_data_make(chart_data *d, chart_case *c, chart_rhs rhs, uint32_t states);
/** The part of it that finds the floor. */
int chart_floor_find(chart_data *d, chart_case *c);
void chart_data_free(chart_data *d);

/** Whether the method, or the peer, answers the op in this precision */
int chart_op_answered(uint32_t op, uint32_t method, uint32_t precision);
/** The frame of the named link, or of the body behind most joints where it is NULL or absent. */
uint32_t chart_find_tip(const tfa_model *model, const char *link);
/** Method of the exact answers of so many bodies: aba, or for Lambda^-1 crba (a dense solution with
 * the factors of M and the Jacobian) up to 128 bodies and propagation above. */
tfa_method chart_exact_method(chart_op op, uint32_t bodies);

/** A peer's answer to one state, into d->found. */
void chart_peer_answer(const chart_case *c, uint32_t method, const chart_data *d, uint32_t state);

/** Request and reply of one state, with room in d->found. */
tfa_request chart_request(const chart_data *d, uint32_t state);
tfa_reply chart_reply(const chart_data *d, tfa_answer *answer);

/** The states of the data, over and over, as one request, and room for its answers */
typedef struct chart_batch {
    tfa_request request;
    tfa_reply reply;
    double *block;
} chart_batch;

/** @return TFA_OK or TFA_E_MEMORY */
int chart_batch_make(chart_batch *b, const chart_data *d, uint32_t bodies);
/** The answer to one of its states, into d->found */
void chart_batch_answer(const chart_batch *b, const chart_data *d, uint32_t state);
void chart_batch_free(chart_batch *b);

/** Relative error of d->found against the exact answer of the state: 2-norm (of a matrix the
 * Frobenius norm), and the largest of single components. */
double chart_error(const chart_data *d, uint32_t state, double *worst_component);

/** FNV-1a over the bits of the answer in d->found, carried on from `hash`. */
#define CHART_HASH_START UINT64_C(0xcbf29ce484222325)
#define CHART_HASH_PRIME UINT64_C(0x100000001b3)
uint64_t chart_hash_answer(uint64_t hash, const chart_data *d);

/** Subject of a refusal, by name */
void chart_name_invalid_field(char *text, size_t size, const chart_case *c, const tfa_reply *reply);

double chart_median(double *values, uint32_t count);

/** One measurement. */
typedef struct chart_row {
    char target[64];
    uint32_t bodies;
    chart_rhs rhs;
    chart_choice choice;
    int status;                   /**< of the first state that was not answered */
    const char *skipped;          /**< why it was not asked at all: one word; NULL: it was */
    char field[64];               /**< subject of status or skipped */
    uint32_t answered_by;         /**< tfa_method: another one after a fallback */
    double error;                 /**< relative 2-norm, median over the states */
    double error_low, error_high; /**< least and largest of the seeds' errors */
    double worst;                 /**< largest relative error of a component in any state */
    double floor;                 /**< of the data */
    double estimate;              /**< as replied, median; NaN without refinement */
    double time, aba_time;        /**< us a state: medians of interleaved samples */
    double time_low, time_high;   /**< least and largest of the seeds' times */
    double ratio;                 /**< median of time / aba_time of neighbours */
    uint32_t samples;
    uint64_t bits; /**< hash of all bits of all answers */
    /** tfa_method or peer of an earlier row, with as many steps, whose answers are the same to
     * the last bit; 0: none */
    uint32_t same_as;
    int front; /**< on the Pareto front of its target, size, threads and right-hand side */
} chart_row;

/** A call that takes longer than this many budgets is not repeated, and is not made for any larger
 * robot: there is no answer in the chart. */
#define CHART_OVER_BUDGET 20.0
#define CHART_SKIPPED_OVER_BUDGET "over_budget"
/** Subject of a row whose precision is not built */
#define CHART_FIELD_PRECISION "precision"

/** Subject of a row whose kernel is not in --kernels */
#define CHART_FIELD_KERNEL "kernel"

/** Puts rows of several seeds together, `count` of each seed one behind the other, into the first
 * `count`: medians over the seeds, and their least and largest errors and times. If a row is not
 * good for one of the seeds, the row of that seed stands for all. */
void chart_combine_seeds(chart_row *rows, size_t count, uint32_t seeds);
/** Sets same_as, of one state at a time on one thread. Rows that quadruple precision makes exact
 * have none. */
void chart_find_same(chart_row *rows, size_t count);

/** Names the case in the row, which has no numbers yet. */
void chart_row_begin(chart_row *row, const chart_case *c, const chart_data *d);
/** Errors and times of row->who.
 * @param budget_ms  a call that takes CHART_OVER_BUDGET of them is not repeated
 * @param seconds    for timing */
void chart_measure(chart_row *row, chart_case *c, const chart_data *d, uint32_t budget_ms,
                   double seconds);
/** The part of it that is time: the choice and aba in turns, the batch if it has a block, else one
 * state a request. @return a tfa_status */
int chart_measure_times(chart_row *row, chart_batch *batch, chart_case *c, const chart_data *d,
                        double seconds);
/** CPU time of this thread, s. */
double chart_now(void);
/** One answer, into d->found; `reply` from chart_reply, `solver` unused for peers. @return its
 * status */
int chart_answer(const chart_case *c, const chart_solver *solver, const chart_choice *choice,
                 const chart_data *d, uint32_t state, tfa_reply *reply);

/** Marks the front among rows of one target, size, threads and right-hand side. Errors below the
 * floor of the data count as the floor, errors within a factor of two as equal, and errors of
 * CHART_NO_DIGIT or more as no answer. A row whose answers are the same as those of an earlier one
 * is not on the front. */
#define CHART_NO_DIGIT 0.1
void chart_mark_front(chart_row *rows, size_t count);
/** An answer of the method itself, with a finite error. */
int chart_row_good(const chart_row *row);
/** "ok", "fallback", "over_budget", "E_SINGULAR", ...: as in the column status. */
const char *chart_row_status(const chart_row *row);
/** "qdd"; "": the op has none */
const char *chart_row_rhs(const chart_row *row);

void chart_print_head(FILE *out, const chart_options *options);
void chart_print_row(FILE *out, const chart_row *row);
void chart_print_row_json(FILE *out, const chart_row *row);

/** Draws into options->folder. @return an exit status; the reason stands on stderr */
int chart_draw(const chart_options *options, const chart_row *rows, size_t count);
/** Writes the page and closes its file. @return an exit status; the reason stands on stderr */
int chart_page(FILE *out, const chart_options *options, const chart_row *rows, size_t count);
/* Parts of chart_draw: the commands for gnuplot. */
/** The scatter of one target, size and number of threads. */
void chart_draw_scatter(FILE *gnuplot, const chart_options *options, const chart_row *rows,
                        size_t count);
/** The overview: rows of one precision and number of threads. */
void chart_draw_overview(FILE *gnuplot, const chart_options *options, const chart_row *rows,
                         size_t count);
/** time_name: label of the axis of time */
void chart_set_time_name(FILE *gnuplot, const chart_choice *choice);
/** Threads and strategy, where they are not one thread and single: ", 2 threads, batch" for a title
 * or "-2-threads-batch" for the name of a file */
const char *chart_name_how(const chart_choice *choice, int file, char *text, size_t size);
/** Smaller numbers have no place on an axis; larger errors are drawn as if they were this one. */
#define CHART_ERROR_MIN 1e-17
#define CHART_ERROR_MAX 1e2
/** Number of a method's mark in style.gp, from 1 on */
uint32_t chart_mark(uint32_t method);
/** Whether the row has a mark of its own */
int chart_row_drawn(const chart_row *row);
double chart_draw_error(double error);
double chart_draw_floor(const chart_row *row);
/** Of positive numbers; zero-initialised: none yet. */
typedef struct chart_range {
    double low, high;
} chart_range;
void chart_range_extend(chart_range *range, double value);
/** low_time, high_time, time_tics, time_format: axes with a margin, 1 to 10 without any time. */
void chart_set_times(FILE *gnuplot, const chart_range *times, uint32_t count);

#endif
