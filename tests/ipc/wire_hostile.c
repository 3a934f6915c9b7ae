/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile bytes in a request slot: a decoded request stays inside the copy of its slot, and its
 * reply inside a reply slot.
 */
#include "fuzz/random.h"
#include "ipc/wire_reply.h"
#include "test.h"
#include "wire_slot.h"

/* True when `count` items from `at` on lie within the copy, or there are none. */
static bool inside(const void *at, size_t bytes, const void *copy, size_t size)
{
    const unsigned char *begin = copy, *first = at;
    return !at || (first >= begin && bytes <= size && first + bytes <= begin + size);
}

/* The arrays of a decoded request lie in the copy of the slot, whatever its counts say. */
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
    assert_true(inside(r->constraint_acceleration, count * tfa_constraint_numbers(r), copy, size));
    assert_true(inside(r->stabilisation, 2 * sizeof(double), copy, size));
    assert_true(inside(r->torque_weights, s->v_count * sizeof(double), copy, size));
    assert_true(inside(r->rank_threshold, sizeof(double), copy, size));
    assert_true(inside(r->payloads, r->payload_count * sizeof(double[10]), copy, size));
    assert_true(inside(r->modes, count * s->modes, copy, size));
    assert_true(inside(r->mode_velocities, count * s->modes, copy, size));
    assert_true(inside(r->locked, r->locked_count * sizeof(uint32_t), copy, size));
}

/* The answers that a decoded request asks for fit into a reply slot. */
static void assert_reply_inside(const tfa_wire_shape *s, const tfa_wire_reply_shape *reply_shape)
{
    const size_t size = tfa_wire_reply_capacity(s);
    unsigned char *slot = wire_slot(size);
    tfa_reply out;
    tfa_wire_reply_buffers(s, reply_shape, slot, &out);
#define INSIDE(block, field, ...)                                                                  \
    assert_true(                                                                                   \
        inside(out.field, tfa_wire_reply_width(s, TFA_WIRE_##block, reply_shape), slot, size));
    TFA_OUTPUT_LIST(INSIDE)
#undef INSIDE
    free(slot);
}

/* Random lines: the copy stays within the slot, the pointers within the copy. The slots are
 * allocated to the byte, so AddressSanitizer sees one step too far. */
TEST(hostile_lines_stay_inside)
{
    const tfa_wire_shape *shapes[] = {&wire_arm, &wire_dog};
    struct random_source bits = {1};
    for (int i = 0; i < 20000; i++) {
        const tfa_wire_shape *s = shapes[i & 1];
        const size_t size = tfa_wire_request_capacity(s);
        uint64_t *slot = malloc(size), *copy = malloc(size);
        for (size_t k = 0; k < size / 8; k++)
            slot[k] = random_next(&bits);
        tfa_wire_request *line = (tfa_wire_request *)(void *)slot;
        if (i & 2)
            line->dof = s->q_count + s->v_count + s->base_freedoms + s->modes;
        if (i & 4)
            line->count %= s->max_batch + 1;
        if (i & 8)
            line->op %= TFA_OP_LAST + 1;
        if (i & 16) { /* sometimes valid counts, one too many, or none */
            line->wrench_count %= TFA_MAX_WRENCHES + 2;
            line->payload_count %= TFA_MAX_PAYLOADS + 2;
            line->locked_count %= s->v_count + 2;
            line->constraints &= (1u << (s->max_tips + 1) % 32) - 1;
        }
        tfa_wire_copy_request(s, &(tfa_wire_form){0}, slot, copy);
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
