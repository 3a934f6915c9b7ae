/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Real robots load without an error, and what is loaded agrees with a look at the bare text.
 */
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/description.h>

#include <cmocka.h>

#define ROBOTS TFA_SOURCE_DIR "/../shared/robots"

static char *read_text(const char *path)
{
    FILE *in = fopen(path, "rb");
    assert_non_null(in);
    size_t room = 8 << 20;
    char *text = calloc(1, room);
    assert_non_null(text);
    assert_true(fread(text, 1, room - 1, in) < room - 1);
    fclose(in);
    for (char *c = strstr(text, "<!--"); c; c = strstr(c, "<!--")) {
        char *end = strstr(c, "-->");
        assert_non_null(end);
        memset(c, ' ', (size_t)(end - c));
    }
    return text;
}

/* <link ...>, but neither <link_...> nor <parent link=...> */
static size_t count_links(const char *text)
{
    size_t n = 0;
    for (const char *at = strstr(text, "<link"); at; at = strstr(at + 1, "<link"))
        n += at[5] == ' ' || at[5] == '\t' || at[5] == '\r' || at[5] == '\n';
    return n;
}

/* All masses in document order, summed: equal to the bit if every one was read to the bit. */
static double sum_of_masses(const char *text)
{
    double sum = 0;
    for (const char *at = strstr(text, "<mass"); at; at = strstr(at + 1, "<mass")) {
        const char *value = strstr(at, "value=\"");
        assert_non_null(value);
        sum += strtod(value + strlen("value=\""), NULL);
    }
    return sum;
}

static void check_robot(const char *path)
{
    tfa_report report = {0};
    tfa_description *d = NULL;
    int status = tfa_urdf_load(path, &d, &report);
    for (size_t i = 0; i < report.count && report.errors > 0; i++)
        print_error("%s: %s\n", path, report.messages[i].text);
    assert_int_equal(status, TFA_OK);
    char *text = read_text(path);
    bool world = d->links[0].line == 0;
    assert_int_equal(d->link_count, count_links(text) + world);
    assert_int_equal(d->joint_count + 1, d->link_count);
    double sum = 0;
    for (size_t i = 0; i < d->link_count; i++)
        sum += d->links[i].mass;
    double expected = sum_of_masses(text);
    assert_memory_equal(&sum, &expected, sizeof sum);
    free(text);
    tfa_description_free(d);
    tfa_report_free(&report);
}

static void test_robots(void **state)
{
    (void)state;
    DIR *folder = opendir(ROBOTS);
    if (!folder) {
        print_message("skipped: no folder %s\n", ROBOTS);
        skip();
        return;
    }
    size_t robots = 0;
    for (struct dirent *entry; (entry = readdir(folder));) {
        size_t length = strlen(entry->d_name);
        if (length < 5 || strcmp(entry->d_name + length - 5, ".urdf") != 0)
            continue;
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", ROBOTS, entry->d_name);
        check_robot(path);
        robots++;
    }
    closedir(folder);
    print_message("%zu robots\n", robots);
    assert_true(robots > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_robots)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
