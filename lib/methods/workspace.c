/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The noun that computes: a workspace in the caller's memory, and tfa_compute.
 */
#include <math.h>
#include <stdlib.h>

#include "kernel/table.h"
#include "methods/methods.h"
#include "model/arena.h"
#include "model/model.h"

/* Robots with more bodies have no room for several states unless it is asked for: 40 KB a body. */
#define WIDE_BODIES_MAX 128

/* Fewer states go one at a time: eight lanes take as long as 1.5 states of a 7-joint arm (measured
 * 2026-11-22, Intel Xeon with AVX-512). */
#define WIDE_STATES_MIN 2

#define SPECTRUM_ENTRIES (36 * TFA_MAX_TIPS * TFA_MAX_TIPS)

struct tfa_workspace {
    const struct tfa_model *model;
    const struct tfa_kernel *kernel;
    struct state *state;
    const struct tfa_lanes *lanes; /* NULL: one state at a time */
    struct state *wide;
    double *spectrum; /* scratch of the eigenvalues */
};

static tfa_precision precision_of(const tfa_workspace_options *options)
{
    return options ? options->precision : TFA_F64;
}

/* Who answers: for one state, and for several where it pays. */
struct choice {
    const struct tfa_kernel *kernel;
    const struct tfa_lanes *lanes;
};

static struct choice choose(const tfa_model *model, const tfa_workspace_options *options)
{
    struct choice c = {tfa_kernel_select(precision_of(options)), NULL};
    const int one = options && options->states == TFA_STATES_ONE;
    if (model && precision_of(options) == TFA_F64 && !one && !model->mimics &&
        model->bodies <= WIDE_BODIES_MAX)
        c.lanes = tfa_lanes_select();
    return c;
}

/* One walk for the size and the pointers. */
static size_t walk(const tfa_model *model, struct choice c, void *memory,
                   struct tfa_workspace **out)
{
    struct arena a = {memory, 0};
    struct tfa_workspace *w = arena_take(&a, 1, sizeof *w), count_only;
    struct tfa_workspace *o = w ? w : &count_only;
    o->spectrum = arena_take(&a, SPECTRUM_ENTRIES, sizeof(double));
    void *state = arena_take(&a, c.kernel->size(model), 1);
    void *wide = arena_take(&a, c.lanes ? c.lanes->size(model) : 0, 1);
    o->model = model;
    o->kernel = c.kernel;
    o->lanes = c.lanes;
    if (w)
        w->state = c.kernel->init(model, state);
    if (w && c.lanes)
        w->wide = c.lanes->init(model, wide);
    *out = w;
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    const struct choice c = choose(model, options);
    struct tfa_workspace *none;
    return c.kernel && model ? walk(model, c, NULL, &none) : 0;
}

int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                       const tfa_workspace_options *options, tfa_workspace **workspace)
{
    if (!memory || !model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    const struct choice c = choose(model, options);
    if (!c.kernel)
        return TFA_E_UNSUPPORTED;
    if (size < tfa_workspace_size(model, options) || (uintptr_t)memory % TFA_ALIGNMENT)
        return TFA_E_MEMORY;
    (void)walk(model, c, memory, workspace);
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

static void add_spectrum(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const uint32_t n = 6 * r->tip_count;
    const double *lambda = reply->lambda_inv + (size_t)n * n * k;
    reply->spectrum[k] = tfa_spectrum_of(lambda, n, w->spectrum);
}

int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    int status = tfa_request_check(workspace->model, request, reply);
    return status == TFA_OK ? tfa_compute_checked(workspace, request, reply) : status;
}

/* May the states of a request go side by side? Forward dynamics and nothing else, by aba. */
static int goes_wide(const tfa_workspace *w, const tfa_request *r)
{
    return w->lanes && r->op == TFA_OP_FORWARD_DYNAMICS &&
           (r->method == TFA_METHOD_AUTO || r->method == TFA_METHOD_ABA) &&
           r->estimate != TFA_ESTIMATE_ALWAYS && r->hold == TFA_HOLD_NONE &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT) && !r->tip_count &&
           !r->wrench_count && !r->payload_count && !r->locked_count;
}

/* As many states from k on as go side by side; 0 where one at a time is better or has to say
 * what is wrong. */
static uint32_t compute_wide(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const uint32_t left = r->count - k;
    const uint32_t count = left < w->lanes->lanes ? left : w->lanes->lanes;
    if (count < WIDE_STATES_MIN || !w->lanes->answer(w->wide, r, k, count, reply))
        return 0;
    for (uint32_t l = 0; reply->answers && l < count; l++)
        reply->answers[k + l] =
            (tfa_answer){.method = TFA_METHOD_ABA, .error_estimate = (double)NAN};
    return count;
}

static int compute_one(tfa_workspace *w, const tfa_request *request, uint32_t k, tfa_reply *reply)
{
    const int spectrum = request->flags & TFA_WANT_SPECTRUM && request->tip_count &&
                         reply->spectrum && reply->lambda_inv;
    tfa_reply one = *reply;
    tfa_answer answer;
    const int status = w->kernel->answer(w->state, request, k, &one, &answer);
    if (reply->answers)
        reply->answers[k] = answer;
    if (status != TFA_OK && reply->status == TFA_OK) {
        reply->status = status;
        reply->field = one.field;
        reply->index = one.index;
        reply->state = k;
    }
    if (status == TFA_OK && spectrum)
        add_spectrum(w, request, k, reply);
    return status;
}

int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    const int wide = goes_wide(workspace, request);
    for (uint32_t k = 0; k < request->count;) {
        uint32_t done = wide ? compute_wide(workspace, request, k, reply) : 0;
        if (!done)
            (void)compute_one(workspace, request, k, reply);
        k += done ? done : 1;
    }
    return reply->status;
}

const char *tfa_isa_name(void)
{
    const struct tfa_kernel *kernel = tfa_kernel_select(TFA_F64);
    return kernel ? kernel->isa : "none";
}
