/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Status texts, the report and the grammar of numbers.
 */
#include "test.h"
#include "urdf/urdf.h"

#include <locale.h>

TEST(test_status)
{
    assert_string_equal(tfa_status_text(TFA_OK), "ok");
    assert_string_equal(tfa_status_cause(TFA_OK), "");
    assert_string_equal(tfa_status_name(TFA_E_AGAIN), "E_AGAIN");
    assert_string_equal(tfa_status_text(TFA_E_AGAIN), "ring full");
    assert_string_equal(tfa_status_text(1), "unknown status");
    assert_string_equal(tfa_status_text(-1000), "unknown status");
    assert_non_null(tfa_status_cause(77));
    assert_non_null(tfa_status_name(77));
#define CHECK(name, number, text, cause)                                                           \
    assert_int_equal(TFA_##name, number);                                                          \
    assert_string_equal(tfa_status_name(number), #name);                                           \
    assert_true((number) == 0 || tfa_status_cause(number)[0] != '\0');
    TFA_STATUS_LIST(CHECK)
#undef CHECK
}

TEST(test_format)
{
    tfa_report r = {0};
    char text[128];
    tfa_report_add(&r, TFA_ERROR, 7, "some-code", "link '%s': %d is odd; make it even", "a", 3);
    tfa_report_add(&r, TFA_NOTE, 0, "other", "robot: fine");
    assert_int_equal(r.count, 2);
    assert_int_equal(r.errors, 1);
    assert_int_equal(r.warnings, 0);
    tfa_report_format(&r, 0, text, sizeof text);
    assert_string_equal(text, "line 7: error: link 'a': 3 is odd; make it even [some-code]");
    tfa_report_format(&r, 1, text, sizeof text);
    assert_string_equal(text, "note: robot: fine [other]");
    tfa_report_set_file(&r, "x.urdf");
    size_t needed = tfa_report_format(&r, 0, text, sizeof text);
    assert_string_equal(text, "x.urdf:7: error: link 'a': 3 is odd; make it even [some-code]");
    assert_int_equal(needed, strlen(text));
    tfa_report_format(&r, 1, text, sizeof text);
    assert_string_equal(text, "x.urdf: note: robot: fine [other]");
    assert_int_equal(tfa_report_format(&r, 0, text, 5), needed);
    assert_string_equal(text, "x.ur");
    assert_int_equal(tfa_report_format(&r, 0, NULL, 0), needed);
    assert_int_equal(tfa_report_format(&r, 2, text, sizeof text), 0);
    assert_string_equal(text, "");
    tfa_report_free(&r);
    assert_int_equal(r.count, 0);
    assert_null(r.file);
    tfa_report_free(&r);
}

TEST(test_growth)
{
    tfa_report r = {0};
    for (int i = 0; i < 1000; i++)
        tfa_report_add(&r, TFA_WARNING, (uint32_t)i, "code", "message %d", i);
    assert_int_equal(r.count, 1000);
    assert_int_equal(r.warnings, 1000);
    assert_string_equal(r.messages[999].text, "message 999");
    assert_string_equal(r.messages[0].text, "message 0");
    tfa_report_free(&r);
    tfa_report_add(NULL, TFA_ERROR, 0, "code", "nobody listens");
}

TEST(test_number_grammar)
{
    static const struct {
        const char *text;
        tfa_number_fault fault;
        double value;
    } rows[] = {
        {"0", TFA_NUMBER_OK, 0.0},
        {"-0", TFA_NUMBER_OK, -0.0},
        {"+1.5", TFA_NUMBER_OK, 1.5},
        {"1.", TFA_NUMBER_OK, 1.0},
        {".5", TFA_NUMBER_OK, 0.5},
        {"-.5e-1", TFA_NUMBER_OK, -0.05},
        {"1E+3", TFA_NUMBER_OK, 1000.0},
        {"0e9999", TFA_NUMBER_OK, 0.0},
        {"0.1", TFA_NUMBER_OK, 0.1},
        {"1.7976931348623157e308", TFA_NUMBER_OK, 1.7976931348623157e308},
        {"5e-324", TFA_NUMBER_OK, 5e-324},
        {"2e-324", TFA_NUMBER_UNDERFLOW, 0},
        {"-1e-9999", TFA_NUMBER_UNDERFLOW, 0},
        {"1e309", TFA_NUMBER_OVERFLOW, 0},
        {"", TFA_NUMBER_MALFORMED, 0},
        {"+", TFA_NUMBER_MALFORMED, 0},
        {".", TFA_NUMBER_MALFORMED, 0},
        {"e1", TFA_NUMBER_MALFORMED, 0},
        {"1e", TFA_NUMBER_MALFORMED, 0},
        {"1e+", TFA_NUMBER_MALFORMED, 0},
        {"1e1.5", TFA_NUMBER_MALFORMED, 0},
        {"1.2.3", TFA_NUMBER_MALFORMED, 0},
        {"1_000", TFA_NUMBER_MALFORMED, 0},
        {"1 ", TFA_NUMBER_MALFORMED, 0},
        {"\t1", TFA_NUMBER_MALFORMED, 0},
        {"0x10", TFA_NUMBER_MALFORMED, 0},
        {"infinity", TFA_NUMBER_MALFORMED, 0},
        {"NaN", TFA_NUMBER_MALFORMED, 0},
        {"1d3", TFA_NUMBER_MALFORMED, 0},
        {"1.5f", TFA_NUMBER_MALFORMED, 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double value = 0;
        tfa_number_fault fault = tfa_number_read(rows[i].text, strlen(rows[i].text), &value);
        if (fault != rows[i].fault ||
            (fault == TFA_NUMBER_OK && memcmp(&value, &rows[i].value, sizeof value) != 0))
            fail_msg("'%s' is %a with fault %d", rows[i].text, value, (int)fault);
    }
}
