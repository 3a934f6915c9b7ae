/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scenes: what they leave out, and how they are refused. (That what is left is exact is tested
 * against the unreduced robot in tests/dynamics.)
 */
#include "hand.h"
#include "models.h"
#include "test.h"

/* Two arms on a rail: base -rail(p)- cart -turn- post, which carries
 * left: -l1- upper_l -l2(planar)- lower_l, right: -r1- upper_r -r2(floating)- ball,
 * and base carries -lamp- shade, base =stand= foot. */
enum { BASE, CART, POST, UPPER_L, LOWER_L, UPPER_R, BALL, SHADE, FOOT };
enum { RAIL, TURN, L1, L2, R1, R2, LAMP, STAND };

static void two_arms(hand *h)
{
    static const char *const names[] = {"base",    "cart", "post",  "upper_l", "lower_l",
                                        "upper_r", "ball", "shade", "foot"};
    hand_begin(h);
    for (uint32_t k = 0; k < 9; k++)
        hand_link(h, names[k], 1 + k, 0.1, 0.02 * k, 0);
    hand_joint(h, "rail", TFA_JOINT_PRISMATIC, BASE, CART)->xyz[2] = 0.1;
    hand_joint(h, "turn", TFA_JOINT_REVOLUTE, CART, POST)->xyz[2] = 0.2;
    h->joint[TURN].reduction = -50;
    hand_joint(h, "l1", TFA_JOINT_REVOLUTE, POST, UPPER_L)->xyz[1] = 0.2;
    hand_joint(h, "l2", TFA_JOINT_PLANAR, UPPER_L, LOWER_L)->xyz[0] = 0.3;
    hand_joint(h, "r1", TFA_JOINT_REVOLUTE, POST, UPPER_R)->xyz[1] = -0.2;
    hand_joint(h, "r2", TFA_JOINT_FLOATING, UPPER_R, BALL)->xyz[0] = 0.3;
    hand_joint(h, "lamp", TFA_JOINT_REVOLUTE, BASE, SHADE)->xyz[0] = 1;
    hand_joint(h, "stand", TFA_JOINT_FIXED, BASE, FOOT)->xyz[0] = -1;
}

static const char *const lower_l[] = {"lower_l"}, *const shade[] = {"shade"},
                         *const foot[] = {"foot"}, *const nobody[] = {"nobody"},
                         *const both[] = {"upper_l", "shade"};
static const tfa_lock no_lock[] = {{"nojoint", {0}}}, lock_fixed[] = {{"stand", {0}}},
                      twice[] = {{"turn", {1}}, {"turn", {1}}},
                      not_finite[] = {{"l2", {0, 0, (double)INFINITY}}},
                      long_quaternion[] = {{"r2", {0, 0, 0, 0, 0, 0.1, 1}}};
static const tfa_payload on_nobody[] = {{.link = "nobody", .mass = 1}},
                         negative[] = {{.link = "ball", .mass = -1}},
                         nan_com[] = {{.link = "ball", .mass = 1, .com = {0, (double)NAN, 0}}},
                         indefinite[] = {{.link = "ball", .inertia = {1, 2, 0, 1, 0, 1}}};
static const tfa_rotor no_rotor[] = {{"nojoint", 1}}, two_rotors[] = {{"turn", 1}, {"turn", 1}},
                       negative_rotor[] = {{"turn", -1}}, nan_rotor[] = {{"turn", (double)NAN}},
                       vast_rotor[] = {{"turn", 1e308}};

