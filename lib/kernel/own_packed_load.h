/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of one state and lanes that hold its bodies, in a kernel of one robot's own.
 */
#ifndef TFA_KERNEL_OWN_PACKED_LOAD_H
#define TFA_KERNEL_OWN_PACKED_LOAD_H

/* The state in all lanes */
struct own_lanes {
    uint32_t lane[1];
};

/* Coordinate and freedom of the body in a lane, among those of the joints */
#define OWN_Q_OF(l) own_coordinate[own_body[b->body[l]].q]
#define OWN_V_OF(l) own_freedom[own_body[b->body[l]].v - OWN_BASE]

TFA_INLINE num own_take_base(const struct own_lanes *at, const double *array, size_t stride,
                             size_t k)
{
    return num_of(array ? array[stride * at->lane[0] + k] : 0);
}

TFA_INLINE void own_take_coordinate(struct own_inputs *in, const terms *b, const double *q)
{
#define OWN_GET(l) (OWN_Q_OF(l).multiplier * q[OWN_Q_OF(l).from] + OWN_Q_OF(l).offset)
    if (!b->base)
        in->q[b->q] = NUM_EACH(OWN_GET);
#undef OWN_GET
}

TFA_INLINE void own_take_coordinates(struct own_inputs *in, const struct own_lanes *at,
                                     const tfa_request *r)
{
    const double *q = r->q + (size_t)OWN_Q_COUNT * at->lane[0];
    in->angle = in->q;
#define OWN_LOAD(i) own_take_coordinate(in, &own_step[i], q);
    OWN_STEPS_OUTWARD(OWN_LOAD)
#undef OWN_LOAD
    for (size_t k = 0; OWN_BASE && k < 7; k++)
        in->base[k] = own_take_base(at, r->base_pose, 7, k);
}

TFA_INLINE void own_take_freedom(num *out, const terms *b, const double *x)
{
#define OWN_GET(l) (OWN_V_OF(l).multiplier * x[OWN_V_OF(l).from])
    if (!b->base)
        out[b->v] = NUM_EACH(OWN_GET);
#undef OWN_GET
}

TFA_INLINE void own_take_freedoms(num *out, const struct own_lanes *at, const double *base,
                                  const double *joints)
{
    static const double rest[OWN_V_COUNT];
    const double *x = joints ? joints + (size_t)OWN_V_COUNT * at->lane[0] : rest;
    for (size_t k = 0; k < OWN_BASE; k++)
        out[k] = own_take_base(at, base, 6, k);
#define OWN_LOAD(i) own_take_freedom(out, &own_step[i], x);
    OWN_STEPS_OUTWARD(OWN_LOAD)
#undef OWN_LOAD
}

TFA_INLINE void own_damp_step(num *tau, const num *qd, const terms *b, double sign)
{
#define OWN_GET(l) sign *own_damping[own_body[b->body[l]].v]
    if (!b->base)
        tau[b->v] += NUM_EACH(OWN_GET) * qd[b->v];
#undef OWN_GET
}

/* tau += sign d qd */
TFA_INLINE void own_damp(num *tau, const num *qd, double sign)
{
#define OWN_LOAD(i) own_damp_step(tau, qd, &own_step[i], sign);
    if (OWN_DAMPED) {
        OWN_STEPS_OUTWARD(OWN_LOAD)
    }
#undef OWN_LOAD
}

TFA_INLINE void own_give_freedom(const num *x, const terms *b, double *out)
{
#define OWN_PUT(l)                                                                                 \
    if (b->held >> l & 1)                                                                          \
        out[OWN_V_OF(l).from] = x[b->v][l];
    if (b->base)
        return;
    OWN_PUT(0)
    OWN_PUT(1)
#if NUM_LANES > 2
    OWN_PUT(2)
    OWN_PUT(3)
#endif
#if NUM_LANES > 4
    OWN_PUT(4)
    OWN_PUT(5)
    OWN_PUT(6)
    OWN_PUT(7)
#endif
#undef OWN_PUT
}

/* Base six, then joints; either array may be NULL. */
TFA_INLINE void own_give(const num *x, double *base, double *joints, uint32_t count)
{
    (void)count;
    for (size_t j = 0; base && j < OWN_BASE; j++)
        base[j] = x[j][0];
#define OWN_PUT(i) own_give_freedom(x, &own_step[i], joints);
    if (joints) {
        OWN_STEPS_OUTWARD(OWN_PUT)
    }
#undef OWN_PUT
}

#endif
