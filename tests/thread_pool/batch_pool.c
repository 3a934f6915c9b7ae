/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A pool answers as tfa_compute does, to the bit, whatever the number of threads and the size of
 * the batch, errors included; meant to run under ThreadSanitizer too.
 */
#include "models.h"
#include "test.h"

#include <errno.h>
#include <sched.h>
#include <totalforce/totalforce.h>

#define STATES 97
#define STEP (STATES / TEST_ROUNDS(STATES))
#define TIPS 2
#define WRENCHES 3
#define POOLS 4
#define UNTOUCHED 0x5a /* what the buffers hold before */

static const uint32_t pool_threads[POOLS] = {1, 2, 3, 7};

/* A robot with inputs for all states, a workspace and the pools. */
struct bench {
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_batch_pool *pool[POOLS];
    uint32_t nq, nv, base, tips[TIPS], wrench_frames[WRENCHES];
    double *q, *v, *tau, *qdd, *pose, *twist, *wrench, *acceleration, *wrenches;
};

/* Every buffer of a reply in one block, so that one comparison sees all. */
struct outputs {
    size_t size;
    char *memory;
    tfa_reply reply;
};

static double noise(void)
{
    static uint64_t x = 88172645463325252u;
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return (double)(x >> 11) / (double)(1ull << 52) - 1;
}

static double *numbers(size_t width)
{
    double *x = calloc(width * STATES + 1, sizeof *x);
    assert_non_null(x);
    for (size_t k = 0; k < width * STATES; k++)
        x[k] = noise();
    return x;
}

static void fill(struct bench *b)
{
    b->nq = tfa_model_q_count(b->model);
    b->nv = tfa_model_v_count(b->model);
    b->base = tfa_model_base_freedoms(b->model);
    b->q = numbers(b->nq);
    b->v = numbers(b->nv);
    b->tau = numbers(b->nv);
    b->qdd = numbers(b->nv);
    b->pose = numbers(7);
    b->twist = numbers(6);
    b->wrench = numbers(6);
    b->acceleration = numbers(6);
    b->wrenches = numbers((size_t)6 * WRENCHES);
    for (int k = 0; k < STATES; k++) {
        double *u = b->pose + 7 * k + 3;
        double n = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3]);
        for (int i = 0; i < 4; i++)
            u[i] /= n;
    }
}

static void open_model(struct bench *b, tfa_model *model)
{
    *b = (struct bench){.model = model};
    b->workspace = workspace_for(model, NULL);
    for (int k = 0; k < POOLS; k++) {
        const tfa_batch_pool_options options = {.threads = pool_threads[k]};
        assert_int_equal(tfa_batch_pool_create(model, &options, &b->pool[k]), TFA_OK);
        assert_int_equal(tfa_batch_pool_threads(b->pool[k]), pool_threads[k]);
    }
    fill(b);
}

static void open_humanoid(struct bench *b, tfa_base base)
{
    const tfa_model_options options = {.base = base};
    tfa_model *model = bundled_model("humanoid.urdf", &options);
    open_model(b, model);
    static const char *const links[] = {"left_palm", "right_thumb_2_link", "head_camera_link"};
    for (int k = 0; k < WRENCHES; k++) {
        int32_t frame = tfa_model_find_frame(model, links[k]);
        assert_true(frame >= 0);
        b->wrench_frames[k] = (uint32_t)frame;
        if (k < TIPS)
            b->tips[k] = (uint32_t)frame;
    }
}

static void close_bench(struct bench *b)
{
    for (int k = 0; k < POOLS; k++)
        tfa_batch_pool_free(b->pool[k]);
    tfa_workspace_free(b->workspace);
    tfa_model_free(b->model);
    double *const arrays[] = {b->q,     b->v,      b->tau,          b->qdd,     b->pose,
                              b->twist, b->wrench, b->acceleration, b->wrenches};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
}

