/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loops of a model where all its joints are at 0.
 */
#ifndef TOOLS_MODEL_MODEL_LOOPS_H
#define TOOLS_MODEL_MODEL_LOOPS_H

#include <stdbool.h>
#include <totalforce/totalforce.h>

/** Error above which a loop is open, m or rad */
#define MODEL_LOOP_OPEN 1e-6

/** Constraints at the zero posture; contacts are none of it. */
typedef struct model_loops {
    uint32_t checked;                     /**< bits of constraints */
    double error[TFA_MAX_CONSTRAINTS][2]; /**< of the held rows, m and rad */
    uint32_t open;                        /**< bits of those above MODEL_LOOP_OPEN */
    /* where one is open: what tfa_close_loops makes of it */
    int status;          /**< TFA_OK: they close */
    uint32_t iterations; /**< of the posture */
    double left;         /**< largest error, m or rad */
    uint32_t joint;      /**< that changes most */
    double change;       /**< of one of its coordinates, rad or m */
} model_loops;

/** Finds them. @return TFA_OK, or a status of tfa_workspace_create: nothing is checked. */
TFA_CHECKED int model_loops_check(const tfa_model *model, model_loops *loops);

/** Code of the warning about an open loop, and its text. As snprintf. */
#define MODEL_LOOP_CODE "open-loop"
int model_loops_text(const tfa_model *model, const model_loops *loops, uint32_t constraint,
                     char *text, size_t size);

/** Prints a warning for each open loop on standard error, after the name of the file. */
void model_loops_warn(const tfa_model *model, const model_loops *loops, const char *file);

#endif
