/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies through slots: nothing is lost, nothing hostile reaches beyond a slot.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "client/wire.h"

#define BATCH 3

static const tfa_wire_shape arm = {.q_count = 7, .v_count = 7, .max_batch = 1};
static const tfa_wire_shape dog = {
    .q_count = 12, .v_count = 11, .base_freedoms = 6, .max_batch = BATCH};

static uint64_t seed = 88172645463325252u;

static uint64_t random_bits(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

static const double *numbers(size_t count)
{
    double *x = malloc((count + 1) * sizeof *x);
    for (size_t i = 0; i < count; i++)
        x[i] = (double)(random_bits() >> 11);
    return x;
}

static void *exact(size_t size)
{
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    memset(memory, 0xa5, size);
    return memory;
}

static void assert_same(const double *a, const double *b, size_t count)
{
    assert_int_equal(a == NULL, b == NULL);
    if (a)
        assert_memory_equal(a, b, count * sizeof *a);
}

/* A request with everything; `without` leaves out block k where bit k is set. */
static tfa_request full_request(const tfa_wire_shape *s, uint32_t without)
{
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .method = TFA_METHOD_TFA,
                     .estimate = TFA_ESTIMATE_ALWAYS,
                     .frame = TFA_FRAME_WORLD,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = TFA_WANT_SPECTRUM,
                     .count = BATCH,
                     .tip_count = 3,
                     .wrench_count = 2,
                     .tips = {5, 0, 70000},
                     .wrench_frames = {UINT32_MAX, 4}};
    const double **arrays[] = {&r.q,         &r.v,          &r.tau,         &r.qdd,
                               &r.base_pose, &r.base_twist, &r.base_wrench, &r.base_acceleration,
                               &r.gravity,   &r.wrenches};
    const size_t width[] = {s->q_count, s->v_count, s->v_count, s->v_count, 7, 6, 6, 6, 1, 12};
    for (uint32_t k = 0; k < TFA_WIRE_REQUEST_BLOCKS; k++)
        *arrays[k] = without >> k & 1 ? NULL : numbers(BATCH * width[k]);
    return r;
}

static void free_request(const tfa_request *r)
{
    const double *arrays[] = {r->q,         r->v,          r->tau,         r->qdd,
                              r->base_pose, r->base_twist, r->base_wrench, r->base_acceleration,
                              r->gravity,   r->wrenches};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free((void *)(uintptr_t)arrays[k]);
}

static void compare(const tfa_wire_shape *s, const tfa_request *a, const tfa_request *b)
{
    assert_int_equal(a->op, b->op);
    assert_int_equal(a->method, b->method);
    assert_int_equal(a->estimate, b->estimate);
    assert_int_equal(a->frame, b->frame);
    assert_int_equal(a->refine, b->refine);
    assert_int_equal(a->flags, b->flags);
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->tip_count, b->tip_count);
    assert_int_equal(a->wrench_count, b->wrench_count);
    assert_memory_equal(a->tips, b->tips, a->tip_count * sizeof *a->tips);
    assert_memory_equal(a->wrench_frames, b->wrench_frames,
                        a->wrench_count * sizeof *a->wrench_frames);
    assert_same(a->q, b->q, BATCH * s->q_count);
    assert_same(a->v, b->v, BATCH * s->v_count);
    assert_same(a->tau, b->tau, BATCH * s->v_count);
    assert_same(a->qdd, b->qdd, BATCH * s->v_count);
    assert_same(a->base_pose, b->base_pose, BATCH * 7);
    assert_same(a->base_twist, b->base_twist, BATCH * 6);
    assert_same(a->base_wrench, b->base_wrench, BATCH * 6);
    assert_same(a->base_acceleration, b->base_acceleration, BATCH * 6);
    assert_same(a->gravity, b->gravity, 3);
    assert_same(a->wrenches, b->wrenches, BATCH * 12);
}

