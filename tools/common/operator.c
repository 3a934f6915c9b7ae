/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared by the commands for operators.
 */
#include "operator.h"

#include "ipc/control_socket.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
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

void operator_explain(const char *command, const char *runtime_dir, int status)
{
    const char *cause = status == TFA_E_SYSTEM ? strerror(errno) : tfa_status_cause(status);
    char *found = tfa_find_runtime_dir(runtime_dir, TFA_CONTROL_NAME);
    const char *folder = found ? found : TFA_DEFAULT_RUNTIME_DIR;
    if (status == TFA_E_DISCONNECTED)
        fprintf(stderr,
                "totalforce %s: no daemon answers at %s: start one (totalforced FILE.yaml), or "
                "name its runtime_dir with --runtime-dir\n",
                command, folder);
    else if (status == TFA_E_TIMEOUT)
        fprintf(stderr,
                "totalforce %s: the daemon at %s does not answer in time: it was stopped, or other "
                "programs take its processor\n",
                command, folder);
    else
        fprintf(stderr, "totalforce %s: %s: %s: %s\n", command, folder, tfa_status_text(status),
                cause);
    free(found);
}
