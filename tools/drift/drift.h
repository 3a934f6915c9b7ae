/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of `totalforce drift`: energy of a robot that swings freely, over simulated
 * time.
 */
#ifndef TOOLS_DRIFT_DRIFT_H
#define TOOLS_DRIFT_DRIFT_H

#include "chart/chart.h"

#include <stdio.h>

enum { DRIFT_STEPS = 8 };

/* X(NAME, word, what) */
#define DRIFT_INTEGRATOR_LIST(X)                                                                   \
    X(EULER, "euler", "semi-implicit Euler, order 1: new velocities move the joints")              \
    X(RK4, "rk4", "Runge-Kutta, order 4")                                                          \
    X(GBS8, "gbs8", "extrapolated midpoint rule of Gragg, Bulirsch and Stoer, order 8")

typedef enum drift_integrator {
#define DRIFT_INTEGRATOR_ENUM(name, word, what) DRIFT_##name,
    DRIFT_INTEGRATOR_LIST(DRIFT_INTEGRATOR_ENUM)
#undef DRIFT_INTEGRATOR_ENUM
        DRIFT_INTEGRATOR_COUNT
} drift_integrator;

extern const char *const drift_integrator_words[DRIFT_INTEGRATOR_COUNT];

/** Accelerations of n joints. @return a tfa_status */
typedef int drift_accelerate(void *context, const double *q, const double *v, double *a);

/** q'' = a(q, q') */
typedef struct drift_system {
    uint32_t n;
    drift_accelerate *accelerate;
    void *context;
    double *scratch; /**< DRIFT_SCRATCH n numbers */
} drift_system;

#define DRIFT_SCRATCH 20

/** One step of h seconds, in place. @return the status of the first acceleration that failed */
int drift_step(drift_integrator integrator, const drift_system *system, double h, double *q,
               double *v);

typedef struct drift_options {
    chart_target target;
    uint32_t bodies; /**< of a mechanism */
    uint32_t methods[CHART_METHODS], method_count;
    uint32_t precisions[CHART_PRECISION_COUNT], precision_count;
    double steps[DRIFT_STEPS]; /**< s */
    uint32_t step_count;
    drift_integrator integrator;
    uint32_t refine, samples;
    double seconds, turn;
    uint64_t seed;
    const char *folder, *scripts; /**< as in chart_options */
    char *command;
} drift_options;

/** Fills in the options; a usage error ends the program. @return 0 or an errno */
int drift_parse(int argc, char **argv, drift_options *options);

/** A robot that swings from a state at rest, and its energy then. */
typedef struct drift_case {
    chart_case chart;
    uint32_t n;
    double *start; /**< q, then v */
    double energy; /**< kinetic and potential at the start, J */
    double scale;  /**< kinetic energy at the start, and weight times distance of the centre of mass
                        from the origin, J */
} drift_case;

/** @return TFA_OK; otherwise nothing is left to release and the reason stands on stderr */
int drift_case_open(drift_case *c, const drift_options *options);
void drift_case_close(drift_case *c);
/** Kinetic and potential energy in quadruple precision, J. @return a tfa_status */
int drift_energy(const drift_case *c, const double *q, const double *v, double *energy);

/** The solver of a line: method, refinement, precision, as in a chart. */
typedef struct drift_line {
    chart_choice choice;
    double step; /**< s */
    int floor;   /**< accelerations in quadruple precision: the error of the integrator */
    int status;  /**< of the first answer that failed; the line ends there */
    uint32_t count;
    double *time, *error; /**< of each sample: s; energy less that of the start, over the scale */
} drift_line;

/** Integrates, with an acceleration of the caller in place of the line's method where `accelerate`
 * is not NULL. @return TFA_OK or TFA_E_MEMORY */
int drift_run(drift_line *line, drift_case *c, const drift_options *options,
              drift_accelerate *accelerate, void *context);
void drift_line_free(drift_line *line);
/** Largest error up to a sample */
double drift_largest(const drift_line *line, uint32_t sample);
/** "aba f64" */
const char *drift_line_name(const drift_line *line, char *text, size_t size);

void drift_print_head(FILE *out, const drift_options *options);
void drift_print(FILE *out, const drift_case *c, const drift_options *options,
                 const drift_line *line);
/** One sentence for each line, `before` in front of it */
void drift_print_summary(FILE *out, const char *before, const drift_options *options,
                         const drift_line *lines, size_t count);
/** Draws into options->folder. @return an exit status; the reason stands on stderr */
int drift_draw(const drift_options *options, const drift_case *c, const drift_line *lines,
               size_t count);

#endif
