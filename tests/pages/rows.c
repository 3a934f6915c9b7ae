/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows of a CSV file.
 */
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

static _Noreturn void give_up(const char *what, const char *about)
{
    fprintf(stderr, "rows: %s: %s\n", what, about);
    exit(2);
}

/* Cuts a line in place. @return the number of fields */
static int cut(char *line, char **fields)
{
    int count = 0;
    for (char *in = line, *out; count < ROWS_COLUMNS; in++) {
        int quoted = 0;
        fields[count++] = out = in;
        for (; *in && *in != '\n' && (quoted || *in != ','); in++) {
            if (*in != '"')
                *out++ = *in;
            else if (quoted && in[1] == '"')
                *out++ = *in++;
            else
                quoted = !quoted;
        }
        const int more = *in == ',';
        *out = 0;
        if (!more)
            return count;
    }
    give_up("too many columns", line);
}

void rows_open(rows *r, const char *path)
{
    static const char command[] = "# command: ";
    *r = (rows){.in = fopen(path, "re")};
    if (!r->in)
        give_up(path, "cannot be read");
    while (fgets(r->head, sizeof r->head, r->in) && *r->head == '#')
        if (strncmp(r->head, command, sizeof command - 1) == 0)
            snprintf(r->command, sizeof r->command, "%.*s",
                     (int)strcspn(r->head, "\n") - (int)sizeof command + 1,
                     r->head + sizeof command - 1);
    r->count = cut(r->head, r->names);
}

int rows_next(rows *r)
{
    if (!fgets(r->line, sizeof r->line, r->in)) {
        fclose(r->in);
        return 0;
    }
    if (cut(r->line, r->fields) != r->count)
        give_up("another number of columns", r->line);
    return 1;
}

const char *rows_text(const rows *r, const char *name)
{
    for (int i = 0; i < r->count; i++)
        if (strcmp(r->names[i], name) == 0)
            return r->fields[i];
    give_up("no column", name);
}

double rows_number(const rows *r, const char *name, double empty)
{
    char *end;
    const char *text = rows_text(r, name);
    const double value = strtod(text, &end);
    if (*end)
        give_up(name, text);
    return *text ? value : empty;
}

uint32_t rows_whole(const rows *r, const char *name)
{
    return (uint32_t)rows_number(r, name, 0.0);
}

uint32_t rows_word(const rows *r, const char *name, const char *const *words, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(words[i], rows_text(r, name)) == 0)
            return i;
    give_up(name, rows_text(r, name));
}

int rows_status(const rows *r, const char *name)
{
    for (int status = 0; status > -100; status--)
        if (strcmp(tfa_status_name(status), rows_text(r, name)) == 0)
            return status;
    return 1;
}
