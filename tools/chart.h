/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the parts of `totalforce chart` share: cases, their data, and one row for each measurement.
 */
#ifndef TFA_TOOLS_CHART_H
#define TFA_TOOLS_CHART_H

#include "mechanism.h"

#include <stdio.h>
#include <totalforce/totalforce.h>

enum {
    CHART_METHODS = 32,
    CHART_CASES = 32,
    CHART_SIZES = 16,
    CHART_STATES = 16,
    CHART_REFINE = 3
};

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

/** A mechanism, or a robot from a file. */
typedef struct chart_subject {
    const char *label; /**< as on the command line: NAME, NAME:X or a file */
    const char *file;  /**< NULL: a mechanism */
    mechanism_kind kind;
    double value; /**< X: its mass ratio, taper or radius; 0: the default */
} chart_subject;

typedef struct chart_options {
    chart_subject subjects[CHART_CASES];
    uint32_t subject_count;
    uint32_t sizes[CHART_SIZES], size_count;
    uint32_t methods[CHART_METHODS], method_count;
    uint32_t rhs;    /**< bit set of chart_rhs */
    uint32_t refine; /**< bit set of refinement steps */
    uint32_t states; /**< of each case and right-hand side */
    uint32_t budget; /**< CPU time for one row, ms */
    uint64_t seed;
    tfa_base base; /**< of files */
    int json;
    const char *folder;  /**< for CSV and pictures; NULL: rows on standard output only */
    const char *scripts; /**< folder of the gnuplot scripts; NULL: beside the program */
    char *command;       /**< the command line, for the header */
} chart_options;

/** Fills in the options; a usage error ends the program. @return 0 or an errno */
int chart_parse(int argc, char **argv, chart_options *options);

/** A model with a workspace of each precision. */
typedef struct chart_case {
    char name[64];
    uint32_t bodies; /**< moving bodies of the file or mechanism, before merging */
    tfa_model *model;
    tfa_workspace *f64, *f128;
    uint64_t random;
    int stay; /**< keep near q = 0, where the mechanism stands as its name says */
} chart_case;

/** @return TFA_OK; otherwise nothing is left to release and the reason stands on stderr */
int chart_case_open(chart_case *c, const chart_options *options, const chart_subject *subject,
                    uint32_t bodies);
/** The same of any mechanism. */
int chart_case_open_mechanism(chart_case *c, const mechanism_options *mechanism, const char *label);
void chart_case_close(chart_case *c);

/** States of one case and right-hand side, one after the other, and the exact answers. */
typedef struct chart_data {
    chart_rhs rhs;
    uint32_t states, q, v, base; /**< numbers of one state */
    double *block;               /**< all arrays below */
    double *coordinates, *velocity, *tau, *pose;
    double *exact; /**< qdd by aba in f128, base acceleration behind it */
    double *found; /**< of one state */
    double floor;  /**< median over the states */
} chart_data;

/** Draws the states and computes their exact answers and the floor. @return a tfa_status */
int chart_data_make(chart_data *d, chart_case *c, chart_rhs rhs, uint32_t states);
void chart_data_free(chart_data *d);

/** Request and reply of one state, with room in d->found. */
tfa_request chart_request(const chart_data *d, uint32_t state);
tfa_reply chart_reply(const chart_data *d, tfa_answer *answer);

/** Relative error of d->found against the exact answer of the state: 2-norm, and the largest of
 * single components. */
double chart_error(const chart_data *d, uint32_t state, double *worst_component);

/** What a refusal was about, by name. */
void chart_name_culprit(char *text, size_t size, const chart_case *c, const tfa_reply *reply);

double chart_median(double *values, uint32_t count);

/** One measurement. */
typedef struct chart_row {
    char subject[64];
    uint32_t bodies;
    chart_rhs rhs;
    uint32_t method, refine;
    int status;            /**< of the first state that was not answered */
    char field[64];        /**< what it was about */
    uint32_t answered_by;  /**< tfa_method: another one after a fallback */
    double error;          /**< relative 2-norm, median over the states */
    double worst;          /**< largest relative error of a component in any state */
    double floor;          /**< of the data */
    double estimate;       /**< as replied, median; NaN without refinement */
    double time, aba_time; /**< us a call: medians of interleaved samples */
    double ratio;          /**< median of time / aba_time of neighbours */
    uint32_t samples;
    int front; /**< on the Pareto front of its subject, size and right-hand side */
} chart_row;

/** Errors and times of one method. */
void chart_measure(chart_row *row, chart_case *c, const chart_data *d, uint32_t budget_ms);

/** Marks the front among rows of one subject, size and right-hand side. Errors below the floor of
 * the data count as the floor, and errors within a factor of two as equal. */
void chart_mark_front(chart_row *rows, size_t count);
/** An answer of the method itself, with a finite error. */
int chart_row_good(const chart_row *row);

void chart_print_head(FILE *out, const chart_options *options);
void chart_print_row(FILE *out, const chart_row *row);
void chart_print_row_json(FILE *out, const chart_row *row);

/** Draws into options->folder. @return an exit status; the reason stands on stderr */
int chart_draw(const chart_options *options, const chart_row *rows, size_t count);
/** Part of chart_draw: the commands of the overview. */
void chart_draw_overview(FILE *gnuplot, const chart_options *options, const chart_row *rows,
                         size_t count);

#endif
