/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Four mistakes that others have shipped in model reduction, each with a robot made by hand and the
 * numbers it must have: mass counted twice, armature lost, a massless link that moves the centre of
 * mass, structural links dropped. Whatever leaves a robot smaller must pass: fixed joints, locks of
 * a scene, followers, fused bodies, payloads.
 */
#include "hand.h"
#include "models.h"
#include "test.h"

#define G 9.80665
#define MOST 12

/* What a model says of one configuration at rest: M, the torques that hold it against gravity, and
 * qdd under a torque of 1 on the last joint in weightlessness. */
struct facts {
    tfa_model_summary s;
    double M[MOST * MOST], tau[MOST], base[6], qdd[MOST];
    uint32_t n;
};

static struct facts ask_model(const tfa_model *m, const double *q)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1}, weightless[3] = {0, 0, 0};
    struct facts f = {.s = tfa_model_summarise(m)};
    double tau[MOST] = {0};
    const uint32_t nv = tfa_model_v_count(m);
    f.n = tfa_model_base_freedoms(m) + nv;
    assert_true(f.n <= MOST);
    tau[nv ? nv - 1 : 0] = 1;
    tfa_workspace *w = workspace_for(m, NULL);
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1, .q = q, .base_pose = pose, .tau = tau};
    tfa_reply reply = {.mass_matrix = f.M, .tau = f.tau, .base_wrench = f.base, .qdd = f.qdd};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.gravity = weightless;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
    return f;
}

static struct facts ask(const hand *h, const tfa_model_options *options, const double *q)
{
    tfa_model *m = hand_model(h, options);
    struct facts f = ask_model(m, q);
    tfa_model_free(m);
    return f;
}

/* ---- mass double-counted where a fixed joint lies between moving joints ---- */

/* base -shoulder- upper =mount= bracket -elbow- lower =flange= tool: 16.79 kg with a bracket of
 * 0.65 kg, 17.44 kg where it counts twice. */
static void make_bracket(hand *h)
{
    hand_begin(h);
    hand_link(h, "base", 5, 0, 0, 0.1);
    hand_link(h, "upper", 4.8, 0.2, 0, 0);
    hand_link(h, "bracket", 0.65, 0.05, 0, 0);
    hand_link(h, "lower", 3.84, 0.15, 0, 0);
    hand_link(h, "tool", 2.5, 0, 0, 0.05);
    hand_joint(h, "shoulder", TFA_JOINT_REVOLUTE, 0, 1)->xyz[2] = 0.3;
    hand_joint(h, "mount", TFA_JOINT_FIXED, 1, 2)->xyz[0] = 0.4;
    hand_joint(h, "elbow", TFA_JOINT_REVOLUTE, 2, 3)->xyz[0] = 0.1;
    hand_joint(h, "flange", TFA_JOINT_FIXED, 3, 4)->xyz[0] = 0.3;
}

static void check_bracket(const hand *h, const tfa_scene *scene, double moment_upper)
{
    const double q[2] = {0, 0}, outer = 3.84 * 0.65 + 2.5 * 0.8;
    for (int base = 0; base < 2; base++) {
        const tfa_model_options options = {.base = base ? TFA_BASE_FLOATING : TFA_BASE_FIXED,
                                           .scene = scene};
        struct facts f = ask(h, &options, q);
        hand_near(f.s.total_mass, 16.79, 1e-14);
        hand_near(f.s.moving_mass, base ? 16.79 : 11.79, 1e-14);
        hand_near(f.s.com[0] * 16.79, moment_upper + outer, 1e-14);
        hand_near(f.s.com[1], 0, 1e-15);
        hand_near(f.tau[0], -G * (moment_upper + outer), 1e-13);
        hand_near(f.tau[1], -G * (3.84 * 0.15 + 2.5 * 0.3), 1e-13);
        for (uint32_t k = 0; base && k < 3; k++)
            hand_near(f.M[k * f.n + k], 16.79, 1e-14);
        if (base)
            hand_near(f.base[2], 16.79 * G, 1e-12);
    }
}

