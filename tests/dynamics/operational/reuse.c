/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * An answer depends on its request only: after any other requests it has the bits that a workspace
 * just made gives; a batch has those of its states one by one; and answers that need no solution
 * have the same bits whichever op and flags stand beside them.
 */
#include "operational.h"
#include "support/fixture.h"
#include "test.h"

#define FREEDOMS 30 /* robots larger than this take too long */
#define REQUESTS 12
#define KINEMATICS                                                                                 \
    (TFA_WANT_POSES | TFA_WANT_FRAME_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |                 \
     TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY)

static const tfa_op ops[] = {TFA_OP_KINEMATICS,       TFA_OP_FORWARD_DYNAMICS,
                             TFA_OP_INVERSE_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                             TFA_OP_MASS_MATRIX,      TFA_OP_BIAS,
                             TFA_OP_TASK_TORQUES};
#define OPS (sizeof ops / sizeof *ops)

static double desired[OP_STATES * OP_ROWS];
static const double weightless[3] = {0, 0, 0};
static uint32_t compared;

static bool has_lambda(tfa_op op)
{
    return op == TFA_OP_FORWARD_DYNAMICS || op == TFA_OP_OPERATIONAL_INERTIA ||
           op == TFA_OP_TASK_TORQUES;
}

/* A request with some of everything */
static tfa_request draw(op_case *c)
{
    op_choose_tips(c, 1 + random_below(&c->s, OP_TIPS), (tfa_rows)random_below(&c->s, 2),
                   (tfa_reference_frame)random_below(&c->s, 3));
    if (random_below(&c->s, 2))
        (void)op_lock(c);
    else
        op_unlock(c);
    tfa_request r = c->r;
    r.op = ops[random_below(&c->s, OPS)];
    r.flags = (uint32_t)random_bits(&c->s) & TFA_WANT_ALL;
    if (!has_lambda(r.op))
        r.flags &= KINEMATICS;
    r.rank_loss = (tfa_rank_loss)random_below(&c->s, 2);
    r.task_acceleration = desired;
    if (r.op == TFA_OP_MASS_MATRIX)
        r.locked_count = 0;
    if (random_below(&c->s, 3) == 0)
        r.v = r.base_twist = NULL;
    if (random_below(&c->s, 3) == 0)
        r.wrench_count = 0;
    if (random_below(&c->s, 3) == 0)
        r.payload_count = 0;
    if (random_below(&c->s, 3) == 0)
        r.gravity = weightless;
    if (random_below(&c->s, 3) == 0)
        r.tau = NULL;
    if (random_below(&c->s, 3) == 0)
        r.count = 1;
    op_choose_method(c, &r);
    return r;
}

static void same(const op_case *c, const tfa_request *r, const char *what, const op_answers *a,
                 const op_answers *b)
{
    if (memcmp(a->memory, b->memory, a->size * sizeof *a->memory) != 0 ||
        memcmp(a->rank, b->rank, a->count * sizeof *a->rank) != 0 ||
        memcmp(a->spectrum, b->spectrum, a->count * sizeof *a->spectrum) != 0 ||
        memcmp(a->answers, b->answers, a->count * sizeof *a->answers) != 0) {
        size_t k = 0;
        while (k < a->size && memcmp(a->memory + k, b->memory + k, sizeof *a->memory) == 0)
            k++;
        fail_msg("%s: %s: op %d, flags %x, %u tips, %u rows, frame %d, %u locked, %u states: number"
                 " %zu of %zu is %.17g, not %.17g",
                 c->name, what, (int)r->op, (unsigned)r->flags, (unsigned)r->tip_count,
                 (unsigned)a->rows, (int)r->frame, (unsigned)r->locked_count, (unsigned)r->count, k,
                 a->size, k < a->size ? b->memory[k] : 0, k < a->size ? a->memory[k] : 0);
    }
    compared++;
}

/* State k of answers to several, where those to one stand */
static void copy_state(const op_answers *all, uint32_t k, op_answers *one)
{
    double *from = all->memory, *to = one->memory;
    const size_t n = all->n, m = all->rows;
    const size_t sizes[] = {all->nv,
                            all->nv,
                            6,
                            6,
                            m * m,
                            n * n,
                            7 * (size_t)all->tips,
                            7 * (size_t)all->frames,
                            6 * (size_t)all->tips,
                            m * n,
                            m,
                            3,
                            3,
                            3 * n,
                            1,
                            6,
                            2,
                            m * m,
                            m,
                            m,
                            TFA_LOST_MAX * (2 + m),
                            n,
                            n,
                            n,
                            n,
                            n};
    size_t total = 0;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        memcpy(to, from + k * sizes[i], sizes[i] * sizeof *to);
        to += sizes[i];
        total += sizes[i];
        from += all->count * sizes[i];
    }
    assert_int_equal(total, one->size);
    one->rank[0] = all->rank[k];
    one->spectrum[0] = all->spectrum[k];
    one->answers[0] = all->answers[k];
}

static void one_by_one(op_case *c, tfa_workspace *w, const tfa_request *r, const op_answers *all)
{
    const tfa_request before = c->r;
    c->r = *r;
    for (uint32_t k = 0; k < r->count; k++) {
        const tfa_request one = op_state(c, k);
        op_answers *a = op_answers_create(c, &one), *b = op_answers_create(c, &one);
        op_compute(c, w, &one, a);
        copy_state(all, k, b);
        same(c, r, "alone and in a batch", b, a);
        op_answers_free(b);
        op_answers_free(a);
    }
    c->r = before;
}

