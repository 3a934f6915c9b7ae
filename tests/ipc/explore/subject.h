/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Code under test: its scenarios, its call sites and the errors of its callers.
 */
#ifndef TFA_EXPLORER_SUBJECT_H
#define TFA_EXPLORER_SUBJECT_H

#include <stdatomic.h>

#include "explorer.h"

/** A call site by function and kind */
typedef struct subject_label {
    const char *function;
    int kind;
    const char *label; /**< NULL: it stands for the kernel and is not weakened */
} subject_label;

/** A weakening without effect, with its reason; any other that survives fails. Stronger orders need
 *  no exploration: they admit fewer executions. */
typedef struct subject_harmless {
    const char *function;
    int kind;
    memory_order order; /**< weakened to it */
    const char *reason;
} subject_harmless;

typedef struct subject {
    const char *name;
    const char *files[4];             /**< whose sites are weakened; NULL ends them */
    const subject_label *labels;      /**< a site without a label fails; NULL ends them */
    const subject_harmless *harmless; /**< NULL ends them */
    int scenarios;
    const char *(*scenario_name)(int number);
    explorer_result (*explore)(int number);
    int errors; /**< numbers from 1 below it; 0: none is made */
    void (*make_error)(int error);
    const char *(*error_text)(int error);
} subject;

extern const subject ring_subject, tap_subject;

/** Explores each scenario to its end without a finding. @return number of failures */
int scenarios_run(const subject *s);

/** Explores until a scenario has a finding, number *hint first. @return its name, *finding and its
 *  number in *hint; NULL: none has a finding */
const char *scenarios_find(const subject *s, const char **finding, int *hint);

/** Weakens every order, one call site and one step at a time, and makes every error of a caller.
 *  Each must be found in some scenario. @return number of failures */
int mutations_run(const subject *s);

#endif
