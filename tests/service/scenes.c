/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scenes and policies of the configuration: the daemon serves what the library compiles.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <signal.h>
#include <sys/wait.h>
#include <totalforce/constraints.h>
#include <totalforce/description.h>
#include <totalforce/modes.h>

#define TIMEOUT_NS WAIT_NS
#define HUMANOID TFA_SOURCE_DIR "/config/robots/humanoid.urdf"
#define ARM_FILE TFA_SOURCE_DIR "/config/robots/arm7.urdf"
#define FREEDOMS_MAX 64

/* ---- the shipped example ---- */

/* The robots of an example below config/, with its folder written as '@/config/'. */
static void read_robots(const char *file, char *robots, size_t size)
{
    char text[8192];
    FILE *in = fopen(file, "r");
    assert_non_null(in);
    text[fread(text, 1, sizeof text - 1, in)] = 0;
    fclose(in);
    const char *from = strstr(text, "\nrobots:\n");
    assert_non_null(from);
    from += strlen("\nrobots:\n");
    for (const char *urdf; (urdf = strstr(from, "urdf: robots/")); from = urdf + 6) {
        const size_t used = strlen(robots);
        snprintf(robots + used, size - used, "%.*s@/config/", (int)(urdf + 6 - from), from);
    }
    strncat(robots, from, size - strlen(robots) - 1);
}

static tfa_model *compile(const char *file, const tfa_model_options *options)
{
    tfa_report report = {0};
    tfa_model *model;
    assert_int_equal(tfa_model_load(file, options, &report, &model), TFA_OK);
    tfa_report_free(&report);
    return model;
}

/* The same hash, the same lists, and the same bits of one forward dynamics. */
static void assert_serves(const harness *h, const char *name, const tfa_model *model)
{
    static const double pose[7] = {0, 0, 1, 0, 0, 0, 1};
    double q[FREEDOMS_MAX], here[FREEDOMS_MAX], there[FREEDOMS_MAX], base[2][6];
    double modes[2][FREEDOMS_MAX] = {{0}};
    const uint32_t mode_count = tfa_model_mode_count(model);
    SCOPED_CLIENT *client = harness_connect(h, name, TFA_WAIT_BLOCK);
    const tfa_client_info *info = tfa_client_get_info(client);
    assert_string_equal(info->model_hash, tfa_model_hash_text(model));
    assert_int_equal(info->v_count, tfa_model_v_count(model));
    assert_int_equal(info->frame_count, tfa_model_frame_count(model));
    for (uint32_t i = 0; i < info->joint_count; i++)
        assert_string_equal(info->joint_names[i], tfa_model_joint(model, i).name);
    for (int i = 0; i < FREEDOMS_MAX; i++)
        q[i] = 0.1 * (i % 7);
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .estimate = TFA_ESTIMATE_NEVER,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = q,
                                 .modes = mode_count ? q : NULL,
                                 .base_pose = info->base_freedoms ? pose : NULL};
    tfa_reply a = {.qdd = here, .modes = modes[0], .base_acceleration = base[0]};
    tfa_reply b = {.qdd = there, .modes = modes[1], .base_acceleration = base[1]};
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    assert_int_equal(tfa_compute(w, &request, &a), TFA_OK);
    assert_int_equal(tfa_client_call(client, &request, &b, TIMEOUT_NS, NULL), TFA_OK);
    assert_memory_equal(here, there, info->v_count * sizeof(double));
    assert_memory_equal(modes[0], modes[1], mode_count * sizeof(double));
    assert_true(mode_count == 0 || modes[1][0] != 0);
    assert_true(b.model == tfa_model_tag(model));
}

static void check_arm(const harness *h)
{
    static const double moon[3] = {0, 0, -1.62};
    const tfa_payload load = {
        .link = "tool0", .mass = 2, .com = {0, 0, 0.05}, .inertia = {4e-3, 0, 0, 4e-3, 0, 2e-3}};
    const tfa_scene scene = {.payloads = &load, .payload_count = 1};
    const tfa_model_options options[3] = {{0}, {.scene = &scene}, {.gravity = moon}};
    static const char *const names[3] = {"arm", "arm.loaded", "arm.moon"};
    for (int i = 0; i < 3; i++) {
        SCOPED_MODEL *model = compile(ARM_FILE, &options[i]);
        assert_serves(h, names[i], model);
    }
}

