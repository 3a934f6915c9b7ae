/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Workspaces in the caller's memory.
 */
#include "engine/form.h"

#include <stdlib.h>
#include <string.h>

#include "dynamics/scan/chain_cut.h"
#include "engine/tuning.h"
#include "layout/schedule_body_lanes.h"
#include "model/arena.h"
#include "model/hash.h"
#include "model/model.h"
#include "specialised/specialised_internal.h"

/* Choices of auto, fallbacks, and methods that need almost no memory */
#define METHODS_ALWAYS                                                                             \
    (TFA_METHOD_BIT(TFA_METHOD_AUTO) | TFA_METHOD_BIT(TFA_METHOD_RNEA) |                           \
     TFA_METHOD_BIT(TFA_METHOD_ABA) | TFA_METHOD_BIT(TFA_METHOD_PROPAGATION) |                     \
     TFA_METHOD_BIT(TFA_METHOD_EFPA) | TFA_METHOD_BIT(TFA_METHOD_PV_OSIMR) |                       \
     TFA_METHOD_BIT(TFA_METHOD_SCAN) | TFA_METHOD_BIT(TFA_METHOD_SCAN_TWO_PASS))

/* Kernels of a workspace. `residual_kernel`: NULL if the precision is that of the factors; `batch`:
 * NULL if states are computed one at a time. */
struct kernel_choice {
    struct tfa_reserved reserved;
    tfa_precision precision;
    const struct tfa_kernel *kernel, *residual_kernel, *batch;
    uint32_t batch_max;
    const struct tfa_segment_lanes_kernel *segment_lanes;
    const struct tfa_body_lanes_kernel *body_lanes;
    const struct tfa_specialised_kernel *specialised;
    double time_ratio;                 /* of the time of a state that body lanes take; 1 without */
    struct tfa_lane_schedule schedule; /* of body lanes */
    int32_t table[TFA_BODY_LANES_BODIES_MAX * TFA_BODY_LANES_MAX];
};

/* Chooses the fastest variant of body lanes, or none if one body after the other is faster. */
static void choose_body_lanes(const tfa_model *model, const struct tfa_backend *backend,
                              struct kernel_choice *out)
{
    double least = model->bodies;
    for (uint32_t k = 0; !model->mimics && k < TFA_BODY_LANES_KERNELS_MAX && backend->body_lanes[k];
         k++) {
        const struct tfa_body_lanes_kernel *body_lanes = backend->body_lanes[k];
        const struct tfa_lane_schedule p =
            tfa_schedule_body_lanes(model, body_lanes->lanes, out->table);
        if (p.steps && p.steps * body_lanes->step < least) {
            least = p.steps * body_lanes->step;
            out->body_lanes = body_lanes;
        }
    }
    if (!out->body_lanes)
        return;
    out->time_ratio = least / model->bodies;
    out->schedule = tfa_schedule_body_lanes(model, out->body_lanes->lanes, out->table);
}

/* Methods to reserve memory for; with mimics auto takes crba. */
static uint32_t reserved_methods(const tfa_model *model, uint32_t wanted)
{
    uint32_t methods = wanted | METHODS_ALWAYS;
    if (!wanted && model->bodies <= TFA_RESERVE_ALL_BODIES_MAX)
        methods = TFA_METHODS_ALL;
    for (uint32_t k = 0; model->modes && tfa_method_describe(k); k++)
        if (tfa_method_describe(k)->refuses & TFA_REFUSES_MODES)
            methods &= ~TFA_METHOD_BIT(k);
    if (model->mimics)
        methods |= TFA_METHOD_BIT(TFA_METHOD_CRBA);
    if (model->mass_entries > TFA_MASS_ENTRIES_MAX)
        methods &= ~TFA_METHOD_BIT(TFA_METHOD_CRBA);
    return methods;
}

/* Strategies for one state in double precision throughout */
static void choose_doubles(const tfa_model *model, const struct tfa_backend *backend,
                           struct kernel_choice *out)
{
    choose_body_lanes(model, backend, out);
    if (tfa_cut_segments(model).count)
        out->segment_lanes = backend->segment_lanes;
}

