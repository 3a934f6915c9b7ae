/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exact reductions change nothing: hundreds of random robots, each reduced in one way or in
 * several, give the answers of the robot with nothing reduced to 1e-13.
 */
#include "model/model.h"
#include "reductions.h"
#include "test.h"

#define BOUND 1e-13
/* Lambda^-1 of TFA one-sided is not refined. */
#define TFA_LAMBDA 2e-11
#define STATES 2
#define WRENCHES 2
#define SEEDS_ALONE 12                      /* for each kind of reduction, on each base */
#define SEEDS_TOGETHER test_extent(60, 250) /* with several, on each base */
#define LAMBDA_MOST 48                      /* rows of Lambda^-1 of eight tips */

/* Room for all answers of one state. */
struct answer {
    double *x, *M; /* base first, then joints; n + 6 and n x n */
    double lambda[LAMBDA_MOST * LAMBDA_MOST], poses[TFA_MAX_TIPS * 7];
};

static struct answer answer_make(const reduction *r)
{
    struct answer a = {.x = calloc(r->n + 7, sizeof *a.x),
                       .M = calloc((size_t)r->n * r->n + 1, sizeof *a.M)};
    assert_true(a.x && a.M);
    return a;
}

static void answer_free(struct answer *a)
{
    free(a->M);
    free(a->x);
}

/* What was compared, the worst of it, and how often. */
static struct {
    const char *what;
    double worst;
    unsigned count, refused, fell_back;
} tally[96];
static unsigned skipped, robots, fused_joints, inner_frames;

static size_t find_tally(const char *what)
{
    size_t k = 0;
    while (tally[k].what && strcmp(tally[k].what, what) != 0)
        k++;
    assert_true(k + 1 < sizeof tally / sizeof *tally);
    tally[k].what = what;
    return k;
}

static void count(const reduction *r, const char *what, double error, double bound)
{
    const size_t k = find_tally(what);
    tally[k].count += error >= 0;
    tally[k].refused += error < 0;
    tally[k].worst = fmax(tally[k].worst, error);
    if (!(error <= bound))
        fail_msg("%s: %s: error %.3g, bound %g", r->name, what, error, bound);
}

/* ---- structure, mass ---- */

static void check_fate(const reduction *r, const tfa_declared_joint *d)
{
    size_t k = 0;
    while (k < r->whole->joint_count && strcmp(r->whole->joints[k].name, d->name) != 0)
        k++;
    const reduced_joint *j = &r->joint[k];
    if (k == r->whole->joint_count || j->absent) {
        assert_int_equal(d->fate, TFA_FATE_ABSENT);
        return;
    }
    assert_int_equal(d->joint, j->index);
    if (r->whole->joints[k].type == TFA_JOINT_FIXED)
        assert_int_equal(d->fate, TFA_FATE_FIXED);
    else if (j->locked)
        assert_int_equal(d->fate, TFA_FATE_LOCKED);
    else if (j->leader >= 0) {
        assert_true(d->fate == TFA_FATE_FOLLOWS || d->fate == TFA_FATE_FUSED);
        assert_int_equal(d->leader, r->joint[j->leader].index);
        assert_true(d->multiplier == j->multiplier && d->offset == j->offset);
    } else
        assert_true(d->fate == TFA_FATE_MOVES || d->fate == TFA_FATE_FUSED);
}

static void check_structure(const reduction *r)
{
    const uint32_t base = r->n - r->nv;
    uint32_t own = 0;
    assert_int_equal(tfa_model_v_count(r->model), r->nv);
    assert_int_equal(tfa_model_q_count(r->model), r->nq);
    assert_int_equal(tfa_model_base_freedoms(r->model), base);
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        if (j->index < 0)
            continue;
        tfa_joint_info info = tfa_model_joint(r->model, (uint32_t)j->index);
        assert_string_equal(info.name, r->whole->joints[k].name);
        assert_int_equal(info.type, r->whole->joints[k].type);
        assert_int_equal(base + info.v_index, r->tie[base + j->v].to);
        assert_true(info.armature == r->whole->joints[k].armature);
        own++;
    }
    assert_int_equal(tfa_model_joint_count(r->model), own);
    assert_int_equal(tfa_model_declared_count(r->model), r->file->joint_count);
    for (uint32_t k = 0; k < r->file->joint_count; k++) {
        tfa_declared_joint d = tfa_model_declared(r->model, k);
        check_fate(r, &d);
    }
    fused_joints += tfa_model_summarise(r->model).fused;
    for (uint32_t k = 0; k < r->model->frames; k++)
        inner_frames += r->model->frame[k].part > 0;
}

