/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A chain and the kernels' own state for it, in quadruple precision: for tests that look inside.
 */
#ifndef TESTS_SUPPORT_CHAINS_STATE_H
#define TESTS_SUPPORT_CHAINS_STATE_H

#include <totalforce/totalforce.h>

#include "chains_scan.h"
#include "layout/state.h"

/* A chain, and a state in quadruple precision to look into */
struct bench {
    tfa_description *d;
    tfa_model *model;
    uint32_t n;
    double *q, *v, *tau, wrenches[12];
    uint32_t wrench_frames[2], wrench_count;
    void *memory;
    struct state *s;
};

/** A description in b->d gets its model and random states. */
void bench_load(struct bench *b, chain_mechanism mechanism, tfa_base base, uint64_t seed);
struct bench bench_open(chain_mechanism mechanism, uint32_t links, tfa_base base, uint64_t seed);
void bench_close(struct bench *b);
tfa_request bench_request(const struct bench *b);
/** The state loaded with that request; released by bench_close. */
struct state *bench_state(struct bench *b);

#endif