TEST(mass_counts_once)
{
    hand h;
    make_bracket(&h);
    check_bracket(&h, NULL, 4.8 * 0.2 + 0.65 * 0.45);
    /* the mount moves, but the scene locks it: at 0, and turned over (about z, in line) */
    tfa_lock lock = {.joint = "mount"};
    const tfa_scene scene = {.locks = &lock, .lock_count = 1};
    h.joint[1].type = TFA_JOINT_REVOLUTE;
    check_bracket(&h, &scene, 4.8 * 0.2 + 0.65 * 0.45);
    h.joint[1].type = TFA_JOINT_PRISMATIC;
    h.joint[1].axis[0] = 1;
    h.joint[1].axis[1] = 0;
    h.joint[1].xyz[0] = 0.25;
    lock.q[0] = 0.15;
    check_bracket(&h, &scene, 4.8 * 0.2 + 0.65 * 0.45);
    /* the bracket's mass comes as a payload of an empty bracket */
    make_bracket(&h);
    h.link[2].mass = 0;
    memset(h.link[2].inertia, 0, sizeof h.link[2].inertia);
    const tfa_payload payload = {.link = "bracket",
                                 .mass = 0.65,
                                 .com = {0.05, 0, 0},
                                 .inertia = {0.0065, 0, 0, 0.0065, 0, 0.0065}};
    const tfa_scene loaded = {.payloads = &payload, .payload_count = 1};
    check_bracket(&h, &loaded, 4.8 * 0.2 + 0.65 * 0.45);
}

/* ---- armature lost in the reduced model ---- */

#define A1 0.7  /* of the shoulder */
#define A2 0.11 /* of the elbow */

/* Moment of inertia about y of a link of hand.h at distance d from the axis */
static double about(double mass, double d)
{
    return mass * (0.01 + d * d);
}

static void make_with_armature(hand *h)
{
    make_bracket(h);
    h->joint[0].armature = A1;
    h->joint[2].armature = A2;
}

/* One joint is left: its M is `inertia`, and a torque of 1 turns it with 1 / inertia. */
static void check_single(const struct facts *f, double inertia)
{
    assert_int_equal(f->n, 1);
    hand_near(f->M[0], inertia, 1e-14);
    hand_near(f->qdd[0], 1 / inertia, 1e-14);
}

TEST(armature_stays)
{
    hand h;
    make_with_armature(&h);
    const double q[2] = {0.3, 0};
    const double lower = about(3.84, 0.15) + about(2.5, hypot(0.3, 0.05));
    const double outer = about(3.84, 0.65) + about(2.5, hypot(0.8, 0.05));
    const double upper = about(4.8, 0.2) + about(0.65, 0.45);
    struct facts f = ask(&h, NULL, q);
    hand_near(f.M[0], upper + outer + A1, 1e-13);
    hand_near(f.M[3], lower + A2, 1e-14);
    const double coupling = f.M[1];

    /* locked: the joint that is left keeps its own, and gets nothing of the other's */
    tfa_lock lock = {.joint = "shoulder", .q = {0.5}};
    const tfa_scene scene = {.locks = &lock, .lock_count = 1};
    const tfa_model_options locked = {.scene = &scene};
    f = ask(&h, &locked, q);
    check_single(&f, lower + A2);
    lock = (tfa_lock){.joint = "elbow", .q = {0}};
    f = ask(&h, &locked, q);
    check_single(&f, upper + outer + A1);

    /* projected: M = M11 + 2 r M12 + r^2 M22, both rotors in it */
    h.joint[2].mimic = 0;
    h.joint[2].multiplier = -1.5;
    h.joint[2].offset = 1.5 * q[0]; /* the elbow stands at 0 */
    const tfa_model_options projected = {.mimic = TFA_MIMIC_PROJECT};
    f = ask(&h, &projected, q);
    check_single(&f, upper + outer + A1 - 3 * coupling + 2.25 * (lower + A2));
}

