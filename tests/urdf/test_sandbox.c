/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reading a robot opens its file and nothing else: no mesh, no network, no output.
 */
#include "test.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/inotify.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <totalforce/model.h>
#include <unistd.h>

static const char robot[] =
    "<robot name=\"r\">\n"
    "<material name=\"m\"><texture filename=\"%s/mesh.png\"/></material>\n"
    "<link name=\"a\"><inertial><mass value=\"1\"/>"
    "<inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial>"
    "<visual><geometry><mesh filename=\"package://p/mesh.dae\"/></geometry></visual>"
    "<visual><geometry><mesh filename=\"%s/mesh.stl\"/></geometry></visual>"
    "<visual><geometry><mesh filename=\"file://%s/mesh.stl\"/></geometry></visual>"
    "<collision><geometry><mesh filename=\"%s/pipe\"/></geometry></collision>"
    "<collision><geometry><mesh filename=\"http://127.0.0.1:9/mesh.stl\"/></geometry></collision>"
    "<collision><geometry><mesh filename=\"mesh.stl\"/></geometry></collision></link>\n"
    "</robot>\n";

/* A folder with a robot, a mesh, a texture and a pipe that nobody writes to. */
struct folder {
    char path[64];
    char urdf[96];
    char mesh[96];
    char texture[96];
    char pipe[96];
};

static void write_file(const char *path, const char *text)
{
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    assert_int_equal(fclose(out), 0);
}

static int make_folder(void **state)
{
    struct folder *f = calloc(1, sizeof *f);
    assert_non_null(f);
    strcpy(f->path, "/tmp/tfa-sandbox-XXXXXX");
    assert_non_null(mkdtemp(f->path));
    snprintf(f->urdf, sizeof f->urdf, "%s/robot.urdf", f->path);
    snprintf(f->mesh, sizeof f->mesh, "%s/mesh.stl", f->path);
    snprintf(f->texture, sizeof f->texture, "%s/mesh.png", f->path);
    snprintf(f->pipe, sizeof f->pipe, "%s/pipe", f->path);
    write_file(f->mesh, "solid");
    write_file(f->texture, "png");
    assert_int_equal(mkfifo(f->pipe, 0600), 0);
    char text[4096];
    snprintf(text, sizeof text, robot, f->path, f->path, f->path, f->path);
    write_file(f->urdf, text);
    *state = f;
    return 0;
}

static int remove_folder(void **state)
{
    struct folder *f = *state;
    unlink(f->urdf);
    unlink(f->mesh);
    unlink(f->texture);
    unlink(f->pipe);
    rmdir(f->path);
    free(f);
    return 0;
}

static void load(const char *path)
{
    tfa_report report = {0};
    tfa_model *model = NULL;
    assert_int_equal(tfa_model_load(path, NULL, &report, &model), TFA_OK);
    tfa_model_free(model);
    tfa_report_free(&report);
}

/* Names of the files in the folder that were opened since the last call, with blanks between. */
static void opened(int watch, char *names, size_t size)
{
    _Alignas(struct inotify_event) char events[4096];
    names[0] = '\0';
    ssize_t got = read(watch, events, sizeof events);
    for (ssize_t at = 0; at < got;) {
        const struct inotify_event *e = (const void *)(events + at);
        size_t n = strlen(names);
        snprintf(names + n, size - n, "%s ", e->len > 0 ? e->name : ".");
        at += (ssize_t)sizeof *e + (ssize_t)e->len;
    }
}

/* A reader would hang in the pipe: the alarm turns that into a failure. */
static void test_meshes_stay_closed(void **state)
{
    const struct folder *f = *state;
    char names[1024];
    int watch = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (watch < 0 || inotify_add_watch(watch, f->path, IN_OPEN) < 0) {
        print_message("skipped: inotify does not work here\n");
        skip();
        return;
    }
    close(open(f->mesh, O_RDONLY | O_CLOEXEC));
    opened(watch, names, sizeof names);
    assert_string_equal(names, "mesh.stl "); /* the watch sees what it has to see */
    char *here = getcwd(NULL, 0);
    assert_non_null(here);
    assert_int_equal(chdir(f->path), 0); /* relative names lead to the mesh as well */
    opened(watch, names, sizeof names);
    alarm(120);
    load(f->urdf);
    alarm(0);
    opened(watch, names, sizeof names);
    assert_int_equal(chdir(here), 0);
    free(here);
    close(watch);
    assert_string_equal(names, "robot.urdf ");
}

/* From now on a process that opens, connects, starts or prints anything is killed. */
static bool forbid_everything(void)
{
#define KILL(call)                                                                                 \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_##call, 0, 1),                                         \
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS)
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        KILL(openat),
        KILL(socket),
        KILL(connect),
        KILL(execve),
#ifdef SYS_open
        KILL(open),
#endif
        /* Writing to a pipe of its own is how the undefined behaviour sanitizer tests an
         * address. */
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_write, 0, 2),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[0])),
        BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, STDERR_FILENO, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
    };
#undef KILL
    struct sock_fprog filter = {.len = sizeof code / sizeof *code, .filter = code};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

enum { WORKED = 0, FAILED = 1, NO_FILTER = 2 };

enum after { NOTHING, OPEN, PRINT };

static int parse_in_sandbox(const char *text, enum after after)
{
    if (!forbid_everything())
        return NO_FILTER;
    tfa_report report = {0};
    tfa_description *d = NULL;
    int status = tfa_urdf_parse(text, strlen(text), "f.urdf", &d, &report);
    tfa_description_free(d);
    tfa_report_free(&report);
    if (after == OPEN)
        (void)open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (after == PRINT && write(STDERR_FILENO, "", 0) != 0)
        return FAILED;
    return status == TFA_OK || status == TFA_E_PARSE ? WORKED : FAILED;
}

/* The status of a child that parses `text` and may do nothing else. */
static int run_sandbox(const char *text, enum after after)
{
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(parse_in_sandbox(text, after));
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

/* Neither a good nor a bad file makes the parser open, connect, start or print anything. */
static void test_only_computes(void **state)
{
    const struct folder *f = *state;
    char text[4096];
    snprintf(text, sizeof text, robot, f->path, f->path, f->path, f->path);
    int status = run_sandbox(text, NOTHING);
    if (WIFEXITED(status) && WEXITSTATUS(status) == NO_FILTER) {
        print_message("skipped: no seccomp filters here\n");
        skip();
        return;
    }
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == WORKED);
    status = run_sandbox("<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1,5\"/>"
                         "</inertial></link><joint/></robot>",
                         NOTHING);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == WORKED);
    for (enum after after = OPEN; after <= PRINT; after++) { /* the filter filters */
        status = run_sandbox(text, after);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_meshes_stay_closed, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_only_computes, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
