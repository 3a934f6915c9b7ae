/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of one state and lanes that hold its bodies, in a kernel specialised for one
 * robot.
 */
#ifndef TFA_LAYOUT_SPECIALISED_BODY_LANES_INPUTS_H
#define TFA_LAYOUT_SPECIALISED_BODY_LANES_INPUTS_H

#include "spatial/friction.h"

/* The state in all lanes */
struct lane_states {
    uint32_t lane[1];
};

/* 1 if a condition holds for all bodies of the state */
TFA_INLINE uint32_t states_of_mask(num_mask holds)
{
    return num_all(holds) != 0;
}

/* Coordinate and freedom of the body in a lane, among those of the joints */
#define ROBOT_Q_OF(l) robot_coordinate[robot_body[b->body[l]].q]
#define ROBOT_V_OF(l) robot_freedom[robot_body[b->body[l]].v - ROBOT_BASE]

TFA_INLINE num gather_base(const struct lane_states *at, const double *array, size_t stride,
                           size_t k)
{
    return num_of(array ? array[stride * at->lane[0] + k] : 0);
}

TFA_INLINE void gather_position(struct robot_inputs *in, const body_constants *b, const double *q)
{
#define ROBOT_GET(l) (ROBOT_Q_OF(l).multiplier * q[ROBOT_Q_OF(l).from] + ROBOT_Q_OF(l).offset)
    if (!b->base)
        in->q[b->q] = NUM_EACH(ROBOT_GET);
#undef ROBOT_GET
}

TFA_INLINE void gather_positions(struct robot_inputs *in, const struct lane_states *at,
                                 const tfa_request *r, size_t first, size_t end)
{
    (void)first, (void)end; /* all */
    const double *q = r->q + (size_t)ROBOT_Q_COUNT * at->lane[0];
    in->angle = in->q;
#define ROBOT_GATHER(i) gather_position(in, &robot_step[i], q);
    ROBOT_STEPS_OUTWARD(ROBOT_GATHER)
#undef ROBOT_GATHER
    for (size_t k = 0; ROBOT_BASE && k < 7; k++)
        in->base[k] = gather_base(at, r->base_pose, 7, k);
}

TFA_INLINE void gather_freedom(num *out, const body_constants *b, const double *x)
{
#define ROBOT_GET(l) (ROBOT_V_OF(l).multiplier * x[ROBOT_V_OF(l).from])
    if (!b->base)
        out[b->v] = NUM_EACH(ROBOT_GET);
#undef ROBOT_GET
}

TFA_INLINE void gather_freedoms(num *out, const struct lane_states *at, const double *base,
                                const double *joints)
{
    static const double rest[ROBOT_V_COUNT];
    const double *x = joints ? joints + (size_t)ROBOT_V_COUNT * at->lane[0] : rest;
    for (size_t k = 0; k < ROBOT_BASE; k++)
        out[k] = gather_base(at, base, 6, k);
#define ROBOT_GATHER(i) gather_freedom(out, &robot_step[i], x);
    ROBOT_STEPS_OUTWARD(ROBOT_GATHER)
#undef ROBOT_GATHER
}

/* `of`: numbers of the freedoms */
TFA_INLINE void add_of_step(num *tau, const double *of, num x, const body_constants *b, double sign)
{
#define ROBOT_GET(l) sign *of[robot_body[b->body[l]].v]
    tau[b->v] += NUM_EACH(ROBOT_GET) * x;
#undef ROBOT_GET
}

TFA_INLINE void add_dissipation_of_step(num *tau, const num *qd, const body_constants *b,
                                        double sign)
{
    if (ROBOT_DAMPED && !b->base)
        add_of_step(tau, robot_damping, qd[b->v], b, sign);
    if (ROBOT_HAS_FRICTION && !b->base)
        add_of_step(tau, robot_friction, friction_sign(qd[b->v], num_of(robot_friction_velocity)),
                    b, sign);
}

/* tau += sign (damping and friction) */
TFA_INLINE void add_dissipation(num *tau, const num *qd, double sign)
{
#define ROBOT_GATHER(i) add_dissipation_of_step(tau, qd, &robot_step[i], sign);
    if (ROBOT_DAMPED || ROBOT_HAS_FRICTION) {
        ROBOT_STEPS_OUTWARD(ROBOT_GATHER)
    }
#undef ROBOT_GATHER
}

TFA_INLINE void spread_freedom(num *out, const body_constants *b, const double *x)
{
#define ROBOT_GET(l) x[robot_body[b->body[l]].v]
    if (!b->base)
        out[b->v] = NUM_EACH(ROBOT_GET);
#undef ROBOT_GET
}

/* From freedoms of one body after the other */
TFA_INLINE void spread_freedoms(num *out, const double *x)
{
    for (size_t k = 0; k < ROBOT_BASE; k++)
        out[k] = num_of(x[k]);
#define ROBOT_GATHER(i) spread_freedom(out, &robot_step[i], x);
    ROBOT_STEPS_OUTWARD(ROBOT_GATHER)
#undef ROBOT_GATHER
}

TFA_INLINE void scatter_freedom(const num *x, const body_constants *b, double *out)
{
#define ROBOT_PUT(l)                                                                               \
    if (b->lane_mask >> l & 1)                                                                     \
        out[ROBOT_V_OF(l).from] = x[b->v][l];
    if (b->base)
        return;
    ROBOT_PUT(0)
    ROBOT_PUT(1)
#if NUM_LANES > 2
    ROBOT_PUT(2)
    ROBOT_PUT(3)
#endif
#if NUM_LANES > 4
    ROBOT_PUT(4)
    ROBOT_PUT(5)
    ROBOT_PUT(6)
    ROBOT_PUT(7)
#endif
#undef ROBOT_PUT
}

/* Base six, then joints; either array may be NULL. */
TFA_INLINE void scatter_outputs(const num *x, const struct lane_states *at, double *base,
                                double *joints)
{
    const size_t state = at->lane[0];
    for (size_t j = 0; base && j < ROBOT_BASE; j++)
        base[6 * state + j] = x[j][0];
#define ROBOT_PUT(i) scatter_freedom(x, &robot_step[i], joints + ROBOT_V_COUNT * state);
    if (joints) {
        ROBOT_STEPS_OUTWARD(ROBOT_PUT)
    }
#undef ROBOT_PUT
}

#endif
