/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The noun that computes: a workspace in the caller's memory.
 */
#include "methods/workspace.h"

#include <stdlib.h>
#include <string.h>

#include "kernel/cut.h"
#include "methods/tuning.h"
#include "model/arena.h"
#include "model/hash.h"
#include "model/model.h"
#include "own/own.h"
#include "plan/limbs.h"

#define SPECTRUM_ENTRIES (36 * TFA_MAX_TIPS * TFA_MAX_TIPS)

/* What auto may take, what takes over where a method fails, and what keeps next to nothing */
#define METHODS_ALWAYS                                                                             \
    (TFA_METHOD_BIT(TFA_METHOD_AUTO) | TFA_METHOD_BIT(TFA_METHOD_RNEA) |                           \
     TFA_METHOD_BIT(TFA_METHOD_ABA) | TFA_METHOD_BIT(TFA_METHOD_PROPAGATION) |                     \
     TFA_METHOD_BIT(TFA_METHOD_EFPA) | TFA_METHOD_BIT(TFA_METHOD_PV_OSIMR) |                       \
     TFA_METHOD_BIT(TFA_METHOD_SCAN) | TFA_METHOD_BIT(TFA_METHOD_SCAN_TWO_PASS))

/* Who answers. The wider kernel is NULL where it would be the same, lanes where states go one by
 * one. */
struct choice {
    uint32_t methods;
    const struct tfa_kernel *kernel, *wider;
    const struct tfa_lanes *lanes;
    const struct tfa_pieces *pieces;
    const struct tfa_strips_kernel *strips;
    const struct tfa_limbs *limbs;
    const struct tfa_own_kernel *own;
    double share;               /* of the time of a state that limbs side by side take; 1 without */
    struct tfa_packing packing; /* of the limbs */
    int32_t table[TFA_LIMBS_BODIES_MAX * TFA_LIMBS_LANES_MAX];
};

/* Limbs side by side, with the variant that takes the least time for a state; or nothing, where one
 * body after the other takes less. */
static void choose_limbs(const tfa_model *model, struct choice *out)
{
    const struct tfa_limbs *limbs;
    double least = model->bodies;
    for (uint32_t k = 0; !model->mimics && (limbs = tfa_limbs_select(k)); k++) {
        const struct tfa_packing p = tfa_limbs_pack(model, limbs->lanes, out->table);
        if (p.steps && p.steps * limbs->step < least) {
            least = p.steps * limbs->step;
            out->limbs = limbs;
        }
    }
    if (!out->limbs)
        return;
    out->share = least / model->bodies;
    out->packing = tfa_limbs_pack(model, out->limbs->lanes, out->table);
}

/* Long chains go in pieces where the arithmetic is double throughout. */
static const struct tfa_pieces *choose_pieces(const tfa_model *model)
{
    const struct tfa_pieces *pieces = tfa_pieces_select();
    return pieces && pieces->size(model) ? pieces : NULL;
}

/* Methods that there is to be room for. With mimics auto takes crba. */
static uint32_t room(const tfa_model *model, uint32_t wanted)
{
    uint32_t methods = wanted | METHODS_ALWAYS;
    if (!wanted && model->bodies <= TFA_ROOM_BODIES_MAX)
        methods = TFA_METHODS_ALL;
    if (model->mimics)
        methods |= TFA_METHOD_BIT(TFA_METHOD_CRBA);
    if (model->mass_entries > TFA_MASS_ENTRIES_MAX)
        methods &= ~TFA_METHOD_BIT(TFA_METHOD_CRBA);
    return methods;
}