/* Each is refused with one error. */
static const struct refusal {
    tfa_scene scene;
    const char *says; /* code and text */
} refusals[] = {
    {{.root = "nobody"},
     "scene-root: link 'nobody': the root of the scene does not exist; name a link of the robot, "
     "or none for all of it; nearest: 'foot', 'base', 'post'"},
    {{.tips = nobody, .tip_count = 1},
     "scene-tip: link 'nobody': the tip of the scene does not exist; name a link of the robot; "
     "nearest: 'foot', 'base', 'post'"},
    {{.root = "upper_r", .tips = lower_l, .tip_count = 1},
     "scene-tip: link 'lower_l': the tip of the scene does not hang from its root; choose another "
     "tip or another root"},
    {{.locks = no_lock, .lock_count = 1},
     "scene-lock: joint 'nojoint': the scene locks it, but the robot has no such joint; correct "
     "the name; nearest: 'rail', 'turn', 'stand'"},
    {{.locks = lock_fixed, .lock_count = 1},
     "scene-lock: joint 'stand': the scene locks it, but it is fixed in the file; remove the lock"},
    {{.locks = twice, .lock_count = 2},
     "scene-lock: joint 'turn': the scene locks it twice; remove one of the locks"},
    {{.locks = not_finite, .lock_count = 1},
     "scene-lock: joint 'l2': the scene locks it at a coordinate that is not finite; correct it"},
    {{.locks = long_quaternion, .lock_count = 1},
     "scene-lock: joint 'r2': the scene locks it at a quaternion whose norm is off from 1 by more "
     "than 1e-3; correct it (x y z, then x y z w)"},
    {{.payloads = on_nobody, .payload_count = 1},
     "scene-payload: link 'nobody': the payload is on a link that does not exist; name a link of "
     "the robot; nearest: 'foot', 'base', 'post'"},
    {{.payloads = negative, .payload_count = 1},
     "scene-payload: link 'ball': the payload has a negative mass; correct it"},
    {{.payloads = nan_com, .payload_count = 1},
     "scene-payload: link 'ball': the payload has a number that is not finite; correct it"},
    {{.payloads = indefinite, .payload_count = 1},
     "scene-payload: link 'ball': the payload has an inertia with a negative eigenvalue, which no "
     "body has; correct it"},
    {{.rotors = no_rotor, .rotor_count = 1},
     "scene-rotor: joint 'nojoint': the scene has a rotor for it, but the robot has no such joint; "
     "correct the name; nearest: 'rail', 'turn', 'stand'"},
    {{.rotors = two_rotors, .rotor_count = 2},
     "scene-rotor: joint 'turn': the scene has two rotors for it; remove one"},
    {{.rotors = negative_rotor, .rotor_count = 1},
     "scene-rotor: joint 'turn': rotor inertia -1 kg m^2 and reduction -50 give no finite armature "
     "that is not negative; correct them"},
    {{.rotors = nan_rotor, .rotor_count = 1},
     "scene-rotor: joint 'turn': rotor inertia nan kg m^2 and reduction -50 give no finite "
     "armature that is not negative; correct them"},
    {{.rotors = vast_rotor, .rotor_count = 1},
     "scene-rotor: joint 'turn': rotor inertia 1e+308 kg m^2 and reduction -50 give no finite "
     "armature that is not negative; correct them"},
};

TEST(test_refused)
{
    for (size_t k = 0; k < sizeof refusals / sizeof *refusals; k++) {
        const struct refusal *row = &refusals[k];
        const tfa_model_options options = {.scene = &row->scene};
        tfa_report report = {0};
        tfa_model *m = NULL;
        char says[512];
        hand h;
        two_arms(&h);
        assert_int_equal(tfa_model_create(&h.d, &options, &report, &m), TFA_E_MODEL);
        assert_null(m);
        assert_int_equal(report.errors, 1);
        snprintf(says, sizeof says, "%s: %s", report.messages[0].code, report.messages[0].text);
        assert_string_equal(says, row->says);
        tfa_report_free(&report);
        assert_int_equal(tfa_model_size(&h.d, &options), 0);
    }
}

static tfa_model *model_of(const hand *h, const tfa_scene *scene, tfa_base base)
{
    const tfa_model_options options = {.base = base, .scene = scene};
    return hand_model(h, &options);
}

static void expect_joints(const tfa_model *m, const char *names)
{
    char have[200] = "";
    for (uint32_t k = 0; k < tfa_model_joint_count(m); k++) {
        strcat(have, k ? " " : "");
        strcat(have, tfa_model_joint(m, k).name);
    }
    assert_string_equal(have, names);
}

static tfa_declared_joint declared(const tfa_model *m, const char *name)
{
    for (uint32_t k = 0; k < tfa_model_declared_count(m); k++)
        if (strcmp(tfa_model_declared(m, k).name, name) == 0)
            return tfa_model_declared(m, k);
    fail_msg("joint %s is not declared", name);
    return (tfa_declared_joint){0};
}

