/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Runs the tables of URDF snippets: status, message, line and code of every row.
 */
#include "rows.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/description.h>

#include <cmocka.h>

static int message_differs(const urdf_row *row, const tfa_message *m)
{
    return (int)m->severity != row->severity || m->line != row->line ||
           strcmp(m->code, row->code) != 0 || (row->message && strcmp(m->text, row->message) != 0);
}

/* NULL for the message: any text will do, and more messages may follow. */
static int row_fails(const urdf_row *row)
{
    tfa_report report = {0};
    tfa_description *description = NULL;
    int status =
        tfa_urdf_parse(row->text, strlen(row->text), "f.urdf", &description, &report);
    size_t expected = row->severity >= 0;
    int fails = status != row->status || (description != NULL) != (status == TFA_OK) ||
                (row->message ? report.count != expected : report.count < expected) ||
                (report.errors > 0) != (status != TFA_OK) ||
                (expected && report.count > 0 && message_differs(row, &report.messages[0]));
    if (fails) {
        printf("row '%s': %s\n", row->name, tfa_status_name(status));
        for (size_t i = 0; i < report.count; i++) {
            char text[4096];
            tfa_report_format(&report, i, text, sizeof text);
            printf("  got  %s\n", text);
        }
        printf("  want f.urdf:%u: %s [%s]\n", row->line, row->message ? row->message : "*",
               row->code);
    }
    tfa_description_free(description);
    tfa_report_free(&report);
    return fails;
}

static void run(const urdf_row *rows)
{
    int failures = 0;
    for (; rows->name; rows++)
        failures += row_fails(rows);
    assert_int_equal(failures, 0);
}

static void test_numbers(void **state)
{
    (void)state;
    run(urdf_number_rows);
}

static void test_tree(void **state)
{
    (void)state;
    run(urdf_tree_rows);
}

static void test_xml(void **state)
{
    (void)state;
    run(urdf_xml_rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_tree),
        cmocka_unit_test(test_xml),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
