/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints the table of keys for the program that writes the manual page.
 */
#include "command_line/command_line.h"
#include "config_table.h"

static const char *kind_text(config_kind kind)
{
    static const char *const texts[] = {"whole number", "yes or no", "number", "text",
                                        "word",         "group",     "list"};
    return texts[kind];
}

static void print_type(const config_row *row, FILE *out)
{
    fprintf(out, "\t%s", kind_text(row->kind));
    if (row->kind == CONFIG_LIST)
        fprintf(out, " of %ss", row->table ? "group" : kind_text(row->entry));
    if (row->kind == CONFIG_WORD)
        for (size_t i = (size_t)row->low; row->words[i]; i++)
            fprintf(out, "%s%s", i == (size_t)row->low ? ": " : ", ", row->words[i]);
}

static void print_default(const config_row *row, FILE *out)
{
    fputc('\t', out);
    if (row->required)
        return;
    if (row->word)
        fputs(row->word, out);
    else if ((row->kind == CONFIG_COUNT || row->kind == CONFIG_NUMBER) &&
             row->default_value >= row->low)
        fprintf(out, "%u", row->default_value);
    else if (row->kind == CONFIG_BOOL)
        fputs(row->default_value ? "yes" : "no", out);
    else if (row->kind == CONFIG_WORD)
        fputs(row->words[row->default_value], out);
}

static void print_range(const config_row *row, FILE *out)
{
    fputc('\t', out);
    if (row->kind == CONFIG_COUNT || row->kind == CONFIG_NUMBER)
        fprintf(out, "%.10g to %.10g%s%s", row->low, row->high, row->word ? ", or " : "",
                row->word ? row->word : "");
    else if (row->kind == CONFIG_LIST && row->low == row->high)
        fprintf(out, "%.10g entries", row->low);
    else if (row->kind == CONFIG_LIST)
        fprintf(out, "%.10g to %.10g entries", row->low, row->high);
}

/* Of a group the keys in it tell. */
static const char *reload_text(const config_row *row)
{
    return row->kind == CONFIG_GROUP ? "" : row->reloadable ? "reload" : "restart";
}

static void print_rows(const config_table *table, const char *path, FILE *out)
{
    char inner[256];
    for (const config_row *row = table->rows; row->key; row++) {
        fprintf(out, "key\t%s%s", path, row->key);
        print_type(row, out);
        fputs(row->required ? "\trequired" : "\t", out);
        print_default(row, out);
        print_range(row, out);
        command_line_print_field(row->unit, out);
        fprintf(out, "\t%s", reload_text(row));
        command_line_print_field(row->help, out);
        fputc('\n', out);
        if (!row->table)
            continue;
        snprintf(inner, sizeof inner, "%s%s%s.", path, row->key,
                 row->kind == CONFIG_LIST ? "[]" : "");
        print_rows(row->table, inner, out);
    }
}

int config_print_keys(FILE *out)
{
    print_rows(&config_top, "", out);
    return fflush(out);
}
