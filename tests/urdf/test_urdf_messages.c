/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * No case of urdf.md is without a test, and every test that the catalogue names exists.
 */
#include "faults.h"
#include "test.h"
#include "urdf_messages.h"

#include <stdbool.h>

#define TABLES TFA_SOURCE_DIR "/../shared/urdf.md"

static const urdf_fault *const tables[] = {urdf_number_faults, urdf_inertial_faults,
                                           urdf_joint_faults, urdf_tree_faults, urdf_xml_faults};
enum { TABLE_COUNT = sizeof tables / sizeof *tables };

static const urdf_fault *find_row(const char *name)
{
    for (size_t t = 0; t < TABLE_COUNT; t++)
        for (const urdf_fault *row = tables[t]; row->name; row++)
            if (strcmp(row->name, name) == 0)
                return row;
    return NULL;
}

static bool file_has(const char *path, const char *text)
{
    FILE *in = fopen(path, "r");
    bool found = false;
    char line[4096];
    while (in && !found && fgets(line, sizeof line, in))
        found = strstr(line, text) != NULL;
    if (in)
        fclose(in);
    return found;
}

static bool exists(char *test)
{
    char *colon = strchr(test, ':');
    if (!colon)
        return find_row(test) != NULL;
    char path[1024];
    *colon = '\0';
    snprintf(path, sizeof path, TFA_SOURCE_DIR "/%s", test);
    return file_has(path, colon + 1);
}

TEST(test_named_tests_exist)
{
    size_t missing = 0;
    for (const urdf_case *c = urdf_messages; c->text; c++) {
        char *tests = strdup(c->tests);
        assert_non_null(tests);
        char *rest = NULL;
        for (char *t = strtok_r(tests, ";", &rest); t; t = strtok_r(NULL, ";", &rest)) {
            t += strspn(t, " ");
            if (exists(t))
                continue;
            print_error("%s: no test '%s'\n", c->text, t);
            missing++;
        }
        free(tests);
    }
    assert_int_equal(missing, 0);
}

TEST(test_fault_names_are_unique)
{
    for (size_t t = 0; t < TABLE_COUNT; t++)
        for (const urdf_fault *row = tables[t]; row->name; row++)
            if (find_row(row->name) != row)
                fail_msg("two rows are called '%s'", row->name);
}

/* The first cell of a table row into `cell`; false for other lines, table heads and rulers. */
static bool first_cell(const char *line, char *cell)
{
    const char *end = line[0] == '|' && line[1] == ' ' ? strstr(line + 2, " |") : NULL;
    if (!end)
        return false;
    size_t length = (size_t)(end - line - 2);
    memcpy(cell, line + 2, length);
    cell[length] = '\0';
    return strcmp(cell, "input") != 0 && strcmp(cell, "case") != 0;
}

static bool is_listed(const char *text)
{
    for (const urdf_case *c = urdf_messages; c->text; c++)
        if (strcmp(c->text, text) == 0)
            return true;
    return false;
}

TEST(test_no_case_is_missing)
{
    FILE *in = fopen(TABLES, "r");
    if (!in) {
        print_message("skipped: no file %s\n", TABLES);
        skip();
        return;
    }
    char line[4096];
    char cell[4096];
    size_t cases = 0;
    size_t missing = 0;
    while (fgets(line, sizeof line, in)) {
        if (!first_cell(line, cell))
            continue;
        cases++;
        if (is_listed(cell))
            continue;
        print_error("no test for the case: %s\n", cell);
        missing++;
    }
    fclose(in);
    size_t listed = 0;
    while (urdf_messages[listed].text)
        listed++;
    assert_int_equal(missing, 0);
    assert_int_equal(cases, listed);
}
