/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the DDS types and the C types of dynamics.h: sizes are checked, arrays are pointed at.
 */
#include "dds_convert.h"

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

tfa_dds_reply_sizes tfa_dds_sizes_of_reply(const tfa_request *request, const tfa_dds_shape *shape)
{
    const uint32_t count = request->count;
    const uint32_t rows = 6 * request->tip_count;
    const uint32_t n = shape->base_freedoms + shape->v_count;
    const bool answers_lambda = request->op == TFA_OP_OPERATIONAL_INERTIA ||
                                (request->op == TFA_OP_FORWARD_DYNAMICS && rows > 0);
    tfa_dds_reply_sizes sizes = {.answers = count};

    if (request->op == TFA_OP_FORWARD_DYNAMICS) {
        sizes.qdd = count * shape->v_count;
        sizes.base_acceleration = count * shape->base_freedoms;
    }
    if (request->op == TFA_OP_INVERSE_DYNAMICS) {
        sizes.tau = count * shape->v_count;
        sizes.base_wrench = count * shape->base_freedoms;
    }
    if (request->op == TFA_OP_MASS_MATRIX)
        sizes.mass_matrix = count * n * n;
    if (answers_lambda) {
        sizes.lambda_inv = count * rows * rows;
        sizes.spectrum = request->flags & TFA_WANT_SPECTRUM ? count : 0;
    }
    sizes.poses = request->flags & TFA_WANT_POSES ? count * request->tip_count * 7 : 0;
    return sizes;
}

/* A sequence of `expected` numbers, or an empty one: then NULL. Keeps the first error. */
static const double *view_array(const dds_sequence_double *sequence, uint64_t expected,
                                tfa_field field, tfa_dds_field_error *field_error)
{
    if (sequence->_length == 0)
        return NULL;
    if (sequence->_length != expected) {
        if (field_error->status == TFA_OK)
            *field_error = (tfa_dds_field_error){TFA_E_SIZE, field, sequence->_length};
        return NULL;
    }
    return sequence->_buffer;
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

/* Views joint indices; at most one for each freedom. */
static const uint32_t *view_joints(const dds_sequence_unsigned_long *sequence, uint32_t v_count,
                                   uint32_t *count, tfa_field field,
                                   tfa_dds_field_error *field_error)
{
    *count = count_indices(sequence, v_count, field, field_error);
    return *count > 0 ? sequence->_buffer : NULL;
}

static bool op_exists(uint32_t op)
{
    return op >= TFA_OP_FORWARD_DYNAMICS && op <= TFA_OP_MASS_MATRIX;
}

/* The counts that every size follows from */
static void check_sizes(const totalforce_dds_Request *sample, const tfa_dds_shape *shape,
                        tfa_dds_field_error *field_error)
{
    *field_error = (tfa_dds_field_error){.status = TFA_OK};
    if (!op_exists(sample->op))
        *field_error = (tfa_dds_field_error){TFA_E_ARGUMENT, TFA_FIELD_OP, sample->op};
    else if (sample->count < 1 || sample->count > shape->max_batch)
        *field_error = (tfa_dds_field_error){TFA_E_SIZE, TFA_FIELD_COUNT, sample->count};
    else if (sample->method > UINT16_MAX) /* the ring has 16 bits for it */
        *field_error = (tfa_dds_field_error){TFA_E_METHOD, TFA_FIELD_METHOD, sample->method};
}

/* Everything that is not one number for each joint or base freedom. */
static void view_lists(const totalforce_dds_Request *sample, const tfa_dds_shape *shape,
                       tfa_request *r, tfa_dds_field_error *field_error)
{
    r->tip_count = copy_indices(&sample->tips, r->tips, TFA_MAX_TIPS, TFA_FIELD_TIPS, field_error);
    r->wrench_count = copy_indices(&sample->wrench_frames, r->wrench_frames, TFA_MAX_WRENCHES,
                                   TFA_FIELD_WRENCHES, field_error);
    r->payload_count = copy_indices(&sample->payload_frames, r->payload_frames, TFA_MAX_PAYLOADS,
                                    TFA_FIELD_PAYLOADS, field_error);
    r->locked = view_joints(&sample->locked, shape->v_count, &r->locked_count, TFA_FIELD_LOCKED,
                            field_error);
    r->gravity = view_array(&sample->gravity, 3, TFA_FIELD_GRAVITY, field_error);
    r->wrenches = view_array(&sample->wrenches, (uint64_t)r->count * r->wrench_count * 6,
                             TFA_FIELD_WRENCHES, field_error);
    r->payloads = view_array(&sample->payloads, (uint64_t)r->payload_count * TFA_PAYLOAD_NUMBERS,
                             TFA_FIELD_PAYLOADS, field_error);
}

int tfa_dds_request_view(const totalforce_dds_Request *sample, const tfa_dds_shape *shape,
                         tfa_request *request, tfa_dds_field_error *field_error)
{
    const uint64_t count = sample->count;
    const uint64_t v_size = count * shape->v_count;
    const uint64_t base = shape->base_freedoms > 0 ? count : 0;

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
    };
    request->q = view_array(&sample->q, count * shape->q_count, TFA_FIELD_Q, field_error);
    request->v = view_array(&sample->v, v_size, TFA_FIELD_V, field_error);
    request->tau = view_array(&sample->tau, v_size, TFA_FIELD_TAU, field_error);
    request->qdd = view_array(&sample->qdd, v_size, TFA_FIELD_QDD, field_error);
    request->base_pose = view_array(&sample->base_pose, 7 * base, TFA_FIELD_BASE_POSE, field_error);
    request->base_twist =
        view_array(&sample->base_twist, 6 * base, TFA_FIELD_BASE_TWIST, field_error);
    request->base_wrench =
        view_array(&sample->base_wrench, 6 * base, TFA_FIELD_BASE_WRENCH, field_error);
    request->base_acceleration =
        view_array(&sample->base_acceleration, 6 * base, TFA_FIELD_BASE_ACCELERATION, field_error);
    view_lists(sample, shape, request, field_error);
    return field_error->status;
}

