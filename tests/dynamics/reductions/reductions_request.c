/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints locked and payloads added by one request, on top of whatever the scene has done: against
 * the oracle, and against scenes that lock and load the same.
 */
#include "model/model.h"
#include "models.h"
#include "reductions.h"
#include "test.h"

#define BOUND 1e-13
#define TFA_LAMBDA 2e-11
#define SEEDS test_extent(30, 100)
#define MOST 96 /* freedoms */
#define TIPS 3
#define ROWS (6 * TIPS)

static double worst, worst_tfa;
static unsigned compared, left_out, refused, loaded_too;

static void within(const reduction *r, const char *what, const double *x, const double *want,
                   size_t n, double bound)
{
    double error = relative_difference(x, want, n);
    if (bound == BOUND)
        worst = fmax(worst, error);
    else
        worst_tfa = fmax(worst_tfa, error);
    compared++;
    if (!(error <= bound))
        fail_msg("%s: %s: error %.3g, bound %g", r->name, what, error, bound);
}

/* Asks; false when TFA refused by name. */
static bool ask(const reduction *r, tfa_workspace *w, const tfa_request *q, tfa_reply *reply)
{
    const bool answered = reduction_ask(r, w, q, reply);
    refused += !answered;
    return answered;
}

static void must_refuse(const reduction *r, const tfa_request *q, int status, tfa_field field)
{
    double x[MOST * MOST];
    tfa_reply reply = {.qdd = x, .mass_matrix = x};
    assert_int_equal(tfa_compute(r->f64, q, &reply), status);
    assert_int_equal(reply.status, status);
    assert_int_equal(reply.field, field);
}

static void for_seeds(void (*law)(reduction *r, uint64_t seed))
{
    worst = worst_tfa = 0;
    compared = left_out = refused = 0;
    reduction_for_seeds(2001, 2000 + SEEDS, law);
    print_message("  worst %.1e (tfa %.1e) of %u, refused %u, robots left out %u\n", worst,
                  worst_tfa, compared, refused, left_out);
    assert_true(compared > SEEDS && left_out < SEEDS / 2);
}

static double bound_of(tfa_method method, bool lambda)
{
    if (!reduction_may_refuse(method))
        return BOUND;
    return lambda ? TFA_LAMBDA : BOUND;
}

/* Forward dynamics with Lambda^-1 in the same request, and Lambda^-1 alone in every frame, by the
 * methods given, of the oracle's state as it is set. */
static void check_answers(const reduction *r, const question *a, const tfa_request *request,
                          const tfa_method *methods, size_t count, tfa_workspace *w)
{
    static double lambda[ROWS * ROWS], want_lambda[ROWS * ROWS];
    double x[MOST] = {0}, want[MOST] = {0};
    const uint32_t base = r->n - r->nv;
    for (int frame = 0; frame < 3; frame++) {
        tfa_request q = *request;
        tfa_reply reply = {.qdd = x + base, .base_acceleration = x, .lambda_inv = lambda};
        const size_t rows = 6 * (size_t)q.tip_count;
        oracle_forward(r->o, q.tau, q.base_wrench, want + base, want);
        oracle_lambda_inv(r->o, a->whole.tips, a->whole.tip_count, (tfa_reference_frame)frame,
                          want_lambda);
        for (size_t m = 0; m < count; m++) {
            const char *name = tfa_method_name((uint32_t)methods[m]);
            q.method = methods[m];
            q.refine = w == r->mixed ? TFA_REFINE_DEFAULT : request->refine;
            q.frame = request->frame; /* the wrenches were given in it */
            q.op = TFA_OP_FORWARD_DYNAMICS;
            if (q.method != TFA_METHOD_PROPAGATION && q.method != TFA_METHOD_TFA_ONE_SIDED &&
                q.method != TFA_METHOD_EFPA && q.method != TFA_METHOD_PV_OSIMR &&
                ask(r, w, &q, &reply)) {
                within(r, name, x, want, r->n, bound_of(q.method, false));
                if ((int)q.frame == frame)
                    within(r, "lambda_inv besides qdd", lambda, want_lambda, rows * rows,
                           bound_of(q.method, true));
            }
            q.op = TFA_OP_OPERATIONAL_INERTIA;
            q.frame = (tfa_reference_frame)frame;
            if (ask(r, w, &q, &reply))
                within(r, name, lambda, want_lambda, rows * rows, bound_of(q.method, true));
        }
    }
}

static void choose_tips(question *a, const reduction *r, random_source *s)
{
    uint32_t first = random_below(s, (uint32_t)r->whole->link_count);
    assert_true(r->n <= MOST);
    question_tips(a, r, first, TIPS);
    if (a->r.tip_count == 0)
        question_tips(a, r, 0, TIPS);
}

