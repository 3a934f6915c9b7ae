/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Progress of long work, in the last line of a terminal.
 */
#ifndef TOOLS_COMMON_PROGRESS_H
#define TOOLS_COMMON_PROGRESS_H

#include <stdint.h>

/** Shows "what: done of count unit" where standard error is a terminal, at most twice a second;
 *  count 0: "what ..." alone, at once; what NULL: clears the line, which is due before any other
 *  output and at the end. Main thread only. */
void progress_show(const char *what, uint64_t done, uint64_t count, const char *unit);

/** 1 if standard error is a terminal. */
int progress_wanted(void);

#endif
