/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints the configuration in effect, from the table of keys.
 */
#include "config_table.h"

static void dump_table(const config_table *t, const char *in, int indent, const char *lead,
                       FILE *out);

static void dump_text(const char *text, FILE *out)
{
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', out);
        if ((unsigned char)*text < ' ' || *text == 0x7f)
            fprintf(out, "\\x%02x", (unsigned)*text);
        else
            fputc(*text, out);
    }
    fputc('"', out);
}

static void dump_scalar(config_kind kind, const config_row *row, const void *in, FILE *out)
{
    switch (kind) {
    case CONFIG_COUNT:
        if (row->word && *(const uint32_t *)in == UINT32_MAX)
            fputs(row->word, out);
        else
            fprintf(out, "%u", *(const uint32_t *)in);
        break;
    case CONFIG_BOOL:
        fputs(*(const bool *)in ? "true" : "false", out);
        break;
    case CONFIG_NUMBER:
        fprintf(out, "%.17g", *(const double *)in);
        break;
    case CONFIG_WORD:
        fputs(row->words[*(const uint32_t *)in], out);
        break;
    default:
        dump_text(*(const char *const *)in, out);
        break;
    }
}

static void dump_list(const config_row *row, const char *in, int indent, FILE *out)
{
    const char *entries = *(const char *const *)(const void *)(in + row->at);
    const size_t count = *(const size_t *)(const void *)(in + row->count_at);
    fprintf(out, "%*s%s:", indent, "", row->key);
    if (row->table) {
        fputc('\n', out);
        for (size_t i = 0; i < count; i++)
            dump_table(row->table, entries + i * row->table->size, indent + 4, "  - ", out);
        return;
    }
    const size_t size = config_entry_size(row);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : " [", out);
        dump_scalar(row->entry, row, entries + i * size, out);
    }
    fputs("]\n", out);
}

/* A key without a value is shown as a comment, and a required group as empty. */
static bool is_absent(const config_row *row, const char *in)
{
    const config_row *key = row->kind == CONFIG_GROUP ? row->table->rows : NULL;
    while (key && key->key && is_absent(key, in + row->at))
        key++;
    if (key)
        return !key->key;
    if (row->kind == CONFIG_TEXT)
        return *(const char *const *)(const void *)(in + row->at) == NULL;
    if (row->kind == CONFIG_NUMBER)
        return row->low > 0 && !(*(const double *)(const void *)(in + row->at) > 0);
    return row->kind == CONFIG_LIST && *(const size_t *)(const void *)(in + row->count_at) == 0;
}

static void dump_row(const config_row *row, const char *in, int indent, const char *lead, FILE *out)
{
    if (is_absent(row, in)) {
        fprintf(out, row->required ? "%*s%s: {}\n" : "%*s# %s:\n", indent, "", row->key);
    } else if (row->kind == CONFIG_GROUP) {
        fprintf(out, "%*s%s:\n", indent, "", row->key);
        dump_table(row->table, in + row->at, indent + 2, "", out);
    } else if (row->kind == CONFIG_LIST) {
        dump_list(row, in, indent, out);
    } else {
        if (*lead)
            fprintf(out, "%*s%s", indent - 4, "", lead);
        else
            fprintf(out, "%*s", indent, "");
        fprintf(out, "%s: ", row->key);
        dump_scalar(row->kind, row, in + row->at, out);
        fputc('\n', out);
    }
}

static void dump_table(const config_table *t, const char *in, int indent, const char *lead,
                       FILE *out)
{
    for (const config_row *row = t->rows; row->key; row++) {
        fprintf(out, "%*s# %s\n", indent, "", row->help);
        dump_row(row, in, indent, row == t->rows ? lead : "", out);
    }
}

void config_dump(const config *c, FILE *out)
{
    dump_table(&config_top, (const char *)c, 0, "", out);
}
