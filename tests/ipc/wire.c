/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies through slots: nothing is lost, nothing hostile reaches beyond a slot.
 */
#include "ipc/wire.h"
#include "same_request.h"
#include "test.h"

#include <stdbool.h>

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

static const void *numbers(size_t count)
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

/* A request with everything; `without` leaves out block k where bit k is set. */
static tfa_request full_request(const tfa_wire_shape *s, uint32_t without)
{
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .method = TFA_METHOD_TFA,
                     .estimate = TFA_ESTIMATE_ALWAYS,
                     .frame = TFA_FRAME_WORLD,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES,
                     .count = BATCH,
                     .tip_count = 3,
                     .wrench_count = 2,
                     .payload_count = 3,
                     .locked_count = s->v_count, /* odd: the block is padded */
                     .tips = {5, 0, 70000},
                     .wrench_frames = {UINT32_MAX, 4},
                     .payload_frames = {1, UINT32_MAX, 0}};
#define SET(block, array, count)                                                                   \
    r.array = without >> TFA_WIRE_##block & 1 ? NULL : numbers(BATCH * (size_t)(count))
    SET(Q, q, s->q_count);
    SET(V, v, s->v_count);
    SET(TAU, tau, s->v_count);
    SET(QDD, qdd, s->v_count);
    SET(BASE_POSE, base_pose, 7);
    SET(BASE_TWIST, base_twist, 6);
    SET(BASE_WRENCH, base_wrench, 6);
    SET(BASE_ACCELERATION, base_acceleration, 6);
    SET(GRAVITY, gravity, 1);
    SET(WRENCHES, wrenches, 12);
    SET(PAYLOADS, payloads, TFA_PAYLOAD_NUMBERS);
    SET(LOCKED, locked, s->v_count);
#undef SET
    return r;
}

static void free_request(const tfa_request *r)
{
    const void *arrays[] = {r->q,         r->v,          r->tau,         r->qdd,
                            r->base_pose, r->base_twist, r->base_wrench, r->base_acceleration,
                            r->gravity,   r->wrenches,   r->payloads,    r->locked};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free((void *)(uintptr_t)arrays[k]);
}

static request_sizes sizes_of(const tfa_wire_shape *s)
{
    return (request_sizes){s->q_count, s->v_count, s->base_freedoms};
}

/* Every subset of the optional blocks arrives as it was sent. */
TEST(requests_arrive)
{
    const size_t size = tfa_wire_request_capacity(&dog);
    const request_sizes sizes = sizes_of(&dog);
    for (uint32_t without = 0; without < 1u << TFA_WIRE_REQUEST_BLOCKS; without++) {
        tfa_request sent = full_request(&dog, without), got;
        void *slot = exact(size), *copy = exact(size);
        tfa_wire_reply_shape reply_shape, asked;
        tfa_field invalid_field;
        assert_int_equal(tfa_wire_encode_request(&dog, &sent, tfa_wire_want(&sent, NULL), 7, 8,
                                                 slot, &reply_shape),
                         TFA_OK);
        tfa_wire_copy_request(&dog, slot, copy);
        assert_int_equal(tfa_wire_decode_request(&dog, copy, &got, &asked, &invalid_field), TFA_OK);
        assert_int_equal(((tfa_wire_request *)copy)->id, 7);
        assert_memory_equal(&reply_shape, &asked, sizeof reply_shape);
        assert_same_request(&sizes, &sent, &got);
        free_request(&sent);
        free(slot);
        free(copy);
    }
}

/* What tfa_request_check refuses must reach it. */
TEST(nonsense_arrives)
{
    const size_t size = tfa_wire_request_capacity(&arm);
    const double none = 0;
    void *slot = exact(size);
    tfa_request r = {.op = (tfa_op)77,
                     .method = (tfa_method)100000,
                     .frame = (tfa_reference_frame)-1,
                     .count = 0,
                     .tip_count = 9,
                     .wrench_count = 100,
                     .payload_count = 1000,
                     .locked_count = UINT32_MAX},
                got;
    r.wrenches = r.payloads = &none;
    r.locked = &r.locked_count;
    tfa_wire_reply_shape reply_shape;
    tfa_field invalid_field;
    assert_int_equal(tfa_wire_encode_request(&arm, &r, 0, 1, 1, slot, &reply_shape), TFA_OK);
    assert_int_equal(tfa_wire_decode_request(&arm, slot, &got, &reply_shape, &invalid_field),
                     TFA_OK);
    assert_int_equal(got.op, 77);
    assert_int_equal(got.method, 65535);
    assert_int_equal(got.frame, 255);
    assert_int_equal(got.count, 0);
    assert_int_equal(got.tip_count, 9);
    assert_int_equal(got.wrench_count, 100);
    assert_int_equal(got.payload_count, 255);
    assert_int_equal(got.locked_count, UINT32_MAX);
    assert_null(got.q);
    assert_null(got.wrenches);
    assert_null(got.payloads);
    assert_null(got.locked);
    free(slot);
}

