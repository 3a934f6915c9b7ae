/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The parts of the test; each prints a table. @return number of failures
 */
#ifndef TFA_EXPLORER_PARTS_H
#define TFA_EXPLORER_PARTS_H

#include "explorer.h"

int litmus_run(void);
int scenarios_run(void);
int mutations_run(void);

/** Explores until a scenario has a finding, number *hint first. @return its name, *finding and its
 *  number in *hint; NULL: none has a finding */
const char *scenarios_find(const char **finding, int *hint);

#endif