/* A request of `op` with all that the op can hold. */
static tfa_request request(const struct bench *b, tfa_op op, tfa_method method, uint32_t tips)
{
    tfa_request r = {.op = op,
                     .method = method,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = tips ? TFA_WANT_SPECTRUM | TFA_WANT_POSES : 0,
                     .count = STATES,
                     .tip_count = tips,
                     .wrench_count = b->wrench_frames[0] ? WRENCHES : 0,
                     .q = b->q,
                     .v = b->v,
                     .tau = b->tau,
                     .qdd = b->qdd,
                     .wrenches = b->wrenches};
    memcpy(r.tips, b->tips, sizeof b->tips);
    memcpy(r.wrench_frames, b->wrench_frames, sizeof b->wrench_frames);
    if (b->base) {
        r.base_pose = b->pose;
        r.base_twist = b->twist;
        r.base_wrench = b->wrench;
        r.base_acceleration = b->acceleration;
    }
    return r;
}

/* Places the buffer of one kind of answer at a multiple of 8 bytes. */
static void *take_buffer(struct outputs *o, size_t bytes)
{
    void *at = o->memory ? o->memory + o->size : NULL;
    o->size += (bytes + 7) / 8 * 8;
    return at;
}

static void set_buffers(struct outputs *o, const struct bench *b, uint32_t count)
{
    const size_t n = b->nv + b->base, d = sizeof(double);
    o->size = 0;
    o->reply = (tfa_reply){
        .qdd = take_buffer(o, count * b->nv * d),
        .base_acceleration = take_buffer(o, count * 6 * d),
        .tau = take_buffer(o, count * b->nv * d),
        .base_wrench = take_buffer(o, count * 6 * d),
        .lambda_inv = take_buffer(o, count * 36 * TIPS * TIPS * d),
        .mass_matrix = take_buffer(o, count * n * n * d),
        .spectrum = take_buffer(o, count * sizeof(tfa_spectrum)),
        .answers = take_buffer(o, count * sizeof(tfa_answer)),
        .poses = take_buffer(o, count * 7 * TIPS * d),
    };
}

/* Buffers for `count` states, not one more: a thread that writes beyond is seen by the next
 * buffer, or by AddressSanitizer. */
static void open_outputs(struct outputs *o, const struct bench *b, uint32_t count)
{
    o->memory = NULL;
    set_buffers(o, b, count);
    o->memory = malloc(o->size);
    assert_non_null(o->memory);
    memset(o->memory, UNTOUCHED, o->size);
    set_buffers(o, b, count);
}

static void compare(const struct bench *b, tfa_request *r, uint32_t count)
{
    struct outputs alone, shared;
    r->count = count;
    open_outputs(&alone, b, count);
    int expected = tfa_compute(b->workspace, r, &alone.reply);
    open_outputs(&shared, b, count);
    for (int k = 0; k < POOLS; k++) {
        memset(shared.memory, UNTOUCHED, shared.size);
        shared.reply.status = shared.reply.field = 77;
        shared.reply.index = shared.reply.state = 77;
        int status = tfa_batch_pool_compute(b->pool[k], r, &shared.reply);
        const tfa_reply *x = &alone.reply, *y = &shared.reply;
        if (status != expected || y->status != x->status || y->field != x->field ||
            y->index != x->index || y->state != x->state)
            fail_msg("op %d, %u states, %u threads: %s, %s %u of state %u; tfa_compute: %s, %s %u "
                     "of state %u",
                     (int)r->op, (unsigned)count, (unsigned)pool_threads[k],
                     tfa_status_name(status), tfa_field_name(y->field), (unsigned)y->index,
                     (unsigned)y->state, tfa_status_name(expected), tfa_field_name(x->field),
                     (unsigned)x->index, (unsigned)x->state);
        if (memcmp(alone.memory, shared.memory, alone.size) != 0)
            fail_msg("op %d, %u states, %u threads: the bits differ", (int)r->op, (unsigned)count,
                     (unsigned)pool_threads[k]);
    }
    free(alone.memory);
    free(shared.memory);
}

