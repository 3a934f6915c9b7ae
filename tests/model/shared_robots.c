/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Real robots become models: how many bodies and freedoms each has with its mimics free and
 * projected, that every method then solves the same equations, and what is said of Romeo, whose
 * fingers have no mass.
 */
#include "models.h"
#include "test.h"

#include <totalforce/totalforce.h>
#include <unistd.h>

#define ROBOTS TFA_SOURCE_DIR "/../shared/robots/"

/* Counted by hand from the files: bodies are moving joints that are not locked. */
static const struct robot {
    const char *file;
    uint32_t lock_massless;
    uint32_t bodies, followers, fixed, locked;
} robots[] = {
    {"allegro_right.urdf", 0, 16, 0, 4, 0},
    {"anymal_c.urdf", 0, 12, 0, 65, 0},
    {"baxter.urdf", 0, 19, 2, 37, 0},
    {"double_pendulum.urdf", 0, 2, 0, 0, 0},
    {"go2.urdf", 0, 12, 0, 18, 0},
    {"h1.urdf", 0, 19, 0, 5, 0},
    {"iiwa14.urdf", 0, 7, 0, 3, 0},
    {"panda.urdf", 0, 9, 1, 3, 0},
    {"pr2.urdf", 0, 30, 10, 51, 0},
    {"romeo.urdf", 1, 31, 0, 26, 24},
    {"simple_humanoid.urdf", 0, 29, 0, 1, 0},
    {"solo12.urdf", 0, 12, 0, 4, 0},
    {"ur5.urdf", 0, 6, 0, 4, 0},
};
#define COUNT (sizeof robots / sizeof *robots)

static int absent(void)
{
    if (access(ROBOTS, R_OK) == 0)
        return 0;
    print_message("SKIPPED: no folder %s\n", ROBOTS);
    return 1;
}

static tfa_model *load(const struct robot *r, tfa_base base, tfa_mimic_policy mimic)
{
    char path[512];
    tfa_report report = {0};
    tfa_model *model = NULL;
    const tfa_model_options options = {
        .base = base, .mimic = mimic, .lock_massless_leaves = r->lock_massless};
    snprintf(path, sizeof path, ROBOTS "%s", r->file);
    int status = tfa_model_load(path, &options, &report, &model);
    if (status != TFA_OK)
        fail_msg("%s: %s", r->file, tfa_status_text(status));
    tfa_report_free(&report);
    return model;
}

TEST(bodies_and_freedoms)
{
    if (absent())
        return;
    for (size_t k = 0; k < COUNT; k++)
        for (int mimic = TFA_MIMIC_FREE; mimic <= TFA_MIMIC_LOCK; mimic++) {
            const struct robot *r = &robots[k];
            tfa_model *model = load(r, TFA_BASE_FIXED, (tfa_mimic_policy)mimic);
            const tfa_model_summary s = tfa_model_summarise(model);
            const uint32_t lost = mimic == TFA_MIMIC_FREE ? 0 : r->followers;
            assert_int_equal(s.bodies, r->bodies - (mimic == TFA_MIMIC_LOCK ? lost : 0));
            assert_int_equal(s.v_count, r->bodies - lost);
            assert_int_equal(s.q_count, s.v_count);
            assert_int_equal(s.follows, mimic == TFA_MIMIC_PROJECT ? lost : 0);
            assert_int_equal(s.fixed, r->fixed);
            assert_int_equal(s.locked, r->locked + (mimic == TFA_MIMIC_LOCK ? lost : 0));
            assert_int_equal(s.singular_body, -1);
            tfa_model_free(model);
        }
}

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

/* |a - b| / |b| */
static double distance(const double *a, const double *b, size_t n)
{
    double d = 0, s = 0;
    for (size_t k = 0; k < n; k++) {
        d += (a[k] - b[k]) * (a[k] - b[k]);
        s += b[k] * b[k];
    }
    return s > 0 ? sqrt(d / s) : sqrt(d);
}

struct answer {
    double x[256], lambda[36];
};

