/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The growing list of messages that loading and compiling a robot leaves behind.
 */
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/report.h>

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

/* Code and text share one block that starts with the code, so that one free() releases both. */
static char *message_block(const char *code, const char *format, va_list arguments, char **text)
{
    va_list again;
    va_copy(again, arguments);
    int length = tfa_report_print(NULL, 0, format, again);
    va_end(again);
    if (length < 0)
        return NULL;
    size_t code_size = strlen(code) + 1;
    size_t text_size = (size_t)length + 1;
    char *block = malloc(code_size + text_size);
    if (!block)
        return NULL;
    memcpy(block, code, code_size);
    *text = block + code_size;
    tfa_report_print(*text, text_size, format, arguments);
    return block;
}

void tfa_report_add(tfa_report *report, tfa_severity severity, uint32_t line, const char *code,
                    const char *format, ...)
{
    if (!report)
        return;
    report->errors += severity == TFA_ERROR;
    report->warnings += severity == TFA_WARNING;
    if (report_grow(report) != 0)
        return;
    char *text = NULL;
    va_list arguments;
    va_start(arguments, format);
    char *block = message_block(code ? code : "", format, arguments, &text);
    va_end(arguments);
    if (!block)
        return;
    report->messages[report->count++] = (tfa_message){
        .severity = severity, .line = line, .count = 1, .code = block, .text = text, .entity = ""};
}

void tfa_report_set_file(tfa_report *report, const char *file)
{
    if (!report)
        return;
    char *copy = file ? strdup(file) : NULL;
    free(report->file);
    report->file = copy;
}

static const char *severity_text(tfa_severity severity)
{
    static const char *const texts[] = {"note", "warning", "error"};
    return (unsigned)severity < 3 ? texts[severity] : "message";
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
    int length = snprintf(buffer, size, "%s%s%s%s: %s [%s]", before, colon, where,
                          severity_text(message->severity), message->text, message->code);
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
