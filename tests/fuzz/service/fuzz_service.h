/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared parts of the fuzz targets of the daemon.
 */
#ifndef TFA_TESTS_FUZZ_SERVICE_H
#define TFA_TESTS_FUZZ_SERVICE_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void require(int condition)
{
    if (!condition)
        abort();
}

/* The status is of the list. */
static inline int is_known_status(int status)
{
    return status <= TFA_OK && status >= TFA_E_OPEN;
}

/* The bundled arm, loaded once. */
static inline tfa_model *fuzz_model(void)
{
    static tfa_model *model;
    if (!model)
        require(tfa_model_load(TFA_SOURCE_DIR "/config/robots/arm7.urdf", NULL, NULL, &model) ==
                TFA_OK);
    return model;
}

#endif
