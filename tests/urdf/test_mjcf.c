/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots as MJCF and, written from MuJoCo's manual by hand, as URDF have the same dynamics.
 */
#include "test.h"

#include <totalforce/dynamics.h>
#include <totalforce/limits.h>
#include <totalforce/model.h>

#define FOLDER TFA_SOURCE_DIR "/tests/urdf/mjcf/"

enum { MOST = 12 };

static tfa_model *load(const char *name, tfa_base base, tfa_mimic_policy mimic)
{
    const tfa_model_options options = {
        .base = base, .damping = 1, .friction = 1, .rotor_inertia = 1, .mimic = mimic};
    char path[512];
    tfa_report report = {0};
    tfa_model *model = NULL;
    snprintf(path, sizeof path, FOLDER "%s", name);
    if (tfa_model_load(path, &options, &report, &model) != TFA_OK)
        fail_msg("%s: %s", name, report.count > 0 ? report.messages[0].text : "");
    tfa_report_free(&report);
    return model;
}

/* Distinct numbers for every input, from -1 to 1 */
static void fill(double *numbers, int count, double seed)
{
    for (int k = 0; k < count; k++)
        numbers[k] = sin(seed + 1.7 * k);
}

struct answers {
    double tau[MOST], wrench[6], mass[MOST * MOST], qdd[MOST], base[6];
};

static void answer(const tfa_model *model, int floats, struct answers *a)
{
    static const double pose[7] = {0.1, -0.2, 0.3, 0.48, -0.6, 0.64, 0};
    double q[MOST], v[MOST], x[MOST], twist[6];
    tfa_workspace *w = NULL;
    const uint32_t constraints = tfa_model_constraint_count(model);
    memset(a, 0, sizeof *a);
    fill(q, MOST, 0.1);
    fill(v, MOST, 0.2);
    fill(x, MOST, 0.3);
    fill(twist, 6, 0.4);
    assert_int_equal(tfa_workspace_create(model, NULL, &w), TFA_OK);
    tfa_request r = {.count = 1, .q = q, .v = v, .qdd = x};
    r.base_pose = floats ? pose : NULL;
    r.base_twist = r.base_acceleration = floats ? twist : NULL;
    tfa_reply y = {.tau = a->tau, .base_wrench = floats ? a->wrench : NULL};
    r.op = TFA_OP_INVERSE_DYNAMICS;
    assert_int_equal(tfa_compute(w, &r, &y), TFA_OK);
    r = (tfa_request){.op = TFA_OP_MASS_MATRIX, .count = 1, .q = q, .base_pose = r.base_pose};
    y = (tfa_reply){.mass_matrix = a->mass};
    assert_int_equal(tfa_compute(w, &r, &y), TFA_OK);
    r.op = constraints ? TFA_OP_CONSTRAINED_DYNAMICS : TFA_OP_FORWARD_DYNAMICS;
    r.constraints = (1U << constraints) - 1;
    r.v = v;
    r.base_twist = floats ? twist : NULL;
    y = (tfa_reply){.qdd = a->qdd, .base_acceleration = floats ? a->base : NULL};
    assert_int_equal(tfa_compute(w, &r, &y), TFA_OK);
    tfa_workspace_free(w);
}

static const struct robot {
    const char *mjcf, *urdf;
    tfa_base base;
    tfa_mimic_policy mimic;
    uint32_t freedoms, constraints;
} robots[] = {
    {"arm.xml", "arm.urdf", TFA_BASE_FIXED, TFA_MIMIC_FREE, 4, 0},
    {"arm.xml", "arm.urdf", TFA_BASE_FIXED, TFA_MIMIC_PROJECT, 3, 0},
    {"leg.xml", "leg.urdf", TFA_BASE_FIXED, TFA_MIMIC_FREE, 3, 0},
    {"walker.xml", "walker.urdf", TFA_BASE_FLOATING, TFA_MIMIC_FREE, 6, 2},
};

TEST(test_same_dynamics)
{
    for (size_t k = 0; k < sizeof robots / sizeof *robots; k++) {
        const struct robot *r = &robots[k];
        struct answers a[2];
        for (int side = 0; side < 2; side++) {
            tfa_model *model = load(side == 0 ? r->mjcf : r->urdf, r->base, r->mimic);
            assert_int_equal(tfa_model_v_count(model), r->freedoms);
            assert_int_equal(tfa_model_constraint_count(model), r->constraints);
            answer(model, r->base == TFA_BASE_FLOATING, &a[side]);
            tfa_model_free(model);
        }
        double size = 0, error = 0;
        for (size_t i = 0; i < sizeof a[0] / sizeof(double); i++) {
            const double x = ((double *)&a[0])[i], y = ((double *)&a[1])[i];
            size = fmax(size, fabs(y));
            error = fmax(error, fabs(x - y));
        }
        print_message("%s: largest difference %.2g of %.2g\n", r->mjcf, error, size);
        assert_true(error <= 1e-12 * size);
    }
}

/* A text in memory names no folder. */
TEST(test_include_in_memory)
{
    static const char text[] = "<mujoco><include file=\"arm.xml\"/></mujoco>";
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_parse(text, sizeof text - 1, "f", &d, &report), TFA_E_PARSE);
    assert_string_equal(report.messages[0].code, "bad-include");
    tfa_report_free(&report);
}

TEST(test_limits)
{
    static const char *const names[] = {"pan", "left", "lift", "absent"};
    const double degree = acos(-1) / 180;
    tfa_report report = {0};
    tfa_joint_limits limits[4];
    char *text;
    size_t length;
    assert_int_equal(tfa_urdf_read(FOLDER "arm.xml", &text, &length, &report), TFA_OK);
    assert_int_equal(tfa_urdf_limits(text, length, names, 4, limits), TFA_OK);
    assert_true(limits[0].limited && fabs(limits[0].lower + 90 * degree) < 1e-15);
    assert_true(fabs(limits[2].upper - 45 * degree) < 1e-15);
    assert_true(limits[1].lower == 0 && limits[1].upper == 0.04 && !limits[3].limited);
    free(text);
    tfa_report_free(&report);
}
