/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages of the URDF front end, with a bound for each code.
 */
#include "urdf/urdf.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Number of earlier messages with this code. */
static size_t times_reported(tfa_urdf_log *log, tfa_severity severity, const char *code)
{
    for (size_t i = 0; i < log->code_count; i++)
        if (strcmp(log->codes[i].code, code) == 0 && log->codes[i].severity == severity)
            return log->codes[i].count++;
    if (log->code_count < TFA_URDF_MAX_CODES) {
        log->codes[log->code_count].code = code;
        log->codes[log->code_count].severity = severity;
        log->codes[log->code_count].count = 1;
        log->code_count++;
    }
    return 0;
}

uint32_t tfa_urdf_place(const tfa_urdf_log *log, uint32_t row, char *prefix, size_t size)
{
    uint32_t start = 0, shift = 0, passed = 0, line = 0; /* rows before the file that holds it */
    const char *file = NULL;
    for (size_t k = 0; k < log->span_count && log->spans[k].row < row; k++) {
        const tfa_urdf_span *s = &log->spans[k];
        if (s->row < passed)
            continue; /* inside a span that ended */
        if (row > s->row + s->rows) {
            shift += s->rows;
            passed = s->row + s->rows;
            continue;
        }
        line = file ? line : s->row - start - shift;
        file = s->file;
        start = s->row - 1;
        shift = 0;
    }
    prefix[0] = '\0';
    if (!file)
        return row - start - shift;
    snprintf(prefix, size, "%.255s:%u: ", file, row - start - shift);
    return line;
}

void tfa_urdf_report(tfa_urdf_log *log, tfa_severity severity, uint32_t line, const char *code,
                     const char *format, ...)
{
    log->errors += severity == TFA_ERROR;
    if (times_reported(log, severity, code) >= TFA_URDF_MAX_REPEATS)
        return;
    char text[2048]; /* three names of 255 bytes and a sentence fit */
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    char prefix[300];
    line = tfa_urdf_place(log, line, prefix, sizeof prefix);
    tfa_report_add(log->report, severity, line, code, "%s%s", prefix, text);
}

/* One message that counts as many. */
static void report_repeats(tfa_report *report, tfa_severity severity, const char *code, size_t rest)
{
    const size_t before = report->count;
    tfa_report_add(report, severity, 0, code,
                   "robot: %zu more messages of this kind are not listed", rest);
    report->errors += severity == TFA_ERROR ? rest - 1 : 0;
    report->warnings += severity == TFA_WARNING ? rest - 1 : 0;
    if (report->count > before)
        report->messages[before].count = (uint32_t)rest;
}

void tfa_urdf_report_repeats(tfa_urdf_log *log)
{
    for (size_t i = 0; i < log->code_count; i++)
        if (log->codes[i].count > TFA_URDF_MAX_REPEATS)
            report_repeats(log->report, log->codes[i].severity, log->codes[i].code,
                           log->codes[i].count - TFA_URDF_MAX_REPEATS);
}
