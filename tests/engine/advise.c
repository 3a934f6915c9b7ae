/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The adviser's bound against the truth: x by the oracle of the whole robot, y by the model that is
 * compiled with the advised joints locked, and the norm of their difference by the oracle's M. The
 * bound is never below it and hardly above, over random robots, scenes and states.
 */
#include "dynamics/reductions/reductions.h"
#include "model/model.h"
#include "models.h"
#include "test.h"

#include <totalforce/advise.h>

#define SEEDS 200
#define STATES 3
#define MOST 128   /* freedoms */
#define SLACK 1e-9 /* relative: what a bound may have for rounding */

static const double tolerances[] = {0.5, 0.1, 1e-2, 1e-4, 1e-8};
enum { TOLERANCES = sizeof tolerances / sizeof *tolerances };

/* A model and what it was compiled from, with states for it and for the oracle of the whole robot
 */
struct subject {
    const char *name;
    const tfa_description *description;
    const tfa_model_options *options;
    const tfa_model *model;
    oracle *o;
    const oracle_tie *tie; /* NULL: none */
    tfa_request r, whole;
};

static struct {
    unsigned scenes, locked, joints;
    double loosest;
} tally;

/* ---- the scene, compiled ---- */

static tfa_model *compile(const struct subject *s, const tfa_advice *advice, const uint32_t *joints,
                          uint32_t count)
{
    static const tfa_scene whole;
    tfa_model_options options = s->options ? *s->options : (tfa_model_options){0};
    tfa_scene scene = options.scene ? *options.scene : whole;
    tfa_lock *locks = calloc(scene.lock_count + count + 1, sizeof *locks);
    tfa_model *model = NULL;
    assert_non_null(locks);
    for (size_t k = 0; k < scene.lock_count; k++)
        locks[k] = scene.locks[k];
    for (uint32_t k = 0; k < count; k++) {
        const tfa_joint_info joint = tfa_model_joint(s->model, joints[k]);
        locks[scene.lock_count + k].joint = joint.name;
        memcpy(locks[scene.lock_count + k].q, advice->q + joint.q_index,
               joint.q_count * sizeof *advice->q);
    }
    scene.locks = locks;
    scene.lock_count += count;
    options.scene = &scene;
    const int status = tfa_model_create(s->description, &options, NULL, &model);
    if (status != TFA_OK)
        fail_msg("%s: %u joints locked: %s", s->name, (unsigned)count, tfa_status_text(status));
    free(locks);
    return model;
}

/* Copies what the scene has of q, v and tau of state k, or its qdd back. */
static void convert(const struct subject *s, const tfa_model *scene, uint32_t k, double *q,
                    double *v, double *tau, const double *qdd, double *y)
{
    const uint32_t nq = tfa_model_q_count(s->model), nv = tfa_model_v_count(s->model);
    for (uint32_t j = 0; j < tfa_model_joint_count(scene); j++) {
        const tfa_joint_info to = tfa_model_joint(scene, j);
        const int32_t index = tfa_model_find_joint(s->model, to.name);
        assert_true(index >= 0);
        const tfa_joint_info at = tfa_model_joint(s->model, (uint32_t)index);
        memcpy(q + to.q_index, s->r.q + (size_t)nq * k + at.q_index, to.q_count * sizeof *q);
        for (uint32_t i = 0; i < to.v_count; i++) {
            const size_t from = (size_t)nv * k + at.v_index + i;
            v[to.v_index + i] = s->r.v ? s->r.v[from] : 0;
            tau[to.v_index + i] = s->r.tau[from];
            if (qdd)
                y[at.v_index + i] = qdd[to.v_index + i];
        }
    }
}

