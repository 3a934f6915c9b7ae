/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: DDS requests with fields and lengths of sequences from any bytes. A request is
 * refused by field or computed, and its reply passes to a sample and back.
 */
#include <string.h>

#include "dds/topics/dds_convert.h"
#include "fuzz_service.h"

#define BATCH 3
#define NUMBERS 512 /* of the longest sequence */
#define INDICES 16
#define TIPS 12 /* more are refused */
#define ROWS (6 * TIPS)
#define ANSWERS (BATCH * ROWS * ROWS) /* of the largest answer */

typedef struct bytes {
    const uint8_t *at;
    size_t left;
} bytes;

/* One buffer for every answer. */
typedef struct buffers {
    double block[TFA_WIRE_REPLY_BLOCKS][ANSWERS];
} buffers;

/* The next number of the input; zeros at its end. */
static uint32_t next(bytes *b, size_t size)
{
    uint32_t x = 0;
    const size_t n = b->left < size ? b->left : size;
    memcpy(&x, b->at, n);
    b->at += n;
    b->left -= n;
    return x;
}

/* A length that is often right and sometimes not. */
static dds_sequence_double make_doubles(bytes *b, double *numbers, uint32_t expected)
{
    const uint32_t choice = next(b, 1);
    const uint32_t length = choice < 128   ? expected % NUMBERS
                            : choice < 192 ? 0
                                           : next(b, 2) % NUMBERS;
    for (uint32_t i = 0; i < length; i++)
        numbers[i] = (double)(int8_t)next(b, 1) * 0.05;
    if (length && choice % 16 == 15)
        numbers[0] = NAN;
    return (dds_sequence_double){length, length, numbers, false};
}

static dds_sequence_unsigned_long make_indices(bytes *b, uint32_t *indices)
{
    const uint32_t length = next(b, 1) % INDICES;
    for (uint32_t i = 0; i < length; i++)
        indices[i] = next(b, 1);
    return (dds_sequence_unsigned_long){length, length, indices, false};
}

static void make_arrays(bytes *b, totalforce_dds_Request *s)
{
    static double numbers[15][NUMBERS];
    const uint32_t n = s->count, tips = s->tips._length;
    const struct {
        dds_sequence_double *sequence;
        uint32_t expected;
    } arrays[] = {{&s->q, 7 * n},
                  {&s->v, 7 * n},
                  {&s->tau, 7 * n},
                  {&s->qdd, 7 * n},
                  {&s->base_pose, 0},
                  {&s->base_twist, 0},
                  {&s->base_wrench, 0},
                  {&s->base_acceleration, 0},
                  {&s->gravity, 3},
                  {&s->wrenches, 6 * n * s->wrench_frames._length},
                  {&s->payloads, TFA_PAYLOAD_NUMBERS * s->payload_frames._length},
                  {&s->task_acceleration, tfa_tip_rows(s->rows) * n * tips},
                  {&s->rank_threshold, 1},
                  {&s->modes, 0},
                  {&s->mode_velocities, 0}};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        *arrays[i].sequence = make_doubles(b, numbers[i], arrays[i].expected);
}

static void make_request(bytes *b, totalforce_dds_Request *s)
{
    static uint32_t indices[4][INDICES];
    *s = (totalforce_dds_Request){.op = next(b, 1) % (TFA_OP_LAST + 2),
                                  .method = next(b, 1) % 20,
                                  .estimate = next(b, 1) % 5,
                                  .frame = next(b, 1) % 4,
                                  .refine = next(b, 1) % 4,
                                  .flags = next(b, 2) % (TFA_WANT_ALL + 2),
                                  .rows = next(b, 1) % 3,
                                  .rank_loss = next(b, 1) % 4,
                                  .constraints = next(b, 1),
                                  .count = next(b, 1) % (BATCH + 2)};
    s->tips = make_indices(b, indices[0]);
    s->wrench_frames = make_indices(b, indices[1]);
    s->payload_frames = make_indices(b, indices[2]);
    s->locked = make_indices(b, indices[3]);
    make_arrays(b, s);
}

static tfa_reply reply_into(buffers *b)
{
    tfa_reply reply = {0};
#define POINT_AT(name, field, ...) reply.field = (void *)b->block[TFA_WIRE_##name];
    TFA_OUTPUT_LIST(POINT_AT)
#undef POINT_AT
    return reply;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static tfa_workspace *workspace;
    static buffers out, in;
    const tfa_workspace_options options = {.max_tips = TIPS};
    const tfa_wire_shape shape = {.q_count = 7,
                                  .v_count = 7,
                                  .frames = tfa_model_frame_count(fuzz_model()),
                                  .max_batch = BATCH,
                                  .max_tips = TIPS};
    bytes b = {data, size};
    totalforce_dds_Request sample;
    totalforce_dds_Reply reply_sample = {0};
    tfa_request request;
    tfa_dds_field_error error;
    if (!workspace)
        require(tfa_workspace_create(fuzz_model(), &options, &workspace) == TFA_OK);
    make_request(&b, &sample);
    if (tfa_dds_request_view(&sample, &shape, &request, &error) != TFA_OK) {
        require(is_known_status(error.status) && error.field != TFA_FIELD_NONE);
        return 0;
    }
    tfa_reply reply = reply_into(&out), back = reply_into(&in);
    const int status = tfa_compute(workspace, &request, &reply);
    require(is_known_status(status));
    const tfa_wire_reply_shape reply_shape = tfa_wire_reply_shape_of(&shape, &request);
    tfa_dds_reply_fill(&reply, &shape, &reply_shape, &reply_sample);
    require(tfa_dds_reply_read(&reply_sample, &shape, &reply_shape, &back) == TFA_OK);
    require(back.status == status);
    for (uint32_t k = 0; tfa_wire_has_answers(status) && k < TFA_WIRE_REPLY_BLOCKS; k++)
        if (reply_shape.want >> k & 1)
            require(memcmp(in.block[k], out.block[k],
                           tfa_wire_reply_width(&shape, k, &reply_shape)) == 0);
    return 0;
}
