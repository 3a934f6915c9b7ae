/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Side files of constraints: what arrives, and a table of mistakes with what is said about each.
 */
#include "test.h"

#include <math.h>
#include <totalforce/constraints.h>

#define ONE(rest) "constraints:\n  - {name: c, second: {link: a}, " rest "}\n"

static const struct {
    const char *text;
    int status;
    unsigned line;
    const char *message; /* of the first error: a part of it */
} rows[] = {
    {"{}\n", TFA_OK, 0, ""},
    {"constraints: []\nactuated: []\n", TFA_OK, 0, ""},
    {ONE("hold: point"), TFA_OK, 0, ""},
    {"{\"actuated\": [\"j\"], \"constraints\": [{\"name\": \"c\", \"second\": {\"rpy\": [0, 0, "
     "1e-3]}, \"hold\": [\"x\"]}]}",
     TFA_OK, 0, ""},
    {"", TFA_E_PARSE, 1, "column 1: no keys; the file is empty"},
    {"constraints: &x []\n", TFA_E_PARSE, 1, "anchors (&) and aliases (*) are not read here"},
    {"3\n", TFA_E_PARSE, 1, "column 1: keys are expected here: 'constraints: [{name: ..}, ..]'"},
    {"constraint: []\n", TFA_E_PARSE, 1, "column 1: there is no key 'constraint'; write 'constr"},
    {"constraints: {}\n", TFA_E_PARSE, 1, "column 14: constraints: a list is expected here"},
    {"constraints: [3]\n", TFA_E_PARSE, 1,
     "column 15: constraints[0]: keys are expected here: 'name', 'second', 'hold'"},
    {"actuated: j\n", TFA_E_PARSE, 1, "column 11: actuated: a list is expected here"},
    {"actuated: [j, [k]]\n", TFA_E_PARSE, 1, "column 15: actuated: a name is expected here"},
    {"constraints: [{second: {}, hold: x}]\n", TFA_E_PARSE, 1,
     "column 15: constraints[0]: the key 'name' is missing; write 'name', 'second', 'hold'"},
    {"constraints: [{name: c, hold: x}]\n", TFA_E_PARSE, 1, "the key 'second' is missing"},
    {"constraints: [{name: c, second: {}}]\n", TFA_E_PARSE, 1, "the key 'hold' is missing"},
    {ONE("hold: x, name: d"), TFA_E_PARSE, 2, "constraints[0]: name: it is there twice"},
    {ONE("hold: x, bilateral: true"), TFA_E_PARSE, 2, "there is no key 'bilateral'"},
    {ONE("hold: points"), TFA_E_PARSE, 2,
     "column 40: constraints[0].hold: 'points' is not one of point, hinge, weld, x, y, z, rx, ry, "
     "rz"},
    {ONE("hold: [x, w]"), TFA_E_PARSE, 2, "column 44: constraints[0].hold: 'w' is not one of"},
    {ONE("hold: [[x]]"), TFA_E_PARSE, 2, "constraints[0].hold: '..' is not one of"},
    {ONE("hold: []"), TFA_E_PARSE, 2, "constraints[0].hold: it holds nothing; write point"},
    {ONE("hold: x, unilateral: yes"), TFA_E_PARSE, 2,
     "constraints[0].unilateral: 'yes' is not one of true, false"},
    {ONE("hold: x, first: a"), TFA_E_PARSE, 2,
     "constraints[0].first: keys are expected here: 'link: LINK', 'xyz: [x, y, z]'"},
    {ONE("hold: x, first: {links: a}"), TFA_E_PARSE, 2, "first: there is no key 'links'"},
    {ONE("hold: x, first: {link: ''}"), TFA_E_PARSE, 2, "first.link: a name is expected here"},
    {ONE("hold: x, first: {xyz: [0, 1]}"), TFA_E_PARSE, 2,
     "constraints[0].first.xyz: 2 numbers where 3 are expected: m"},
    {ONE("hold: x, first: {rpy: 1}"), TFA_E_PARSE, 2, "first.rpy: 0 numbers where 3 are expected"},
    {ONE("hold: x, first: {rpy: [0, 0, .nan]}"), TFA_E_PARSE, 2,
     "constraints[0].first.rpy: '.nan' is not a finite number"},
};

