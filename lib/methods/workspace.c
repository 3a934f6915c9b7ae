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

#define SPECTRUM_ENTRIES (36 * TFA_MAX_TIPS * TFA_MAX_TIPS)

struct tfa_workspace {
    const struct tfa_model *model;
    const struct tfa_kernel *kernel;
    struct state *state;
    double *spectrum; /* scratch of the eigenvalues */
};

static tfa_precision precision_of(const tfa_workspace_options *options)
{
    return options ? options->precision : TFA_F64;
}

/* One walk for the size and the pointers. */
static size_t walk(const tfa_model *model, const struct tfa_kernel *kernel, void *memory,
                   struct tfa_workspace **out)
{
    struct arena a = {memory, 0};
    struct tfa_workspace *w = arena_take(&a, 1, sizeof *w), count_only;
    struct tfa_workspace *o = w ? w : &count_only;
    o->spectrum = arena_take(&a, SPECTRUM_ENTRIES, sizeof(double));
    void *state = arena_take(&a, kernel->size(model), 1);
    o->model = model;
    o->kernel = kernel;
    if (w)
        w->state = kernel->init(model, state);
    *out = w;
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    const struct tfa_kernel *kernel = tfa_kernel_select(precision_of(options));
    struct tfa_workspace *none;
    return kernel && model ? walk(model, kernel, NULL, &none) : 0;
}

int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                       const tfa_workspace_options *options, tfa_workspace **workspace)
{
    if (!memory || !model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    const struct tfa_kernel *kernel = tfa_kernel_select(precision_of(options));
    if (!kernel)
        return TFA_E_UNSUPPORTED;
    if (size < tfa_workspace_size(model, options) || (uintptr_t)memory % TFA_ALIGNMENT)
        return TFA_E_MEMORY;
    (void)walk(model, kernel, memory, workspace);
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

int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply)
{
    int status = TFA_OK;
    const int spectrum = request->flags & TFA_WANT_SPECTRUM && request->tip_count &&
                         reply->spectrum && reply->lambda_inv;
    for (uint32_t k = 0; k < request->count; k++) {
        tfa_reply one = *reply;
        tfa_answer answer;
        int s = workspace->kernel->answer(workspace->state, request, k, &one, &answer);
        if (reply->answers)
            reply->answers[k] = answer;
        if (s != TFA_OK && status == TFA_OK) {
            status = reply->status = s;
            reply->field = one.field;
            reply->index = one.index;
            reply->state = k;
        }
        if (s == TFA_OK && spectrum)
            add_spectrum(workspace, request, k, reply);
    }
    return status;
}

const char *tfa_isa_name(void)
{
    const struct tfa_kernel *kernel = tfa_kernel_select(TFA_F64);
    return kernel ? kernel->isa : "none";
}