/* Every subset of the optional blocks arrives as it was sent. */
static void requests_arrive(void **state)
{
    (void)state;
    const size_t size = tfa_wire_request_capacity(&dog);
    for (uint32_t without = 0; without < 1u << TFA_WIRE_REQUEST_BLOCKS; without++) {
        tfa_request sent = full_request(&dog, without), got;
        void *slot = exact(size), *copy = exact(size);
        tfa_wire_ask ask, asked;
        tfa_field culprit;
        assert_int_equal(
            tfa_wire_encode_request(&dog, &sent, tfa_wire_want(&sent, NULL), 7, 8, slot, &ask),
            TFA_OK);
        tfa_wire_copy_request(&dog, slot, copy);
        assert_int_equal(tfa_wire_decode_request(&dog, copy, &got, &asked, &culprit), TFA_OK);
        assert_int_equal(((tfa_wire_request *)copy)->id, 7);
        assert_memory_equal(&ask, &asked, sizeof ask);
        compare(&dog, &sent, &got);
        free_request(&sent);
        free(slot);
        free(copy);
    }
}

/* What tfa_request_check refuses must reach it. */
static void nonsense_arrives(void **state)
{
    (void)state;
    const size_t size = tfa_wire_request_capacity(&arm);
    void *slot = exact(size);
    tfa_request r = {.op = (tfa_op)77,
                     .method = (tfa_method)100000,
                     .frame = (tfa_reference_frame)-1,
                     .count = 0,
                     .tip_count = 9,
                     .wrench_count = 100},
                got;
    tfa_wire_ask ask;
    tfa_field culprit;
    assert_int_equal(tfa_wire_encode_request(&arm, &r, 0, 1, 1, slot, &ask), TFA_OK);
    assert_int_equal(tfa_wire_decode_request(&arm, slot, &got, &ask, &culprit), TFA_OK);
    assert_int_equal(got.op, 77);
    assert_int_equal(got.method, 65535);
    assert_int_equal(got.frame, 65535);
    assert_int_equal(got.count, 0);
    assert_int_equal(got.tip_count, 9);
    assert_int_equal(got.wrench_count, 100);
    assert_null(got.q);
    free(slot);
}

static void limits_are_kept(void **state)
{
    (void)state;
    const tfa_wire_shape large = {.q_count = 300, .v_count = 300, .max_batch = 64};
    const tfa_wire_shape middle = {.q_count = 256, .v_count = 256, .max_batch = 64};
    void *slot = exact(tfa_wire_request_capacity(&large));
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1};
    tfa_wire_ask ask;
    const uint32_t want = tfa_wire_want(&r, NULL);
    assert_int_equal(tfa_wire_encode_request(&large, &r, want, 1, 1, slot, &ask),
                     TFA_E_UNSUPPORTED);
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &ask), TFA_OK);
    r.count = 2; /* 2 x 512 KiB fit into a slot, 3 do not */
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &ask), TFA_OK);
    r.count = 3;
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &ask), TFA_E_SIZE);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.count = 65;
    assert_int_equal(tfa_wire_encode_request(&large, &r, tfa_wire_want(&r, NULL), 1, 1, slot, &ask),
                     TFA_E_SIZE);
    free(slot);
}

/* The common exchange is a few cache lines. */
static void common_request_is_small(void **state)
{
    (void)state;
    static const double x[7] = {0};
    unsigned char *slot = exact(tfa_wire_request_capacity(&arm));
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = x, .v = x, .tau = x};
    tfa_wire_ask ask;
    assert_int_equal(tfa_wire_encode_request(&arm, &r, tfa_wire_want(&r, NULL), 1, 1, slot, &ask),
                     TFA_OK);
    size_t end = tfa_wire_request_capacity(&arm);
    while (slot[end - 1] == 0xa5)
        end--;
    assert_true(end <= (size_t)4 * 64);
    free(slot);
}

/* Random lines: the copy stays within the slot, the pointers within the copy. The slots are
 * allocated to the byte, so AddressSanitizer sees one step too far. */
