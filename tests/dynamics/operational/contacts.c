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
    random_states *x;
    op_case c; /* of it: name, sizes, workspaces, oracle and request */
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
        h->c.r.tips[p] = link;
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
    h->c.f64 = workspace_for(h->model, &options);
    h->c.f128 = workspace_for(h->model, &quadruple);
    assert_int_equal(tfa_workspace_max_tips(h->c.f64), POINTS);
    h->c.o = oracle_create(&h->whole, TFA_BASE_FLOATING);
    h->c.n = oracle_freedoms(h->c.o);
    h->c.six = 6;
    h->c.nv = h->c.n - 6;
    h->c.nq = oracle_q_count(h->c.o);
    h->c.link_count = (uint32_t)h->whole.link_count;
    snprintf(h->c.name, sizeof h->c.name, "%s", file);
    h->x = random_states_create(7, &h->whole, h->c.o, STATES, 0);
    h->c.r.count = STATES;
    h->c.r.tip_count = POINTS;
    h->c.r.q = h->x->q;
    h->c.r.v = h->x->v;
    h->c.r.base_pose = h->x->base_pose;
    h->c.r.base_twist = h->x->base_twist;
    for (uint32_t p = 0; p < POINTS; p++)
        assert_int_equal(tfa_model_find_frame(h->model, h->names[2 * p]), h->c.r.tips[p]);
}

static void close_robot(struct robot *h)
{
    random_states_free(h->x);
    oracle_free(h->c.o);
    tfa_workspace_free(h->c.f128);
    tfa_workspace_free(h->c.f64);
    tfa_model_free(h->model);
    tfa_description_free(h->file);
}

/* State k of the oracle: J (rows x n), bias accelerations (rows), lambda_inv */
static void ask_oracle(struct robot *h, uint32_t k, quad *J, quad *bias, quad *A)
{
    const oracle_tips tips = {h->c.r.tips, POINTS, h->c.r.rows == TFA_ROWS_POINT ? 3 : 6,
                              h->c.r.frame};
    oracle_set_state(h->c.o, &h->c.r, k);
    oracle_jacobian(h->c.o, &tips, J);
    oracle_bias_acceleration(h->c.o, &tips, bias);
    oracle_inverse_of_rows(h->c.o, J, POINTS * tips.rows, A);
}

/* Every method, one kind of rows in one frame */
static void delassus(struct robot *h, tfa_rows rows, tfa_reference_frame frame)
{
    const size_t m = POINTS * (rows == TFA_ROWS_POINT ? 3 : 6), n = h->c.n;
    quad *J = op_alloc(STATES * m * n, sizeof *J), *bias = op_alloc(STATES * m, sizeof *bias);
    quad *A = op_alloc(STATES * m * m, sizeof *A);
    h->c.r.rows = rows;
    h->c.r.frame = frame;
    for (uint32_t k = 0; k < STATES; k++)
        ask_oracle(h, k, J + k * m * n, bias + k * m, A + k * m * m);
    for (size_t w = 0; w <= METHODS; w++) {
        const int quadruple = w == METHODS;
        tfa_request r = h->c.r;
        op_bound lambda = {"lambda_inv", {quadruple ? 1e-14 : methods[w].bound}, {0}};
        op_bound motion = {"J and J-dot v", {1e-13}, {0}};
        r.op = TFA_OP_OPERATIONAL_INERTIA;
        r.method = quadruple ? TFA_METHOD_PV_OSIMR : methods[w].method;
        r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION;
        op_answers *a = op_answers_create(&h->c, &r);
        op_compute(&h->c, quadruple ? h->c.f128 : h->c.f64, &r, a);
        for (size_t k = 0; k < STATES; k++) {
            op_within(&h->c, &lambda, op_error(a->lambda_inv + k * m * m, A + k * m * m, m * m, 0));
            op_within(&h->c, &motion, op_error(a->jacobian + k * m * n, J + k * m * n, m * n, 0));
            op_within(&h->c, &motion, op_error(a->bias_acceleration + k * m, bias + k * m, m, 0));
        }
        op_answers_free(a);
        print_message("  %-16s %u rows, frame %d: lambda_inv %.2g, J and J-dot v %.2g\n",
                      quadruple ? "pv-osimr, f128" : methods[w].name, (unsigned)m, (int)frame,
                      lambda.worst[0], motion.worst[0]);
    }
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
    static double desired[STATES * ROWS];
    op_bound reached = {"J qdd + bias_acceleration = desired", {1e-10}, {0}};
    random_source s = {11};
    h.c.r.rows = TFA_ROWS_POINT;
    tfa_request r = h.c.r;
    r.op = TFA_OP_TASK_TORQUES;
    r.task_acceleration = desired;
    r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_LAMBDA;
    op_answers *a = op_answers_create(&h.c, &r);
    op_compute(&h.c, h.c.f64, &r, a);
    for (uint32_t k = 0; k < STATES; k++) { /* J times random accelerations is in reach */
        double qdd[MOST];
        assert_int_equal(a->rank[k].rank, 6 * LIMBS);
        for (uint32_t j = 0; j < h.c.n; j++)
            qdd[j] = random_uniform(&s, -5, 5);
        (void)op_tip_acceleration(a, k, qdd, desired + (size_t)k * ROWS);
    }
    op_compute(&h.c, h.c.f64, &r, a);
    for (uint32_t k = 0; k < STATES; k++) {
        double tau[MOST], qdd[MOST], got[ROWS];
        op_forces(&h.c, a, k, tau);
        op_move(&h.c, h.c.f64, k, tau, qdd);
        (void)op_tip_acceleration(a, k, qdd, got);
        op_within(&h.c, &reached, op_difference(got, desired + (size_t)k * ROWS, ROWS, 0));
    }
    op_print(&reached, 1);
    op_answers_free(a);
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
        tfa_request r = h.c.r;
        r.op = ops[k];
        r.task_acceleration = desired;
        r.flags = TFA_WANT_POSES;
        expect(h.c.f64, r, TFA_OK, 0);
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
        expect(h.c.f64, r, TFA_E_SIZE, TFA_MAX_TIPS + 1);
        expect(few, r, TFA_E_SIZE, TFA_MAX_TIPS + 1);
    }
    tfa_workspace_free(pair);
    tfa_workspace_free(few);
    close_robot(&h);
}
