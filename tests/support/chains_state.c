/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Chains with the kernels' own state for them.
 */
#include "chains_state.h"

#include "dynamics/solve/load.h"
#include "interface/kernel_table.h"
#include "models.h"
#include "random_robot.h"
#include "test.h"

void bench_load(struct bench *b, chain_mechanism mechanism, tfa_base base, uint64_t seed)
{
    const tfa_model_options options = {.base = base};
    random_source r = {seed + 1};
    b->model = compiled(b->d, &options);
    b->n = tfa_model_v_count(b->model);
    b->q = calloc(tfa_model_q_count(b->model) + 7, sizeof *b->q);
    b->v = calloc(b->n, sizeof *b->v);
    b->tau = calloc(b->n, sizeof *b->tau);
    assert_true(b->q && b->v && b->tau);
    chain_coordinates(mechanism, b->d, seed + 2, b->q);
    for (uint32_t k = 0; k < b->n; k++) {
        b->v[k] = random_uniform(&r, -1, 1);
        b->tau[k] = random_uniform(&r, -1, 1);
    }
}

struct bench bench_open(chain_mechanism mechanism, uint32_t links, tfa_base base, uint64_t seed)
{
    struct bench b = {.d = chain_create(mechanism, links, seed)};
    bench_load(&b, mechanism, base, seed);
    return b;
}

void bench_close(struct bench *b)
{
    free(b->memory);
    free(b->tau);
    free(b->v);
    free(b->q);
    tfa_model_free(b->model);
    chain_free(b->d);
}

tfa_request bench_request(const struct bench *b)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .count = 1,
                     .wrench_count = b->wrench_count,
                     .wrenches = b->wrenches,
                     .q = b->q,
                     .v = b->v,
                     .tau = b->tau,
                     .base_pose = pose};
    memcpy(r.wrench_frames, b->wrench_frames, sizeof b->wrench_frames);
    return r;
}

struct state *bench_state(struct bench *b)
{
    const struct tfa_kernel *kernel = &tfa_kernel_f128_base;
    const tfa_request request = bench_request(b);
    const struct tfa_reserved reserved = {TFA_METHODS_ALL, TFA_DEFAULT_TIPS};
    const size_t size = (kernel->size(b->model, reserved) + 63) / 64 * 64;
    b->memory = aligned_alloc(64, size);
    assert_non_null(b->memory);
    b->s = kernel->init(b->model, reserved, b->memory);
    TFA_V(load)(b->s, &request, 0, 1);
    return b->s;
}
