/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reading a configuration: from the nodes of a YAML document, by the table of keys. Every scalar
 * passes through config_read_scalar, so that every key is read whole or refused.
 */
#ifndef TFA_SERVICE_CONFIG_CONFIG_READ_H
#define TFA_SERVICE_CONFIG_CONFIG_READ_H

#include <yaml.h>

#include "config_table.h"

#define CONFIG_PATH_MAX 256 /* of "robots[1].scenes[0].root", for messages */

/* One file that is read: its nodes, where errors go and how many there were. */
typedef struct config_reader {
    const char *file;
    FILE *errors;
    unsigned count;
    yaml_document_t *document;
} config_reader;

/** Where a scalar belongs. */
typedef struct config_scalar {
    const config_row *row;
    config_kind kind; /**< of the row, or of an entry of its list */
    bool is_entry;    /**< the row's range is then that of the list */
    const char *path;
} config_scalar;

/** Reports an error at a node: "FILE:LINE:COLUMN: path: error". */
__attribute__((format(printf, 4, 5))) void config_error_at(config_reader *r,
                                                           const yaml_node_t *node,
                                                           const char *path, const char *format,
                                                           ...);
/** The same, at the value of the path. */
__attribute__((format(printf, 3, 4))) void config_error(config_reader *r, const char *path,
                                                        const char *format, ...);

/** Follows a path like "robots[1].urdf" as far as the document has it: the last node found. */
const yaml_node_t *config_follow(yaml_document_t *document, const char *path);

/** Reads the file. Reports an error if it is not one YAML document.
 *  @return TFA_OK, and r->document holds nodes; TFA_E_FILE; TFA_E_PARSE; TFA_E_MEMORY */
TFA_CHECKED int config_read_document(config_reader *r);

/** Fills the struct of a table, defaults included; reports every key that is wrong.
 *  `node` NULL: the file leaves it out. @return TFA_OK, errors or not; TFA_E_MEMORY */
TFA_CHECKED int config_read_table(config_reader *r, const config_table *table,
                                  const yaml_node_t *node, const char *path, void *out);

/** Reads one scalar; reports an error, with the spelling that was most likely meant, and writes the
 *  default if the type is wrong. Text stays in the document. */
void config_read_scalar(config_reader *r, const config_scalar *scalar, const yaml_node_t *node,
                        void *out);

/** The runtime directory where the file leaves it out: by the environment, or the default.
 *  @return TFA_OK; TFA_E_MEMORY */
TFA_CHECKED int config_set_runtime_dir(config *c);
/** Reports a runtime directory in which the path of a socket would not fit its address. */
void config_check_runtime_dir(config_reader *r, const config *c);

/** Writes the default of a slot. */
void config_set_default(const config_scalar *scalar, void *out);

#endif
