/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reports: the errors, warnings and notes of loading and compiling a robot.
 *
 * Thread rule: one thread at a time uses a report.
 */
#ifndef TOTALFORCE_REPORT_H
#define TOTALFORCE_REPORT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Errors refuse a robot; warnings and notes do not. */
typedef enum tfa_severity { TFA_NOTE = 0, TFA_WARNING = 1, TFA_ERROR = 2 } tfa_severity;
/** Their words: X(value, word) */
#define TFA_SEVERITY_WORDS(X)                                                                      \
    X(TFA_NOTE, "note")                                                                            \
    X(TFA_WARNING, "warning")                                                                      \
    X(TFA_ERROR, "error")

/** One message. The report owns the strings. */
typedef struct tfa_message {
    tfa_severity severity; /**< an error refuses the file */
    uint32_t line;         /**< line in the file, from 1, of the first of `count`; 0: none */
    uint32_t count;        /**< number of links, joints or elements that the message is about */
    const char *code;      /**< stable code, for instance "bad-number" */
    const char *text;   /**< "link 'NAME': problem; remedy; links like it: 9 ('NAME', 'B', ...)" */
    const char *entity; /**< first link or joint of a grouped message; item of a note about unused
                              items ("damping", "<gazebo>"); else "" */
    uint32_t prefix_length; /**< bytes of text before the list of names; 0: no list */
} tfa_message;

/** Syntax in which messages spell options and keys: that of the interface in use. */
typedef enum tfa_option_syntax {
    TFA_SYNTAX_C = 0,        /**< mimic = project, as in tfa_model_options */
    TFA_SYNTAX_COMMAND_LINE, /**< --mimic=project */
    TFA_SYNTAX_YAML,         /**< mimic: project */
    TFA_SYNTAX_JSON,         /**< "mimic":"project" */
    TFA_SYNTAX_PYTHON,       /**< mimic='project' */
} tfa_option_syntax;

/** A growing list of messages. Zero-initialise before first use; release with tfa_report_free. */
typedef struct tfa_report {
    char *file;               /**< file that the messages are about; NULL: none */
    tfa_message *messages;    /**< in order of occurrence */
    size_t count;             /**< messages */
    size_t capacity;          /**< messages that fit the allocated memory */
    size_t errors;            /**< occurrences: a message about nine links counts nine times */
    size_t warnings;          /**< the same */
    size_t first;             /**< first message of the latest load or compilation */
    tfa_option_syntax syntax; /**< set by the caller before loading */
} tfa_report;

/**
 * Appends a message formatted as by printf, with a decimal point in every locale. Allocates; if
 * that fails the message is lost and the counters still count. Cost: O(1) amortised.
 *
 * @param report    NULL: nothing happens
 * @param severity  of the message
 * @param line      line in the file; 0: none
 * @param code      stable code of the message
 * @param format    as printf
 */
TFA_API void tfa_report_add(tfa_report *report, tfa_severity severity, uint32_t line,
                            const char *code, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/** Sets the file name of tfa_report_format; copied; NULL: none. */
TFA_API void tfa_report_set_file(tfa_report *report, const char *file);

/**
 * Writes message `index` as "FILE:LINE: severity: text [code]".
 *
 * @param report  filled before
 * @param index   message, from 0
 * @param buffer  always terminated if size > 0
 * @param size    of buffer, bytes
 * @return length of the whole message, as snprintf; 0 if there is no such message
 */
TFA_API size_t tfa_report_format(const tfa_report *report, size_t index, char *buffer, size_t size);

/** Releases the memory of the report and sets it to zero, ready for use. NULL is allowed. */
TFA_API void tfa_report_free(tfa_report *report);

#ifdef __cplusplus
}
#endif
#endif
