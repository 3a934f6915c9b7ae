/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Resolves TFA_METHOD_AUTO by the model and the request. Strategies and kernels only ever see
 * concrete methods.
 */
#include "engine/methods.h"
#include "engine/strategy.h"
#include "engine/tuning.h"

/* 1: the request locks a freedom; fixed joints have none */
static int locks_freedom(const tfa_model *m, const tfa_request *r)
{
    for (uint32_t k = 0; k < r->locked_count; k++)
        if (m->joint[r->locked[k]].v_count)
            return 1;
    return 0;
}

/* With mimics crba: T^T M T is regular wherever the robot can move; M is not where followers have
 * no mass of their own or slide along their leaders. Derivatives need the factors of M anyway. */
static int goes_by_mass_matrix(const tfa_workspace *w, const tfa_request *r, uint32_t traits)
{
    return (w->model->mimics || traits & TRAIT_DERIVATIVES) &&
           w->reserved.methods & TFA_METHOD_BIT(TFA_METHOD_CRBA) && !locks_freedom(w->model, r);
}

/* The segment scan for long chains of revolute joints, in double precision */
static int is_long(const tfa_workspace *w, uint32_t traits)
{
    return w->segment_lanes && w->model->bodies >= TFA_SCAN_BODIES_MIN &&
           !(traits & (TRAITS_SCENE | TRAIT_REFINE));
}

static tfa_method forward_method(const tfa_workspace *w, const tfa_request *r, uint32_t traits)
{
    if (goes_by_mass_matrix(w, r, traits))
        return TFA_METHOD_CRBA;
    return is_long(w, traits) && traits & TRAIT_FD ? TFA_METHOD_SCAN : TFA_METHOD_ABA;
}

/* pv-osimr is never slower for several tips (lambda_pv.c). */
static tfa_method osim_method(const tfa_workspace *w, const tfa_request *r, uint32_t traits)
{
    if (goes_by_mass_matrix(w, r, traits))
        return TFA_METHOD_CRBA;
    const int refined = traits & TRAIT_OSIM && traits & TRAIT_REFINE; /* by columns */
    const int composed =
        traits & TRAIT_SEVERAL_TIPS && !refined && !w->model->mimics && !w->model->modes;
    return composed ? TFA_METHOD_PV_OSIMR : TFA_METHOD_PROPAGATION;
}

struct tfa_resolved tfa_resolve_method(const tfa_workspace *w, const tfa_request *r,
                                       uint32_t traits)
{
    if (r->method != TFA_METHOD_AUTO)
        return (struct tfa_resolved){r->method, r->method};
    if (traits & TFA_OPS_RNEA)
        return (struct tfa_resolved){TFA_METHOD_RNEA, TFA_METHOD_RNEA};
    if (traits & TRAIT_M)
        return (struct tfa_resolved){TFA_METHOD_CRBA, TFA_METHOD_CRBA};
    struct tfa_resolved by = {0};
    if (traits & TRAIT_TIPS)
        by.osim = osim_method(w, r, traits);
    by.method = traits & TRAIT_OSIM ? by.osim : forward_method(w, r, traits);
    return by;
}

/* Sides of active constraints that are on links */
static uint32_t tips_of_constraints(const tfa_model *m, const tfa_request *r)
{
    uint32_t sides = 0;
    for (uint32_t k = 0; k < m->constraints; k++)
        if (r->constraints >> k & 1)
            for (int side = 0; side < 2; side++)
                sides += m->closure[k].frame[side] >= 0 ? 1u : 0;
    return sides;
}

int tfa_reserved_check(const tfa_workspace *w, const tfa_request *r, tfa_reply *reply)
{
    const int whole = r->op == TFA_OP_MASS_MATRIX;
    if (r->tip_count > w->reserved.tips) {
        reply->field = TFA_FIELD_TIPS;
        reply->index = w->reserved.tips;
        return reply->status = TFA_E_UNSUPPORTED;
    }
    if (TFA_OP_BIT(r->op) & TRAITS_CONSTRAINED &&
        tips_of_constraints(w->model, r) > w->reserved.tips) {
        reply->field = TFA_FIELD_CONSTRAINTS;
        reply->index = w->reserved.tips;
        return reply->status = TFA_E_UNSUPPORTED;
    }
    if (w->reserved.methods & TFA_METHOD_BIT(whole ? TFA_METHOD_CRBA : r->method))
        return TFA_OK;
    reply->field = whole ? TFA_FIELD_OP : TFA_FIELD_METHOD;
    reply->index = whole ? 0 : (uint32_t)r->method;
    return reply->status = TFA_E_UNSUPPORTED;
}