/* All coordinates 0 but those of joints that are locked or follow; absent links without mass. */
static void check_mass(const reduction *r, question *a)
{
    const size_t links = r->whole->link_count;
    double mass, com[3], pose[7] = {0, 0, 0, 0, 0, 0, 1}, *q = calloc(r->whole_nq + 1, sizeof *q);
    double *masses = calloc(links, sizeof *masses);
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        if (j->locked)
            memcpy(q + j->q, j->at, j->q_count * sizeof *q);
        else if (j->q_count == 7)
            q[j->q + 6] = 1;
        else if (j->leader >= 0)
            q[j->q] = j->offset;
    }
    for (size_t k = 0; k < links; k++) {
        masses[k] = r->whole->links[k].mass;
        if (tfa_model_find_frame(r->model, r->whole->links[k].name) < 0)
            r->whole->links[k].mass = 0;
    }
    tfa_request at = a->whole;
    at.q = q;
    at.base_pose = pose;
    at.wrench_count = 0;
    oracle_set_state(r->o, &at, 0);
    oracle_mass(r->o, &mass, com);
    for (size_t k = 0; k < links; k++)
        r->whole->links[k].mass = masses[k];
    tfa_model_summary s = tfa_model_summarise(r->model);
    count(r, "total mass", fabs(s.total_mass - mass) / mass, BOUND);
    count(r, "centre of mass", relative_difference(s.com, com, 3), BOUND);
    free(masses);
    free(q);
}

/* ---- answers ---- */

static tfa_reply reply_into(const reduction *r, struct answer *a)
{
    return (tfa_reply){.qdd = a->x + (r->n - r->nv),
                       .base_acceleration = a->x,
                       .tau = a->x + (r->n - r->nv),
                       .base_wrench = a->x,
                       .mass_matrix = a->M,
                       .lambda_inv = a->lambda,
                       .poses = a->poses};
}

static void check_forward(const reduction *r, const tfa_request *request, struct answer *want,
                          struct answer *got)
{
#define WAYS(name)                                                                                 \
    {                                                                                              \
        name, name ", f128", name ", f32+f64"                                                      \
    }
    static const struct {
        tfa_method method;
        const char *name[3];
    } methods[] = {{TFA_METHOD_AUTO, WAYS("forward, auto")},
                   {TFA_METHOD_ABA, WAYS("forward, aba")},
                   {TFA_METHOD_CRBA, WAYS("forward, crba")},
                   {TFA_METHOD_TFA, WAYS("forward, tfa")},
                   {TFA_METHOD_TFA_CR, WAYS("forward, tfa-cr")},
                   {TFA_METHOD_CFA, WAYS("forward, cfa")},
                   {TFA_METHOD_CFA_CR, WAYS("forward, cfa-cr")},
                   {TFA_METHOD_SCAN, WAYS("forward, scan")},
                   {TFA_METHOD_SCAN_TWO_PASS, WAYS("forward, scan-two-pass")},
                   {TFA_METHOD_DCA, WAYS("forward, dca")},
                   {TFA_METHOD_HESSENBERG, WAYS("forward, hessenberg")}};
#undef WAYS
    tfa_workspace *const workspaces[] = {r->f64, r->f128, r->mixed};
    tfa_request q = *request;
    const uint32_t base = r->n - r->nv;
    oracle_forward(r->o, q.tau, q.base_wrench, want->x + base, want->x);
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (int w = 0; w < 3; w++) {
            const char *name = methods[m].name[w];
            tfa_answer how = {0};
            tfa_reply reply = reply_into(r, got);
            reply.answers = &how;
            q.method = methods[m].method;
            q.refine = w == 2 ? TFA_REFINE_DEFAULT : request->refine;
            bool answered = reduction_ask(r, workspaces[w], &q, &reply);
            count(r, name, answered ? relative_difference(got->x, want->x, r->n) : -1, BOUND);
            tally[find_tally(name)].fell_back += answered && how.flags & TFA_ANSWER_FALLBACK;
        }
}

