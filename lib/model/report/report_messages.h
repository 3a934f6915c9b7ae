/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages that loading and compiling share: one for many links alike, notes about what is not
 * used, the last line of a refused file, and options in the syntax of the interface in use.
 */
#ifndef TFA_MODEL_REPORT_REPORT_MESSAGES_H
#define TFA_MODEL_REPORT_REPORT_MESSAGES_H

#include <stdarg.h>
#include <totalforce/report.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Formats as vsnprintf, with a point in numbers in every locale. @return the length or -1 */
int tfa_report_print(char *text, size_t size, const char *format, va_list arguments);

/* Adds an error; the value is `status`. Arguments as tfa_report_add. */
#define TFA_REFUSE(report, status, line, code, ...)                                                \
    (tfa_report_add(report, TFA_ERROR, line, code, __VA_ARGS__), (status))

/* Starts a load or a compilation: later messages are not grouped with earlier ones. */
void tfa_report_begin(tfa_report *report);

/*
 * As tfa_report_add, for messages that may be many of one kind. The first of this severity and code
 * since tfa_report_begin is kept; the others add to its count and to the list of names at its end.
 * noun: "links" or "joints". O(messages).
 */
void tfa_report_add_grouped(tfa_report *report, tfa_severity severity, uint32_t line,
                            const char *code, const char *noun, const char *name,
                            const char *format, ...) __attribute__((format(printf, 7, 8)));

/* Notes that `item`, which the file has `count` times, is not used; `more`: the end of the
 * sentence, with its separator, or "". */
void tfa_report_add_unused(tfa_report *report, uint32_t line, const char *code, const char *item,
                           size_t count, const char *more);

/*
 * The last line of a refused file, code "refused": how many errors of how many kinds since
 * tfa_report_begin, and the option with which it loads, if there is one. Not counted as an error
 * itself; nothing is said without an error.
 */
void tfa_report_add_refused(tfa_report *report, const char *option);

/* Options of a model that messages name. */
typedef enum tfa_option {
    TFA_OPTION_BASE_FIXED,
    TFA_OPTION_BASE_FLOATING,
    TFA_OPTION_MIMIC_PROJECT,
    TFA_OPTION_MIMIC_LOCK,
    TFA_OPTION_INERTIA_STRICT,
    TFA_OPTION_INERTIA_REPAIR,
    TFA_OPTION_LOCK_LEAVES,
    TFA_OPTION_DAMPING,
    TFA_OPTION_ROTOR_INERTIA,
    TFA_OPTIONS
} tfa_option;

/* As the user of report->syntax writes it; NULL report: as in C. */
const char *tfa_option_text(const tfa_report *report, tfa_option choice);

#ifdef __cplusplus
}
#endif
#endif
