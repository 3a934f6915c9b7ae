/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints of file and scene, and joints with a motor: what arrives, what the hash tells apart,
 * and how each mistake is refused.
 */
#include "hand.h"
#include "models.h"
#include "test.h"

#include <math.h>

/* base -shoulder- upper -elbow- lower =flange= tool, upper -finger- tip, finger after elbow */
enum { BASE, UPPER, LOWER, TOOL, TIP };
enum { SHOULDER, ELBOW, FLANGE, FINGER };

static void arm(hand *h)
{
    hand_arm(h);
    hand_link(h, "tip", 1, 0.1, 0, 0);
    hand_joint(h, "finger", TFA_JOINT_REVOLUTE, UPPER, TIP)->xyz[0] = 0.2;
}

#define FOOT                                                                                       \
    {                                                                                              \
        .name = "foot", .link = {NULL, "tool"}, .rows = TFA_CONSTRAINT_POINT, .unilateral = 1      \
    }
static const tfa_constraint foot = FOOT;

/* ---- refusals ---- */

static const tfa_constraint twice[] = {FOOT, FOOT};

static const struct {
    tfa_constraint constraint;
    const char *text;
} refusals[] = {
    {{.link = {NULL, "tool"}, .rows = 1},
     "constraint '(none)': it has no name; give it one, by which requests call it"},
    {{.name = "", .link = {NULL, "tool"}, .rows = 1},
     "constraint '': it has no name; give it one, by which requests call it"},
    {{.name = "c", .link = {NULL, "tool"}},
     "constraint 'c': its rows are none of the six components of a motion; choose from bits 0 to "
     "5"},
    {{.name = "c", .link = {NULL, "tool"}, .rows = 0x40},
     "constraint 'c': its rows are none of the six components of a motion; choose from bits 0 to "
     "5"},
    {{.name = "c", .link = {NULL, "tool"}, .rows = 0x3b, .unilateral = 1},
     "constraint 'c': it is unilateral, but does not hold z of its first frame; hold row z"},
    {{.name = "c", .rows = 1},
     "constraint 'c': both frames are of the world; one of them must be on a link of the robot"},
    {{.name = "c", .link = {NULL, "tool"}, .rows = 1, .pose[1] = {0, (double)NAN}},
     "constraint 'c': a number of its poses is not finite; correct it"},
    {{.name = "c", .link = {NULL, "tool"}, .rows = 1, .pose[0] = {[3] = 1, [6] = 1}},
     "constraint 'c': the norm of a quaternion is off from 1 by more than 1e-3; correct it (x y z, "
     "then x y z w)"},
    {{.name = "c", .link = {"tool", "lwer"}, .rows = 1},
     "link 'lwer': a constraint is on a link that does not exist; name a link of the robot, or the "
     "world; nearest: 'lower', 'upper', 'base'"},
    {{.name = "c", .link = {"tip", "tip"}, .rows = 1, .pose[0] = {1}},
     "constraint 'c': its frames do not move against each other: their links are one body, or "
     "fixed to the world; constrain others, or leave it out"},
    {{.name = "c", .link = {"lower", "tool"}, .rows = 1},
     "constraint 'c': its frames do not move against each other: their links are one body, or "
     "fixed to the world; constrain others, or leave it out"},
    {{.name = "c", .link = {NULL, "base"}, .rows = 1},
     "constraint 'c': its frames do not move against each other: their links are one body, or "
     "fixed to the world; constrain others, or leave it out"},
};

static void assert_refused(const tfa_scene *scene, const char *code, const char *text)
{
    const tfa_model_options options = {.scene = scene};
    hand h;
    arm(&h);
    struct outcome o = hand_outcome(&h, &options, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_MODEL);
    assert_string_equal(hand_said(&o, code)->text, text);
    hand_forget(&o);
}

TEST(test_refused)
{
    for (size_t k = 0; k < sizeof refusals / sizeof *refusals; k++)
        assert_refused(&(tfa_scene){.constraints = &refusals[k].constraint, .constraint_count = 1},
                       "scene-constraint", refusals[k].text);
    assert_refused(&(tfa_scene){.constraints = twice, .constraint_count = 2}, "scene-constraint",
                   "constraint 'foot': another one has this name; rename one of them");
    const tfa_constraint on_base = {.name = "c", .link = {"base", "tool"}, .rows = 1};
    assert_refused(
        &(tfa_scene){.root = "upper", .constraints = &on_base, .constraint_count = 1},
        "scene-constraint",
        "constraint 'c': one of its links is not part of the scene; constrain others, or leave it "
        "out");
    char names[TFA_MAX_CONSTRAINTS + 1][4];
    tfa_constraint many[TFA_MAX_CONSTRAINTS + 1];
    for (int k = 0; k <= TFA_MAX_CONSTRAINTS; k++) {
        snprintf(names[k], sizeof names[k], "c%d", k);
        many[k] = foot;
        many[k].name = names[k];
    }
    assert_refused(&(tfa_scene){.constraints = many, .constraint_count = TFA_MAX_CONSTRAINTS + 1},
                   "scene-constraint",
                   "constraint 'c32': 32 constraints are the most of a model; leave some out");
}