/* The specialised kernel has code for doubles and for batches of floats, not for both together. */
static const struct tfa_specialised_kernel *choose_specialised(const tfa_workspace_options *o,
                                                               int mixed)
{
    if (!o->specialised || mixed || o->precision == TFA_F128)
        return NULL;
    const struct tfa_specialised_kernel *kernel = o->specialised->kernel;
    return o->precision == TFA_F64 || kernel->lanes_f32 ? kernel : NULL;
}

/* Chooses the batch kernel: always for floats; for doubles if the robot is small and the precision
 * not mixed. */
static void choose_batch(const tfa_model *model, const struct tfa_backend *backend,
                         const tfa_workspace_options *o, struct kernel_choice *out)
{
    const int floats = o->precision == TFA_F32;
    const int several = !out->residual_kernel && o->states == TFA_STATES_AUTO;
    if (floats)
        out->batch = backend->batch_f32;
    else if (several && o->precision == TFA_F64 && model->bodies <= TFA_BATCH_BODIES_MAX)
        out->batch = backend->batch_f64;
    if (out->batch)
        out->batch_max = several ? out->batch->lanes : 1;
}

/* Returns 0 if a precision does not exist or the residual's is the lower one. */
static int choose_kernels(const tfa_model *model, const tfa_workspace_options *options,
                          struct kernel_choice *out)
{
    static const tfa_workspace_options defaults;
    const tfa_workspace_options *o = options ? options : &defaults;
    const struct tfa_backend *backend = tfa_backend_select();
    const tfa_precision residual = o->residual == TFA_RESIDUAL_F64    ? TFA_F64
                                   : o->residual == TFA_RESIDUAL_F128 ? TFA_F128
                                                                      : o->precision;
    const int narrower = o->precision == TFA_F128 && residual == TFA_F64;
    const uint32_t tips = o->max_tips ? o->max_tips : TFA_DEFAULT_TIPS;
    if (!backend || narrower || tips > TFA_MAX_TIPS || (uint32_t)o->residual > TFA_RESIDUAL_F128 ||
        (uint32_t)o->precision > TFA_F32)
        return 0;
    *out = (struct kernel_choice){.reserved = {reserved_methods(model, o->methods), tips},
                                  .precision = o->precision,
                                  .kernel = o->precision == TFA_F128 ? &tfa_kernel_f128_base
                                                                     : backend->f64,
                                  .time_ratio = 1};
    if (residual != o->precision)
        out->residual_kernel = residual == TFA_F128 ? &tfa_kernel_f128_base : backend->f64;
    if (o->precision == TFA_F32 && out->residual_kernel)
        out->kernel = out->residual_kernel;
    choose_batch(model, backend, o, out);
    if (model->modes)
        return 1; /* the others are for rigid links */
    if (o->precision == TFA_F64 && !out->residual_kernel)
        choose_doubles(model, backend, out);
    out->specialised = choose_specialised(o, out->residual_kernel != NULL);
    return 1;
}

/* Sets everything that needs no memory. */
static void describe(const tfa_model *model, const struct kernel_choice *c, struct tfa_workspace *o)
{
    *o = (struct tfa_workspace){
        .model = model,
        .reserved = c->reserved,
        .precision = c->precision,
        .kernel = c->kernel,
        .residual_kernel = {c->residual_kernel, NULL},
        .batch = c->batch,
        .batch_max = c->batch_max,
        .batch_min = c->precision == TFA_F32 ? 1 : TFA_BATCH_STATES_MIN,
        .batch_min_body_lanes = (uint32_t)(TFA_BATCH_TIME_RATIO / c->time_ratio) + 1,
        .body_lanes = c->body_lanes,
        .body_lanes_min_bodies =
            (uint32_t)(c->time_ratio * model->bodies) + 1, /* that body lanes are worth */
        .segment_lanes = c->segment_lanes,
        .specialised = c->specialised,
        .host = specialised_host_api(model),
    };
    if (c->batch && o->batch_min_body_lanes > c->batch->lanes)
        o->batch_min_body_lanes = c->batch->lanes; /* full vectors always pay */
    if (o->batch_min_body_lanes < o->batch_min)
        o->batch_min_body_lanes = o->batch_min;
    o->strategies = tfa_strategies_of(o, o->strategy);
}

