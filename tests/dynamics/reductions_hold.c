/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Held joints: the answer is that of the robot with these joints fixed, and what is said of its
 * error is the truth, never less and hardly more. The truth is the oracle's: sqrt((x - y)^T M
 * (x - y)) with x its own exact answer and y the library's.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reductions.h"

#define SEEDS 100
#define MOST 128 /* freedoms */

/* What a certificate allows for the rounding of the answer, in |x|_M + |M^-1 tau|_M: of that no 1 %
 * can be asked. 64 eps for each of at most 100 bodies. */
#define ROUNDING 1.5e-12

/* A robot with one request, the library's and the oracle's, on which joints are held. */
struct subject {
    const char *name;
    oracle *o;
    const tfa_model *model;
    tfa_workspace *w;
    const oracle_tie *tie;
    uint32_t n, base, whole_n; /* freedoms: of the model, of its base, of the oracle */
    tfa_request r, whole;
};

static unsigned certified, held_joints, all_joints;
static double loosest;

/* x: with every joint free, but those that the request locks. */
static void exact(const struct subject *s, const oracle_tie *tie, double *x)
{
    oracle_tie_freedoms(s->o, tie, s->n);
    oracle_set_state(s->o, &s->whole, 0);
    oracle_forward(s->o, s->r.tau, s->r.base_wrench, x + s->base, x);
}

/* `tie` with these public joints still. */
static void stop(const struct subject *s, const oracle_tie *tie, const uint32_t *joints,
                 uint32_t count, oracle_tie *out)
{
    uint8_t still[MOST] = {0};
    for (uint32_t k = 0; k < count; k++) {
        tfa_joint_info info = tfa_model_joint(s->model, joints[k]);
        for (uint32_t i = 0; i < info.v_count; i++)
            still[s->base + info.v_index + i] = 1;
    }
    for (uint32_t k = 0; k < s->whole_n; k++) {
        out[k] = tie[k];
        if (tie[k].to != ORACLE_STILL && still[tie[k].to])
            out[k].to = ORACLE_STILL;
    }
}

struct held_answer {
    double y[MOST];
    uint8_t held[MOST];
    tfa_certificate c;
    tfa_answer answer;
};

static void ask(const struct subject *s, const tfa_request *q, struct held_answer *a)
{
    memset(a, 0, sizeof *a);
    a->c.held = UINT32_MAX;
    tfa_reply reply = {.qdd = a->y + s->base,
                       .base_acceleration = a->y,
                       .held = a->held,
                       .certificate = &a->c,
                       .answers = &a->answer};
    int status = tfa_compute(s->w, q, &reply);
    if (status != TFA_OK)
        fail_msg("%s: %s (%s)", s->name, tfa_status_text(status), tfa_field_name(reply.field));
}

/* Nothing is held silently: flags, counts and marks say what was. */
static uint32_t check_marks(const struct subject *s, const struct held_answer *a)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < tfa_model_joint_count(s->model); k++) {
        tfa_joint_info info = tfa_model_joint(s->model, k);
        const uint8_t *held = a->held + info.v_index;
        assert_true(held[0] <= 1);
        count += held[0];
        for (uint32_t i = 0; i < info.v_count; i++) {
            assert_int_equal(held[i], held[0]);
            assert_true(!held[i] || a->y[s->base + info.v_index + i] == 0);
        }
    }
    assert_int_equal(a->c.held, count);
    assert_int_equal((a->answer.flags & TFA_ANSWER_HELD) != 0, count > 0);
    return count;
}

/* |M^-1 tau|_M: what the forces of the joints do to the robot at rest without gravity */
static double force_norm(const struct subject *s)
{
    static const double weightless[3];
    double x[MOST];
    tfa_request q = s->r;
    q.v = q.base_twist = NULL;
    q.gravity = weightless;
    q.wrench_count = 0;
    tfa_reply reply = {.qdd = x + s->base, .base_acceleration = x};
    assert_int_equal(tfa_compute(s->w, &q, &reply), TFA_OK);
    return oracle_energy_norm(s->o, x + s->base, x, NULL, NULL);
}