/* ---- those of the file ---- */

static void with_loop(hand *h, tfa_constraint *loop)
{
    arm(h);
    *loop = (tfa_constraint){
        .name = "close", .link = {"base", "tool"}, .rows = TFA_CONSTRAINT_HINGE, .line = 7};
    h->d.constraints = loop;
    h->d.constraint_count = 1;
}

TEST(test_file_comes_first)
{
    hand h;
    tfa_constraint loop;
    with_loop(&h, &loop);
    const tfa_scene scene = {.constraints = &foot, .constraint_count = 1};
    tfa_model *m = hand_model(&h, &(tfa_model_options){.scene = &scene});
    assert_int_equal(tfa_model_constraint_count(m), 2);
    const tfa_constraint_info of_file = tfa_model_constraint(m, 0),
                              of_scene = tfa_model_constraint(m, 1);
    assert_string_equal(of_file.name, "close");
    assert_int_equal(of_file.frame[0], BASE);
    assert_int_equal(of_file.frame[1], TOOL);
    assert_int_equal(of_file.rows, TFA_CONSTRAINT_HINGE);
    assert_int_equal(of_file.unilateral, 0);
    assert_string_equal(of_scene.name, "foot");
    assert_int_equal(of_scene.frame[0], -1);
    assert_int_equal(of_scene.unilateral, 1);
    assert_int_equal(tfa_model_find_constraint(m, "foot"), 1);
    assert_int_equal(tfa_model_find_constraint(m, "feet"), -1);
    assert_null(tfa_model_constraint(m, 2).name);
    tfa_model_free(m);
}

