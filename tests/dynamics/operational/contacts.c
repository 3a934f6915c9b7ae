/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * 32 contact points of a humanoid, eight on each hand and foot: lambda_inv (the Delassus matrix)
 * by every method that answers it, against dense algebra in quadruple precision; with J,
 * bias_acceleration, Lambda and task torques beside it.
 */
#include "models.h"
#include "operational.h"
#include "test.h"

#define POINTS 32
#define LIMBS 4
#define STATES 3
#define MOST 128 /* links of the file */

static const struct {
    const char *name;
    tfa_method method;
    double bound;
} methods[] = {
    {"auto", TFA_METHOD_AUTO, 1e-12},         {"propagation", TFA_METHOD_PROPAGATION, 1e-12},
    {"pv-osimr", TFA_METHOD_PV_OSIMR, 1e-12}, {"efpa", TFA_METHOD_EFPA, 1e-12},
    {"crba", TFA_METHOD_CRBA, 1e-11},         {"aba", TFA_METHOD_ABA, 1e-12},
};
#define METHODS (sizeof methods / sizeof *methods)

/* A humanoid with contact points */
struct robot {
    tfa_description *file, whole;
    tfa_link links[MOST + POINTS];
    tfa_joint joints[MOST + POINTS];
    char names[2 * POINTS][16];
    tfa_model *model;
    tfa_workspace *w, *f128;
    oracle *o;
    random_states *x;
    tfa_request r;
    uint32_t n;
};

static uint32_t link_of(const tfa_description *d, const char *name)
{
    for (uint32_t k = 0; k < d->link_count; k++)
        if (strcmp(d->links[k].name, name) == 0)
            return k;
    fail_msg("no link '%s'", name);
    return 0;
}

static void add_points(struct robot *h, random_source *s)
{
    static const char *const limbs[LIMBS] = {"left_palm", "right_palm", "left_foot", "right_foot"};
    const tfa_description *d = h->file;
    assert_true(d->link_count <= MOST);
    memcpy(h->links, d->links, d->link_count * sizeof *d->links);
    memcpy(h->joints, d->joints, d->joint_count * sizeof *d->joints);
    h->whole = *d;
    h->whole.links = h->links;
    h->whole.joints = h->joints;
    for (uint32_t p = 0; p < POINTS; p++) {
        const uint32_t link = (uint32_t)h->whole.link_count++;
        tfa_joint *j = &h->joints[h->whole.joint_count++];
        snprintf(h->names[2 * p], sizeof h->names[0], "contact %u", (unsigned)p);
        snprintf(h->names[2 * p + 1], sizeof h->names[0], "weld %u", (unsigned)p);
        h->links[link] = (tfa_link){.name = h->names[2 * p], .quat = {0, 0, 0, 1}};
        *j = (tfa_joint){.name = h->names[2 * p + 1],
                         .type = TFA_JOINT_FIXED,
                         .parent = link_of(d, limbs[p % LIMBS]),
                         .child = link,
                         .mimic = -1};
        for (int i = 0; i < 3; i++)
            j->xyz[i] = random_uniform(s, -0.1, 0.1);
        random_quaternion(s, j->quat);
        h->r.tips[p] = link;
    }
}

static void open_robot(struct robot *h, const char *file)
{
    random_source s = {5};
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    const tfa_workspace_options options = {.max_tips = POINTS},
                                quadruple = {.precision = TFA_F128, .max_tips = POINTS};
    memset(h, 0, sizeof *h);
    h->file = bundled_description(file);
    add_points(h, &s);
    h->model = compiled(&h->whole, &floating);
    h->w = workspace_for(h->model, &options);
    h->f128 = workspace_for(h->model, &quadruple);
    assert_int_equal(tfa_workspace_max_tips(h->w), POINTS);
    h->o = oracle_create(&h->whole, TFA_BASE_FLOATING);
    h->n = oracle_freedoms(h->o);
    h->x = random_states_create(7, &h->whole, h->o, STATES, 0);
    h->r.count = STATES;
    h->r.tip_count = POINTS;
    h->r.q = h->x->q;
    h->r.v = h->x->v;
    h->r.base_pose = h->x->base_pose;
    h->r.base_twist = h->x->base_twist;
    for (uint32_t p = 0; p < POINTS; p++)
        assert_int_equal(tfa_model_find_frame(h->model, h->names[2 * p]), h->r.tips[p]);
}

static void close_robot(struct robot *h)
{
    random_states_free(h->x);
    oracle_free(h->o);
    tfa_workspace_free(h->f128);
    tfa_workspace_free(h->w);
    tfa_model_free(h->model);
    tfa_description_free(h->file);
}

