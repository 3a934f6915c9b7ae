/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The system without a compiler, and compilers that fail, hang, write too much or nothing: each is
 * said, and nothing is left behind.
 */
#include "bench.h"
#include "support/wait.h"
#include "test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Besides . and .. */
static uint32_t entries(const char *folder)
{
    uint32_t count = 0;
    DIR *all = opendir(folder);
    assert_non_null(all);
    for (struct dirent *e; (e = readdir(all));)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(all);
    return count;
}

/* Builds the arm's kernel with these options, which must fail so. */
static void expect(bench *b, tfa_specialise_options options, int status, const char *error_text)
{
    char path[256];
    bench_path(b, "kernels/kernel.so", path);
    if (!options.sources)
        options.sources = b->sources;
    const int got =
        tfa_specialised_build(b->arm, &options, path, NULL, b->error_text, sizeof b->error_text);
    if (got != status)
        fail_msg("%s: %s, not %s", b->error_text, tfa_status_name(got), tfa_status_name(status));
    bench_assert_error_text(b, error_text);
    assert_int_equal(entries(b->kernels), 0);
}

/* A program that answers --version as a compiler does, and then does this. */
static const char *script(bench *b, const char *does, char path[256])
{
    char text[1024];
    const int length = snprintf(text, sizeof text,
                                "#!/bin/sh\n[ \"$1\" = --version ] && echo 'fake 12.0' && exit 0\n"
                                "for word; do last=$word; done\n%s\n",
                                does);
    bench_write(bench_path(b, "fake", path), text, (size_t)length);
    assert_int_equal(chmod(path, 0755), 0);
    return path;
}

TEST(compilers_that_are_not_there)
{
    bench b;
    char path[256];
    bench_open(&b);
    bench_write(bench_path(&b, "sources/dynamics/specialised/specialised.c", path), "", 0);
    char *before = strdup(getenv("PATH"));
    setenv("PATH", b.kernels, 1);
    expect(&b, (tfa_specialise_options){0}, TFA_E_UNSUPPORTED,
           "looked for clang, gcc and cc in PATH; `apt install clang`");
    setenv("PATH", before, 1);
    free(before);
    expect(&b, (tfa_specialise_options){.compiler = "no-such-compiler"}, TFA_E_UNSUPPORTED,
           "there is no compiler 'no-such-compiler'");
    expect(&b, (tfa_specialise_options){.compiler = "/etc/passwd"}, TFA_E_UNSUPPORTED,
           "there is no compiler '/etc/passwd'");
    expect(&b, (tfa_specialise_options){.sources = "/etc"}, TFA_E_FILE,
           "no dynamics/specialised/specialised.c in '/etc'");
    bench_close(&b);
}

TEST(compilers_that_fail)
{
    bench b;
    char path[256];
    bench_open(&b);
    bench_write(bench_path(&b, "sources/dynamics/specialised/specialised.c", path), "int x = ;\n",
                10);
    expect(&b, (tfa_specialise_options){0}, TFA_E_NOT_COMPUTED, "expected expression");
    expect(&b,
           (tfa_specialise_options){.compiler = script(&b, "echo 'worn out' >&2; exit 7", path)},
           TFA_E_NOT_COMPUTED, "worn out");
    bench_assert_error_text(&b, "status 7");
    expect(&b, (tfa_specialise_options){.compiler = script(&b, "exit 0", path)}, TFA_E_NOT_COMPUTED,
           "made no shared object");
    bench_close(&b);
}

/* Limits are of its own processes: one that computes, one that waits, one that writes, one that
 * takes memory. */
TEST(compilers_without_end)
{
    bench b;
    char path[256];
    bench_open(&b);
    bench_write(bench_path(&b, "sources/dynamics/specialised/specialised.c", path), "", 0);
    tfa_specialise_options o = {.seconds = 1, .memory_mib = 256, .file_mib = 1};
    o.compiler = script(&b, "sleep 1000 & wait", path);
    expect(&b, o, TFA_E_TIMEOUT, "more than 1 s");
    o.compiler = script(&b, "while :; do :; done", path);
    expect(&b, o, TFA_E_TIMEOUT, "more than 1 s");
    o.seconds = 300; /* these end by themselves */
    o.compiler = script(&b, "head -c 9000000 /dev/zero >\"$last\"", path);
    expect(&b, o, TFA_E_NOT_COMPUTED, "files up to 1 MiB");
    o.compiler = script(&b,
                        "n=$(head -c 300000000 /dev/zero | tail -n 1 | wc -c)\n"
                        "[ \"$n\" -ge 300000000 ] || exit 3",
                        path);
    expect(&b, o, TFA_E_NOT_COMPUTED, "status 3");
    bench_close(&b);
}

