/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce model FILE --advise STATES.jsonl --tolerance T`.
 */
#ifndef TOOLS_MODEL_ADVISE_H
#define TOOLS_MODEL_ADVISE_H

#include "common/scene_options.h"

#include <totalforce/advise.h>

/**
 * Reads states of the model, as lines of `totalforce solve`, and prints which joints a scene may
 * lock in all of them, as a configuration of the daemon. Adds these locks to the options.
 * @param urdf  the model's file
 * @param path  of the states; "-": standard input
 * @return an exit status: EXIT_UNMET where no joint may be locked
 */
int advise_locks(const tfa_model *model, const char *urdf, scene_options *options, const char *path,
                 double tolerance);

/** Prints cost and savings of locking, as comments; `scene` is the model with the locks. */
void advise_print(const tfa_model *model, const tfa_model *scene, const tfa_advice *advice,
                  uint32_t states, double tolerance);

/** Prints the robot as the options describe it, with one scene. The last locks of the options are
 *  those of the advice. @return 0 where writing fails or the file is not there (errno) */
int advise_print_robot(const tfa_model *model, const char *urdf, const scene_options *options,
                       const tfa_advice *advice);

#endif
