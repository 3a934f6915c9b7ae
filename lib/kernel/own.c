/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A kernel of one robot's own: the steps of the kernels, compiled with that robot's tables
 * (own_tables.h, written by `totalforce specialise`) as constants. Compiled four times: one number at
 * a time, which exports the table; with the robot's limbs in lanes (TFA_PACKED); with states in lanes;
 * and one number at a time with inertias that are read at run time (OWN_LOADED), for payloads. Inertias
 * as inputs of all four would make inverse dynamics of a humanoid 1.5 times as slow
 * (docs/specialised.md).
 *
 * Compilers are told that numbers are finite and zeros have no sign, or 0 x would not be 0. What is not
 * finite is found by its bits.
 */
#include "own_tables.h"

#if !defined TFA_PACKED || defined OWN_LIMB_LANES /* not every robot has limbs that pay */
#ifdef TFA_PACKED
#define TFA_LANES OWN_LIMB_LANES
#endif

#include <string.h>

#include "kernel/own_walk.h"

int TFA_V(own)(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, uint32_t count,
               tfa_reply *reply);

/* ---- what all of them share ---- */

/* Left to a generic kernel, which estimates the error */
TFA_INLINE int own_is_doubtful(const struct state *s, const tfa_request *r)
{
    return r->estimate != TFA_ESTIMATE_NEVER && sentinel_trips(s);
}

TFA_INLINE double *own_place(double *array, size_t stride, uint32_t k)
{
    return array ? array + stride * k : NULL;
}

/* State k and those behind it; lanes that are left over repeat the last one */
TFA_INLINE struct own_lanes own_states(uint32_t k, uint32_t count)
{
    struct own_lanes at;
    for (uint32_t l = 0; l < sizeof at.lane / sizeof *at.lane; l++)
        at.lane[l] = k + (l < count ? l : count - 1);
    return at;
}

/* Sines and cosines of coordinates first .. end - 1 */
TFA_INLINE void own_turn(struct own_inputs *in, const struct tfa_own_host *host, size_t first,
                         size_t end)
{
    host->sincos((const double *)(in->angle + first), (double *)(in->sine + first),
                 (double *)(in->cosine + first), (end - first) * NUM_LANES);
}

TFA_INLINE void own_load(struct own_inputs *in, const struct tfa_own_host *host,
                         const tfa_request *r, const struct own_lanes *at)
{
    own_take_coordinates(in, at, r);
    own_turn(in, host, 0, OWN_UNIT_COORDINATES);
}

TFA_INLINE void own_load_forward(struct own_inputs *in, const struct tfa_own_host *host,
                                 const tfa_request *r, const struct own_lanes *at)
{
    own_load(in, host, r, at);
    own_take_freedoms(in->qd, at, r->base_twist, r->v);
    own_take_freedoms(in->x, at, r->base_wrench, r->tau);
    own_damp(in->x, in->qd, -1);
}

static __attribute__((flatten, noinline)) int forward(const struct tfa_own_host *host,
                                                      const tfa_request *r, uint32_t k,
                                                      uint32_t count, tfa_reply *reply)
{
    const struct own_lanes at = own_states(k, count);
    struct own_inputs in;
    struct state s;
    num qdd[OWN_UNIT_FREEDOMS];
    own_load_forward(&in, host, r, &at);
    own_start(&s, &in, host, r);
    own_forward(&s, in.x, qdd);
    own_give(qdd, own_place(reply->base_acceleration, 6, k), own_place(reply->qdd, OWN_V_COUNT, k),
             count);
    return own_is_sound(qdd, OWN_UNIT_FREEDOMS) && !own_is_doubtful(&s, r);
}

#ifdef TFA_PACKED
int TFA_V(own)(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, uint32_t count,
               tfa_reply *reply)
{
    return forward(host, r, k, count, reply);
}
#else

static __attribute__((flatten, noinline)) int inverse(const struct tfa_own_host *host,
                                                      const tfa_request *r, uint32_t k,
                                                      uint32_t count, tfa_reply *reply)
{
    const struct own_lanes at = own_states(k, count);
    struct own_inputs in;
    struct state s;
    num tau[OWN_FREEDOMS];
    own_load(&in, host, r, &at);
    own_take_freedoms(in.qd, &at, r->base_twist, r->v);
    own_take_freedoms(in.x, &at, r->base_acceleration, r->qdd);
    own_start(&s, &in, host, r);
    own_inverse(&s, in.x, tau);
    own_damp(tau, in.qd, 1);
    own_give(tau, own_place(reply->base_wrench, 6, k), own_place(reply->tau, OWN_V_COUNT, k),
             count);
    return own_is_sound(tau, OWN_FREEDOMS);
}

#if NUM_LANES > 1 || defined OWN_LOADED
int TFA_V(own)(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, uint32_t count,
               tfa_reply *reply)
{
    return r->op == TFA_OP_INVERSE_DYNAMICS || !OWN_GOES_FORWARD
               ? inverse(host, r, k, count, reply)
               : forward(host, r, k, count, reply);
}
#else
#include "kernel/own_lambda.h"
#include "kernel/own_takes.h"

/* ---- tips, one number at a time ---- */

#define OWN_LOAD_TREE(i)                                                                           \
    if (!own_is_straight() && own_body[i].tree == own_body[tip].tree && !own_body[i].base)         \
        own_take_coordinate(in, at, r, own_body[i].q);
#define OWN_COUNT_TREE(i) end += own_body[i].tree == own_body[tip].tree && !own_body[i].base;

