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
#include "dynamics/reductions/reductions.h"
#include "kernels.h"
#include "test.h"

#include <glob.h>

#define WRENCHES 2

static const reduction_bounds bounds = {2e-11, 2e-14, 0, 2e-11};
static uint32_t robots;

static void compare(reduction *r, random_source *s)
{
    question a;
    tfa_request one, whole;
    const uint32_t links = (uint32_t)r->whole->link_count;
    assert_true(question_open(&a, r, 7, 1, WRENCHES));
    one = question_state(&a, r, 0, &whole);
    one.refine = 0;
    one.estimate = TFA_ESTIMATE_NEVER;
    reduction_check_forward(r, &one, &whole, r->tie, &bounds);
    one.tip_count = whole.tip_count = kernels_find(r->model) ? 1 : 2; /* such kernels take one */
    one.tips[0] = whole.tips[0] = links - 1;
    one.tips[1] = whole.tips[1] = random_below(s, links);
    reduction_check_lambda(r, &one, &whole, r->tie, &bounds, 1);
    question_close(&a);
    robots++;
}

static void with_options(const char *path, tfa_base base, tfa_mimic_policy mimic, int armature)
{
    reduction r;
    tfa_description *d;
    tfa_report report = {0};
    const char *name = strrchr(path, '/') + 1;
    const tfa_model_options options = {.base = base, .mimic = mimic, .lock_massless_leaves = 1};
    random_source s = {7};
    assert_int_equal(tfa_urdf_load(path, &d, &report), TFA_OK);
    for (size_t j = 0; armature && j < d->joint_count; j++)
        if (d->joints[j].type != TFA_JOINT_FIXED)
            d->joints[j].armature += random_uniform(&s, 0.01, 0.2);
    if (reduction_open_robot(&r, name, d, &options)) {
        if (r.nv > 0 && !kernels_skip(r.model))
            compare(&r, &s);
        reduction_close(&r);
    } else { /* a floating base needs a root with mass */
        print_message("  REFUSED: %s\n", name);
        assert_true(base == TFA_BASE_FLOATING);
    }
    tfa_report_free(&report);
    tfa_description_free(d);
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

TEST(every_method_on_every_file)
{
    all_in(TFA_SOURCE_DIR "/config/robots/*.urdf");
    assert_true(robots >= 8);
    all_in(TFA_SOURCE_DIR "/../shared/robots/*.urdf");
    print_message("  %u robots, bases, policies and armatures\n", (unsigned)robots);
    reduction_print();
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        if (tfa_method_describe(m)->forward_dynamics)
            assert_true(reduction_answered(TFA_OP_FORWARD_DYNAMICS, m) > 0);
        if (tfa_method_describe(m)->lambda)
            assert_true(reduction_answered(TFA_OP_OPERATIONAL_INERTIA, m) > 0);
    }
}
