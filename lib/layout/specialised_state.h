/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * State of a kernel specialised for one robot: the arrays that the steps of the algorithms
 * read and write, on the stack, in arrays whose sizes and indices are constants, so that the
 * compiler keeps numbers instead of arrays. Units and frames as in state.h.
 */
#ifndef TFA_LAYOUT_SPECIALISED_STRUCT_H
#define TFA_LAYOUT_SPECIALISED_STRUCT_H

/* Whole vectors of 8 doubles are written from any coordinate on (number/sincos.h). */
#define ROBOT_PADDED(n) ((n) + 8)

/* Inputs of the request, and sines: read by other functions by their addresses. */
struct robot_inputs {
    num q[ROBOT_PADDED(ROBOT_UNIT_COORDINATES)], sine[ROBOT_PADDED(ROBOT_UNIT_COORDINATES)],
        cosine[ROBOT_PADDED(ROBOT_UNIT_COORDINATES)];
    const num *angle; /* q, or the request's own numbers where they are the same */
    num qd[ROBOT_UNIT_FREEDOMS], x[ROBOT_UNIT_FREEDOMS]; /* x: tau, or qdd */
    num base[7], boost_rate[3];
#ifdef ROBOT_PAYLOADS
    struct tfa_body loaded_bodies[ROBOT_BODIES]; /* with the request's payloads */
#endif
};

struct state {
    const struct tfa_model *m;
#ifdef ROBOT_PAYLOADS
    const struct tfa_body *loaded; /* `carried` of the inputs */
#endif
    const num *q, *sine, *cosine, *qd, *base; /* of the inputs */
    struct joint_nd joint_nd[1];              /* the base */
    xform X[ROBOT_UNITS];
    svec v[ROBOT_UNITS], c[ROBOT_UNITS], p[ROBOT_UNITS], a[ROBOT_UNITS], f[ROBOT_UNITS];
    sym6 IA[ROBOT_UNITS];
    svec pA[ROBOT_UNITS], U[ROBOT_UNITS], K[ROBOT_UNITS];
    num Dinv[ROBOT_UNITS], u[ROBOT_UNITS];
    num margin;             /* sentinel.h */
    double payload_size[2]; /* tfa_payload_size */
    vec3 gravity;
    int locked; /* 0: no joint is locked */
};

/* The constants of body i */
TFA_INLINE const body_constants *body_constants_of(const struct state *s, uint32_t i)
{
    (void)s;
    return &robot_unit[i];
}

/* The same, with the payloads of the request: only for mass, h and I. */
TFA_INLINE const body_constants *body_with_payload(const struct state *s, uint32_t i)
{
#ifdef ROBOT_PAYLOADS
    return &s->loaded[i];
#else
    return body_constants_of(s, i);
#endif
}

TFA_INLINE int state_payloads(const struct state *s)
{
    (void)s;
#ifdef ROBOT_PAYLOADS
    return 1;
#else
    return 0;
#endif
}

/* Hides from the compiler that numbers are constants, but for zeros. clang rounds a product of two
 * constants that it fuses into a sum otherwise, as where lanes hold other bodies, too. */
#ifdef __x86_64__
#define ROBOT_REGISTER "+x"
#else
#define ROBOT_REGISTER "+w"
#endif
TFA_INLINE void hide_inertia(sym6 *S)
{
    num *x = (num *)(void *)S;
#ifndef ROBOT_PAYLOADS /* those are read at run time */
#pragma GCC unroll 21
    for (size_t k = 0; k < sizeof *S / sizeof *x; k++)
        if (!num_all(x[k] == num_of(0))) /* a constant */
            __asm__("" : ROBOT_REGISTER(x[k]));
#endif
}
#define hide_inertia hide_inertia

/* Rotor inertia of freedom k */
static inline num joint_armature(const struct state *s, const body_constants *b, uint32_t k)
{
    (void)s;
    return b->n == 1 ? body_armature(b) : num_of(robot_armature[body_first_freedom(b) + k]);
}

#endif
