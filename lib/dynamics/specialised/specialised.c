/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table of a kernel specialised for one robot: the library's steps, compiled with that robot's
 * constants (robot_tables.h), and which of them answers which request (robot_choice.h); both are
 * written by `totalforce specialise`. The functions are those of specialised_solve.c, compiled for
 * each algorithm and for states in lanes, of specialised_derivatives.c and of
 * specialised_body_lanes.c.
 */
#include "dynamics/specialised/specialised_supports.h"
#include "robot_choice.h"

typedef uint32_t robot_solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                             uint32_t count, tfa_reply *reply);

robot_solve ROBOT_FORWARD_ONE, ROBOT_INVERSE_ONE, ROBOT_LAMBDA_ONE, ROBOT_FORWARD_LAMBDA_ONE,
    ROBOT_FORWARD_PAYLOADS, ROBOT_INVERSE_PAYLOADS, ROBOT_MASS_ONE, ROBOT_MASS_PAYLOADS;

#if ROBOT_HAS_DERIVATIVES
robot_solve tfa_robot_derivatives_one, tfa_robot_derivatives_batch;
#define ROBOT_DERIVATIVES_ONE tfa_robot_derivatives_one
#define ROBOT_DERIVATIVES_BATCH tfa_robot_derivatives_batch
#else
#define ROBOT_DERIVATIVES_ONE tfa_robot_none
#define ROBOT_DERIVATIVES_BATCH tfa_robot_none
#endif

/* Forward dynamics, then Lambda^-1: with branches in lanes less than one pass without */
uint32_t tfa_robot_two_passes(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return ROBOT_FORWARD_ONE(host, r, k, count, reply) & ROBOT_LAMBDA_ONE(host, r, k, count, reply);
}

/* For requests that the robot has no code for */
uint32_t tfa_robot_none(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                        uint32_t count, tfa_reply *reply)
{
    (void)host, (void)r, (void)k, (void)count, (void)reply;
    return TFA_SPECIALISED_NO_CODE;
}

/* Functions of one number type: one state, or states in lanes */
struct solvers {
    robot_solve *forward, *inverse, *lambda, *forward_lambda, *forward_payloads, *inverse_payloads,
        *mass, *mass_payloads, *derivatives; /* of doubles */
};

TFA_INLINE uint32_t solve_by(struct solvers by, const struct tfa_host_api *host,
                             const tfa_request *r, uint32_t k, uint32_t count, tfa_reply *reply)
{
    const int forward = r->op == TFA_OP_FORWARD_DYNAMICS;
    if (TFA_OP_BIT(r->op) & TRAITS_DERIVATIVES)
        return by.derivatives(host, r, k, count, reply);
    if (r->op == TFA_OP_OPERATIONAL_INERTIA)
        return by.lambda(host, r, k, count, reply);
    if (r->op == TFA_OP_MASS_MATRIX)
        return (r->payload_count ? by.mass_payloads : by.mass)(host, r, k, count, reply);
    if (r->payload_count)
        return (forward ? by.forward_payloads : by.inverse_payloads)(host, r, k, count, reply);
    if (!forward)
        return by.inverse(host, r, k, count, reply);
    return (r->tip_count ? by.forward_lambda : by.forward)(host, r, k, count, reply);
}

static uint32_t solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                      tfa_reply *reply)
{
    const struct solvers one = {
        ROBOT_FORWARD_ONE,        ROBOT_INVERSE_ONE,      ROBOT_LAMBDA_ONE,
        ROBOT_FORWARD_LAMBDA_ONE, ROBOT_FORWARD_PAYLOADS, ROBOT_INVERSE_PAYLOADS,
        ROBOT_MASS_ONE,           ROBOT_MASS_PAYLOADS,    ROBOT_DERIVATIVES_ONE};
    return solve_by(one, host, r, k, 1, reply);
}

#if ROBOT_BATCH_LANES
robot_solve ROBOT_FORWARD_BATCH, ROBOT_INVERSE_BATCH, ROBOT_LAMBDA_BATCH,
    ROBOT_FORWARD_LAMBDA_BATCH, ROBOT_FORWARD_BATCH_PAYLOADS, ROBOT_INVERSE_BATCH_PAYLOADS,
    ROBOT_MASS_BATCH, ROBOT_MASS_BATCH_PAYLOADS;

static uint32_t solve_batch(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                            uint32_t count, tfa_reply *reply)
{
    const struct solvers batch = {
        ROBOT_FORWARD_BATCH,        ROBOT_INVERSE_BATCH,          ROBOT_LAMBDA_BATCH,
        ROBOT_FORWARD_LAMBDA_BATCH, ROBOT_FORWARD_BATCH_PAYLOADS, ROBOT_INVERSE_BATCH_PAYLOADS,
        ROBOT_MASS_BATCH,           ROBOT_MASS_BATCH_PAYLOADS,    ROBOT_DERIVATIVES_BATCH};
    return solve_by(batch, host, r, k, count, reply);
}
#endif

#if ROBOT_BATCH_F32_LANES
robot_solve ROBOT_FORWARD_BATCH_F32, ROBOT_INVERSE_BATCH_F32, ROBOT_LAMBDA_BATCH_F32,
    ROBOT_FORWARD_LAMBDA_BATCH_F32, ROBOT_FORWARD_BATCH_F32_PAYLOADS,
    ROBOT_INVERSE_BATCH_F32_PAYLOADS, ROBOT_MASS_BATCH_F32, ROBOT_MASS_BATCH_F32_PAYLOADS;

static uint32_t solve_batch_f32(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                                uint32_t count, tfa_reply *reply)
{
    const struct solvers batch_f32 = {ROBOT_FORWARD_BATCH_F32,
                                      ROBOT_INVERSE_BATCH_F32,
                                      ROBOT_LAMBDA_BATCH_F32,
                                      ROBOT_FORWARD_LAMBDA_BATCH_F32,
                                      ROBOT_FORWARD_BATCH_F32_PAYLOADS,
                                      ROBOT_INVERSE_BATCH_F32_PAYLOADS,
                                      ROBOT_MASS_BATCH_F32,
                                      ROBOT_MASS_BATCH_F32_PAYLOADS};
    return solve_by(batch_f32, host, r, k, count, reply);
}
#endif

#define SPECIALISED_STRING_OF(x) #x
#define SPECIALISED_STRING(x) SPECIALISED_STRING_OF(x)

__attribute__((visibility("default")))
const struct tfa_specialised_kernel tfa_specialised_kernel = {
    .abi = TFA_SPECIALISED_ABI,
    .request_bytes = sizeof(tfa_request),
    .reply_bytes = sizeof(tfa_reply),
    .model_bytes = sizeof(struct tfa_model),
    .model = ROBOT_HASH,
    .isa = SPECIALISED_STRING(TFA_ISA_NAME),
    .compiler = __VERSION__,
    .algorithms = ROBOT_ALGORITHMS,
    .bodies = ROBOT_BODIES,
    .lanes = ROBOT_BATCH_LANES,
    .supports = supports_request,
    .solve = solve,
#if ROBOT_BATCH_LANES
    .solve_batch = solve_batch,
#endif
#if ROBOT_BATCH_F32_LANES
    .lanes_f32 = ROBOT_BATCH_F32_LANES,
    .supports_f32 = supports_request_f32,
    .solve_batch_f32 = solve_batch_f32,
#endif
};
