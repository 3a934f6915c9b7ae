/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the policies for inertias, massless parts, mimics and damping make of a robot.
 */
#include "hand.h"
#include "mistakes.h"
#include "model/model.h"
#include "test.h"

TEST(test_inertia_rows)
{
    static const struct {
        uint32_t link;
        double ixy, ixx; /* 0: as it was */
        tfa_inertia_policy policy;
        int status;
        tfa_severity severity;
        const char *code, *text;
    } rows[] = {
        {UPPER, 0.03, 0, TFA_INERTIA_STRICT, TFA_E_MODEL, TFA_ERROR, "inertia-not-positive",
         "link 'upper': its inertia has the eigenvalue -0.01 kg m^2; a body cannot have a negative "
         "one: correct <inertia>, or choose inertia = repair"},
        {UPPER, 0.03, 0, TFA_INERTIA_STRICT_PHYSICAL, TFA_E_MODEL, TFA_ERROR,
         "inertia-not-positive",
         "link 'upper': its inertia has the eigenvalue -0.01 kg m^2; a body cannot have a negative "
         "one: correct <inertia>, or choose inertia = repair"},
        {UPPER, 0.03, 0, TFA_INERTIA_WARN, TFA_OK, TFA_WARNING, "inertia-not-positive",
         "link 'upper': its inertia has the eigenvalue -0.01 kg m^2; a body cannot have a negative "
         "one: correct <inertia>"},
        {UPPER, 0.03, 0, TFA_INERTIA_REPAIR, TFA_OK, TFA_WARNING, "inertia-repaired",
         "link 'upper': its inertia has the principal moments -0.01 0.02 0.05 kg m^2; used as 0 "
         "0.02 0.05: correct <inertia>"},
        {BASE, 0.06, 0, TFA_INERTIA_STRICT, TFA_OK, TFA_WARNING, "inertia-not-positive",
         "link 'base': its inertia has the eigenvalue -0.02 kg m^2; a body cannot have a negative "
         "one: correct <inertia>"},
        {BASE, 0.06, 0, TFA_INERTIA_REPAIR, TFA_OK, TFA_WARNING, "inertia-not-positive",
         "link 'base': its inertia has the eigenvalue -0.02 kg m^2; a body cannot have a negative "
         "one: correct <inertia>"},
        {UPPER, 0, 0.05, TFA_INERTIA_STRICT_PHYSICAL, TFA_E_MODEL, TFA_ERROR, "triangle",
         "link 'upper': its principal moments of inertia are 0.02 0.02 0.05 kg m^2; in a body the "
         "largest does not exceed the sum of the others: correct <inertia>, or choose inertia = "
         "strict"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        hand h;
        hand_arm(&h);
        double *I = h.link[rows[k].link].inertia;
        I[1] = rows[k].ixy;
        I[0] = rows[k].ixx > 0 ? rows[k].ixx : I[0];
        const tfa_model_options options = {.inertia = rows[k].policy};
        struct outcome o = hand_outcome(&h, &options, TFA_SYNTAX_C);
        const tfa_message *m = hand_said(&o, rows[k].code);
        assert_int_equal(o.status, rows[k].status);
        assert_int_equal(m->severity, rows[k].severity);
        assert_int_equal(m->line, 10 + rows[k].link);
        assert_string_equal(m->text, rows[k].text);
        assert_int_equal(o.report.errors + o.report.warnings, 1);
        hand_forget(&o);
    }
}

/* What no policy has anything to say about: a broken triangle when nobody asked, or on the base;
 * a deficit that the rounding of a file explains. */
TEST(test_inertia_silent)
{
    hand h;
    hand_arm(&h);
    h.link[BASE].inertia[0] = 9;
    const tfa_model_options physical = {.inertia = TFA_INERTIA_STRICT_PHYSICAL};
    struct outcome o = hand_outcome(&h, &physical, TFA_SYNTAX_C);
    assert_int_equal(o.report.errors + o.report.warnings, 0);
    hand_forget(&o);
    h.link[UPPER].inertia[0] = 9;
    o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
    assert_int_equal(o.report.errors + o.report.warnings, 0);
    hand_forget(&o);
    h.link[UPPER].inertia[3] = -1e-7;
    o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
    assert_int_equal(o.report.errors + o.report.warnings, 0);
    hand_forget(&o);
}

/* Clipping keeps the eigenvectors: 0.05 along (1, 1, 0), 0.02 along z, 0 along (1, -1, 0). */
TEST(test_repaired)
{
    hand bad, good;
    hand_arm(&bad);
    hand_arm(&good);
    bad.link[UPPER].inertia[1] = 0.03;
    const double clipped[6] = {0.025, 0.025, 0, 0.025, 0, 0.02};
    memcpy(good.link[UPPER].inertia, clipped, sizeof clipped);
    const tfa_model_options repair = {.inertia = TFA_INERTIA_REPAIR};
    struct outcome a = hand_outcome(&bad, &repair, TFA_SYNTAX_C),
                   b = hand_outcome(&good, NULL, TFA_SYNTAX_C);
    assert_memory_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    hand_forget(&a);
    hand_forget(&b);
}

TEST(test_massless_leaves)
{
    hand h;
    hand_arm(&h);
    hand_link(&h, "pointer", 0, 0, 0, 0);
    hand_link(&h, "needle", 0, 0, 0, 0);
    hand_link(&h, "ball", 0, 0, 0, 0);
    hand_joint(&h, "swing", TFA_JOINT_CONTINUOUS, TOOL, 4);
    hand_joint(&h, "twist", TFA_JOINT_CONTINUOUS, 4, 5);
    hand_joint(&h, "fly", TFA_JOINT_FLOATING, TOOL, 6)->xyz[0] = 0.2;
    const tfa_model_options lock = {.lock_massless_leaves = 1};
    struct outcome o = hand_outcome(&h, &lock, TFA_SYNTAX_C);
    assert_int_equal(o.report.warnings, 3);
    assert_string_equal(hand_said(&o, "massless-leaf-locked")->text,
                        "joint 'swing': nothing with mass moves with it; locked at 0; joints like "
                        "it: 3 ('swing', 'twist', 'fly')");
    assert_int_equal(hand_said(&o, "massless-leaf-locked")->line, 103);
    assert_int_equal(hand_said(&o, "massless-leaf-locked")->count, 3);
    assert_int_equal(tfa_model_summarise(o.model).bodies, 2);
    assert_int_equal(tfa_model_summarise(o.model).locked, 3);
    assert_int_equal(tfa_model_frame(o.model, 6).body, 1);
    hand_forget(&o);
    h.joint[4].armature = 0.01; /* twist has a rotor: it moves, swing does not */
    o = hand_outcome(&h, &lock, TFA_SYNTAX_C);
    assert_int_equal(o.report.warnings, 2);
    assert_int_equal(tfa_model_joint_count(o.model), 3);
    assert_string_equal(tfa_model_joint(o.model, 2).name, "twist");
    hand_forget(&o);
}

static void remove_mass(tfa_link *link)
{
    link->mass = 0;
    memset(link->inertia, 0, sizeof link->inertia);
}

/* A floating base without mass must be held by two joints, or by one with armature. */
TEST(test_massless_root)
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    hand h;
    hand_arm(&h);
    remove_mass(&h.link[BASE]);
    struct outcome o = hand_outcome(&h, &floating, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_NO_MASS);
    assert_int_equal(hand_said(&o, "massless-root")->line, 10);
    hand_forget(&o);
    h.joint[SHOULDER].armature = 0.1;
    o = hand_outcome(&h, &floating, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    hand_forget(&o);
    h.joint[SHOULDER].armature = 0;
    hand_joint(&h, "leg", TFA_JOINT_REVOLUTE, BASE, hand_link(&h, "leg", 1, 0, 0, 0.1))->axis[0] =
        1;
    o = hand_outcome(&h, &floating, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    hand_forget(&o);
    h.joint[SHOULDER].type = TFA_JOINT_FIXED; /* descend through fixed joints */
    o = hand_outcome(&h, &floating, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    assert_int_equal(tfa_model_summarise(o.model).bodies, 3);
    hand_forget(&o);
}

static tfa_joint *follow(tfa_joint *j, int32_t leader, double multiplier, double offset)
{
    j->mimic = leader;
    j->multiplier = multiplier;
    j->offset = offset;
    return j;
}

/* The arm with a finger on the tool; finger follows elbow, which follows shoulder. */
static void make_followers(hand *h)
{
    hand_arm(h);
    uint32_t finger = hand_link(h, "finger", 0.1, 0.02, 0, 0);
    follow(hand_joint(h, "finger", TFA_JOINT_PRISMATIC, TOOL, finger), ELBOW, 0.5, 0.125);
    follow(&h->joint[ELBOW], SHOULDER, -2, 0.25);
}

TEST(test_mimic_free)
{
    hand h;
    make_followers(&h);
    struct outcome o = hand_outcome(&h, NULL, TFA_SYNTAX_C);
    const tfa_message *m = hand_said(&o, "mimic-free");
    assert_int_equal(m->severity, TFA_WARNING);
    assert_string_equal(m->text,
                        "robot: joints that mimic others move on their own here: 2; choose "
                        "mimic = project to have them follow, or mimic = lock");
    assert_int_equal(tfa_model_v_count(o.model), 3);
    hand_forget(&o);
}

TEST(test_mimic_project)
{
    const tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT};
    hand h;
    make_followers(&h);
    struct outcome o = hand_outcome(&h, &project, TFA_SYNTAX_C);
    assert_int_equal(o.report.errors + o.report.warnings, 0);
    assert_int_equal(tfa_model_q_count(o.model), 1);
    assert_int_equal(tfa_model_v_count(o.model), 1);
    assert_int_equal(tfa_model_joint_count(o.model), 1);
    tfa_model_summary s = tfa_model_summarise(o.model);
    assert_int_equal(s.bodies, 3);
    assert_int_equal(s.follows, 2);
    assert_int_equal(s.mimics, 2);
    tfa_declared_joint elbow = tfa_model_declared(o.model, 1),
                       finger = tfa_model_declared(o.model, 3);
    assert_int_equal(elbow.fate, TFA_FATE_FOLLOWS);
    assert_int_equal(elbow.leader, 0);
    assert_true(elbow.multiplier == -2 && elbow.offset == 0.25);
    assert_int_equal(finger.joint, -1);
    assert_int_equal(finger.leader, 0);
    assert_true(finger.multiplier == -1 && finger.offset == 0.25);
    hand_forget(&o);
}

/* A leader that stands makes followers stand where it puts them. */
TEST(test_mimic_stands)
{
    static const tfa_lock shoulder[] = {{"shoulder", {0.75}}};
    static const tfa_lock where_it_is[] = {{"shoulder", {0.75}}, {"elbow", {-1.25}}};
    static const tfa_lock all[] = {{"shoulder", {0.75}}, {"elbow", {-1.25}}, {"finger", {-0.5}}};
    const tfa_scene one = {.locks = shoulder, .lock_count = 1},
                    two = {.locks = where_it_is, .lock_count = 2},
                    three = {.locks = all, .lock_count = 3};
    const tfa_model_options rows[] = {{.mimic = TFA_MIMIC_PROJECT, .scene = &one},
                                      {.mimic = TFA_MIMIC_PROJECT, .scene = &two},
                                      {.mimic = TFA_MIMIC_LOCK, .scene = &one},
                                      {.mimic = TFA_MIMIC_FREE, .scene = &three}};
    hand h;
    make_followers(&h);
    uint8_t hash[32];
    for (int k = 0; k < 4; k++) {
        struct outcome o = hand_outcome(&h, &rows[k], TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_OK);
        assert_int_equal(tfa_model_summarise(o.model).bodies, 0);
        assert_int_equal(tfa_model_summarise(o.model).locked, 3);
        if (k > 0)
            assert_memory_equal(hash, tfa_model_hash(o.model), 32);
        memcpy(hash, tfa_model_hash(o.model), 32);
        hand_forget(&o);
    }
}

TEST(test_mimic_lock)
{
    static const tfa_lock locks[] = {{"elbow", {0.25}}, {"finger", {0.25}}};
    const tfa_scene scene = {.locks = locks, .lock_count = 2};
    const tfa_model_options lock = {.mimic = TFA_MIMIC_LOCK}, by_hand = {.scene = &scene};
    hand h;
    make_followers(&h);
    struct outcome a = hand_outcome(&h, &lock, TFA_SYNTAX_C),
                   b = hand_outcome(&h, &by_hand, TFA_SYNTAX_C);
    assert_int_equal(tfa_model_v_count(a.model), 1);
    assert_memory_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    hand_forget(&a);
    hand_forget(&b);
}

TEST(test_mimic_refused)
{
    static const tfa_lock elbow[] = {{"elbow", {0.5}}},
                          both[] = {{"shoulder", {0.75}}, {"elbow", {0.5}}};
    static const tfa_scene follower = {.locks = elbow, .lock_count = 1},
                           contradiction = {.locks = both, .lock_count = 2},
                           outside = {.root = "upper"},
                           outside_locked = {.root = "upper", .locks = elbow, .lock_count = 1};
    static const struct {
        const tfa_scene *scene;
        int32_t mimic; /* of shoulder */
        tfa_joint_type type;
        const char *code, *text;
    } rows[] = {
        {&follower, -1, TFA_JOINT_REVOLUTE, "scene-lock",
         "joint 'elbow': the scene locks it, but it follows joint 'shoulder', which is not locked; "
         "lock that one"},
        {&contradiction, -1, TFA_JOINT_REVOLUTE, "scene-lock",
         "joint 'elbow': the scene locks it at 0.5, but following joint 'shoulder' it stands at "
         "-1.25; remove its lock"},
        {NULL, 3, TFA_JOINT_REVOLUTE, "mimic-loop",
         "joint 'finger': in the end it mimics itself; let one of the joints move by itself"},
        {NULL, 12, TFA_JOINT_REVOLUTE, "mimic-unknown",
         "joint 'shoulder': mimics a joint that does not exist; correct its name or index, or let "
         "it "
         "move by itself"},
        {NULL, TFA_MIMIC_UNKNOWN, TFA_JOINT_REVOLUTE, "mimic-unknown",
         "joint 'shoulder': mimics a joint that does not exist; correct its name or index, or let "
         "it "
         "move by itself"},
        {NULL, -1, TFA_JOINT_FLOATING, "mimic-type",
         "joint 'elbow': mimics a joint that has no single coordinate; follow a revolute, "
         "continuous or prismatic joint"},
    };
    hand h;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        make_followers(&h);
        follow(&h.joint[SHOULDER], rows[k].mimic, 1, 0);
        h.joint[SHOULDER].type = rows[k].type;
        const tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT, .scene = rows[k].scene};
        struct outcome o = hand_outcome(&h, &project, TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_E_MODEL);
        assert_string_equal(hand_said(&o, rows[k].code)->text, rows[k].text);
        hand_forget(&o);
    }
    make_followers(&h);
    tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT, .scene = &outside};
    struct outcome o = hand_outcome(&h, &project, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_MODEL);
    assert_string_equal(o.report.messages[0].text,
                        "joint 'elbow': it follows joint 'shoulder', which does not hang from the "
                        "root of the scene; lock it, or choose another root");
    hand_forget(&o);
    project.scene = &outside_locked; /* that remedy helps, and the finger follows the elbow */
    o = hand_outcome(&h, &project, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_OK);
    assert_int_equal(tfa_model_summarise(o.model).locked, 2);
    hand_forget(&o);
}

