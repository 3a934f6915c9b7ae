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

static int parse_text(const char *name, const char *text, size_t length,
                      const tfa_model_options *options, tfa_report *report, tfa_model **model)
{
    tfa_description *description = NULL;
    report->syntax = TFA_SYNTAX_COMMAND_LINE;
    int status = tfa_urdf_parse(text, length, name, &description, report);
    if (status == TFA_OK)
        status = tfa_model_create(description, options, report, model);
    tfa_description_free(description);
    return status;
}

static int load_standard_input(const tfa_model_options *options, tfa_report *report,
                               tfa_model **model)
{
    size_t length;
    char *text = read_text(stdin, &length);
    if (!text)
        return TFA_E_FILE;
    const int status = parse_text("(standard input)", text, length, options, report, model);
    free(text);
    return status;
}

tfa_model *load_model(const char *path, const tfa_model_options *options, tfa_severity lowest,
                      tfa_report *report)
{
    tfa_model *model = NULL;
    errno = 0;
    report->syntax = TFA_SYNTAX_COMMAND_LINE;
    int status = strcmp(path, "-") == 0 ? load_standard_input(options, report, &model)
                                        : tfa_model_load(path, options, report, &model);
    int saved = errno;
    print_messages(report, lowest);
    if (status == TFA_OK)
        return model;
    if (status == TFA_E_FILE && saved && report->errors == 0)
        fprintf(stderr, "%s: error: %s\n", path, strerror(saved));
    else if (report->errors == 0)
        fprintf(stderr, "%s: error: %s: %s\n", path, tfa_status_text(status),
                tfa_status_cause(status));
    return NULL;
}