/* State k of the oracle: J (rows x n), bias accelerations (rows), lambda_inv */
static void ask_oracle(struct robot *h, uint32_t k, quad *J, quad *bias, quad *A)
{
    const oracle_tips tips = {h->r.tips, POINTS, h->r.rows == TFA_ROWS_POINT ? 3 : 6, h->r.frame};
    oracle_set_state(h->o, &h->r, k);
    oracle_jacobian(h->o, &tips, J);
    oracle_bias_acceleration(h->o, &tips, bias);
    oracle_inverse_of_rows(h->o, J, POINTS * tips.rows, A);
}

static double error_of(const double *x, const quad *want, size_t count)
{
    const double error = op_error(x, want, count, 0);
    return isnan(error) ? INFINITY : error;
}

static void check(const char *what, const double *x, const quad *want, size_t count, double bound,
                  double *worst)
{
    const double error = error_of(x, want, count);
    if (!(error <= bound))
        fail_msg("%s: error %.3g, bound %g", what, error, bound);
    *worst = fmax(*worst, error);
}

/* Every method, one kind of rows in one frame */
static void delassus(struct robot *h, tfa_rows rows, tfa_reference_frame frame)
{
    const size_t m = POINTS * (rows == TFA_ROWS_POINT ? 3 : 6), n = h->n;
    quad *J = op_alloc(STATES * m * n, sizeof *J), *bias = op_alloc(STATES * m, sizeof *bias);
    quad *A = op_alloc(STATES * m * m, sizeof *A);
    double *got = op_alloc(STATES * m * m, sizeof *got),
           *got_J = op_alloc(STATES * m * n, sizeof *got_J);
    double *got_bias = op_alloc(STATES * m, sizeof *got_bias);
    h->r.rows = rows;
    h->r.frame = frame;
    for (uint32_t k = 0; k < STATES; k++)
        ask_oracle(h, k, J + k * m * n, bias + k * m, A + k * m * m);
    for (size_t w = 0; w <= METHODS; w++) {
        const int quadruple = w == METHODS;
        tfa_reply reply = {.lambda_inv = got, .jacobian = got_J, .bias_acceleration = got_bias};
        tfa_request r = h->r;
        double worst = 0, motion = 0;
        r.op = TFA_OP_OPERATIONAL_INERTIA;
        r.method = quadruple ? TFA_METHOD_PV_OSIMR : methods[w].method;
        r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION;
        for (size_t e = 0; e < STATES * m * m; e++)
            got[e] = NAN;
        assert_int_equal(tfa_compute(quadruple ? h->f128 : h->w, &r, &reply), TFA_OK);
        for (size_t k = 0; k < STATES; k++) {
            check("lambda_inv", got + k * m * m, A + k * m * m, m * m,
                  quadruple ? 1e-14 : methods[w].bound, &worst);
            check("jacobian", got_J + k * m * n, J + k * m * n, m * n, 1e-13, &motion);
            check("bias_acceleration", got_bias + k * m, bias + k * m, m, 1e-13, &motion);
        }
        print_message("  %-16s %u rows, frame %d: lambda_inv %.2g, J and J-dot v %.2g\n",
                      quadruple ? "pv-osimr, f128" : methods[w].name, (unsigned)m, (int)frame,
                      worst, motion);
    }
    free(got_bias);
    free(got_J);
    free(got);
    free(A);
    free(bias);
    free(J);
}

TEST(contact_points_of_a_humanoid)
{
    static struct robot h;
    open_robot(&h, "humanoid.urdf");
    for (int frame = 0; frame < 3; frame++)
        delassus(&h, TFA_ROWS_POINT, (tfa_reference_frame)frame);
    delassus(&h, TFA_ROWS_POSE, TFA_FRAME_LOCAL_WORLD_ALIGNED);
    close_robot(&h);
}

