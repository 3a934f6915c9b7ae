/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reading of side files of a URDF: YAML documents without anchors, whose faults become messages of
 * a report with line and column.
 */
#ifndef TFA_MODES_SIDE_FILE_H
#define TFA_MODES_SIDE_FILE_H

#include <totalforce/report.h>

#include "text/yaml_document.h"

/* A document while it is read */
typedef struct tfa_side_file {
    yaml_document_t document;
    tfa_report *report;
    const char *code; /* of its messages */
    size_t errors;
} tfa_side_file;

/* A kind of side file */
typedef struct tfa_side_form {
    const char *code, *what; /* "modes": "it is no file of modes" */
    size_t bytes_max;
    /* Appends the contents to `out`, nothing after errors. @return TFA_OK, errors or not;
     * TFA_E_MEMORY */
    int (*read)(tfa_side_file *r, void *out);
} tfa_side_form;

/* As tfa_modes_parse and tfa_modes_load, for any form */
TFA_CHECKED int tfa_side_parse(const tfa_side_form *form, const char *text, size_t length,
                               const char *name, void *out, tfa_report *report);
TFA_CHECKED int tfa_side_load(const tfa_side_form *form, const char *path, void *out,
                              tfa_report *report);

/* ---- nodes ---- */

static inline size_t items_of(const yaml_node_t *node)
{
    return (size_t)(node->data.sequence.items.top - node->data.sequence.items.start);
}

static inline size_t pairs_of(const yaml_node_t *node)
{
    return (size_t)(node->data.mapping.pairs.top - node->data.mapping.pairs.start);
}

static inline const yaml_node_t *item(tfa_side_file *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.sequence.items.start[k]);
}

static inline const yaml_node_t *value_of(tfa_side_file *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.mapping.pairs.start[k].value);
}

static inline const yaml_node_t *key_at(tfa_side_file *r, const yaml_node_t *node, size_t k)
{
    return yaml_document_get_node(&r->document, node->data.mapping.pairs.start[k].key);
}

/* The text of a scalar; NULL: it is none, or has a NUL character. */
const char *tfa_side_text(const yaml_node_t *node);

static inline const char *key_of(tfa_side_file *r, const yaml_node_t *node, size_t k)
{
    return tfa_side_text(key_at(r, node, k));
}

/* Reports "column N: PATH: TEXT". */
__attribute__((format(printf, 4, 5))) void tfa_side_fault(tfa_side_file *r, const yaml_mark_t *mark,
                                                          const char *path, const char *format,
                                                          ...);
#define FAULT(r, node, path, ...) tfa_side_fault(r, &(node)->start_mark, path, __VA_ARGS__)

bool tfa_side_is_mapping(tfa_side_file *r, const yaml_node_t *node, const char *path,
                         const char *form);

/* The values of known keys; NULL where there is none. `form` shows them. */
void tfa_side_keys(tfa_side_file *r, const yaml_node_t *node, const char *path,
                   const char *const *names, size_t count, const char *form,
                   const yaml_node_t **values);

double tfa_side_number(tfa_side_file *r, const yaml_node_t *node, const char *path);

/* A list of `count` numbers, `what` in messages */
void tfa_side_numbers(tfa_side_file *r, const yaml_node_t *node, const char *path, size_t count,
                      const char *what, double *numbers);

#endif
