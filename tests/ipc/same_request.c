/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compares requests field by field.
 */
#include "same_request.h"

#include "interface/fields.h"
#include "test.h"

static void assert_same_array(const void *sent, const void *got, size_t bytes)
{
    assert_int_equal(sent == NULL || bytes == 0, got == NULL);
    if (got)
        assert_memory_equal(sent, got, bytes);
}

static void assert_same_numbers(const double *sent, const double *got, size_t count)
{
    assert_same_array(sent, got, count * sizeof *sent);
}

static void assert_same_scalars(const tfa_request *sent, const tfa_request *got)
{
    assert_int_equal(sent->op, got->op);
    assert_int_equal(sent->method, got->method);
    assert_int_equal(sent->estimate, got->estimate);
    assert_int_equal(sent->frame, got->frame);
    assert_int_equal(sent->refine, got->refine);
    assert_int_equal(sent->flags, got->flags);
    assert_int_equal(sent->count, got->count);
    assert_int_equal(sent->tip_count, got->tip_count);
    assert_int_equal(sent->wrench_count, got->wrench_count);
    assert_int_equal(sent->payload_count, got->payload_count);
    assert_int_equal(sent->locked_count, got->locked_count);
    assert_int_equal(sent->rows, got->rows);
    assert_int_equal(sent->rank_loss, got->rank_loss);
    assert_int_equal(sent->constraints, got->constraints);
}

void assert_same_request(const request_sizes *sizes, const tfa_request *sent,
                         const tfa_request *got)
{
    const size_t count = sent->count, base = sizes->base_freedoms > 0 ? count : 0;
    assert_same_scalars(sent, got);
    assert_memory_equal(sent->tips, got->tips, sent->tip_count * sizeof *sent->tips);
    assert_memory_equal(sent->wrench_frames, got->wrench_frames,
                        sent->wrench_count * sizeof *sent->wrench_frames);
    assert_memory_equal(sent->payload_frames, got->payload_frames,
                        sent->payload_count * sizeof *sent->payload_frames);
    assert_same_array(sent->locked, got->locked, sent->locked_count * sizeof *sent->locked);
    assert_same_numbers(sent->q, got->q, count * sizes->q_count);
    assert_same_numbers(sent->v, got->v, count * sizes->v_count);
    assert_same_numbers(sent->tau, got->tau, count * sizes->v_count);
    assert_same_numbers(sent->qdd, got->qdd, count * sizes->v_count);
    assert_same_numbers(sent->base_pose, got->base_pose, 7 * base);
    assert_same_numbers(sent->base_twist, got->base_twist, 6 * base);
    assert_same_numbers(sent->base_wrench, got->base_wrench, 6 * base);
    assert_same_numbers(sent->base_acceleration, got->base_acceleration, 6 * base);
    assert_same_numbers(sent->gravity, got->gravity, 3);
    assert_same_numbers(sent->wrenches, got->wrenches, count * sent->wrench_count * 6);
    assert_same_numbers(sent->task_acceleration, got->task_acceleration,
                        count * sent->tip_count * (sent->rows == TFA_ROWS_POINT ? 3 : 6));
    assert_same_numbers(sent->rank_threshold, got->rank_threshold, 1);
    assert_same_numbers(sent->characteristic_length, got->characteristic_length, 1);
    assert_same_numbers(sent->payloads, got->payloads,
                        (size_t)sent->payload_count * TFA_PAYLOAD_NUMBERS);
    assert_same_numbers(sent->modes, got->modes, count * sizes->modes);
    assert_same_numbers(sent->mode_velocities, got->mode_velocities, count * sizes->modes);
    assert_same_numbers(sent->constraint_acceleration, got->constraint_acceleration,
                        count * tfa_constraint_numbers(sent));
    assert_same_numbers(sent->stabilisation, got->stabilisation, 2);
    assert_same_numbers(sent->torque_weights, got->torque_weights, sizes->v_count);
}
