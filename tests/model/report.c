/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reports format, truncate, grow and are released; every status has its name, text and cause.
 */
#include "test.h"

#include <totalforce/report.h>
#include <totalforce/status.h>

TEST(test_format)
{
    static const struct {
        const char *file;
        tfa_severity severity;
        uint32_t line;
        const char *expected;
    } rows[] = {
        {"a.urdf", TFA_ERROR, 7, "a.urdf:7: error: link 'x': 3 kg [code]"},
        {"a.urdf", TFA_WARNING, 0, "a.urdf: warning: link 'x': 3 kg [code]"},
        {NULL, TFA_NOTE, 7, "line 7: note: link 'x': 3 kg [code]"},
        {NULL, TFA_ERROR, 0, "error: link 'x': 3 kg [code]"},
        {"", TFA_ERROR, UINT32_MAX, ":4294967295: error: link 'x': 3 kg [code]"},
        {"a.urdf", (tfa_severity)9, 1, "a.urdf:1: message: link 'x': 3 kg [code]"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_report report = {0};
        tfa_report_set_file(&report, rows[k].file);
        tfa_report_add(&report, rows[k].severity, rows[k].line, "code", "link '%s': %d kg", "x", 3);
        char text[100];
        size_t length = strlen(rows[k].expected);
        assert_int_equal(tfa_report_format(&report, 0, text, sizeof text), length);
        assert_string_equal(text, rows[k].expected);
        tfa_report_free(&report);
    }
}

/* Whatever the room, the text is terminated, nothing beyond it is written, and the length needed
 * comes back. */
TEST(test_truncation)
{
    tfa_report report = {0};
    tfa_report_set_file(&report, "f");
    tfa_report_add(&report, TFA_NOTE, 12, "c", "hello");
    const char *whole = "f:12: note: hello [c]";
    size_t length = strlen(whole);
    for (size_t size = 0; size <= length + 2; size++) {
        char text[40];
        memset(text, '#', sizeof text);
        assert_int_equal(tfa_report_format(&report, 0, text, size), length);
        size_t kept = size == 0 ? 0 : size <= length ? size - 1 : length;
        assert_memory_equal(text, whole, kept);
        if (size > 0)
            assert_int_equal(text[kept], '\0');
        assert_int_equal(text[size > length ? length + 1 : size], '#');
    }
    assert_int_equal(tfa_report_format(&report, 0, NULL, 0), length);
    tfa_report_free(&report);
}

TEST(test_no_message)
{
    tfa_report report = {0};
    char text[8] = "before";
    assert_int_equal(tfa_report_format(&report, 0, text, sizeof text), 0);
    assert_string_equal(text, "");
    assert_int_equal(tfa_report_format(NULL, 0, text, sizeof text), 0);
    assert_int_equal(tfa_report_format(&report, SIZE_MAX, NULL, 0), 0);
    tfa_report_add(NULL, TFA_ERROR, 1, "code", "text");
    tfa_report_set_file(NULL, "file");
    tfa_report_free(NULL);
    tfa_report_free(&report);
}

TEST(test_growth)
{
    tfa_report report = {0};
    for (int k = 0; k < 300; k++)
        tfa_report_add(&report, (tfa_severity)(k % 3), (uint32_t)k, k % 2 ? "odd" : NULL, "%d", k);
    assert_int_equal(report.count, 300);
    assert_int_equal(report.errors, 100);
    assert_int_equal(report.warnings, 100);
    for (int k = 0; k < 300; k++) {
        char number[16];
        snprintf(number, sizeof number, "%d", k);
        assert_string_equal(report.messages[k].text, number);
        assert_string_equal(report.messages[k].code, k % 2 ? "odd" : "");
        assert_int_equal(report.messages[k].line, k);
    }
    tfa_report_free(&report);
    assert_null(report.messages);
    assert_int_equal(report.count + report.errors + report.warnings + report.capacity, 0);
    tfa_report_add(&report, TFA_ERROR, 1, "again", "usable");
    assert_int_equal(report.count, 1);
    tfa_report_free(&report);
}

TEST(test_long_text)
{
    tfa_report report = {0};
    static char name[5000];
    memset(name, 'n', sizeof name - 1);
    tfa_report_add(&report, TFA_ERROR, 0, "long", "link '%s'", name);
    assert_int_equal(strlen(report.messages[0].text), sizeof name - 1 + strlen("link ''"));
    assert_memory_equal(report.messages[0].text + strlen("link '"), name, sizeof name - 1);
    tfa_report_free(&report);
}

TEST(test_file_name)
{
    tfa_report report = {0};
    char name[] = "one";
    tfa_report_set_file(&report, name);
    name[0] = 'O';
    assert_string_equal(report.file, "one"); /* copied */
    tfa_report_set_file(&report, report.file);
    assert_string_equal(report.file, "one");
    tfa_report_set_file(&report, "two");
    assert_string_equal(report.file, "two");
    tfa_report_set_file(&report, NULL);
    assert_null(report.file);
    tfa_report_free(&report);
}

TEST(test_status)
{
    int numbers[64], count = 0;
#define ROW(name, number, text, cause)                                                             \
    assert_string_equal(tfa_status_name(TFA_##name), #name);                                       \
    assert_string_equal(tfa_status_text(TFA_##name), text);                                        \
    assert_string_equal(tfa_status_cause(TFA_##name), cause);                                      \
    assert_true((sizeof cause > 1) == (TFA_##name != TFA_OK));                                     \
    assert_true(sizeof text > 1);                                                                  \
    numbers[count++] = TFA_##name;
    TFA_STATUS_LIST(ROW)
#undef ROW
    for (int k = 0; k < count; k++) { /* 0, -1, -2, ...: no gaps, so 1 and -count are unknown */
        assert_int_equal(numbers[k], -k);
        for (int i = 0; i < k; i++)
            assert_string_not_equal(tfa_status_text(-i), tfa_status_text(-k));
    }
    const int unknown[] = {1, -count, INT32_MAX, INT32_MIN};
    for (int k = 0; k < 4; k++) {
        assert_string_equal(tfa_status_text(unknown[k]), "unknown status");
        assert_string_equal(tfa_status_name(unknown[k]), "E_UNKNOWN");
        assert_string_equal(tfa_status_cause(unknown[k]),
                            "the number is no status of this version of the library");
    }
}
