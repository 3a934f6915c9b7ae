/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Suggestions for an unknown word, for messages.
 */
#ifndef TOOLS_COMMON_SUGGEST_H
#define TOOLS_COMMON_SUGGEST_H

#include <stddef.h>

/** As tfa_suggest_words, of the methods. */
void suggest_methods(const char *wrong, char *text, size_t size);

/** For command_line_values */
const char *suggest_method(size_t index);

#endif