TEST(limits_are_kept)
{
    const tfa_wire_shape large = {.q_count = 300, .v_count = 300, .max_batch = 64};
    const tfa_wire_shape middle = {.q_count = 256, .v_count = 256, .max_batch = 64};
    void *slot = exact(tfa_wire_request_capacity(&large));
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1};
    tfa_wire_reply_shape reply_shape;
    const uint32_t want = tfa_wire_want(&r, NULL);
    assert_int_equal(tfa_wire_encode_request(&large, &r, want, 1, 1, slot, &reply_shape),
                     TFA_E_UNSUPPORTED);
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape), TFA_OK);
    r.count = 2; /* 2 x 512 KiB fit into a slot, 3 do not */
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape), TFA_OK);
    r.count = 3;
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape),
                     TFA_E_SIZE);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.count = 65;
    assert_int_equal(
        tfa_wire_encode_request(&large, &r, tfa_wire_want(&r, NULL), 1, 1, slot, &reply_shape),
        TFA_E_SIZE);
    free(slot);
}

static size_t bytes_written(const unsigned char *slot, size_t capacity)
{
    while (capacity > 0 && slot[capacity - 1] == 0xa5)
        capacity--;
    return capacity;
}

/* The common exchange is a few cache lines: 7 joints with q, v and tau, and their qdd. */
TEST(common_exchange_is_small)
{
    static const double x[7] = {0};
    double qdd[7];
    tfa_answer answer;
    const size_t request_size = tfa_wire_request_capacity(&arm);
    const size_t reply_size = tfa_wire_reply_capacity(&arm);
    unsigned char *slot = exact(request_size), *answered = exact(reply_size);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = x, .v = x, .tau = x};
    tfa_reply reply = {.qdd = qdd, .answers = &answer};
    tfa_wire_reply_shape reply_shape;
    assert_int_equal(
        tfa_wire_encode_request(&arm, &r, tfa_wire_want(&r, &reply), 1, 1, slot, &reply_shape),
        TFA_OK);
    assert_in_range(bytes_written(slot, request_size), 1, 4 * TFA_WIRE_LINE);
    reply = (tfa_reply){.model = UINT64_MAX};
    tfa_wire_reply_buffers(&arm, &reply_shape, answered, &reply);
    memcpy(reply.qdd, x, sizeof x);
    *reply.answers = (tfa_answer){0};
    assert_null(reply.poses);
    tfa_wire_encode_reply(&reply, reply_shape.want, answered);
    assert_in_range(bytes_written(answered, reply_size), 1, 3 * TFA_WIRE_LINE);
    free(slot);
    free(answered);
}

/* True when `count` items from `at` on lie within the copy, or there are none. */
static bool inside(const void *at, size_t bytes, const void *copy, size_t size)
{
    const unsigned char *begin = copy, *first = at;
    return !at || (first >= begin && bytes <= size && first + bytes <= begin + size);
}

/* What a decoded request points at lies in the copy of the slot, whatever its counts say. */
static void assert_request_inside(const tfa_wire_shape *s, const tfa_request *r, const void *copy,
                                  size_t size)
{
    const size_t count = r->count * sizeof(double);
    assert_true(r->count <= s->max_batch);
    assert_true(inside(r->q, count * s->q_count, copy, size));
    assert_true(inside(r->v, count * s->v_count, copy, size));
    assert_true(inside(r->tau, count * s->v_count, copy, size));
    assert_true(inside(r->qdd, count * s->v_count, copy, size));
    assert_true(inside(r->base_pose, count * 7, copy, size));
    assert_true(inside(r->base_twist, count * 6, copy, size));
    assert_true(inside(r->base_wrench, count * 6, copy, size));
    assert_true(inside(r->base_acceleration, count * 6, copy, size));
    assert_true(inside(r->gravity, 3 * sizeof(double), copy, size));
    assert_true(inside(r->wrenches, count * 6 * r->wrench_count, copy, size));
    assert_true(inside(r->payloads, r->payload_count * sizeof(double[10]), copy, size));
    assert_true(inside(r->locked, r->locked_count * sizeof(uint32_t), copy, size));
}

