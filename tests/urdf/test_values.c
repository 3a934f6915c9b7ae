/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a good file turns into: every number to the bit, document order, tree, mimics, rotors.
 */
#include "comma.h"
#include "faults.h"
#include "models.h"
#include "test.h"

#include <locale.h>
#include <totalforce/model.h>

static tfa_description *parse_urdf(const char *text)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    int status = tfa_urdf_parse(text, strlen(text), "f.urdf", &d, &report);
    if (status != TFA_OK && report.count > 0)
        print_error("%s\n", report.messages[0].text);
    tfa_report_free(&report);
    assert_int_equal(status, TFA_OK);
    assert_non_null(d);
    return d;
}

/* Equal as bits: tells -0 from 0 and hides no rounding. */
static void assert_same(double a, double b)
{
    if (memcmp(&a, &b, sizeof a) != 0)
        fail_msg("%a is not %a", a, b);
}

static void assert_vector(const double *v, double x, double y, double z)
{
    assert_same(v[0], x);
    assert_same(v[1], y);
    assert_same(v[2], z);
}

static const char full[] =
    "<?xml version='1.0'?>\n"
    "<robot name=\"full\">\n"
    "<joint name=\"joint_10\" type=\"revolute\"><origin xyz=\"0.1 -0.2 1e-17\" rpy=\"0.3 0.5 "
    "-0.7\"/>\n"
    "<parent link=\"z\"/><child link=\"b\"/><axis xyz=\"0 0.6 0.8\"/>\n" LIMIT
    "<dynamics damping=\"0.7\" friction=\"0.1\"/></joint>\n"
    "<link name=\"z\"><inertial><origin xyz=\"1.1 2.2 3.3\" rpy=\"0 0 1.5707963267948966\"/>"
    "<mass value=\"3.0000000000000004\"/><inertia ixx=\"1.01\" ixy=\"0.02\" ixz=\"0.03\" "
    "iyy=\"1.04\" iyz=\"0.05\" izz=\"1.06\"/></inertial></link>\n"
    "<link name=\"b\"/>\n"
    "<joint name=\"joint_2\" type=\"prismatic\"><parent link=\"b\"/><child link=\"a\"/>" LIMIT
    "<mimic joint=\"joint_10\" multiplier=\"-2.5\" offset=\"0.125\"/></joint>\n"
    "<link name=\"a\"/><link name=\"c\"/><link name=\"d\"/><link name=\"e\"/>\n"
    "<joint name=\"joint_1\" type=\"fixed\"><parent link=\"a\"/><child link=\"c\"/></joint>\n"
    "<joint name=\"p\" type=\"planar\"><parent link=\"a\"/><child link=\"d\"/>"
    "<axis xyz=\"0 0 -1\"/></joint>\n"
    "<joint name=\"f\" type=\"floating\"><parent link=\"a\"/><child link=\"e\"/></joint>\n"
    "</robot>";

TEST(test_numbers_are_exact)
{
    tfa_description *d = parse_urdf(full);
    assert_string_equal(d->name, "full");
    const tfa_link *z = &d->links[0];
    assert_same(z->mass, 3.0000000000000004);
    assert_vector(z->com, 1.1, 2.2, 3.3);
    const double inertia[6] = {1.01, 0.02, 0.03, 1.04, 0.05, 1.06};
    assert_memory_equal(z->inertia, inertia, sizeof inertia);
    assert_true(fabs(z->quat[2] - sqrt(0.5)) < 1e-15 && fabs(z->quat[3] - sqrt(0.5)) < 1e-15);
    const tfa_joint *j = &d->joints[0];
    assert_vector(j->xyz, 0.1, -0.2, 1e-17);
    assert_true(fabs(j->axis[1] - 0.6) < 1e-15 && fabs(j->axis[2] - 0.8) < 1e-15);
    assert_same(j->damping, 0.7);
    assert_same(j->armature, 0);
    tfa_description_free(d);
}