/* One walk for the size and the pointers. */
static size_t layout(const tfa_model *model, const struct kernel_choice *c, void *memory,
                     struct tfa_workspace **out)
{
    struct arena a = {memory, 0};
    const int shared = c->residual_kernel == c->kernel; /* one state serves both */
    struct tfa_workspace *w = arena_alloc(&a, 1, sizeof *w);
    const size_t entries = (size_t)36 * c->reserved.tips * c->reserved.tips;
    double *spectrum = arena_alloc(&a, entries, sizeof(double));
    struct tfa_last *last = arena_alloc(&a, TFA_OP_LAST + 1, sizeof *last);
    double *loop = arena_alloc(&a, 2 * (6 + (size_t)model->v_count), sizeof(double));
    void *state = arena_alloc(&a, c->kernel->size(model, c->reserved), 1);
    void *residual_kernel = arena_alloc(
        &a, c->residual_kernel && !shared ? c->residual_kernel->size(model, c->reserved) : 0, 1);
    void *body_lanes_state =
        arena_alloc(&a, c->body_lanes ? c->body_lanes->size(model, &c->schedule) : 0, 1);
    void *batch_state = arena_alloc(&a, c->batch ? c->batch->size(model, c->reserved) : 0, 1);
    void *segment_lanes =
        arena_alloc(&a, c->segment_lanes ? c->segment_lanes->size(model, c->kernel) : 0, 1);
    *out = w;
    if (!w)
        return a.used;
    describe(model, c, w);
    w->last = last;
    memset(last, 0, (TFA_OP_LAST + 1) * sizeof *last);
    w->loop = loop;
    w->spectrum = spectrum;
    memset(spectrum, 0, entries * sizeof(double)); /* pages are there before the first request */
    w->state = c->kernel->init(model, c->reserved, state);
    if (c->body_lanes) {
        w->body_lanes_state = c->body_lanes->init(model, &c->schedule, body_lanes_state);
        w->factors = c->kernel->factor_buffers(w->state);
    }
    if (c->batch)
        w->batch_state = c->batch->init(model, c->reserved, batch_state);
    if (c->segment_lanes)
        w->segment_lanes_state = c->segment_lanes->init(model, c->kernel, segment_lanes);
    if (c->residual_kernel)
        w->residual_kernel.state =
            shared ? w->state : c->residual_kernel->init(model, c->reserved, residual_kernel);
    if (c->residual_kernel && c->precision == TFA_F32)
        c->batch->set_residual_kernel(w->batch_state, &w->residual_kernel);
    else if (c->residual_kernel)
        c->kernel->set_residual_kernel(w->state, &w->residual_kernel);
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    struct tfa_workspace *none;
    struct kernel_choice c;
    return model && choose_kernels(model, options, &c) ? layout(model, &c, NULL, &none) : 0;
}

/* 1: the specialised kernel has the constants of this model */
static int is_kernel_of(const tfa_model *model, const tfa_workspace_options *o)
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
    struct kernel_choice c;
    if (!is_kernel_of(model, options))
        return TFA_E_ARGUMENT;
    if (!choose_kernels(model, options, &c))
        return TFA_E_UNSUPPORTED;
    if (size < tfa_workspace_size(model, options) || (uintptr_t)memory % TFA_ALIGNMENT)
        return TFA_E_MEMORY;
    (void)layout(model, &c, memory, workspace);
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

void tfa_workspace_set_executor(tfa_workspace *w, struct tfa_executor *executor)
{
    w->executor = executor;
    w->kernel->set_executor(w->state, executor);
    if (w->residual_kernel.kernel)
        w->residual_kernel.kernel->set_executor(w->residual_kernel.state, executor);
}

uint32_t tfa_workspace_methods(const tfa_workspace *workspace)
{
    return workspace->reserved.methods;
}

uint32_t tfa_workspace_max_tips(const tfa_workspace *workspace)
{
    return workspace->reserved.tips;
}
