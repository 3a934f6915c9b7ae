/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Traits of a request: one word of bits, computed once, from which the engine decides how to
 * compute.
 */
#ifndef TFA_ENGINE_TRAITS_H
#define TFA_ENGINE_TRAITS_H

#include <totalforce/dynamics.h>

enum {
    TRAIT_FD = 1u << TFA_OP_FORWARD_DYNAMICS,
    TRAIT_ID = 1u << TFA_OP_INVERSE_DYNAMICS,
    TRAIT_OSIM = 1u << TFA_OP_OPERATIONAL_INERTIA,
    TRAIT_M = 1u << TFA_OP_MASS_MATRIX,
    TRAIT_TIPS = 1u << 8,            /* at least one tip */
    TRAIT_SEVERAL_TIPS = 1u << 9,    /* at least two */
    TRAIT_POSES = 1u << 10,          /* of the tips */
    TRAIT_SPECTRUM = 1u << 11,       /* of lambda_inv */
    TRAIT_WRENCH = 1u << 12,         /* external wrenches */
    TRAIT_PAYLOAD = 1u << 13,        /* payloads of the request */
    TRAIT_LOCK = 1u << 14,           /* locked joints of the request */
    TRAIT_REFINE = 1u << 15,         /* a number of refinement steps above 0 */
    TRAIT_DEFAULT_REFINE = 1u << 16, /* the method's own number of steps */
    TRAIT_ESTIMATE = 1u << 17,       /* an error estimate of every answer */
    TRAIT_DEFAULT_ESTIMATE =
        1u << 18,           /* an error estimate where the method or the sentinel asks for one */
    TRAIT_BATCH = 1u << 19, /* several states */
};

/* Changes of the model's constants or forces */
#define TRAITS_CHANGED (TRAIT_WRENCH | TRAIT_PAYLOAD | TRAIT_LOCK)
/* Lists that name frames or joints */
#define TRAITS_SCENE (TRAIT_TIPS | TRAITS_CHANGED)

/* Of a request with a valid op. Cost: some ten instructions. */
static inline uint32_t traits_of(const tfa_request *r)
{
    uint32_t t = 1u << r->op;
    t |= r->tip_count ? TRAIT_TIPS : 0;
    t |= r->tip_count > 1 ? TRAIT_SEVERAL_TIPS : 0;
    t |= r->flags & TFA_WANT_POSES ? TRAIT_POSES : 0;
    t |= r->flags & TFA_WANT_SPECTRUM ? TRAIT_SPECTRUM : 0;
    t |= r->wrench_count ? TRAIT_WRENCH : 0;
    t |= r->payload_count ? TRAIT_PAYLOAD : 0;
    t |= r->locked_count ? TRAIT_LOCK : 0;
    t |= r->refine == TFA_REFINE_DEFAULT ? TRAIT_DEFAULT_REFINE : r->refine ? TRAIT_REFINE : 0;
    t |= r->estimate == TFA_ESTIMATE_ALWAYS    ? TRAIT_ESTIMATE
         : r->estimate == TFA_ESTIMATE_DEFAULT ? TRAIT_DEFAULT_ESTIMATE
                                               : 0;
    t |= r->count > 1 ? TRAIT_BATCH : 0;
    return t;
}

#endif
