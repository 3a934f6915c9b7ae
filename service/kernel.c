/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kernels of robots' own: found, built, and said in the log. Nothing here runs in a worker.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "robot.h"

#define BUILD_SECONDS 120
#define BUILD_MEMORY_MIB 2048
#define BUILD_FILE_MIB 32

static void log_kernel(const tfa_robot *robot)
{
    const tfa_specialised_info info = tfa_specialised_describe(robot->own);
    const char *file = strrchr(info.path, '/');
    tfa_log(TFA_LOG_INFO,
            "robot '%s': kernel of its own, %s, %u states at a time, within %.2g, '%.40s..'",
            robot->name, info.isa, info.lanes ? info.lanes : 1, info.error,
            file ? file + 1 : info.path);
}

/* The log cuts long lines: the reason, which holds a path, has one of its own. */
static void log_generic(const tfa_robot *robot, int status, const char *reason)
{
    tfa_log(TFA_LOG_WARNING, "robot '%s': the generic kernel answers (%s):", robot->name,
            tfa_status_text(status));
    tfa_log(TFA_LOG_WARNING, "%s", reason[0] ? reason : tfa_status_cause(status));
}

static char *directory_of(const config *settings)
{
    return config_file_path(settings, settings->specialise_directory);
}

/* Not there is not wrong. */
static int find(const config *settings, tfa_robot *robot, char *reason, size_t size)
{
    char *directory = directory_of(settings);
    const int status =
        directory ? tfa_specialised_find(directory, robot->model, &robot->own, reason, size)
                  : TFA_E_MEMORY;
    free(directory);
    return status;
}

/* Another precision, or a residual in another, has no use for it. */
static bool is_double(const config_robot *c)
{
    return c->precision == CONFIG_PRECISION_F64 &&
           (c->residual == TFA_RESIDUAL_SAME || c->residual == TFA_RESIDUAL_F64);
}

void tfa_robot_find_kernel(const config *settings, tfa_robot *robot)
{
    char reason[512];
    if (settings->specialise == CONFIG_SPECIALISE_OFF || !is_double(robot->config))
        return;
    int status = tfa_specialised_check(robot->model, reason, sizeof reason);
    robot->tried = status != TFA_OK;
    if (status == TFA_OK)
        status = find(settings, robot, reason, sizeof reason);
    if (status == TFA_OK)
        log_kernel(robot);
    else if (status == TFA_E_FILE)
        tfa_log(TFA_LOG_INFO, "robot '%s': no kernel of its own yet, the generic one answers",
                robot->name);
    else
        log_generic(robot, status, reason);
}

bool tfa_robot_wants_kernel(const config *settings, const tfa_robot *robot)
{
    return settings->specialise == CONFIG_SPECIALISE_BUILD && !robot->own && !robot->tried &&
           is_double(robot->config);
}

static int build(const tfa_robot *robot, const char *directory, int (*go_on)(void *context),
                 void *context, char *reason, size_t size)
{
    const tfa_specialise_options options = {.seconds = BUILD_SECONDS,
                                            .memory_mib = BUILD_MEMORY_MIB,
                                            .file_mib = BUILD_FILE_MIB,
                                            .one_by_one = 1,
                                            .go_on = go_on,
                                            .context = context};
    tfa_specialise_result result;
    char name[TFA_SPECIALISED_NAME_SIZE], *path = NULL;
    /* what nobody may load from there is not worth the compiler */
    int status = tfa_specialised_trust(directory, reason, size);
    tfa_specialised_name(robot->model, 0, name);
    if (status == TFA_OK && asprintf(&path, "%s/%s", directory, name) < 0)
        status = TFA_E_MEMORY;
    if (status == TFA_OK)
        status = tfa_specialised_build(robot->model, &options, path, &result, reason, size);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO, "robot '%s': kernel built in %.1f s by %s", robot->name,
                result.compile_s, result.compiler);
    free(path);
    return status;
}

void tfa_robot_build_kernel(const config *settings, tfa_robot *robot, int (*go_on)(void *context),
                            void *context)
{
    char reason[1024] = "", *directory = directory_of(settings);
    int status =
        directory ? build(robot, directory, go_on, context, reason, sizeof reason) : TFA_E_MEMORY;
    free(directory);
    robot->tried = true;
    if (status == TFA_OK)
        status = find(settings, robot, reason, sizeof reason);
    if (status == TFA_OK)
        log_kernel(robot);
    else
        log_generic(robot, status, reason);
}

bool tfa_robot_same_kernel(const tfa_robot *a, const tfa_robot *b)
{
    if (!a->own || !b->own)
        return !a->own && !b->own;
    return memcmp(tfa_specialised_describe(a->own).digest, tfa_specialised_describe(b->own).digest,
                  32) == 0;
}
