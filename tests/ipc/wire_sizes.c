/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sizes of slots: a common exchange is small; the reply to an accepted request fits, and a request
 * whose reply would not fit is refused.
 */
#include "ipc/ring.h"
#include "ipc/wire_reply.h"
#include "test.h"
#include "wire_slot.h"

static const tfa_wire_shape humanoid = {.q_count = 47,
                                        .v_count = 47,
                                        .base_freedoms = 6,
                                        .frames = 60,
                                        .max_batch = 2048,
                                        .max_tips = TFA_DEFAULT_TIPS};

TEST(limits_are_kept)
{
    const tfa_wire_shape large = {.q_count = 300, .v_count = 300, .max_batch = 64};
    const tfa_wire_shape middle = {.q_count = 256, .v_count = 256, .max_batch = 64};
    void *slot = wire_slot(tfa_wire_request_capacity(&large));
    tfa_field field;
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1};
    tfa_wire_reply_shape reply_shape;
    const uint64_t want = tfa_wire_want(&r, NULL);
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
    const size_t request_size = tfa_wire_request_capacity(&wire_arm);
    const size_t reply_size = tfa_wire_reply_capacity(&wire_arm);
    unsigned char *slot = wire_slot(request_size), *answered = wire_slot(reply_size);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = x, .v = x, .tau = x};
    tfa_reply reply = {.qdd = qdd, .answers = &answer};
    tfa_wire_reply_shape reply_shape;
    assert_int_equal(tfa_wire_encode_request(&wire_arm, &r, tfa_wire_want(&r, &reply), 1, 1, slot,
                                             &reply_shape, NULL),
                     TFA_OK);
    assert_in_range(bytes_written(slot, request_size), 1, 4 * TFA_CACHE_LINE);
    reply = (tfa_reply){.model = UINT64_MAX};
    tfa_wire_reply_buffers(&wire_arm, &reply_shape, answered, &reply);
    memcpy(reply.qdd, x, sizeof x);
    *reply.answers = (tfa_answer){0};
    assert_null(reply.poses);
    tfa_wire_encode_reply(&reply, reply_shape.want, answered);
    assert_in_range(bytes_written(answered, reply_size), 1, 3 * TFA_CACHE_LINE);
    free(slot);
    free(answered);
}

/* The largest answer for one state fits into a slot, whatever the op; arrays do not overlap. */
TEST(largest_reply_fits)
{
    const size_t size = tfa_wire_reply_capacity(&wire_dog);
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        const tfa_request r = {.op = (tfa_op)op,
                               .flags = TFA_WANT_ALL,
                               .count = 1,
                               .tip_count = TFA_MAX_TIPS,
                               .constraints = UINT32_MAX};
        const tfa_wire_reply_shape reply_shape = tfa_wire_reply_shape_of(&wire_dog, &r);
        unsigned char *slot = wire_slot(size), *end = slot + TFA_WIRE_LINE;
        tfa_reply out;
        assert_int_equal(reply_shape.rows, 6 * TFA_MAX_TIPS);
        tfa_wire_reply_buffers(&wire_dog, &reply_shape, slot, &out);
#define BEHIND(block, field, ...)                                                                  \
    if (out.field) {                                                                               \
        assert_ptr_equal(out.field, end);                                                          \
        end += tfa_wire_reply_width(&wire_dog, TFA_WIRE_##block, &reply_shape);                    \
    }
        TFA_OUTPUT_LIST(BEHIND)
#undef BEHIND
        assert_true(end <= slot + size);
        assert_non_null(out.frame_poses);
        free(slot);
    }
}

/* A batch of any size fits with what every state has; the rest shares TFA_WIRE_SHARED_BYTES. */
TEST(large_batches_share)
{
    const tfa_wire_shape *large[] = {&humanoid, &wire_dog, &wire_arm};
    for (size_t k = 0; k < 3; k++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
            const tfa_wire_shape *shape = large[k];
            tfa_request r = {.op = (tfa_op)op, .tip_count = shape->max_tips, .count = 1};
            r.constraints = tfa_all_constraints(shape->max_tips);
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
    const size_t bytes = 8 * (47 + 6 + 2 + 3 + 7 * TFA_DEFAULT_TIPS);
    assert_true(tfa_wire_reply_capacity(&humanoid) <=
                TFA_WIRE_LINE + TFA_WIRE_SHARED_BYTES + humanoid.max_batch * bytes);
    const tfa_ring_layout layout = tfa_ring_layout_of(&humanoid, 16);
    assert_true(layout.request_bytes + layout.reply_bytes <= (size_t)256 << 20);
    const tfa_request r = {
        .op = TFA_OP_FORWARD_DYNAMICS, .flags = TFA_WANT_POSES, .tip_count = 1, .count = 2048};
    tfa_field field;
    tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&humanoid, &r);
    assert_int_equal(tfa_wire_check_reply_shape(&humanoid, &shape, &field), TFA_OK);
    shape.want |= TFA_WIRE_BIT(FRAME_POSES);
    assert_int_equal(tfa_wire_check_reply_shape(&humanoid, &shape, &field), TFA_E_SIZE);
    assert_int_equal(field, TFA_FIELD_COUNT);
}
