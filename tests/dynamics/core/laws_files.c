/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every method of the table against the oracle on every robot file, config/robots and, where it is
 * there, ../shared/robots: base fixed and floating, mimics free and projected, joints that move
 * nothing with mass locked, with and without armature on all joints, with velocities, gravity and
 * wrenches. The oracle has nothing reduced: it ties freedoms by equations.
 *
 * What a method refuses, by the row of the table, is counted.
 */
#include "kernels.h"
#include "support/fixture.h"
#include "test.h"

#include <glob.h>

#define METHODS 32
#define WRENCHES 2
#define MOST 256 /* joints of a file */
#define BOUND 2e-11
#define BOUND_F128 2e-14

struct count {
    uint32_t answered, refused;
    double worst;
};
static struct count forward[METHODS], lambda[METHODS];
static uint32_t robots;

/* A robot in both languages */
struct robot {
    const char *name;
    tfa_description *d;
    tfa_model *model;
    tfa_workspace *f64, *f128;
    oracle *o;
    uint32_t six, nv, n; /* base freedoms; of the model; rows of M */
    double q[7 * MOST], v[MOST], tau[MOST];
    double all_q[7 * MOST], all_v[MOST];
};

/* What became of joint j of the file. */
static tfa_declared_joint fate_of(const struct robot *r, uint32_t j)
{
    for (uint32_t k = 0; k < tfa_model_declared_count(r->model); k++) {
        const tfa_declared_joint found = tfa_model_declared(r->model, k);
        if (strcmp(found.name, r->d->joints[j].name) == 0)
            return found;
    }
    fail_msg("%s: no joint '%s'", r->name, r->d->joints[j].name);
    return (tfa_declared_joint){0};
}

/* The joint that joint j of the file follows in the end: q_j = multiplier q + offset. */
static uint32_t leader_of(const struct robot *r, uint32_t j, double *multiplier, double *offset)
{
    *multiplier = 1;
    *offset = 0;
    if (fate_of(r, j).fate != TFA_FATE_FOLLOWS)
        return j;
    while (r->d->joints[j].mimic >= 0) {
        *offset += *multiplier * r->d->joints[j].offset;
        *multiplier *= r->d->joints[j].multiplier;
        j = (uint32_t)r->d->joints[j].mimic;
    }
    return j;
}

/* Ties the freedoms of all joints to those of the model, and fills in their q and v. */
static void tie(struct robot *r)
{
    static const uint32_t widths[] = {0, 1, 1, 1, 3, 7};
    oracle_tie ties[MOST];
    for (uint32_t k = 0; k < r->six; k++)
        ties[k] = (oracle_tie){k, 1};
    for (uint32_t v = 0, q = 0, within; v < oracle_v_count(r->o); v++) {
        const uint32_t j = oracle_joint_of_freedom(r->o, v, &within);
        double multiplier, offset;
        const uint32_t leader = leader_of(r, j, &multiplier, &offset);
        const int32_t own = tfa_model_find_joint(r->model, r->d->joints[leader].name);
        const uint32_t width = within == 0 ? widths[r->d->joints[j].type] : 0;
        oracle_tie *t = &ties[r->six + v];
        *t = (oracle_tie){ORACLE_STILL, 0};
        r->all_v[v] = 0;
        for (uint32_t k = 0; k < width; k++)
            r->all_q[q + k] = 0;
        if (own >= 0) {
            const tfa_joint_info info = tfa_model_joint(r->model, (uint32_t)own);
            *t = (oracle_tie){r->six + info.v_index + within, multiplier};
            r->all_v[v] = multiplier * r->v[info.v_index + within];
            for (uint32_t k = 0; k < width; k++)
                r->all_q[q + k] = multiplier * r->q[info.q_index + k] + offset;
        } else {
            assert_int_equal(fate_of(r, leader).fate, TFA_FATE_LOCKED);
        }
        q += width;
    }
    oracle_tie_freedoms(r->o, ties, r->n);
}

