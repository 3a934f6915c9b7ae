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
    struct tfa_wider wider; /* of the residual; no kernel: that of the factors */
    double *spectrum;       /* scratch of the eigenvalues */
};

/* Whose arithmetic is used. The wider kernel is NULL where it would be the same. */
struct choice {
    const struct tfa_kernel *kernel, *wider;
};

/* Returns 0 when the precisions are not there or the residual's is the narrower one. */
static int choose(const tfa_workspace_options *options, struct choice *out)
{
    static const tfa_workspace_options defaults;
    const tfa_workspace_options *o = options ? options : &defaults;
    const tfa_precision residual = o->residual == TFA_RESIDUAL_F64    ? TFA_F64
                                   : o->residual == TFA_RESIDUAL_F128 ? TFA_F128
                                                                      : o->precision;
    const int narrower = o->precision == TFA_F128 && residual == TFA_F64;
    *out = (struct choice){tfa_kernel_select(o->precision), NULL};
    if (residual != o->precision)
        out->wider = tfa_kernel_select(residual);
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
    o->model = model;
    o->kernel = c->kernel;
    o->wider = (struct tfa_wider){c->wider, NULL};
    if (w)
        w->state = c->kernel->init(model, state);
    if (w && c->wider) {
        w->wider.state = c->wider->init(model, wider);
        c->kernel->widen(w->state, &w->wider);
    }
    *out = w;
    return a.used;
}

size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options)
{
    struct tfa_workspace *none;
    struct choice c;
    return model && choose(options, &c) ? walk(model, &c, NULL, &none) : 0;
}

int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                       const tfa_workspace_options *options, tfa_workspace **workspace)
{
    if (!memory || !model || !workspace)
        return TFA_E_ARGUMENT;
    *workspace = NULL;
    struct choice c;
    if (!choose(options, &c))
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

static void add_spectrum(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const uint32_t n = 6 * r->tip_count;
    const double *lambda = reply->lambda_inv + (size_t)n * n * k;
    reply->spectrum[k] = tfa_spectrum_of(lambda, n, w->spectrum);
}

/* ---- factors in one arithmetic, residuals in another ---- */

static int answer_wider(tfa_workspace *w, const tfa_request *r, uint32_t k, tfa_reply *reply,
                        tfa_answer *answer)
{
    return w->wider.kernel->answer(w->wider.state, r, k, reply, answer);
}

/* Accelerations by refined factors; what is in doubt then, or was refused, by the wider kernel. */
static int answer_forward_mixed(tfa_workspace *w, const tfa_request *r, uint32_t k,
                                tfa_reply *reply, tfa_answer *answer)
{
    tfa_request part = *r;
    tfa_reply untouched = *reply;
    part.tip_count = 0;
    part.flags &= ~TFA_WANT_POSES;
    const int status = w->kernel->answer(w->state, &part, k, reply, answer);
    if (status == TFA_OK && !(answer->flags & TFA_ANSWER_WIDER))
        return status;
    uint16_t reasons = (answer->flags & (uint16_t)~TFA_ANSWER_ESTIMATED) | TFA_ANSWER_WIDER;
    if (status == TFA_E_NOT_COMPUTED)
        reasons |= TFA_ANSWER_FALLBACK | TFA_ANSWER_NOT_FINITE;
    part.method = reasons & TFA_ANSWER_FALLBACK ? TFA_METHOD_AUTO : r->method;
    *reply = untouched;
    const int last = answer_wider(w, &part, k, reply, answer);
    answer->flags |= reasons;
    return last;
}

static __attribute__((noinline)) int answer_mixed(tfa_workspace *w, const tfa_request *r,
                                                  uint32_t k, tfa_reply *reply, tfa_answer *answer)
{
    if (r->op != TFA_OP_FORWARD_DYNAMICS || r->hold != TFA_HOLD_NONE)
        return answer_wider(w, r, k, reply, answer);
    const int status = answer_forward_mixed(w, r, k, reply, answer);
    if (status != TFA_OK || !r->tip_count)
        return status;
    tfa_answer tips;
    tfa_request part = *r;
    part.op = TFA_OP_OPERATIONAL_INERTIA;
    part.method = TFA_METHOD_AUTO;
    part.refine = TFA_REFINE_DEFAULT;
    part.estimate = TFA_ESTIMATE_NEVER;
    return answer_wider(w, &part, k, reply, &tips);
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
        int s = workspace->wider.kernel
                    ? answer_mixed(workspace, request, k, &one, &answer)
                    : workspace->kernel->answer(workspace->state, request, k, &one, &answer);
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
