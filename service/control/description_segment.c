/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot's settings and URDF in a segment, for recorders and for the command `describe`. All who
 * ask get the same segment: what they keep open takes no more memory of the daemon.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "control/daemon.h"
#include "ipc/recording.h"

/* Text and name of the URDF that the robot was compiled of; free both. NULL: errno says why. */
static char *read_urdf(const tfa_daemon *d, const tfa_robot *robot, char **name, size_t *length)
{
    const size_t index = (size_t)(robot->config - d->settings->robots);
    char *text = d->descriptions.loaded ? d->descriptions.loaded[index] : NULL;
    size_t capacity = 0;
    if (text) {
        *name = strdup("robot_description");
        *length = strlen(text);
        return strdup(text);
    }
    *name = config_file_path(d->settings, robot->config->urdf);
    FILE *in = *name ? fopen(*name, "re") : NULL;
    if (!in)
        return NULL;
    errno = 0;
    const ssize_t n = getdelim(&text, &capacity, EOF, in);
    *length = n > 0 ? (size_t)n : 0;
    if (ferror(in) || n <= 0 || *length > TFA_RECORDING_URDF_MAX) {
        errno = errno ? errno : EFBIG;
        free(text);
        text = NULL;
    }
    fclose(in);
    return text;
}

/* Head, settings and URDF in one block; free it. NULL: no memory */
static char *describe(const tfa_robot *robot, const char *name, const char *urdf, size_t length,
                      size_t *size)
{
    char *settings = NULL, *block = NULL;
    size_t bytes = 0;
    FILE *out = open_memstream(&settings, &bytes);
    if (!out)
        return NULL;
    tfa_robot_describe(robot, name, out);
    if (fclose(out) == 0) {
        const tfa_recording_description head = {bytes, length};
        const size_t padded = tfa_recording_padded(bytes);
        *size = sizeof head + padded + tfa_recording_padded(length);
        block = calloc(1, *size);
        if (block) {
            memcpy(block, &head, sizeof head);
            memcpy(block + sizeof head, settings, bytes);
            memcpy(block + sizeof head + padded, urdf, length);
        }
    }
    free(settings);
    return block;
}

const tfa_segment *description_segment(tfa_daemon *d, uint32_t i, char *text, size_t size)
{
    tfa_robot *robot = &d->robot_set.robots[i];
    char *name = NULL;
    size_t length = 0, bytes = 0;
    if (robot->description.fd_readonly >= 0)
        return &robot->description;
    char *urdf = read_urdf(d, robot, &name, &length);
    if (!urdf) {
        snprintf(text, size, "error: '%s': %s", name ? name : robot->config->urdf, strerror(errno));
        free(name);
        return NULL;
    }
    char *block = describe(robot, name, urdf, length, &bytes);
    const int status =
        block ? tfa_segment_create_constant(block, bytes, &robot->description) : TFA_E_MEMORY;
    if (status != TFA_OK)
        snprintf(text, size, "error: a description of %zu bytes: %s", bytes,
                 tfa_status_text(status));
    free(block);
    free(urdf);
    free(name);
    return status == TFA_OK ? &robot->description : NULL;
}