static void hostile_lines_stay_inside(void **state)
{
    (void)state;
    const tfa_wire_shape *shapes[] = {&arm, &dog};
    for (int i = 0; i < 20000; i++) {
        const tfa_wire_shape *s = shapes[i & 1];
        const size_t size = tfa_wire_request_capacity(s);
        uint64_t *slot = malloc(size), *copy = malloc(size);
        for (size_t k = 0; k < size / 8; k++)
            slot[k] = random_bits();
        tfa_wire_request *line = (tfa_wire_request *)(void *)slot;
        if (i & 2)
            line->dof = s->q_count + s->v_count + s->base_freedoms;
        if (i & 4)
            line->count %= s->max_batch + 1;
        if (i & 8)
            line->op %= 5;
        tfa_wire_copy_request(s, slot, copy);
        tfa_request r;
        tfa_wire_ask ask;
        tfa_field culprit;
        if (tfa_wire_decode_request(s, copy, &r, &ask, &culprit) == TFA_OK) {
            const unsigned char *end = (unsigned char *)copy + size;
            assert_true(r.count <= s->max_batch);
            assert_true(!r.q || (const unsigned char *)(r.q + r.count * s->q_count) <= end);
            assert_true(!r.gravity || (const unsigned char *)(r.gravity + 3) <= end);
            unsigned char *reply = exact(tfa_wire_reply_capacity(s));
            tfa_reply out;
            tfa_wire_reply_buffers(s, &ask, reply, &out);
            if (out.lambda_inv)
                assert_true((unsigned char *)(out.lambda_inv + (size_t)36 * ask.tip_count *
                                                                   ask.tip_count * ask.count) <=
                            reply + tfa_wire_reply_capacity(s));
            free(reply);
        }
        free(slot);
        free(copy);
    }
}

static void replies_arrive(void **state)
{
    (void)state;
    unsigned char *slot = exact(tfa_wire_reply_capacity(&dog));
    const tfa_request r = {
        .op = TFA_OP_FORWARD_DYNAMICS, .flags = TFA_WANT_SPECTRUM, .count = 2, .tip_count = 1};
    double qdd[22], base[12], lambda[72];
    tfa_answer answers[2];
    tfa_spectrum spectrum[2];
    tfa_reply mine = {.qdd = qdd,
                      .base_acceleration = base,
                      .lambda_inv = lambda,
                      .spectrum = spectrum,
                      .answers = answers};
    const tfa_wire_ask ask = {.count = 2, .tip_count = 1, .want = tfa_wire_want(&r, &mine)};
    tfa_reply inside = {.status = TFA_E_NOT_COMPUTED, .field = TFA_FIELD_Q, .index = 3, .state = 1};
    tfa_wire_reply_buffers(&dog, &ask, slot, &inside);
    assert_null(inside.tau);
    assert_null(inside.mass_matrix);
    for (int i = 0; i < 22; i++)
        inside.qdd[i] = i;
    inside.lambda_inv[71] = 71;
    inside.base_acceleration[11] = 11;
    inside.spectrum[1].rank = 5;
    inside.answers[1] = (tfa_answer){.status = -15, .method = 3, .error_estimate = 0.5};
    tfa_wire_encode_reply(&inside, ask.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), ask.want);
    tfa_wire_copy_answers(&dog, &ask, slot, &mine);
    assert_int_equal(mine.status, TFA_E_NOT_COMPUTED);
    assert_int_equal(mine.field, TFA_FIELD_Q);
    assert_int_equal(mine.index, 3);
    assert_int_equal(mine.state, 1);
    assert_true(qdd[21] == 21 && lambda[71] == 71 && base[11] == 11);
    assert_int_equal(spectrum[1].rank, 5);
    assert_true(answers[1].status == -15 && answers[1].method == 3);
    inside.status = TFA_E_VALUE;
    tfa_wire_encode_reply(&inside, ask.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), 0);
    free(slot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(requests_arrive),           cmocka_unit_test(nonsense_arrives),
        cmocka_unit_test(limits_are_kept),           cmocka_unit_test(common_request_is_small),
        cmocka_unit_test(hostile_lines_stay_inside), cmocka_unit_test(replies_arrive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
