/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ways to a model, what its hash tells apart, its rotors, and its accessors.
 */
#include "hand.h"
#include "models.h"
#include "test.h"

TEST(test_own_memory)
{
    hand h;
    hand_arm(&h);
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    const tfa_model_options *const options[] = {NULL, &floating};
    for (int k = 0; k < 2; k++) {
        tfa_model *created = hand_model(&h, options[k]);
        size_t size = tfa_model_size(&h.d, options[k]);
        assert_int_not_equal(size, 0);
        char *memory = aligned_alloc(64, size + 64);
        assert_non_null(memory);
        memset(memory, 0xa5, size + 64);
        const tfa_model *placed = created;
        assert_int_equal(tfa_model_init(memory, size - 1, &h.d, options[k], NULL, &placed),
                         TFA_E_MEMORY);
        assert_null(placed);
        assert_int_equal(tfa_model_init(memory, 0, &h.d, options[k], NULL, &placed), TFA_E_MEMORY);
        assert_int_equal(tfa_model_init(memory + 8, size, &h.d, options[k], NULL, &placed),
                         TFA_E_MEMORY);
        assert_int_equal(tfa_model_init(memory, size, &h.d, options[k], NULL, &placed), TFA_OK);
        assert_non_null(placed);
        assert_memory_equal(tfa_model_hash(placed), tfa_model_hash(created), 32);
        assert_string_equal(tfa_model_hash_text(placed), tfa_model_hash_text(created));
        for (size_t e = size; e < size + 64; e++) /* not a byte more than it said */
            assert_int_equal((uint8_t)memory[e], 0xa5);
        free(memory);
        tfa_model_free(created);
    }
}

/* A model keeps nothing of the description that it was made of. */
TEST(test_description_is_free_to_go)
{
    hand h;
    hand_arm(&h);
    char name[] = "shoulder", robot[] = "robot", link[] = "upper";
    h.joint[0].name = name;
    h.link[1].name = link;
    h.d.name = robot;
    tfa_model *m = hand_model(&h, NULL);
    name[0] = link[0] = robot[0] = '#';
    memset(h.link, 0xff, sizeof h.link);
    assert_string_equal(tfa_model_joint(m, 0).name, "shoulder");
    assert_string_equal(tfa_model_frame(m, 1).name, "upper");
    assert_string_equal(tfa_model_name(m), "robot");
    tfa_model_free(m);
    hand_arm(&h);
    h.d.name = NULL;
    m = hand_model(&h, NULL);
    assert_string_equal(tfa_model_name(m), "");
    tfa_model_free(m);
}

enum { SAME, OTHER };
static const double moon[3] = {0, 0, -1.62};
static const double standard[3] = {0, 0, -9.80665};

static void keep(hand *h)
{
    (void)h;
}

static void change_line_and_limits(hand *h)
{
    h->link[1].line = 77;
    h->joint[1].line = 78;
    h->joint[1].damping = 3;
}

CHANGE(scale_axis, h->joint[1].axis[1] = 2)
CHANGE(mass, h->link[2].mass += 1e-9)
CHANGE(com, h->link[2].com[0] += 1e-9)
CHANGE(inertia, h->link[2].inertia[5] *= 1.0001)
CHANGE(axis, h->joint[1].axis[2] = 1e-6)
CHANGE(flipped_axis, h->joint[1].axis[1] = -1)
CHANGE(origin, h->joint[0].xyz[0] = 1e-9)
CHANGE(prismatic, h->joint[1].type = TFA_JOINT_PRISMATIC)
CHANGE(armature, h->joint[1].armature = 1e-6)
CHANGE(rotor, h->joint[1].rotor = 0.25)
CHANGE(friction, h->joint[1].friction = 0.25)
CHANGE(joint_name, h->joint[1].name = "elbov")
CHANGE(link_name, h->link[3].name = "tooth")

static void fixed_frame(hand *h)
{
    h->link[3].mass = 0; /* with no mass it is only a frame; both sides of the comparison */
    memset(h->link[3].inertia, 0, sizeof h->link[3].inertia);
}

CHANGE(fixed_frame_moved, fixed_frame(h); h->joint[2].xyz[2] = 1e-9)

