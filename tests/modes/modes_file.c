/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Side files of modes: what arrives, and a table of mistakes with what is said about each.
 */
#include "test.h"

#include <math.h>
#include <totalforce/modes.h>

/* Modes of link `a` begin in line 4. */
#define LINK "links:\n  a:\n    modes:\n"
#define MODE                                                                                       \
    "      - {momentum: [0, 1, 0, 0, 0, 2], mass: 3, stiffness: 4, shape: {j: [0, 1, 0, 0, 0, "    \
    "5]}}\n"
#define WITH(momentum, mass, rest)                                                                 \
    LINK "      - {momentum: " momentum ", mass: " mass ", stiffness: 4" rest "}\n"
#define GOOD_MOMENTUM "[0, 1, 0, 0, 0, 2]"

static const struct {
    const char *text;
    int status;
    unsigned line;
    const char *message; /* of the first error: a part of it */
} rows[] = {
    {"links: {}\n", TFA_OK, 0, ""},
    {LINK MODE, TFA_OK, 0, ""},
    {WITH(GOOD_MOMENTUM, "3", ", shape: {}"), TFA_OK, 0, ""},
    {"{\"links\": {\"a\": {\"modes\": [{\"momentum\": [0, 0, 0, 0, 0, 0], \"mass\": [1.0], "
     "\"stiffness\": [2e3], \"shape\": {}}]}}}",
     TFA_OK, 0, ""},
    {"", TFA_E_PARSE, 1, "column 1: no keys; the file is empty"},
    {"links: [\n", TFA_E_PARSE, 2, "this is not YAML: "},
    {LINK "\t- 1\n", TFA_E_PARSE, 4, "column 1: this is not YAML: "},
    {LINK MODE "---\n" LINK MODE, TFA_E_PARSE, 6, "a second document"},
    {"links: &x {}\n", TFA_E_PARSE, 1, "column 8: anchors (&) and aliases (*) are not read here"},
    {"links: *x\n", TFA_E_PARSE, 1, "column 8: anchors (&) and aliases (*) are not read here"},
    {"[[[[[[[[[1]]]]]]]]]", TFA_E_PARSE, 1, "more than 8 levels deep"},
    {"3\n", TFA_E_PARSE, 1, "column 1: keys are expected here: 'links: {LINK: {modes: [..]}}'"},
    {"link: {}\n", TFA_E_PARSE, 1, "column 1: there is no key 'link'; write 'links: "},
    {"{}\n", TFA_E_PARSE, 1, "column 1: the key 'links' is missing; write 'links: "},
    {"links: {}\nlinks: {}\n", TFA_E_PARSE, 2,
     "column 1: links: it is there twice, first in line 1"},
    {"links: 3\n", TFA_E_PARSE, 1, "column 8: links: keys are expected here: 'LINK: "},
    {LINK MODE "  a: {modes: []}\n", TFA_E_PARSE, 5, "column 3: links: link 'a' is there twice"},
    {"links: {\"a\\0b\": {}}\n", TFA_E_PARSE, 1, "column 9: links: link '?' is no text"},
    {"links: {a: {}}\n", TFA_E_PARSE, 1,
     "column 12: links.a: 0 modes; a list of 1 to 12 is expected"},
    {"links: {a: {modes: 3}}\n", TFA_E_PARSE, 1, "column 20: links.a: 0 modes; a list of 1 to 12"},
    {"links: {a: {modes: [1,1,1,1,1,1,1,1,1,1,1,1,1]}}\n", TFA_E_PARSE, 1, "links.a: 13 modes;"},
    {LINK "      - 3\n", TFA_E_PARSE, 4,
     "column 9: links.a.modes[0]: keys are expected here: 'momentum', 'mass', "},
    {WITH("[0, 1, 0]", "3", ", shape: {}"), TFA_E_PARSE, 4,
     "column 20: links.a.modes[0].momentum: 3 numbers where 6 are expected: [lx, ly, lz, ax, ay, "
     "az]"},
    {WITH("1", "3", ", shape: {}"), TFA_E_PARSE, 4, "links.a.modes[0].momentum: 0 numbers where 6"},
    {WITH(GOOD_MOMENTUM, "[3, 4]", ", shape: {}"), TFA_E_PARSE, 4,
     "column 46: links.a.modes[0].mass: 2 numbers where 1 are expected: a row, one for each mode"},
    {WITH(GOOD_MOMENTUM, "3 kg", ", shape: {}"), TFA_E_PARSE, 4,
     "links.a.modes[0].mass: '3 kg' is not a finite number; write it like 2.5 or -1e-3"},
    {WITH(GOOD_MOMENTUM, ".inf", ", shape: {}"), TFA_E_PARSE, 4, "'.inf' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "1e999", ", shape: {}"), TFA_E_PARSE, 4, "'1e999' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "{b: 1}", ", shape: {}"), TFA_E_PARSE, 4, "'{..}' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "\"a\\nb\"", ", shape: {}"), TFA_E_PARSE, 4,
     "'a?b' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "3", ", damping: ~, shape: {}"), TFA_E_PARSE, 4,
     "links.a.modes[0].damping: '~' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "3", ", limit: [1], shape: {}"), TFA_E_PARSE, 4,
     "links.a.modes[0].limit: '[..]' is not a finite number"},
    {WITH(GOOD_MOMENTUM, "3", ", mas: 3, shape: {}"), TFA_E_PARSE, 4,
     "column 63: links.a.modes[0]: there is no key 'mas'; write 'momentum', 'mass', "},
    {WITH(GOOD_MOMENTUM, "3", ", mass: 3, shape: {}"), TFA_E_PARSE, 4,
     "links.a.modes[0]: mass: it is there twice, first in line 4"},
    {WITH(GOOD_MOMENTUM, "3", ""), TFA_E_PARSE, 4,
     "column 9: links.a.modes[0]: the key 'shape' is missing; write 'momentum', "},
    {WITH(GOOD_MOMENTUM, "3", ", shape: [1]"), TFA_E_PARSE, 4,
     "links.a.modes[0].shape: keys are expected here: 'JOINT: [dx, dy, dz, tx, ty, tz]'"},
    {WITH(GOOD_MOMENTUM, "3", ", shape: {j: [1]}"), TFA_E_PARSE, 4,
     "links.a.modes[0].shape: 1 numbers where 6 are expected: [dx, dy, dz, tx, ty, tz]"},
    {WITH(GOOD_MOMENTUM, "3", ", shape: {j: [0,0,0,0,0,0], j: [0,0,0,0,0,0]}"), TFA_E_PARSE, 4,
     "links.a.modes[0].shape: joint 'j' is there twice"},
    {LINK "      - {momentum: [0, 1, 0, 0, 0, 2], mass: [3, 0], stiffness: 4, shape: {}}\n" MODE,
     TFA_E_PARSE, 5, "links.a.modes[1].shape: joint 'j' is not in the shape of the first mode; "},
    {LINK MODE "      - {momentum: [0, 1, 0, 0, 0, 2], mass: 3, stiffness: 4, shape: {}}\n",
     TFA_E_PARSE, 5, "links.a.modes[1].shape: joint 'j' of the first mode is missing; write zeros"},
};

