/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * PROTO
 */
#include "kernel/kernel.h"
#include "kernel/lambda.h"
#include "kernel/scan.h"

int osim_least __attribute__((weak)) = 6;

static uint32_t outermost(const struct state *s, const struct tip_wrenches *w, int32_t *body,
                          int32_t *next)
{
    uint32_t group = 0;
    *body = *next = -1;
    for (uint32_t t = 0; t < s->tips; t++)
        if (w[t].body > *body) {
            *next = *body;
            *body = w[t].body;
            group = 1u << t;
        } else if (w[t].body == *body) {
            group |= 1u << t;
        } else if (w[t].body > *next) {
            *next = w[t].body;
        }
    return group;
}

static int32_t stretch_element(const struct state *s, int32_t i, int32_t end, num *A, num *C)
{
    svec P[6];
    for (int e = 0; e < 6; e++) {
        P[e] = sv_zero();
        sv_put(&P[e], e, 1);
    }
    for (int e = 0; e < 36; e++)
        C[e] = 0;
    for (; i > end; i = s->body[i].parent) {
        num psi[6][6], phi[6][6];
        TFA_V(propagate)(s, i, 6, P, psi, phi);
        for (uint32_t k = 0; k < s->body[i].n; k++)
            scan_add_response(C, psi[k], phi[k]);
    }
    for (int e = 0; e < 6; e++) {
        sv_store(A + 6 * e, P[e]);
        for (int f = 0; f < e; f++)
            C[6 * e + f] = C[6 * f + e];
    }
    return i;
}

void TFA_V(lambda_osim)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w[TFA_MAX_TIPS];
    int32_t body, next;
    uint32_t group;
    TFA_V(lambda_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++)
        TFA_V(tip_start)(s, t, frame, &w[t]);
    for (;;) {
        group = outermost(s, w, &body, &next);
        if (body < 0)
            break;
        uint32_t freedoms = 0;
        for (int32_t i = body; i > next; i = s->body[i].parent)
            freedoms += s->body[i].n;
        int parts = 0;
        for (uint32_t t = 0; t < s->tips; t++)
            parts |= group >> t & 1 && w[t].moved < s->body[body].n;
        if (!(group & (group - 1)) || parts || freedoms < (uint32_t)osim_least) {
            for (uint32_t t = 0; t < s->tips; t++)
                while (group >> t & 1 && w[t].body > (parts ? body - 1 : next))
                    TFA_V(tip_pass)(s, t, &w[t]);
            continue;
        }
        num A[36], C[36];
        const int32_t end = stretch_element(s, body, next, A, C);
        TFA_V(tips_cross)(s, group, w, A, C);
        for (uint32_t t = 0; t < s->tips; t++)
            if (group >> t & 1) {
                w[t].body = end;
                w[t].moved = 6;
            }
    }
    TFA_V(lambda_joints)(s);
    TFA_V(lambda_mirror)(s);
}
