/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages with a rule of their own: links without <inertial>, rounded inertias, what is not used,
 * many of one kind, and the last line of a refused robot in the syntax of each interface.
 */
#include "hand.h"
#include "models.h"
#include "test.h"

#include <float.h>
#include <totalforce/dynamics.h>
#include <totalforce/text.h>

static void expect(const struct outcome *o, const char *code, const char *text)
{
    assert_string_equal(hand_said(o, code)->text, text);
}

static void remove_inertial(tfa_link *link)
{
    link->mass = 0;
    memset(link->inertia, 0, sizeof link->inertia);
    link->inertial = 0;
}

/* The arm, whose upper link says nothing of its mass. */
static void make_massless_followers(hand *h)
{
    hand_arm(h);
    remove_inertial(&h->link[1]);
    h->joint[1].axis[0] = 1;
    h->joint[1].axis[1] = 0;
}

TEST(test_no_inertial)
{
    const tfa_model_options physical = {.inertia = TFA_INERTIA_STRICT_PHYSICAL};
    hand h;
    make_massless_followers(&h);
    struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    assert_int_equal(hand_said(&o, "massless-link")->severity, TFA_WARNING);
    assert_int_equal(hand_said(&o, "massless-link")->line, 11);
    expect(
        &o, "massless-link",
        "link 'upper': moves by itself and has no <inertial>: joint 'shoulder' and joint 'elbow' "
        "became one joint with 2 freedoms; add <inertial>, or make its joint fixed");
    hand_forget(&o);
    o = hand_outcome(&h, &physical, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_MODEL);
    expect(
        &o, "massless-link",
        "link 'upper': moves by itself and has no <inertial>: joint 'shoulder' and joint 'elbow' "
        "became one joint with 2 freedoms; add <inertial>, or make its joint fixed, or choose "
        "inertia = strict");
    expect(&o, "refused", "robot: not loaded: 1 error; it loads with inertia = strict");
    hand_forget(&o);
    h.link[1].inertial = 1; /* stated zeros are a universal joint */
    o = hand_outcome(&h, &physical, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    assert_int_equal(o.report.warnings, 0);
    hand_forget(&o);
}

/* A link that something with mass is fixed to, or that does not move by itself, needs none. */
TEST(test_inertial_not_needed)
{
    const tfa_model_options physical = {.inertia = TFA_INERTIA_STRICT_PHYSICAL};
    const tfa_payload load[] = {{.link = "upper", .mass = 1}};
    const tfa_scene loaded = {.payloads = load, .payload_count = 1};
    const tfa_lock shoulder[] = {{"shoulder", {0.5}}};
    const tfa_scene locked = {.locks = shoulder, .lock_count = 1};
    hand h;
    make_massless_followers(&h);
    for (int k = 0; k < 2; k++) {
        tfa_model_options options = physical;
        options.scene = k ? &locked : &loaded;
        struct outcome o = hand_outcome(&h, &options, TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_OK);
        assert_false(hand_says(&o, "massless-link"));
        hand_forget(&o);
    }
    hand_joint(&h, "weld", TFA_JOINT_FIXED, 1, hand_link(&h, "motor", 1, 0, 0, 0));
    struct outcome o = hand_outcome(&h, &physical, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    assert_false(hand_says(&o, "massless-link"));
    hand_forget(&o);
}

/* Forward dynamics of the arm at some state. */
static void solve(const tfa_model *model, double qdd[2])
{
    const double q[2] = {0.3, -0.7}, v[2] = {0.5, 0.25}, tau[2] = {1, -2};
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = q, .v = v, .tau = tau};
    tfa_reply reply = {.qdd = qdd};
    tfa_workspace *w = workspace_for(model, NULL);
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
}

/* A moment that is 0 but for rounding: the arm with it is the arm with 0. */
TEST(test_rounded)
{
    static const double moments[] = {-2.4e-35, -5.4e-20, -1e-16};
    hand exact, h;
    hand_arm(&exact);
    memset(exact.link[1].inertia, 0, sizeof exact.link[1].inertia);
    struct outcome want = hand_outcome(&exact, NULL, TFA_SYNTAX_C);
    for (size_t k = 0; k < sizeof moments / sizeof *moments; k++) {
        double a[2], b[2];
        hand_arm(&h);
        for (int i = 0; i < 6; i++)
            h.link[1].inertia[i] = i == 0 ? moments[k] : i == 3 ? -moments[k] / 2 : 0;
        struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_OK);
        assert_int_equal(hand_said(&o, "inertia-rounded")->severity, TFA_NOTE);
        assert_int_equal(o.report.warnings, 0);
        assert_memory_equal(tfa_model_hash(o.model), tfa_model_hash(want.model), 32);
        solve(o.model, a);
        solve(want.model, b);
        assert_true(isfinite(a[0]) && isfinite(a[1]));
        assert_memory_equal(a, b, sizeof a);
        hand_forget(&o);
    }
    hand_forget(&want);
}

