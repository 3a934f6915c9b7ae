/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Specialised kernels: found, loaded, and named in the log. Nothing here runs in a worker.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/log.h"
#include "robot.h"

static void log_kernel(const tfa_robot *robot)
{
    const tfa_specialised_info info = tfa_specialised_describe(robot->specialised);
    const char *file = strrchr(info.path, '/');
    tfa_log(TFA_LOG_INFO,
            "robot '%s': specialised kernel, %s, %u states at a time, within %.2g, '%.40s..'",
            robot->name, info.isa, info.lanes ? info.lanes : 1, info.error,
            file ? file + 1 : info.path);
}

/* The log cuts long lines: the reason, which holds a path, has one of its own. */
static void log_generic(const tfa_robot *robot, int status, const char *error_text)
{
    tfa_log(TFA_LOG_WARNING, "robot '%s': the generic kernel answers (%s):", robot->name,
            tfa_status_text(status));
    tfa_log(TFA_LOG_WARNING, "%s", error_text[0] ? error_text : tfa_status_cause(status));
}

/* A missing file is no fault. */
static int find_kernel(const config *settings, tfa_robot *robot, char *error_text, size_t size)
{
    char *directory = config_file_path(settings, settings->specialise_directory);
    const int status = directory ? tfa_specialised_find(directory, robot->model,
                                                        &robot->specialised, error_text, size)
                                 : TFA_E_MEMORY;
    free(directory);
    return status;
}

/* Another precision, or a residual in another, has no use for it. */
static bool is_double_precision(const config_robot *c)
{
    return c->precision == CONFIG_PRECISION_F64 &&
           (c->residual == TFA_RESIDUAL_SAME || c->residual == TFA_RESIDUAL_F64);
}

void tfa_robot_find_kernel(const config *settings, tfa_robot *robot)
{
    char error_text[512];
    if (settings->specialise == CONFIG_SPECIALISE_OFF || !is_double_precision(robot->config))
        return;
    int status = tfa_specialised_check(robot->model, error_text, sizeof error_text);
    if (status == TFA_OK)
        status = find_kernel(settings, robot, error_text, sizeof error_text);
    if (status == TFA_OK)
        log_kernel(robot);
    else if (status == TFA_E_FILE)
        tfa_log(TFA_LOG_INFO, "robot '%s': no specialised kernel yet, the generic one answers",
                robot->name);
    else
        log_generic(robot, status, error_text);
}

bool tfa_robot_same_kernel(const tfa_robot *a, const tfa_robot *b)
{
    if (!a->specialised || !b->specialised)
        return !a->specialised && !b->specialised;
    return memcmp(tfa_specialised_describe(a->specialised).digest,
                  tfa_specialised_describe(b->specialised).digest, 32) == 0;
}
