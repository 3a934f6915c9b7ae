/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Real robots load without an error, and what is loaded agrees with a look at the bare text.
 */
#include "test.h"

#include <dirent.h>
#include <stdbool.h>
#include <totalforce/description.h>

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

enum { CODES = 8 };

/* What the files hold, counted with an XML reader that is not ours, and what there is to say. */
static const struct expectation {
    const char *file;
    size_t links, joints, fixed, mimics, massless;
    size_t moving_massless; /* children of moving joints */
    size_t damping, friction;
    struct {
        const char *code;
        size_t count;
    } reported[CODES];
} expectations[] = {
    {"allegro_right.urdf", 21, 20, 4, 0, 0, 0, 16, 16, {{"triangle", 13}}},
    {"anymal_c.urdf", 78, 77, 65, 0, 19, 0, 0, 0, {{"triangle", 5}, {"no-inertial", 18}}},
    {"baxter.urdf", 57, 56, 37, 2, 1, 0, 19, 0, {{"odd-gyration", 2}}},
    {"double_pendulum.urdf", 3, 2, 0, 0, 0, 0, 2, 0, {{"equal-limits", 2}}},
    {"go2.urdf", 31, 30, 18, 0, 2, 0, 0, 0, {{"no-inertial", 2}}},
    {"h1.urdf", 25, 24, 5, 0, 5, 0, 0, 0, {{"no-inertial", 5}}},
    {"iiwa14.urdf", 11, 10, 3, 0, 3, 0, 7, 0, {{"no-inertial", 2}}},
    {"panda.urdf", 13, 12, 3, 1, 2, 0, 9, 0, {{"no-inertial", 2}}},
    {"pr2.urdf", 82, 81, 51, 10, 14, 0, 32, 0, {{"triangle", 2}, {"no-inertial", 14}}},
    {"romeo.urdf", 82, 81, 26, 22, 50, 24, 0, 0, {{"triangle", 2}, {"no-inertial", 25}}},
    {"simple_humanoid.urdf", 31, 30, 1, 0, 1, 0, 0, 0, {{"placeholder-inertia", 30}}},
    {"solo12.urdf", 17, 16, 4, 0, 0, 0, 0, 0, {{NULL, 0}}},
    {"ur5.urdf", 11, 10, 4, 0, 4, 0, 0, 0, {{"no-inertial", 3}}},
};

static void count(const tfa_description *d, struct expectation *got)
{
    for (size_t i = 0; i < d->link_count; i++)
        got->massless += d->links[i].mass == 0;
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_joint *joint = &d->joints[j];
        bool fixed = joint->type == TFA_JOINT_FIXED;
        got->fixed += fixed;
        got->mimics += joint->mimic >= 0;
        got->moving_massless += !fixed && d->links[joint->child].mass == 0;
        got->damping += joint->damping != 0;
        got->friction += joint->friction != 0;
    }
}

static size_t count_code(const tfa_report *report, const char *code)
{
    size_t n = 0;
    for (size_t i = 0; i < report->count; i++)
        n += strcmp(report->messages[i].code, code) == 0 ? report->messages[i].count : 0;
    return n;
}

static void check_messages(const struct expectation *want, const tfa_report *report)
{
    size_t expected = 0;
    for (size_t k = 0; k < CODES && want->reported[k].code; k++) {
        size_t n = count_code(report, want->reported[k].code);
        if (n != want->reported[k].count)
            fail_msg("%s: %zu messages %s", want->file, n, want->reported[k].code);
        expected++;
    }
    for (size_t i = 0; i < report->count && report->count != expected; i++)
        print_error("%s:%u: %s\n", want->file, report->messages[i].line, report->messages[i].text);
    assert_int_equal(report->count, expected);
}

/* Nothing is expected of robots that are not in the table. */
static void check_expectation(const char *path, const tfa_description *d, const tfa_report *report)
{
    const char *file = strrchr(path, '/') + 1;
    const struct expectation *want = NULL;
    for (size_t i = 0; i < sizeof expectations / sizeof *expectations; i++)
        if (strcmp(expectations[i].file, file) == 0)
            want = &expectations[i];
    if (!want) {
        print_message("%s: nothing is known of it\n", file);
        return;
    }
    struct expectation got = {0};
    count(d, &got);
    assert_int_equal(d->link_count, want->links);
    assert_int_equal(d->joint_count, want->joints);
    assert_int_equal(got.fixed, want->fixed);
    assert_int_equal(got.mimics, want->mimics);
    assert_int_equal(got.massless, want->massless);
    assert_int_equal(got.moving_massless, want->moving_massless);
    assert_int_equal(got.damping, want->damping);
    assert_int_equal(got.friction, want->friction);
    check_messages(want, report);
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
    check_expectation(path, d, &report);
    tfa_description_free(d);
    tfa_report_free(&report);
}

TEST(test_robots)
{
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
    assert_true(robots >= sizeof expectations / sizeof *expectations);
}
