/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages of loading and compiling: grouped messages, notes about unused items, the last line of a
 * refused file, options in the syntax of the interface in use.
 */
#ifndef TFA_MODEL_REPORT_REPORT_MESSAGES_H
#define TFA_MODEL_REPORT_REPORT_MESSAGES_H

#include <stdarg.h>
#include <totalforce/report.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Formats as vsnprintf, with a decimal point in every locale. @return the length or -1 */
int tfa_report_print(char *text, size_t size, const char *format, va_list arguments);

/* Appends a message. Code, entity and text share a block that starts with the code. Returns NULL
 * without memory; the counters still count. */
tfa_message *tfa_report_append(tfa_report *report, tfa_severity severity, uint32_t line,
                               const char *code, const char *entity, const char *text);

/* Adds an error; the value is `status`. Arguments as tfa_report_add. */
#define TFA_REFUSE(report, status, line, code, ...)                                                \
    (tfa_report_add(report, TFA_ERROR, line, code, __VA_ARGS__), (status))

/* Starts a load or a compilation: later messages are not grouped with earlier ones. */
void tfa_report_begin(tfa_report *report);

/* As tfa_report_add, for messages that occur often. Keeps the first of this severity and code since
 * tfa_report_begin; later ones increase its count and the list of names at its end. noun: "links"
 * or "joints". O(messages). */
void tfa_report_add_grouped(tfa_report *report, tfa_severity severity, uint32_t line,
                            const char *code, const char *noun, const char *name,
                            const char *format, ...) __attribute__((format(printf, 7, 8)));

/* Notes that `item` is not used; the file has it `count` times. `more`: end of the sentence with
 * its separator, or "". */
void tfa_report_add_unused(tfa_report *report, uint32_t line, const char *code, const char *item,
                           size_t count, const char *more);

/* Adds the last line of a refused file, code "refused": number of errors and kinds since
 * tfa_report_begin, and the option with which it compiles, if any. Not counted as an error; nothing
 * without an error. */
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
    TFA_OPTION_FRICTION,
    TFA_OPTION_ROTOR_INERTIA,
    TFA_OPTIONS
} tfa_option;

/* Spelling of an option in report->syntax; NULL report: as in C. */
const char *tfa_option_text(const tfa_report *report, tfa_option choice);

#ifdef __cplusplus
}
#endif
#endif