TEST(mistakes_are_named)
{
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_report report = {0};
        tfa_modes modes = {0};
        tfa_report_set_file(&report, "robot.urdf");
        const int status =
            tfa_modes_parse(rows[k].text, strlen(rows[k].text), "f.yaml", &modes, &report);
        const tfa_message *first = report.count ? report.messages : NULL;
        const int good = rows[k].status == TFA_OK;
        if (status != rows[k].status || (first == NULL) != good || (!good && modes.count) ||
            strcmp(report.file, good ? "robot.urdf" : "f.yaml") != 0 ||
            (first && (first->line != rows[k].line || !strstr(first->text, rows[k].message))))
            fail_msg("row %zu: %s, line %u: %s\n%s", k, tfa_status_name(status),
                     first ? first->line : 0, first ? first->text : "", rows[k].text);
        tfa_modes_free(&modes);
        tfa_report_free(&report);
    }
}

static void parse(const char *text, tfa_modes *modes)
{
    tfa_report report = {0};
    assert_int_equal(tfa_modes_parse(text, strlen(text), NULL, modes, &report), TFA_OK);
    assert_int_equal(report.count, 0);
    tfa_report_free(&report);
}

/* Values arrive where tfa_link_modes has them; a second file is appended, a refused one is not. */
TEST(values_arrive)
{
    static const char second[] =
        LINK "      - momentum: [1, 2, 3, 4, 5, 6]\n"
             "        mass: [10, 1]\n        stiffness: 7\n        damping: [0.5, 0.25]\n"
             "        limit: 0.125\n"
             "        shape: {left: [1, 2, 3, 4, 5, 6], right: [0, 0, 0, 0, 0, 1]}\n"
             "      - momentum: [0, 0, 0, 0, 0, -6]\n        mass: [1, 20]\n        stiffness: 8\n"
             "        shape: {right: [2, 0, 0, 0, 0, 0], left: [0, 0, 0, 0, 3, 0]}\n";
    tfa_modes modes = {0};
    tfa_report report = {0};
    parse("links: {b: {modes: [{momentum: [0, 0, 0, 0, 0, 0], mass: 1, stiffness: 2, shape: {}}]}}",
          &modes);
    parse(second, &modes);
    assert_int_equal(tfa_modes_parse("links: 3", 8, NULL, &modes, &report), TFA_E_PARSE);
    tfa_report_free(&report);
    assert_int_equal(modes.count, 2);
    assert_string_equal(modes.links[0].link, "b");
    assert_int_equal(modes.links[0].shape_count, 0);
    const tfa_link_modes *a = &modes.links[1];
    const double mass[] = {10, 1, 1, 20}, stiffness[] = {7, 0, 0, 8}, damping[] = {0.5, 0.25, 0, 0};
    const double right[] = {0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0};
    assert_string_equal(a->link, "a");
    assert_int_equal(a->mode_count, 2);
    assert_true(a->momentum[5] == 6 && a->momentum[11] == -6);
    assert_memory_equal(a->mass, mass, sizeof mass);
    assert_memory_equal(a->stiffness, stiffness, sizeof stiffness);
    assert_memory_equal(a->damping, damping, sizeof damping);
    assert_true(a->limit[0] == 0.125 && isinf(a->limit[1]));
    assert_int_equal(a->shape_count, 2);
    assert_string_equal(a->shapes[0].joint, "left");
    assert_true(a->shapes[0].shape[0] == 1 && a->shapes[0].shape[10] == 3);
    assert_string_equal(a->shapes[1].joint, "right");
    assert_memory_equal(a->shapes[1].shape, right, sizeof right);
    tfa_modes_free(&modes);
}

