/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The noun that computes: a workspace in the caller's memory.
 */
#include "methods/strategy.h"

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

/* The kernels of a workspace. `wider` is NULL where it would be the same as `kernel` or as the factors',
 * `batch` where states go one by one. */
struct choice {
    uint32_t methods;
    tfa_precision precision;
    const struct tfa_kernel *kernel, *wider, *batch;
    uint32_t batch_max;
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
static void choose_limbs(const tfa_model *model, const struct tfa_backend *backend,
                         struct choice *out)
{
    double least = model->bodies;
    for (uint32_t k = 0; !model->mimics && k < TFA_LIMBS_MAX && backend->limbs[k]; k++) {
        const struct tfa_limbs *limbs = backend->limbs[k];
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

/* Methods that there is to be room for. With mimics auto takes crba. */
static uint32_t reserved_methods(const tfa_model *model, uint32_t wanted)
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

/* Doubles throughout: the ways of one state through several lanes. */
static void choose_doubles(const tfa_model *model, const struct tfa_backend *backend,
                           const tfa_workspace_options *o, struct choice *out)
{
    const uint32_t cyclic = TFA_METHOD_BIT(TFA_METHOD_TFA_CR) | TFA_METHOD_BIT(TFA_METHOD_CFA_CR);
    choose_limbs(model, backend, out);
    out->own = o->specialised ? o->specialised->kernel : NULL;
    if (out->methods & cyclic && backend->pieces->size(model))
        out->pieces = backend->pieces;
    if (tfa_cut_strips(model).count)
        out->strips = backend->strips;
}

/* Floats are those of batches; doubles of batches where the robot is small and nothing is mixed. */
static void choose_batch(const tfa_model *model, const struct tfa_backend *backend,
                         const tfa_workspace_options *o, struct choice *out)
{
    const int floats = o->precision == TFA_F32;
    const int several = !out->wider && o->states == TFA_STATES_AUTO;
    if (floats)
        out->batch = backend->batch_f32;
    else if (several && o->precision == TFA_F64 && model->bodies <= TFA_LANES_BODIES_MAX)
        out->batch = backend->batch_f64;
    if (out->batch)
        out->batch_max = several ? out->batch->lanes : 1;
}

/* Returns 0 when the precisions are not there or the residual's is the narrower one. */
static int choose(const tfa_model *model, const tfa_workspace_options *options, struct choice *out)
{
    static const tfa_workspace_options defaults;
    const tfa_workspace_options *o = options ? options : &defaults;
    const struct tfa_backend *backend = tfa_backend_select();
    const tfa_precision residual = o->residual == TFA_RESIDUAL_F64    ? TFA_F64
                                   : o->residual == TFA_RESIDUAL_F128 ? TFA_F128
                                                                      : o->precision;
    const int narrower = o->precision == TFA_F128 && residual == TFA_F64;
    if (!backend || narrower || (uint32_t)o->residual > TFA_RESIDUAL_F128 ||
        (uint32_t)o->precision > TFA_F32)
        return 0;
    *out =
        (struct choice){.methods = reserved_methods(model, o->methods),
                        .precision = o->precision,
                        .kernel = o->precision == TFA_F128 ? &tfa_kernel_f128_base : backend->f64,
                        .share = 1};
    if (residual != o->precision)
        out->wider = residual == TFA_F128 ? &tfa_kernel_f128_base : backend->f64;
    if (o->precision == TFA_F32 && out->wider)
        out->kernel = out->wider;
    choose_batch(model, backend, o, out);
    if (o->precision == TFA_F64 && !out->wider)
        choose_doubles(model, backend, o, out);
    return 1;
}

/* Everything that is known without memory */
static void describe(const tfa_model *model, const struct choice *c, struct tfa_workspace *o)
{
    *o = (struct tfa_workspace){
        .model = model,
        .methods = c->methods,
        .precision = c->precision,
        .kernel = c->kernel,
        .wider = {c->wider, NULL},
        .batch = c->batch,
        .batch_max = c->batch_max,
        .batch_min = c->precision == TFA_F32 ? 1 : TFA_LANES_STATES_MIN,
        .batch_min_limbs = (uint32_t)(TFA_LANES_STATES_WORTH / c->share) + 1,
        .limbs = c->limbs,
        .limbs_from = (uint32_t)(c->share * model->bodies) + 1, /* that limbs are worth */
        .pieces = c->pieces,
        .strips = c->strips,
        .own = c->own,
        .host = own_host(model),
    };
    if (c->batch && o->batch_min_limbs > c->batch->lanes)
        o->batch_min_limbs = c->batch->lanes; /* full vectors always pay */
    if (o->batch_min_limbs < o->batch_min)
        o->batch_min_limbs = o->batch_min;
    o->strategies = tfa_strategies_of(o, o->strategy);
}

/* One walk for the size and the pointers. */
static size_t walk(const tfa_model *model, const struct choice *c, void *memory,
                   struct tfa_workspace **out)
{
    struct arena a = {memory, 0};
    const int shared = c->wider == c->kernel; /* one state serves both */
    struct tfa_workspace *w = arena_take(&a, 1, sizeof *w);
    double *spectrum = arena_take(&a, SPECTRUM_ENTRIES, sizeof(double));
    void *state = arena_take(&a, c->kernel->size(model, c->methods), 1);
    void *wider = arena_take(&a, c->wider && !shared ? c->wider->size(model, c->methods) : 0, 1);
    void *limb_state = arena_take(&a, c->limbs ? c->limbs->size(model, &c->packing) : 0, 1);
    void *batch_state = arena_take(&a, c->batch ? c->batch->size(model, c->methods) : 0, 1);
    void *piece_state = arena_take(&a, c->pieces ? c->pieces->size(model) : 0, 1);
    void *strips = arena_take(&a, c->strips ? c->strips->size(model, c->kernel) : 0, 1);
    *out = w;
    if (!w)
        return a.used;
    describe(model, c, w);
    w->spectrum = spectrum;
    memset(spectrum, 0,
           SPECTRUM_ENTRIES * sizeof(double)); /* pages are there before the first request */
    w->state = c->kernel->init(model, c->methods, state);
    if (c->limbs) {
        w->limb_state = c->limbs->init(model, &c->packing, limb_state);
        w->factors = c->kernel->lend(w->state);
    }
    if (c->batch)
        w->batch_state = c->batch->init(model, c->methods, batch_state);
    if (c->pieces)
        w->piece_state = c->pieces->init(model, piece_state);
    if (c->strips)
        w->strips_state = c->strips->init(model, c->kernel, strips);
    if (c->wider)
        w->wider.state = shared ? w->state : c->wider->init(model, c->methods, wider);
    if (c->wider && c->precision == TFA_F32)
        c->batch->widen(w->batch_state, &w->wider);
    else if (c->wider)
        c->kernel->widen(w->state, &w->wider);
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