/* R = Rz(yaw) Ry(pitch) Rx(roll) as a quaternion x y z w. */
TEST(test_rpy)
{
    tfa_description *d = parse_urdf(full);
    double a = 0.15, b = 0.25, c = -0.35;
    const double expected[4] = {
        sin(a) * cos(b) * cos(c) - cos(a) * sin(b) * sin(c),
        cos(a) * sin(b) * cos(c) + sin(a) * cos(b) * sin(c),
        cos(a) * cos(b) * sin(c) - sin(a) * sin(b) * cos(c),
        cos(a) * cos(b) * cos(c) + sin(a) * sin(b) * sin(c),
    };
    for (int i = 0; i < 4; i++)
        assert_true(fabs(d->joints[0].quat[i] - expected[i]) < 1e-15);
    const double identity[4] = {0, 0, 0, 1};
    assert_memory_equal(d->joints[1].quat, identity, sizeof identity);
    assert_memory_equal(d->links[1].quat, identity, sizeof identity);
    tfa_description_free(d);
}

/* quat_xyzw of URDF 1.1 in joint and inertial: the unit quaternion of that direction */
TEST(test_quaternions)
{
    static const struct {
        const char *text;
        double x, y, z, w;
    } rows[] = {
        {"0 0 0.6 0.8", 0, 0, 0.6, 0.8},
        {"-0.5 0.5 0.5 -0.5005", -0.5, 0.5, 0.5, -0.5005},
        {"0\t1 0\n0", 0, 1, 0, 0},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        char text[1000];
        snprintf(text, sizeof text,
                 "<robot name=\"r\" version=\"1.2\"><link name=\"a\"/>"
                 "<link name=\"b\"><inertial><origin quat_xyzw=\"%s\"/><mass value=\"1\"/>" INERTIA
                 "</inertial></link>" JOINT("j", "continuous", "a", "b",
                                            "<origin xyz=\"0 0 1\" quat_xyzw=\"%s\"/>") "</robot>",
                 rows[k].text, rows[k].text);
        tfa_description *d = parse_urdf(text);
        const double x = rows[k].x, y = rows[k].y, z = rows[k].z, w = rows[k].w;
        const double n = sqrt(x * x + y * y + z * z + w * w), wanted[4] = {x, y, z, w};
        for (int e = 0; e < 4; e++) {
            assert_true(fabs(d->joints[0].quat[e] - wanted[e] / n) < 2e-16);
            assert_same(d->joints[0].quat[e], d->links[1].quat[e]);
        }
        assert_vector(d->joints[0].xyz, 0, 0, 1);
        tfa_description_free(d);
    }
}

TEST(test_document_order)
{
    static const char *const links[] = {"z", "b", "a", "c", "d", "e"};
    static const char *const joints[] = {"joint_10", "joint_2", "joint_1", "p", "f"};
    static const tfa_joint_type types[] = {TFA_JOINT_REVOLUTE, TFA_JOINT_PRISMATIC, TFA_JOINT_FIXED,
                                           TFA_JOINT_PLANAR, TFA_JOINT_FLOATING};
    static const uint32_t ends[][2] = {{0, 1}, {1, 2}, {2, 3}, {2, 4}, {2, 5}};
    static const uint32_t lines[] = {3, 8, 10, 11, 12};
    tfa_description *d = parse_urdf(full);
    assert_int_equal(d->link_count, 6);
    assert_int_equal(d->joint_count, 5);
    for (size_t i = 0; i < d->link_count; i++)
        assert_string_equal(d->links[i].name, links[i]);
    for (size_t j = 0; j < d->joint_count; j++) {
        assert_string_equal(d->joints[j].name, joints[j]);
        assert_int_equal(d->joints[j].type, types[j]);
        assert_int_equal(d->joints[j].parent, ends[j][0]);
        assert_int_equal(d->joints[j].child, ends[j][1]);
        assert_int_equal(d->joints[j].line, lines[j]);
    }
    tfa_description_free(d);
}

TEST(test_mimic_and_defaults)
{
    tfa_description *d = parse_urdf(full);
    assert_int_equal(d->joints[0].mimic, -1);
    assert_same(d->joints[0].multiplier, 1);
    assert_same(d->joints[0].offset, 0);
    assert_int_equal(d->joints[1].mimic, 0);
    assert_same(d->joints[1].multiplier, -2.5);
    assert_same(d->joints[1].offset, 0.125);
    assert_vector(d->joints[1].axis, 1, 0, 0); /* URDF's default */
    assert_vector(d->joints[3].axis, 0, 0, -1);
    tfa_description_free(d);
}

