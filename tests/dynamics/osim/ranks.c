/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The rank of Lambda^-1 by every method, unrefined and as by default, is that of force propagation
 * in quadruple precision: robots in random and in singular postures, one tip and several; tips that
 * share more freedoms than there are; and long chains, whose segments fill lanes.
 */
#include "mechanism/mechanism.h"
#include "models.h"
#include "support/fixture.h"
#include "test.h"

#include <unistd.h>

enum { CONFIGURATIONS = 60, TIPS = 4, FREEDOMS = 128 };

/* Robots and their tips. The fingers are light, and what their joints do not move is a hand and an
 * arm. */
static const struct {
    const char *file;
    tfa_base base;
    const char *tips[TIPS];
} robots[] = {
    {"config/robots/arm6.urdf", TFA_BASE_FIXED, {"tool0"}},
    {"config/robots/arm7.urdf", TFA_BASE_FIXED, {"tool0"}},
    {"config/robots/arm7.urdf", TFA_BASE_FIXED, {"link_3", "tool0"}},
    {"config/robots/quadruped.urdf", TFA_BASE_FLOATING, {"FL_foot", "RR_foot"}},
    {"config/robots/humanoid.urdf", TFA_BASE_FIXED, {"left_thumb_2_link", "left_index_tip"}},
    {"config/robots/humanoid.urdf", TFA_BASE_FLOATING, {"left_ring_2_link", "left_index_tip"}},
    {"config/robots/humanoid.urdf",
     TFA_BASE_FIXED,
     {"left_palm", "left_middle_1_link", "left_foot", "right_index_tip"}},
    {"../shared/robots/panda.urdf", TFA_BASE_FIXED, {"panda_hand_tcp"}},
    {"../shared/robots/panda.urdf", TFA_BASE_FIXED, {"panda_leftfinger", "panda_rightfinger"}},
    {"../shared/robots/panda.urdf", TFA_BASE_FIXED, {"panda_hand", "panda_leftfinger"}},
};

static uint64_t asked;
static uint32_t least = UINT32_MAX;

/* One posture of `x`, all methods */
static void hold_ranks(const test_robot *x, tfa_request *r)
{
    static double lambda[36 * TIPS * TIPS];
    tfa_spectrum spectrum;
    tfa_reply reply = {.lambda_inv = lambda, .spectrum = &spectrum};
    r->method = TFA_METHOD_PROPAGATION;
    r->refine = TFA_REFINE_DEFAULT;
    compute_ok(x, x->f128, r, &reply);
    const tfa_spectrum want = spectrum;
    least = want.rank < least ? want.rank : least;
    for (uint32_t m = 0; tfa_method_describe(m); m++)
        for (int unestimated = 0; unestimated < 2 && tfa_method_describe(m)->lambda;
             unestimated++) {
            r->method = (tfa_method)m;
            r->refine = unestimated ? 0 : TFA_REFINE_DEFAULT;
            const int status = tfa_compute(x->f64, r, &reply);
            if (status == TFA_E_METHOD || status == TFA_E_SINGULAR || status == TFA_E_UNSUPPORTED)
                continue;
            assert_int_equal(status, TFA_OK);
            asked++;
            if (spectrum.rank != want.rank)
                fail_msg("%s, %s%s: rank %u, f128 %u; eigenvalues %.2g to %.2g", x->name,
                         tfa_method_name(m), unestimated ? ", bare" : "", (unsigned)spectrum.rank,
                         (unsigned)want.rank, spectrum.eig_min, spectrum.eig_max);
        }
}

static tfa_request request_of(const double *q)
{
    return (tfa_request){.op = TFA_OP_OPERATIONAL_INERTIA,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .flags = TFA_WANT_SPECTRUM,
                         .count = 1,
                         .q = q};
}

/* At random, then most joints and at last all of them straight, so that arms are stretched out and
 * axes of wrists meet */
