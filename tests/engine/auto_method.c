/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `auto` is a function of the model and the request: the segment scan from TFA_SCAN_BODIES_MIN
 * bodies of a chain on, whatever the number of threads and of states; requests and robots that the
 * scan does not take in segment lanes go by aba.
 */
#include "engine/tuning.h"
#include "models.h"
#include "random_robot.h"
#include "test.h"

#include <totalforce/totalforce.h>

enum { LONG = TFA_SCAN_BODIES_MIN, STATES = 5, THREADS = 3 };

/* A random chain and all that answers for it */
struct test_case {
    tfa_description *description;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_batch_pool *pool;
};

static const random_robot_options revolute = {.shape = RANDOM_CHAIN};

static void open_case(struct test_case *s, uint32_t bodies, random_robot_options robot,
                      const tfa_model_options *base, tfa_workspace_options options)
{
    robot.joints = bodies;
    s->description = random_robot_create(bodies, &robot);
    assert_non_null(s->description);
    s->model = compiled(s->description, base);
    s->workspace = workspace_for(s->model, &options);
    const tfa_batch_pool_options pool = {
        .threads = THREADS, .precision = options.precision, .residual = options.residual};
    assert_int_equal(tfa_batch_pool_create(s->model, &pool, &s->pool), TFA_OK);
}

static void close_case(struct test_case *s)
{
    tfa_batch_pool_free(s->pool);
    tfa_workspace_free(s->workspace);
    tfa_model_free(s->model);
    random_robot_free(s->description);
}

/* Numbers of all states; the same at every call */
static double *numbers(size_t n)
{
    random_source random = {n};
    double *x = malloc(n * sizeof *x);
    assert_non_null(x);
    for (size_t k = 0; k < n; k++)
        x[k] = random_uniform(&random, -1, 1);
    return x;
}

/* Coordinates of one state: quaternions are of unit length */
static double *coordinates(const tfa_model *m)
{
    random_source random = {1};
    double *q = calloc(tfa_model_q_count(m) + 1, sizeof *q), *at = q;
    assert_non_null(q);
    for (uint32_t k = 0; k < tfa_model_joint_count(m); k++)
        at += random_coordinates(&random, tfa_model_joint(m, k).type, at);
    return q;
}

/* The method that answers; `changed` is a request with nothing but what is special about it. */
static tfa_method method_of(const struct test_case *s, const tfa_request *changed, int pool)
{
    tfa_answer answer = {0};
    tfa_request r = *changed;
    double *q = coordinates(s->model), *lambda = calloc(36 * 4, sizeof *lambda);
    double pose[7] = {0, 0, 0, 0, 0, 0, 1}, base[6];
    double *qdd = calloc(tfa_model_v_count(s->model), sizeof *qdd);
    tfa_reply reply = {
        .qdd = qdd, .base_acceleration = base, .lambda_inv = lambda, .answers = &answer};
    r.op = r.op ? r.op : TFA_OP_FORWARD_DYNAMICS;
    r.count = 1;
    r.q = q;
    r.base_pose = tfa_model_base_freedoms(s->model) ? pose : NULL;
    assert_int_equal(pool ? tfa_batch_pool_compute(s->pool, &r, &reply)
                          : tfa_compute(s->workspace, &r, &reply),
                     TFA_OK);
    free(q);
    free(qdd);
    free(lambda);
    return (tfa_method)answer.method;
}

static const tfa_request plain = {.refine = TFA_REFINE_DEFAULT};

TEST(long_chains_go_by_scan)
{
    for (uint32_t bodies = LONG - 1; bodies <= LONG; bodies++) {
        struct test_case s;
        open_case(&s, bodies, revolute, NULL, (tfa_workspace_options){0});
        for (int pool = 0; pool < 2; pool++)
            assert_int_equal(method_of(&s, &plain, pool),
                             bodies < LONG ? TFA_METHOD_ABA : TFA_METHOD_SCAN);
        close_case(&s);
    }
}

