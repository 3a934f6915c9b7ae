/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cases of `totalforce atlas` and `totalforce drift`: robots, their states, the exact answers and
 * the floor. Those of `totalforce chart` are in tools/python.
 */
#ifndef TOOLS_CHART_CHART_H
#define TOOLS_CHART_CHART_H

#include "mechanism/mechanism.h"

#include <totalforce/totalforce.h>

enum { CHART_METHODS = 32, CHART_STATES = 16, CHART_SEEDS = 16, CHART_REFINE = 3 };

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

/** A mechanism, or a robot from a file. */
typedef struct chart_target {
    const char *label; /**< as on the command line: NAME, NAME:X or a file */
    const char *file;  /**< NULL: a mechanism */
    mechanism_kind kind;
    double value; /**< X: its mass ratio, taper or radius; 0: the default */
} chart_target;

typedef struct chart_options {
    uint32_t precisions[CHART_PRECISION_COUNT], precision_count; /**< of the solvers */
    double turn; /**< joint angles are drawn from +-turn rad; 0: as the target has it */
    uint64_t seed;
    tfa_base base;   /**< of files */
    const char *tip; /**< link of Lambda^-1; NULL: the one behind most joints */
} chart_options;

struct argp_state;
/** For option_list_read: a number of bodies, a chart_precision. */
uint32_t chart_read_size(struct argp_state *state, const char *name, const char *word);
uint32_t chart_read_precision(struct argp_state *state, const char *name, const char *word);

/** The solver of a row: a method with all that it can be given. */
typedef struct chart_choice {
    uint32_t method; /**< tfa_method */
    uint32_t refine;
    uint32_t precision; /**< chart_precision */
} chart_choice;

/** "aba" */
const char *chart_method_name(uint32_t method);
/** Computes requests of one precision. */
typedef struct chart_solver {
    tfa_workspace *workspace;
    int status; /**< why there is none */
} chart_solver;

/** A model with all that answers for it. */
typedef struct chart_case {
    char name[64];
    uint32_t bodies; /**< moving bodies of the file or mechanism, before merging */
    chart_op op;     /**< of the data that are made next */
    uint32_t tip;    /**< frame of Lambda^-1 */
    tfa_model *model;
    tfa_workspace *f64, *f128;                   /**< one thread, generic */
    chart_solver solvers[CHART_PRECISION_COUNT]; /**< where asked for */
    tfa_model *neighbour;          /**< the same with the last bit of every number changed */
    tfa_workspace *neighbour_f128; /**< sines and cosines rounded to double */
    uint64_t random;
    double turn; /**< joint angles are drawn from +-turn rad, displacements from a tenth in m */
} chart_case;

/** @return TFA_OK; otherwise nothing is left to release and the reason stands on stderr */
int chart_case_open(chart_case *c, const chart_options *options, const chart_target *target,
                    uint32_t bodies);
/** The same of any mechanism. */
int chart_case_open_mechanism(chart_case *c, const mechanism_options *mechanism, const char *label);
void chart_case_close(chart_case *c);

/** Makes the neighbour of the robot, whose description is changed. @return a tfa_status */
int chart_floor_open(chart_case *c, tfa_description *description, const tfa_model_options *options);
void chart_floor_close(chart_case *c);

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

/** The frame of the named link, or of the body behind most joints where it is NULL or absent. */
uint32_t chart_find_tip(const tfa_model *model, const char *link);
/** Method of the exact answers of so many bodies: aba, or for Lambda^-1 crba (a dense solution with
 * the factors of M and the Jacobian) up to 128 bodies and propagation above. */
tfa_method chart_exact_method(chart_op op, uint32_t bodies);

/** Request and reply of one state, with room in d->found. */
tfa_request chart_request(const chart_data *d, uint32_t state);
tfa_reply chart_reply(const chart_data *d, tfa_answer *answer);

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

/** Number of a method's mark in style.gp, from 1 on */
uint32_t chart_mark(uint32_t method);

#endif