/* The subtree of a link: its own frame is the world, and nothing else is in any list. */
TEST(test_root)
{
    hand h;
    two_arms(&h);
    const tfa_scene scene = {.root = "post"};
    tfa_model *m = model_of(&h, &scene, TFA_BASE_FIXED);
    expect_joints(m, "l1 l2 r1 r2");
    assert_int_equal(tfa_model_frame_count(m), 5);
    assert_string_equal(tfa_model_frame(m, 0).name, "post");
    assert_int_equal(tfa_model_frame(m, 0).body, -1);
    assert_int_equal(tfa_model_find_frame(m, "cart"), -1);
    assert_int_equal(declared(m, "rail").fate, TFA_FATE_ABSENT);
    assert_int_equal(declared(m, "turn").fate, TFA_FATE_ABSENT);
    assert_int_equal(declared(m, "stand").fate, TFA_FATE_ABSENT);
    assert_int_equal(declared(m, "l1").fate, TFA_FATE_MOVES);
    tfa_model_summary s = tfa_model_summarise(m);
    assert_int_equal(s.absent, 4);
    hand_near(s.total_mass, 3 + 4 + 5 + 6 + 7, 0);
    tfa_model_free(m);
    m = model_of(&h, &scene, TFA_BASE_FLOATING);
    assert_int_equal(tfa_model_summarise(m).bodies, 5);
    assert_int_equal(tfa_model_frame(m, 0).body, 0);
    assert_string_equal(tfa_model_body_name(m, 0), "post");
    tfa_model_free(m);
}

/* Trees without a tip go; the joint that ties two together may be locked; a floating base keeps
 * them all. */
TEST(test_tips)
{
    static const tfa_lock locks[] = {{"rail", {0.5}}, {"turn", {0.3}}};
    static const struct {
        tfa_scene scene;
        tfa_base base;
        const char *joints;
    } rows[] = {
        {{.tips = lower_l, .tip_count = 1}, TFA_BASE_FIXED, "rail turn l1 l2 r1 r2"},
        {{.tips = shade, .tip_count = 1}, TFA_BASE_FIXED, "lamp"},
        {{.tips = foot, .tip_count = 1}, TFA_BASE_FIXED, ""},
        {{.tips = shade, .tip_count = 1}, TFA_BASE_FLOATING, "rail turn l1 l2 r1 r2 lamp"},
        {{.tips = both, .tip_count = 2, .locks = locks, .lock_count = 2},
         TFA_BASE_FIXED,
         "l1 l2 lamp"},
    };
    hand h;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        two_arms(&h);
        tfa_model *m = model_of(&h, &rows[k].scene, rows[k].base);
        expect_joints(m, rows[k].joints);
        assert_true(tfa_model_find_frame(m, "foot") >= 0);
        tfa_model_free(m);
    }
}

/* A mimic couples two trees: they stay or go together. */
TEST(test_coupled_trees)
{
    hand h;
    two_arms(&h);
    h.joint[LAMP].mimic = R1;
    h.joint[LAMP].multiplier = 2;
    const tfa_scene scene = {.tips = shade, .tip_count = 1};
    tfa_model_options options = {.scene = &scene, .mimic = TFA_MIMIC_PROJECT};
    tfa_model *m = hand_model(&h, &options);
    expect_joints(m, "rail turn l1 l2 r1 r2");
    assert_int_equal(declared(m, "lamp").fate, TFA_FATE_FOLLOWS);
    tfa_model_free(m);
    options.mimic = TFA_MIMIC_LOCK;
    m = hand_model(&h, &options);
    expect_joints(m, "");
    tfa_model_free(m);
}

