/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared by the commands for operators of a daemon, which its control socket answers.
 */
#ifndef TOOLS_COMMON_OPERATOR_H
#define TOOLS_COMMON_OPERATOR_H

#include <argp.h>

/** --runtime-dir; its input is a const char *, NULL without the option. */
extern const struct argp operator_argp;

/** Prints why `totalforce COMMAND` got no answer, and the folder that it looked in (`runtime_dir`:
 *  of operator_argp): a tfa_status, and errno of TFA_E_SYSTEM. */
void operator_explain(const char *command, const char *runtime_dir, int status);

#endif
