/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every way to write a number wrong in every attribute that decides the robot: message, line, code.
 */
#include "faults.h"
#include "test.h"

#include <totalforce/description.h>

/* A robot with every attribute on a line of its own. */
static const char *const lines[] = {
    "<robot name=\"r\"><link name=\"arm\"><inertial><origin",
    " xyz=\"0.1 0.2 0.3\"",
    " rpy=\"1 -2 3e-1\"",
    "/><mass",
    " value=\"1.25\"",
    "/><inertia",
    " ixx=\"0.1\"",
    " ixy=\"0.01\"",
    " ixz=\"-0.01\"",
    " iyy=\"0.1\"",
    " iyz=\"0\"",
    " izz=\"0.1\"",
    "/></inertial></link><link name=\"b\"/><link name=\"c\"/>"
    "<joint name=\"i\" type=\"continuous\"><parent link=\"arm\"/><child link=\"b\"/></joint>"
    "<joint name=\"j\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/><origin",
    " xyz=\"0 0 1\"",
    " rpy=\"0 0 0\"",
    "/><axis",
    " xyz=\"0 1 0\"",
    "/><dynamics",
    " damping=\"0.5\"",
    " friction=\"0\"",
    "/><mimic joint=\"i\"",
    " multiplier=\"2\"",
    " offset=\"0.1\"",
    "/><drake:rotor_inertia",
    " value=\"1e-5\"",
    "/></joint></robot>",
};
enum { LINES = sizeof lines / sizeof *lines };

static const struct {
    const char *value;   /* in the file */
    const char *printed; /* in messages */
    const char *code;
    const char *what;
} faults[] = {
    {"1,5", "1,5", BAD, NOT_A_NUMBER},
    {"nan", "nan", BAD, NOT_A_NUMBER},
    {"-NaN", "-NaN", BAD, NOT_A_NUMBER},
    {"inf", "inf", BAD, NOT_A_NUMBER},
    {"Infinity", "Infinity", BAD, NOT_A_NUMBER},
    {"0x1p3", "0x1p3", BAD, NOT_A_NUMBER},
    {"0x10", "0x10", BAD, NOT_A_NUMBER},
    {"1.5kg", "1.5kg", BAD, NOT_A_NUMBER},
    {"1.2.3", "1.2.3", BAD, NOT_A_NUMBER},
    {"1e", "1e", BAD, NOT_A_NUMBER},
    {"\xC2\xBD", "\xC2\xBD", BAD, NOT_A_NUMBER},
    {"\xE2\x88\x92"
     "1",
     "\xE2\x88\x92"
     "1",
     BAD, NOT_A_NUMBER}, /* a typographic minus */
    {"1e-400", "1e-400", "underflow",
     "is smaller than any number of double precision; write 0 if that is meant"},
    {"-1e999", "-1e999", "overflow", "is larger than any number of double precision; correct it"},
};
enum { FAULTS = sizeof faults / sizeof *faults };

/* The value in line i is replaced. Release with free(). */
static char *robot_with(size_t i, const char *value)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    assert_non_null(out);
    for (size_t k = 0; k < LINES; k++)
        if (k == i)
            fprintf(out, "%.*s\"%s\"\n", (int)strcspn(lines[k], "\""), lines[k], value);
        else
            fprintf(out, "%s\n", lines[k]);
    assert_int_equal(fclose(out), 0);
    return text;
}

/* The element that the attribute in line i belongs to. */
static void element_of(size_t i, char *name, size_t size)
{
    while (lines[i][0] == ' ')
        i--;
    const char *start = strrchr(lines[i], '<') + 1;
    snprintf(name, size, "%.*s", (int)strcspn(start, " "), start);
}

static void expect(size_t i, const char *value, const char *code, const char *message)
{
    char *text = robot_with(i, value);
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_parse(text, strlen(text), "f.urdf", &d, &report), TFA_E_PARSE);
    assert_null(d);
    for (size_t k = 0; report.count != 2 && k < report.count; k++)
        print_error("%s\n", report.messages[k].text);
    assert_int_equal(report.count, 2);
    assert_string_equal(report.messages[1].code, "refused");
    char got[2048];
    char want[2048];
    tfa_report_format(&report, 0, got, sizeof got);
    snprintf(want, sizeof want, "f.urdf:%zu: error: %s [%s]", i + 1, message, code);
    assert_string_equal(got, want);
    tfa_report_free(&report);
    free(text);
}

static const char *owner_of(size_t i)
{
    return i < LINES / 2 ? "link 'arm'" : "joint 'j'";
}