int tfa_dds_torques_view(const totalforce_dds_JointTorques *sample, const tfa_dds_shape *shape,
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

int tfa_dds_request_fill(const tfa_request *request, const tfa_dds_shape *shape,
                         totalforce_dds_Request *sample)
{
    const uint64_t count = request->count;
    const uint64_t v_size = count * shape->v_count;
    const uint64_t base = shape->base_freedoms > 0 ? count : 0;

    if (request->tip_count > TFA_MAX_TIPS || request->wrench_count > TFA_MAX_WRENCHES ||
        request->payload_count > TFA_MAX_PAYLOADS || request->locked_count > shape->v_count)
        return TFA_E_SIZE;
    sample->op = (uint32_t)request->op;
    sample->method = (uint32_t)request->method;
    sample->estimate = (uint32_t)request->estimate;
    sample->frame = (uint32_t)request->frame;
    sample->refine = request->refine;
    sample->flags = request->flags;
    sample->count = request->count;
    sample->payload_frames = alias_indices(request->payload_frames, request->payload_count);
    sample->locked = alias_indices(request->locked, request->locked_count);
    sample->payloads =
        alias_array(request->payloads, (uint64_t)request->payload_count * TFA_PAYLOAD_NUMBERS);
    sample->tips = alias_indices(request->tips, request->tip_count);
    sample->wrench_frames = alias_indices(request->wrench_frames, request->wrench_count);
    sample->q = alias_array(request->q, count * shape->q_count);
    sample->v = alias_array(request->v, v_size);
    sample->tau = alias_array(request->tau, v_size);
    sample->qdd = alias_array(request->qdd, v_size);
    sample->base_pose = alias_array(request->base_pose, 7 * base);
    sample->base_twist = alias_array(request->base_twist, 6 * base);
    sample->base_wrench = alias_array(request->base_wrench, 6 * base);
    sample->base_acceleration = alias_array(request->base_acceleration, 6 * base);
    sample->gravity = alias_array(request->gravity, 3);
    sample->wrenches = alias_array(request->wrenches, count * request->wrench_count * 6);
    return TFA_OK;
}

bool tfa_dds_status_has_answers(int32_t status)
{
    return status == TFA_OK || status == TFA_E_SINGULAR || status == TFA_E_NOT_COMPUTED;
}

void tfa_dds_reply_fill(const tfa_reply *reply, const tfa_dds_reply_sizes *sizes,
                        totalforce_dds_Reply *sample)
{
    static const tfa_dds_reply_sizes none;
    const tfa_dds_reply_sizes *s = tfa_dds_status_has_answers(reply->status) ? sizes : &none;
    const uint32_t answers = reply->answers != NULL ? s->answers : 0;
    const uint32_t spectra = reply->spectrum != NULL ? s->spectrum : 0;

    sample->status = reply->status;
    sample->field = (uint32_t)reply->field;
    sample->index = reply->index;
    sample->state = reply->state;
    sample->answers = (dds_sequence_totalforce_dds_Answer){
        answers, answers, answers > 0 ? (totalforce_dds_Answer *)reply->answers : NULL, false};
    sample->qdd = alias_array(reply->qdd, s->qdd);
    sample->base_acceleration = alias_array(reply->base_acceleration, s->base_acceleration);
    sample->tau = alias_array(reply->tau, s->tau);
    sample->base_wrench = alias_array(reply->base_wrench, s->base_wrench);
    sample->lambda_inv = alias_array(reply->lambda_inv, s->lambda_inv);
    sample->mass_matrix = alias_array(reply->mass_matrix, s->mass_matrix);
    sample->spectrum = (dds_sequence_totalforce_dds_Spectrum){
        spectra, spectra, spectra > 0 ? (totalforce_dds_Spectrum *)reply->spectrum : NULL, false};
    sample->poses = alias_array(reply->poses, s->poses);
}

void tfa_dds_accelerations_fill(const tfa_reply *reply, const tfa_dds_reply_sizes *sizes,
                                totalforce_dds_JointAccelerations *sample)
{
    const bool answered = tfa_dds_status_has_answers(reply->status);

    sample->status = reply->status;
    sample->field = (uint32_t)reply->field;
    sample->index = reply->index;
    sample->error_estimate = NAN;
    if (answered && reply->answers != NULL) {
        sample->method = reply->answers[0].method;
        sample->flags = reply->answers[0].flags;
        sample->error_estimate = reply->answers[0].error_estimate;
    }
    sample->qdd = alias_array(reply->qdd, answered ? sizes->qdd : 0);
    sample->base_acceleration =
        alias_array(reply->base_acceleration, answered ? sizes->base_acceleration : 0);
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

static bool read_array(double *to, const dds_sequence_double *from, uint32_t expected)
{
    return read_items(to, from->_buffer, from->_length, expected, sizeof *to);
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

int tfa_dds_reply_read(const totalforce_dds_Reply *sample, const tfa_dds_reply_sizes *sizes,
                       tfa_reply *reply)
{
    static const tfa_dds_reply_sizes none;
    const tfa_dds_reply_sizes *s = tfa_dds_status_has_answers(sample->status) ? sizes : &none;

    reply->model = tag_of(sample->model_hash);
    reply->status = sample->status;
    reply->field = (tfa_field)sample->field;
    reply->index = sample->index;
    reply->state = sample->state;
    const bool fits =
        read_array(reply->qdd, &sample->qdd, s->qdd) &&
        read_array(reply->base_acceleration, &sample->base_acceleration, s->base_acceleration) &&
        read_array(reply->tau, &sample->tau, s->tau) &&
        read_array(reply->base_wrench, &sample->base_wrench, s->base_wrench) &&
        read_array(reply->lambda_inv, &sample->lambda_inv, s->lambda_inv) &&
        read_array(reply->mass_matrix, &sample->mass_matrix, s->mass_matrix) &&
        read_items(reply->answers, sample->answers._buffer, sample->answers._length, s->answers,
                   sizeof *reply->answers) &&
        read_array(reply->poses, &sample->poses, s->poses) &&
        read_items(reply->spectrum, sample->spectrum._buffer, sample->spectrum._length, s->spectrum,
                   sizeof *reply->spectrum);
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