TEST(armature_stays_when_fused)
{
    hand h;
    make_with_armature(&h);
    for (int k = 1; k <= 2; k++) {
        h.link[k].mass = 0;
        memset(h.link[k].inertia, 0, sizeof h.link[k].inertia);
    }
    const double q[2] = {0.3, 0};
    const double lower = about(3.84, 0.15) + about(2.5, hypot(0.3, 0.05));
    const double outer = about(3.84, 0.65) + about(2.5, hypot(0.8, 0.05));
    struct facts f = ask(&h, NULL, q);
    assert_int_equal(f.s.fused, 2);
    assert_int_equal(f.s.bodies, 1);
    hand_near(f.M[0], outer + A1, 1e-13);
    hand_near(f.M[3], lower + A2, 1e-14);
    hand_near(f.M[0] * f.qdd[0] + f.M[1] * f.qdd[1], 0, 1e-14);
    hand_near(f.M[2] * f.qdd[0] + f.M[3] * f.qdd[1], 1, 1e-14);
}

/* A payload, given later, and the rotors of the file besides. */
TEST(armature_stays_when_loaded)
{
    hand h;
    make_with_armature(&h);
    h.joint[2].rotor = 0.25;
    const double q[2] = {0.3, 0};
    const double lower = about(3.84, 0.15) + about(2.5, hypot(0.3, 0.05));
    const tfa_model_options options = {.rotor_inertia = 1};
    tfa_model *m = hand_model(&h, &options), *derived = NULL;
    const tfa_payload payload = {.link = "tool", .mass = 2, .com = {0.1, 0, 0}};
    assert_int_equal(tfa_model_derive(m, NULL, &payload, 1, NULL, &derived), TFA_OK);
    struct facts f = ask_model(derived, q);
    hand_near(tfa_model_joint(derived, 0).armature, A1, 0);
    hand_near(tfa_model_joint(derived, 1).armature, A2 + 0.25, 1e-16);
    hand_near(f.M[3], lower + A2 + 0.25 + 2 * 0.4 * 0.4, 1e-14);
    tfa_model_free(derived);
    tfa_model_free(m);
}

/* ---- a massless fixed link that moves its parent's centre of mass ---- */

/* The same robot without and with empty links, whose numbers are there all the same. */
TEST(empty_links_are_frames)
{
    static const char *const names[] = {"camera", "tcp", "world_mark"};
    static const uint32_t parents[] = {1, 4, 0};
    const double q[2] = {0.4, -0.9};
    hand plain, marked;
    make_bracket(&plain);
    make_bracket(&marked);
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t link = hand_link(&marked, names[k], 0, 1, 2, 3);
        tfa_joint *j = hand_joint(&marked, names[k], TFA_JOINT_FIXED, parents[k], link);
        j->xyz[0] = 0.7;
        j->quat[0] = j->quat[3] = sqrt(0.5);
    }
    for (int base = 0; base < 2; base++) {
        const tfa_model_options options = {.base = base ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
        struct facts a = ask(&plain, &options, q), b = ask(&marked, &options, q);
        assert_true(a.s.total_mass == b.s.total_mass && a.s.moving_mass == b.s.moving_mass);
        assert_memory_equal(a.s.com, b.s.com, sizeof a.s.com);
        assert_memory_equal(a.M, b.M, sizeof a.M);
        assert_memory_equal(a.tau, b.tau, sizeof a.tau);
        assert_memory_equal(a.base, b.base, sizeof a.base);
        assert_memory_equal(a.qdd, b.qdd, sizeof a.qdd);
        assert_int_equal(b.s.links, a.s.links + 3);
    }
}

/* An empty link on a joint that is locked: it is a frame then, and no more. */
TEST(locked_empty_link_is_a_frame)
{
    const double q[2] = {0.4, -0.9};
    hand plain, marked;
    make_bracket(&plain);
    make_bracket(&marked);
    uint32_t link = hand_link(&marked, "dial", 0, 1, 2, 3);
    hand_joint(&marked, "dial", TFA_JOINT_REVOLUTE, 3, link)->xyz[1] = 0.2;
    const tfa_model_options leaves = {.lock_massless_leaves = 1};
    const tfa_lock lock = {.joint = "dial", .q = {0.8}};
    const tfa_scene scene = {.locks = &lock, .lock_count = 1};
    const tfa_model_options locked = {.scene = &scene};
    struct facts a = ask(&plain, NULL, q), b = ask(&marked, &leaves, q);
    assert_memory_equal(a.s.com, b.s.com, sizeof a.s.com);
    assert_memory_equal(a.M, b.M, sizeof a.M);
    assert_memory_equal(a.tau, b.tau, sizeof a.tau);
    b = ask(&marked, &locked, q);
    assert_memory_equal(a.s.com, b.s.com, sizeof a.s.com);
    assert_memory_equal(a.M, b.M, sizeof a.M);
    assert_memory_equal(a.tau, b.tau, sizeof a.tau);
}