/* Files that are missing, too large, or large and wrong everywhere: bounded messages */
TEST(files_are_bounded)
{
    tfa_modes modes = {0};
    tfa_report report = {0};
    const size_t size = TFA_MODES_MAX_BYTES + 1;
    char *text = malloc(size + 1);
    assert_non_null(text);
    memset(text, '#', size);
    assert_int_equal(tfa_modes_parse(text, size, "f", &modes, &report), TFA_E_FILE);
    assert_string_equal(report.messages[0].code, "too-large");
    tfa_report_free(&report);
    size_t used = (size_t)sprintf(text, "{");
    for (int k = 0; used + 20 < 1 << 18; k++)
        used += (size_t)sprintf(text + used, "k%d: 0, ", k);
    strcpy(text + used, "}");
    assert_int_equal(tfa_modes_parse(text, strlen(text), "f", &modes, &report), TFA_E_PARSE);
    assert_int_equal(report.count, 100);
    tfa_report_free(&report);
    assert_int_equal(tfa_modes_load("/nowhere/f.yaml", &modes, &report), TFA_E_FILE);
    assert_string_equal(report.file, "/nowhere/f.yaml");
    assert_string_equal(report.messages[0].code, "unreadable");
    tfa_report_free(&report);
    assert_int_equal(tfa_modes_load(NULL, &modes, &report), TFA_E_ARGUMENT);
    assert_int_equal(modes.count, 0);
    free(text);
}
