/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constant terms of one body, as the kernels read them. In a packed variant (TFA_PACKED) the
 * lanes of a num hold several bodies of one state: constants are stored in lane order, and what
 * stands for a body elsewhere, its index, is a step: one body for each lane, of the same kind of
 * joint, parents in steps before.
 */
#ifndef TFA_KERNEL_TERMS_H
#define TFA_KERNEL_TERMS_H

#include "model/model.h"
#include "spatial/spatial.h"

#if defined TFA_PACKED && defined TFA_OWN
#include "kernel/own_packed_terms.h"
#elif defined TFA_PACKED
#include "kernel/packed_terms.h"
#else

#ifdef TFA_OWN
#include "kernel/own_abi.h"
#include "own_tables.h"
#endif

typedef struct tfa_body terms;

/* T: from the parent's frame to the joint's at q = 0 */
static inline mat3 terms_E(const terms *b)
{
    return m3_load(b->E);
}

static inline vec3 terms_r(const terms *b)
{
    return v3_load(b->r);
}

static inline num terms_mass(const terms *b)
{
    return num_of(b->mass);
}

/* Mass times centre of mass */
static inline vec3 terms_h(const terms *b)
{
    return v3_load(b->h);
}

static inline sym3 terms_I(const terms *b)
{
    return (sym3){num_of(b->I[0]), num_of(b->I[1]), num_of(b->I[2]),
                  num_of(b->I[3]), num_of(b->I[4]), num_of(b->I[5])};
}

/* Of a joint with one freedom */
static inline num terms_armature(const terms *b)
{
    return num_of(b->armature);
}

/* Of an axial one: shift along z */
static inline num terms_d(const terms *b)
{
    return num_of(b->d);
}

static inline int terms_geared(const terms *b)
{
#ifdef TFA_OWN
    if (OWN_KEEPS & TFA_OWN_KEEPS_ARMATURE)
        return 1;
#endif
    return b->armature > 0;
}

/* First freedom among those of the model */
static inline uint32_t terms_freedom(const terms *b)
{
    return b->v;
}

#endif
#endif