static void check_humanoid(const harness *h)
{
    static const char *const tips[] = {"left_palm"};
    const tfa_scene reach = {.root = "torso_link", .tips = tips, .tip_count = 1};
    const tfa_model_options whole = {.base = TFA_BASE_FLOATING}, part = {.scene = &reach};
    tfa_model *all = compile(HUMANOID, &whole), *arm = compile(HUMANOID, &part);
    assert_serves(h, "humanoid", all);
    assert_serves(h, "humanoid.reach", arm);
    assert_true(tfa_model_v_count(arm) < tfa_model_v_count(all) / 2);
    SCOPED_CLIENT *walk = harness_connect(h, "humanoid.walk", TFA_WAIT_BLOCK);
    const tfa_client_info *info = tfa_client_get_info(walk);
    assert_int_equal(info->v_count, tfa_model_v_count(all) - 18);
    for (uint32_t i = 0; i < info->joint_count; i++)
        assert_null(strstr(info->joint_names[i], "thumb"));
    tfa_model_free(all);
    tfa_model_free(arm);
}

TEST(example_is_served)
{
    char robots[8192] = "";
    read_robots(TFA_SOURCE_DIR "/config/scenes.yaml", robots, sizeof robots);
    SCOPED_HARNESS h = harness_serve(robots, "");
    check_arm(&h);
    check_humanoid(&h);
    assert_true(harness_logged(&h, "robot 'arm.moon': 7 joints"));
    assert_int_equal(harness_log_lines(&h, "shares its constants"), 2);
    assert_true(harness_logged(&h, "robot 'humanoid.walk': "));
    assert_true(harness_logged(&h, " 18 locked,"));
}

/* ---- flexible links ---- */

static tfa_model *compile_flexible(const char *text)
{
    tfa_modes modes = {0};
    tfa_report report = {0};
    assert_int_equal(tfa_modes_parse(text, strlen(text), NULL, &modes, &report), TFA_OK);
    tfa_report_free(&report);
    const tfa_scene scene = {.modes = modes.links, .modes_count = modes.count};
    tfa_model *model = bundled_model("flexible_arm.urdf", &(tfa_model_options){.scene = &scene});
    tfa_modes_free(&modes);
    return model;
}

/* A scene has its file of modes, relative to the configuration; a reload reads it again, and with a
 * broken one the daemon serves on as before. No specialised kernel is looked for. */
TEST(modes_are_served)
{
    SCOPED_TEXT *text = bundled_text("flexible_arm.yaml");
    SCOPED_MODEL *rigid = bundled_model("flexible_arm.urdf", NULL);
    SCOPED_MODEL *flexible = compile_flexible(text);
    SCOPED_HARNESS h = harness_make("  - name: arm\n    urdf: @/config/robots/flexible_arm.urdf\n"
                                    "    scenes: [{name: bent, modes: [m.yaml]}]\n",
                                    "specialise: load\nspecialise_directory: .\n");
    harness_write(&h, "m.yaml", text);
    harness_start(&h, "arm");
    assert_serves(&h, "arm", rigid);
    assert_serves(&h, "arm.bent", flexible);
    assert_true(harness_logged(&h, "robot 'arm.bent': the generic kernel answers"));
    assert_true(harness_logged(&h, "link 'upper_beam' is flexible"));
    harness_write(&h, "m.yaml", "links: 3\n");
    harness_reload(&h, NULL, "");
    assert_true(harness_logged(&h, "m.yaml:1: error: column 8: links: keys are expected here"));
    assert_true(harness_logged(&h, "reload: refused"));
    assert_serves(&h, "arm.bent", flexible);
    char *damping = strstr(text, "damping: ");
    assert_non_null(damping);
    damping[strlen("damping: ")] = '1';
    SCOPED_MODEL *changed = compile_flexible(text);
    assert_string_not_equal(tfa_model_hash_text(changed), tfa_model_hash_text(flexible));
    harness_write(&h, "m.yaml", text);
    harness_reload(&h, NULL, "");
    assert_true(harness_logged(&h, "reload: done, 1 of 2"));
    assert_serves(&h, "arm.bent", changed);
}

/* ---- constraints ---- */