/* ---- inertia of structural links dropped ---- */

/* frame =bolts= plate =screws= box, and a flywheel of 4 kg on the box: 13 kg of structure. */
static void make_structure(hand *h)
{
    hand_begin(h);
    hand_link(h, "frame", 2, 0, 0, 0);
    hand_link(h, "plate", 8, 0.1, 0, 0);
    hand_link(h, "box", 3, 0, 0, 0.2);
    hand_link(h, "flywheel", 4, 0, 0, 0);
    hand_joint(h, "bolts", TFA_JOINT_FIXED, 0, 1)->xyz[2] = -0.5;
    hand_joint(h, "screws", TFA_JOINT_FIXED, 1, 2)->xyz[0] = 0.3;
    hand_joint(h, "motor", TFA_JOINT_CONTINUOUS, 2, 3)->xyz[1] = 0.1;
}

static void check_structure(const hand *h, const tfa_scene *scene)
{
    /* masses and places of the four, frame's axes; inertias are 0.01 m times the identity */
    static const double m[4] = {2, 8, 3, 4};
    static const double p[4][3] = {{0, 0, 0}, {0.1, 0, -0.5}, {0.3, 0, -0.3}, {0.3, 0.1, -0.5}};
    const double q = 0.7;
    tfa_model_options options = {.base = TFA_BASE_FIXED, .scene = scene};
    struct facts f = ask(h, &options, &q);
    hand_near(f.s.total_mass, 17, 1e-14);
    hand_near(f.s.moving_mass, 4, 1e-15);
    options.base = TFA_BASE_FLOATING;
    f = ask(h, &options, &q);
    hand_near(f.s.total_mass, 17, 1e-14);
    hand_near(f.s.moving_mass, 17, 1e-14);
    assert_int_equal(f.s.bodies, 2);
    double moment[3] = {0, 0, 0}, inertia[9] = {0};
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 3; i++) {
            moment[i] += m[k] * p[k][i];
            inertia[4 * i] += m[k] * 0.01;
            for (int j = 0; j < 3; j++) {
                inertia[3 * i + j] -= m[k] * p[k][i] * p[k][j];
                inertia[4 * i] += m[k] * p[k][j] * p[k][j];
            }
        }
    for (uint32_t i = 0; i < 3; i++) {
        hand_near(f.s.com[i], moment[i] / 17, 1e-15);
        hand_near(f.M[i * f.n + i], 17, 1e-14);
        for (uint32_t j = 0; j < 3; j++)
            hand_near(f.M[(3 + i) * f.n + 3 + j], inertia[3 * i + j], 1e-14);
    }
    /* m [c]x: what couples turning and pushing */
    hand_near(f.M[1 * f.n + 5], moment[0], 1e-14);
    hand_near(f.M[2 * f.n + 3], moment[1], 1e-14);
    hand_near(f.M[0 * f.n + 4], moment[2], 1e-14);
}

TEST(structure_counts)
{
    hand h;
    make_structure(&h);
    check_structure(&h, NULL);
    const tfa_lock locks[2] = {{.joint = "bolts", .q = {0}}, {.joint = "screws", .q = {0.3}}};
    const tfa_scene scene = {.locks = locks, .lock_count = 2};
    h.joint[0].type = TFA_JOINT_REVOLUTE;
    h.joint[1].type = TFA_JOINT_PRISMATIC;
    h.joint[1].axis[0] = 1;
    h.joint[1].axis[1] = 0;
    h.joint[1].xyz[0] = 0;
    check_structure(&h, &scene);
}