/* A locked joint leaves every list; the poses are those of the unlocked robot at that q. */
TEST(test_locks)
{
    static const tfa_lock locks[] = {{"rail", {0.5}},
                                     {"turn", {20.3}},
                                     {"l2", {0.1, -0.2, 0.7}},
                                     {"r2", {0.3, 0.1, 0.2, 0.1, 0.7, -0.1, 0.7}}};
    const tfa_scene scene = {.locks = locks, .lock_count = 4};
    hand h;
    two_arms(&h);
    tfa_model *m = model_of(&h, &scene, TFA_BASE_FIXED),
              *whole = model_of(&h, NULL, TFA_BASE_FIXED);
    expect_joints(m, "l1 r1 lamp");
    assert_int_equal(tfa_model_summarise(m).locked, 4);
    assert_int_equal(tfa_model_declared(m, 0).fate, TFA_FATE_LOCKED);
    assert_int_equal(tfa_model_declared(m, 0).body, -1);
    hand_near(tfa_model_summarise(m).total_mass, tfa_model_summarise(whole).total_mass, 0);
    const double q[3] = {0.4, -0.6, 0.2};
    const double all[] = {0.5, 20.3, 0.4, 0.1, -0.2, 0.7, -0.6, 0.3,
                          0.1, 0.2,  0.1, 0.7, -0.1, 0.7, 0.2};
    double a[7], b[7], lambda[36];
    for (uint32_t link = 0; link < h.d.link_count; link++) {
        tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA,
                         .flags = TFA_WANT_POSES,
                         .count = 1,
                         .tip_count = 1,
                         .tips = {link},
                         .q = q};
        tfa_reply reply = {.poses = a, .lambda_inv = lambda};
        tfa_workspace *w = workspace_for(m, NULL);
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        tfa_workspace_free(w);
        r.q = all;
        reply.poses = b;
        w = workspace_for(whole, NULL);
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        tfa_workspace_free(w);
        for (int k = 0; k < 7; k++)
            hand_near(a[k], b[k], 1e-15);
    }
    tfa_model_free(whole);
    tfa_model_free(m);
}

/* What a scene may say of joints and links that its root leaves out. */
TEST(test_absent)
{
    static const tfa_lock lamp[] = {{"lamp", {1}}};
    static const tfa_payload on_cart[] = {{.link = "cart", .mass = 1}};
    const tfa_scene scene = {
        .root = "post", .locks = lamp, .lock_count = 1, .payloads = on_cart, .payload_count = 1};
    const tfa_model_options options = {.scene = &scene};
    hand h;
    two_arms(&h);
    tfa_report report = {0};
    tfa_model *m = NULL;
    assert_int_equal(tfa_model_create(&h.d, &options, &report, &m), TFA_OK);
    assert_int_equal(report.count, 3);
    assert_string_equal(report.messages[2].code, "base-mass");
    assert_int_equal(report.warnings, 1);
    assert_string_equal(report.messages[0].text,
                        "link 'cart': it is not part of the scene, its payload is left out; choose "
                        "another root, or remove the payload");
    assert_string_equal(report.messages[1].text,
                        "joint 'lamp': it is not part of the scene, its lock does nothing; remove "
                        "it");
    hand_near(tfa_model_summarise(m).total_mass, 25, 0);
    tfa_report_free(&report);
    tfa_model_free(m);
}

/* Trees that the file interleaves stand one after the other inside, and as declared outside. */
TEST(test_interleaved_trees)
{
    hand h;
    hand_begin(&h);
    static const char *const names[] = {"base", "a1", "b1", "a2", "b2", "a3"};
    for (uint32_t k = 0; k < 6; k++)
        hand_link(&h, names[k], 1, 0.1, 0, 0);
    hand_joint(&h, "ja1", TFA_JOINT_REVOLUTE, 0, 1);
    hand_joint(&h, "jb1", TFA_JOINT_PLANAR, 0, 2);
    hand_joint(&h, "ja2", TFA_JOINT_PRISMATIC, 1, 3);
    hand_joint(&h, "jb2", TFA_JOINT_REVOLUTE, 2, 4);
    hand_joint(&h, "ja3", TFA_JOINT_REVOLUTE, 3, 5);
    tfa_model *m = hand_model(&h, NULL);
    expect_joints(m, "ja1 jb1 ja2 jb2 ja3");
    static const uint32_t body[] = {0, 3, 1, 4, 2}, q[] = {0, 1, 4, 5, 6};
    static const int32_t parent[] = {-1, 0, 1, -1, 3};
    for (uint32_t k = 0; k < 5; k++) {
        tfa_joint_info j = tfa_model_joint(m, k);
        assert_int_equal(j.body, body[k]);
        assert_int_equal(j.q_index, q[k]);
        assert_int_equal(tfa_model_body_parent(m, k), parent[k]);
        assert_int_equal(tfa_model_find_frame(m, names[k + 1]), k + 1);
        assert_int_equal(tfa_model_frame(m, k + 1).body, body[k]);
    }
    tfa_model_free(m);
}