static void draw(uint64_t *s, uint32_t configuration, uint32_t n, double *q)
{
    for (uint32_t k = 0; k < n; k++) {
        const double at = mechanism_random_uniform(s, -1.5, 1.5),
                     straight = mechanism_random_uniform(s, 0, CONFIGURATIONS);
        q[k] = straight < configuration ? 0 : at;
    }
}

static void open_workspaces(test_robot *x)
{
    const tfa_workspace_options quad = {.precision = TFA_F128};
    const tfa_workspace_options all = {.methods = TFA_METHODS_ALL};
    x->f64 = workspace_for(x->model, &all);
    x->f128 = workspace_for(x->model, &quad);
}

static void close_robot(test_robot *x)
{
    tfa_workspace_free(x->f64);
    tfa_workspace_free(x->f128);
    tfa_model_free(x->model);
}

/* Opens robot k of the table, tips and all; 0 where it is not there */
static int open_robot(size_t k, test_robot *x, tfa_request *r)
{
    const tfa_model_options options = {.base = robots[k].base};
    char path[512];
    *x = (test_robot){.base = robots[k].base};
    snprintf(path, sizeof path, "%s/%s", TFA_SOURCE_DIR, robots[k].file);
    if (access(path, R_OK) != 0 && robots[k].file[0] == '.')
        return 0;
    assert_int_equal(tfa_model_load(path, &options, NULL, &x->model), TFA_OK);
    for (; r->tip_count < TIPS && robots[k].tips[r->tip_count]; r->tip_count++) {
        const int32_t tip = tfa_model_find_frame(x->model, robots[k].tips[r->tip_count]);
        assert_true(tip >= 0);
        r->tips[r->tip_count] = (uint32_t)tip;
    }
    snprintf(x->name, sizeof x->name, "%s to %s", robots[k].file, robots[k].tips[r->tip_count - 1]);
    open_workspaces(x);
    return 1;
}

TEST(robots_in_any_configuration)
{
    static const double upright[7] = {0, 0, 0, 0, 0, 0, 1};
    for (size_t k = 0; k < sizeof robots / sizeof *robots; k++) {
        test_robot x;
        double q[FREEDOMS];
        tfa_request r = request_of(q);
        uint64_t s = k;
        if (!open_robot(k, &x, &r))
            continue;
        r.base_pose = x.base == TFA_BASE_FLOATING ? upright : NULL;
        for (uint32_t configuration = 0; configuration <= CONFIGURATIONS; configuration++) {
            draw(&s, configuration, tfa_model_q_count(x.model), q);
            hold_ranks(&x, &r);
        }
        close_robot(&x);
    }
    print_message("  %llu answers, ranks from %u on\n", (unsigned long long)asked, (unsigned)least);
}

/* The tip of a planar chain moves in its plane, of a straight one at least not along it. */
TEST(chains)
{
    static const mechanism_kind kinds[] = {MECHANISM_PLANAR, MECHANISM_STRAIGHT, MECHANISM_RANDOM,
                                           MECHANISM_TAPER};
    static const uint32_t sizes[] = {2, 4, 12, 47, 48, 64, 100};
    double q[FREEDOMS] = {0};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++)
            for (uint64_t seed = 1; seed <= 4; seed++) {
                mechanism_options o = mechanism_defaults(kinds[k], sizes[n]);
                const tfa_model_options options = {.base = TFA_BASE_FIXED};
                tfa_request r = request_of(q);
                test_robot x = {0};
                o.seed = seed;
                x.description = mechanism_make(&o);
                assert_non_null(x.description);
                x.model = compiled(x.description, &options);
                snprintf(x.name, sizeof x.name, "%s of %u, seed %u", mechanism_name(o.kind),
                         (unsigned)o.bodies, (unsigned)seed);
                open_workspaces(&x);
                r.tip_count = 1;
                r.tips[0] = tfa_model_frame_count(x.model) - 1;
                hold_ranks(&x, &r);
                close_robot(&x);
                mechanism_free(x.description);
            }
}
