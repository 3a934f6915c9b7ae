/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names of robots that are no paths: what they stand for, and what the message says where they
 * stand for nothing.
 */
#include "support/wait.h"
#include "test.h"

#include <errno.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <totalforce/totalforce.h>
#include <unistd.h>

/* Two workspaces below the current folder: a/share/arm, a/share/leg; b/leg, b/hand */
static const char *const folders[] = {"a", "a/share", "a/share/arm", "a/share/leg",
                                      "b", "b/leg",   "b/hand"};
#define FOLDERS (sizeof folders / sizeof *folders)
static const char robot[] = "<robot name=\"r\"><link name=\"a\"/></robot>";
static const char file[] = "b/hand/my robot.urdf";

static void make_folders(char *root)
{
    assert_non_null(mkdtemp(root));
    assert_int_equal(chdir(root), 0);
    for (size_t k = 0; k < FOLDERS; k++)
        assert_int_equal(mkdir(folders[k], 0700), 0);
    FILE *out = fopen(file, "w");
    assert_non_null(out);
    assert_true(fputs(robot, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

static void remove_folders(const char *root)
{
    assert_int_equal(unlink(file), 0);
    for (size_t k = FOLDERS; k-- > 0;)
        assert_int_equal(rmdir(folders[k]), 0);
    assert_int_equal(chdir("/"), 0);
    assert_int_equal(rmdir(root), 0);
}

static void set(const char *name, const char *value)
{
    assert_int_equal(value ? setenv(name, value, 1) : unsetenv(name), 0);
}

static const struct {
    const char *ament, *ros, *home, *name;
    int error; /* errno; 0: `text` is the path, otherwise a part of the reason */
    const char *text;
} rows[] = {
    {NULL, NULL, NULL, "arm.urdf", 0, "arm.urdf"},
    {NULL, NULL, NULL, "/a b/~/c$(d).urdf", 0, "/a b/~/c$(d).urdf"},
    {"a", "b", NULL, "package://arm/urdf/arm.urdf", 0, "a/share/arm/urdf/arm.urdf"},
    {"a", "b", NULL, "package://leg/l.urdf", 0, "a/share/leg/l.urdf"},
    {"x:a:", "y::b", NULL, "package://hand/h.urdf", 0, "b/hand/h.urdf"},
    {NULL, "b", NULL, "$(find leg)/urdf/l.urdf", 0, "b/leg/urdf/l.urdf"},
    {"a", NULL, NULL, "$(find-pkg-share arm)/arm.urdf", 0, "a/share/arm/arm.urdf"},
    {"a", NULL, NULL, "$(find  arm )/arm.urdf", 0, "a/share/arm/arm.urdf"},
    {NULL, NULL, "/home/me", "~/arm.urdf", 0, "/home/me/arm.urdf"},
    {NULL, NULL, NULL, "file:///robots/arm.urdf", 0, "/robots/arm.urdf"},
    {NULL, NULL, NULL, "file://localhost/my%20robots/100%25.urdf", 0, "/my robots/100%.urdf"},
    {NULL, NULL, NULL, "file:/arm%zz.urdf%0", 0, "/arm%zz.urdf%0"},
    {"a:c", NULL, NULL, "package://hand/h.urdf", ENOENT,
     "no package 'hand' in AMENT_PREFIX_PATH (a:c) or ROS_PACKAGE_PATH (not set); source"},
    {"", "b:d", NULL, "$(find arm)/a.urdf", ENOENT,
     "no package 'arm' in AMENT_PREFIX_PATH (not set) or ROS_PACKAGE_PATH (b:d)"},
    {"a", "b", NULL, "package:///urdf/arm.urdf", ENOENT, "names no package and file"},
    {"a", "b", NULL, "package://arm", ENOENT, "'arm' names no package and file"},
    {"a", "b", NULL, "$(find arm/urdf", ENOENT, "write $(find PACKAGE)/FILE"},
    {NULL, NULL, NULL, "~/arm.urdf", ENOENT, "HOME is not set"},
    {NULL, NULL, "/home/me", "~you/arm.urdf", ENOENT, "'~you/...' is not expanded; a path"},
    {NULL, NULL, NULL, "file://elsewhere/arm.urdf", ENOENT, "another host"},
    {NULL, NULL, NULL, "http://example.org/arm.urdf", ENOENT, "'http:/...' is not expanded"},
    {NULL, NULL, NULL, "model://arm/model.sdf", ENOENT, "'model:/...' is not expanded"},
    {NULL, NULL, NULL, "$(env HOME)/arm.urdf", ENOENT, "'$(env HOME)...' is not expanded"},
};

TEST(names)
{
    char root[] = "/tmp/tfa-find-XXXXXX", path[TFA_URDF_PATH_MAX];
    make_folders(root);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        set("AMENT_PREFIX_PATH", rows[k].ament);
        set("ROS_PACKAGE_PATH", rows[k].ros);
        set("HOME", rows[k].home);
        const int status = tfa_urdf_find(rows[k].name, path, sizeof path);
        const int error = status == TFA_OK ? 0 : errno;
        if (status != (rows[k].error ? TFA_E_FILE : TFA_OK) || error != rows[k].error ||
            (error ? !strstr(path, rows[k].text) : strcmp(path, rows[k].text) != 0))
            fail_msg("%s: %s, errno %d: '%s'", rows[k].name, tfa_status_name(status), error, path);
    }
    remove_folders(root);
}

/* Loading finds by the same names; messages have the path, or the name where there is none. */
TEST(loading)
{
    char root[] = "/tmp/tfa-find-XXXXXX";
    make_folders(root);
    set("ROS_PACKAGE_PATH", "b");
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_int_equal(tfa_urdf_load("package://hand/my robot.urdf", &d, &report), TFA_OK);
    assert_string_equal(d->name, "r");
    assert_string_equal(report.file, file);
    tfa_description_free(d);
    char *text = NULL;
    size_t length = 0;
    assert_int_equal(tfa_urdf_read("$(find hand)/my robot.urdf", &text, &length, &report), TFA_OK);
    assert_int_equal(length, strlen(robot));
    assert_string_equal(text, robot);
    free(text);
    tfa_report_free(&report);
    assert_int_equal(tfa_urdf_read("package://hand/none.urdf", &text, &length, &report),
                     TFA_E_FILE);
    assert_int_equal(errno, ENOENT);
    assert_null(text);
    assert_string_equal(report.file, "b/hand/none.urdf");
    tfa_report_free(&report);
    assert_int_equal(tfa_urdf_load("package://foot/none.urdf", &d, &report), TFA_E_FILE);
    assert_string_equal(report.file, "package://foot/none.urdf");
    assert_non_null(strstr(report.messages[0].text, "no package 'foot' in AMENT_PREFIX_PATH"));
    tfa_report_free(&report);
    remove_folders(root);
}

/* A pipe that nobody writes is an empty file, not one to wait for; one with a writer is read to its
 * end, however late it writes. */
TEST(pipes)
{
    char root[] = "/tmp/tfa-find-XXXXXX", *text = NULL;
    size_t length = 0;
    tfa_report report = {0};
    tfa_description *d = NULL;
    assert_non_null(mkdtemp(root));
    assert_int_equal(chdir(root), 0);
    assert_int_equal(mkfifo("pipe", 0600), 0);
    assert_int_not_equal(tfa_urdf_load("pipe", &d, &report), TFA_OK);
    tfa_report_free(&report);
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    const pid_t writer = fork();
    if (writer == 0) {
        sleep_ms(20);
        _exit(write(ends[1], robot, strlen(robot)) != (ssize_t)strlen(robot));
    }
    assert_int_equal(close(ends[1]), 0);
    char name[32]; /* as <(program) of a shell */
    snprintf(name, sizeof name, "/dev/fd/%d", ends[0]);
    assert_int_equal(tfa_urdf_read(name, &text, &length, &report), TFA_OK);
    assert_string_equal(text, robot);
    free(text);
    tfa_report_free(&report);
    assert_int_equal(waitpid(writer, NULL, 0), writer);
    assert_int_equal(close(ends[0]), 0);
    assert_int_equal(unlink("pipe"), 0);
    assert_int_equal(chdir("/"), 0);
    assert_int_equal(rmdir(root), 0);
}

TEST(long_names)
{
    char path[32], name[64];
    memset(name, 'a', sizeof name);
    name[sizeof name - 1] = '\0';
    assert_int_equal(tfa_urdf_find(name, path, sizeof path), TFA_E_FILE);
    assert_int_equal(errno, ENAMETOOLONG);
    memcpy(name, "file:/", 6);
    assert_int_equal(tfa_urdf_find(name, path, sizeof path), TFA_E_FILE);
    assert_string_equal(path, "the name is longer than 31 byte");
    assert_int_equal(tfa_urdf_find(NULL, path, sizeof path), TFA_E_ARGUMENT);
    assert_int_equal(tfa_urdf_find(name, path, 0), TFA_E_ARGUMENT);
}
