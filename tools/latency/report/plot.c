/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Page and comparison of a session: `totalforce plot` as a child process.
 */
#include "report.h"

#include "common/commands.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

/* Runs this program with other arguments. @return an exit status */
static int run(int out, const char *const *arguments)
{
    const pid_t child = fork();
    int status = -1;
    if (child == 0) {
        dup2(out, STDOUT_FILENO);
        execv("/proc/self/exe", (char *const *)(uintptr_t)arguments);
        _exit(EXIT_FAILED);
    }
    const int ended = child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status);
    return ended && WEXITSTATUS(status) == EXIT_GOOD ? EXIT_GOOD : EXIT_FAILED;
}

int latency_compare(const char *before, const char *after)
{
    return run(STDOUT_FILENO, (const char *[]){"totalforce", "plot", before, after, NULL});
}

int latency_check_plot(const latency_options *o)
{
    const char *const argument = o->compare_count ? o->compare[0] : "--help";
    if (!o->compare_count && !o->html)
        return EXIT_GOOD;
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    const int result = run(nowhere, (const char *[]){"totalforce", "plot", argument, NULL});
    close(nowhere);
    return result;
}

int latency_plot(const latency_options *o, const latency_session *session)
{
    char path[] = "/tmp/totalforce-latency-XXXXXX";
    const char *arguments[] = {"totalforce", "plot", NULL, NULL, NULL, NULL, NULL};
    int count = 2;
    if (!o->compare_count && !o->html)
        return EXIT_GOOD;
    const int file = mkstemp(path);
    if (file < 0 || close(file) != 0 || latency_save(path, session) != 0) {
        perror(path);
        return EXIT_FAILED;
    }
    if (o->html) {
        arguments[count++] = "--html";
        arguments[count++] = o->html;
    }
    if (o->compare_count)
        arguments[count++] = o->compare[0];
    arguments[count] = path;
    const int result = run(o->json ? STDERR_FILENO : STDOUT_FILENO, arguments);
    remove(path);
    return result;
}