TEST(test_hash)
{
    static const struct {
        const char *name;
        void (*from)(hand *h);
        void (*to)(hand *h);
        tfa_model_options options; /* of `to` */
        int expected;
    } rows[] = {
        {"nothing", keep, keep, {0}, SAME},
        {"lines and damping", keep, change_line_and_limits, {0}, SAME},
        {"length of the axis", keep, scale_axis, {0}, SAME},
        {"default gravity, given", keep, keep, {.gravity = standard}, SAME},
        {"rotors asked for, none there", keep, keep, {.rotor_inertia = 1}, SAME},
        {"friction, not asked for", keep, friction, {0}, SAME},
        {"friction", friction, friction, {.friction = 1}, OTHER},
        {"rotor, not asked for", keep, rotor, {0}, SAME},
        {"rotor", rotor, rotor, {.rotor_inertia = 1}, OTHER},
        {"mass", keep, mass, {0}, OTHER},
        {"centre of mass", keep, com, {0}, OTHER},
        {"inertia", keep, inertia, {0}, OTHER},
        {"axis", keep, axis, {0}, OTHER},
        {"flipped axis", keep, flipped_axis, {0}, OTHER},
        {"joint origin", keep, origin, {0}, OTHER},
        {"joint type", keep, prismatic, {0}, OTHER},
        {"armature", keep, armature, {0}, OTHER},
        {"gravity", keep, keep, {.gravity = moon}, OTHER},
        {"base", keep, keep, {.base = TFA_BASE_FLOATING}, OTHER},
        {"joint name", keep, joint_name, {0}, OTHER},
        {"link name", keep, link_name, {0}, OTHER},
        {"pose of a massless frame", fixed_frame, fixed_frame_moved, {0}, OTHER},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        hand from, to;
        hand_arm(&from);
        hand_arm(&to);
        rows[k].from(&from);
        rows[k].to(&to);
        tfa_model *a = hand_model(&from, NULL), *b = hand_model(&to, &rows[k].options);
        int differ = memcmp(tfa_model_hash(a), tfa_model_hash(b), 32) != 0;
        int text_differs = strcmp(tfa_model_hash_text(a), tfa_model_hash_text(b)) != 0;
        if (differ != (rows[k].expected == OTHER) || text_differs != differ)
            fail_msg("%s: hash %s", rows[k].name, differ ? "changed" : "did not change");
        assert_int_equal(strspn(tfa_model_hash_text(a), "0123456789abcdef"), 64);
        tfa_model_free(a);
        tfa_model_free(b);
    }
}

/* Element 0, 0 of M at q = 0. */
static double first_inertia(const tfa_model *m)
{
    tfa_workspace *w = workspace_for(m, NULL);
    double q[2] = {0, 0}, M[4];
    const tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1, .q = q};
    tfa_reply reply = {.mass_matrix = M};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
    return M[0];
}

TEST(test_rotors)
{
    hand h;
    hand_arm(&h);
    h.joint[0].armature = 0.5;
    h.joint[0].rotor = 0.25; /* the armature is the user's word: no note */
    h.joint[1].rotor = 0.125;
    h.joint[2].rotor = 8; /* on a fixed joint: nothing */
    tfa_report report = {0};
    tfa_model *without = NULL;
    assert_int_equal(tfa_model_create(&h.d, NULL, &report, &without), TFA_OK);
    assert_int_equal(report.count, 2);
    assert_string_equal(report.messages[1].code, "base-mass");
    assert_string_equal(report.messages[1].text,
                        "link 'base': it and what is fixed to it have mass, 4 kg, which is not "
                        "used, and the file has no link 'world' that it is fixed to; did you mean "
                        "base = floating?");
    assert_int_equal(report.messages[0].severity, TFA_NOTE);
    assert_string_equal(report.messages[0].code, "rotor-inertia");
    assert_string_equal(report.messages[0].text,
                        "robot: rotor inertia: not used; in the file: 1; rotor_inertia = 1 uses "
                        "it");
    assert_int_equal(report.messages[0].line, 101);
    assert_string_equal(report.messages[0].entity, "rotor inertia");
    tfa_report_free(&report);
    const tfa_model_options options = {.rotor_inertia = 1};
    tfa_model *with = NULL;
    assert_int_equal(tfa_model_create(&h.d, &options, &report, &with), TFA_OK);
    assert_int_equal(report.warnings, 0);
    assert_true(tfa_model_joint(without, 0).armature == 0.5);
    assert_true(tfa_model_joint(with, 0).armature == 0.75);
    assert_true(tfa_model_joint(with, 1).armature == 0.125);
    hand_near(first_inertia(with) - first_inertia(without), 0.25, 1e-12);
    tfa_model_free(with);
    tfa_model_free(without);
    tfa_report_free(&report);
}