/* Of the file and of the scene; a reload may change them. */
TEST(constraints_are_served)
{
    static const double xyz[3] = {0, 0, 0.1}, rpy[3] = {0, 0.5, 0};
    static const char *const actuated[] = {"joint_2", "joint_4"};
    tfa_constraint foot = {
        .name = "foot", .link = {"world", "tool0"}, .rows = 0x0f, .unilateral = 1};
    tfa_constraint_set_pose(foot.pose[0], NULL, rpy);
    tfa_constraint_set_pose(foot.pose[1], xyz, NULL);
    foot.link[0] = NULL;
    tfa_scene scene = {.constraints = &foot, .constraint_count = 1};
    const tfa_model_options options = {.scene = &scene};
    SCOPED_MODEL *whole = compile(ARM_FILE, NULL);
    SCOPED_MODEL *held = compile(ARM_FILE, &options);
    scene.actuated = actuated;
    scene.actuated_count = 2;
    SCOPED_MODEL *driven = compile(ARM_FILE, &options);
    SCOPED_HARNESS h = harness_serve(
        ARM "    scenes:\n      - name: held\n        constraints:\n"
            "          - {name: foot, first: {rpy: [0, 0.5, 0]}, hold: [point, rx],\n"
            "             second: {link: tool0, xyz: [0, 0, 0.1]}, unilateral: true}\n"
            "      - {name: driven, actuated: [joint_2, joint_4], constraints: [{name: foot, \n"
            "         first: {link: world, rpy: [0, 0.5, 0]}, hold: [x, y, z, rx], \n"
            "         second: {link: tool0, xyz: [0, 0, 0.1]}, unilateral: yes}]}\n",
        "");
    assert_serves(&h, "arm", whole);
    assert_serves(&h, "arm.held", held);
    assert_serves(&h, "arm.driven", driven);
    assert_int_equal(harness_log_lines(&h, "shares its constants"), 0);
    harness_reload(&h, ARM "    scenes: [{name: held}, {name: driven, actuated: [joint_2]}]\n", "");
    assert_true(harness_logged(&h, "reload: done, 2 of 3"));
    assert_serves(&h, "arm.held", whole);
}

/* ---- mistakes ---- */