TEST(mistakes_are_named)
{
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_report report = {0};
        tfa_constraints c = {0};
        tfa_report_set_file(&report, "robot.urdf");
        const int status =
            tfa_constraints_parse(rows[k].text, strlen(rows[k].text), "f.yaml", &c, &report);
        const tfa_message *first = report.count ? report.messages : NULL;
        const int good = rows[k].status == TFA_OK;
        if (status != rows[k].status || (first == NULL) != good ||
            (!good && (c.count || c.actuated_count)) ||
            strcmp(report.file, good ? "robot.urdf" : "f.yaml") != 0 ||
            (first && (first->line != rows[k].line || !strstr(first->text, rows[k].message) ||
                       strcmp(first->code, "constraints") != 0)))
            fail_msg("row %zu: %s, line %u: %s\n%s", k, tfa_status_name(status),
                     first ? first->line : 0, first ? first->text : "", rows[k].text);
        tfa_constraints_free(&c);
        tfa_report_free(&report);
    }
}

static void parse(const char *text, tfa_constraints *constraints)
{
    tfa_report report = {0};
    assert_int_equal(tfa_constraints_parse(text, strlen(text), NULL, constraints, &report), TFA_OK);
    assert_int_equal(report.count, 0);
    tfa_report_free(&report);
}

/* Values arrive where tfa_constraint has them; a second file is appended, a refused one is not. */
TEST(values_arrive)
{
    static const double foot[7] = {0, 0, -0.05, 0, 0, 0, 1};
    const double half = 0.7071067811865476;
    tfa_constraints c = {0};
    tfa_report report = {0};
    parse("constraints: [{name: foot, second: {link: sole, xyz: [0, 0, -0.05]}, hold: point,\n"
          "               unilateral: true}]\nactuated: [hip, knee]\n",
          &c);
    parse("constraints:\n  - name: grip\n    first: {link: left, rpy: [0, 1.5707963267948966, 0]}\n"
          "    second: {link: world, xyz: [1, 2, 3]}\n    hold: [z, rx, point]\n"
          "    unilateral: false\nactuated: [ankle]\n",
          &c);
    assert_int_equal(tfa_constraints_parse("actuated: 3", 11, NULL, &c, &report), TFA_E_PARSE);
    tfa_report_free(&report);
    assert_int_equal(c.count, 2);
    assert_string_equal(c.list[0].name, "foot");
    assert_null(c.list[0].link[0]);
    assert_string_equal(c.list[0].link[1], "sole");
    assert_memory_equal(c.list[0].pose[1], foot, sizeof foot);
    assert_int_equal(c.list[0].rows, TFA_CONSTRAINT_POINT);
    assert_int_equal(c.list[0].unilateral, 1);
    assert_string_equal(c.list[1].link[0], "left");
    assert_null(c.list[1].link[1]);
    assert_true(fabs(c.list[1].pose[0][4] - half) < 1e-15);
    assert_true(c.list[1].pose[1][2] == 3 && c.list[1].pose[1][6] == 1);
    assert_int_equal(c.list[1].rows, 0x0f);
    assert_int_equal(c.list[1].unilateral, 0);
    assert_int_equal(c.actuated_count, 3);
    assert_string_equal(c.actuated[1], "knee");
    assert_string_equal(c.actuated[2], "ankle");
    tfa_constraints_free(&c);
}

/* Files that are missing, too large, or have too many entries */
TEST(files_are_bounded)
{
    tfa_constraints c = {0};
    tfa_report report = {0};
    const size_t size = TFA_CONSTRAINTS_MAX_BYTES + 1;
    char *text = malloc(size + 1);
    assert_non_null(text);
    memset(text, '#', size);
    assert_int_equal(tfa_constraints_parse(text, size, "f", &c, &report), TFA_E_FILE);
    assert_string_equal(report.messages[0].code, "too-large");
    tfa_report_free(&report);
    size_t used = (size_t)sprintf(text, "actuated: [");
    for (int k = 0; k <= 10000; k++)
        used += (size_t)sprintf(text + used, "j, ");
    strcpy(text + used, "]");
    assert_int_equal(tfa_constraints_parse(text, strlen(text), "f", &c, &report), TFA_E_PARSE);
    assert_non_null(strstr(report.messages[0].text, "10001 entries; a file has at most 10000"));
    tfa_report_free(&report);
    assert_int_equal(tfa_constraints_load("/nowhere/f.yaml", &c, &report), TFA_E_FILE);
    assert_string_equal(report.file, "/nowhere/f.yaml");
    tfa_report_free(&report);
    assert_int_equal(tfa_constraints_load(NULL, &c, &report), TFA_E_ARGUMENT);
    free(text);
    tfa_constraints_free(&c);
    tfa_constraints_free(NULL);
}