static const struct {
    tfa_op op;
    tfa_method method;
    uint32_t tips;
    uint32_t step; /* of the batch sizes: all of them where states are cheap */
    uint32_t locked;
} kinds[] = {
    {TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_AUTO, 0, 1, 0},
    {TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_TFA, TIPS, 32, 0},
    {TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_CRBA, 1, 32, 0},
    {TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_AUTO, 0, 16, 4},
    {TFA_OP_INVERSE_DYNAMICS, TFA_METHOD_AUTO, 0, 1, 0},
    {TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_AUTO, TIPS, 8, 0},
    {TFA_OP_MASS_MATRIX, TFA_METHOD_AUTO, 0, 4, 0},
};

static void same_bits(tfa_base base)
{
    struct bench b;
    open_humanoid(&b, base);
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        static const uint32_t fingers[] = {20, 21, 22, 23};
        tfa_request r = request(&b, kinds[k].op, kinds[k].method, kinds[k].tips);
        r.locked = fingers;
        r.locked_count = kinds[k].locked;
        for (uint32_t count = 1; count <= STATES; count += STEP * kinds[k].step)
            compare(&b, &r, count);
    }
    close_bench(&b);
}

TEST(test_fixed)
{
    same_bits(TFA_BASE_FIXED);
}

TEST(test_floating)
{
    same_bits(TFA_BASE_FLOATING);
}

/* The optional inputs absent, and the optional outputs too. */
TEST(test_bare_request)
{
    struct bench b;
    open_humanoid(&b, TFA_BASE_FLOATING);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = STATES,
                           .q = b.q,
                           .base_pose = b.pose};
    double *alone = numbers(b.nv), *shared = numbers(b.nv);
    tfa_reply reply = {.qdd = alone};
    assert_int_equal(tfa_compute(b.workspace, &r, &reply), TFA_OK);
    for (int k = 0; k < POOLS; k++) {
        memset(shared, UNTOUCHED, sizeof(double) * b.nv * STATES);
        reply = (tfa_reply){.qdd = shared};
        assert_int_equal(tfa_batch_pool_compute(b.pool[k], &r, &reply), TFA_OK);
        assert_memory_equal(shared, alone, sizeof(double) * b.nv * STATES);
    }
    free(alone);
    free(shared);
    close_bench(&b);
}

/* The index and the state that are reported are those of the whole batch, of the first failure. */
TEST(test_bad_states)
{
    struct bench b;
    open_humanoid(&b, TFA_BASE_FLOATING);
    tfa_request r = request(&b, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_AUTO, 0);
    double *const spoilt[] = {&b.pose[7 * 70 + 6], &b.wrenches[6 * WRENCHES * 96 + 17],
                              &b.tau[(size_t)b.nv * 41 + 9], &b.q[(size_t)b.nq * 53 + 10],
                              &b.q[(size_t)b.nq * 52 + 11]};
    static const double values[] = {3, (double)INFINITY, (double)NAN, (double)NAN,
                                    -(double)INFINITY};
    static const struct {
        int status;
        tfa_field field;
        uint32_t index, state;
    } expected[] = {{TFA_E_QUATERNION, TFA_FIELD_BASE_POSE, 3, 70},
                    {TFA_E_VALUE, TFA_FIELD_WRENCHES, 17, 96},
                    {TFA_E_VALUE, TFA_FIELD_TAU, 9, 41},
                    {TFA_E_VALUE, TFA_FIELD_Q, 10, 53},
                    {TFA_E_VALUE, TFA_FIELD_Q, 11, 52}};
    for (int k = 0; k < 5; k++) { /* each outranks those before */
        *spoilt[k] = values[k];
        compare(&b, &r, STATES);
        tfa_reply reply = {.qdd = NULL};
        assert_int_equal(tfa_batch_pool_compute(b.pool[2], &r, &reply), expected[k].status);
        assert_int_equal(reply.field, expected[k].field);
        assert_int_equal(reply.index, expected[k].index);
        assert_int_equal(reply.state, expected[k].state);
    }
    close_bench(&b);
}

