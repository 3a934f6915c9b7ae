/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Finds the line and column of a value in a YAML file, for errors that libcyaml cannot know.
 */
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

void config_locate(const char *file, const char *path, size_t *line, size_t *column)
{
    yaml_parser_t parser;
    yaml_document_t document;
    *line = *column = 0;
    FILE *stream = fopen(file, "re");
    if (!stream)
        return;
    if (!yaml_parser_initialize(&parser))
        goto err_stream;
    yaml_parser_set_input_file(&parser, stream);
    if (yaml_parser_load(&parser, &document)) {
        const yaml_node_t *node = follow(&document, path);
        if (node) {
            *line = node->start_mark.line + 1;
            *column = node->start_mark.column + 1;
        }
        yaml_document_delete(&document);
    }
    yaml_parser_delete(&parser);
err_stream:
    fclose(stream);
}