/* Mass is asked of the freedom, not of each joint that moves with it. */
TEST(test_massless_followers)
{
    tfa_model_options project = {.mimic = TFA_MIMIC_PROJECT};
    hand h;
    for (int massless_leader = 0; massless_leader < 2; massless_leader++) {
        hand_arm(&h);
        uint32_t dial = hand_link(&h, "dial", 0, 0, 0, 0);
        hand_joint(&h, "dial", TFA_JOINT_CONTINUOUS, BASE, dial);
        follow(&h.joint[massless_leader ? SHOULDER : 3], massless_leader ? 3 : SHOULDER, 10, 0);
        struct outcome o = hand_outcome(&h, &project, TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_OK);
        assert_int_equal(tfa_model_summarise(o.model).bodies, 3);
        assert_int_equal(tfa_model_v_count(o.model), 2);
        assert_int_equal(o.model->massless_followers,
                         1); /* M is regular only after the projection */
        hand_forget(&o);
    }
    massless_leaf(&h);
    h.joint[4].parent = 4; /* swing hangs from the dial and leads a second dial: no mass at all */
    h.joint[4].child = 5;
    h.d.link_count = 5;
    hand_link(&h, "pointer", 0, 0, 0, 0);
    hand_joint(&h, "echo", TFA_JOINT_CONTINUOUS, TOOL, hand_link(&h, "echo", 0, 0, 0, 0));
    follow(&h.joint[5], 4, 3, 0.5);
    struct outcome o = hand_outcome(&h, &project, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_NO_MASS);
    assert_int_equal(o.report.errors, 1);
    hand_forget(&o);
    project.lock_massless_leaves = 1;
    o = hand_outcome(&h, &project, TFA_SYNTAX_C);
    assert_int_equal(tfa_model_summarise(o.model).locked, 2);
    hand_forget(&o);
}

