/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The process that serves the test robots over DDS is totalforced itself.
 */
#include "dds_test.h"
#include "door_process.h"
#include "robots.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>

#define ARM TFA_SOURCE_DIR "/config/robots/arm7.urdf"
#define WALKER TFA_SOURCE_DIR "/config/robots/quadruped.urdf"

extern char **environ;

static char directory[64];
static pid_t running; /* a test that failed may leave one */

bool test_robots_make(test_robot robots[TEST_ROBOTS])
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    tfa_report report = {0};

    robots[0] = (test_robot){"arm", NULL};
    robots[1] = (test_robot){"walker", NULL};
    const bool made = tfa_model_load(ARM, NULL, &report, &robots[0].model) == TFA_OK &&
                      tfa_model_load(WALKER, &floating, &report, &robots[1].model) == TFA_OK;
    tfa_report_free(&report);
    return made;
}

void test_daemon_main(int argc, char **argv)
{
    (void)argc;
    (void)argv;
}

/* Robots that DDS must not know stand before and between those that it serves. */
static void write_config(const char *path, uint32_t domain)
{
    FILE *file = fopen(path, "w");

    assert_non_null(file);
    fprintf(file,
            "runtime_dir: %s/run\n"
            "dds:\n  enabled: true\n  domain: %u\n"
            "robots:\n"
            "  - name: hidden\n    urdf: " WALKER "\n    dds: false\n"
            "  - name: arm\n    urdf: " ARM "\n    estimate: never\n    max_batch: %d\n"
            "  - name: secret\n    urdf: " ARM "\n    dds: false\n"
            "  - name: walker\n    urdf: " WALKER "\n    base: floating\n    estimate: never\n"
            "    max_batch: %d\n",
            directory, domain, TEST_BATCH, TEST_BATCH);
    assert_int_equal(fclose(file), 0);
}

static void clean_up(void)
{
    char command[128];

    if (running > 0)
        kill(running, SIGKILL);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    (void)!system(command);
}

static void await_ready(int out)
{
    char text[4096];
    size_t length = 0;
    ssize_t got;

    while (length + 1 < sizeof text && (got = read(out, text + length, 1)) == 1) {
        text[++length] = '\0';
        if (text[length - 1] == '\n' && strstr(text, "ready:") != NULL)
            return;
    }
    fail_msg("totalforced does not become ready:\n%s", text);
}

test_daemon test_daemon_start(uint32_t domain, const test_daemon_options *options)
{
    char program[] = TFA_BINARY_DIR "/bin/totalforced", file[96];
    char *argv[] = {program, file, NULL};
    test_daemon daemon;
    posix_spawn_file_actions_t actions;
    int ends[2];

    (void)options;
    if (directory[0] == '\0') {
        strcpy(directory, "/tmp/totalforce-test-XXXXXX");
        assert_non_null(mkdtemp(directory));
        atexit(clean_up);
    }
    snprintf(file, sizeof file, "%s/config.yaml", directory);
    write_config(file, domain);
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    assert_int_equal(posix_spawn(&daemon.pid, program, &actions, NULL, argv, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    running = daemon.pid;
    close(ends[1]);
    daemon.out = ends[0];
    await_ready(daemon.out);
    return daemon;
}

unsigned long test_daemon_stop(test_daemon *daemon)
{
    int status;

    assert_int_equal(kill(daemon->pid, SIGTERM), 0);
    assert_int_equal(waitpid(daemon->pid, &status, 0), daemon->pid);
    running = 0;
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    close(daemon->out);
    return 0;
}