/* ---- locked ---- */

struct locked {
    uint32_t joints[MOST], count;
    oracle_tie tie[MOST];
    double v[MOST], whole_v[MOST];
};

/* About a third of the public joints; what is tied to them stands still. */
static void choose_locked(const reduction *r, random_source *s, struct locked *l)
{
    const uint32_t base = r->n - r->nv;
    uint8_t still[MOST] = {0};
    l->count = 0;
    for (uint32_t k = 0; k < tfa_model_joint_count(r->model); k++) {
        tfa_joint_info info = tfa_model_joint(r->model, k);
        if (random_below(s, 3) > 0)
            continue;
        l->joints[l->count++] = k;
        for (uint32_t i = 0; i < info.v_count; i++)
            still[base + info.v_index + i] = 1;
    }
    for (uint32_t k = 0; k < base + r->whole_nv; k++) {
        l->tie[k] = r->tie[k];
        if (r->tie[k].to != ORACLE_STILL && still[r->tie[k].to])
            l->tie[k].to = ORACLE_STILL;
    }
}

/* Torques that keep the locked joints where they are are part of inverse dynamics: the equations of
 * the joints that are locked still hold, their qdd is 0 whatever the request says. */
static void check_inverse(const reduction *r, const tfa_request *request, const tfa_request *whole,
                          const struct locked *l)
{
    double x[MOST] = {0}, want[MOST] = {0}, qdd[MOST];
    const uint32_t base = r->n - r->nv;
    tfa_request q = *request;
    tfa_reply reply = {.tau = x + base, .base_wrench = x};
    memcpy(qdd, q.qdd, r->nv * sizeof *qdd);
    for (uint32_t k = 0; k < l->count; k++) {
        tfa_joint_info info = tfa_model_joint(r->model, l->joints[k]);
        memset(qdd + info.v_index, 0, info.v_count * sizeof *qdd);
    }
    oracle_tie_freedoms(r->o, r->tie, r->n);
    oracle_set_state(r->o, whole, 0);
    oracle_inverse(r->o, qdd, q.base_acceleration, want + base, want);
    q.op = TFA_OP_INVERSE_DYNAMICS;
    q.tip_count = 0;
    ask(r, r->f64, &q, &reply);
    within(r, "inverse", x, want, r->n, BOUND);
    oracle_tie_freedoms(r->o, l->tie, r->n);
    oracle_set_state(r->o, whole, 0);
}

static void check_refusals(const reduction *r, const tfa_request *request)
{
    tfa_request q = *request;
    q.method = TFA_METHOD_CRBA;
    must_refuse(r, &q, TFA_E_METHOD, TFA_FIELD_LOCKED);
    q.method = TFA_METHOD_TFA;
    must_refuse(r, &q, TFA_E_METHOD, TFA_FIELD_LOCKED);
    q.method = TFA_METHOD_AUTO;
    q.op = TFA_OP_MASS_MATRIX;
    must_refuse(r, &q, TFA_E_UNSUPPORTED, TFA_FIELD_LOCKED);
    const uint32_t nobody = tfa_model_joint_count(r->model);
    q.op = TFA_OP_FORWARD_DYNAMICS;
    q.locked = &nobody;
    q.locked_count = 1;
    must_refuse(r, &q, TFA_E_JOINT, TFA_FIELD_LOCKED);
}

/* The locked joints' qdd are zeros, not small numbers. */
static void check_zeros(const reduction *r, tfa_workspace *w, const tfa_request *request,
                        const struct locked *l)
{
    double qdd[MOST];
    tfa_reply reply = {.qdd = qdd};
    ask(r, w, request, &reply);
    for (uint32_t k = 0; k < l->count; k++) {
        tfa_joint_info info = tfa_model_joint(r->model, l->joints[k]);
        for (uint32_t i = 0; i < info.v_count; i++)
            assert_true(qdd[info.v_index + i] == 0);
    }
}

static void locked(reduction *r, uint64_t seed)
{
    static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_PROPAGATION};
    double numbers[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    question a;
    struct locked l;
    random_source s = {seed};
    if (!question_open(&a, r, seed, 2, 2)) {
        left_out++;
        return;
    }
    a.r.frame = a.whole.frame = (tfa_reference_frame)(seed % 3);
    choose_tips(&a, r, &s);
    for (uint32_t k = 0; k < 2; k++) { /* another set in each state, the velocities kept */
        choose_locked(r, &s, &l);
        if (k == 1) { /* and loaded, on the same joints and links as often as not */
            question_load(&a, r, &s, 2, numbers);
            if (!question_is_good(&a, r))
                break;
            loaded_too++;
        }
        tfa_request whole, one = question_state(&a, r, k, &whole);
        one.locked = l.joints;
        one.locked_count = l.count;
        oracle_tie_freedoms(r->o, l.tie, r->n);
        oracle_set_state(r->o, &whole, 0);
        check_answers(r, &a, &one, methods, 3, r->f64);
        check_answers(r, &a, &one, methods, 3, r->mixed);
        check_inverse(r, &one, &whole, &l);
        check_zeros(r, r->f64, &one, &l);
        check_zeros(r, r->mixed, &one, &l);
        if (l.count)
            check_refusals(r, &one);
        one.locked_count = 0; /* and let go of again */
        oracle_tie_freedoms(r->o, r->tie, r->n);
        oracle_set_state(r->o, &whole, 0);
        check_answers(r, &a, &one, methods, 3, r->f64);
        check_answers(r, &a, &one, methods, 3, r->mixed);
    }
    question_close(&a);
}

