/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reports: the growing list of messages of loading and compiling a robot.
 */
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

#include "model/report/report_messages.h"

static int report_grow(tfa_report *report)
{
    if (report->count < report->capacity)
        return 0;
    size_t capacity = report->capacity ? 2 * report->capacity : 16;
    tfa_message *messages = realloc(report->messages, capacity * sizeof *messages);
    if (!messages)
        return -1;
    report->messages = messages;
    report->capacity = capacity;
    return 0;
}

int tfa_report_print(char *text, size_t size, const char *format, va_list arguments)
{
    /* the C locale is static in glibc, so this cannot fail */
    const locale_t previous = uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
    const int length = vsnprintf(text, size, format, arguments);
    uselocale(previous);
    return length;
}

tfa_message *tfa_report_append(tfa_report *report, tfa_severity severity, uint32_t line,
                               const char *code, const char *entity, const char *text)
{
    const size_t c = strlen(code) + 1, e = strlen(entity) + 1, t = strlen(text) + 1;
    report->errors += severity == TFA_ERROR;
    report->warnings += severity == TFA_WARNING;
    char *block = report_grow(report) == 0 ? malloc(c + e + t) : NULL;
    if (!block)
        return NULL;
    memcpy(block, code, c);
    memcpy(block + c, entity, e);
    memcpy(block + c + e, text, t);
    tfa_message *m = &report->messages[report->count++];
    *m = (tfa_message){.severity = severity,
                       .line = line,
                       .count = 1,
                       .code = block,
                       .entity = block + c,
                       .text = block + c + e};
    return m;
}

void tfa_report_add(tfa_report *report, tfa_severity severity, uint32_t line, const char *code,
                    const char *format, ...)
{
    if (!report)
        return;
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int length = tfa_report_print(NULL, 0, format, again);
    char *text = length < 0 ? NULL : malloc((size_t)length + 1);
    if (text) {
        tfa_report_print(text, (size_t)length + 1, format, arguments);
        tfa_report_append(report, severity, line, code ? code : "", "", text);
    } else {
        report->errors += severity == TFA_ERROR;
        report->warnings += severity == TFA_WARNING;
    }
    va_end(again);
    va_end(arguments);
    free(text);
}

void tfa_report_set_file(tfa_report *report, const char *file)
{
    if (!report)
        return;
    char *copy = file ? strdup(file) : NULL;
    free(report->file);
    report->file = copy;
}

size_t tfa_report_format(const tfa_report *report, size_t index, char *buffer, size_t size)
{
    if (size > 0)
        buffer[0] = '\0';
    if (!report || index >= report->count)
        return 0;
    const tfa_message *message = &report->messages[index];
    char where[16] = "";
    if (message->line > 0)
        snprintf(where, sizeof where, "%u: ", message->line);
    const char *before = report->file ? report->file : message->line > 0 ? "line " : "";
    const char *colon = !report->file ? "" : message->line > 0 ? ":" : ": ";
    const uint32_t severity = message->severity;
    const char *word = severity > TFA_ERROR ? "message" : tfa_word(TFA_WORDS_SEVERITY, severity);
    int length = snprintf(buffer, size, "%s%s%s%s: %s [%s]", before, colon, where, word,
                          message->text, message->code);
    return length < 0 ? 0 : (size_t)length;
}

void tfa_report_free(tfa_report *report)
{
    if (!report)
        return;
    for (size_t i = 0; i < report->count; i++)
        free((void *)(uintptr_t)report->messages[i].code);
    free(report->messages);
    free(report->file);
    *report = (tfa_report){0};
}
