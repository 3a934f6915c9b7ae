/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any bytes at all give either sound modes or an error with a message; the same
 * for constraints.
 */
#include "invariants.h"

#include <math.h>
#include <string.h>
#include <totalforce/constraints.h>
#include <totalforce/modes.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require_finite(const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        REQUIRE(isfinite(numbers[i]));
}

static void require_link(const tfa_link_modes *link)
{
    const size_t n = link->mode_count;
    REQUIRE(n >= 1 && n <= TFA_MAX_LINK_MODES);
    REQUIRE(strlen(link->link) < TFA_MODES_MAX_BYTES);
    require_finite(link->momentum, 6 * n);
    require_finite(link->mass, n * n);
    require_finite(link->stiffness, n * n);
    require_finite(link->damping, n * n);
    for (size_t k = 0; k < n; k++)
        REQUIRE(!isnan(link->limit[k]));
    for (size_t j = 0; j < link->shape_count; j++) {
        REQUIRE(strlen(link->shapes[j].joint) < TFA_MODES_MAX_BYTES);
        require_finite(link->shapes[j].shape, 6 * n);
    }
}

static void check_constraints(const char *text, size_t size)
{
    tfa_report report = {0};
    tfa_constraints c = {0};
    const int status = tfa_constraints_parse(text, size, "f.yaml", &c, &report);
    REQUIRE(status == TFA_OK || (c.count == 0 && c.actuated_count == 0));
    check_report(&report, status);
    for (size_t k = 0; k < c.count; k++) {
        REQUIRE(*c.list[k].name && c.list[k].rows && c.list[k].rows <= TFA_CONSTRAINT_WELD);
        require_finite(c.list[k].pose[0], 14);
    }
    for (size_t k = 0; k < c.actuated_count; k++)
        REQUIRE(*c.actuated[k]);
    tfa_constraints_free(&c);
    tfa_report_free(&report);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    check_constraints((const char *)data, size);
    tfa_report report = {0};
    tfa_modes modes = {0};
    const int status = tfa_modes_parse((const char *)data, size, "f.yaml", &modes, &report);
    REQUIRE(status == TFA_OK || modes.count == 0);
    check_report(&report, status);
    for (size_t i = 0; i < modes.count; i++)
        require_link(&modes.links[i]);
    tfa_modes_free(&modes);
    tfa_report_free(&report);
    return 0;
}