/* The certificate against the truth; `tie` is the robot with nothing held. */
static void check_certificate(const struct subject *s, const oracle_tie *tie,
                              const struct held_answer *a)
{
    double x[MOST];
    const uint32_t b = s->base;
    exact(s, tie, x);
    const double size = oracle_energy_norm(s->o, x + b, x, NULL, NULL);
    const double truth = oracle_energy_norm(s->o, x + b, x, a->y + b, a->y);
    const double most = 1.01 * truth + ROUNDING * (size + force_norm(s));
    assert_int_equal(a->c.exact, 1);
    if (!(a->c.error >= truth && a->c.relative >= truth / size * (1 - 1e-12)))
        fail_msg("%s: %u held: certificate %.17g (relative %.17g), truth %.17g (%.17g)", s->name,
                 (unsigned)a->c.held, a->c.error, a->c.relative, truth, truth / size);
    if (!(a->c.error <= most && a->c.relative <= most / size))
        fail_msg("%s: %u held: certificate %.17g (relative %.17g) above truth %.17g (%.17g)",
                 s->name, (unsigned)a->c.held, a->c.error, a->c.relative, truth, truth / size);
    if (truth > 1e-11 * size)
        loosest = fmax(loosest, a->c.error / truth);
    certified++;
}

static uint32_t choose(const struct subject *s, random_source *source, uint32_t one_in,
                       uint32_t *joints)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < tfa_model_joint_count(s->model); k++)
        if (random_below(source, one_in) == 0)
            joints[count++] = k;
    return count;
}

/* ---- the joints of a list ---- */

static void given(const struct subject *s, random_source *source, const oracle_tie *tie,
                  const uint32_t *locked, uint32_t locked_count, double bound)
{
    uint32_t joints[MOST];
    double want[MOST];
    oracle_tie stopped[MOST];
    struct held_answer a;
    tfa_request q = s->r;
    q.locked = locked;
    q.locked_count = locked_count;
    q.held = joints;
    q.held_count = choose(s, source, 3, joints);
    ask(s, &q, &a); /* a list alone holds nothing */
    assert_int_equal(a.answer.flags & TFA_ANSWER_HELD, 0);
    exact(s, tie, want);
    assert_true(relative_difference(a.y, want, s->n) <= bound);
    q.hold = TFA_HOLD_GIVEN;
    ask(s, &q, &a);
    assert_true(isnan(a.c.error) && isnan(a.c.relative) && a.c.exact == 0);
    q.flags = TFA_WANT_CERTIFICATE;
    ask(s, &q, &a);
    stop(s, tie, joints, q.held_count, stopped);
    exact(s, stopped, want);
    double error = relative_difference(a.y, want, s->n);
    if (!(error <= bound))
        fail_msg("%s: qdd with %u joints held: error %g", s->name, (unsigned)q.held_count, error);
    held_joints += check_marks(s, &a);
    for (uint32_t k = 0; k < q.held_count; k++)
        assert_int_equal(a.held[tfa_model_joint(s->model, joints[k]).v_index], 1);
    check_certificate(s, tie, &a);
    all_joints += tfa_model_joint_count(s->model);
}

/* ---- as many joints as the tolerance allows ---- */

static void automatic(const struct subject *s, const oracle_tie *tie, const uint32_t *locked,
                      uint32_t locked_count)
{
    static const double tolerances[] = {0.5, 0.1, 1e-2, 1e-4, 1e-8, 1e-16};
    struct held_answer a, exact_answer;
    tfa_request q = s->r;
    q.locked = locked;
    q.locked_count = locked_count;
    ask(s, &q, &exact_answer);
    q.hold = TFA_HOLD_AUTO;
    for (size_t t = 0; t < sizeof tolerances / sizeof *tolerances; t++) {
        q.tolerance = tolerances[t];
        ask(s, &q, &a);
        uint32_t count = check_marks(s, &a);
        if (count == 0) {
            assert_memory_equal(a.y, exact_answer.y, s->n * sizeof *a.y);
            continue;
        }
        check_certificate(s, tie, &a); /* so the truth is below what is compared here */
        assert_true(a.c.relative <= q.tolerance);
        held_joints += count;
        all_joints += tfa_model_joint_count(s->model);
    }
}

/* ---- robots of all sorts ---- */