/* Four limbs have 24 independent rows; accelerations that the limbs can have are reached. */
TEST(task_of_all_contact_points)
{
    static struct robot h;
    open_robot(&h, "humanoid.urdf");
    enum { ROWS = 3 * POINTS };
    static double desired[STATES * ROWS], lambda[STATES * ROWS * ROWS], J[STATES * ROWS * MOST];
    static double bias[STATES * ROWS], tau[STATES * MOST], wrench[STATES * 6], qdd[STATES * MOST];
    static double base[STATES * 6];
    tfa_rank rank[STATES];
    random_source s = {11};
    tfa_request r = h.r;
    const uint32_t nv = h.n - 6;
    r.rows = TFA_ROWS_POINT;
    r.op = TFA_OP_TASK_TORQUES;
    r.task_acceleration = desired;
    r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_LAMBDA;
    tfa_reply reply = {.jacobian = J,
                       .bias_acceleration = bias,
                       .lambda = lambda,
                       .rank = rank,
                       .tau = tau,
                       .base_wrench = wrench};
    assert_int_equal(tfa_compute(h.w, &r, &reply), TFA_OK);
    for (uint32_t k = 0; k < STATES; k++) { /* J times random accelerations is in reach */
        double x[MOST];
        assert_int_equal(rank[k].rank, 6 * LIMBS);
        for (uint32_t j = 0; j < h.n; j++)
            x[j] = random_uniform(&s, -5, 5);
        for (uint32_t i = 0; i < ROWS; i++) {
            desired[k * ROWS + i] = bias[k * ROWS + i];
            for (uint32_t j = 0; j < h.n; j++)
                desired[k * ROWS + i] += J[((size_t)k * ROWS + i) * h.n + j] * x[j];
        }
    }
    assert_int_equal(tfa_compute(h.w, &r, &reply), TFA_OK);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.tau = tau;
    r.base_wrench = wrench;
    r.flags = 0;
    reply = (tfa_reply){.qdd = qdd, .base_acceleration = base};
    assert_int_equal(tfa_compute(h.w, &r, &reply), TFA_OK);
    double worst = 0;
    for (uint32_t k = 0; k < STATES; k++) {
        double got[ROWS];
        for (uint32_t i = 0; i < ROWS; i++) {
            got[i] = bias[k * ROWS + i];
            for (uint32_t j = 0; j < h.n; j++)
                got[i] += J[((size_t)k * ROWS + i) * h.n + j] *
                          (j < 6 ? base[6 * k + j] : qdd[(size_t)k * nv + j - 6]);
        }
        worst = fmax(worst, op_difference(got, desired + k * ROWS, ROWS, 0));
    }
    print_message("  worst %.2g\n", worst);
    assert_true(worst <= 1e-10);
    close_robot(&h);
}

/* ---- limits ---- */

static void expect(tfa_workspace *w, tfa_request r, int status, uint32_t index)
{
    tfa_reply reply = {0};
    assert_int_equal(tfa_compute(w, &r, &reply), status);
    assert_int_equal(reply.status, status);
    assert_int_equal(reply.field, status ? TFA_FIELD_TIPS : TFA_FIELD_NONE);
    assert_int_equal(reply.index, index);
}

TEST(tips_beyond_memory_are_refused)
{
    static struct robot h;
    open_robot(&h, "humanoid.urdf");
    static const tfa_op ops[] = {TFA_OP_OPERATIONAL_INERTIA, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_KINEMATICS, TFA_OP_TASK_TORQUES};
    static double desired[STATES * 6 * (POINTS + 1)];
    tfa_workspace *few = workspace_for(h.model, NULL);
    const tfa_workspace_options two = {.max_tips = 2}, many = {.max_tips = TFA_MAX_TIPS + 1};
    tfa_workspace *pair = workspace_for(h.model, &two), *none = NULL;
    assert_int_equal(tfa_workspace_max_tips(few), TFA_DEFAULT_TIPS);
    assert_int_equal(tfa_workspace_max_tips(pair), 2);
    assert_int_equal(tfa_workspace_create(h.model, &many, &none), TFA_E_UNSUPPORTED);
    assert_null(none);
    assert_int_equal(tfa_workspace_size(h.model, &many), 0);
    assert_true(tfa_workspace_size(h.model, &two) < tfa_workspace_size(h.model, NULL));
    for (size_t k = 0; k < sizeof ops / sizeof *ops; k++) {
        tfa_request r = h.r;
        r.op = ops[k];
        r.task_acceleration = desired;
        r.flags = TFA_WANT_POSES;
        expect(h.w, r, TFA_OK, 0);
        expect(few, r, TFA_E_UNSUPPORTED, TFA_DEFAULT_TIPS); /* the first one too many */
        r.tip_count = TFA_DEFAULT_TIPS + 1;
        expect(few, r, TFA_E_UNSUPPORTED, TFA_DEFAULT_TIPS);
        r.tip_count = TFA_DEFAULT_TIPS;
        expect(few, r, TFA_OK, 0);
        r.tip_count = 3;
        expect(pair, r, TFA_E_UNSUPPORTED, 2);
        r.tip_count = 2;
        expect(pair, r, TFA_OK, 0);
        r.tip_count = TFA_MAX_TIPS + 1;
        expect(h.w, r, TFA_E_SIZE, TFA_MAX_TIPS + 1);
        expect(few, r, TFA_E_SIZE, TFA_MAX_TIPS + 1);
    }
    tfa_workspace_free(pair);
    tfa_workspace_free(few);
    close_robot(&h);
}
