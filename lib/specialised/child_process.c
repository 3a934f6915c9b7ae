/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A compiler as a child process, with limits on processor time, memory and file size.
 */
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

#define TIMEOUT_FACTOR 2 /* wall-clock limit over the limit of processor time */
#define POLL_NS 5000000

/* SIGXCPU tells a process at its soft limit of processor time; a process that ignores it is killed
 * at the wall-clock limit. The shell sets its own limits and becomes the program; arguments are
 * passed unchanged. */
static const char limited[] = "ulimit -S -t \"$1\" && ulimit -v \"$2\" && ulimit -f \"$3\" && "
                              "ulimit -c 0 && shift 3 && exec \"$@\"";

double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct launch {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    char limit[3][16];
    char temporary[600];
    const char *argv[BUILD_ARGUMENTS_MAX + 8];
};

static void set_arguments(struct launch *c, const char *const *argv, const struct process_limits *l)
{
    size_t n = 0;
    snprintf(c->limit[0], sizeof c->limit[0], "%u", l->seconds);
    snprintf(c->limit[1], sizeof c->limit[1], "%llu", l->memory_mib * 1024ull);
    snprintf(c->limit[2], sizeof c->limit[2], "%llu", l->file_mib * 2048ull); /* of 512 bytes */
    const char *const first[] = {"sh", "-c", limited, "sh", c->limit[0], c->limit[1], c->limit[2]};
    for (; n < sizeof first / sizeof *first; n++)
        c->argv[n] = first[n];
    for (size_t k = 0; k < BUILD_ARGUMENTS_MAX && argv[k]; k++)
        c->argv[n++] = argv[k];
    c->argv[n] = NULL;
}

/* Signals as at the start of a program, a process group of its own. */
static int set_attributes(struct launch *c)
{
    sigset_t none, all;
    const struct sched_param ordinary = {0};
    short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP |
                  POSIX_SPAWN_SETSCHEDULER;
    sigemptyset(&none);
    sigfillset(&all);
    sigdelset(&all, SIGKILL);
    sigdelset(&all, SIGSTOP);
    return posix_spawnattr_setsigmask(&c->attributes, &none) ||
           posix_spawnattr_setsigdefault(&c->attributes, &all) ||
           posix_spawnattr_setpgroup(&c->attributes, 0) ||
           posix_spawnattr_setschedpolicy(&c->attributes, SCHED_OTHER) ||
           posix_spawnattr_setschedparam(&c->attributes, &ordinary) ||
           posix_spawnattr_setflags(&c->attributes, flags);
}

/* No input, output to a file, no other open file of this process. */
static int set_files(struct launch *c, const char *output_path)
{
    return posix_spawn_file_actions_addopen(&c->files, 0, "/dev/null", O_RDONLY, 0) ||
           posix_spawn_file_actions_addopen(&c->files, 1, output_path, O_WRONLY | O_CREAT | O_TRUNC,
                                            0600) ||
           posix_spawn_file_actions_adddup2(&c->files, 1, 2) ||
           posix_spawn_file_actions_addclosefrom_np(&c->files, 3);
}

static int is_cancelled(const struct process_limits *l)
{
    return l->cancel && *l->cancel;
}

/* Returns the exit status; kills the process group at the wall-clock limit, or when cancelled. */
static int wait_for(const struct child_process *child, const struct process_limits *l,
                    int *timed_out)
{
    const double end = child->start_time + TIMEOUT_FACTOR * (double)l->seconds;
    const struct timespec pause = {0, POLL_NS};
    int result = 0;
    for (;;) {
        const pid_t got = waitpid(child->process, &result, WNOHANG);
        if (got == child->process)
            return result;
        if (got < 0 && errno != EINTR)
            return -1;
        if (!*timed_out && seconds_now() > end) {
            *timed_out = 1;
            kill(-child->process, SIGKILL);
        }
        if (is_cancelled(l))
            kill(-child->process, SIGKILL);
        nanosleep(&pause, NULL);
    }
}

