/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory of an object with arrays: one walk gives its size (base NULL) or the pointers into it.
 */
#ifndef TFA_MODEL_ARENA_H
#define TFA_MODEL_ARENA_H

#include <stddef.h>
#include <stdint.h>

#define TFA_ALIGNMENT 64 /* a cache line and the widest vector */

struct arena {
    char *base; /* NULL: counts only */
    size_t used;
};

/* The next `count` elements of `size` bytes, 64-byte aligned; NULL while counting. */
static inline void *arena_alloc(struct arena *a, size_t count, size_t size)
{
    void *at = a->base ? a->base + a->used : NULL;
    size_t bytes = count * size;
    a->used += (bytes + TFA_ALIGNMENT - 1) / TFA_ALIGNMENT * TFA_ALIGNMENT;
    return at;
}

#endif