/* Of a scene: the square of the reduction, 1 without one, which a note says. */
TEST(test_rotors_of_a_scene)
{
    static const tfa_rotor rotors[] = {{"shoulder", 1e-4}, {"elbow", 0.25}};
    const tfa_scene scene = {.rotors = rotors, .rotor_count = 2};
    const tfa_model_options options = {.scene = &scene};
    hand h;
    hand_arm(&h);
    h.joint[0].armature = 0.5;
    h.joint[0].reduction = -100;
    struct outcome without = hand_outcome(&h, NULL, TFA_SYNTAX_C),
                   with = hand_outcome(&h, &options, TFA_SYNTAX_C);
    assert_int_equal(with.status, TFA_OK);
    assert_true(tfa_model_joint(with.model, 0).armature == 0.5 + 1e-4 * 100 * 100);
    assert_true(tfa_model_joint(with.model, 1).armature == 0.25);
    hand_near(first_inertia(with.model) - first_inertia(without.model), 1, 1e-12);
    assert_string_equal(hand_said(&with, "no-reduction")->text,
                        "joint 'elbow': the file has no reduction for its rotor, which counts as "
                        "turning with the joint");
    assert_memory_not_equal(tfa_model_hash(with.model), tfa_model_hash(without.model), 32);
    hand_forget(&with);
    hand_forget(&without);
}

TEST(test_accessors)
{
    hand h;
    hand_arm(&h);
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    tfa_model *m = hand_model(&h, &floating);
    assert_int_equal(tfa_model_base_freedoms(m), 6);
    assert_int_equal(tfa_model_v_count(m), 2);
    assert_int_equal(tfa_model_q_count(m), 2);
    assert_int_equal(tfa_model_joint_count(m), 2);
    assert_int_equal(tfa_model_frame_count(m), 4);
    assert_int_equal(tfa_model_find_joint(m, "elbow"), 1);
    assert_int_equal(tfa_model_find_joint(m, "flange"), -1); /* fixed */
    assert_int_equal(tfa_model_find_joint(m, ""), -1);
    assert_int_equal(tfa_model_find_frame(m, "tool"), 3);
    assert_int_equal(tfa_model_find_frame(m, "elbow"), -1);
    assert_int_equal(tfa_model_joint(m, 1).v_index, 1); /* the base's six do not count */
    assert_int_equal(tfa_model_joint(m, 1).body, 2);
    assert_int_equal(tfa_model_frame(m, 3).body, 2);
    assert_string_equal(tfa_model_body_name(m, 0), "base");
    assert_string_equal(tfa_model_body_name(m, 2), "lower");
    assert_int_equal(tfa_model_body_frame(m, 2), 2);
    assert_int_equal(tfa_model_body_parent(m, 0), -1);
    assert_int_equal(tfa_model_body_parent(m, 2), 1);
    static const uint32_t beyond[] = {4, UINT32_MAX};
    for (int k = 0; k < 2; k++) {
        assert_null(tfa_model_joint(m, beyond[k]).name);
        assert_int_equal(tfa_model_joint(m, beyond[k]).v_count, 0);
        assert_null(tfa_model_frame(m, beyond[k]).name);
        assert_int_equal(tfa_model_frame(m, beyond[k]).body, -1);
        assert_string_equal(tfa_model_body_name(m, beyond[k]), "");
        assert_int_equal(tfa_model_body_frame(m, beyond[k]), 0);
        assert_int_equal(tfa_model_body_parent(m, beyond[k]), -1);
    }
    assert_null(tfa_model_joint(m, 2).name);
    assert_string_equal(tfa_model_body_name(m, 3), "");
    tfa_model_free(m);
}

TEST(test_load)
{
    static const char good[] = TFA_SOURCE_DIR "/config/robots/arm7.urdf";
    static const char missing[] = TFA_SOURCE_DIR "/config/robots/no-such-robot.urdf";
    tfa_report report = {0};
    tfa_model *m = (tfa_model *)&report;
    assert_int_equal(tfa_model_load(missing, NULL, &report, &m), TFA_E_FILE);
    assert_null(m);
    assert_int_equal(report.errors, 1);
    assert_string_equal(report.file, missing);
    assert_string_equal(report.messages[0].code, "unreadable");
    assert_string_equal(report.messages[0].text, "file: cannot be read: No such file or directory");
    tfa_report_free(&report);
    assert_int_equal(tfa_model_load(missing, NULL, NULL, &m), TFA_E_FILE);

    assert_int_equal(tfa_model_load(good, NULL, &report, &m), TFA_OK);
    assert_int_equal(report.errors, 0);
    assert_string_equal(report.file, good);
    assert_int_equal(tfa_model_joint_count(m), 7);
    assert_string_equal(tfa_model_joint(m, 6).name, "joint_7");
    tfa_model_free(m);
    tfa_report_free(&report);
    assert_int_equal(tfa_model_load(good, NULL, NULL, &m), TFA_OK);
    tfa_model_free(m);

    const tfa_model_options options = {.base = (tfa_base)-1};
    assert_int_equal(tfa_model_load(good, &options, NULL, &m), TFA_E_ARGUMENT);
    assert_null(m);
}