/* A build in a process of its own, whose compilers make a file "started.PROCESS".
 * @return when it is there */
static pid_t start_build(bench *b, const char *compiler)
{
    char path[256], name[32], started[256];
    const tfa_specialise_options options = {.sources = b->sources, .compiler = compiler};
    bench_path(b, "kernels/kernel.so", path);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(tfa_specialised_build(b->arm, &options, path, NULL, NULL, 0) != TFA_OK);
    snprintf(name, sizeof name, "started.%d", (int)child);
    bench_path(b, name, started);
    assert_true(WAIT_FOR(access(started, F_OK) == 0));
    return child;
}

/* Kills the build and waits until its lock is free: a compiler on its way to exec has a copy of the
 * descriptor. */
static void end_build(bench *b, pid_t child)
{
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    DIR *all = opendir(b->kernels);
    assert_non_null(all);
    for (struct dirent *e; (e = readdir(all));) {
        if (e->d_name[0] == '.' && strlen(e->d_name) <= 2)
            continue;
        const int folder = openat(dirfd(all), e->d_name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        assert_true(WAIT_FOR(flock(folder, LOCK_EX | LOCK_NB) == 0));
        close(folder);
    }
    closedir(all);
}

/* The next build removes what a killed one left, and nothing of one that runs. */
TEST(killed_builds)
{
    bench b;
    char path[256], mark[256], started[256], does[600], compiler[256];
    bench_open(&b);
    bench_write(bench_path(&b, "sources/dynamics/specialised/specialised.c", path), "", 0);
    bench_write(bench_path(&b, "mark", mark), "", 0);
    snprintf(
        does, sizeof does,
        "touch %s.$PPID; n=0; while [ -e %s ] && [ $((n += 1)) -lt 6000 ]; do sleep 0.05; done",
        bench_path(&b, "started", started), mark);
    script(&b, does, compiler);
    end_build(&b, start_build(&b, compiler));
    assert_int_equal(entries(b.kernels), 1);
    const pid_t running = start_build(&b, compiler); /* in its place */
    const tfa_specialise_options fails = {.sources = b.sources, .compiler = "/etc/passwd"};
    assert_int_equal(tfa_specialised_build(b.arm, &fails, bench_path(&b, "kernels/kernel.so", path),
                                           NULL, NULL, 0),
                     TFA_E_UNSUPPORTED);
    assert_int_equal(entries(b.kernels), 1);
    end_build(&b, running);
    assert_int_equal(unlink(mark), 0);
    expect(&b, fails, TFA_E_UNSUPPORTED, "there is no compiler");
    bench_close(&b);
}

TEST(files_that_cannot_be_written)
{
    bench b;
    char path[256];
    const tfa_specialise_options options = {.sources = b.sources};
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernel.so", path));
    assert_int_equal(tfa_specialised_build(b.arm, &options, bench_path(&b, "no/kernel.so", path),
                                           NULL, b.error_text, sizeof b.error_text),
                     TFA_E_FILE);
    bench_assert_error_text(&b, "cannot be written");
    assert_int_equal(
        tfa_specialised_build(b.arm, &options, b.kernels, NULL, b.error_text, sizeof b.error_text),
        TFA_E_FILE);
    assert_int_equal(tfa_specialised_build(NULL, &options, path, NULL, NULL, 0), TFA_E_ARGUMENT);
    assert_int_equal(tfa_specialised_build(b.arm, &options, NULL, NULL, NULL, 0), TFA_E_ARGUMENT);
    bench_close(&b);
}

/* Paths reach the compiler as they are, whatever a shell would make of them. */
TEST(words_are_not_read_by_a_shell)
{
    bench b;
    char from[256], to[256], path[256];
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernel.so", path));
    assert_int_equal(rename(bench_path(&b, "sources", from),
                            bench_path(&b, "$(touch owned) ; 'touch' \"owned\" *", to)),
                     0);
    const tfa_specialise_options options = {.sources = to};
    assert_int_equal(
        tfa_specialised_build(b.arm, &options, path, NULL, b.error_text, sizeof b.error_text),
        TFA_OK);
    assert_int_not_equal(access("owned", F_OK), 0);
    bench_close(&b);
}
