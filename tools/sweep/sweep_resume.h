/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Resume files: finished blocks with their statistics, one line each with a checksum, appended by
 * one process. PREFIX.0, PREFIX.1, ... of one sweep are read together.
 *
 *   totalforce-sweep 1 version=... isa=... model=... op=... seed=... count=... block=...
 *   block 12 0:10000 6:10000 ... #43eaeb339d9ba566
 *
 * The first line is everything that decides the result. Words of a block are index:value in
 * hexadecimal: the words of struct statistics that are not zero. The number behind # is the FNV-1a
 * hash of the line before the blank. A line that was cut off is a missing block.
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
