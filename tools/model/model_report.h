/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The load report, for people and as JSON.
 */
#ifndef TOOLS_MODEL_MODEL_REPORT_H
#define TOOLS_MODEL_MODEL_REPORT_H

#include "common/scene_options.h"
#include "model_loops.h"

#include <stdbool.h>
#include <totalforce/text.h>

/** How often the report has messages of one code and severity. */
typedef struct code_count {
    const char *code;
    tfa_severity severity;
    size_t count;
} code_count;

/** Everything that either form of the report tells. Cost: linear in links, joints, messages. */
typedef struct model_report {
    const char *file;
    const scene_options *options;
    const tfa_report *messages;
    const tfa_model *model; /**< NULL: it could not be loaded */
    const char *kernel;     /**< which one answers, and why */
    uint32_t bodies;
    /* links of body b: link_names[first_link[b]] to link_names[first_link[b + 1] - 1]; after the
     * last body those fixed to the world */
    uint32_t *first_link;
    const char **link_names;
    model_loops loops; /**< where all joints are at 0 */
    code_count *codes; /**< in order of first appearance */
    size_t code_count;
} model_report;

/** Groups links by body and messages by code. @return TFA_OK, TFA_E_MEMORY (then free it, too). */
TFA_CHECKED int model_report_init(model_report *report, const char *file,
                                  const scene_options *options, const tfa_report *messages,
                                  const tfa_model *model);
void model_report_free(model_report *report);

/** Prints on standard output. @return 0, or not 0 when that failed. */
int model_report_print_text(const model_report *report);
int model_report_print_json(const model_report *report);
int model_report_print_tree(const model_report *report);

/** A side branch, and the main chain of its tree, in bodies */
typedef struct long_branch {
    uint32_t body; /**< the first */
    uint32_t bodies, chain;
} long_branch;

/** The longest side branch. @return whether it is longer than log2 of its chain, so that methods of
 *  O(log N) on the chain wait for it */
bool model_find_long_branch(const tfa_model *model, long_branch *found);

/** The message says that something of the file has no effect. */
int model_code_is_ignored(const char *code);
/** The message says that something of the file was put right. */
int model_code_is_repaired(const char *code);

/** Words of the rows of a constraint, at most 6. @return how many */
size_t model_constraint_words(uint32_t rows, const char **words);

/** Name of a constraint's link; NULL: the world */
const char *model_constraint_link(const tfa_model *model, const tfa_constraint_info *constraint,
                                  int side);

/** A joint of the model has no motor: the scene names those that have one. */
bool model_names_actuated(const tfa_model *model);

/** Joints by fate, TFA_FATE_ABSENT + 1 numbers. */
void model_count_fates(const tfa_model_summary *summary, uint32_t *counts);

#endif