/* Coordinates of the tree that hangs where the tip's does; they stand together. */
TFA_INLINE void own_load_tree(struct own_inputs *in, const struct tfa_own_host *host,
                              const tfa_request *r, const struct own_lanes *at, int32_t tip)
{
    const struct tfa_body *root = &own_body[own_body[tip].tree];
    size_t end = root->base ? 0 : root->q;
    const size_t first = end;
    in->angle = own_angles(in, at, r);
    OWN_OUTWARD(OWN_LOAD_TREE)
    OWN_OUTWARD(OWN_COUNT_TREE)
    for (size_t k = 0; OWN_BASE && k < 7; k++)
        in->base[k] = own_take(at, r->base_pose, 7, k);
    own_turn(in, host, first, end);
}

/* Lambda^-1 alone, of the tip on body `tip` */
TFA_INLINE int lambda_of(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                         int32_t tip, tfa_reply *reply)
{
    const struct own_lanes at = own_states(k, 1);
    struct own_inputs in;
    struct state s;
    own_load_tree(&in, host, r, &at, tip);
    own_start(&s, &in, host, r);
    own_factor(&s, tip);
    const struct block C = own_carry(&s, tip, &host->model->frame[r->tips[0]], r->frame);
    return own_give_lambda(&C, reply->lambda_inv + 36 * (size_t)k) && !own_is_doubtful(&s, r);
}

#define OWN_LAMBDA(i)                                                                              \
    case i:                                                                                        \
        return OWN_HAS_TIP(i) ? lambda_of(host, r, k, i, reply) : 0;

static __attribute__((flatten, noinline)) int
lambda(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    switch (host->model->frame[r->tips[0]].body) {
        OWN_OUTWARD(OWN_LAMBDA)
    default:
        return 0;
    }
}

#ifdef OWN_LIMB_LANES
int tfa_own_own_limbs(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                      uint32_t count, tfa_reply *reply);

static int alone(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                 tfa_reply *reply)
{
    return tfa_own_own_limbs(host, r, k, 1, reply);
}

/* Two walks, one with all limbs side by side: less than one walk without. */
static int both(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    return alone(host, r, k, reply) && lambda(host, r, k, reply);
}
#else
#define OWN_TIP(i)                                                                                 \
    case i:                                                                                        \
        if (!OWN_HAS_TIP(i))                                                                       \
            return 0;                                                                              \
        C = own_carry(&s, i, f, r->frame);                                                         \
        break;

/* Forward dynamics, and Lambda^-1 with the same factors */
static __attribute__((flatten, noinline)) int
both(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    const struct own_lanes at = own_states(k, 1);
    struct own_inputs in;
    struct state s;
    struct block C;
    num qdd[OWN_FREEDOMS];
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    own_load_forward(&in, host, r, &at);
    own_start(&s, &in, host, r);
    own_forward(&s, in.x, qdd);
    own_give(qdd, own_place(reply->base_acceleration, 6, k), own_place(reply->qdd, OWN_V_COUNT, k),
             1);
    switch (f->body) {
        OWN_OUTWARD(OWN_TIP)
    default:
        return 0;
    }
    return own_is_sound(qdd, OWN_FREEDOMS) && !own_is_doubtful(&s, r) &&
           own_give_lambda(&C, reply->lambda_inv + 36 * (size_t)k);
}

static int alone(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                 tfa_reply *reply)
{
    return OWN_GOES_FORWARD ? forward(host, r, k, 1, reply) : 0;
}
#endif

/* ---- the table ---- */

int TFA_V(own)(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, uint32_t count,
               tfa_reply *reply)
{
    (void)count;
    if (r->op == TFA_OP_INVERSE_DYNAMICS)
        return inverse(host, r, k, 1, reply);
    if (r->op == TFA_OP_OPERATIONAL_INERTIA)
        return lambda(host, r, k, reply);
    return r->tip_count && OWN_GOES_FORWARD ? both(host, r, k, reply) : alone(host, r, k, reply);
}

int tfa_own_own_loaded(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                       uint32_t count, tfa_reply *reply);

static int one(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    return r->payload_count ? tfa_own_own_loaded(host, r, k, 1, reply)
                            : TFA_V(own)(host, r, k, 1, reply);
}

#if OWN_LANES
int tfa_own_own_many(const struct tfa_own_host *host, const tfa_request *r, uint32_t k,
                     uint32_t count, tfa_reply *reply);

/* 0: states with payloads go one at a time. */
static int many(const struct tfa_own_host *host, const tfa_request *r, uint32_t k, uint32_t count,
                tfa_reply *reply)
{
    return r->payload_count ? 0 : tfa_own_own_many(host, r, k, count, reply);
}
#endif

#define OWN_STRING_OF(x) #x
#define OWN_STRING(x) OWN_STRING_OF(x)

__attribute__((visibility("default"))) const struct tfa_own_kernel tfa_own_kernel = {
    .abi = TFA_OWN_ABI,
    .request_bytes = sizeof(tfa_request),
    .reply_bytes = sizeof(tfa_reply),
    .model_bytes = sizeof(struct tfa_model),
    .model = OWN_HASH,
    .isa = OWN_STRING(TFA_ISA_NAME),
    .compiler = __VERSION__,
    .bodies = OWN_BODIES,
    .lanes = OWN_LANES,
    .takes = own_takes,
    .one = one,
#if OWN_LANES
    .many = many,
#endif
};
#endif
#endif
#endif