TEST(test_request_errors)
{
    struct bench b;
    open_humanoid(&b, TFA_BASE_FLOATING);
    const tfa_request good = request(&b, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_AUTO, TIPS);
    tfa_request bad[10];
    for (int k = 0; k < 10; k++)
        bad[k] = good;
    bad[0].op = (tfa_op)9;
    bad[1].method = TFA_METHOD_RNEA;
    bad[2].tips[1] = tfa_model_frame_count(b.model);
    bad[3].tip_count = TFA_MAX_TIPS + 1;
    bad[4].q = NULL;
    bad[5].base_pose = NULL;
    bad[6].wrenches = NULL;
    bad[7].refine = TFA_MAX_REFINE + 1;
    static const double gravity[3] = {0, 0, (double)NAN};
    bad[8].gravity = gravity;
    bad[9].frame = (tfa_reference_frame)-1;
    for (int k = 0; k < 10; k++) {
        tfa_reply reply = {.qdd = NULL};
        assert_int_not_equal(tfa_request_check(b.model, &bad[k], &reply), TFA_OK);
        compare(&b, &bad[k], STATES);
    }
    tfa_request none = good;
    compare(&b, &none, 0);
    compare(&b, &none, STATES); /* the pool works on after an error */
    close_bench(&b);
}

/* Two rods without mass and a point of 1 kg at the end: M is singular where both are in line. */
static tfa_model *point_arm(void)
{
    tfa_link links[3] = {{.name = "base", .quat = {0, 0, 0, 1}},
                         {.name = "rod", .quat = {0, 0, 0, 1}},
                         {.name = "tip", .mass = 1, .com = {1, 0, 0}, .quat = {0, 0, 0, 1}}};
    tfa_joint joints[2] = {{.name = "one",
                            .type = TFA_JOINT_REVOLUTE,
                            .child = 1,
                            .quat = {0, 0, 0, 1},
                            .axis = {0, 0, 1},
                            .mimic = -1},
                           {.name = "two",
                            .type = TFA_JOINT_REVOLUTE,
                            .parent = 1,
                            .child = 2,
                            .xyz = {1, 0, 0},
                            .quat = {0, 0, 0, 1},
                            .axis = {0, 0, 1},
                            .mimic = -1}};
    const tfa_description d = {
        .name = "point", .links = links, .link_count = 3, .joints = joints, .joint_count = 2};
    tfa_model *model = compiled(&d, NULL);
    return model;
}

/* A state that has no answer spoils no other, and the first of them is told. */
TEST(test_singular_states)
{
    struct bench b;
    open_model(&b, point_arm());
    tfa_request r = request(&b, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, 0);
    compare(&b, &r, STATES);
    tfa_reply reply = {.qdd = NULL};
    assert_int_equal(tfa_batch_pool_compute(b.pool[3], &r, &reply), TFA_OK);
    static const uint32_t singular[] = {96, 60, 17}; /* from the last to the first */
    for (int k = 0; k < 3; k++) {
        memset(b.q + 2 * singular[k], 0, 2 * sizeof(double));
        compare(&b, &r, STATES);
        assert_int_equal(tfa_batch_pool_compute(b.pool[3], &r, &reply), TFA_E_NOT_COMPUTED);
        assert_int_equal(reply.state, singular[k]);
    }
    close_bench(&b);
}

/* One part of a request after the other, by a pool or (NULL) by the workspace alone. */
static int in_parts(const struct bench *b, tfa_batch_pool *pool, const tfa_request *r,
                    uint32_t part, tfa_reply *reply)
{
    int status = tfa_request_check(b->model, r, reply);
    for (uint32_t first = 0; first < r->count; first += part) {
        const uint32_t left = r->count - first, count = left < part ? left : part;
        status = pool ? tfa_batch_pool_compute_states(pool, r, first, count, reply)
                      : tfa_compute_states(b->workspace, r, first, count, reply);
        assert_int_equal(status, reply->status);
    }
    return status;
}

