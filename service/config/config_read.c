/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a YAML file to the configuration, by the table of keys: which keys there are, lists and
 * missing keys. All errors of a file are found in one go.
 */
#include "config_read.h"

#include "text/yaml_document.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* ---- errors ---- */

/* Of more errors only this is said: an alias repeats those of its list as often as it stands. */
#define ERRORS_MAX 100

__attribute__((format(printf, 4, 0))) static void print_error(config_reader *r,
                                                              const yaml_mark_t *mark,
                                                              const char *path, const char *format,
                                                              va_list arguments)
{
    r->count++;
    if (r->count == ERRORS_MAX + 1)
        fprintf(r->errors, "%s:%zu:%zu: more errors are not listed\n", r->file, mark->line + 1,
                mark->column + 1);
    if (r->count > ERRORS_MAX)
        return;
    fprintf(r->errors, "%s:%zu:%zu: %s%s", r->file, mark->line + 1, mark->column + 1, path,
            *path ? ": " : "");
    vfprintf(r->errors, format, arguments);
    fputc('\n', r->errors);
}

void config_error_at(config_reader *r, const yaml_node_t *node, const char *path,
                     const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_error(r, &node->start_mark, path, format, arguments);
    va_end(arguments);
}

void config_error(config_reader *r, const char *path, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_error(r, &config_follow(r->document, path)->start_mark, path, format, arguments);
    va_end(arguments);
}

/* ---- the document ---- */

#define DEPTH_MAX 32 /* a configuration has six levels */

int config_read_document(config_reader *r)
{
    tfa_yaml_fault fault;
    FILE *stream = fopen(r->file, "re");
    if (!stream) {
        fprintf(r->errors, "%s:0:0: cannot be read: %s\n", r->file, strerror(errno));
        return TFA_E_FILE;
    }
    const int status = tfa_yaml_read(stream, DEPTH_MAX, true, r->document, &fault);
    if (status == TFA_E_PARSE)
        fprintf(r->errors, "%s:%zu:%zu: %s\n", r->file, fault.mark.line + 1, fault.mark.column + 1,
                fault.text);
    fclose(stream);
    return status;
}

/* ---- lists ---- */

static void describe_list(const config_row *row, char *text, size_t size)
{
    const char *what = row->table                    ? "entries with keys"
                       : row->entry == CONFIG_COUNT  ? "whole numbers"
                       : row->entry == CONFIG_NUMBER ? "numbers"
                       : row->entry == CONFIG_WORD   ? "words"
                                                     : "texts";
    if (row->low == row->high)
        snprintf(text, size, "a list of %.10g %s", row->low, what);
    else if (row->low == 0)
        snprintf(text, size, "a list of up to %.10g %s", row->high, what);
    else
        snprintf(text, size, "a list of %.10g to %.10g %s", row->low, row->high, what);
}

static bool check_list(config_reader *r, const config_row *row, const yaml_node_t *node,
                       const char *path, size_t *count)
{
    char wanted[80];
    describe_list(row, wanted, sizeof wanted);
    if (node->type == YAML_SCALAR_NODE)
        config_error_at(r, node, path, "'%.80s' where %s is expected: [a, b, ..]",
                        (const char *)node->data.scalar.value, wanted);
    if (node->type == YAML_MAPPING_NODE)
        config_error_at(r, node, path, "keys where %s is expected; begin each entry with '- '",
                        wanted);
    if (node->type != YAML_SEQUENCE_NODE)
        return false;
    *count = (size_t)(node->data.sequence.items.top - node->data.sequence.items.start);
    if ((double)*count >= row->low && (double)*count <= row->high)
        return true;
    config_error_at(r, node, path, "%zu given, %s is expected", *count, wanted);
    return false;
}

static int read_list(config_reader *r, const config_row *row, const yaml_node_t *node,
                     const char *path, char *out)
{
    char **list = (char **)(void *)(out + row->at), entry_path[CONFIG_PATH_MAX];
    size_t *count = (size_t *)(void *)(out + row->count_at), length = 0;
    const size_t size = config_entry_size(row);
    int status = TFA_OK;
    const bool one = node && row->one && node->type == YAML_SCALAR_NODE;
    if (one)
        length = 1;
    else if (!node || !check_list(r, row, node, path, &length) || length == 0)
        return TFA_OK;
    *list = calloc(length, size);
    if (!*list)
        return TFA_E_MEMORY;
    *count = length;
    for (size_t i = 0; i < length && status == TFA_OK; i++) {
        const yaml_node_t *entry =
            one ? node : yaml_document_get_node(r->document, node->data.sequence.items.start[i]);
        if (one)
            snprintf(entry_path, sizeof entry_path, "%.200s", path);
        else
            snprintf(entry_path, sizeof entry_path, "%.200s[%zu]", path, i);
        const config_scalar scalar = {row, row->entry, true, entry_path};
        if (row->table)
            status = config_read_table(r, row->table, entry, entry_path, *list + i * size);
        else
            config_read_scalar(r, &scalar, entry, *list + i * size);
    }
    return status;
}