/* Inverse dynamics with everything, and gravity alone: the first moments of all masses. */
static void check_inverse(const reduction *r, const tfa_request *request, const tfa_request *whole,
                          struct answer *want, struct answer *got)
{
    tfa_request q = *request, w = *whole;
    const uint32_t base = r->n - r->nv;
    tfa_reply reply = reply_into(r, got);
    q.op = TFA_OP_INVERSE_DYNAMICS;
    oracle_inverse(r->o, q.qdd, q.base_acceleration, want->x + base, want->x);
    for (int wide = 0; wide < 2; wide++) {
        reduction_ask(r, wide ? r->f128 : r->f64, &q, &reply);
        count(r, wide ? "inverse, f128" : "inverse", relative_difference(got->x, want->x, r->n),
              BOUND);
    }
    q.v = q.qdd = q.base_twist = q.base_acceleration = NULL;
    w.v = w.base_twist = NULL;
    q.wrench_count = w.wrench_count = 0;
    for (int axis = 0; axis < 3; axis++) {
        double g[3] = {0, 0, 0};
        g[axis] = 9.81;
        q.gravity = w.gravity = g;
        oracle_set_state(r->o, &w, 0);
        oracle_inverse(r->o, NULL, NULL, want->x + base, want->x);
        reduction_ask(r, r->f64, &q, &reply);
        count(r, "gravity torque", relative_difference(got->x, want->x, r->n), BOUND);
    }
    oracle_set_state(r->o, whole, 0);
}

static void check_mass_matrix(const reduction *r, const tfa_request *request, struct answer *want,
                              struct answer *got)
{
    tfa_request q = *request;
    tfa_reply reply = reply_into(r, got);
    q.op = TFA_OP_MASS_MATRIX;
    oracle_mass_matrix(r->o, want->M);
    for (int wide = 0; wide < 2; wide++) {
        reduction_ask(r, wide ? r->f128 : r->f64, &q, &reply);
        count(r, wide ? "mass matrix, f128" : "mass matrix",
              relative_difference(got->M, want->M, (size_t)r->n * r->n), BOUND);
    }
}

static void check_poses(const reduction *r, const question *a, const struct answer *got)
{
    for (uint32_t t = 0; t < a->r.tip_count; t++) {
        double p[3], R[9], T[9];
        const double *x = got->poses + 7 * t, *o = x + 3;
        oracle_pose(r->o, a->whole.tips[t], p, R);
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                int n = (i + 1) % 3, m = (i + 2) % 3;
                double turn = k == n ? -o[3] : o[3];
                T[3 * i + k] = i == k ? 1 - 2 * (o[n] * o[n] + o[m] * o[m])
                                      : 2 * (o[i] * o[k] + turn * o[3 - i - k]);
            }
        double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), off = 0;
        for (int i = 0; i < 3; i++)
            off = hypot(off, x[i] - p[i]);
        assert_true(o[3] >= 0);
        count(r, "pose, quaternion's norm",
              fabs(o[0] * o[0] + o[1] * o[1] + o[2] * o[2] + o[3] * o[3] - 1), BOUND);
        count(r, "pose, position", off / fmax(length, 0.1), BOUND);
        count(r, "pose, rotation", relative_difference(T, R, 9), BOUND);
    }
}

