/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Finds the line and column of a value in a YAML file, for errors that libcyaml cannot know.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "config_table.h"

static yaml_node_t *mapping_value(yaml_document_t *document, const yaml_node_t *node,
                                  const char *key, size_t length)
{
    if (node->type != YAML_MAPPING_NODE)
        return NULL;
    for (yaml_node_pair_t *p = node->data.mapping.pairs.start; p < node->data.mapping.pairs.top;
         p++) {
        const yaml_node_t *name = yaml_document_get_node(document, p->key);
        if (name && name->type == YAML_SCALAR_NODE && name->data.scalar.length == length &&
            memcmp(name->data.scalar.value, key, length) == 0)
            return yaml_document_get_node(document, p->value);
    }
    return NULL;
}

static yaml_node_t *sequence_entry(yaml_document_t *document, const yaml_node_t *node, long index)
{
    if (node->type != YAML_SEQUENCE_NODE)
        return NULL;
    yaml_node_item_t *item = node->data.sequence.items.start + index;
    if (index < 0 || item >= node->data.sequence.items.top)
        return NULL;
    return yaml_document_get_node(document, *item);
}

/* Follows a path as far as it goes: the last node found. */
static const yaml_node_t *follow(yaml_document_t *document, const char *path)
{
    yaml_node_t *node = yaml_document_get_root_node(document);
    const yaml_node_t *last = node;
    while (node && *path) {
        if (*path == '[') {
            node = sequence_entry(document, node, strtol(path + 1, NULL, 10));
            path += strcspn(path, "]");
            path += *path == ']';
        } else {
            path += *path == '.';
            size_t length = strcspn(path, ".[");
            node = mapping_value(document, node, path, length);
            path += length;
        }
        if (node)
            last = node;
    }
    return last;
}

static void locate_path(yaml_document_t *document, const char *path, size_t *line, size_t *column)
{
    const yaml_node_t *node = follow(document, path);
    if (!node)
        return;
    *line = node->start_mark.line + 1;
    *column = node->start_mark.column + 1;
}

static bool is_before(size_t line, size_t column, size_t other_line, size_t other_column)
{
    return line < other_line || (line == other_line && column < other_column);
}

/* The first key of that name at or after the place. */
static void locate_key(yaml_document_t *document, const char *key, size_t *line, size_t *column)
{
    size_t best_line = SIZE_MAX, best_column = SIZE_MAX;
    for (yaml_node_t *node = document->nodes.start; node < document->nodes.top; node++) {
        if (node->type != YAML_MAPPING_NODE)
            continue;
        for (yaml_node_pair_t *p = node->data.mapping.pairs.start; p < node->data.mapping.pairs.top;
             p++) {
            const yaml_node_t *name = yaml_document_get_node(document, p->key);
            if (!name || name->type != YAML_SCALAR_NODE ||
                strcmp((const char *)name->data.scalar.value, key) != 0)
                continue;
            const size_t l = name->start_mark.line + 1, c = name->start_mark.column + 1;
            if (!is_before(l, c, *line, *column) && is_before(l, c, best_line, best_column)) {
                best_line = l;
                best_column = c;
            }
        }
    }
    if (best_line == SIZE_MAX)
        return;
    *line = best_line;
    *column = best_column;
}

typedef void (*locator)(yaml_document_t *document, const char *what, size_t *line, size_t *column);

static void with_document(const char *file, locator locate, const char *what, size_t *line,
                          size_t *column)
{
    yaml_parser_t parser;
    yaml_document_t document;
    FILE *stream = fopen(file, "re");
    if (!stream)
        return;
    if (!yaml_parser_initialize(&parser))
        goto err_stream;
    yaml_parser_set_input_file(&parser, stream);
    if (yaml_parser_load(&parser, &document)) {
        locate(&document, what, line, column);
        yaml_document_delete(&document);
    }
    yaml_parser_delete(&parser);
err_stream:
    fclose(stream);
}

void config_locate(const char *file, const char *path, size_t *line, size_t *column)
{
    *line = *column = 0;
    with_document(file, locate_path, path, line, column);
}

void config_locate_key(const char *file, const char *key, size_t *line, size_t *column)
{
    with_document(file, locate_key, key, line, column);
}
