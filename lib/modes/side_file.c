/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Nodes, numbers and messages of side files.
 */
#include "modes/side_file.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/description.h>
#include <totalforce/text.h>

#include "model/report/report_messages.h"

enum { DEPTH_MAX = 8, ERRORS_LISTED = 100 };

void tfa_side_fault(tfa_side_file *r, const yaml_mark_t *mark, const char *path, const char *format,
                    ...)
{
    char text[600];
    va_list arguments;
    if (++r->errors > ERRORS_LISTED)
        return;
    va_start(arguments, format);
    if (tfa_report_print(text, sizeof text, format, arguments) < 0)
        *text = '\0';
    va_end(arguments);
    for (char *at = text; *at; at++) /* of values and names; a message is one line */
        if ((unsigned char)*at < ' ' || *at == 0x7f)
            *at = '?';
    tfa_report_add(r->report, TFA_ERROR, (uint32_t)mark->line + 1, r->code, "column %zu: %s%s%s",
                   mark->column + 1, path, *path ? ": " : "", text);
}

/* ---- nodes ---- */

const char *tfa_side_text(const yaml_node_t *node)
{
    if (node->type != YAML_SCALAR_NODE ||
        strlen((const char *)node->data.scalar.value) != node->data.scalar.length)
        return NULL;
    return (const char *)node->data.scalar.value;
}

bool tfa_side_is_mapping(tfa_side_file *r, const yaml_node_t *node, const char *path,
                         const char *form)
{
    if (node->type == YAML_MAPPING_NODE)
        return true;
    FAULT(r, node, path, "keys are expected here: %s", form);
    return false;
}

void tfa_side_keys(tfa_side_file *r, const yaml_node_t *node, const char *path,
                   const char *const *names, size_t count, const char *form,
                   const yaml_node_t **values)
{
    if (!tfa_side_is_mapping(r, node, path, form))
        return;
    for (size_t i = 0; i < pairs_of(node); i++) {
        const char *key = key_of(r, node, i);
        const yaml_node_t *value = value_of(r, node, i);
        size_t k = 0;
        while (key && k < count && strcmp(names[k], key) != 0)
            k++;
        if (!key || k == count)
            FAULT(r, key_at(r, node, i), path, "there is no key '%.80s'; write %s", key ? key : "?",
                  form);
        else if (values[k])
            FAULT(r, key_at(r, node, i), path, "%s: it is there twice, first in line %zu", key,
                  values[k]->start_mark.line + 1);
        else
            values[k] = value;
    }
}

double tfa_side_number(tfa_side_file *r, const yaml_node_t *node, const char *path)
{
    const char *text =
        node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : NULL;
    double value = 0;
    if (!text || tfa_number_read(text, node->data.scalar.length, &value) != TFA_NUMBER_OK)
        FAULT(r, node, path, "'%.80s' is not a finite number; write it like 2.5 or -1e-3",
              text                               ? text
              : node->type == YAML_SEQUENCE_NODE ? "[..]"
                                                 : "{..}");
    return value;
}

void tfa_side_numbers(tfa_side_file *r, const yaml_node_t *node, const char *path, size_t count,
                      const char *what, double *numbers)
{
    const size_t given = node->type == YAML_SEQUENCE_NODE ? items_of(node) : 0;
    if (given != count)
        FAULT(r, node, path, "%zu numbers where %zu are expected: %s", given, count, what);
    else
        for (size_t k = 0; k < count; k++)
            numbers[k] = tfa_side_number(r, item(r, node, k), path);
}

/* ---- files ---- */

static int parse(const tfa_side_form *form, const char *text, size_t length, void *out,
                 tfa_report *report)
{
    tfa_side_file r = {.report = report, .code = form->code};
    tfa_yaml_fault fault;
    if (length > form->bytes_max)
        return TFA_REFUSE(report, TFA_E_FILE, 0, "too-large",
                          "file: more than %zu MiB; it is no file of %s", form->bytes_max >> 20,
                          form->what);
    FILE *stream = fmemopen((void *)(uintptr_t)(length ? text : "\n"), length ? length : 1, "r");
    if (!stream)
        return TFA_E_MEMORY;
    int status = tfa_yaml_read(stream, DEPTH_MAX, false, &r.document, &fault);
    fclose(stream);
    if (status == TFA_E_PARSE)
        tfa_side_fault(&r, &fault.mark, "", "%s", fault.text);
    if (status != TFA_OK)
        return status;
    status = form->read(&r, out);
    yaml_document_delete(&r.document);
    return status == TFA_OK && r.errors ? TFA_E_PARSE : status;
}

/* The report's file is that of the side file if that is refused. */
static int finish(int status, tfa_report *report, char *file_before)
{
    const int error = errno;
    if (status != TFA_OK) {
        free(file_before);
    } else {
        free(report->file);
        report->file = file_before;
    }
    errno = error;
    return status;
}

int tfa_side_parse(const tfa_side_form *form, const char *text, size_t length, const char *name,
                   void *out, tfa_report *report)
{
    if (!out || !report || (!text && length > 0))
        return TFA_E_ARGUMENT;
    char *file_before = report->file;
    report->file = NULL;
    tfa_report_set_file(report, name);
    return finish(parse(form, text, length, out, report), report, file_before);
}

int tfa_side_load(const tfa_side_form *form, const char *path, void *out, tfa_report *report)
{
    char *text, *file_before;
    size_t length;
    if (!path || !out || !report)
        return TFA_E_ARGUMENT;
    file_before = report->file;
    report->file = NULL;
    int status = tfa_urdf_read(path, &text, &length, report);
    if (status == TFA_OK) {
        status = parse(form, text, length, out, report);
        free(text);
    }
    return finish(status, report, file_before);
}