TEST(locked_is_tied_loaded_or_not)
{
    loaded_too = 0;
    for_seeds(locked);
    assert_true(loaded_too > SEEDS);
}

/* ---- locked by the request, locked by the scene ---- */

/* The model with the locks of the request among those of its scene; NULL when it has too many. */
static tfa_model *lock_in_scene(reduction *r, const struct locked *l, const double *q)
{
    tfa_lock locks[MOST];
    size_t count = r->scene.lock_count;
    memcpy(locks, r->locks, count * sizeof *locks);
    for (uint32_t k = 0; k < l->count; k++, count++) {
        tfa_joint_info info = tfa_model_joint(r->model, l->joints[k]);
        locks[count].joint = info.name;
        memcpy(locks[count].q, q + info.q_index, info.q_count * sizeof *q);
    }
    r->scene.locks = locks;
    r->scene.lock_count = count;
    r->scene.payloads = r->scene_payloads;
    r->scene.payload_count = r->payload_count;
    r->options.gravity = r->gravity;
    return reduction_compile(r, r->file, &r->options);
}

/* The request in the arrays of a model with fewer joints. */
struct smaller {
    double q[2 * MOST], v[MOST], tau[MOST];
    uint32_t from[MOST]; /* freedom of the request for each of the model */
};

static void translate(const reduction *r, const tfa_model *model, const tfa_request *in,
                      struct smaller *x, tfa_request *out)
{
    for (uint32_t k = 0; k < tfa_model_joint_count(model); k++) {
        tfa_joint_info to = tfa_model_joint(model, k);
        int32_t j = tfa_model_find_joint(r->model, to.name);
        assert_true(j >= 0);
        tfa_joint_info from = tfa_model_joint(r->model, (uint32_t)j);
        memcpy(x->q + to.q_index, in->q + from.q_index, to.q_count * sizeof *x->q);
        memcpy(x->v + to.v_index, in->v + from.v_index, to.v_count * sizeof *x->v);
        memcpy(x->tau + to.v_index, in->tau + from.v_index, to.v_count * sizeof *x->tau);
        for (uint32_t i = 0; i < to.v_count; i++)
            x->from[to.v_index + i] = from.v_index + i;
    }
    *out = *in;
    out->q = x->q;
    out->v = x->v;
    out->tau = x->tau;
    out->locked_count = 0;
    for (uint32_t k = 0; k < in->wrench_count; k++)
        out->wrench_frames[k] = (uint32_t)tfa_model_find_frame(
            model, tfa_model_frame(r->model, in->wrench_frames[k]).name);
    for (uint32_t k = 0; k < in->tip_count; k++)
        out->tips[k] =
            (uint32_t)tfa_model_find_frame(model, tfa_model_frame(r->model, in->tips[k]).name);
}

static void compare_scenes(reduction *r, const tfa_model *model, const tfa_request *request)
{
    static double lambda[2][ROWS * ROWS];
    double poses[2][7 * TIPS], x[MOST], y[MOST], z[MOST];
    const uint32_t base = r->n - r->nv, nv = tfa_model_v_count(model);
    struct smaller small;
    tfa_request q;
    tfa_workspace *w = workspace_for(model, NULL);
    translate(r, model, request, &small, &q);
    q.flags = TFA_WANT_POSES;
    tfa_reply reply = {
        .qdd = y + base, .base_acceleration = y, .lambda_inv = lambda[0], .poses = poses[0]};
    ask(r, w, &q, &reply);
    q = *request;
    q.flags = TFA_WANT_POSES;
    reply = (tfa_reply){
        .qdd = x + base, .base_acceleration = x, .lambda_inv = lambda[1], .poses = poses[1]};
    ask(r, r->f64, &q, &reply);
    memcpy(z, x, base * sizeof *z);
    for (uint32_t k = 0; k < nv; k++)
        z[base + k] = x[base + small.from[k]];
    within(r, "qdd of the scene", z, y, base + nv, BOUND);
    within(r, "lambda_inv of the scene", lambda[1], lambda[0],
           36 * (size_t)q.tip_count * q.tip_count, BOUND);
    within(r, "poses of the scene", poses[1], poses[0], 7 * (size_t)q.tip_count, BOUND);
    tfa_workspace_free(w);
}

