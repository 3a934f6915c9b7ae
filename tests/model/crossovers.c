/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Files of crossovers: what is written is read again, and whatever is wrong with one is told by
 * line, name and remedy, and changes nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <totalforce/totalforce.h>

static int read_text(const char *text, tfa_crossovers *out, char *error, size_t size)
{
    char path[] = "/tmp/tfa-crossovers-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
    close(file);
    const int status = tfa_crossovers_read(path, out, error, size);
    unlink(path);
    return status;
}

/* Every number another one, each in its range; the last is never. */
static tfa_crossovers numbered(void)
{
    tfa_crossovers c;
    uint32_t at = 100, *last = NULL;
#define NUMBER(name, standard, lowest, unit, what) c.name = at++, last = &c.name;
    TFA_CROSSOVER_LIST(NUMBER)
#undef NUMBER
    *last = TFA_NEVER;
    return c;
}

static void test_round_trip(void **state)
{
    (void)state;
    char text[4096], error[256];
    const tfa_crossovers written = numbered();
    tfa_crossovers read;
    memset(&read, 0, sizeof read);
    const size_t size = tfa_crossovers_text(&written, "machine: X\ndate: Y", text, sizeof text);
    assert_int_equal(size, strlen(text));
    assert_non_null(strstr(text, "\n# machine: X\n# date: Y\n"));
    assert_int_equal(read_text(text, &read, error, sizeof error), TFA_OK);
    assert_string_equal(error, "");
    assert_memory_equal(&read, &written, sizeof read);
    assert_int_equal(tfa_crossovers_text(&written, "machine: X\ndate: Y", NULL, 0), size);
    char cut[8];
    assert_int_equal(tfa_crossovers_text(&written, "machine: X\ndate: Y", cut, sizeof cut), size);
    assert_string_equal(cut, "# From ");
}

/* The file in config/ is what the library has: so its head says where the numbers come from. */
static void test_shipped_file(void **state)
{
    (void)state;
    char error[256];
    tfa_crossovers read;
    memset(&read, 0, sizeof read);
    if (tfa_crossovers_read(TFA_SOURCE_DIR "/config/crossovers.conf", &read, error, sizeof error) !=
        TFA_OK)
        fail_msg("%s", error);
    assert_memory_equal(&read, tfa_crossovers_default(), sizeof read);
}

static void test_what_is_not_named(void **state)
{
    (void)state;
    char error[256];
    tfa_crossovers read, want = *tfa_crossovers_default();
    want.scan_from_2 = 77;
    assert_int_equal(read_text("  # a comment\r\n\n version : 1 # the first\r\nscan_from_2:77",
                               &read, error, sizeof error),
                     TFA_OK);
    assert_memory_equal(&read, &want, sizeof read);
}

static const struct mistake {
    const char *text, *error; /* behind the file's name */
} mistakes[] = {
    {"", ":0: version: not there; write version: 1"},
    {"version: 2\n", ":1: version: '2', must be 1; run totalforce chart --calibrate anew"},
    {"scan_from_1: 8\nversion: 1\n", ":1: scan_from_1: before the version; write version: 1 first"},
    {"version: 1\nscan_from_1 8\n", ":2: scan_from_1 8: no colon; write name: number"},
    {"version: 1\nscan_from_1: 1\n", ":2: scan_from_1: '1' is out of range; a whole number of "},
    {"version: 1\nscan_from_1: -8\n", ":2: scan_from_1: '-8' is out of range"},
    {"version: 1\nscan_from_1: 8.5\n", ":2: scan_from_1: '8.5' is out of range"},
    {"version: 1\nscan_from_1: 4294967295\n", ":2: scan_from_1: '4294967295' is out of range"},
    {"version: 1\nscan_from_1:\n", ":2: scan_from_1: '' is out of range"},
    {"version: 1\nscan_from_1: Never\n", ":2: scan_from_1: 'Never' is out of range"},
    {"version: 1\nscan_from_1: 8\n\nscan_from_1: 8\n", ":4: scan_from_1: given twice; remove one"},
    {"version: 1\nscan_form_1: 8\n", ":2: scan_form_1: not a crossover; one of lanes_from, "},
};

static void test_mistakes(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof mistakes / sizeof *mistakes; k++) {
        char error[1024];
        tfa_crossovers read;
        memset(&read, 0x5a, sizeof read);
        const tfa_crossovers untouched = read;
        assert_int_equal(read_text(mistakes[k].text, &read, error, sizeof error), TFA_E_PARSE);
        assert_memory_equal(&read, &untouched, sizeof read);
        const char *behind = strchr(error, ':');
        if (!behind || strncmp(behind, mistakes[k].error, strlen(mistakes[k].error)) != 0)
            fail_msg("'%s' instead of '%s'", error, mistakes[k].error);
        char cut[5];
        assert_int_equal(read_text(mistakes[k].text, &read, cut, sizeof cut), TFA_E_PARSE);
        assert_int_equal(strlen(cut), 4);
        assert_int_equal(read_text(mistakes[k].text, &read, NULL, 0), TFA_E_PARSE);
    }
}

static void test_no_file(void **state)
{
    (void)state;
    char error[256];
    tfa_crossovers read;
    assert_int_equal(tfa_crossovers_read("/no/such/file", &read, error, sizeof error), TFA_E_FILE);
    assert_string_equal(error, "/no/such/file: cannot be read: No such file or directory");
    assert_int_equal(tfa_crossovers_read("/", &read, error, sizeof error), TFA_E_FILE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),        cmocka_unit_test(test_shipped_file),
        cmocka_unit_test(test_what_is_not_named), cmocka_unit_test(test_mistakes),
        cmocka_unit_test(test_no_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
