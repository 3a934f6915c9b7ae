/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What changes while a kernel of one robot's own computes: what the steps of the algorithms read and
 * write, on the stack, in arrays whose sizes and indices are constants, so that the compiler keeps
 * numbers instead of arrays. Units and frames as in state.h.
 */
#ifndef TFA_KERNEL_OWN_STATE_H
#define TFA_KERNEL_OWN_STATE_H

#include "kernel/own_abi.h"
#include "own_tables.h"

/* What a walk passes: bodies, or steps of bodies that stand side by side */
#ifdef TFA_PACKED
#define own_unit own_step
#define OWN_UNITS OWN_STEPS
#define OWN_UNIT_COORDINATES (OWN_STEP_FREEDOMS - OWN_BASE)
#define OWN_UNIT_FREEDOMS OWN_STEP_FREEDOMS
#define OWN_UNITS_OUTWARD OWN_STEPS_OUTWARD
#define OWN_UNITS_INWARD OWN_STEPS_INWARD
#else
#define own_unit own_body
#define OWN_UNITS OWN_BODIES
#define OWN_UNIT_COORDINATES OWN_COORDINATES
#define OWN_UNIT_FREEDOMS OWN_FREEDOMS
#define OWN_UNITS_OUTWARD OWN_OUTWARD
#define OWN_UNITS_INWARD OWN_INWARD
#endif

/* More bodies that do not go side by side are left to the loop of the generic kernel. Written out, a chain of 32
 * takes 0.80 times as long, of 40 0.86, of 48 0.90, but cold 2.8, 3.4 and 4.1 times, and its compiler 20 s and
 * more (docs/specialised.md). */
#define OWN_WALK_MAX 40
#if OWN_BODIES <= OWN_WALK_MAX || (defined OWN_LIMB_LANES && !defined OWN_LOADED)
#define OWN_GOES_FORWARD 1
#else
#define OWN_GOES_FORWARD 0 /* no code for what is not taken */
#endif

/* Whole vectors of 8 doubles are written from any coordinate on (variants/sincos.h). */
#define OWN_ROOM(n) ((n) + 8)

/* What comes from the request, and sines: other functions know where these stand. */
struct own_inputs {
    num q[OWN_ROOM(OWN_UNIT_COORDINATES)], sine[OWN_ROOM(OWN_UNIT_COORDINATES)],
        cosine[OWN_ROOM(OWN_UNIT_COORDINATES)];
    const num *angle; /* q, or the request's own numbers where they are the same */
    num qd[OWN_UNIT_FREEDOMS], x[OWN_UNIT_FREEDOMS]; /* x: tau, or qdd */
    num base[7];
#ifdef OWN_LOADED
    struct tfa_body carried[OWN_BODIES]; /* with the request's payloads */
#endif
};

struct state {
    const struct tfa_model *m;
#ifdef OWN_LOADED
    const struct tfa_body *loaded; /* `carried` of the inputs */
#endif
    const num *q, *sine, *cosine, *qd, *base; /* of the inputs */
    struct multi multi[1];                    /* the base */
    place X[OWN_UNITS];
    svec v[OWN_UNITS], c[OWN_UNITS], p[OWN_UNITS], a[OWN_UNITS], f[OWN_UNITS];
    sym6 IA[OWN_UNITS];
    svec pA[OWN_UNITS], U[OWN_UNITS], K[OWN_UNITS];
    num Dinv[OWN_UNITS], u[OWN_UNITS];
    num margin;        /* sentinel.h */
    num payload_bound; /* inertia of the request's payloads about any joint, at most */
    vec3 gravity;
    int locked; /* 0: no joint is locked */
};

#endif
