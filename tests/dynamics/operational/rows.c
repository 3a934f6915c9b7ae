/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows of points are the linear rows of poses: in J, bias_acceleration and lambda_inv; and Lambda,
 * mu and p of a point solve the equations of these rows alone.
 */
#include "operational.h"
#include "test.h"

#define TIPS 4

enum { JACOBIAN, BIAS, INVERSE, SOLVED, KINDS };
static op_bound bounds[] = {
    {"jacobian", {1e-14}, {0}},
    {"bias_acceleration", {1e-14}, {0}},
    {"lambda_inv", {1e-14}, {0}},
    {"mu and p of a point", {1e-14}, {0}},
};
static uint32_t solved;

static uint32_t row_of(uint32_t i)
{
    return 6 * (i / 3) + i % 3;
}

static void check_rows(const op_case *c, const op_answers *pose, const op_answers *point,
                       uint32_t k)
{
    double rows[3 * TIPS * OP_FREEDOMS], bias[3 * TIPS], block[9 * TIPS * TIPS];
    const uint32_t m = point->rows, all = pose->rows, n = c->n;
    for (uint32_t i = 0; i < m; i++) {
        const uint32_t at = row_of(i);
        memcpy(rows + (size_t)i * n, pose->jacobian + ((size_t)k * all + at) * n, n * sizeof *rows);
        bias[i] = pose->bias_acceleration[(size_t)k * all + at];
        for (uint32_t j = 0; j < m; j++)
            block[i * m + j] = pose->lambda_inv[((size_t)k * all + at) * all + row_of(j)];
    }
    const double *J = point->jacobian + (size_t)k * m * n;
    op_within(c, &bounds[JACOBIAN], op_difference(J, rows, (size_t)m * n, 0));
    op_within(c, &bounds[BIAS],
              op_difference(point->bias_acceleration + (size_t)k * m, bias, m, 0));
    op_within(c, &bounds[INVERSE],
              op_difference(point->lambda_inv + (size_t)k * m * m, block, (size_t)m * m, 0));
}

/* lambda_inv p = J M^-1 gravity: linear rows of what the pose's p solves, where both ranks are
 * full. The same of mu. */
static void check_solution(const op_case *c, const op_answers *pose, const op_answers *point,
                           uint32_t k)
{
    const uint32_t m = point->rows, all = pose->rows;
    if (pose->rank[k].rank < all || point->rank[k].rank < m || pose->rank[k].condition > 1e5)
        return;
    for (int which = 0; which < 2; which++) {
        const double *whole = (which ? pose->mu : pose->p) + (size_t)k * all;
        const double *part = (which ? point->mu : point->p) + (size_t)k * m;
        const double *A = pose->lambda_inv + (size_t)k * all * all;
        const double *B = point->lambda_inv + (size_t)k * m * m;
        double want[3 * TIPS], got[3 * TIPS];
        for (uint32_t i = 0; i < m; i++) {
            want[i] = got[i] = 0;
            for (uint32_t j = 0; j < all; j++)
                want[i] += A[row_of(i) * all + j] * whole[j];
            for (uint32_t j = 0; j < m; j++)
                got[i] += B[i * m + j] * part[j];
        }
        const double size = norm2(A, (size_t)all * all) * norm2(whole, all);
        op_within(c, &bounds[SOLVED], op_difference(got, want, m, size));
    }
    solved++;
}

static void rows_agree(op_case *c)
{
    static const tfa_op ops[] = {TFA_OP_OPERATIONAL_INERTIA, TFA_OP_FORWARD_DYNAMICS};
    for (int frame = 0; frame < 3; frame++) {
        op_choose_tips(c, 1 + (uint32_t)frame % TIPS, TFA_ROWS_POSE, (tfa_reference_frame)frame);
        tfa_request r = c->r;
        r.op = ops[random_below(&c->s, 2)];
        r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_TWISTS |
                  TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P;
        op_answers *pose = op_answer(c, c->f64, &r);
        r.rows = TFA_ROWS_POINT;
        op_answers *point = op_answer(c, c->f64, &r);
        assert_memory_equal(point->twists, pose->twists, /* always six numbers */
                            r.count * 6 * r.tip_count * sizeof *pose->twists);
        for (uint32_t k = 0; k < r.count; k++) {
            check_rows(c, pose, point, k);
            check_solution(c, pose, point, k);
        }
        op_answers_free(point);
        op_answers_free(pose);
    }
}

TEST(points_are_the_linear_rows_of_poses)
{
    op_for_each(OP_ALL, rows_agree);
    op_print(bounds, KINDS);
    assert_true(solved > 100);
}
