/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loads models for the subcommands.
 */
#include "load_model.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/description.h>
#include <totalforce/text.h>

void print_messages(const tfa_report *report, tfa_severity lowest)
{
    for (size_t i = 0; i < report->count; i++) {
        if (report->messages[i].severity < lowest)
            continue;
        size_t size = tfa_report_format(report, i, NULL, 0) + 1;
        char *text = malloc(size);
        if (!text)
            continue;
        tfa_report_format(report, i, text, size);
        fprintf(stderr, "%s\n", text);
        free(text);
    }
}

static char *read_text(FILE *in, size_t *length)
{
    char *text = NULL;
    size_t size = 0;
    for (*length = 0;;) {
        if (*length == size) {
            size = size ? 2 * size : 65536;
            char *grown = realloc(text, size);
            if (!grown)
                break;
            text = grown;
        }
        const size_t got = fread(text + *length, 1, size - *length, in);
        *length += got;
        if (got == 0 && !ferror(in))
            return text;
        if (got == 0)
            break;
    }
    free(text);
    return NULL;
}

char *read_robot(const char *path, size_t *length)
{
    tfa_report report = {0};
    char *text = NULL;
    if (strcmp(path, "-") != 0) {
        (void)!tfa_urdf_read(path, &text, length, &report);
        print_messages(&report, TFA_ERROR);
        tfa_report_free(&report);
    } else if (!(text = read_text(stdin, length))) {
        fprintf(stderr, "%s: error: %s\n", path, strerror(errno));
    }
    return text;
}

static int describe(const char *path, tfa_description **description, tfa_report *report)
{
    size_t length;
    if (strcmp(path, "-") != 0)
        return tfa_urdf_load(path, description, report);
    char *text = read_text(stdin, &length);
    const int status =
        text ? tfa_urdf_parse(text, length, "(standard input)", description, report) : TFA_E_FILE;
    free(text);
    return status;
}

static const char *joint_name(const void *description, size_t k)
{
    return ((const tfa_description *)description)->joints[k].name;
}

static int set_armature(tfa_description *d, const tfa_rotor *armature)
{
    char nearest[160];
    for (size_t k = 0; k < d->joint_count; k++)
        if (strcmp(d->joints[k].name, armature->joint) == 0) {
            d->joints[k].armature = armature->inertia;
            return TFA_OK;
        }
    tfa_suggest(armature->joint, d, d->joint_count, joint_name, nearest, sizeof nearest);
    fprintf(stderr, "--armature: the file has no joint '%s'; nearest: %s\n", armature->joint,
            nearest);
    return TFA_E_JOINT;
}

tfa_model *load_model(const char *path, const tfa_model_options *options, const tfa_rotor *armature,
                      uint32_t armature_count, tfa_severity lowest, tfa_report *report)
{
    tfa_model *model = NULL;
    tfa_description *description = NULL;
    errno = 0;
    report->syntax = TFA_SYNTAX_COMMAND_LINE;
    int status = describe(path, &description, report);
    for (uint32_t k = 0; status == TFA_OK && k < armature_count; k++)
        status = set_armature(description, &armature[k]);
    if (status == TFA_OK)
        status = tfa_model_create(description, options, report, &model);
    tfa_description_free(description);
    int saved = errno;
    print_messages(report, lowest);
    if (status == TFA_OK)
        return model;
    if (status == TFA_E_FILE && saved && report->errors == 0)
        fprintf(stderr, "%s: error: %s\n", path, strerror(saved));
    else if (report->errors == 0 && status != TFA_E_JOINT)
        fprintf(stderr, "%s: error: %s: %s\n", path, tfa_status_text(status),
                tfa_status_cause(status));
    return NULL;
}
