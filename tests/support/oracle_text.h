/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rotations and axes as the text of a URDF file states them, read without the library.
 *
 * The numbers of the text are read as doubles; from there on everything is quadruple precision.
 */
#ifndef TESTS_SUPPORT_ORACLE_TEXT_H
#define TESTS_SUPPORT_ORACLE_TEXT_H

#include "oracle.h"

typedef struct oracle_text oracle_text;

/** The description gives names and indices only. Handles well-formed files without CDATA. Fails the
 * test when memory runs out. */
oracle_text *oracle_text_read(const char *text, const tfa_description *description);
/** The same of a file. */
oracle_text *oracle_text_load(const char *path, const tfa_description *description);
void oracle_text_free(oracle_text *text);

/** From the next state on the oracle takes rotations and axes from the text, which must outlive it,
 * instead of the description; NULL: from the description. */
void oracle_use_text(oracle *o, const oracle_text *text);

#endif