/* Returns 0 when the precisions are not there or the residual's is the narrower one. */
static int choose(const tfa_model *model, const tfa_workspace_options *options, struct choice *out)
{
    static const tfa_workspace_options defaults;
    const tfa_workspace_options *o = options ? options : &defaults;
    const tfa_precision residual = o->residual == TFA_RESIDUAL_F64    ? TFA_F64
                                   : o->residual == TFA_RESIDUAL_F128 ? TFA_F128
                                                                      : o->precision;
    const int narrower = o->precision == TFA_F128 && residual == TFA_F64;
    *out = (struct choice){
        .methods = room(model, o->methods), .kernel = tfa_kernel_select(o->precision), .share = 1};
    if (residual != o->precision)
        out->wider = tfa_kernel_select(residual);
    else if (o->states == TFA_STATES_AUTO && model->bodies <= TFA_LANES_BODIES_MAX)
        out->lanes = tfa_lanes_select(o->precision);
    if (residual == o->precision && o->precision == TFA_F64) {
        choose_limbs(model, out);
        out->own = o->specialised ? o->specialised->kernel : NULL;
        if (out->methods & (TFA_METHOD_BIT(TFA_METHOD_TFA_CR) | TFA_METHOD_BIT(TFA_METHOD_CFA_CR)))
            out->pieces = choose_pieces(model);
        if (tfa_cut_strips(model).count)
            out->strips = tfa_strips_select();
    }
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
    void *state = arena_take(&a, c->kernel->size(model, c->methods), 1);
    void *wider = arena_take(&a, c->wider ? c->wider->size(model, c->methods) : 0, 1);
    void *limb_state = arena_take(&a, c->limbs ? c->limbs->size(model, &c->packing) : 0, 1);
    void *lane_state = arena_take(&a, c->lanes ? c->lanes->size(model, c->methods) : 0, 1);
    void *piece_state = arena_take(&a, c->pieces ? c->pieces->size(model) : 0, 1);
    void *strips = arena_take(&a, c->strips ? c->strips->size(model, c->kernel) : 0, 1);
    o->model = model;
    o->methods = c->methods;
    o->kernel = c->kernel;
    o->lanes = c->lanes;
    o->lanes_from = (uint32_t)(TFA_LANES_STATES_WORTH / c->share) + 1;
    if (c->lanes && o->lanes_from > c->lanes->lanes)
        o->lanes_from = c->lanes->lanes; /* full vectors always pay */
    o->limbs = c->limbs;
    o->limbs_from = (uint32_t)(c->share * model->bodies) + 1; /* that limbs are worth */
    o->pieces = c->pieces;
    o->strips = c->strips;
    o->own = c->own;
    o->host = own_host(model);
    o->crew = NULL;
    o->wider = (struct tfa_wider){c->wider, NULL};
    if (w) /* every page is there before the first request */
        memset(o->spectrum, 0, SPECTRUM_ENTRIES * sizeof(double));
    if (w)
        w->state = c->kernel->init(model, c->methods, state);
    if (w && c->wider) {
        w->wider.state = c->wider->init(model, c->methods, wider);
        c->kernel->widen(w->state, &w->wider);
    }
    if (w && c->limbs)
        w->limb_state = c->limbs->init(model, &c->packing, limb_state);
    if (w && c->limbs)
        w->factors = c->kernel->lend(w->state);
    if (w && c->lanes)
        w->lane_state = c->lanes->init(model, c->methods, lane_state);
    if (w && c->pieces)
        w->piece_state = c->pieces->init(model, piece_state);
    if (w && c->strips)
        w->strips_state = c->strips->init(model, c->kernel, strips);
    *out = w;
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    struct tfa_workspace *none;
    struct choice c;
    return model && choose(model, options, &c) ? walk(model, &c, NULL, &none) : 0;
}

/* A kernel with the constants of another model would answer, and be wrong. */
static int fits(const tfa_model *model, const tfa_workspace_options *o)
{
    uint8_t hash[32];
    if (!o || !o->specialised)
        return 1;
    tfa_hash_without_gravity(model, hash);
    return memcmp(o->specialised->kernel->model, hash, sizeof hash) == 0;
}

int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                       const tfa_workspace_options *options, tfa_workspace **workspace)
{
    if (!memory || !model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    struct choice c;
    if (!fits(model, options))
        return TFA_E_ARGUMENT;
    if (!choose(model, options, &c))
        return TFA_E_UNSUPPORTED;
    if (size < tfa_workspace_size(model, options) || (uintptr_t)memory % TFA_ALIGNMENT)
        return TFA_E_MEMORY;
    (void)walk(model, &c, memory, workspace);
    if (options && options->round_sincos)
        c.kernel->round_sincos((*workspace)->state);
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
    const int status = tfa_workspace_init(memory, size, model, options, workspace);
    if (status != TFA_OK)
        free(memory);
    return status;
}

void tfa_workspace_free(tfa_workspace *workspace)
{
    free(workspace);
}

void tfa_workspace_employ(tfa_workspace *w, struct tfa_crew *crew)
{
    w->crew = crew;
    w->kernel->employ(w->state, crew);
    if (w->wider.kernel)
        w->wider.kernel->employ(w->wider.state, crew);
}

uint32_t tfa_workspace_methods(const tfa_workspace *workspace)
{
    return workspace->methods;
}

const char *tfa_isa_name(void)
{
    const struct tfa_kernel *kernel = tfa_kernel_select(TFA_F64);
    return kernel ? kernel->isa : "none";
}
