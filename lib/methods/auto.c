/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What auto takes, by the crossovers of a workspace; the kernels know methods by name only, and
 * their own last resort.
 */
#include "methods/workspace.h"
#include "model/model.h"

uint32_t tfa_longest_chain(const tfa_model *m)
{
    uint32_t longest = 0;
    for (uint32_t t = 0; t < m->trees; t++)
        longest = m->chain[t].length > longest ? m->chain[t].length : longest;
    return longest;
}

/* Numbers of bodies from which the scan pays with as many threads as solve a state */
static void scan_pays_from(const tfa_workspace *w, uint32_t *forward, uint32_t *lambda)
{
    const tfa_crossovers *c = &w->crossovers;
    const uint32_t threads = w->crew ? w->crew->threads : 1;
    *forward = threads >= 4 ? c->scan_from_4 : threads >= 2 ? c->scan_from_2 : c->scan_from_1;
    *lambda = threads >= 4   ? c->lambda_scan_from_4
              : threads >= 2 ? c->lambda_scan_from_2
                             : c->lambda_scan_from_1;
}

/* Is every tip carried by the last body of a main chain? From there the scan reaches the root by
 * segments. */
static int tips_at_ends(const tfa_model *m, const tfa_request *r)
{
    uint32_t found = 0;
    for (uint32_t k = 0; k < r->tip_count; k++)
        for (uint32_t t = 0; t < m->trees; t++)
            found += m->frame[r->tips[k]].body == (int32_t)m->chain[t].body[m->chain[t].length - 1];
    return found == r->tip_count;
}

/* Nothing in the request that the scan refuses. Doubles only: the crossovers were measured there, and
 * a reference has nothing to gain. */
static int scan_takes(const tfa_workspace *w, const tfa_request *r)
{
    return w->kernel->precision == TFA_F64 && !w->wider.kernel && !w->model->mimics &&
           !r->locked_count;
}

static int scan_pays(const tfa_workspace *w, const tfa_request *r, int forward, int lambda)
{
    uint32_t from[2];
    scan_pays_from(w, &from[0], &from[1]);
    return (!forward || w->longest_chain >= from[0]) && (!lambda || w->longest_chain >= from[1]) &&
           scan_takes(w, r) && (!lambda || tips_at_ends(w->model, r));
}

tfa_method tfa_auto_method(const tfa_workspace *w, const tfa_request *r)
{
    const int forward = is_forward(r);
    const int lambda = r->op == TFA_OP_OPERATIONAL_INERTIA || (forward && r->tip_count);
    if (!forward && !lambda)
        return TFA_METHOD_AUTO;
    if (scan_pays(w, r, forward, lambda))
        return TFA_METHOD_SCAN;
    if (!forward && r->tip_count > 1 && r->tip_count < w->crossovers.pv_from && !w->model->mimics)
        return TFA_METHOD_PROPAGATION;
    return TFA_METHOD_AUTO;
}
