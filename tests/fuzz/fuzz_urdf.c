/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes at all give either a sound description or an error with a message.
 */
#include "invariants.h"

#include <totalforce/model.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What parsed must compile or be refused with a reason, on both bases. */
static void require_model(const tfa_description *d)
{
    for (int base = TFA_BASE_FIXED; base <= TFA_BASE_FLOATING; base++) {
        const tfa_model_options options = {.base = (tfa_base)base, .rotor_inertia = 1};
        tfa_report report = {0};
        tfa_model *model = NULL;
        int status = tfa_model_create(d, &options, &report, &model);
        REQUIRE((model != NULL) == (status == TFA_OK));
        check_report(&report, status);
        tfa_model_free(model);
        tfa_report_free(&report);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    tfa_description *d = check_parse((const char *)data, size);
    if (d)
        require_model(d);
    tfa_description_free(d);
    return 0;
}
