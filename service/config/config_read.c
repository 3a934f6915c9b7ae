/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a YAML file to the configuration, by the table of keys: which keys there are, lists and
 * missing keys. All errors of a file are found in one go.
 */
#include "config_read.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* ---- errors ---- */

__attribute__((format(printf, 4, 0))) static void print_error(config_reader *r,
                                                              const yaml_mark_t *mark,
                                                              const char *path, const char *format,
                                                              va_list arguments)
{
    fprintf(r->errors, "%s:%zu:%zu: %s%s", r->file, mark->line + 1, mark->column + 1, path,
            *path ? ": " : "");
    vfprintf(r->errors, format, arguments);
    fputc('\n', r->errors);
    r->count++;
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

__attribute__((format(printf, 3, 4))) static void
error_at_mark(config_reader *r, const yaml_mark_t *mark, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_error(r, mark, "", format, arguments);
    va_end(arguments);
}

/* ---- the document ---- */

#define DEPTH_MAX 32

static int refuse_yaml(config_reader *r, const yaml_parser_t *parser)
{
    if (parser->error == YAML_MEMORY_ERROR)
        return TFA_E_MEMORY;
    const bool tab = parser->problem && strstr(parser->problem, "cannot start any token");
    error_at_mark(r, parser->error == YAML_READER_ERROR ? &parser->mark : &parser->problem_mark,
                  "this is not YAML: %s%s%s%s", parser->problem ? parser->problem : "unreadable",
                  parser->context ? " " : "", parser->context ? parser->context : "",
                  tab ? "; indent by spaces, quote texts that begin with a special character" : "");
    return TFA_E_PARSE;
}

/* One file is one document. */
static int check_end(config_reader *r, yaml_parser_t *parser)
{
    yaml_document_t more;
    if (!yaml_parser_load(parser, &more))
        return refuse_yaml(r, parser);
    const yaml_node_t *root = yaml_document_get_root_node(&more);
    if (root)
        config_error_at(r, root, "", "a second document; a configuration is one document");
    yaml_document_delete(&more);
    return root ? TFA_E_PARSE : TFA_OK;
}

static int parse_document(config_reader *r, yaml_parser_t *parser)
{
    static const yaml_mark_t start = {0};
    if (!yaml_parser_load(parser, r->document))
        return refuse_yaml(r, parser);
    int status = TFA_E_PARSE;
    if (!yaml_document_get_root_node(r->document))
        error_at_mark(r, &start, "no keys; at least 'robots' is needed");
    else
        status = check_end(r, parser);
    if (status != TFA_OK)
        yaml_document_delete(r->document);
    return status;
}

/* libyaml takes a time that grows with the square of the depth, and then a stack of that depth: a
 * configuration has six levels. Errors of another kind are left to the reading that follows. */
static int check_depth(config_reader *r, FILE *stream)
{
    yaml_parser_t parser;
    yaml_event_t event;
    int depth = 0;
    bool more = true;
    if (!yaml_parser_initialize(&parser))
        return TFA_E_MEMORY;
    yaml_parser_set_input_file(&parser, stream);
    while (more && depth <= DEPTH_MAX && yaml_parser_parse(&parser, &event)) {
        more = event.type != YAML_STREAM_END_EVENT;
        depth += event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT;
        depth -= event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
        if (depth > DEPTH_MAX)
            error_at_mark(r, &event.start_mark,
                          "lists and keys within each other, more than %d "
                          "levels deep",
                          DEPTH_MAX);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    rewind(stream);
    return depth > DEPTH_MAX ? TFA_E_PARSE : TFA_OK;
}

int config_read_document(config_reader *r)
{
    yaml_parser_t parser;
    FILE *stream = fopen(r->file, "re");
    if (!stream) {
        fprintf(r->errors, "%s:0:0: cannot be read: %s\n", r->file, strerror(errno));
        return TFA_E_FILE;
    }
    int status = check_depth(r, stream);
    if (status == TFA_OK && !yaml_parser_initialize(&parser))
        status = TFA_E_MEMORY;
    if (status == TFA_OK) {
        yaml_parser_set_input_file(&parser, stream);
        status = parse_document(r, &parser);
        yaml_parser_delete(&parser);
    }
    fclose(stream);
    return status;
}

/* ---- lists ---- */

static void describe_list(const config_row *row, char *text, size_t size)
{
    const char *what = row->table                    ? "entries with keys"
                       : row->entry == CONFIG_COUNT  ? "whole numbers"
                       : row->entry == CONFIG_NUMBER ? "numbers"
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
    if (!node || !check_list(r, row, node, path, &length) || length == 0)
        return TFA_OK;
    *list = calloc(length, size);
    if (!*list)
        return TFA_E_MEMORY;
    *count = length;
    for (size_t i = 0; i < length && status == TFA_OK; i++) {
        const yaml_node_t *entry =
            yaml_document_get_node(r->document, node->data.sequence.items.start[i]);
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