/* A scene without its links, or in which nothing moves between them, has it no more. */
TEST(test_file_is_left_out)
{
    static const tfa_lock locks[] = {{"shoulder", {0.5}}, {"elbow", {0.5}}};
    static const struct {
        tfa_scene scene;
        const char *text;
    } rows[] = {
        {{.root = "upper"},
         "constraint 'close': one of its links is not part of the scene; it is left out"},
        {{.locks = locks, .lock_count = 2},
         "constraint 'close': its frames do not move against each other: their links are one body, "
         "or fixed to the world; it is left out"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        hand h;
        tfa_constraint loop;
        with_loop(&h, &loop);
        struct outcome o =
            hand_outcome(&h, &(tfa_model_options){.scene = &rows[k].scene}, TFA_SYNTAX_C);
        assert_int_equal(o.status, TFA_OK);
        const tfa_message *said = hand_said(&o, "loop-joint");
        assert_string_equal(said->text, rows[k].text);
        assert_int_equal(said->severity, TFA_NOTE);
        assert_int_equal(said->line, 7);
        assert_int_equal(tfa_model_constraint_count(o.model), 0);
        hand_forget(&o);
    }
}

TEST(test_file_and_scene_share_names)
{
    hand h;
    tfa_constraint loop;
    with_loop(&h, &loop);
    loop.name = "foot";
    const tfa_scene scene = {.constraints = &foot, .constraint_count = 1};
    struct outcome o = hand_outcome(&h, &(tfa_model_options){.scene = &scene}, TFA_SYNTAX_C);
    assert_int_equal(o.status, TFA_E_MODEL);
    assert_string_equal(hand_said(&o, "scene-constraint")->text,
                        "constraint 'foot': another one has this name; rename one of them");
    hand_forget(&o);
}

/* ---- joints with a motor ---- */

static void assert_actuated(const tfa_model *m, const char *names)
{
    char have[100] = "";
    for (uint32_t k = 0; k < tfa_model_joint_count(m); k++)
        if (tfa_model_joint(m, k).actuated)
            strcat(strcat(have, *have ? " " : ""), tfa_model_joint(m, k).name);
    assert_string_equal(have, names);
}

TEST(test_actuated)
{
    static const char *const finger[] = {"finger"}, *const two[] = {"elbow", "shoulder", "elbow"};
    hand h;
    arm(&h);
    tfa_scene scene = {.actuated = NULL};
    tfa_model_options options = {.scene = &scene};
    tfa_model *m = hand_model(&h, NULL);
    assert_actuated(m, "shoulder elbow finger");
    tfa_model_free(m);
    scene.actuated = two;
    scene.actuated_count = 3;
    m = hand_model(&h, &options);
    assert_actuated(m, "shoulder elbow");
    tfa_model_free(m);
    /* a follower stands for its leader */
    h.joint[FINGER].mimic = ELBOW;
    h.joint[FINGER].multiplier = 1;
    scene.actuated = finger;
    scene.actuated_count = 1;
    options.mimic = TFA_MIMIC_PROJECT;
    m = hand_model(&h, &options);
    assert_actuated(m, "elbow");
    tfa_model_free(m);
    options.mimic = TFA_MIMIC_FREE;
    m = hand_model(&h, &options);
    assert_actuated(m, "finger");
    tfa_model_free(m);
}

TEST(test_actuated_refused)
{
    static const tfa_lock lock[] = {{"elbow", {0}}};
    static const char *const elbw[] = {"elbw"}, *const elbow[] = {"elbow"},
                             *const flange[] = {"flange"}, *const shoulder[] = {"shoulder"},
                             *const none[] = {NULL};
    static const struct {
        tfa_scene scene;
        const char *text;
    } rows[] = {
        {{.actuated = elbw, .actuated_count = 1},
         "joint 'elbw': the scene says that it is actuated, but the robot has no such joint; "
         "correct the name; nearest: 'elbow', 'flange', 'finger'"},
        {{.actuated = none, .actuated_count = 1},
         "joint '(none)': the scene says that it is actuated, but the robot has no such joint; "
         "correct the name; nearest: 'elbow', 'flange', 'finger'"},
        {{.actuated = flange, .actuated_count = 1},
         "joint 'flange': the scene says that it is actuated, but it is fixed in the file; remove "
         "it from the actuated joints"},
        {{.actuated = elbow, .actuated_count = 1, .locks = lock, .lock_count = 1},
         "joint 'elbow': the scene says that it is actuated, but it is locked; remove it from the "
         "actuated joints"},
        {{.actuated = shoulder, .actuated_count = 1, .root = "upper"},
         "joint 'shoulder': the scene says that it is actuated, but it is not part of the scene; "
         "remove it from the actuated joints"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        assert_refused(&rows[k].scene, "scene-actuated", rows[k].text);
}

/* ---- the hash ---- */

CHANGE(none, (void)h)
CHANGE(name, h->d.constraints->name = "open")
CHANGE(first, h->d.constraints->link[0] = NULL)
CHANGE(second, h->d.constraints->link[1] = "lower")
CHANGE(position, h->d.constraints->pose[0][2] = 1e-9)
CHANGE(axes, (h->d.constraints->pose[1][4] = 0.6, h->d.constraints->pose[1][6] = 0.8))
CHANGE(rows, h->d.constraints->rows = TFA_CONSTRAINT_WELD)
CHANGE(unilateral, h->d.constraints->unilateral = 1)
CHANGE(no_loop, h->d.constraint_count = 0)
CHANGE(line, h->d.constraints->line = 8)
CHANGE(unit, h->d.constraints->pose[1][6] = 1)

TEST(test_hash)
{
    static const char *const some[] = {"shoulder"}, *const all[] = {"finger", "elbow", "shoulder"};
    static const struct {
        void (*change)(hand *);
        const char *const *actuated;
        size_t actuated_count;
        bool differs;
    } changes[] = {
        {none, NULL, 0, false},  {name, NULL, 0, true},       {first, NULL, 0, true},
        {second, NULL, 0, true}, {position, NULL, 0, true},   {axes, NULL, 0, true},
        {rows, NULL, 0, true},   {unilateral, NULL, 0, true}, {no_loop, NULL, 0, true},
        {line, NULL, 0, false},  {unit, NULL, 0, false},      {none, some, 1, true},
        {none, all, 3, false},
    };
    hand h;
    tfa_constraint loop;
    with_loop(&h, &loop);
    tfa_model *m = hand_model(&h, NULL);
    for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
        with_loop(&h, &loop);
        changes[k].change(&h);
        const tfa_scene scene = {.actuated = changes[k].actuated,
                                 .actuated_count = changes[k].actuated_count};
        tfa_model *other = hand_model(&h, &(tfa_model_options){.scene = &scene});
        if ((strcmp(tfa_model_hash_text(m), tfa_model_hash_text(other)) != 0) != changes[k].differs)
            fail_msg("change %zu", k);
        tfa_model_free(other);
    }
    tfa_model_free(m);
}
