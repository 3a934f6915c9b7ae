/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reading of files that are one YAML document.
 */
#ifndef TFA_TEXT_YAML_DOCUMENT_H
#define TFA_TEXT_YAML_DOCUMENT_H

#include <stdbool.h>
#include <stdio.h>
#include <totalforce/status.h>
#include <yaml.h>

/* Why a text is refused, and where. */
typedef struct tfa_yaml_fault {
    yaml_mark_t mark;
    char text[240];
} tfa_yaml_fault;

/* Reads the one document of a stream, which can be rewound. Lists and keys are at most `depth_max`
 * levels deep.
 * @param aliases  anchors and aliases are allowed; a node may then be its own child
 * @return TFA_OK: release with yaml_document_delete; TFA_E_PARSE: `fault` says why; TFA_E_MEMORY */
TFA_CHECKED int tfa_yaml_read(FILE *stream, int depth_max, bool aliases, yaml_document_t *document,
                              tfa_yaml_fault *fault);

#endif
