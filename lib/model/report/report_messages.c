/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages of loading and compiling: grouping, notes about unused items, options in the syntax of
 * the interface in use.
 */
#include "model/report/report_messages.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_LISTED_MAX = 5, TEXT = 2048 }; /* three names of 255 bytes and a sentence fit */

/* By tfa_option_syntax */
#define WORD(name, value)                                                                          \
    {                                                                                              \
        name " = " value, "--" name "=" value, name ": " value, "\"" name "\":\"" value "\"",      \
            name "='" value "'"                                                                    \
    }
#define SWITCH(name, dashed)                                                                       \
    {                                                                                              \
        name " = 1", "--" dashed, name ": yes", "\"" name "\":true", name "=True"                  \
    }

const char *tfa_option_text(const tfa_report *report, tfa_option option)
{
    static const char *const texts[TFA_OPTIONS][TFA_SYNTAX_PYTHON + 1] = {
        [TFA_OPTION_BASE_FIXED] = WORD("base", "fixed"),
        [TFA_OPTION_BASE_FLOATING] = WORD("base", "floating"),
        [TFA_OPTION_MIMIC_PROJECT] = WORD("mimic", "project"),
        [TFA_OPTION_MIMIC_LOCK] = WORD("mimic", "lock"),
        [TFA_OPTION_INERTIA_STRICT] = WORD("inertia", "strict"),
        [TFA_OPTION_INERTIA_REPAIR] = WORD("inertia", "repair"),
        [TFA_OPTION_LOCK_LEAVES] = SWITCH("lock_massless_leaves", "lock-massless-leaves"),
        [TFA_OPTION_DAMPING] = SWITCH("damping", "damping"),
        [TFA_OPTION_FRICTION] = SWITCH("friction", "friction"),
        [TFA_OPTION_ROTOR_INERTIA] = SWITCH("rotor_inertia", "rotor-inertia"),
    };
    const unsigned syntax = report ? (unsigned)report->syntax : 0;
    return texts[option][syntax <= TFA_SYNTAX_PYTHON ? syntax : 0];
}

void tfa_report_begin(tfa_report *report)
{
    if (report)
        report->first = report->count;
}

static tfa_message *find_group(const tfa_report *report, tfa_severity severity, const char *code)
{
    for (size_t i = report->count; i-- > report->first;) {
        tfa_message *m = &report->messages[i];
        if (m->prefix_length > 0 && m->severity == severity && strcmp(m->code, code) == 0)
            return m;
    }
    return NULL;
}

/* Code, entity and text share a block that starts with the code. */
static void replace_text(tfa_message *m, const char *text)
{
    const size_t head = (size_t)(m->text - m->code), size = strlen(text) + 1;
    const size_t entity = (size_t)(m->entity - m->code);
    char *block = realloc((void *)(uintptr_t)m->code, head + size);
    if (!block)
        return; /* the shorter text remains */
    memcpy(block + head, text, size);
    m->code = block;
    m->entity = block + entity;
    m->text = block + head;
}

/* "STEM; links like it: 2 ('a', 'b')": one more name, or "..." after the last that is shown */
static void add_name(tfa_message *m, const char *noun, const char *name)
{
    char list[TEXT], text[2 * TEXT];
    const char *open = strchr(m->text + m->prefix_length, '(');
    if (open) /* without the closing parenthesis */
        snprintf(list, sizeof list, "%.*s", (int)(strlen(open) - 2), open + 1);
    else
        snprintf(list, sizeof list, "'%s'", m->entity);
    const size_t used = strlen(list);
    if (m->count <= NAMES_LISTED_MAX)
        snprintf(list + used, sizeof list - used, ", '%s'", name);
    else if (m->count == NAMES_LISTED_MAX + 1)
        snprintf(list + used, sizeof list - used, ", ...");
    snprintf(text, sizeof text, "%.*s; %s like it: %u (%s)", (int)m->prefix_length, m->text, noun,
             m->count, list);
    replace_text(m, text);
}

void tfa_report_add_grouped(tfa_report *report, tfa_severity severity, uint32_t line,
                            const char *code, const char *noun, const char *name,
                            const char *format, ...)
{
    if (!report)
        return;
    tfa_message *m = find_group(report, severity, code);
    if (m) {
        report->errors += severity == TFA_ERROR;
        report->warnings += severity == TFA_WARNING;
        m->count++;
        add_name(m, noun, name);
        return;
    }
    char text[TEXT];
    va_list arguments;
    va_start(arguments, format);
    tfa_report_print(text, sizeof text, format, arguments);
    va_end(arguments);
    m = tfa_report_append(report, severity, line, code, name, text);
    if (m)
        m->prefix_length = (uint32_t)strlen(m->text);
}

void tfa_report_add_unused(tfa_report *report, uint32_t line, const char *code, const char *item,
                           size_t count, const char *more)
{
    if (!report)
        return;
    char text[TEXT];
    snprintf(text, sizeof text, "robot: %s: not used; in the file: %zu%s", item, count, more);
    tfa_message *m = tfa_report_append(report, TFA_NOTE, line, code, item, text);
    if (m)
        m->count = (uint32_t)count;
}

/* Number of errors since report->first, and of their codes */
static size_t count_errors(const tfa_report *report, size_t *kinds)
{
    size_t errors = 0;
    *kinds = 0;
    for (size_t i = report->first; i < report->count; i++) {
        const tfa_message *m = &report->messages[i];
        size_t k = report->first;
        if (m->severity != TFA_ERROR)
            continue;
        errors += m->count;
        while (k < i && (report->messages[k].severity != TFA_ERROR ||
                         strcmp(report->messages[k].code, m->code) != 0))
            k++;
        *kinds += k == i;
    }
    return errors;
}

void tfa_report_add_refused(tfa_report *report, const char *option)
{
    if (!report)
        return;
    size_t kinds;
    const size_t errors = count_errors(report, &kinds), counted = report->errors;
    if (errors == 0)
        return;
    char text[TEXT], of[64] = "";
    if (errors > 1)
        snprintf(of, sizeof of, " of %zu kind%s", kinds, kinds == 1 ? "" : "s");
    snprintf(text, sizeof text, "robot: not loaded: %zu error%s%s%s%s", errors,
             errors == 1 ? "" : "s", of, option ? "; it loads with " : "", option ? option : "");
    tfa_report_add(report, TFA_ERROR, 0, "refused", "%s", text);
    report->errors = counted;
}
