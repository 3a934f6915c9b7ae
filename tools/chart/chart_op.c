/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ops of the chart: forward dynamics, and Lambda^-1 of one link.
 */
#include "chart.h"

const tfa_op chart_ops[CHART_OP_COUNT] = {
#define CHART_OP_OP(name, word, op, what) op,
    CHART_OP_LIST(CHART_OP_OP)
#undef CHART_OP_OP
};

/* M has 16384 entries at most: the dense solution takes a second in quadruple precision. */
#define DENSE_BODIES_MAX 128

/* Moving bodies on the way from a body to the base */
static uint32_t depth_of(const tfa_model *model, int32_t body)
{
    uint32_t depth = 0;
    for (; body >= 0; body = tfa_model_body_parent(model, (uint32_t)body))
        depth++;
    return depth;
}

uint32_t chart_find_tip(const tfa_model *model, const char *link)
{
    const int32_t named = link ? tfa_model_find_frame(model, link) : -1;
    uint32_t deepest = 0, most = 0;
    const uint32_t bodies = tfa_model_summarise(model).bodies;
    for (uint32_t body = 0; named < 0 && body < bodies; body++) {
        const uint32_t depth = depth_of(model, (int32_t)body);
        if (depth > most) {
            most = depth;
            deepest = body;
        }
    }
    return named >= 0 ? (uint32_t)named : tfa_model_body_frame(model, deepest);
}

tfa_method chart_exact_method(chart_op op, uint32_t bodies)
{
    if (op == CHART_FORWARD)
        return TFA_METHOD_ABA;
    return bodies <= DENSE_BODIES_MAX ? TFA_METHOD_CRBA : TFA_METHOD_PROPAGATION;
}
