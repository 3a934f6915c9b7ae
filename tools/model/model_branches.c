/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Side branches that are long beside their main chain.
 */
#include "model_report.h"

#include <stdlib.h>

typedef struct place {
    uint32_t root, deepest; /* of its tree; of a root: the body at the end of its main chain */
    uint32_t depth;
    uint32_t branch, length; /* its branch's first body, and bodies from there to it */
    bool on_chain;
} place;

/* Bodies stand after their parents. */
static void find_chains(const tfa_model *model, uint32_t bodies, place *at)
{
    for (uint32_t i = 0; i < bodies; i++) {
        const int32_t parent = tfa_model_body_parent(model, i);
        at[i].root = parent < 0 ? i : at[parent].root;
        at[i].depth = parent < 0 ? 1 : at[parent].depth + 1;
        if (parent < 0)
            at[i].deepest = i;
        place *root = &at[at[i].root];
        if (at[i].depth > at[root->deepest].depth)
            root->deepest = i;
    }
    for (uint32_t i = 0; i < bodies; i++)
        for (int32_t b = at[i].root == i ? (int32_t)at[i].deepest : -1; b >= 0;
             b = tfa_model_body_parent(model, (uint32_t)b))
            at[b].on_chain = true;
}

bool model_find_long_branch(const tfa_model *model, long_branch *found)
{
    const uint32_t bodies = tfa_model_summarise(model).bodies;
    place *at = calloc(bodies + 1, sizeof *at);
    *found = (long_branch){0};
    if (at)
        find_chains(model, bodies, at);
    for (uint32_t i = 0; at && i < bodies; i++) {
        if (at[i].on_chain)
            continue;
        const place *parent = &at[tfa_model_body_parent(model, i)]; /* roots are on chains */
        at[i].branch = parent->on_chain ? i : parent->branch;
        at[i].length = parent->on_chain ? 1 : parent->length + 1;
        if (at[i].length > found->bodies)
            *found = (long_branch){at[i].branch, at[i].length, at[at[at[i].root].deepest].depth};
    }
    free(at);
    return found->bodies && (found->bodies >= 32 || UINT32_C(1) << found->bodies > found->chain);
}