TEST(test_axis_is_normalised)
{
    static const char *const axes[] = {"3 0 4", "1e-200 0 1e-200", "1e300 1e300 1e300",
                                       "0 0 1.0005", "0.577 0.577 0.577"};
    for (size_t i = 0; i < sizeof axes / sizeof *axes; i++) {
        char text[512];
        snprintf(
            text, sizeof text,
            ROBOT(LINK("a") LINK("b") JOINT("j", "continuous", "a", "b", "<axis xyz=\"%s\"/>")),
            axes[i]);
        tfa_description *d = parse_urdf(text);
        const double *axis = d->joints[0].axis;
        double square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
        assert_true(fabs(square - 1) < 1e-15);
        tfa_description_free(d);
    }
}

TEST(test_world)
{
    tfa_description *d = parse_urdf(ROBOT(LINK("a") LINK("b") JOINT("i", "fixed", "a", "b", "")
                                              JOINT("j", "floating", "world", "a", "")));
    assert_int_equal(d->link_count, 3);
    assert_string_equal(d->links[0].name, "world");
    assert_int_equal(d->links[0].line, 0);
    assert_same(d->links[0].mass, 0);
    assert_string_equal(d->links[d->joints[1].parent].name, "world");
    assert_string_equal(d->links[d->joints[1].child].name, "a");
    assert_string_equal(d->links[d->joints[0].child].name, "b");
    tfa_description_free(d);
}

/* Neither the order of the alphabet nor that of the numbers: that of the document, but a joint
 * comes after those that carry it. */
TEST(test_published_order)
{
    static const char text[] = ROBOT(MASSIVE("e") MASSIVE("d") MASSIVE("c") MASSIVE("b")
                                         MASSIVE("a") JOINT("joint_10", "continuous", "b", "c", "")
                                             JOINT("joint_2", "prismatic", "a", "d", LIMIT)
                                                 JOINT("joint_3", "revolute", "a", "b", LIMIT)
                                                     JOINT("joint_1", "continuous", "a", "e", ""));
    static const char *const order[] = {"joint_3", "joint_10", "joint_2", "joint_1"};
    tfa_description *d = parse_urdf(text);
    assert_string_equal(d->joints[0].name, "joint_10"); /* as declared */
    tfa_model *model = compiled(d, NULL);
    assert_int_equal(tfa_model_joint_count(model), 4);
    for (uint32_t j = 0; j < 4; j++) {
        assert_string_equal(tfa_model_joint(model, j).name, order[j]);
        assert_int_equal(tfa_model_find_joint(model, order[j]), j);
    }
    tfa_model_free(model);
    tfa_description_free(d);
}

TEST(test_damping_and_friction)
{
    tfa_description *d = parse_urdf(ROBOT(
        LINK("a") LINK("b") LINK("c") LINK("d") LINK("e")
            JOINT("i", "continuous", "a", "b", "<dynamics damping=\"0.1\" friction=\"2e-3\"/>")
                JOINT("j", "continuous", "b", "c", "<dynamics friction=\"1e-300\"/>")
                    JOINT("k", "continuous", "c", "d", "<dynamics damping=\"-0.3\"/>")
                        JOINT("l", "continuous", "d", "e", "<dynamics/>")));
    static const double damping[] = {0.1, 0, -0.3, 0};
    static const double friction[] = {2e-3, 1e-300, 0, 0};
    for (size_t j = 0; j < 4; j++) {
        assert_same(d->joints[j].damping, damping[j]);
        assert_same(d->joints[j].friction, friction[j]);
    }
    tfa_description_free(d);
}

