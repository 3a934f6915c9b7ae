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
#define SEEDS test_extent(30, 100)
#define MOST REDUCTION_MOST
#define ROWS (6 * REDUCTION_TIPS)

static const reduction_bounds bounds = {BOUND, BOUND, BOUND, 2e-11};
static unsigned left_out, loaded_too;

static void must_refuse(const reduction *r, const tfa_request *q, int status, tfa_field field)
{
    tfa_reply reply = {0};
    assert_int_equal(tfa_compute(r->f64, q, &reply), status);
    assert_int_equal(reply.status, status);
    assert_int_equal(reply.field, field);
}

static void for_seeds(void (*law)(reduction *r, uint64_t seed))
{
    left_out = 0;
    reduction_for_seeds(2001, 2000 + SEEDS, law);
    reduction_print();
    print_message("  robots left out %u\n", left_out);
    assert_true(left_out < SEEDS / 2);
}

static void choose_tips(question *a, const reduction *r, random_source *s)
{
    question_tips(a, r, random_below(s, (uint32_t)r->whole->link_count), REDUCTION_TIPS);
    if (a->r.tip_count == 0)
        question_tips(a, r, 0, REDUCTION_TIPS);
}

/* Everything, of state k of the question and freedoms tied like this */
static void check_answers(reduction *r, const tfa_request *one, const tfa_request *whole,
                          const oracle_tie *tie)
{
    reduction_check_forward(r, one, whole, tie, &bounds);
    reduction_check_lambda(r, one, whole, tie, &bounds, 3);
    reduction_check_inverse(r, one, whole, &bounds);
}

/* ---- locked ---- */

struct locked {
    uint32_t joints[MOST], count;
    oracle_tie tie[MOST];
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

static void check_refusals(const reduction *r, const tfa_request *request)
{
    tfa_request q = *request;
    q.op = TFA_OP_MASS_MATRIX;
    must_refuse(r, &q, TFA_E_UNSUPPORTED, TFA_FIELD_LOCKED);
    const uint32_t nobody = tfa_model_joint_count(r->model);
    q.op = TFA_OP_FORWARD_DYNAMICS;
    q.locked = &nobody;
    q.locked_count = 1;
    must_refuse(r, &q, TFA_E_JOINT, TFA_FIELD_LOCKED);
}

static void locked(reduction *r, uint64_t seed)
{
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
        check_answers(r, &one, &whole, l.tie);
        if (l.count)
            check_refusals(r, &one);
        one.locked_count = 0; /* and let go of again */
        check_answers(r, &one, &whole, r->tie);
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
    double poses[2][7 * REDUCTION_TIPS], x[MOST], y[MOST], z[MOST];
    const uint32_t base = r->n - r->nv, nv = tfa_model_v_count(model);
    struct smaller small;
    tfa_request q;
    tfa_workspace *w = workspace_for(model, NULL);
    translate(r, model, request, &small, &q);
    q.flags = TFA_WANT_POSES;
    tfa_reply reply = {
        .qdd = y + base, .base_acceleration = y, .lambda_inv = lambda[0], .poses = poses[0]};
    (void)reduction_ask(r, w, &q, &reply);
    q = *request;
    q.flags = TFA_WANT_POSES;
    reply = (tfa_reply){
        .qdd = x + base, .base_acceleration = x, .lambda_inv = lambda[1], .poses = poses[1]};
    (void)reduction_ask(r, r->f64, &q, &reply);
    memcpy(z, x, base * sizeof *z);
    for (uint32_t k = 0; k < nv; k++)
        z[base + k] = x[base + small.from[k]];
    reduction_within(r, "qdd of the scene", z, y, base + nv, BOUND);
    reduction_within(r, "lambda_inv of the scene", lambda[1], lambda[0],
                     36 * (size_t)q.tip_count * q.tip_count, BOUND);
    reduction_within(r, "poses of the scene", poses[1], poses[0], 7 * (size_t)q.tip_count, BOUND);
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

static void refuse_infinite(const reduction *r, const tfa_request *request)
{
    double numbers[TFA_PAYLOAD_NUMBERS];
    tfa_request q = *request;
    q.payloads = numbers;
    q.payload_count = 1;
    for (int k = 0; k < TFA_PAYLOAD_NUMBERS; k++) {
        memcpy(numbers, request->payloads, sizeof numbers);
        numbers[k] = k % 2 ? NAN : INFINITY;
        must_refuse(r, &q, TFA_E_VALUE, TFA_FIELD_PAYLOADS);
    }
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
        tfa_request whole, one = question_state(&a, r, turn % 2, &whole);
        check_answers(r, &one, &whole, r->tie);
        if (turn == 0) {
            refuse_inside(r, &a.r);
            refuse_infinite(r, &a.r);
        }
    }
    question_close(&a);
}

TEST(payload_is_mass)
{
    for_seeds(loaded);
}
