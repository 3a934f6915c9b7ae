/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A report collects what loading and compiling a robot has to say: errors, warnings, notes.
 */
#ifndef TOTALFORCE_REPORT_H
#define TOTALFORCE_REPORT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tfa_severity { TFA_NOTE = 0, TFA_WARNING = 1, TFA_ERROR = 2 } tfa_severity;

/** One message. Strings belong to the report and live as long as it. */
typedef struct tfa_message {
    tfa_severity severity;
    uint32_t line;      /**< line in the file, 1-based; 0 where there is none; the first one's */
    uint32_t count;     /**< links, joints or elements that it is about: 1, or all that are alike */
    const char *code;   /**< stable code, for instance "bad-number" */
    const char *text;   /**< "link 'NAME': what; what to do; links like it: 9 ('NAME', 'B', ...)" */
    const char *entity; /**< first link or joint of a message that may be about many; name of
                              what a note says is not used: "damping", "<gazebo>"; else "" */
    /** bytes of text before the list of those like it; 0: it is about one */
    uint32_t prefix_length;
} tfa_message;

/** How a message spells an option: as the user of that interface writes it. */
typedef enum tfa_option_syntax {
    TFA_SYNTAX_C = 0,        /**< mimic = project, as in tfa_model_options */
    TFA_SYNTAX_COMMAND_LINE, /**< --mimic=project */
    TFA_SYNTAX_YAML,         /**< mimic: project */
} tfa_option_syntax;

/** A growing list of messages. Zero-initialise before first use; release with tfa_report_free. */
typedef struct tfa_report {
    char *file; /**< the file the messages are about; NULL if none */
    tfa_message *messages;
    size_t count;
    size_t capacity;
    size_t errors;   /**< as often as they occurred: a message about nine links counts nine times */
    size_t warnings; /**< the same */
    size_t first;    /**< first message of the load or compilation that wrote last */
    tfa_option_syntax syntax; /**< set by the caller before loading */
} tfa_report;

/**
 * Appends a message formatted as by printf. Allocates; when that fails the counters still count.
 * Where: a single thread per report.
 */
TFA_API void tfa_report_add(tfa_report *report, tfa_severity severity, uint32_t line,
                            const char *code, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/** Sets the file name that messages are printed with (copied). */
TFA_API void tfa_report_set_file(tfa_report *report, const char *file);

/**
 * Writes message `index` as "FILE:LINE: severity: text [code]" into `buffer` (always terminated).
 * Returns the length that the whole message needs, as snprintf does.
 */
TFA_API size_t tfa_report_format(const tfa_report *report, size_t index, char *buffer, size_t size);

/** Releases everything the report owns and leaves it empty and usable again. */
TFA_API void tfa_report_free(tfa_report *report);

#ifdef __cplusplus
}
#endif
#endif
