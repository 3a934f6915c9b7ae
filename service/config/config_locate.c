/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Finds a value in a YAML document by its path, for messages about it.
 */
#include <stdlib.h>
#include <string.h>

#include "config_read.h"

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

const yaml_node_t *config_follow(yaml_document_t *document, const char *path)
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