/* A batch in parts of any size is the batch: same bits, same failed field. */
TEST(test_parts)
{
    static const uint32_t partition[] = {1, 2, 5, 8, 16, 31, STATES, 2 * STATES};
    struct bench b;
    open_model(&b, point_arm());
    memset(b.q + (size_t)2 * 60, 0, 2 * sizeof(double)); /* states without an answer */
    memset(b.q + (size_t)2 * 17, 0, 2 * sizeof(double));
    const tfa_request r = request(&b, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, 0);
    struct outputs whole, cut;
    open_outputs(&whole, &b, STATES);
    open_outputs(&cut, &b, STATES);
    assert_int_equal(tfa_compute(b.workspace, &r, &whole.reply), TFA_E_NOT_COMPUTED);
    for (size_t k = 0; k < sizeof partition / sizeof *partition; k++)
        for (int p = -1; p < POOLS; p++) {
            memset(cut.memory, UNTOUCHED, cut.size);
            assert_int_equal(in_parts(&b, p < 0 ? NULL : b.pool[p], &r, partition[k], &cut.reply),
                             TFA_E_NOT_COMPUTED);
            assert_int_equal(cut.reply.state, 17);
            assert_int_equal(cut.reply.field, whole.reply.field);
            assert_memory_equal(cut.memory, whole.memory, whole.size);
        }
    free(whole.memory);
    free(cut.memory);
    close_bench(&b);
}

/* Who asks for a priority gets it, or is told by name why not. */
TEST(test_priority)
{
    tfa_thread_pool *thread_pool = NULL;
    tfa_thread_pool_options options = {.threads = 2, .priority = 100};
    assert_int_equal(tfa_thread_pool_create(&options, &thread_pool), TFA_E_ARGUMENT);
    options.priority = 1;
    errno = 0;
    const int status = tfa_thread_pool_create(&options, &thread_pool);
    if (status != TFA_OK) {
        assert_int_equal(status, TFA_E_SYSTEM);
        assert_int_equal(errno, EPERM);
        assert_null(thread_pool);
    }
    tfa_thread_pool_free(thread_pool);
}

TEST(test_options)
{
    tfa_model *model = point_arm();
    tfa_batch_pool *pool = NULL;
    assert_int_equal(tfa_batch_pool_create(NULL, NULL, &pool), TFA_E_ARGUMENT);
    assert_int_equal(tfa_batch_pool_create(model, NULL, NULL), TFA_E_ARGUMENT);
    tfa_batch_pool_options options = {.threads = 257};
    assert_int_equal(tfa_batch_pool_create(model, &options, &pool), TFA_E_ARGUMENT);
    options = (tfa_batch_pool_options){.threads = 2, .precision = (tfa_precision)7};
    assert_int_equal(tfa_batch_pool_create(model, &options, &pool), TFA_E_UNSUPPORTED);
    assert_null(pool);
    assert_int_equal(tfa_batch_pool_create(model, NULL, &pool), TFA_OK);
    assert_true(tfa_batch_pool_threads(pool) >= 1);
    tfa_batch_pool_free(pool);
    tfa_batch_pool_free(NULL);
    tfa_model_free(model);
}

/* Threads on the processor that this one may use anyway; then on one that no machine has. */
TEST(test_processors)
{
    struct bench b;
    open_model(&b, point_arm());
    const int cpu = sched_getcpu();
    assert_true(cpu >= 0);
    cpu_set_t before, after;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    const int cpus[] = {cpu, cpu, cpu};
    const tfa_batch_pool_options options = {.threads = 3, .spin_ns = 1000, .cpus = cpus};
    tfa_batch_pool_free(b.pool[2]);
    b.pool[2] = NULL;
    assert_int_equal(tfa_batch_pool_create(b.model, &options, &b.pool[2]), TFA_OK);
    tfa_request r = request(&b, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_AUTO, 0);
    compare(&b, &r, STATES);
    assert_int_equal(sched_getaffinity(0, sizeof after, &after), 0);
    assert_true(CPU_EQUAL(&before, &after)); /* the caller's own is not changed */
    static const int wrong[] = {CPU_SETSIZE - 1, CPU_SETSIZE, -1, INT32_MAX};
    for (int k = 0; k < 4; k++) {
        const int bad[] = {cpu, cpu, wrong[k]};
        tfa_batch_pool_options o = options;
        o.cpus = bad;
        tfa_batch_pool *pool = NULL;
        errno = 0;
        assert_int_equal(tfa_batch_pool_create(b.model, &o, &pool), TFA_E_SYSTEM);
        assert_int_equal(errno, EINVAL);
        assert_null(pool);
    }
    close_bench(&b);
}