/* Trees that carry no tip are left out by scenes once a lock has cut them off, and mimics that are
 * locked stand elsewhere when the scene locks their leader: those are other robots. */
static void same_scene(reduction *r, uint64_t seed)
{
    const bool other =
        r->kinds & REDUCE_TIPS || (r->kinds & REDUCE_MIMICS && r->options.mimic == TFA_MIMIC_LOCK);
    question a;
    struct locked l;
    random_source s = {seed + 1};
    if (other || !question_open(&a, r, seed, 1, 2)) {
        left_out += !other;
        return;
    }
    choose_tips(&a, r, &s);
    choose_locked(r, &s, &l);
    for (uint32_t k = 0; k < l.count; k++) {
        tfa_joint_info info = tfa_model_joint(r->model, l.joints[k]);
        memset(a.v + info.v_index, 0, info.v_count * sizeof *a.v);
    }
    a.r.locked = l.joints;
    a.r.locked_count = l.count;
    tfa_model *model = lock_in_scene(r, &l, a.q);
    if (tfa_model_base_freedoms(model) + tfa_model_v_count(model) > 0)
        compare_scenes(r, model, &a.r);
    tfa_model_free(model);
    question_close(&a);
}

TEST(locked_is_a_scene)
{
    for_seeds(same_scene);
}

/* ---- payloads ---- */

/* Between fused joints nothing can be loaded later: the request says which payload it is. */
static void refuse_inside(const reduction *r, const tfa_request *request)
{
    tfa_request q = *request;
    for (uint32_t k = 0; k < r->model->frames; k++)
        if (r->model->frame[k].part > 0) {
            q.payload_frames[0] = k;
            must_refuse(r, &q, TFA_E_UNSUPPORTED, TFA_FIELD_PAYLOADS);
            return;
        }
}

static void check_loaded(const reduction *r, const question *a, uint32_t k)
{
    static const tfa_method methods[] = {
        TFA_METHOD_AUTO,        TFA_METHOD_ABA,           TFA_METHOD_CRBA,          TFA_METHOD_TFA,
        TFA_METHOD_PROPAGATION, TFA_METHOD_TFA_ONE_SIDED, TFA_METHOD_TFA_CR,        TFA_METHOD_CFA,
        TFA_METHOD_CFA_CR,      TFA_METHOD_SCAN,          TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_DCA,
        TFA_METHOD_HESSENBERG,  TFA_METHOD_EFPA,          TFA_METHOD_PV_OSIMR};
    static double M[MOST * MOST], want[MOST * MOST];
    const uint32_t base = r->n - r->nv;
    tfa_request whole, q = question_state(a, r, k, &whole);
    oracle_tie_freedoms(r->o, r->tie, r->n);
    oracle_set_state(r->o, &whole, 0);
    check_answers(r, a, &q, methods, sizeof methods / sizeof *methods, r->f64);
    check_answers(r, a, &q, methods, sizeof methods / sizeof *methods, r->mixed);
    tfa_reply reply = {.mass_matrix = M};
    q.tip_count = 0;
    q.op = TFA_OP_MASS_MATRIX;
    oracle_mass_matrix(r->o, want);
    ask(r, r->f64, &q, &reply);
    within(r, "M", M, want, (size_t)r->n * r->n, BOUND);
    reply = (tfa_reply){.tau = M + base, .base_wrench = M};
    q.op = TFA_OP_INVERSE_DYNAMICS;
    oracle_inverse(r->o, q.qdd, q.base_acceleration, want + base, want);
    ask(r, r->f64, &q, &reply);
    within(r, "inverse", M, want, r->n, BOUND);
}

static void loaded(reduction *r, uint64_t seed)
{
    double numbers[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    question a;
    random_source s = {seed + 2};
    if (!question_open(&a, r, seed, 2, 2)) {
        left_out++;
        return;
    }
    a.r.frame = a.whole.frame = (tfa_reference_frame)(seed % 3);
    choose_tips(&a, r, &s);
    for (uint32_t turn = 0; turn < 3; turn++) { /* some, others, none */
        question_load(&a, r, &s, turn == 2 ? 0 : 1 + random_below(&s, 2), numbers);
        if (!question_is_good(&a, r))
            continue;
        check_loaded(r, &a, turn % 2);
        if (turn == 0)
            refuse_inside(r, &a.r);
    }
    question_close(&a);
}

TEST(payload_is_mass)
{
    for_seeds(loaded);
}
