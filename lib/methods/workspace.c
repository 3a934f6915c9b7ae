/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The noun that computes: a workspace in the caller's memory.
 */
#include "methods/workspace.h"

#include <stdlib.h>

#include "model/arena.h"
#include "model/model.h"

/* Robots with more bodies have no room for several states unless it is asked for: 40 KB a body. */
#define LANES_BODIES_MAX 128

#define SPECTRUM_ENTRIES (36 * TFA_MAX_TIPS * TFA_MAX_TIPS)

/* Who answers. The wider kernel is NULL where it would be the same, lanes where states go one by
 * one. */
struct choice {
    const struct tfa_kernel *kernel, *wider;
    const struct tfa_lanes *lanes;
};

/* Returns 0 when the precisions are not there or the residual's is the narrower one. */
static int choose(const tfa_model *model, const tfa_workspace_options *options, struct choice *out)
{
    static const tfa_workspace_options defaults;
    const tfa_workspace_options *o = options ? options : &defaults;
    const tfa_precision residual = o->residual == TFA_RESIDUAL_F64    ? TFA_F64
                                   : o->residual == TFA_RESIDUAL_F128 ? TFA_F128
                                                                      : o->precision;
    const int narrower = o->precision == TFA_F128 && residual == TFA_F64;
    *out = (struct choice){tfa_kernel_select(o->precision), NULL, NULL};
    if (residual != o->precision)
        out->wider = tfa_kernel_select(residual);
    else if (o->precision == TFA_F64 && o->states == TFA_STATES_AUTO && !model->mimics &&
             model->bodies <= LANES_BODIES_MAX)
        out->lanes = tfa_lanes_select();
    return out->kernel && !narrower && (uint32_t)o->residual <= TFA_RESIDUAL_F128;
}

/* One walk for the size and the pointers. */
static size_t walk(const tfa_model *model, const struct choice *c, void *memory,
                   struct tfa_workspace **out)
{
    struct arena a = {memory, 0};
    struct tfa_workspace *w = arena_take(&a, 1, sizeof *w), count_only;
    struct tfa_workspace *o = w ? w : &count_only;
    o->spectrum = arena_take(&a, SPECTRUM_ENTRIES, sizeof(double));
    void *state = arena_take(&a, c->kernel->size(model), 1);
    void *wider = arena_take(&a, c->wider ? c->wider->size(model) : 0, 1);
    void *lane_state = arena_take(&a, c->lanes ? c->lanes->size(model) : 0, 1);
    o->model = model;
    o->kernel = c->kernel;
    o->lanes = c->lanes;
    o->wider = (struct tfa_wider){c->wider, NULL};
    if (w)
        w->state = c->kernel->init(model, state);
    if (w && c->wider) {
        w->wider.state = c->wider->init(model, wider);
        c->kernel->widen(w->state, &w->wider);
    }
    if (w && c->lanes)
        w->lane_state = c->lanes->init(model, lane_state);
    *out = w;
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    struct tfa_workspace *none;
    struct choice c;
    return model && choose(model, options, &c) ? walk(model, &c, NULL, &none) : 0;
}

int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                       const tfa_workspace_options *options, tfa_workspace **workspace)
{
    if (!memory || !model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    struct choice c;
    if (!choose(model, options, &c))
        return TFA_E_UNSUPPORTED;
    if (size < tfa_workspace_size(model, options) || (uintptr_t)memory % TFA_ALIGNMENT)
        return TFA_E_MEMORY;
    (void)walk(model, &c, memory, workspace);
    return TFA_OK;
}

int tfa_workspace_create(const tfa_model *model, const tfa_workspace_options *options,
                         tfa_workspace **workspace)
{
    if (!model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    size_t size = tfa_workspace_size(model, options);
    if (!size)
        return TFA_E_UNSUPPORTED;
    void *memory = aligned_alloc(TFA_ALIGNMENT, size);
    if (!memory)
        return TFA_E_MEMORY;
    return tfa_workspace_init(memory, size, model, options, workspace);
}

void tfa_workspace_free(tfa_workspace *workspace)
{
    free(workspace);
}

const char *tfa_isa_name(void)
{
    const struct tfa_kernel *kernel = tfa_kernel_select(TFA_F64);
    return kernel ? kernel->isa : "none";
}