/* y of state k, 0 for locked joints */
static void answer_scene(const struct subject *s, const tfa_model *scene, uint32_t k, double *y,
                         double *y_base)
{
    double q[2 * MOST], v[MOST], tau[MOST], qdd[MOST];
    tfa_request r = s->r;
    tfa_reply reply = {.qdd = qdd, .base_acceleration = y_base};
    convert(s, scene, k, q, v, tau, NULL, NULL);
    r.count = 1;
    r.q = q;
    r.v = v;
    r.tau = tau;
    r.base_pose = r.base_pose ? r.base_pose + 7 * (size_t)k : NULL;
    r.base_twist = r.base_twist ? r.base_twist + 6 * (size_t)k : NULL;
    r.base_wrench = r.base_wrench ? r.base_wrench + 6 * (size_t)k : NULL;
    r.wrenches = r.wrenches ? r.wrenches + 6 * (size_t)r.wrench_count * k : NULL;
    for (uint32_t i = 0; i < r.wrench_count; i++)
        r.wrench_frames[i] = (uint32_t)tfa_model_find_frame(
            scene, tfa_model_frame(s->model, r.wrench_frames[i]).name);
    tfa_workspace *w = workspace_for(scene, NULL);
    const int status = tfa_compute(w, &r, &reply);
    if (status != TFA_OK)
        fail_msg("%s: the scene: %s (%s %u)", s->name, tfa_status_text(status),
                 tfa_field_name(reply.field), (unsigned)reply.index);
    memset(y, 0, tfa_model_v_count(s->model) * sizeof *y);
    convert(s, scene, k, q, v, tau, qdd, y);
    tfa_workspace_free(w);
}

/* |x - y|_M / |x|_M of state k */
static double truth(const struct subject *s, const tfa_model *scene, uint32_t k)
{
    double x[MOST], x_base[6] = {0}, y[MOST], y_base[6] = {0};
    const size_t nv = tfa_model_v_count(s->model);
    answer_scene(s, scene, k, y, y_base);
    if (s->tie)
        oracle_tie_freedoms(s->o, s->tie, (uint32_t)nv + tfa_model_base_freedoms(s->model));
    oracle_set_state(s->o, &s->whole, k);
    oracle_forward(s->o, s->r.tau + nv * k, s->r.base_wrench ? s->r.base_wrench + 6 * k : NULL, x,
                   x_base);
    return oracle_energy_norm(s->o, x, x_base, y, y_base) /
           oracle_energy_norm(s->o, x, x_base, NULL, NULL);
}

static void check_bound(const struct subject *s, const tfa_advice *advice, const uint32_t *joints,
                        uint32_t count, double bound)
{
    tfa_model *scene = compile(s, advice, joints, count);
    double most = 0;
    for (uint32_t k = 0; k < s->r.count; k++)
        most = fmax(most, truth(s, scene, k));
    if (!(bound >= most * (1 - 1e-12)))
        fail_msg("%s: %u locked: bound %.17g, error %.17g", s->name, (unsigned)count, bound, most);
    if (!(bound <= 1.01 * most + SLACK))
        fail_msg("%s: %u locked: bound %.17g far above %.17g", s->name, (unsigned)count, bound,
                 most);
    if (most > 1e-6)
        tally.loosest = fmax(tally.loosest, bound / most);
    tally.scenes++;
    tfa_model_free(scene);
}

/* ---- advice ---- */

static uint32_t freedoms_of(const struct subject *s, const tfa_advice *advice)
{
    uint32_t sum = 0;
    for (uint32_t k = 0; k < advice->count; k++) {
        assert_true(k == 0 || advice->single_error[advice->joints[k]] >=
                                  advice->single_error[advice->joints[k - 1]]);
        sum += tfa_model_joint(s->model, advice->joints[k]).v_count;
    }
    return sum;
}

static void check_advice(const struct subject *s)
{
    const uint32_t joints = tfa_model_joint_count(s->model);
    const uint32_t keep = tfa_model_base_freedoms(s->model) ? 0 : 1;
    for (int t = 0; t < TOLERANCES; t++) {
        tfa_advice advice;
        tfa_reply reply;
        const int status = tfa_advise(s->model, &s->r, tolerances[t], &advice, &reply);
        if (status != TFA_OK)
            fail_msg("%s: %s (%s)", s->name, tfa_status_text(status), tfa_field_name(reply.field));
        assert_true(advice.count + keep <= joints && advice.error <= tolerances[t]);
        assert_int_equal(freedoms_of(s, &advice), advice.freedoms);
        tally.joints += joints;
        tally.locked += advice.count;
        if (advice.count)
            check_bound(s, &advice, advice.joints, advice.count, advice.error);
        for (uint32_t j = 0; t == 0 && j < joints && joints > keep; j++)
            check_bound(s, &advice, &j, 1, advice.single_error[j]);
        tfa_advice_free(&advice);
    }
}

