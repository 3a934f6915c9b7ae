/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Creates and releases models.
 */
#include "model/model.h"

#include <math.h>
#include <stdlib.h>

#include "model/arena.h"
#include "model/compile/compile.h"

int tfa_check_gravity(const double *gravity, tfa_report *report)
{
    for (int k = 0; gravity && k < 3; k++)
        if (!isfinite(gravity[k]))
            return TFA_REFUSE(report, TFA_E_VALUE, 0, "bad-gravity",
                              "gravity: component %d is not finite; give three numbers in m/s^2",
                              k);
    return TFA_OK;
}

static int check_options(const tfa_model_options *options, tfa_report *report)
{
    if (!options)
        return TFA_OK;
    if (options->base != TFA_BASE_FIXED && options->base != TFA_BASE_FLOATING)
        return TFA_REFUSE(report, TFA_E_ARGUMENT, 0, "bad-base",
                          "base: %d does not exist; give 0 (fixed) or 1 (floating)",
                          (int)options->base);
    if ((unsigned)options->inertia > TFA_INERTIA_STRICT_PHYSICAL)
        return TFA_REFUSE(report, TFA_E_ARGUMENT, 0, "bad-policy",
                          "inertia: policy %d does not exist; use one of tfa_inertia_policy",
                          (int)options->inertia);
    if ((unsigned)options->mimic > TFA_MIMIC_LOCK)
        return TFA_REFUSE(report, TFA_E_ARGUMENT, 0, "bad-policy",
                          "mimic: policy %d does not exist; use one of tfa_mimic_policy",
                          (int)options->mimic);
    if (!(options->snap >= 0 && options->snap <= TFA_SNAP_MAX))
        return TFA_REFUSE(
            report, TFA_E_VALUE, 0, "bad-snap",
            "snap: %g is not an angle from 0 to %g rad; give what rounding in the file may be",
            options->snap, TFA_SNAP_MAX);
    const double v = options->friction_velocity;
    if (v != 0 && !(v >= TFA_FRICTION_VELOCITY_MIN && isfinite(v)))
        return TFA_REFUSE(
            report, TFA_E_VALUE, 0, "bad-friction-velocity",
            "friction_velocity: %g is no velocity from %g rad/s or m/s on; give 0 for "
            "%g, or the one below which joints count as sticking",
            v, TFA_FRICTION_VELOCITY_MIN, TFA_FRICTION_VELOCITY);
    return tfa_check_gravity(options->gravity, report);
}

size_t tfa_model_size(const tfa_description *description, const tfa_model_options *options)
{
    struct draft d = {0};
    size_t size = 0;
    if (!description)
        return 0;
    if (check_options(options, NULL) == TFA_OK &&
        tfa_draft_make(&d, description, options, NULL) == TFA_OK)
        size = tfa_compiled_size(&d);
    tfa_draft_free(&d);
    return size;
}

/* Makes a draft; a refusal ends with the option that would help. */
static int make_draft(struct draft *d, const tfa_description *description,
                      const tfa_model_options *options, tfa_report *report)
{
    char text[128];
    const int status = tfa_draft_make(d, description, options, report);
    if (status != TFA_OK && report && report->errors > 0)
        tfa_report_add_refused(report,
                               tfa_find_remedy(description, options, report, text, sizeof text));
    return status;
}

/* Compiles into `memory`, or into memory that it allocates if that is NULL. */
static int compile(void *memory, size_t size, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report, void **model)
{
    struct draft d;
    tfa_report_begin(report);
    int status = check_options(options, report);
    if (status != TFA_OK)
        return status;
    status = make_draft(&d, description, options, report);
    if (status == TFA_OK && !memory) {
        size = tfa_compiled_size(&d);
        memory = aligned_alloc(TFA_ALIGNMENT, size);
    }
    if (status == TFA_OK &&
        (!memory || size < tfa_compiled_size(&d) || (uintptr_t)memory % TFA_ALIGNMENT))
        status = TFA_E_MEMORY;
    if (status == TFA_OK) {
        (void)tfa_compile(&d, memory);
        *model = memory; /* the model stands at the start of its memory */
    }
    tfa_draft_free(&d);
    return status;
}

int tfa_model_init(void *memory, size_t size, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report, const tfa_model **model)
{
    void *made = NULL;
    if (!memory || !description || !model)
        return TFA_E_ARGUMENT;
    const int status = compile(memory, size, description, options, report, &made);
    *model = made;
    return status;
}

int tfa_model_create(const tfa_description *description, const tfa_model_options *options,
                     tfa_report *report, tfa_model **model)
{
    void *made = NULL;
    if (!description || !model)
        return TFA_E_ARGUMENT;
    const int status = compile(NULL, 0, description, options, report, &made);
    *model = made;
    return status;
}

int tfa_model_load(const char *urdf_path, const tfa_model_options *options, tfa_report *report,
                   tfa_model **model)
{
    if (!urdf_path || !model)
        return TFA_E_ARGUMENT;
    *model = NULL;
    tfa_report own_report = {0};
    tfa_report *r = report ? report : &own_report;
    tfa_description *description = NULL;
    int status = tfa_urdf_load(urdf_path, &description, r);
    if (status == TFA_OK)
        status = tfa_model_create(description, options, r, model);
    tfa_description_free(description);
    tfa_report_free(&own_report);
    return status;
}

void tfa_model_free(tfa_model *model)
{
    free(model);
}