static void draw(struct robot *r, random_source *s)
{
    for (uint32_t j = 0; j < tfa_model_joint_count(r->model); j++) {
        const tfa_joint_info info = tfa_model_joint(r->model, j);
        (void)random_coordinates(s, info.type, r->q + info.q_index);
    }
    for (uint32_t k = 0; k < r->nv; k++) {
        r->v[k] = random_uniform(s, -1, 1);
        r->tau[k] = random_uniform(s, -10, 10);
    }
}

/* Whether by the table the method refuses something that this status can stand for */
static int may_refuse(const tfa_method_info *row, int status)
{
    const unsigned method =
        TFA_REFUSES_ARMATURE | TFA_REFUSES_MIMICS | TFA_REFUSES_MASSLESS_FOLLOWER;
    return (status == TFA_E_METHOD && row->refuses & method) ||
           (status == TFA_E_SINGULAR && row->refuses & TFA_REFUSES_NO_INVERSE) ||
           (status == TFA_E_UNSUPPORTED && row->refuses & (TFA_REFUSES_LENGTH | TFA_REFUSES_SIZE));
}

static void ask(struct robot *r, tfa_request *request, tfa_reply *reply, const double *want,
                const double *got, uint32_t n, struct count *counts)
{
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        const tfa_method_info *row = tfa_method_describe(m);
        if (!(request->op == TFA_OP_FORWARD_DYNAMICS ? row->forward_dynamics : row->lambda))
            continue;
        for (int quad = 0; quad < 2; quad++) {
            request->method = row->method;
            const int status = tfa_compute(quad ? r->f128 : r->f64, request, reply);
            if (status != TFA_OK) {
                if (!may_refuse(row, status))
                    fail_msg("%s: %s: %s", r->name, row->name, tfa_status_text(status));
                counts[m].refused++;
                continue;
            }
            const double error = relative_error(got, want, n);
            if (!(error <= (quad ? BOUND_F128 : BOUND)))
                fail_msg("%s: %s%s: error %.1e", r->name, row->name, quad ? ", f128" : "", error);
            counts[m].answered++;
            counts[m].worst = fmax(counts[m].worst, quad ? 0 : error);
        }
    }
}

static void compare(struct robot *r, random_source *s)
{
    double pose[7] = {0.1, -0.2, 0.3, 0, 0, 0, 1}, twist[6], wrench[6], wrenches[6 * WRENCHES];
    const double gravity[3] = {1, -2, -9};
    double want[MOST], got[MOST], want_lambda[144], got_lambda[144];
    random_quaternion(s, pose + 3);
    for (int k = 0; k < 6; k++) {
        twist[k] = random_uniform(s, -1, 1);
        wrench[k] = random_uniform(s, -10, 10);
    }
    for (int k = 0; k < 6 * WRENCHES; k++)
        wrenches[k] = random_uniform(s, -10, 10);
    tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .estimate = TFA_ESTIMATE_NEVER,
                           .count = 1,
                           .q = r->q,
                           .v = r->v,
                           .tau = r->tau,
                           .base_pose = r->six ? pose : NULL,
                           .base_twist = r->six ? twist : NULL,
                           .base_wrench = r->six ? wrench : NULL,
                           .gravity = gravity,
                           .wrench_count = WRENCHES,
                           .wrenches = wrenches};
    for (uint32_t k = 0; k < WRENCHES; k++)
        request.wrench_frames[k] = random_below(s, (uint32_t)r->d->link_count);
    tfa_request whole = request;
    whole.q = r->all_q;
    whole.v = r->all_v;
    oracle_set_state(r->o, &whole, 0);
    oracle_forward(r->o, r->tau, wrench, want + r->six, want);
    tfa_reply reply = {.qdd = got + r->six, .base_acceleration = got};
    ask(r, &request, &reply, want, got, r->n, forward);
    request.op = TFA_OP_OPERATIONAL_INERTIA;
    request.tip_count = kernels_find(r->model) ? 1 : 2; /* such kernels take one */
    request.tips[0] = (uint32_t)r->d->link_count - 1;
    request.tips[1] = random_below(s, (uint32_t)r->d->link_count);
    oracle_lambda_inv(r->o, request.tips, request.tip_count, request.frame, want_lambda);
    tfa_reply inverse = {.lambda_inv = got_lambda};
    ask(r, &request, &inverse, want_lambda, got_lambda, 36 * request.tip_count * request.tip_count,
        lambda);
}

