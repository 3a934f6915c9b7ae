/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Models and workspaces that must come about; the test fails otherwise. Released as usual.
 */
#ifndef TFA_TESTS_MODELS_H
#define TFA_TESTS_MODELS_H

#include <totalforce/totalforce.h>

#include "support/scoped.h"

/** A file of config/robots, without errors. */
tfa_description *bundled_description(const char *file);
/** Its text, for free(). */
char *bundled_text(const char *file);
tfa_model *bundled_model(const char *file, const tfa_model_options *options);
tfa_model *compiled(const tfa_description *description, const tfa_model_options *options);
tfa_workspace *workspace_for(const tfa_model *model, const tfa_workspace_options *options);

SCOPED_POINTER(scoped_model_free, tfa_model, tfa_model_free)
SCOPED_POINTER(scoped_workspace_free, tfa_workspace, tfa_workspace_free)
#define SCOPED_MODEL SCOPED(scoped_model_free) tfa_model
#define SCOPED_WORKSPACE SCOPED(scoped_workspace_free) tfa_workspace

/** Forward dynamics of one state; NULL: zeros. */
static inline tfa_request request_fd(const double *q, const double *v, const double *tau)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = q,
                         .v = v,
                         .tau = tau};
}

#endif
