/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_compute allocates nothing: the allocator of this program counts.
 */
#include "support/fixture.h"
#include "support/sanitized.h"
#include "test.h"

#include <stdatomic.h>

static atomic_ulong calls;

#if !defined(SANITIZED) && defined(__GLIBC__)
#define COUNTING 1
/* glibc's own entries, so that the counter needs no dlsym (which allocates). */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *memory);

void *malloc(size_t size)
{
    atomic_fetch_add(&calls, 1);
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    atomic_fetch_add(&calls, 1);
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    atomic_fetch_add(&calls, 1);
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    atomic_fetch_add(&calls, 1);
    return __libc_memalign(alignment, size);
}

void free(void *memory)
{
    atomic_fetch_add(&calls, 1);
    __libc_free(memory);
}
#else
#define COUNTING 0
#endif

TEST(counter_counts)
{
    if (!COUNTING)
        skip();
    unsigned long before = atomic_load(&calls);
    void *volatile memory = malloc(100); /* volatile: or the pair is optimised away */
    free(memory);
    assert_int_equal(atomic_load(&calls) - before, 2);
}

/* The same with what a request may change: payloads that come and go, locked joints. */
static unsigned long change_things(tfa_workspace *w, tfa_request r, tfa_reply *reply)
{
    static const double load[TFA_PAYLOAD_NUMBERS] = {2, 0.1, 0, 0.2, 0.01, 0, 0, 0.01, 0, 0.01};
    static const uint32_t first[] = {0};
    unsigned long answered = 0;
    r.method = TFA_METHOD_AUTO;
    r.refine = 0;
    r.estimate = TFA_ESTIMATE_NEVER;
    r.payloads = load;
    r.payload_frames[0] = r.tips[0];
    r.locked = first;
    for (unsigned k = 0; k < 64; k++) {
        r.op = k & 1 ? TFA_OP_OPERATIONAL_INERTIA : TFA_OP_FORWARD_DYNAMICS;
        r.payload_count = k >> 1 & 1;
        r.locked_count = k >> 2 & 1;
        r.tip_count = k >> 3 & 1 ? 0 : 2;
        r.flags = TFA_WANT_POSES;
        answered += tfa_compute(w, &r, reply) == TFA_OK;
    }
    return answered;
}

/* Every op with every method, a bad request, and a fallback-prone refinement. */
static void every_request_of(test_robot *robot, tfa_workspace *w)
{
    random_states *x = fixture_states(robot, 0, 2, 2);
    const size_t n = robot->n;
    double *numbers =
        calloc(2 * (2 * (size_t)robot->nv + n * n + 12 + 144 + 14) + 1, sizeof *numbers);
    tfa_spectrum spectrum[2];
    tfa_answer answers[2];
    assert_non_null(numbers);
    tfa_reply reply = {.spectrum = spectrum, .answers = answers, .qdd = numbers};
    reply.tau = reply.qdd + 2 * (size_t)robot->nv;
    reply.mass_matrix = reply.tau + 2 * (size_t)robot->nv;
    reply.base_acceleration = reply.mass_matrix + 2 * n * n;
    reply.base_wrench = reply.base_acceleration + 12;
    reply.lambda_inv = reply.base_wrench + 12;
    reply.poses = reply.lambda_inv + 2 * 144;
    tfa_request r = fixture_request(robot, x);
    r.flags = TFA_WANT_SPECTRUM;
    r.estimate = TFA_ESTIMATE_ALWAYS;
    r.tip_count = 2;
    r.tips[0] = (uint32_t)robot->description->link_count - 1;

    unsigned long before = atomic_load(&calls), answered = 0;
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++)
        for (int method = -1; method <= TFA_METHOD_HYBRID; method++)
            for (uint32_t refine = 0; refine <= TFA_MAX_REFINE; refine++) {
                r.op = (tfa_op)op;
                r.method = (tfa_method)method;
                r.refine = refine;
                answered += tfa_compute(w, &r, &reply) == TFA_OK;
            }
    const unsigned long changed = change_things(w, r, &reply);
    unsigned long after = atomic_load(&calls);
    assert_true(answered >= 3 * 4);
    assert_true(changed >= 16);
    assert_int_equal(after - before, 0);
    free(numbers);
    random_states_free(x);
}

static void constrained_requests(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, 2, 2);
    tfa_workspace *w = fixture_workspace(robot->model, TFA_F64);
    double wrenches[2 * 12];
    tfa_reply reply = {.constraint_wrenches = wrenches};
    tfa_request r = fixture_request(robot, x);
    r.constraints = (1u << tfa_model_constraint_count(robot->model)) - 1;
    const unsigned long before = atomic_load(&calls);
    unsigned answered = 0;
    for (r.op = TFA_OP_CONSTRAINED_DYNAMICS; r.op <= TFA_OP_LAST; r.op++)
        answered += tfa_compute(w, &r, &reply) == TFA_OK;
    tfa_posture posture = {
        .q = x->q, .v = x->v, .base_pose = x->base_pose, .base_twist = x->base_twist};
    (void)!tfa_close_loops(w, &r, NULL, &posture);
    assert_int_equal(atomic_load(&calls) - before, 0);
    assert_true(answered > 0 && posture.iterations > 0);
    tfa_workspace_free(w);
    random_states_free(x);
}

static void every_request(test_robot *robot)
{
    tfa_workspace *mixed = fixture_mixed(robot->model, TFA_F32, TFA_RESIDUAL_F64);
    every_request_of(robot, robot->f64);
    every_request_of(robot, mixed);
    tfa_workspace_free(mixed);
    fixture_constrained(robot, constrained_requests);
}

TEST(computing_allocates_nothing)
{
    if (!COUNTING)
        skip();
    for_every_robot(every_request, false);
}