static void check_attribute(size_t i)
{
    int name = (int)strcspn(lines[i] + 1, "=");
    int vector = strchr(lines[i] + 1, ' ') != NULL;
    char element[64];
    element_of(i, element, sizeof element);
    for (size_t f = 0; f < FAULTS; f++) {
        char value[128];
        char message[1024];
        const char *printed = faults[f].printed;
        snprintf(value, sizeof value, vector ? "0 %s 1" : "%s", faults[f].value);
        if (vector)
            snprintf(message, sizeof message, "%s: %.*s=\"0 %s 1\" of <%s>: \"%s\" %s", owner_of(i),
                     name, lines[i] + 1, printed, element, printed, faults[f].what);
        else
            snprintf(message, sizeof message, "%s: %.*s=\"%s\" of <%s> %s", owner_of(i), name,
                     lines[i] + 1, printed, element, faults[f].what);
        expect(i, value, faults[f].code, message);
    }
    char message[1024];
    snprintf(message, sizeof message,
             "%s: %.*s=\"${m + 1}\" of <%s> is an unexpanded xacro expression; run xacro first: "
             "xacro f.urdf > f.urdf.urdf",
             owner_of(i), name, lines[i] + 1, element);
    expect(i, "${m + 1}", "xacro", message);
}

TEST(test_every_attribute)
{
    size_t attributes = 0;
    for (size_t i = 0; i < LINES; i++) {
        if (lines[i][0] != ' ')
            continue;
        check_attribute(i);
        attributes++;
    }
    assert_int_equal(attributes, 17);
}

TEST(test_every_vector)
{
    static const struct {
        const char *value;
        const char *count;
    } wrong[] = {
        {"", "0"}, {"1", "1"}, {"1 2", "2"}, {"1 2 3 4", "4"}, {"1 2 3 4 5 6", "more than 4"}};
    size_t vectors = 0;
    for (size_t i = 0; i < LINES; i++) {
        if (lines[i][0] != ' ' || !strchr(lines[i] + 1, ' '))
            continue;
        vectors++;
        char element[64];
        element_of(i, element, sizeof element);
        for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
            char message[1024];
            snprintf(message, sizeof message,
                     "%s: %.3s=\"%s\" of <%s> has %s numbers; write three with blanks between them",
                     owner_of(i), lines[i] + 1, wrong[k].value, element, wrong[k].count);
            expect(i, wrong[k].value, "bad-vector", message);
        }
    }
    assert_int_equal(vectors, 5);
}

static tfa_description *parse_urdf(const char *text, size_t warnings)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_parse(text, strlen(text), NULL, &d, &report), TFA_OK);
    assert_int_equal(report.count, warnings);
    for (size_t k = 0; k < report.count; k++)
        assert_string_equal(report.messages[k].code, "white-space");
    tfa_report_free(&report);
    return d;
}

static void expect_same(const tfa_description *a, const tfa_description *b)
{
    const size_t mass = offsetof(tfa_link, mass), xyz = offsetof(tfa_joint, xyz);
    for (size_t k = 0; k < a->link_count; k++)
        assert_memory_equal((const char *)&a->links[k] + mass, (const char *)&b->links[k] + mass,
                            offsetof(tfa_link, last_digit) - mass);
    for (size_t k = 0; k < a->joint_count; k++)
        assert_memory_equal((const char *)&a->joints[k] + xyz, (const char *)&b->joints[k] + xyz,
                            sizeof(tfa_joint) - xyz);
}

/* White space around and between the numbers changes no bit. */
TEST(test_white_space)
{
    char *plain = robot_with(LINES, "");
    tfa_description *want = parse_urdf(plain, 0);
    for (size_t i = 0; i < LINES; i++) {
        char value[64];
        if (lines[i][0] != ' ')
            continue;
        const char *start = strchr(lines[i], '"') + 1;
        snprintf(value, sizeof value, "\n %.*s\r\n&#9;", (int)strcspn(start, "\""), start);
        for (char *c = value + 2; *c; c++)
            *c = *c == ' ' ? '\t' : *c;
        char *text = robot_with(i, value);
        tfa_description *d = parse_urdf(text, 1);
        expect_same(d, want);
        tfa_description_free(d);
        free(text);
    }
    tfa_description_free(want);
    free(plain);
}

/* As it stands the robot is good: the tests above fail for one reason only. */
TEST(test_unchanged)
{
    char *text = robot_with(LINES, "");
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_parse(text, strlen(text), "f.urdf", &d, &report), TFA_OK);
    assert_int_equal(report.count, 0);
    assert_int_equal(d->joint_count, 2);
    tfa_description_free(d);
    tfa_report_free(&report);
    free(text);
}
