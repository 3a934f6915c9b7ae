/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Models and workspaces that must come about; the test fails otherwise. Released as usual.
 */
#ifndef TFA_TESTS_MODELS_H
#define TFA_TESTS_MODELS_H

#include <totalforce/totalforce.h>

/** A file of config/robots, without errors. */
tfa_description *bundled_description(const char *file);
/** Its text, for free(). */
char *bundled_text(const char *file);
tfa_model *bundled_model(const char *file, const tfa_model_options *options);
tfa_model *compiled(const tfa_description *description, const tfa_model_options *options);
tfa_workspace *workspace_for(const tfa_model *model, const tfa_workspace_options *options);

#endif