static void solve(tfa_workspace *w, const tfa_request *r, uint32_t nb, struct answer *a)
{
    tfa_reply reply = {.qdd = a->x + nb, .base_acceleration = a->x, .lambda_inv = a->lambda};
    const int status = tfa_compute(w, r, &reply);
    if (status != TFA_OK)
        fail_msg("%s: %s", tfa_method_name((uint32_t)r->method), tfa_status_text(status));
}

/* All methods against crba in quadruple precision: the worst error. */
static double worst_of(const tfa_model *model)
{
    static const tfa_method methods[] = {TFA_METHOD_ABA, TFA_METHOD_CRBA, TFA_METHOD_TFA};
    static double q[512], v[256], tau[256];
    const double pose[7] = {0.1, -0.2, 0.3, 0, 0.6, 0, 0.8};
    const tfa_workspace_options quad = {.precision = TFA_F128};
    const uint32_t nb = tfa_model_base_freedoms(model), n = nb + tfa_model_v_count(model);
    tfa_workspace *f64, *f128;
    static struct answer exact, found;
    double worst = 0;
    f64 = workspace_for(model, NULL);
    f128 = workspace_for(model, &quad);
    for (int k = 0; k < 8; k++) {
        for (uint32_t j = 0; j < n - nb; j++) {
            q[j] = 3 * uniform();
            v[j] = uniform();
            tau[j] = uniform();
        }
        tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                         .method = TFA_METHOD_CRBA,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .tip_count = 1,
                         .tips = {tfa_model_frame_count(model) - 1},
                         .q = q,
                         .v = v,
                         .tau = tau,
                         .base_pose = pose};
        solve(f128, &r, nb, &exact);
        for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
            r.method = methods[m];
            solve(f64, &r, nb, &found);
            worst = fmax(worst, distance(found.x, exact.x, n));
            worst = fmax(worst, distance(found.lambda, exact.lambda, 36));
        }
    }
    tfa_workspace_free(f64);
    tfa_workspace_free(f128);
    return worst;
}

TEST(every_method_solves_them)
{
    if (absent())
        return;
    for (size_t k = 0; k < COUNT; k++)
        for (int base = TFA_BASE_FIXED; base <= TFA_BASE_FLOATING; base++)
            for (int mimic = TFA_MIMIC_FREE; mimic <= TFA_MIMIC_PROJECT; mimic++) {
                tfa_model *model = load(&robots[k], (tfa_base)base, (tfa_mimic_policy)mimic);
                const double worst = worst_of(model);
                if (!(worst < 1e-12))
                    fail_msg("%s, base %d, mimic %d: %g", robots[k].file, base, mimic, worst);
                tfa_model_free(model);
            }
}

/* The finger joints are counted, the first of them named, with its line and the way out. */
TEST(romeo_is_refused_by_name)
{
    if (absent())
        return;
    tfa_report report = {0};
    tfa_model *model = NULL;
    char text[512];
    size_t named = 0, thumb = 0;
    assert_int_equal(tfa_model_load(ROBOTS "romeo.urdf", NULL, &report, &model), TFA_E_NO_MASS);
    assert_null(model);
    for (size_t k = 0; k < report.count; k++) {
        if (strcmp(report.messages[k].code, "massless-leaf") != 0)
            continue;
        named += report.messages[k].count;
        (void)tfa_report_format(&report, k, text, sizeof text);
        thumb += strcmp(text, ROBOTS "romeo.urdf:1443: error: joint 'LHand': nothing with mass "
                                     "moves with it, so the mass matrix is singular; lock it "
                                     "(lock_massless_leaves = 1 locks all of them), make it "
                                     "fixed, or give link 'LFinger11Link' mass or the joint "
                                     "armature; joints like it: 24 ('LHand', 'RHand', "
                                     "'LFinger12', 'LFinger13', 'LFinger21', ...) "
                                     "[massless-leaf]") == 0;
    }
    assert_int_equal(named, 24);
    assert_int_equal(thumb, 1);
    tfa_report_free(&report);
}