static void assert_same_description(const tfa_description *a, const tfa_description *b)
{
    assert_int_equal(a->link_count, b->link_count);
    assert_int_equal(a->joint_count, b->joint_count);
    for (size_t i = 0; i < a->link_count; i++) {
        assert_string_equal(a->links[i].name, b->links[i].name);
        assert_int_equal(a->links[i].line, b->links[i].line);
        assert_same(a->links[i].mass, b->links[i].mass);
        assert_memory_equal(a->links[i].com, b->links[i].com, sizeof b->links[i].com);
        assert_memory_equal(a->links[i].inertia, b->links[i].inertia, sizeof b->links[i].inertia);
    }
    for (size_t j = 0; j < a->joint_count; j++) {
        assert_string_equal(a->joints[j].name, b->joints[j].name);
        assert_int_equal(a->joints[j].line, b->joints[j].line);
        assert_memory_equal(a->joints[j].xyz, b->joints[j].xyz, sizeof b->joints[j].xyz);
        assert_memory_equal(a->joints[j].quat, b->joints[j].quat, sizeof b->joints[j].quat);
        assert_memory_equal(a->joints[j].quat_low, b->joints[j].quat_low,
                            sizeof b->joints[j].quat_low);
        assert_memory_equal(a->joints[j].axis, b->joints[j].axis, sizeof b->joints[j].axis);
        assert_memory_equal(a->joints[j].axis_low, b->joints[j].axis_low,
                            sizeof b->joints[j].axis_low);
    }
}

/* `text` with every line end replaced by `end`; release with free(). */
static char *with_line_ends(const char *text, const char *end)
{
    char *out = malloc(2 * strlen(text) + 1);
    assert_non_null(out);
    char *at = out;
    for (; *text; text++)
        if (*text == '\n')
            at = stpcpy(at, end);
        else
            *at++ = *text;
    *at = '\0';
    return out;
}

TEST(test_line_ends)
{
    tfa_description *unix_style = parse_urdf(full);
    static const char *const ends[] = {"\r\n", "\r"};
    for (size_t i = 0; i < 2; i++) {
        char *text = with_line_ends(full, ends[i]);
        tfa_description *d = parse_urdf(text);
        assert_same_description(unix_style, d);
        tfa_description_free(d);
        free(text);
    }
    tfa_description_free(unix_style);
}

/* Of the actuator, of the joint, of the transmission; the first one counts, and of an actuator of
 * several joints none. A comment and blanks do not matter. */
TEST(test_reductions)
{
    static const char transmissions[] =
        "<transmission><type>t</type><joint name=\"i\"><hardwareInterface>e</hardwareInterface>"
        "</joint><actuator name=\"i\"> <mechanicalReduction> -1.5e2<!-- turns -->\n"
        "</mechanicalReduction></actuator></transmission>"
        "<transmission><joint name=\"j\"><mechanicalReduction>50.25</mechanicalReduction></joint>"
        "<actuator><mechanicalReduction>-50.25</mechanicalReduction></actuator></transmission>"
        "<transmission><mechanicalReduction>7</mechanicalReduction><joint name=\"k\"/>"
        "</transmission><transmission><joint name=\"k\"/>"
        "<actuator><mechanicalReduction>8</mechanicalReduction></actuator></transmission>"
        "<transmission><joint name=\"l\"/><joint name=\"m\"><mechanicalReduction>3"
        "</mechanicalReduction></joint><actuator><mechanicalReduction>9</mechanicalReduction>"
        "</actuator></transmission></robot>";
    static const char robot[] = ROBOT(LINK("a") LINK("b") JOINT("i", "continuous", "a", "b", "")
                                          LINK("c") JOINT("j", "continuous", "b", "c", "") LINK("d")
                                              JOINT("k", "continuous", "c", "d", "") LINK("e")
                                                  JOINT("l", "continuous", "d", "e", "") LINK("f")
                                                      JOINT("m", "continuous", "e", "f", ""));
    static const double want[] = {-150, 50.25, 7, 0, 3};
    char text[sizeof robot + sizeof transmissions];
    const int length = (int)(strstr(robot, "</robot>") - robot);
    snprintf(text, sizeof text, "%.*s%s", length, robot, transmissions);
    tfa_description *d = parse_urdf(text);
    for (size_t j = 0; j < sizeof want / sizeof *want; j++)
        assert_same(d->joints[j].reduction, want[j]);
    tfa_description_free(d);
}