static void print_tally(unsigned at_least)
{
    print_message("  %u certificates, up to %.4f of the truth; %u joints of %u held\n", certified,
                  loosest, held_joints, all_joints);
    assert_true(certified > at_least && held_joints > certified);
    certified = held_joints = all_joints = 0;
    loosest = 0;
}

/* Joints that follow others cannot be held: refused by name. */
static void refuse(const struct subject *s)
{
    double y[MOST];
    tfa_request q = s->r;
    tfa_reply reply = {.qdd = y};
    q.hold = TFA_HOLD_GIVEN;
    assert_int_equal(tfa_compute(s->w, &q, &reply), TFA_E_UNSUPPORTED);
    assert_int_equal(reply.field, TFA_FIELD_HELD);
}

static void hold_reduced(uint64_t seed, tfa_base base)
{
    reduction r;
    question a;
    random_source source = {seed};
    uint32_t locked[MOST];
    oracle_tie tie[MOST];
    reduction_open(&r, seed, REDUCE_ANYTHING, base);
    if (r.n > 0 && question_open(&a, &r, seed, 1, 2)) {
        struct subject s = {r.name, r.o,    r.model,    r.f64,
                            r.tie,  r.n,    r.n - r.nv, oracle_freedoms(r.o),
                            a.r,    a.whole};
        if (tfa_model_summarise(r.model).mimics) {
            refuse(&s);
        } else {
            given(&s, &source, r.tie, NULL, 0, 1e-13);
            automatic(&s, r.tie, NULL, 0);
            uint32_t count = choose(&s, &source, 4, locked);
            stop(&s, r.tie, locked, count, tie);
            if (base == TFA_BASE_FLOATING || count < tfa_model_joint_count(r.model)) {
                given(&s, &source, tie, locked, count, 1e-13);
                automatic(&s, tie, locked, count);
            }
        }
        question_close(&a);
    }
    reduction_close(&r);
}

static void reduced_robots(void **state)
{
    (void)state;
    for (uint64_t seed = 3001; seed <= 3000 + SEEDS; seed++)
        for (int base = 0; base < 2; base++)
            hold_reduced(seed, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    print_tally(2 * SEEDS);
}

/* ---- long chains ---- */

/* Chains of links that are alike, in the plane or not, pushed at one joint or at all. Their M is
 * badly conditioned: it is the certificate that is tested, and y against its equations to 1e-9. */
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

static void hold_chain(uint64_t seed, uint32_t joints, bool planar, bool local)
{
    const random_robot_options options = {.shape = RANDOM_CHAIN, .joints = joints};
    const double still[3] = {0, 0, 0};
    tfa_description *d = random_robot_create(seed, &options);
    make_chain(d, seed, planar);
    oracle *o = oracle_create(d, TFA_BASE_FIXED);
    random_states *x = random_states_create(seed, d, o, 1, 0);
    random_source source = {seed};
    tfa_model *model = NULL;
    tfa_workspace *w = NULL;
    oracle_tie tie[MOST];
    char name[80];
    snprintf(name, sizeof name, "chain of %u, seed %u%s%s", (unsigned)joints, (unsigned)seed,
             planar ? ", planar" : "", local ? ", pushed at one joint" : "");
    assert_int_equal(tfa_model_create(d, NULL, NULL, &model), TFA_OK);
    assert_int_equal(tfa_workspace_create(model, NULL, &w), TFA_OK);
    for (uint32_t k = 0; k < joints; k++) {
        tie[k] = (oracle_tie){k, 1};
        if (local && k != joints / 3)
            x->tau[k] = 0;
    }
    tfa_request q = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .q = x->q,
                     .v = local ? NULL : x->v,
                     .tau = x->tau,
                     .gravity = local ? still : x->gravity};
    struct subject s = {name, o, model, w, tie, joints, 0, joints, q, q};
    given(&s, &source, tie, NULL, 0, 1e-9);
    automatic(&s, tie, NULL, 0);
    tfa_workspace_free(w);
    tfa_model_free(model);
    random_states_free(x);
    oracle_free(o);
    random_robot_free(d);
}

static void chains(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 24; seed++)
        hold_chain(seed, 8 + 4 * (uint32_t)(seed % 12), seed % 2 == 0, seed % 4 < 2);
    print_tally(72);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reduced_robots),
        cmocka_unit_test(chains),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
