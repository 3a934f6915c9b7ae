/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The mass matrix of one robot: each entry goes from the walk to the reply, where it belongs and to
 * its mirror image. The base comes first, linear before angular.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_MASS_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_MASS_H

#include "dynamics/specialised/specialised_composite.h"
#include "dynamics/specialised/specialised_forward.h"
#include "dynamics/specialised/specialised_supports.h"

#define ROBOT_MASS_ROWS ((size_t)ROBOT_BASE + ROBOT_V_COUNT)

/* Where the entries go; their sum is not finite where one is not. x + zero is never -0: of which
 * sign a zero is depends on the lanes, to compilers that are told that it has none. */
struct mass_entries {
    double *M;
    struct lane_states at;
    num sum, zero;
};

/* Where inner freedom v stands in the reply */
TFA_INLINE size_t public_freedom(size_t v)
{
    return v < ROBOT_BASE ? v
                          : ROBOT_BASE + robot_freedom[v < ROBOT_BASE ? 0 : v - ROBOT_BASE].from;
}

TFA_INLINE void put_entry(struct mass_entries *m, size_t v, size_t w, num x)
{
    const size_t n = ROBOT_MASS_ROWS, a = public_freedom(v), b = public_freedom(w);
    x += m->zero;
    m->sum += x;
#pragma GCC unroll 16
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        double *M = m->M + n * n * m->at.lane[l];
        M[n * a + b] = M[n * b + a] = (double)num_lane(x, l);
    }
}

/* The base's columns of Ic, of unit velocities */
TFA_INLINE void put_base(const struct state *s, struct mass_entries *m, const rigid *Ic)
{
#pragma GCC unroll 6
    for (uint32_t k = 0; k < 6; k++) {
        num x[6], unit[6] = {0};
        unit[k] = num_of(1);
        base_force(s6_rigid_mul(Ic->I, Ic->h, Ic->m, base_motion(unit)), x);
        x[k] += joint_armature(s, robot_body, k);
#pragma GCC unroll 6
        for (uint32_t j = 0; j <= k; j++)
            put_entry(m, k, j, x[j]);
    }
}

TFA_INLINE void mass_step(const struct state *s, struct mass_entries *m, rigid *Ic, int32_t k)
{
    const rigid sum = composite_step(s, Ic, k);
    num row[ROBOT_BODIES], base[6];
    if (ROBOT_BASE && robot_body[k].base) {
        put_base(s, m, &sum);
        return;
    }
    base_force(composite_row(s, k, &sum, row), base);
#pragma GCC unroll 128
    for (int32_t j = ROBOT_BODIES - 1; j >= 0; j--)
        if (j <= k && is_on_path(j, k) && !robot_body[j].base)
            put_entry(m, robot_body[k].v, robot_body[j].v, row[j]);
#pragma GCC unroll 6
    for (size_t e = 0; e < ROBOT_BASE; e++) /* on which all bodies stand */
        put_entry(m, robot_body[k].v, e, base[e]);
}

#define ROBOT_MASS_BACKWARD(i) mass_step(s, m, Ic, i);

TFA_INLINE void mass_walk(struct state *s, struct mass_entries *m)
{
    rigid Ic[ROBOT_BODIES];
#pragma GCC unroll 128
    for (int i = 0; i < ROBOT_BODIES; i++)
        Ic[i] = rigid_zero();
    ROBOT_OUTWARD(ROBOT_POSE)
    ROBOT_INWARD(ROBOT_MASS_BACKWARD)
}

static __attribute__((flatten, noinline)) uint32_t mass_matrix(const struct tfa_host_api *host,
                                                               const tfa_request *r, uint32_t k,
                                                               uint32_t count, tfa_reply *reply)
{
    const size_t entries = ROBOT_MASS_ROWS * ROBOT_MASS_ROWS;
    struct mass_entries m = {reply->mass_matrix, lanes_of_states(k, count), num_of(0), num_of(0)};
    struct robot_inputs in;
    struct state s;
    if (!ROBOT_HAS_MASS || !m.M)
        return TFA_SPECIALISED_NO_CODE;
    __asm__("" : ROBOT_REGISTER(m.zero)); /* known to no compiler */
    load_positions(&in, r, &m.at);
    init_state(&s, &in, host, r);
    if (!ROBOT_IS_CHAIN)
        memset(m.M + entries * k, 0, entries * count * sizeof *m.M);
    mass_walk(&s, &m);
    return states_of_mask(num_is_moderate(m.sum));
}

#endif