/* ---- keys ---- */

static const char *key_of_row(const void *rows, size_t index)
{
    return ((const config_row *)rows)[index].key;
}

/* The row of a key. @return its number, -1 after an error */
static int find_row(config_reader *r, const config_table *t, const yaml_node_t *key,
                    const char *path)
{
    char suggestions[160];
    int count = 0;
    const char *text = key->type == YAML_SCALAR_NODE ? (const char *)key->data.scalar.value : "";
    const bool cut = key->type == YAML_SCALAR_NODE && strlen(text) != key->data.scalar.length;
    for (; t->rows[count].key; count++)
        if (!cut && strcmp(t->rows[count].key, text) == 0)
            return count;
    if (t == &config_top && strcmp(text, "http") == 0) {
        config_error_at(r, key, "http",
                        "totalforced has no HTTP server: the live page and metrics are a program, "
                        "totalforce web --listen ADDRESS:PORT --metrics-socket FILE "
                        "(totalforce-web.service)");
        return -1;
    }
    tfa_suggest(text, t->rows, (size_t)count, key_of_row, suggestions, sizeof suggestions);
    config_error_at(r, key, path,
                    "there is no key '%.80s'%s; nearest: %s; config/full.yaml shows all", text,
                    cut ? " with a NUL character" : "", suggestions);
    return -1;
}

/* The values of a table's rows, NULL where there is none. */
static void collect_values(config_reader *r, const config_table *t, const yaml_node_t *node,
                           const char *path, const yaml_node_t **values)
{
    const yaml_node_t *first[CONFIG_ROWS_MAX];
    for (const yaml_node_pair_t *p = node->data.mapping.pairs.start;
         p < node->data.mapping.pairs.top; p++) {
        const yaml_node_t *key = yaml_document_get_node(r->document, p->key);
        const int row = find_row(r, t, key, path);
        if (row >= 0 && values[row]) {
            config_error_at(r, key, path, "%s: it is there twice, first in line %zu",
                            t->rows[row].key, first[row]->start_mark.line + 1);
        } else if (row >= 0) {
            values[row] = yaml_document_get_node(r->document, p->value);
            first[row] = key;
        }
    }
}

static int read_row(config_reader *r, const config_row *row, const yaml_node_t *node,
                    const char *path, char *out)
{
    const config_scalar scalar = {row, row->kind, false, path};
    if (row->kind == CONFIG_GROUP)
        return config_read_table(r, row->table, node, path, out + row->at);
    if (row->kind == CONFIG_LIST)
        return read_list(r, row, node, path, out);
    if (node)
        config_read_scalar(r, &scalar, node, out + row->at);
    else
        config_set_default(&scalar, out + row->at);
    return TFA_OK;
}

int config_read_table(config_reader *r, const config_table *t, const yaml_node_t *node,
                      const char *path, void *out)
{
    const yaml_node_t *values[CONFIG_ROWS_MAX] = {NULL};
    char key_path[CONFIG_PATH_MAX];
    int status = TFA_OK;
    if (node && node->type == YAML_MAPPING_NODE)
        collect_values(r, t, node, path, values);
    else if (node)
        config_error_at(r, node, path, "keys are expected here ('%s: ...'), not %s", t->rows->key,
                        node->type == YAML_SEQUENCE_NODE ? "a list" : "one value");
    for (size_t i = 0; t->rows[i].key && status == TFA_OK; i++) {
        const config_row *row = &t->rows[i];
        if (node && node->type == YAML_MAPPING_NODE && row->required && !values[i])
            config_error_at(r, node, path, "the key '%s' is missing: %s", row->key, row->help);
        snprintf(key_path, sizeof key_path, "%.180s%s%s", path, *path ? "." : "", row->key);
        status = read_row(r, row, values[i], key_path, out);
    }
    return status;
}
