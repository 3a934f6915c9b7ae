/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Runs the tables of URDF snippets: status, message, line and code of every row.
 */
#include "faults.h"
#include "test.h"

#include <stdbool.h>
#include <totalforce/description.h>

/* A refused file ends with one line that says how many errors there are. */
static size_t without_last(const tfa_report *report, const urdf_fault *row)
{
    const tfa_message *last = report->count > 0 ? &report->messages[report->count - 1] : NULL;
    const bool refused = last && strcmp(last->code, "refused") == 0;
    return refused == (row->status != TFA_OK) ? report->count - refused : SIZE_MAX;
}

/* Whether the lines of row->message are all that was said, with its severity, line and code */
static bool report_differs(const tfa_report *report, const urdf_fault *row)
{
    const char *text = row->message;
    size_t i = 0;
    for (; row->severity >= 0 && *text; i++) {
        size_t length = strcspn(text, "\n");
        const tfa_message *m = i < report->count ? &report->messages[i] : NULL;
        if (!m || (int)m->severity != row->severity || m->line != row->line ||
            strcmp(m->code, row->code) != 0 || strlen(m->text) != length ||
            memcmp(m->text, text, length) != 0)
            return true;
        text += length + (text[length] == '\n');
    }
    return without_last(report, row) != i;
}

static int fault_differs(const urdf_fault *row)
{
    tfa_report report = {0};
    tfa_description *description = NULL;
    int status = tfa_urdf_parse(row->text, strlen(row->text), "f.urdf", &description, &report);
    bool fails = status != row->status || (description != NULL) != (status == TFA_OK) ||
                 (report.errors > 0) != (status != TFA_OK) || report_differs(&report, row);
    if (fails) {
        printf("row '%s': %s\n", row->name, tfa_status_name(status));
        for (size_t i = 0; i < report.count; i++) {
            char text[4096];
            tfa_report_format(&report, i, text, sizeof text);
            printf("  got  %s\n", text);
        }
        printf("  want f.urdf:%u: %s [%s]\n", row->line, row->message, row->code);
    }
    tfa_description_free(description);
    tfa_report_free(&report);
    return fails;
}

static void run_faults(const urdf_fault *rows)
{
    int failures = 0;
    for (; rows->name; rows++)
        failures += fault_differs(rows);
    assert_int_equal(failures, 0);
}

TEST(test_numbers)
{
    run_faults(urdf_number_faults);
}

TEST(test_inertials)
{
    run_faults(urdf_inertial_faults);
}

TEST(test_joints)
{
    run_faults(urdf_joint_faults);
}

TEST(test_tree)
{
    run_faults(urdf_tree_faults);
}

TEST(test_xml)
{
    run_faults(urdf_xml_faults);
}
