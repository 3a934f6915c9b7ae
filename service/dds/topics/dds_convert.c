/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the DDS types and the C types of dynamics.h: sizes are checked, arrays are pointed at.
 */
#include "dds/topics/dds_convert.h"

#include <math.h>
#include <stddef.h>
#include <string.h>
#include <time.h>

/* The nested types are laid out as those of dynamics.h, so whole sequences pass without a copy. */
#define SAME_OFFSET(idl, idl_field, c, c_field)                                                    \
    _Static_assert(offsetof(idl, idl_field) == offsetof(c, c_field), #c "." #c_field)
_Static_assert(sizeof(totalforce_dds_Answer) == sizeof(tfa_answer), "Answer");
SAME_OFFSET(totalforce_dds_Answer, status, tfa_answer, status);
SAME_OFFSET(totalforce_dds_Answer, method, tfa_answer, method);
SAME_OFFSET(totalforce_dds_Answer, flags, tfa_answer, flags);
SAME_OFFSET(totalforce_dds_Answer, error_estimate, tfa_answer, error_estimate);
_Static_assert(sizeof(totalforce_dds_Spectrum) == sizeof(tfa_spectrum), "Spectrum");
SAME_OFFSET(totalforce_dds_Spectrum, rank, tfa_spectrum, rank);
SAME_OFFSET(totalforce_dds_Spectrum, eig_min, tfa_spectrum, eig_min);
SAME_OFFSET(totalforce_dds_Spectrum, eig_max, tfa_spectrum, eig_max);

_Static_assert(sizeof(totalforce_dds_RankInfo) == sizeof(tfa_rank), "RankInfo");
SAME_OFFSET(totalforce_dds_RankInfo, rank, tfa_rank, rank);
SAME_OFFSET(totalforce_dds_RankInfo, lost, tfa_rank, lost);
SAME_OFFSET(totalforce_dds_RankInfo, threshold, tfa_rank, threshold);
SAME_OFFSET(totalforce_dds_RankInfo, condition, tfa_rank, condition);
SAME_OFFSET(totalforce_dds_RankInfo, length, tfa_rank, length);
SAME_OFFSET(totalforce_dds_RankInfo, error_estimate, tfa_rank, error_estimate);

/* Items of an output that a reply of this shape has; 0: it is not among the answers */
static uint32_t items_of(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                         uint32_t block)
{
    if (!(reply_shape->want >> block & 1))
        return 0;
    return (uint32_t)(tfa_wire_reply_width(shape, block, reply_shape) / tfa_outputs[block].size);
}

/* The buffer of a sequence of `expected` items; of an empty one NULL. Keeps the first error. */
static const void *view_items(const void *buffer, uint32_t length, uint64_t expected,
                              tfa_field field, tfa_dds_field_error *field_error)
{
    if (length == 0)
        return NULL;
    if (length != expected) {
        if (field_error->status == TFA_OK)
            *field_error = (tfa_dds_field_error){TFA_E_SIZE, field, length};
        return NULL;
    }
    return buffer;
}

static const double *view_array(const dds_sequence_double *sequence, uint64_t expected,
                                tfa_field field, tfa_dds_field_error *field_error)
{
    return view_items(sequence->_buffer, sequence->_length, expected, field, field_error);
}

/* How many indices a sequence holds; 0 and an error when there are more than `limit`. */
static uint32_t count_indices(const dds_sequence_unsigned_long *sequence, uint32_t limit,
                              tfa_field field, tfa_dds_field_error *field_error)
{
    if (sequence->_length <= limit)
        return sequence->_length;
    if (field_error->status == TFA_OK)
        *field_error = (tfa_dds_field_error){TFA_E_SIZE, field, sequence->_length};
    return 0;
}

/* Copies frame indices; at most `limit`. */
static uint32_t copy_indices(const dds_sequence_unsigned_long *sequence, uint32_t *indices,
                             uint32_t limit, tfa_field field, tfa_dds_field_error *field_error)
{
    const uint32_t count = count_indices(sequence, limit, field, field_error);
    if (count > 0)
        memcpy(indices, sequence->_buffer, count * sizeof *indices);
    return count;
}

/* Items of an array of a request; 0: that of a floating base, and the base is fixed */
static uint64_t input_items(const tfa_wire_shape *shape, int columns, size_t bytes, size_t item)
{
    const bool of_base = columns == EXTENT_BASE || columns == EXTENT_BASE_POSE;
    return of_base && shape->base_freedoms == 0 ? 0 : bytes / item;
}

static bool op_exists(uint32_t op)
{
    return op >= TFA_OP_FORWARD_DYNAMICS && op <= TFA_OP_LAST;
}

/* The counts that every size follows from */
static void check_sizes(const totalforce_dds_Request *sample, const tfa_wire_shape *shape,
                        tfa_dds_field_error *field_error)
{
    *field_error = (tfa_dds_field_error){.status = TFA_OK};
    if (!op_exists(sample->op))
        *field_error = (tfa_dds_field_error){TFA_E_ARGUMENT, TFA_FIELD_OP, sample->op};
    else if (sample->count < 1 || sample->count > shape->max_batch)
        *field_error = (tfa_dds_field_error){TFA_E_SIZE, TFA_FIELD_COUNT, sample->count};
    else if (sample->method > UINT16_MAX) /* more does not fit an answer */
        *field_error = (tfa_dds_field_error){TFA_E_METHOD, TFA_FIELD_METHOD, sample->method};
    else if (sample->rows > TFA_ROWS_POINT)
        *field_error = (tfa_dds_field_error){TFA_E_ARGUMENT, TFA_FIELD_ROWS, sample->rows};
    else if (tfa_constraints_of(sample->op, sample->constraints) > tfa_wire_constraints(shape))
        *field_error = (tfa_dds_field_error){TFA_E_SIZE, TFA_FIELD_CONSTRAINTS,
                                             (uint32_t)__builtin_popcount(sample->constraints)};
}

/* The indices, whose numbers decide sizes of arrays */
static void view_indices(const totalforce_dds_Request *sample, const tfa_wire_shape *shape,
                         tfa_request *r, tfa_dds_field_error *field_error)
{
    r->tip_count =
        copy_indices(&sample->tips, r->tips, shape->max_tips, TFA_FIELD_TIPS, field_error);
    r->wrench_count = copy_indices(&sample->wrench_frames, r->wrench_frames, TFA_MAX_WRENCHES,
                                   TFA_FIELD_WRENCHES, field_error);
    r->payload_count = copy_indices(&sample->payload_frames, r->payload_frames, TFA_MAX_PAYLOADS,
                                    TFA_FIELD_PAYLOADS, field_error);
    r->locked_count = count_indices(&sample->locked, shape->v_count, TFA_FIELD_LOCKED, field_error);
}

int tfa_dds_request_view(const totalforce_dds_Request *sample, const tfa_wire_shape *shape,
                         tfa_request *request, tfa_dds_field_error *field_error)
{
    *request = (tfa_request){0};
    check_sizes(sample, shape, field_error);
    if (field_error->status != TFA_OK)
        return field_error->status;
    *request = (tfa_request){
        .op = (tfa_op)sample->op,
        .method = (tfa_method)sample->method,
        .estimate = (tfa_estimate)sample->estimate,
        .frame = (tfa_reference_frame)sample->frame,
        .refine = sample->refine,
        .flags = sample->flags,
        .count = sample->count,
        .rows = (tfa_rows)sample->rows,
        .rank_loss = (tfa_rank_loss)sample->rank_loss,
        .constraints = sample->constraints,
    };
    view_indices(sample, shape, request, field_error);
    const tfa_extents n =
        tfa_extents_of(shape->q_count, shape->v_count, 0, 0, shape->modes, request);
#define VIEW(name, member, states, rows, columns)                                                  \
    request->member = view_items(sample->member._buffer, sample->member._length,                   \
                                 input_items(shape, EXTENT_##columns,                              \
                                             tfa_wire_request_width(TFA_WIRE_##name, &n),          \
                                             sizeof *request->member),                             \
                                 TFA_FIELD_##name, field_error);
    TFA_INPUT_LIST(VIEW)
#undef VIEW
    return field_error->status;
}

int tfa_dds_torques_view(const totalforce_dds_JointTorques *sample, const tfa_wire_shape *shape,
                         tfa_request *request, tfa_dds_field_error *field_error)
{
    const uint64_t base = shape->base_freedoms > 0 ? 1 : 0;

    *field_error = (tfa_dds_field_error){.status = TFA_OK};
    *request = (tfa_request){
        .op = TFA_OP_FORWARD_DYNAMICS,
        .refine = TFA_REFINE_DEFAULT,
        .count = 1,
        .q = view_array(&sample->q, shape->q_count, TFA_FIELD_Q, field_error),
    };
    request->v = view_array(&sample->v, shape->v_count, TFA_FIELD_V, field_error);
    request->tau = view_array(&sample->tau, shape->v_count, TFA_FIELD_TAU, field_error);
    request->base_pose = view_array(&sample->base_pose, 7 * base, TFA_FIELD_BASE_POSE, field_error);
    request->base_twist =
        view_array(&sample->base_twist, 6 * base, TFA_FIELD_BASE_TWIST, field_error);
    request->base_wrench =
        view_array(&sample->base_wrench, 6 * base, TFA_FIELD_BASE_WRENCH, field_error);
    request->modes = view_array(&sample->modes, shape->modes, TFA_FIELD_MODES, field_error);
    request->mode_velocities =
        view_array(&sample->mode_velocities, shape->modes, TFA_FIELD_MODE_VELOCITIES, field_error);
    return field_error->status;
}

/* A sequence that borrows an array. Cyclone only reads the samples of dds_write, so const may
 * go. */
static dds_sequence_double alias_array(const double *array, uint64_t size)
{
    const uint32_t length = array != NULL ? (uint32_t)size : 0;
    return (dds_sequence_double){
        ._maximum = length,
        ._length = length,
        ._buffer = (double *)(uintptr_t)(length > 0 ? array : NULL),
        ._release = false,
    };
}

/* The same for a sequence of any type */
#define BORROW(sequence, array, size)                                                              \
    do {                                                                                           \
        (sequence)._length = (sequence)._maximum = (array) != NULL ? (uint32_t)(size) : 0;         \
        (sequence)._buffer = (void *)(uintptr_t)((sequence)._length > 0 ? (array) : NULL);         \
        (sequence)._release = false;                                                               \
    } while (0)

static dds_sequence_unsigned_long alias_indices(const uint32_t *array, uint32_t size)
{
    const uint32_t length = array != NULL ? size : 0;
    return (dds_sequence_unsigned_long){
        ._maximum = length,
        ._length = length,
        ._buffer = (uint32_t *)(uintptr_t)(length > 0 ? array : NULL),
        ._release = false,
    };
}

int tfa_dds_request_fill(const tfa_request *request, const tfa_wire_shape *shape,
                         totalforce_dds_Request *sample)
{
    const tfa_extents n =
        tfa_extents_of(shape->q_count, shape->v_count, 0, 0, shape->modes, request);

    if (request->tip_count > shape->max_tips || request->wrench_count > TFA_MAX_WRENCHES ||
        request->payload_count > TFA_MAX_PAYLOADS || request->locked_count > shape->v_count ||
        tfa_constraint_numbers(request) > tfa_wire_constraints(shape))
        return TFA_E_SIZE;
    sample->op = (uint32_t)request->op;
    sample->method = (uint32_t)request->method;
    sample->estimate = (uint32_t)request->estimate;
    sample->frame = (uint32_t)request->frame;
    sample->refine = request->refine;
    sample->flags = request->flags;
    sample->count = request->count;
    sample->rows = (uint32_t)request->rows;
    sample->rank_loss = (uint32_t)request->rank_loss;
    sample->constraints = request->constraints;
    sample->tips = alias_indices(request->tips, request->tip_count);
    sample->wrench_frames = alias_indices(request->wrench_frames, request->wrench_count);
    sample->payload_frames = alias_indices(request->payload_frames, request->payload_count);
#define FILL(name, member, states, rows, columns)                                                  \
    BORROW(sample->member, request->member,                                                        \
           input_items(shape, EXTENT_##columns, tfa_wire_request_width(TFA_WIRE_##name, &n),       \
                       sizeof *request->member));
    TFA_INPUT_LIST(FILL)
#undef FILL
    return TFA_OK;
}

void tfa_dds_reply_fill(const tfa_reply *reply, const tfa_wire_shape *shape,
                        const tfa_wire_reply_shape *reply_shape, totalforce_dds_Reply *sample)
{
    static const tfa_wire_reply_shape none;
    const tfa_wire_reply_shape *const s = tfa_wire_has_answers(reply->status) ? reply_shape : &none;
    sample->status = reply->status;
    sample->field = (uint32_t)reply->field;
    sample->index = reply->index;
    sample->state = reply->state;
    BORROW(sample->answers, reply->answers, items_of(shape, s, TFA_WIRE_ANSWERS));
#define FILL(name, member, ...)                                                                    \
    BORROW(sample->member, tfa_output_buffer(&tfa_outputs[TFA_WIRE_##name], reply),                \
           items_of(shape, s, TFA_WIRE_##name));
    TFA_OUTPUT_WORD_LIST(FILL)
#undef FILL
}

void tfa_dds_accelerations_fill(const tfa_reply *reply, const tfa_wire_shape *shape,
                                totalforce_dds_JointAccelerations *sample)
{
    const bool answered = tfa_wire_has_answers(reply->status);

    sample->status = reply->status;
    sample->field = (uint32_t)reply->field;
    sample->index = reply->index;
    sample->error_estimate = NAN;
    if (answered && reply->answers != NULL) {
        sample->method = reply->answers[0].method;
        sample->flags = reply->answers[0].flags;
        sample->error_estimate = reply->answers[0].error_estimate;
    }
    sample->qdd = alias_array(reply->qdd, answered ? shape->v_count : 0);
    sample->base_acceleration =
        alias_array(reply->base_acceleration, answered ? shape->base_freedoms : 0);
    sample->modes = alias_array(reply->modes, answered ? shape->modes : 0);
}

/* Copies `length` items of `item` bytes when the caller wants them; false when sizes differ. */
static bool read_items(void *to, const void *from, uint32_t length, uint32_t expected, size_t item)
{
    if (length != expected)
        return false;
    if (to != NULL && length > 0)
        memcpy(to, from, length * item);
    return true;
}

/* The first eight bytes of a hash, most significant first: tfa_model_tag. */
static uint64_t tag_of(const totalforce_dds_Hash hash)
{
    uint64_t tag = 0;
    for (int i = 0; i < 8; i++)
        tag = tag << 8 | hash[i];
    return tag;
}

void tfa_dds_set_hash(totalforce_dds_Hash hash, const totalforce_dds_Hash present, uint64_t model)
{
    memcpy(hash, present, sizeof(totalforce_dds_Hash));
    if (model == 0 || model == tag_of(present))
        return;
    memset(hash, 0, sizeof(totalforce_dds_Hash));
    for (int i = 0; i < 8; i++)
        hash[i] = (uint8_t)(model >> (56 - 8 * i));
}

int tfa_dds_reply_read(const totalforce_dds_Reply *sample, const tfa_wire_shape *shape,
                       const tfa_wire_reply_shape *reply_shape, tfa_reply *reply)
{
    static const tfa_wire_reply_shape none;
    const tfa_wire_reply_shape *const s =
        tfa_wire_has_answers(sample->status) ? reply_shape : &none;

    reply->model = tag_of(sample->model_hash);
    reply->status = sample->status;
    reply->field = (tfa_field)sample->field;
    reply->index = sample->index;
    reply->state = sample->state;
    bool fits = read_items(reply->answers, sample->answers._buffer, sample->answers._length,
                           items_of(shape, s, TFA_WIRE_ANSWERS), sizeof(tfa_answer));
#define READ(name, member, ...)                                                                    \
    fits =                                                                                         \
        fits && read_items(tfa_output_buffer(&tfa_outputs[TFA_WIRE_##name], reply),                \
                           sample->member._buffer, sample->member._length,                         \
                           items_of(shape, s, TFA_WIRE_##name), sizeof *sample->member._buffer);
    TFA_OUTPUT_WORD_LIST(READ)
#undef READ
    return fits ? TFA_OK : TFA_E_PROTOCOL;
}

bool tfa_dds_set_robot(char key[totalforce_dds_ROBOT_NAME_MAX + 1], const char *name)
{
    const size_t length = strnlen(name, totalforce_dds_ROBOT_NAME_MAX + 1);

    if (length > totalforce_dds_ROBOT_NAME_MAX)
        return false;
    memcpy(key, name, length);
    key[length] = '\0';
    return true;
}

static int64_t read_clock(clockid_t clock)
{
    struct timespec now;

    clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

int64_t tfa_dds_ros_time(void)
{
    return read_clock(CLOCK_REALTIME);
}

int64_t tfa_dds_ros_offset(void)
{
    const int64_t before = read_clock(CLOCK_MONOTONIC);
    const int64_t ros = read_clock(CLOCK_REALTIME);
    const int64_t after = read_clock(CLOCK_MONOTONIC);

    return ros - (before + (after - before) / 2);
}
