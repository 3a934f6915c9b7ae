/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads a URDF file and runs the passes of urdf.h.
 */
#include "model/report/report_messages.h"
#include "urdf/urdf.h"

#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Reads `file`, at most one byte more than allowed. The buffer has room for a NUL. */
static int read_all(int file, char **text, size_t *length)
{
    size_t capacity = 1 << 16;
    *length = 0;
    *text = malloc(capacity);
    while (*text && *length <= TFA_URDF_MAX_BYTES) {
        ssize_t got = read(file, *text + *length, capacity - *length);
        if (got == 0)
            return TFA_OK;
        if (got < 0 && errno != EINTR)
            return TFA_E_FILE;
        *length += got > 0 ? (size_t)got : 0;
        if (*length < capacity)
            continue;
        capacity *= 2;
        char *more = realloc(*text, capacity);
        if (!more)
            return TFA_E_MEMORY;
        *text = more;
    }
    return *text ? TFA_OK : TFA_E_MEMORY; /* the caller checks the length */
}

int tfa_urdf_read_path(const char *path, char **text, size_t *length)
{
    *text = NULL;
    /* A pipe that nobody writes is empty, and not waited for; one that has a writer is read. */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file >= 0)
        (void)fcntl(file, F_SETFL, fcntl(file, F_GETFL) & ~O_NONBLOCK);
    int status = file < 0 ? TFA_E_FILE : read_all(file, text, length);
    const int error = errno;
    if (file >= 0)
        close(file);
    if (status == TFA_OK) {
        (*text)[*length] = '\0';
        return TFA_OK;
    }
    free(*text);
    *text = NULL;
    errno = error;
    return status;
}

static int run_passes(const char *text, size_t length, char *clean, tfa_urdf_log *log,
                      tfa_description **skeleton, char **canonical)
{
    int status = tfa_urdf_check_xml(text, length, clean, log);
    if (status == TFA_OK)
        status = tfa_urdf_lint(clean, log, skeleton, canonical);
    if (status == TFA_OK)
        status = tfa_urdf_graph(*skeleton, log);
    if (status == TFA_OK && log->errors > 0)
        status = TFA_E_PARSE;
    if (status == TFA_OK)
        status = tfa_urdf_fill(*canonical, *skeleton, log);
    if (status == TFA_OK) {
        tfa_urdf_inertia(*skeleton, log);
        tfa_urdf_notes(*skeleton, log);
    }
    return status;
}

/* run_passes with a decimal point in this thread's input and messages. */
static int run_in_classic_locale(const char *text, size_t length, char *clean, tfa_urdf_log *log,
                                 tfa_description **skeleton, char **canonical)
{
    locale_t classic = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* static in glibc: no malloc */
    if (classic == (locale_t)0)
        return TFA_E_MEMORY;
    locale_t previous = uselocale(classic);
    int status = run_passes(text, length, clean, log, skeleton, canonical);
    uselocale(previous);
    freelocale(classic);
    return status;
}

int tfa_urdf_parse(const char *text, size_t length, const char *name, tfa_description **description,
                   tfa_report *report)
{
    if (!description || !report || (!text && length > 0))
        return TFA_E_ARGUMENT;
    *description = NULL;
    tfa_urdf_log log = {.report = report};
    tfa_report_set_file(report, name);
    tfa_report_begin(report);
    if (length > TFA_URDF_MAX_BYTES) {
        tfa_urdf_report(&log, TFA_ERROR, 0, "too-large",
                        "file: more than %d MiB; is it a URDF file?", TFA_URDF_MAX_BYTES >> 20);
        tfa_report_add_refused(report, NULL);
        return TFA_E_FILE;
    }
    tfa_description *skeleton = NULL;
    char *canonical = NULL;
    char *clean = malloc(length + 1);
    int status = TFA_E_MEMORY;
    if (clean)
        status = run_in_classic_locale(text, length, clean, &log, &skeleton, &canonical);
    tfa_urdf_report_repeats(&log);
    if (status != TFA_OK)
        tfa_report_add_refused(report, NULL);
    free(clean);
    free(canonical);
    if (status == TFA_OK)
        *description = skeleton;
    else
        tfa_description_free(skeleton);
    return status;
}

static int unreadable(tfa_report *report, const char *name, int error, const char *why)
{
    tfa_report_set_file(report, name);
    tfa_report_begin(report);
    tfa_report_add(report, TFA_ERROR, 0, "unreadable", "file: cannot be read: %s", why);
    tfa_report_add_refused(report, NULL);
    errno = error;
    return TFA_E_FILE;
}

int tfa_urdf_read(const char *name, char **text, size_t *length, tfa_report *report)
{
    char path[TFA_URDF_PATH_MAX], message[128];
    if (!name || !text || !length || !report)
        return TFA_E_ARGUMENT;
    *text = NULL;
    *length = 0;
    if (tfa_urdf_find(name, path, sizeof path) != TFA_OK)
        return unreadable(report, name, errno, path);
    const int status = tfa_urdf_read_path(path, text, length);
    if (status == TFA_OK) {
        tfa_report_set_file(report, path);
        return tfa_mjcf_include(path, text, length, report);
    }
    const int error = errno;
    (void)unreadable(report, path, error,
                     status == TFA_E_MEMORY ? "out of memory"
                                            : strerror_r(error, message, sizeof message));
    return status;
}

int tfa_urdf_load(const char *path, tfa_description **description, tfa_report *report)
{
    if (!path || !description || !report)
        return TFA_E_ARGUMENT;
    *description = NULL;
    char *text;
    size_t length;
    int status = tfa_urdf_read(path, &text, &length, report);
    if (status != TFA_OK)
        return status;
    char *file = report->file ? strdup(report->file) : NULL;
    status = tfa_urdf_parse(text, length, file, description, report);
    free(file);
    free(text);
    return status;
}

void tfa_description_free(tfa_description *description)
{
    free(description); /* one block */
}