/* rotor = rotor inertia times the gear ratio squared, summed over a joint's actuators */
TEST(test_rotors)
{
    tfa_description *d = parse_urdf(ROBOT(
        LINK("a") LINK("b") LINK("c") JOINT("i", "continuous", "a", "b",
                                            "<drake:rotor_inertia value=\"0.25\"/>")
            JOINT("j", "continuous", "b", "c", "") "<transmission><joint name=\"j\"/>"
                                                   "<actuator name=\"m\">"
                                                   "<drake:rotor_inertia value=\"0.5\"/>"
                                                   "<drake:gear_ratio value=\"-4\"/></actuator>"
                                                   "<actuator name=\"n\">"
                                                   "<drake:rotor_inertia value=\"1\"/></actuator>"
                                                   "</transmission>"));
    assert_same(d->joints[0].rotor, 0.25);
    assert_same(d->joints[1].rotor, 9);
    assert_same(d->joints[1].armature, 0);
    tfa_description_free(d);
}

TEST(test_names_come_out_unchanged)
{
    tfa_description *d = parse_urdf(ROBOT(LINK("a &lt;&amp;#x41;&quot;'&gt; &#xE9; \xC3\xA9/[] ")));
    assert_string_equal(d->links[0].name, "a <&#x41;\"'> \xC3\xA9 \xC3\xA9/[] ");
    tfa_description_free(d);
}

static void check_decimal_point(void)
{
    tfa_description *d = parse_urdf(full);
    assert_same(d->links[0].mass, 3.0000000000000004);
    assert_vector(d->joints[0].xyz, 0.1, -0.2, 1e-17);
    tfa_description_free(d);
    tfa_report report = {0};
    const char *bad = MASS("1,5");
    assert_int_equal(tfa_urdf_parse(bad, strlen(bad), NULL, &d, &report), TFA_E_PARSE);
    tfa_report_free(&report);
}

/* A decimal comma in the locale changes neither what is accepted nor what is read. */
TEST(test_locale_of_streams)
{
    comma_set(true);
    bool set = comma_is_set();
    check_decimal_point();
    comma_set(false);
    assert_true(set);
}

/* Numbers in messages have a point as well. */
static void check_printed_point(void)
{
    static const char text[] = TWO("continuous", "<axis xyz=\"0 0 2.5\"/>");
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_parse(text, strlen(text), NULL, &d, &report), TFA_OK);
    assert_int_equal(report.count, 1);
    assert_string_equal(report.messages[0].text, "joint 'j': axis has the length 2.5 and is "
                                                 "normalised; write a unit vector");
    tfa_description_free(d);
    tfa_report_free(&report);
}

/* Sets a C locale with a decimal comma: an installed one, or one made in `folder`. */
static bool set_comma_locale(const char *folder)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (setlocale(LC_ALL, names[i]) && localeconv()->decimal_point[0] == ',')
            return true;
    char command[256];
    snprintf(command, sizeof command,
             "localedef --no-archive -i de_DE -f UTF-8 %s/de_DE.UTF-8 >/dev/null 2>&1", folder);
    if (system(command) != 0)
        return false;
    setenv("LOCPATH", folder, 1);
    return setlocale(LC_ALL, "de_DE.UTF-8") && localeconv()->decimal_point[0] == ',';
}

TEST(test_locale_of_c)
{
    char folder[] = "/tmp/tfa-locale-XXXXXX";
    assert_non_null(mkdtemp(folder));
    bool set = set_comma_locale(folder);
    if (set) {
        check_decimal_point();
        check_printed_point();
    }
    setlocale(LC_ALL, "C");
    unsetenv("LOCPATH");
    char command[64];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
    if (!set) {
        print_message("skipped: no locale with a decimal comma, nor the means to make one\n");
        skip();
    }
}

/* ---- loop joints ---- */

static void assert_near(const double *v, double x, double y, double z, double w)
{
    const double want[4] = {x, y, z, w};
    double dot = 0;
    for (int k = 0; k < 4; k++)
        dot += v[k] * want[k];
    if (fabs(fabs(dot) - 1) > 1e-15)
        fail_msg("%g %g %g %g is not the rotation %g %g %g %g", v[0], v[1], v[2], v[3], x, y, z, w);
}

