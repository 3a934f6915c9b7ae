/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of crossovers: shipped, from a file, to a file.
 */
#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/crossovers.h>
#include <totalforce/text.h>

#define VERSION 1

static const tfa_crossovers shipped = {
#define SHIPPED(name, standard, lowest, unit, what) .name = (standard),
    TFA_CROSSOVER_LIST(SHIPPED)
#undef SHIPPED
};

const tfa_crossovers *tfa_crossovers_default(void)
{
    return &shipped;
}

static const struct row {
    const char *name, *unit, *what;
    uint32_t lowest;
    size_t at;
} rows[] = {
#define ROW(name, standard, lowest, unit, what)                                                    \
    {#name, unit, what, lowest, offsetof(tfa_crossovers, name)},
    TFA_CROSSOVER_LIST(ROW)
#undef ROW
};
#define ROWS (sizeof rows / sizeof *rows)

/* ---- reading ---- */

struct reader {
    const char *path;
    char *error;
    size_t error_size;
    unsigned line;
    int version;
    unsigned char given[ROWS];
    tfa_crossovers found;
};

__attribute__((format(printf, 3, 4))) static int complain(struct reader *r, const char *key,
                                                          const char *format, ...)
{
    va_list args;
    va_start(args, format);
    if (r->error && r->error_size) {
        const int used = snprintf(r->error, r->error_size, "%s:%u: %s: ", r->path, r->line, key);
        if (used > 0 && (size_t)used < r->error_size)
            vsnprintf(r->error + used, r->error_size - (size_t)used, format, args);
    }
    va_end(args);
    return TFA_E_PARSE;
}

/* The text without blanks at either end, nor a comment; changed in place. */
static char *trim(char *text)
{
    text[strcspn(text, "#\r\n")] = '\0';
    while (isspace((unsigned char)*text))
        text++;
    size_t end = strlen(text);
    while (end && isspace((unsigned char)text[end - 1]))
        end--;
    text[end] = '\0';
    return text;
}

static int number(const char *text, uint32_t *out)
{
    uint64_t value;
    if (tfa_whole_number_read(text, strlen(text), &value) != TFA_NUMBER_OK || value >= TFA_NEVER)
        return 0;
    *out = (uint32_t)value;
    return 1;
}

static int take_version(struct reader *r, const char *value)
{
    uint32_t version = 0;
    if (!number(value, &version) || version != VERSION)
        return complain(r, "version", "'%s', must be %d; run totalforce chart --calibrate anew",
                        value, VERSION);
    r->version = 1;
    return TFA_OK;
}

static int take_row(struct reader *r, size_t k, const char *value)
{
    uint32_t *out = (uint32_t *)(void *)((char *)&r->found + rows[k].at);
    if (r->given[k]++)
        return complain(r, rows[k].name, "given twice; remove one");
    if (strcmp(value, "never") == 0)
        *out = TFA_NEVER;
    else if (!number(value, out) || *out < rows[k].lowest)
        return complain(r, rows[k].name,
                        "'%s' is out of range; a whole number of %s from %" PRIu32 " to %" PRIu32
                        ", or never",
                        value, rows[k].unit, rows[k].lowest, TFA_NEVER - 1);
    return TFA_OK;
}

static int unknown(struct reader *r, const char *key)
{
    char names[32 * ROWS] = "";
    for (size_t k = 0; k < ROWS; k++)
        strcat(strcat(names, k ? ", " : ""), rows[k].name);
    return complain(r, key, "not a crossover; one of %s", names);
}

static int take_line(struct reader *r, char *text)
{
    char *key = trim(text), *colon = strchr(key, ':');
    if (!*key)
        return TFA_OK;
    if (!colon)
        return complain(r, key, "no colon; write name: number");
    *colon = '\0';
    key = trim(key);
    const char *value = trim(colon + 1);
    if (strcmp(key, "version") == 0)
        return take_version(r, value);
    if (!r->version)
        return complain(r, key, "before the version; write version: %d first", VERSION);
    for (size_t k = 0; k < ROWS; k++)
        if (strcmp(key, rows[k].name) == 0)
            return take_row(r, k, value);
    return unknown(r, key);
}

int tfa_crossovers_read(const char *path, tfa_crossovers *out, char *error, size_t error_size)
{
    struct reader r = {.path = path, .error = error, .error_size = error_size, .found = shipped};
    char *line = NULL;
    size_t room = 0;
    int status = TFA_OK;
    if (error && error_size)
        *error = '\0';
    FILE *in = fopen(path, "re");
    if (!in) {
        if (error)
            snprintf(error, error_size, "%s: cannot be read: %s", path, strerror(errno));
        return TFA_E_FILE;
    }
    while (status == TFA_OK && getline(&line, &room, in) >= 0) {
        r.line++;
        status = take_line(&r, line);
    }
    if (status == TFA_OK && ferror(in)) {
        (void)complain(&r, "cannot be read", "%s", strerror(errno));
        status = TFA_E_FILE;
    }
    if (status == TFA_OK && !r.version)
        status = complain(&r, "version", "not there; write version: %d", VERSION);
    free(line);
    fclose(in);
    if (status == TFA_OK)
        *out = r.found;
    return status;
}

/* ---- writing ---- */

struct writer {
    char *text;
    size_t size, length;
};

__attribute__((format(printf, 2, 3))) static void add(struct writer *w, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const size_t left = w->length < w->size ? w->size - w->length : 0;
    const int n = vsnprintf(left ? w->text + w->length : NULL, left, format, args);
    w->length += n > 0 ? (size_t)n : 0;
    va_end(args);
}

static void add_remark(struct writer *w, const char *remark)
{
    for (const char *line = remark; line && *line;) {
        const size_t length = strcspn(line, "\n");
        add(w, "# %.*s\n", (int)length, line);
        line += length + (line[length] == '\n');
    }
}

size_t tfa_crossovers_text(const tfa_crossovers *crossovers, const char *remark, char *text,
                           size_t size)
{
    struct writer w = {text, size, 0};
    add(&w, "# From which size on which way is the faster one (totalforce chart --calibrate).\n");
    add_remark(&w, remark);
    add(&w, "version: %d\n", VERSION);
    for (size_t k = 0; k < ROWS; k++) {
        char value[16] = "never", pair[64];
        const uint32_t from =
            *(const uint32_t *)(const void *)((const char *)crossovers + rows[k].at);
        if (from != TFA_NEVER)
            snprintf(value, sizeof value, "%" PRIu32, from);
        snprintf(pair, sizeof pair, "%s: %s", rows[k].name, value);
        add(&w, "%-26s # %s: %s\n", pair, rows[k].unit, rows[k].what);
    }
    return w.length;
}
