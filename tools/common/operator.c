/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared by the commands for operators.
 */
#include "operator.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/status.h>

enum { KEY_RUNTIME_DIR = 1024 };

static const struct argp_option option_table[] = {
    {.name = "runtime-dir",
     .key = KEY_RUNTIME_DIR,
     .arg = "DIR",
     .doc = "Where the daemon's sockets are ($TOTALFORCE_RUNTIME_DIR, else /run/totalforce)"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    const char **runtime_dir = state->input;
    if (key != KEY_RUNTIME_DIR)
        return ARGP_ERR_UNKNOWN;
    *runtime_dir = text;
    return 0;
}

const struct argp operator_argp = {.options = option_table, .parser = parse_option};

void operator_explain(const char *command, int status)
{
    if (status == TFA_E_DISCONNECTED)
        fprintf(stderr,
                "totalforce %s: no daemon answers there: start one (totalforced FILE.yaml), or "
                "name its runtime_dir with --runtime-dir\n",
                command);
    else if (status == TFA_E_TIMEOUT)
        fprintf(stderr,
                "totalforce %s: the daemon there does not answer in time: it was stopped, or other "
                "programs take its processor\n",
                command);
    else
        fprintf(stderr, "totalforce %s: %s: %s\n", command, tfa_status_text(status),
                status == TFA_E_SYSTEM ? strerror(errno) : tfa_status_cause(status));
}