static void print_tally(unsigned at_least)
{
    print_message("  %u scenes, bounds up to %.4f of the truth; %u joints of %u locked\n",
                  tally.scenes, tally.loosest, tally.locked, tally.joints);
    assert_true(tally.scenes > at_least && 5 * tally.locked > tally.joints);
    memset(&tally, 0, sizeof tally);
}

/* ---- robots of all sorts ---- */

/* Some joints stay in one place, some nearly; neither accelerates much. */
static void settle(question *a, const reduction *r, random_source *s)
{
    for (size_t i = 0; i < r->whole->joint_count; i++) {
        const reduced_joint *j = &r->joint[i];
        const double share = (const double[]){1, 0, 0x1p-10}[random_below(s, 3)];
        if (j->index < 0 || share == 1)
            continue;
        const tfa_joint_info at = tfa_model_joint(r->model, (uint32_t)j->index);
        for (uint32_t k = 0; k < STATES; k++) {
            double *q = a->q + (size_t)k * r->nq + at.q_index;
            double *v = a->v + (size_t)k * r->nv + at.v_index;
            const double move = j->q_count == 1 ? share * k : 0;
            memcpy(q, a->q + at.q_index, j->q_count * sizeof *q);
            q[0] += move;
            memcpy(a->x->q + (size_t)k * r->whole_nq + j->q, q, j->q_count * sizeof *q);
            for (uint32_t e = 0; e < j->v_count; e++) {
                v[e] *= share;
                a->qdd[(size_t)k * r->nv + at.v_index + e] *= 0x1p-10;
            }
            memcpy(a->x->v + (size_t)k * r->whole_nv + j->v, v, j->v_count * sizeof *v);
        }
    }
}

/* What follows others, in all states */
static void follow(question *a, const reduction *r)
{
    for (size_t i = 0; i < r->whole->joint_count; i++) {
        const reduced_joint *j = &r->joint[i];
        if (j->leader < 0 || j->locked)
            continue;
        const reduced_joint *leader = &r->joint[j->leader];
        for (uint32_t k = 0; k < STATES; k++) {
            double *q = a->x->q + (size_t)k * r->whole_nq, *v = a->x->v + (size_t)k * r->whole_nv;
            q[j->q] = j->multiplier * q[leader->q] + j->offset;
            v[j->v] = j->multiplier * v[leader->v];
        }
    }
}

/* The torques that give qdd */
static void push(question *a, const reduction *r)
{
    tfa_request inverse = a->r;
    tfa_reply reply = {.tau = a->tau, .base_wrench = a->x->base_wrench};
    inverse.op = TFA_OP_INVERSE_DYNAMICS;
    assert_int_equal(tfa_compute(r->f64, &inverse, &reply), TFA_OK);
}

static void advise_reduced(uint64_t seed, tfa_base base)
{
    reduction r;
    question a;
    random_source source = {seed};
    reduction_open(&r, seed, REDUCE_ANYTHING & ~(REDUCE_PAYLOADS | REDUCE_TIPS), base);
    const bool moves = r.options.mimic != TFA_MIMIC_LOCK; /* a lock moves what follows then */
    if (r.nv > 0 && moves && question_open(&a, &r, seed, STATES, 2)) {
        settle(&a, &r, &source);
        follow(&a, &r);
        push(&a, &r);
        const struct subject s = {r.name, r.file, &r.options, r.model, r.o, r.tie, a.r, a.whole};
        tfa_advice advice;
        tfa_reply reply;
        if (r.model->massless_followers)
            assert_int_equal(tfa_advise(r.model, &a.r, 0.1, &advice, &reply), TFA_E_UNSUPPORTED);
        else if (question_is_good(&a, &r))
            check_advice(&s);
        question_close(&a);
    }
    reduction_close(&r);
}