/* A start and --check say the same. */
TEST(mistakes_are_named)
{
    static const struct {
        const char *yaml, *text;
    } cases[] = {
        {ARM "    scenes: [{name: s, payload: [{link: tool, mass: 1}]}]\n",
         "c.yaml:5:41: robot 'arm', scene 's': no link 'tool'; nearest: 'tool0', "},
        {ARM "    scenes: [{name: s, modes: [none.yaml]}]\n",
         "none.yaml: error: file: cannot be read: No such file"},
        {ARM "    scenes: [{name: s, tips: [tool0, tol0]}]\n",
         "c.yaml:5:38: robot 'arm', scene 's': no link 'tol0'; nearest: 'tool0', "},
        {ARM "    scenes: [{name: s, root: link3}]\n", "no link 'link3'; nearest: 'link_"},
        {ARM "    scenes: [{name: s, locked: [{joint: joint1, q: 1}]}]\n",
         "c.yaml:5:41: robot 'arm', scene 's': no joint 'joint1'; nearest: 'joint_"},
        {ARM "    scenes: [{name: s, locked: [{joint: joint_1, pose: [1, 2, 3]}]}]\n",
         "joint 'joint_1' stands at one `q`"},
        {ARM "    scenes: [{name: s, constraints: [{name: c, hold: x, second: {link: tol0}}]}]\n",
         "c.yaml:5:72: robot 'arm', scene 's': no link 'tol0'; nearest: 'tool0', "},
        {ARM "    scenes: [{name: s, constraints: [{name: c, hold: x, second: {}}]}]\n",
         "constraint 'c': both frames are of the world"},
        {ARM "    scenes: [{name: s, actuated: [joint_1, joint_8]}]\n",
         "c.yaml:5:44: robot 'arm', scene 's': no joint 'joint_8'; nearest: 'joint_"},
        {ARM "    scenes: [{name: s, actuated: [flange_joint]}]\n",
         "joint 'flange_joint': the scene says that it is actuated, but it is fixed in the file"},
        {ARM "    armature: [{joint: joint_8, value: 1}]\n",
         "c.yaml:5:24: robot 'arm': no joint 'joint_8'; nearest: 'joint_"},
        {ARM "    rotors: [{joint: joint_8, value: 1}]\n",
         "c.yaml:5:22: robot 'arm': no joint 'joint_8'; nearest: 'joint_"},
        {ARM "    scenes: [{name: s, payload: [{link: tool0, mass: 1, inertia: [1, 0, 0, 1, 0, "
             "-1]}]}]\n",
         "robot 'arm.s'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_HARNESS h = harness_make(cases[i].yaml, "");
        harness_assert_mistake(&h, cases[i].text);
    }
}

/* A start would end because of them; as an ordinary user it would not even look at `user`. */
TEST(users_and_groups_exist)
{
    static const struct {
        const char *more, *user, *group;
        int status;
    } cases[] = {
        {"user: nobody\n", NULL, NULL, 0},
        {"user: no-such-user\n", "c.yaml:2:7: user: there is no user 'no-such-user'", NULL, 2},
        {"group: no-such-group\n", NULL, "c.yaml:2:8: group: there is no group 'no-such-group'", 2},
        {"user: no-such-user\ngroup: no-such-group\n",
         "c.yaml:2:7: user: ", "c.yaml:3:8: group: ", 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_HARNESS h = harness_make(ARM, cases[i].more);
        assert_int_equal(harness_check(&h), cases[i].status);
        assert_true(!cases[i].user || harness_logged(&h, cases[i].user));
        assert_true(!cases[i].group || harness_logged(&h, cases[i].group));
    }
}

TEST(good_ones_pass_the_check)
{
    SCOPED_HARNESS h = harness_make(ARM "    scenes: [{name: s, gravity: [0, 0, -1]}]\n", "");
    assert_int_equal(harness_check(&h), 0);
    assert_true(harness_logged(&h, "robot 'arm.s'"));
}

/* ---- policies ---- */

#define INERTIA "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/>"
#define LINK(name, inertia)                                                                        \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/><origin xyz=\"0.1 0 0\"/>" inertia       \
    "</inertial></link>"
#define JOINT(name, parent, child, more)                                                           \
    "<joint name=\"" name "\" type=\"continuous\"><parent link=\"" parent                          \
    "\"/><child link=\"" child "\"/><axis xyz=\"0 1 0\"/>" more "</joint>"

/* @return freedoms of the robot as served, or -1: it is refused */
static int freedoms_with(const char *inner, const char *policy)
{
    char yaml[256], urdf[2048];
    int freedoms = -1;
    snprintf(yaml, sizeof yaml, "  - name: r\n    urdf: r.urdf\n%s", policy);
    SCOPED_HARNESS h = harness_make(yaml, "");
    snprintf(urdf, sizeof urdf, "<robot name=\"r\"><link name=\"base\"/>\n%s\n</robot>\n", inner);
    harness_write(&h, "r.urdf", urdf);
    if (harness_check(&h) == 0) {
        harness_start(&h, "r");
        SCOPED_CLIENT *client = harness_connect(&h, "r", TFA_WAIT_BLOCK);
        freedoms = (int)tfa_client_get_info(client)->v_count;
        assert_int_equal(harness_stop(&h, SIGTERM), 0);
    }
    return freedoms;
}

TEST(policies_count)
{
    static const char mimic[] = LINK("a", INERTIA) LINK("b", INERTIA) JOINT("j", "base", "a", "")
        JOINT("k", "a", "b", "<mimic joint=\"j\" multiplier=\"2\"/>");
    static const char wrong[] =
        LINK("a", "<inertia ixx=\"-1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>")
            JOINT("j", "base", "a", "");
    static const char leaf[] = LINK("a", INERTIA) "<link name=\"b\"/>" JOINT("j", "base", "a", "")
        JOINT("k", "a", "b", "");
    assert_int_equal(freedoms_with(mimic, ""), 2);
    assert_int_equal(freedoms_with(mimic, "    mimic: project\n"), 1);
    assert_int_equal(freedoms_with(mimic, "    mimic: lock\n"), 1);
    assert_int_equal(freedoms_with(wrong, ""), -1);
    assert_int_equal(freedoms_with(wrong, "    inertia: repair\n"), 1);
    assert_int_equal(freedoms_with(leaf, ""), -1);
    assert_int_equal(freedoms_with(leaf, "    lock_massless_leaves: yes\n"), 1);
}