/* The arm in other units: kg become `mass` kg, m become `length` m. */
static void scale(hand *h, double mass, double length)
{
    for (size_t k = 0; k < h->d.link_count; k++) {
        h->link[k].mass *= mass;
        for (int i = 0; i < 3; i++)
            h->link[k].com[i] *= length;
        for (int i = 0; i < 6; i++)
            h->link[k].inertia[i] *= mass * length * length;
    }
    for (size_t j = 0; j < h->d.joint_count; j++)
        for (int i = 0; i < 3; i++)
            h->joint[j].xyz[i] *= length;
}

/* Rounding goes with the robot: 16 eps times its mass and the square of its longest distance. */
TEST(test_rounding_scales)
{
    static const double units[][2] = {{1, 1}, {1e-6, 1e-3}, {1e6, 1e3}};
    static const struct {
        double times;
        int status;
    } rows[] = {{0.9, TFA_OK}, {1.1, TFA_E_MODEL}};
    for (int u = 0; u < 3; u++)
        for (int k = 0; k < 2; k++) {
            hand h;
            double mass = 0, longest = 0;
            hand_arm(&h);
            memset(h.link[1].inertia, 0, sizeof h.link[1].inertia);
            for (size_t i = 0; i < h.d.link_count; i++) {
                mass += h.link[i].mass;
                longest = fmax(longest,
                               hypot(h.link[i].com[0], hypot(h.link[i].com[1], h.link[i].com[2])));
            }
            for (size_t j = 0; j < h.d.joint_count; j++)
                longest = fmax(
                    longest, hypot(h.joint[j].xyz[0], hypot(h.joint[j].xyz[1], h.joint[j].xyz[2])));
            h.link[1].inertia[0] = -16 * DBL_EPSILON * rows[k].times * mass * longest * longest;
            scale(&h, units[u][0], units[u][1]);
            struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
            assert_int_equal(o.status, rows[k].status);
            hand_forget(&o);
        }
}

/* A camera whose inertia lost a sign in its last decimal u: its least moment (1 - sqrt 2) 1e-6 has
 * the axis x = (sqrt 2, -1, -1) / 2, and u/2 (|x0| + |x1| + |x2|)^2 explains it from u = 2.843e-7
 * on. It is 0 where the camera is part of a body with a larger inertia. */
TEST(test_last_digit)
{
    static const struct {
        double last_digit, others; /* inertia of the links beside it */
        tfa_joint_type mount;
        int loads;
    } rows[] = {
        {1e-6, 0.01, TFA_JOINT_FIXED, 1},    {2.85e-7, 0.01, TFA_JOINT_FIXED, 1},
        {2.84e-7, 0.01, TFA_JOINT_FIXED, 0}, {0, 0.01, TFA_JOINT_FIXED, 0},
        {1e-6, 4.1e-7, TFA_JOINT_FIXED, 0},  {1e-6, 4.2e-7, TFA_JOINT_FIXED, 1},
        {1e-6, 0.01, TFA_JOINT_REVOLUTE, 0}, {1e-6, 0.01, TFA_JOINT_FLOATING, 0},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        hand h;
        hand_arm(&h);
        const double inertia[6] = {1e-6, 1e-6, 1e-6, 1e-6, 0, 1e-6};
        const uint32_t camera = hand_link(&h, "camera", 0.012, 0, 0, 0);
        memcpy(h.link[camera].inertia, inertia, sizeof inertia);
        h.link[camera].last_digit = rows[k].last_digit;
        hand_joint(&h, "mount", rows[k].mount, 2, camera);
        for (uint32_t link = 2; link <= 3; link++)
            for (int e = 0; e < 6; e++)
                h.link[link].inertia[e] *= rows[k].others / (0.01 * h.link[link].mass);
        struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
        assert_int_equal(o.status, rows[k].loads ? TFA_OK : TFA_E_MODEL);
        expect(&o, rows[k].loads ? "inertia-rounded" : "inertia-not-positive",
               rows[k].loads ? "link 'camera': the principal moment -4.14214e-07 kg m^2 of its "
                               "inertia is rounding of the file and used as 0"
                             : "link 'camera': its inertia has the eigenvalue -4.14214e-07 kg m^2; "
                               "a body cannot have a negative one: correct <inertia>, or choose "
                               "inertia = repair");
        hand_forget(&o);
    }
}