/* The answers that a decoded request asks for fit into a reply slot. */
static void assert_reply_inside(const tfa_wire_shape *s, const tfa_wire_reply_shape *reply_shape)
{
    const size_t size = tfa_wire_reply_capacity(s), count = reply_shape->count;
    void *slot = exact(size);
    tfa_reply out;
    tfa_wire_reply_buffers(s, reply_shape, slot, &out);
    assert_true(inside(out.lambda_inv,
                       count * reply_shape->tip_count * reply_shape->tip_count * sizeof(double[36]),
                       slot, size));
    assert_true(inside(out.poses, count * reply_shape->tip_count * sizeof(double[7]), slot, size));
    assert_true(inside(out.spectrum, count * sizeof *out.spectrum, slot, size));
    free(slot);
}

/* The largest answer to one request fits into a slot, and to the byte. */
TEST(largest_reply_fits)
{
    const size_t size = tfa_wire_reply_capacity(&dog);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES,
                           .count = BATCH,
                           .tip_count = TFA_MAX_TIPS};
    const tfa_wire_reply_shape reply_shape = {
        .count = BATCH, .tip_count = TFA_MAX_TIPS, .want = tfa_wire_want(&r, NULL)};
    unsigned char *slot = exact(size);
    tfa_reply out;
    tfa_wire_reply_buffers(&dog, &reply_shape, slot, &out);
    assert_non_null(out.poses); /* the last block */
    assert_ptr_equal(out.poses, slot + size - sizeof(double[BATCH][TFA_MAX_TIPS][7]));
    free(slot);
}

/* Random lines: the copy stays within the slot, the pointers within the copy. The slots are
 * allocated to the byte, so AddressSanitizer sees one step too far. */
TEST(hostile_lines_stay_inside)
{
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
        if (i & 16) { /* sometimes valid counts, one too many, or none */
            line->wrench_count %= TFA_MAX_WRENCHES + 2;
            line->payload_count %= TFA_MAX_PAYLOADS + 2;
            line->locked_count %= s->v_count + 2;
        }
        tfa_wire_copy_request(s, slot, copy);
        tfa_request r;
        tfa_wire_reply_shape reply_shape;
        tfa_field invalid_field;
        if (tfa_wire_decode_request(s, copy, &r, &reply_shape, &invalid_field) == TFA_OK) {
            assert_request_inside(s, &r, copy, size);
            assert_reply_inside(s, &reply_shape);
        }
        free(slot);
        free(copy);
    }
}

TEST(replies_arrive)
{
    unsigned char *slot = exact(tfa_wire_reply_capacity(&dog));
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES,
                           .count = 2,
                           .tip_count = 1};
    double qdd[22], base[12], lambda[72], poses[14];
    tfa_answer answers[2];
    tfa_spectrum spectrum[2];
    tfa_reply mine = {.qdd = qdd,
                      .base_acceleration = base,
                      .lambda_inv = lambda,
                      .spectrum = spectrum,
                      .poses = poses,
                      .answers = answers};
    const tfa_wire_reply_shape reply_shape = {
        .count = 2, .tip_count = 1, .want = tfa_wire_want(&r, &mine)};
    tfa_reply there = {.status = TFA_E_NOT_COMPUTED,
                       .field = TFA_FIELD_BODY,
                       .index = UINT32_MAX,
                       .state = 1,
                       .model = 0x0123456789abcdefu};
    tfa_wire_reply_buffers(&dog, &reply_shape, slot, &there);
    assert_null(there.tau);
    assert_null(there.mass_matrix);
    for (int i = 0; i < 22; i++)
        there.qdd[i] = i;
    there.lambda_inv[71] = 71;
    there.base_acceleration[11] = 11;
    there.spectrum[1].rank = 5;
    there.poses[13] = 13;
    there.answers[1] = (tfa_answer){.status = -15, .method = 3, .error_estimate = 0.5};
    tfa_wire_encode_reply(&there, reply_shape.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), reply_shape.want);
    tfa_wire_copy_answers(&dog, &reply_shape, slot, &mine);
    assert_int_equal(mine.status, TFA_E_NOT_COMPUTED);
    assert_int_equal(mine.field, TFA_FIELD_BODY);
    assert_int_equal(mine.index, UINT32_MAX);
    assert_int_equal(mine.state, 1);
    assert_true(mine.model == 0x0123456789abcdefu);
    assert_true(qdd[21] == 21 && lambda[71] == 71 && base[11] == 11);
    assert_int_equal(spectrum[1].rank, 5);
    assert_true(poses[13] == 13);
    assert_true(answers[1].status == -15 && answers[1].method == 3);
    there.status = TFA_E_VALUE;
    there.model = 1;
    tfa_wire_encode_reply(&there, reply_shape.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), 0);
    assert_true(mine.model == 1); /* a refusal names the model, too */
    free(slot);
}
