/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Numbers of results as JSON.
 */
#ifndef TOOLS_COMMON_RESULTS_H
#define TOOLS_COMMON_RESULTS_H

#include <jansson.h>

/** A number in JSON: null where there is no finite number. */
void results_set_number(json_t *object, const char *key, double value);

#endif