/* Start of the output, control characters replaced by blanks. */
static void read_output(const char *output_path, char *text, size_t size)
{
    FILE *file = fopen(output_path, "re");
    const size_t n = file ? fread(text, 1, size - 1, file) : 0;
    text[n] = '\0';
    if (file)
        fclose(file);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
}

static int check_exit_status(const char *program, int result, int timed_out,
                             const struct process_limits *l, const char *output_path,
                             struct error_text *err)
{
    char text[400];
    const int signal_of = WIFSIGNALED(result) ? WTERMSIG(result) : 0;
    if (timed_out || signal_of == SIGXCPU)
        return refuse(err, TFA_E_TIMEOUT, "%s took more than %u s and was stopped", program,
                      l->seconds);
    if (result == 0)
        return TFA_OK;
    read_output(output_path, text, sizeof text);
    return refuse(err, TFA_E_NOT_COMPUTED,
                  "%s failed (%s %d; it had %u s, %u MiB of memory, files up to %u MiB): %s",
                  program, signal_of ? "signal" : "status",
                  signal_of ? signal_of : WEXITSTATUS(result), l->seconds, l->memory_mib,
                  l->file_mib, text);
}

static int spawn_child(struct launch *c, const char *folder, pid_t *process)
{
    const char *path = getenv("PATH");
    char search[4096];
    snprintf(search, sizeof search, "PATH=%s", path ? path : "/usr/bin:/bin");
    snprintf(c->temporary, sizeof c->temporary, "TMPDIR=%s", folder);
    char locale[] = "LC_ALL=C";
    char *environment[] = {search, c->temporary, locale, NULL};
    return posix_spawn(process, "/bin/sh", &c->files, &c->attributes, (char **)c->argv,
                       environment);
}

int child_process_start(const char *const *argv, const char *folder, int number,
                        const struct process_limits *limits, struct child_process *child,
                        struct error_text *err)
{
    struct launch c;
    *child = (struct child_process){.program = argv[0], .start_time = seconds_now()};
    snprintf(child->output_path, sizeof child->output_path, "%s/said%d", folder, number);
    if (posix_spawn_file_actions_init(&c.files) != 0)
        return TFA_E_MEMORY;
    if (posix_spawnattr_init(&c.attributes) != 0) {
        posix_spawn_file_actions_destroy(&c.files);
        return TFA_E_MEMORY;
    }
    set_arguments(&c, argv, limits);
    int error = set_attributes(&c) || set_files(&c, child->output_path) ? ENOMEM : 0;
    if (!error)
        error = spawn_child(&c, folder, &child->process);
    posix_spawnattr_destroy(&c.attributes);
    posix_spawn_file_actions_destroy(&c.files);
    if (!error)
        return TFA_OK;
    child->process = 0;
    return refuse(err, TFA_E_SYSTEM, "%s cannot be started: %s", argv[0], strerror(error));
}

int child_process_wait(struct child_process *child, const struct process_limits *limits,
                       struct error_text *err)
{
    int timed_out = 0;
    const int result = wait_for(child, limits, &timed_out);
    kill(-child->process, SIGKILL); /* its descendants */
    child->process = 0;
    if (is_cancelled(limits))
        return refuse(err, TFA_E_NOT_COMPUTED, "%s was cancelled", child->program);
    return check_exit_status(child->program, result, timed_out, limits, child->output_path, err);
}

void child_process_stop(struct child_process *child)
{
    int result;
    if (!child->process)
        return;
    kill(-child->process, SIGKILL);
    while (waitpid(child->process, &result, 0) < 0 && errno == EINTR)
        ;
    child->process = 0;
}

int child_process_run(const char *const *argv, const char *folder,
                      const struct process_limits *limits, struct error_text *err)
{
    struct child_process child;
    const int status = child_process_start(argv, folder, 0, limits, &child, err);
    return status == TFA_OK ? child_process_wait(&child, limits, err) : status;
}