static void with_options(const char *path, tfa_base base, tfa_mimic_policy mimic, int armature)
{
    static struct robot r;
    tfa_report report = {0};
    const tfa_model_options options = {.base = base, .mimic = mimic, .lock_massless_leaves = 1};
    random_source s = {7};
    r = (struct robot){.name = strrchr(path, '/') + 1};
    assert_int_equal(tfa_urdf_load(path, &r.d, &report), TFA_OK);
    for (size_t j = 0; armature && j < r.d->joint_count; j++)
        if (r.d->joints[j].type != TFA_JOINT_FIXED)
            r.d->joints[j].armature += random_uniform(&s, 0.01, 0.2);
    const int status = tfa_model_create(r.d, &options, &report, &r.model);
    if (status != TFA_OK) /* a floating base needs a root with mass */
        print_message("  REFUSED: %s: %s\n", r.name, tfa_status_text(status));
    assert_true(status == TFA_OK || base == TFA_BASE_FLOATING);
    if (status == TFA_OK && tfa_model_v_count(r.model) > 0 && !kernels_skip(r.model)) {
        r.o = oracle_create(r.d, base);
        r.f64 = fixture_workspace(r.model, TFA_F64);
        r.f128 = fixture_workspace(r.model, TFA_F128);
        r.six = tfa_model_base_freedoms(r.model);
        r.nv = tfa_model_v_count(r.model);
        r.n = r.six + r.nv;
        assert_true(r.six + oracle_v_count(r.o) <= MOST);
        draw(&r, &s);
        tie(&r);
        compare(&r, &s);
        robots++;
        tfa_workspace_free(r.f64);
        tfa_workspace_free(r.f128);
        oracle_free(r.o);
    }
    tfa_model_free(r.model);
    tfa_report_free(&report);
    tfa_description_free(r.d);
}

static void all_in(const char *pattern)
{
    glob_t g = {0};
    if (glob(pattern, 0, NULL, &g) != 0)
        print_message("SKIP: no robots in %s\n", pattern);
    for (size_t k = 0; k < g.gl_pathc; k++)
        for (int base = 0; base < 2; base++)
            for (int mimic = 0; mimic < 2; mimic++)
                for (int armature = 0; armature < 2; armature++)
                    with_options(g.gl_pathv[k], base ? TFA_BASE_FLOATING : TFA_BASE_FIXED,
                                 mimic ? TFA_MIMIC_PROJECT : TFA_MIMIC_FREE, armature);
    globfree(&g);
}

static void print_counts(const char *what, const struct count *counts)
{
    for (uint32_t m = 0; m < METHODS; m++)
        if (counts[m].answered + counts[m].refused > 0)
            print_message("  %s %-14s %4u answered, %4u refused, worst %.1e\n", what,
                          tfa_method_name(m), (unsigned)counts[m].answered,
                          (unsigned)counts[m].refused, counts[m].worst);
}

TEST(every_method_on_every_file)
{
    all_in(TFA_SOURCE_DIR "/config/robots/*.urdf");
    assert_true(robots >= 8);
    all_in(TFA_SOURCE_DIR "/../shared/robots/*.urdf");
    print_message("  %u robots, bases, policies and armatures\n", (unsigned)robots);
    print_counts("qdd", forward);
    print_counts("lambda_inv", lambda);
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        if (tfa_method_describe(m)->forward_dynamics)
            assert_true(forward[m].answered > 0);
        if (tfa_method_describe(m)->lambda)
            assert_true(lambda[m].answered > 0);
    }
}