/* Requests that the scan does not take in segment lanes, other arithmetics */
TEST(other_requests_do_not)
{
    static const tfa_workspace_options precisions[] = {
        {.precision = TFA_F32}, {.precision = TFA_F128}, {.residual = TFA_RESIDUAL_F128}};
    static const double wrench[6] = {1},
                        payload[TFA_PAYLOAD_NUMBERS] = {1, 0, 0, 0, 1e-3, 0, 0, 1e-3, 0, 1e-3};
    const uint32_t joint = 3;
    const tfa_request aba[] = {
        {.refine = 1},
        {.wrench_count = 1, .wrenches = wrench},
        {.payload_count = 1, .payloads = payload},
        {.locked_count = 1, .locked = &joint},
        {.tip_count = 1, .tips = {LONG}},
    };
    const tfa_request lambda = {.op = TFA_OP_OPERATIONAL_INERTIA, .tip_count = 1, .tips = {LONG}};
    struct test_case s;
    open_case(&s, LONG, revolute, NULL, (tfa_workspace_options){0});
    for (int pool = 0; pool < 2; pool++) {
        for (size_t k = 0; k < sizeof aba / sizeof *aba; k++)
            assert_int_equal(method_of(&s, &aba[k], pool), TFA_METHOD_ABA);
        assert_int_equal(method_of(&s, &lambda, pool), TFA_METHOD_PROPAGATION);
    }
    close_case(&s);
    for (size_t k = 0; k < sizeof precisions / sizeof *precisions; k++) {
        open_case(&s, LONG, revolute, NULL, precisions[k]);
        assert_int_equal(method_of(&s, &plain, 0), TFA_METHOD_ABA);
        close_case(&s);
    }
}

/* Chains with other joints, rotor inertia or a floating base, trees */
TEST(other_robots_do_not)
{
    static const random_robot_options robots[] = {
        {.shape = RANDOM_CHAIN, .all_types = true},
        {.shape = RANDOM_CHAIN, .armature_chance = 1},
        {.shape = RANDOM_STAR},
        {.shape = RANDOM_CHAIN}, /* on a floating base */
    };
    static const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    for (size_t k = 0; k < sizeof robots / sizeof *robots; k++) {
        struct test_case s;
        open_case(&s, LONG + 8, robots[k], k == 3 ? &floating : NULL, (tfa_workspace_options){0});
        assert_int_equal(method_of(&s, &plain, 0), TFA_METHOD_ABA);
        close_case(&s);
    }
}

/* A state has the same bits alone, in a batch, in a batch that is cut, and by several threads. */
TEST(bits_depend_on_the_state_alone)
{
    struct test_case s;
    tfa_answer answers[STATES];
    open_case(&s, LONG, revolute, NULL, (tfa_workspace_options){0});
    const size_t n = LONG;
    double *q = numbers(n * STATES), *tau = numbers(n * STATES), *qdd = calloc(n * STATES * 4, 8);
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = STATES,
                     .q = q,
                     .tau = tau};
    tfa_reply reply = {.qdd = qdd, .answers = answers};
    assert_int_equal(tfa_compute(s.workspace, &r, &reply), TFA_OK);
    for (uint32_t k = 0; k < STATES; k++)
        assert_int_equal(answers[k].method, TFA_METHOD_SCAN);
    reply.qdd = qdd + n * STATES;
    assert_int_equal(tfa_batch_pool_compute(s.pool, &r, &reply), TFA_OK);
    reply.qdd = qdd + 2 * n * STATES;
    assert_int_equal(tfa_compute_states(s.workspace, &r, 0, 2, &reply), TFA_OK);
    assert_int_equal(tfa_batch_pool_compute_states(s.pool, &r, 2, STATES - 2, &reply), TFA_OK);
    for (uint32_t k = 0; k < STATES; k++) {
        const tfa_request one = {
            .op = r.op, .refine = r.refine, .count = 1, .q = q + n * k, .tau = tau + n * k};
        tfa_reply alone = {.qdd = qdd + 3 * n * STATES + n * k};
        assert_int_equal(tfa_batch_pool_compute(s.pool, &one, &alone), TFA_OK);
    }
    for (size_t k = 1; k < 4; k++)
        assert_memory_equal(qdd, qdd + k * n * STATES, n * STATES * sizeof *qdd);
    free(q);
    free(tau);
    free(qdd);
    close_case(&s);
}
