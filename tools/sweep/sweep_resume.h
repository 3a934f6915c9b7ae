/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Resume files: finished blocks with their statistics, one line each with a checksum, appended by
 * one process. PREFIX.0, PREFIX.1, ... of one sweep are read together. Format: docs/sweep.md.
 */
#ifndef TOOLS_SWEEP_SWEEP_RESUME_H
#define TOOLS_SWEEP_SWEEP_RESUME_H

#include "sweep.h"

/** Reads all files of the prefix: merges the blocks into the results and marks them as done.
 *  @return an exit status; the reason stands on stderr */
int sweep_resume_read(const sweep_plan *plan, sweep_results *results);

/** Opens PREFIX.`number` to append to, for one process at a time. @return NULL after a message */
FILE *sweep_resume_open(const sweep_plan *plan, unsigned number);

/** Appends a block. @return 0 or an errno */
int sweep_resume_add(FILE *out, uint64_t block, const statistics *s);

#endif