/* Of damping or friction: read with its option, part of the hash only then. */
static void check_loss(size_t member, const tfa_model_options *used, const char *bad)
{
    hand h;
    hand_arm(&h);
    double *const loss = (double *)(void *)((char *)&h.joint[ELBOW] + member);
    *loss = 0.5;
    struct outcome a = hand_outcome(&h, NULL, TFA_SYNTAX_C),
                   b = hand_outcome(&h, used, TFA_SYNTAX_C);
    assert_memory_not_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    const tfa_joint_info elbow = tfa_model_joint(b.model, ELBOW);
    hand_forget(&b);
    assert_true(elbow.damping == (used->damping ? 0.5 : 0));
    assert_true(elbow.friction == (used->friction ? 0.5 : 0));
    *loss = 0.25;
    b = hand_outcome(&h, NULL, TFA_SYNTAX_C);
    assert_memory_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    hand_forget(&b);
    hand_forget(&a);
    *loss = (double)NAN;
    b = hand_outcome(&h, used, TFA_SYNTAX_C);
    assert_string_equal(hand_said(&b, "bad-number")->text, bad);
    hand_forget(&b);
}

TEST(test_damping_and_friction)
{
    const tfa_model_options damped = {.damping = 1}, rubbed = {.friction = 1};
    check_loss(offsetof(tfa_joint, damping), &damped,
               "joint 'elbow': its damping is not finite; correct it");
    check_loss(offsetof(tfa_joint, friction), &rubbed,
               "joint 'elbow': its friction is not finite; correct it");
}

TEST(test_friction_velocity)
{
    static const double bad[] = {-0.01, 1e-10, (double)NAN, (double)INFINITY};
    hand h;
    hand_arm(&h);
    h.joint[ELBOW].friction = 0.5;
    tfa_model_options options = {.friction = 1};
    struct outcome a = hand_outcome(&h, &options, TFA_SYNTAX_C), b;
    options.friction_velocity = TFA_FRICTION_VELOCITY;
    b = hand_outcome(&h, &options, TFA_SYNTAX_C);
    assert_memory_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    hand_forget(&b);
    options.friction_velocity = TFA_FRICTION_VELOCITY_MIN;
    b = hand_outcome(&h, &options, TFA_SYNTAX_C);
    assert_memory_not_equal(tfa_model_hash(a.model), tfa_model_hash(b.model), 32);
    hand_forget(&b);
    hand_forget(&a);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        options.friction_velocity = bad[k];
        b = hand_outcome(&h, &options, TFA_SYNTAX_C);
        assert_int_equal(b.status, TFA_E_VALUE);
        assert_non_null(hand_said(&b, "bad-friction-velocity"));
        hand_forget(&b);
    }
}
