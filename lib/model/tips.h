/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Trees that carry the tips of a request: the others do not affect quantities of the tips.
 */
#ifndef TFA_MODEL_TIPS_H
#define TFA_MODEL_TIPS_H

#include <totalforce/dynamics.h>

#include "model/model.h"

/* Writes each tree once, in ascending order. Returns how many; tips fixed in the world are in
 * none. */
static inline uint32_t tfa_trees_of_tips(const struct tfa_model *m, const tfa_request *r,
                                         const struct tfa_chain *out[TFA_MAX_TIPS])
{
    uint32_t count = 0;
    for (uint32_t t = 0; t < r->tip_count; t++) {
        const int32_t body = m->frame[r->tips[t]].body;
        const struct tfa_chain *tree = m->chain;
        if (body < 0)
            continue;
        while (body >= (int32_t)tree->end)
            tree++;
        uint32_t at = count;
        while (at > 0 && out[at - 1] > tree)
            at--;
        if (at > 0 && out[at - 1] == tree)
            continue;
        for (uint32_t k = count++; k > at; k--)
            out[k] = out[k - 1];
        out[at] = tree;
    }
    return count;
}

#endif
