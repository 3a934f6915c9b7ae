/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies through slots: nothing is lost, nothing hostile reaches beyond a slot.
 */
#include "ipc/ring.h"
#include "ipc/wire_reply.h"
#include "same_request.h"
#include "test.h"

#include <stdbool.h>

#define BATCH 3

static const tfa_wire_shape arm = {
    .q_count = 7, .v_count = 7, .frames = 9, .max_batch = 1, .max_tips = TFA_DEFAULT_TIPS};
static const tfa_wire_shape dog = {.q_count = 12,
                                   .v_count = 11,
                                   .base_freedoms = 6,
                                   .frames = 20,
                                   .max_batch = BATCH,
                                   .max_tips = TFA_MAX_TIPS};

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
                     .flags = TFA_WANT_ALL,
                     .rows = TFA_ROWS_POINT,
                     .rank_loss = TFA_RANK_REFUSE,
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
    SET(TASK_ACCELERATION, task_acceleration, 9);
    SET(RANK_THRESHOLD, rank_threshold, 1);
    SET(PAYLOADS, payloads, TFA_PAYLOAD_NUMBERS);
    SET(LOCKED, locked, s->v_count);
#undef SET
    return r;
}

static void free_request(const tfa_request *r)
{
    const void *arrays[] = {r->q,
                            r->v,
                            r->tau,
                            r->qdd,
                            r->base_pose,
                            r->base_twist,
                            r->base_wrench,
                            r->base_acceleration,
                            r->gravity,
                            r->wrenches,
                            r->payloads,
                            r->locked,
                            r->task_acceleration,
                            r->rank_threshold};
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
                                                 slot, &reply_shape, NULL),
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
                     .rows = (tfa_rows)300,
                     .rank_loss = (tfa_rank_loss)-1,
                     .tip_count = 8,
                     .wrench_count = 100,
                     .payload_count = 1000,
                     .locked_count = UINT32_MAX},
                got;
    r.wrenches = r.payloads = &none;
    r.locked = &r.locked_count;
    tfa_wire_reply_shape reply_shape;
    tfa_field invalid_field;
    assert_int_equal(tfa_wire_encode_request(&arm, &r, 0, 1, 1, slot, &reply_shape, NULL), TFA_OK);
    assert_int_equal(tfa_wire_decode_request(&arm, slot, &got, &reply_shape, &invalid_field),
                     TFA_OK);
    assert_int_equal(got.op, 77);
    assert_int_equal(got.method, 255);
    assert_int_equal(got.rows, 255);
    assert_int_equal(got.rank_loss, 255);
    assert_int_equal(got.frame, 255);
    assert_int_equal(got.count, 0);
    assert_int_equal(got.tip_count, 8);
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
    tfa_field field;
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1};
    tfa_wire_reply_shape reply_shape;
    const uint32_t want = tfa_wire_want(&r, NULL);
    assert_int_equal(tfa_wire_encode_request(&large, &r, want, 1, 1, slot, &reply_shape, NULL),
                     TFA_E_UNSUPPORTED);
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape, NULL),
                     TFA_OK);
    r.count = 3; /* 3 x 512 KiB fit into a slot, as the derivatives of one state do; 4 do not */
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape, NULL),
                     TFA_OK);
    r.count = 4;
    assert_int_equal(tfa_wire_encode_request(&middle, &r, want, 1, 1, slot, &reply_shape, NULL),
                     TFA_E_SIZE);
    r.op = TFA_OP_DERIVATIVES;
    r.count = 1;
    assert_int_equal(tfa_wire_encode_request(&large, &r, tfa_wire_want(&r, NULL), 1, 1, slot,
                                             &reply_shape, &field),
                     TFA_E_UNSUPPORTED);
    assert_int_equal(field, TFA_FIELD_OP);
    r.op = TFA_OP_KINEMATICS;
    r.tip_count = 1; /* no tips were agreed on */
    assert_int_equal(tfa_wire_encode_request(&large, &r, 0, 1, 1, slot, &reply_shape, &field),
                     TFA_E_SIZE);
    assert_int_equal(field, TFA_FIELD_TIPS);
    r.tip_count = 0;
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.count = 65;
    assert_int_equal(tfa_wire_encode_request(&large, &r, tfa_wire_want(&r, NULL), 1, 1, slot,
                                             &reply_shape, NULL),
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
    assert_int_equal(tfa_wire_encode_request(&arm, &r, tfa_wire_want(&r, &reply), 1, 1, slot,
                                             &reply_shape, NULL),
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
    assert_true(inside(r->task_acceleration,
                       count * r->tip_count * (r->rows == TFA_ROWS_POINT ? 3 : 6), copy, size));
    assert_true(inside(r->rank_threshold, sizeof(double), copy, size));
    assert_true(inside(r->payloads, r->payload_count * sizeof(double[10]), copy, size));
    assert_true(inside(r->locked, r->locked_count * sizeof(uint32_t), copy, size));
}

/* The answers that a decoded request asks for fit into a reply slot. */
static void assert_reply_inside(const tfa_wire_shape *s, const tfa_wire_reply_shape *reply_shape)
{
    const size_t size = tfa_wire_reply_capacity(s);
    unsigned char *slot = exact(size);
    tfa_reply out;
    tfa_wire_reply_buffers(s, reply_shape, slot, &out);
#define INSIDE(block, field, bytes)                                                                \
    assert_true(                                                                                   \
        inside(out.field, tfa_wire_reply_width(s, TFA_WIRE_##block, reply_shape), slot, size));
    TFA_WIRE_REPLY_LIST(INSIDE)
#undef INSIDE
    free(slot);
}

/* The largest answer for one state fits into a slot, whatever the op; arrays do not overlap. */
TEST(largest_reply_fits)
{
    const size_t size = tfa_wire_reply_capacity(&dog);
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        const tfa_request r = {
            .op = (tfa_op)op, .flags = TFA_WANT_ALL, .count = 1, .tip_count = TFA_MAX_TIPS};
        const tfa_wire_reply_shape reply_shape = tfa_wire_reply_shape_of(&dog, &r);
        unsigned char *slot = exact(size), *end = slot + TFA_WIRE_LINE;
        tfa_reply out;
        assert_int_equal(reply_shape.rows, 6 * TFA_MAX_TIPS);
        tfa_wire_reply_buffers(&dog, &reply_shape, slot, &out);
#define BEHIND(block, field, bytes)                                                                \
    if (out.field) {                                                                               \
        assert_ptr_equal(out.field, end);                                                          \
        end += tfa_wire_reply_width(&dog, TFA_WIRE_##block, &reply_shape);                         \
    }
        TFA_WIRE_REPLY_LIST(BEHIND)
#undef BEHIND
        assert_true(end <= slot + size);
        assert_non_null(out.frame_poses);
        free(slot);
    }
}

/* A batch of any size fits with what every state has; the rest shares TFA_WIRE_SHARED_BYTES. */
TEST(large_batches_share)
{
    const tfa_wire_shape s = {.q_count = 47,
                              .v_count = 47,
                              .base_freedoms = 6,
                              .frames = 60,
                              .max_batch = 2048,
                              .max_tips = TFA_DEFAULT_TIPS};
    const tfa_wire_shape *large[] = {&s, &dog, &arm};
    for (size_t k = 0; k < 3; k++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
            const tfa_wire_shape *shape = large[k];
            tfa_request r = {.op = (tfa_op)op, .tip_count = shape->max_tips, .count = 1};
            tfa_field field;
            r.flags = TFA_WANT_ALL;
            for (r.count = 1; r.count <= shape->max_batch; r.count++) {
                const tfa_wire_reply_shape all = tfa_wire_reply_shape_of(shape, &r);
                size_t bytes = TFA_WIRE_LINE;
                for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++)
                    bytes += all.want >> block & 1 ? tfa_wire_reply_width(shape, block, &all) : 0;
                const int status = tfa_wire_check_reply_shape(shape, &all, &field);
                assert_true(status == TFA_OK || (r.count > 1 && status == TFA_E_SIZE));
                if (status == TFA_OK)
                    assert_true(bytes <= tfa_wire_reply_capacity(shape));
                else
                    assert_int_equal(field, TFA_FIELD_COUNT);
            }
        }
}

/* A client with these sizes has a humanoid with a floating base within 256 MiB: replies of
 * accelerations, spectra and poses, and the matrices of some states at once. */
TEST(large_batches_are_small)
{
    const tfa_wire_shape s = {.q_count = 47,
                              .v_count = 47,
                              .base_freedoms = 6,
                              .frames = 60,
                              .max_batch = 2048,
                              .max_tips = TFA_DEFAULT_TIPS};
    const size_t bytes = 8 * (47 + 6 + 2 + 3 + 7 * TFA_DEFAULT_TIPS);
    assert_true(tfa_wire_reply_capacity(&s) <=
                TFA_WIRE_LINE + TFA_WIRE_SHARED_BYTES + s.max_batch * bytes);
    const tfa_ring_layout layout = tfa_ring_layout_of(&s, 16);
    assert_true(layout.request_bytes + layout.reply_bytes <= (size_t)256 << 20);
    const tfa_request r = {
        .op = TFA_OP_FORWARD_DYNAMICS, .flags = TFA_WANT_POSES, .tip_count = 1, .count = 2048};
    tfa_field field;
    tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&s, &r);
    assert_int_equal(tfa_wire_check_reply_shape(&s, &shape, &field), TFA_OK);
    shape.want |= TFA_WIRE_BIT(FRAME_POSES);
    assert_int_equal(tfa_wire_check_reply_shape(&s, &shape, &field), TFA_E_SIZE);
    assert_int_equal(field, TFA_FIELD_COUNT);
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
            line->op %= TFA_OP_LAST + 1;
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
        .count = 2, .tip_count = 1, .rows = 6, .want = tfa_wire_want(&r, &mine)};
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

static uint64_t slot_number(uint32_t block, size_t k)
{
    return (uint64_t)(block + 1) << 32 | k;
}

/* Every block of the replies to every op comes back into its buffer, and into no other; a buffer
 * that is not there is passed over. */
TEST(every_answer_arrives)
{
    enum { WORDS = BATCH * 18 * 18 };
    static uint64_t got[TFA_WIRE_REPLY_BLOCKS][WORDS];
    for (uint32_t k = 0; k < 2 * (TFA_OP_LAST + 1); k++) {
        const tfa_request r = {.op = (tfa_op)(k / 2),
                               .flags = TFA_WANT_ALL,
                               .rows = k & 1 ? TFA_ROWS_POINT : TFA_ROWS_POSE,
                               .count = BATCH,
                               .tip_count = 3};
        tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&dog, &r);
        unsigned char *slot = exact(tfa_wire_reply_capacity(&dog));
        tfa_reply there = {0}, here = {0};
        tfa_wire_reply_buffers(&dog, &shape, slot, &there);
        memset(got, 0, sizeof got);
#define FILL(block, field, bytes)                                                                  \
    for (size_t w = 0;                                                                             \
         there.field && w < tfa_wire_reply_width(&dog, TFA_WIRE_##block, &shape) / 8; w++)         \
        ((uint64_t *)(void *)there.field)[w] = slot_number(TFA_WIRE_##block, w);                   \
    here.field = TFA_WIRE_##block == k ? NULL : (void *)got[TFA_WIRE_##block];
        TFA_WIRE_REPLY_LIST(FILL)
#undef FILL
        assert_int_equal(tfa_wire_want(&r, NULL), k < 2 ? 0 : shape.want);
        tfa_wire_copy_answers(&dog, &shape, slot, &here);
        for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++)
            for (size_t w = 0; w < WORDS; w++) {
                const size_t words = tfa_wire_reply_width(&dog, block, &shape) / 8;
                const bool there_is = shape.want >> block & 1 && block != k && w < words;
                assert_true(words <= WORDS);
                assert_true(got[block][w] == (there_is ? slot_number(block, w) : 0));
            }
        free(slot);
    }
}
