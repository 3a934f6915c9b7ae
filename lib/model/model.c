/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The public noun: making, reading and releasing a model.
 */
#include "model/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/arena.h"
#include "model/compile.h"

size_t tfa_model_size(const tfa_description *description, const tfa_model_options *options)
{
    struct draft d;
    size_t size = 0;
    if (!description)
        return 0;
    if (tfa_draft_make(&d, description, options, NULL) == TFA_OK)
        size = tfa_compiled_size(&d);
    tfa_draft_free(&d);
    return size;
}

static int check_options(const tfa_model_options *options, tfa_report *report)
{
    if (!options)
        return TFA_OK;
    if (options->base != TFA_BASE_FIXED && options->base != TFA_BASE_FLOATING) {
        tfa_report_add(report, TFA_ERROR, 0, "bad-base",
                       "base: %d does not exist; give 0 (fixed) or 1 (floating)",
                       (int)options->base);
        return TFA_E_ARGUMENT;
    }
    for (int k = 0; options->gravity && k < 3; k++)
        if (!isfinite(options->gravity[k])) {
            tfa_report_add(report, TFA_ERROR, 0, "bad-gravity",
                           "gravity: component %d is not finite; give three numbers in m/s^2", k);
            return TFA_E_VALUE;
        }
    return TFA_OK;
}

int tfa_model_init(void *memory, size_t size, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report, const tfa_model **model)
{
    if (!memory || !description || !model)
        return TFA_E_ARGUMENT;
    *model = NULL;
    struct draft d;
    int status = check_options(options, report);
    if (status != TFA_OK)
        return status;
    status = tfa_draft_make(&d, description, options, report);
    if (status == TFA_OK && (size < tfa_compiled_size(&d) || (uintptr_t)memory % TFA_ALIGNMENT))
        status = TFA_E_MEMORY;
    if (status == TFA_OK)
        *model = tfa_compile(&d, options, memory);
    tfa_draft_free(&d);
    return status;
}

int tfa_model_create(const tfa_description *description, const tfa_model_options *options,
                     tfa_report *report, tfa_model **model)
{
    if (!description || !model)
        return TFA_E_ARGUMENT;
    *model = NULL;
    struct draft d;
    int status = check_options(options, report);
    if (status != TFA_OK)
        return status;
    status = tfa_draft_make(&d, description, options, report);
    if (status == TFA_OK) {
        void *memory = aligned_alloc(TFA_ALIGNMENT, tfa_compiled_size(&d));
        status = memory ? TFA_OK : TFA_E_MEMORY;
        if (memory) {
            (void)tfa_compile(&d, options, memory);
            *model = memory; /* the model stands at the start of its memory */
        }
    }
    tfa_draft_free(&d);
    return status;
}

int tfa_model_load(const char *urdf_path, const tfa_model_options *options, tfa_report *report,
                   tfa_model **model)
{
    if (!urdf_path || !model)
        return TFA_E_ARGUMENT;
    *model = NULL;
    tfa_report own = {0};
    tfa_report *r = report ? report : &own;
    tfa_description *description = NULL;
    int status = tfa_urdf_load(urdf_path, &description, r);
    if (status == TFA_OK)
        status = tfa_model_create(description, options, r, model);
    tfa_description_free(description);
    tfa_report_free(&own);
    return status;
}

void tfa_model_free(tfa_model *model)
{
    free(model);
}

const char *tfa_model_name(const tfa_model *model)
{
    return model->name;
}

const uint8_t *tfa_model_hash(const tfa_model *model)
{
    return model->hash;
}

const char *tfa_model_hash_text(const tfa_model *model)
{
    return model->hash_text;
}

tfa_model_summary tfa_model_summarise(const tfa_model *model)
{
    return model->summary;
}

uint32_t tfa_model_q_count(const tfa_model *model)
{
    return model->q_count;
}

uint32_t tfa_model_v_count(const tfa_model *model)
{
    return model->v_count;
}

uint32_t tfa_model_base_freedoms(const tfa_model *model)
{
    return model->base_freedoms;
}

uint32_t tfa_model_joint_count(const tfa_model *model)
{
    return model->joints;
}

tfa_joint_info tfa_model_joint(const tfa_model *model, uint32_t joint)
{
    return joint < model->joints ? model->joint[joint] : (tfa_joint_info){0};
}

int32_t tfa_model_find_joint(const tfa_model *model, const char *name)
{
    for (uint32_t k = 0; k < model->joints; k++)
        if (strcmp(model->joint[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

uint32_t tfa_model_frame_count(const tfa_model *model)
{
    return model->frames;
}

tfa_frame_info tfa_model_frame(const tfa_model *model, uint32_t frame)
{
    if (frame >= model->frames)
        return (tfa_frame_info){NULL, -1};
    return (tfa_frame_info){model->frame[frame].name, model->frame[frame].body};
}

int32_t tfa_model_find_frame(const tfa_model *model, const char *name)
{
    for (uint32_t k = 0; k < model->frames; k++)
        if (strcmp(model->frame[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

const char *tfa_model_body_name(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body_info[body].name : "";
}

uint32_t tfa_model_body_frame(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body[body].link : 0;
}

int32_t tfa_model_body_parent(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body[body].parent : -1;
}