static void with_precision(op_case *c, tfa_workspace *used, tfa_precision precision)
{
    tfa_workspace *w = NULL;
    for (int k = 0; k < REQUESTS; k++) {
        tfa_request r = draw(c);
        r.count = precision == TFA_F128 ? 1 : r.count;
        op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
        w = fixture_workspace(c->model, precision);
        op_compute(c, w, &r, a);
        op_compute(c, used, &r, b);
        same(c, &r, "workspace used before", a, b);
        op_compute(c, used, &r, b);
        same(c, &r, "asked twice", a, b);
        if (r.count > 1)
            one_by_one(c, w, &r, a);
        tfa_workspace_free(w);
        op_answers_free(b);
        op_answers_free(a);
    }
}

static void reuse(op_case *c)
{
    if (c->n > FREEDOMS)
        return;
    for (size_t k = 0; k < sizeof desired / sizeof *desired; k++)
        desired[k] = random_uniform(&c->s, -5, 5);
    with_precision(c, c->f64, TFA_F64);
    if (c->n <= 8)
        with_precision(c, c->f128, TFA_F128);
}

TEST(answers_depend_on_their_request_only)
{
    op_for_each(OP_ALL, reuse);
    print_message("  %u answers compared\n", compared);
}

/* ---- beside others ---- */

static void same_array(const op_case *c, tfa_op op, const char *what, const double *x,
                       const double *y, size_t count)
{
    if (memcmp(x, y, count * sizeof *x) != 0)
        fail_msg("%s: op %d: %s differs from that of kinematics alone", c->name, (int)op, what);
}

static void same_motion(const op_case *c, tfa_op op, const op_answers *a, const op_answers *b)
{
    const size_t k = a->count, m = a->rows, n = a->n;
    same_array(c, op, "poses", a->poses, b->poses, k * 7 * a->tips);
    same_array(c, op, "frame_poses", a->frame_poses, b->frame_poses, k * 7 * a->frames);
    same_array(c, op, "twists", a->twists, b->twists, k * 6 * a->tips);
    same_array(c, op, "jacobian", a->jacobian, b->jacobian, k * m * n);
    same_array(c, op, "bias_acceleration", a->bias_acceleration, b->bias_acceleration, k * m);
    same_array(c, op, "com", a->com, b->com, k * 3);
    same_array(c, op, "com_velocity", a->com_velocity, b->com_velocity, k * 3);
    same_array(c, op, "com_jacobian", a->com_jacobian, b->com_jacobian, k * 3 * n);
    same_array(c, op, "mass", a->mass, b->mass, k);
    same_array(c, op, "momentum", a->momentum, b->momentum, k * 6);
    same_array(c, op, "energy", a->energy, b->energy, k * 2);
}

static void beside_others(op_case *c)
{
    op_choose_tips(c, 2, (tfa_rows)random_below(&c->s, 2),
                   (tfa_reference_frame)random_below(&c->s, 3));
    tfa_request r = c->r;
    r.op = TFA_OP_KINEMATICS;
    r.flags = KINEMATICS;
    r.task_acceleration = desired;
    op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
    op_compute(c, c->f64, &r, a);
    for (size_t k = 0; k < OPS; k++) {
        r.op = ops[k];
        r.flags = has_lambda(r.op) ? TFA_WANT_ALL : KINEMATICS;
        op_compute(c, c->f64, &r, b);
        same_motion(c, r.op, a, b);
    }
    r.op = TFA_OP_KINEMATICS;
    op_answers_clear(b);
    for (uint32_t flag = 1; flag <= TFA_WANT_ENERGY; flag *= 2) {
        r.flags = flag & KINEMATICS;
        assert_int_equal(tfa_compute(c->f64, &r, &b->reply), TFA_OK);
    }
    same_motion(c, r.op, a, b);
    op_answers_free(b);
    op_answers_free(a);
}

TEST(motion_is_the_same_beside_other_answers)
{
    op_for_each(OP_ALL, beside_others);
}

/* ---- what is not asked for ---- */

static bool untouched(const double *x, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (!isnan(x[k]))
            return false;
    return true;
}

/* Buffers without a flag, or of another op, stay as they are; a flag without a buffer is fine. */
static void only_what_is_asked(op_case *c)
{
    op_choose_tips(c, 2, TFA_ROWS_POSE, TFA_FRAME_LOCAL);
    tfa_request r = c->r;
    r.task_acceleration = desired;
    op_answers *a = op_answers_create(c, &r);
    for (size_t k = 0; k < OPS; k++) {
        r.op = ops[k];
        r.flags = 0;
        op_compute(c, c->f64, &r, a);
        assert_true(untouched(a->poses, (size_t)(a->lambda - a->poses))); /* to energy */
        const size_t m = a->rows;
        assert_true(untouched(a->lambda, r.count * (m * m + 2 * m)));
        if (r.op != TFA_OP_BIAS)
            assert_true(untouched(a->gravity_force, 5 * (size_t)r.count * c->n));
        if (!has_lambda(r.op))
            assert_true(untouched(a->lambda_inv, r.count * m * m));
        if (r.op != TFA_OP_MASS_MATRIX)
            assert_true(untouched(a->mass_matrix, (size_t)r.count * c->n * c->n));
        if (r.op != TFA_OP_FORWARD_DYNAMICS)
            assert_true(untouched(a->qdd, (size_t)r.count * c->nv));
        if (r.op != TFA_OP_INVERSE_DYNAMICS && r.op != TFA_OP_TASK_TORQUES)
            assert_true(untouched(a->tau, (size_t)r.count * c->nv));
        r.flags = has_lambda(r.op) ? TFA_WANT_ALL : KINEMATICS;
        tfa_reply reply = {0};
        assert_int_equal(tfa_compute(c->f64, &r, &reply), TFA_OK);
    }
    op_answers_free(a);
}

TEST(only_what_is_asked_for)
{
    op_for_each(OP_ALL, only_what_is_asked);
}