TEST(reduced_robots)
{
    for (uint64_t seed = 3001; seed <= 3000 + SEEDS; seed++)
        for (int base = 0; base < 2; base++)
            advise_reduced(seed, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    print_tally(5 * SEEDS);
}

/* ---- long chains ---- */

/* Links that are alike, in the plane or not */
static void make_chain(tfa_description *d, uint64_t seed, bool planar)
{
    for (size_t k = 0; k < d->link_count; k++) {
        d->links[k].mass = 1;
        memset(d->links[k].com, 0, sizeof d->links[k].com);
        d->links[k].com[0] = 0.5;
        for (int i = 0; i < 6; i++)
            d->links[k].inertia[i] = i == 0 ? 0.005 : i == 3 || i == 5 ? 0.086 : 0;
        memcpy(d->links[k].quat, (const double[4]){0, 0, 0, 1}, sizeof d->links[k].quat);
    }
    for (size_t k = 0; k < d->joint_count; k++) {
        tfa_joint *j = &d->joints[k];
        const bool z = planar || (k + seed) % 2 == 0;
        memcpy(j->xyz, (const double[3]){k > 0, 0, 0}, sizeof j->xyz);
        memcpy(j->quat, (const double[4]){0, 0, 0, 1}, sizeof j->quat);
        memcpy(j->axis, (const double[3]){0, !z, z}, sizeof j->axis);
        j->armature = 0;
    }
}

/* A chain at rest, pushed at one joint: joints far from it do not move. */
static void advise_chain(uint64_t seed, uint32_t joints, bool planar)
{
    const random_robot_options options = {.shape = RANDOM_CHAIN, .joints = joints};
    static const double weightless[3];
    tfa_description *d = random_robot_create(seed, &options);
    make_chain(d, seed, planar);
    oracle *o = oracle_create(d, TFA_BASE_FIXED);
    random_states *x = random_states_create(seed, d, o, 1, 0);
    char name[80];
    snprintf(name, sizeof name, "chain of %u, seed %u", (unsigned)joints, (unsigned)seed);
    tfa_model *model = compiled(d, NULL);
    for (uint32_t k = 0; k < joints; k++)
        x->tau[k] = k == joints / 3 ? x->tau[k] : 0;
    const tfa_request q = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = 1,
                           .q = x->q,
                           .tau = x->tau,
                           .gravity = weightless};
    check_advice(&(struct subject){name, d, NULL, model, o, NULL, q, q});
    tfa_model_free(model);
    random_states_free(x);
    oracle_free(o);
    random_robot_free(d);
}

TEST(chains)
{
    for (uint64_t seed = 1; seed <= 12; seed++)
        advise_chain(seed, 8 + 4 * (uint32_t)(seed % 6), seed % 2 == 0);
    print_tally(50);
}

/* ---- what is refused ---- */

TEST(bad_requests)
{
    reduction r;
    question a;
    tfa_advice advice;
    tfa_reply reply;
    reduction_open(&r, 3001, REDUCE_FIXED, TFA_BASE_FIXED);
    assert_true(question_open(&a, &r, 3001, 2, 0));
    assert_int_equal(tfa_advise(r.model, &a.r, 0, &advice, &reply), TFA_E_ARGUMENT);
    assert_int_equal(tfa_advise(r.model, &a.r, NAN, &advice, &reply), TFA_E_ARGUMENT);
    assert_int_equal(tfa_advise(r.model, NULL, 1, &advice, &reply), TFA_E_ARGUMENT);
    a.q[r.nq] = NAN;
    assert_int_equal(tfa_advise(r.model, &a.r, 1, &advice, &reply), TFA_E_VALUE);
    assert_int_equal(reply.field, TFA_FIELD_Q);
    assert_int_equal(reply.state, 1);
    assert_null(advice.joints);
    question_close(&a);
    reduction_close(&r);
}