TEST(test_unused)
{
    static const tfa_unused items[] = {{"velocity limits", 33, 7}, {"<gazebo>", 12, 3}};
    hand h;
    hand_arm(&h);
    h.joint[0].damping = 50;
    h.joint[1].damping = 2;
    h.joint[2].damping = 9; /* fixed */
    h.joint[1].friction = 0.25;
    h.d.unused = items;
    h.d.unused_count = 2;
    struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_COMMAND_LINE);
    expect(&o, "damping", "robot: damping: not used; in the file: 2; --damping uses it");
    assert_int_equal(hand_said(&o, "damping")->count, 2);
    assert_int_equal(hand_said(&o, "damping")->line, 100);
    expect(&o, "friction", "robot: friction: not used; in the file: 1; --friction uses it");
    assert_int_equal(hand_said(&o, "friction")->line, 101);
    const tfa_message *m = &o.report.messages[2];
    assert_string_equal(m->code, "not-used");
    assert_string_equal(m->entity, "velocity limits");
    assert_string_equal(m->text, "robot: velocity limits: not used; in the file: 7");
    assert_int_equal(m->count, 7);
    assert_int_equal(m->line, 33);
    assert_string_equal(m[1].entity, "<gazebo>");
    hand_forget(&o);
    const tfa_model_options lossy = {.damping = 1, .friction = 1};
    o = hand_outcome(&h, &lossy, TFA_SYNTAX_COMMAND_LINE);
    assert_false(hand_says(&o, "damping") || hand_says(&o, "friction"));
    hand_forget(&o);
}

/* Nine fingers that mimic the elbow and move nothing, and the messages of each interface about
 * them. */
TEST(test_words)
{
    static const char *const remedies[] = {"mimic = project", "--mimic=project", "mimic: project",
                                           "\"mimic\":\"project\"", "mimic='project'"};
    static const char *const floating[] = {"base = floating?", "--base=floating?",
                                           "base: floating?", "\"base\":\"floating\"?",
                                           "base='floating'?"};
    static const char *const names[] = {"f0", "f1", "f2", "f3", "f4", "f5"};
    hand h;
    hand_arm(&h);
    for (int k = 0; k < 6; k++) {
        tfa_joint *j =
            hand_joint(&h, names[k], TFA_JOINT_CONTINUOUS, 2, hand_link(&h, names[k], 0, 0, 0, 0));
        j->mimic = 1;
        j->multiplier = 1;
    }
    for (int syntax = 0; syntax <= TFA_SYNTAX_PYTHON; syntax++) {
        char text[200];
        struct outcome o = hand_outcome(&h, NULL, (tfa_option_syntax)syntax);
        assert_int_equal(o.status, TFA_E_NO_MASS);
        assert_int_equal(o.report.errors, 6);
        snprintf(text, sizeof text, "robot: not loaded: 6 errors of 1 kind; it loads with %s",
                 remedies[syntax]);
        expect(&o, "refused", text);
        assert_non_null(strstr(hand_said(&o, "massless-leaf")->text,
                               "; joints like it: 6 ('f0', 'f1', 'f2', 'f3', 'f4', ...)"));
        assert_non_null(strstr(hand_said(&o, "mimic-free")->text, remedies[syntax]));
        hand_forget(&o);
        const tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT};
        o = hand_outcome(&h, &project, (tfa_option_syntax)syntax);
        assert_int_equal(o.status, TFA_OK); /* the option is one with which it loads */
        assert_non_null(strstr(hand_said(&o, "base-mass")->text, floating[syntax]));
        hand_forget(&o);
    }
}

/* A report that is used again: what an earlier robot left is neither added to nor counted. */
TEST(test_report_again)
{
    hand h;
    make_massless_followers(&h);
    const tfa_model_options physical = {.inertia = TFA_INERTIA_STRICT_PHYSICAL};
    tfa_report report = {0};
    tfa_model *model = NULL;
    for (int k = 1; k <= 3; k++) {
        assert_int_equal(tfa_model_create(&h.d, &physical, &report, &model), TFA_E_MODEL);
        assert_int_equal(report.errors, k);
        const tfa_message *last = &report.messages[report.count - 1];
        assert_string_equal(last->text,
                            "robot: not loaded: 1 error; it loads with inertia = strict");
        assert_int_equal(last[-1].count, 1);
    }
    tfa_report_free(&report);
}

static const char *word(const void *list, size_t index)
{
    return ((const char *const *)list)[index];
}

TEST(test_misspelled)
{
    static const char *const syntax[] = {"inertial", "link", "joint", "axis"};
    static const struct {
        const char *wrong, *meant;
    } rows[] = {{"inertail", "inertial"},
                {"Inertial", "inertial"},
                {"LINK", "link"},
                {"lnk", "link"},
                {"lnik", "link"},
                {"iertal", "inertial"},
                {"jnt", NULL},
                {"linkage", NULL},
                {"sensor", NULL},
                {"", NULL},
                {"axs", "axis"},
                {"internal", NULL}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const char *meant = tfa_misspelled(rows[k].wrong, syntax, 4, word);
        if (!meant || !rows[k].meant) {
            if (meant != rows[k].meant)
                fail_msg("%s: %s", rows[k].wrong, meant ? meant : "nothing");
        } else
            assert_string_equal(meant, rows[k].meant);
    }
    assert_null(tfa_misspelled("link", syntax, 0, word));
}