/* z of the frame of a side, in its link */
static void assert_z(const tfa_constraint *c, int side, double x, double y, double z)
{
    const double *q = c->pose[side] + 3;
    const double have[3] = {2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]),
                            q[3] * q[3] + q[2] * q[2] - q[0] * q[0] - q[1] * q[1]};
    if (fabs(have[0] - x) + fabs(have[1] - y) + fabs(have[2] - z) > 1e-15)
        fail_msg("z is %g %g %g, not %g %g %g", have[0], have[1], have[2], x, y, z);
}

#define TURNED                                                                                     \
    "<joint name=\"t\" type=\"continuous\"><parent link=\"a\"/><child link=\"c\"/><origin "        \
    "rpy=\"1.5707963267948966 0 0\"/></joint>\n"

/* Frames of the file, turned so that z is the axis; both in the same way. */
TEST(test_loop_joints)
{
    const double half = sqrt(0.5);
    tfa_description *d = parse_urdf(ROBOT(
        LINK("a") LINK("b") LINK("c") JOINT("j", "continuous", "a", "b", "") TURNED
        "<loop_joint name=\"drake\" type=\"continuous\"><link1 link=\"b\" xyz=\"1 2 3\" "
        "rpy=\"0 0 1.5707963267948966\"/><link2 link=\"c\" xyz=\"4 5 6\"/></loop_joint>\n"
        "<loop_joint name=\"isaac\" type=\"spherical\"><link1 link=\"world\"/><link1 "
        "link=\"c\" rpy=\"1.5707963267948966 0 0\"/><axis xyz=\"0 0 9\"/></loop_joint>\n"
        "<loop_joint name=\"fusion\" type=\"revolute\"><parent link=\"b\"/><child link=\"c\"/>"
        "<parent_origin xyz=\"1 0 0\"/><child_origin xyz=\"0 0 1\"/><axis xyz=\"0 -0.6 -0.8\" "
        "frame=\"parent\"/></loop_joint>\n"
        "<loop_joint name=\"slide\" type=\"prismatic\"><parent link=\"b\"/><child link=\"c\"/>"
        "<origin xyz=\"7 0 0\"/><axis xyz=\"0 0 -1\"/></loop_joint>\n"
        "<loop_joint name=\"glue\" type=\"fixed\"><link1 link=\"a\"/><link2 link=\"b\"/>"
        "</loop_joint>\n"));
    const tfa_constraint *c = d->constraints;
    assert_int_equal(d->constraint_count, 5);
    assert_string_equal(c[0].name, "drake");
    assert_string_equal(c[0].link[0], "b");
    assert_string_equal(c[0].link[1], "c");
    assert_int_equal(c[0].rows, TFA_CONSTRAINT_HINGE);
    assert_int_equal(c[0].line, 7);
    assert_vector(c[0].pose[0], 1, 2, 3);
    assert_vector(c[0].pose[1], 4, 5, 6);
    assert_z(&c[0], 0, 0, 1, 0); /* x of a frame turned about z */
    assert_z(&c[0], 1, 1, 0, 0);
    assert_null(c[1].link[0]);
    assert_int_equal(c[1].rows, TFA_CONSTRAINT_POINT);
    assert_near(c[1].pose[0] + 3, 0, 0, 0, 1);
    assert_near(c[1].pose[1] + 3, half, 0, 0, half);
    assert_int_equal(c[2].rows, TFA_CONSTRAINT_HINGE);
    assert_vector(c[2].pose[1], 0, 0, 1);
    assert_z(&c[2], 0, 0, -0.6, -0.8);
    assert_z(&c[2], 1, 0, -0.8, 0.6); /* c is turned about x against b, at 0 */
    assert_int_equal(c[3].rows, 0x3b);
    assert_vector(c[3].pose[0], 7, 0, 0);
    assert_vector(c[3].pose[1], 0, 0, 0);
    assert_z(&c[3], 0, 0, 0, -1);
    assert_int_equal(c[4].rows, TFA_CONSTRAINT_WELD);
    assert_near(c[4].pose[1] + 3, 0, 0, 0, 1);
    for (size_t k = 0; k < d->constraint_count; k++)
        assert_int_equal(c[k].unilateral, 0);
    tfa_description_free(d);
}