/* Every link is a tip once, in groups, in all three frames, by every method, with its pose. */
static void check_lambda(const reduction *r, const question *a, const tfa_request *request,
                         struct answer *want, struct answer *got)
{
    static const struct {
        tfa_method method;
        const char *name;
    } methods[] = {{TFA_METHOD_AUTO, "lambda_inv, auto"},
                   {TFA_METHOD_ABA, "lambda_inv, aba"},
                   {TFA_METHOD_CRBA, "lambda_inv, crba"},
                   {TFA_METHOD_TFA, "lambda_inv, tfa"},
                   {TFA_METHOD_TFA_ONE_SIDED, "lambda_inv, tfa-one-sided"},
                   {TFA_METHOD_TFA_CR, "lambda_inv, tfa-cr"},
                   {TFA_METHOD_CFA, "lambda_inv, cfa"},
                   {TFA_METHOD_CFA_CR, "lambda_inv, cfa-cr"},
                   {TFA_METHOD_SCAN, "lambda_inv, scan"},
                   {TFA_METHOD_SCAN_TWO_PASS, "lambda_inv, scan-two-pass"},
                   {TFA_METHOD_DCA, "lambda_inv, dca"},
                   {TFA_METHOD_HESSENBERG, "lambda_inv, hessenberg"},
                   {TFA_METHOD_EFPA, "lambda_inv, efpa"},
                   {TFA_METHOD_PV_OSIMR, "lambda_inv, pv-osimr"},
                   {TFA_METHOD_PROPAGATION, "lambda_inv, propagation"}};
    question tips = *a;
    uint32_t link = 0;
    do {
        link = question_tips(&tips, r, link, 3);
        tfa_request q = *request;
        const uint32_t rows = 6 * tips.r.tip_count;
        q.op = TFA_OP_OPERATIONAL_INERTIA;
        q.flags = TFA_WANT_POSES;
        q.tip_count = tips.r.tip_count;
        memcpy(q.tips, tips.r.tips, sizeof q.tips);
        if (rows == 0)
            break;
        for (int frame = 0; frame < 3; frame++) {
            q.frame = (tfa_reference_frame)frame;
            oracle_lambda_inv(r->o, tips.whole.tips, tips.whole.tip_count, q.frame, want->lambda);
            for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
                tfa_reply reply = reply_into(r, got);
                q.method = methods[m].method;
                bool answered = reduction_ask(r, r->f64, &q, &reply);
                bool tfa = reduction_may_refuse(q.method);
                double error = relative_difference(got->lambda, want->lambda, (size_t)rows * rows);
                count(r, methods[m].name, answered ? error : -1, tfa ? TFA_LAMBDA : BOUND);
                if (answered)
                    check_poses(r, &tips, got);
            }
        }
    } while (link > 0);
}

/* ---- one robot ---- */

static void check(uint64_t seed, uint32_t kinds, tfa_base base)
{
    reduction r;
    question a;
    reduction_open(&r, seed, kinds, base);
    check_structure(&r);
    robots++;
    if (r.n > 0 && question_open(&a, &r, seed, STATES, WRENCHES)) {
        struct answer want = answer_make(&r), got = answer_make(&r);
        check_mass(&r, &a);
        a.r.frame = a.whole.frame = (tfa_reference_frame)(seed % 3);
        for (uint32_t k = 0; k < STATES; k++) {
            tfa_request whole, one = question_state(&a, &r, k, &whole);
            oracle_set_state(r.o, &whole, 0);
            check_forward(&r, &one, &want, &got);
            check_inverse(&r, &one, &whole, &want, &got);
            check_mass_matrix(&r, &one, &want, &got);
            check_lambda(&r, &a, &one, &want, &got);
        }
        answer_free(&got);
        answer_free(&want);
        question_close(&a);
    } else if (r.n > 0) {
        skipped++;
    }
    reduction_close(&r);
}

static void print_tally(void)
{
    for (size_t k = 0; tally[k].what; k++)
        print_message("  %-28s worst %.1e of %6u, refused %u, fell back %u\n", tally[k].what,
                      tally[k].worst, tally[k].count, tally[k].refused, tally[k].fell_back);
    print_message("  %u robots, %u without a well-conditioned posture, %u joints fused, %u frames "
                  "inside fused bodies\n",
                  robots, skipped, fused_joints, inner_frames);
    assert_true(skipped * 3 < robots);
    memset(tally, 0, sizeof tally);
    robots = skipped = fused_joints = inner_frames = 0;
}

TEST(each_reduction_is_exact)
{
    for (uint32_t kind = 0; kind <= REDUCE_TIPS; kind = kind ? 2 * kind : 1) {
        print_message("  kind %u\n", kind);
        for (uint64_t seed = 1; seed <= SEEDS_ALONE; seed++)
            for (int base = 0; base < 2; base++)
                check(seed, kind, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
        print_tally();
    }
}

TEST(combinations_are_exact)
{
    for (uint64_t seed = 1; seed <= SEEDS_TOGETHER; seed++)
        for (int base = 0; base < 2; base++)
            check(seed, REDUCE_ANYTHING, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    assert_true(fused_joints > 0 && inner_frames > 0);
    print_tally();
}
