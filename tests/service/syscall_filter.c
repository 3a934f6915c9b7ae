/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The filter: malloc by interposition, system calls by seccomp.
 */
#include "syscall_filter.h"

#include <dlfcn.h>
#include <errno.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define FAST __attribute__((tls_model("initial-exec")))

#define LIVENESS_CHECK_NS 100000000 /* lib/client/wait.c */
#define SLOWNESS 64                 /* of the worker's clock */

static __thread bool filtered FAST, slow FAST;
static __thread long clock_calls FAST;
static __thread int64_t clock_start FAST, clock_read FAST, checked FAST;

/* ---- allocation ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *memory);

static void check(void)
{
    if (filtered)
        __builtin_trap();
}

EXPORT void *malloc(size_t size)
{
    check();
    return __libc_malloc(size);
}

EXPORT void *calloc(size_t count, size_t size)
{
    check();
    return __libc_calloc(count, size);
}

EXPORT void *realloc(void *memory, size_t size)
{
    check();
    return __libc_realloc(memory, size);
}

EXPORT void *aligned_alloc(size_t alignment, size_t size)
{
    check();
    return __libc_memalign(alignment, size);
}

EXPORT void *memalign(size_t alignment, size_t size);
EXPORT void *memalign(size_t alignment, size_t size)
{
    return aligned_alloc(alignment, size);
}

EXPORT int posix_memalign(void **memory, size_t alignment, size_t size)
{
    *memory = aligned_alloc(alignment, size);
    return *memory ? 0 : ENOMEM;
}

EXPORT void free(void *memory)
{
    check();
    __libc_free(memory);
}

/* ---- system calls ---- */

#define ALLOW(number)                                                                              \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (number), 0, 1),                                           \
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
#define ALLOW_FD(number, fd)                                                                       \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (number), 0, 4),                                           \
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[0])),                \
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (fd), 0, 1),                                           \
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),                                              \
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS)

EXPORT int tfa_test_filter_syscalls(void)
{
    const bool pool = getenv("TFA_FILTER_POOL") != NULL;
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        ALLOW(pool ? SYS_futex : SYS_exit_group),
        ALLOW(pool ? SYS_sched_yield : SYS_exit_group),
        ALLOW(pool ? SYS_clock_nanosleep : SYS_exit_group),
        ALLOW(SYS_clock_gettime),
        ALLOW(SYS_getrusage),
        ALLOW(SYS_exit_group),
        ALLOW_FD(SYS_read, FILTER_READ_FD),
        ALLOW_FD(SYS_write, FILTER_WRITE_FD),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
    };
    const struct sock_fprog program = {.len = sizeof filter / sizeof *filter, .filter = filter};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) != 0)
        return errno;
    struct timespec now;
    filtered = true;
    clock_gettime(CLOCK_MONOTONIC, &now);
    clock_start = checked = clock_read;
    return 0;
}

/* ---- the look at the socket ---- */

EXPORT int poll(struct pollfd *fds, nfds_t count, int timeout)
{
    if (!filtered)
        return (int)syscall(SYS_poll, fds, count, timeout);
    if (timeout != 0 || clock_read - checked < LIVENESS_CHECK_NS)
        __builtin_trap();
    checked = clock_read;
    return 0;
}

/* ---- a thread that does not know of the filter ---- */

static bool is_wanted(const char *thread)
{
    char name[16];
    return pthread_getname_np(pthread_self(), name, sizeof name) == 0 && strcmp(name, thread) == 0;
}

static void tell_time(struct timespec *time)
{
    clock_read = time->tv_sec * INT64_C(1000000000) + time->tv_nsec;
    if (!slow)
        return;
    const int64_t told = clock_start + (clock_read - clock_start) / SLOWNESS;
    *time = (struct timespec){.tv_sec = told / 1000000000, .tv_nsec = told % 1000000000};
}

EXPORT int clock_gettime(clockid_t id, struct timespec *time)
{
    static int (*real)(clockid_t, struct timespec *);
    static long after = -1;
    static const char *thread;
    if (!real) { /* the first call comes long before there is a second thread that asks */
        const char *text = getenv("TFA_FILTER_AFTER");
        thread = getenv("TFA_FILTER_THREAD");
        after = text && thread ? strtol(text, NULL, 10) : -1;
        *(void **)(void *)&real = dlsym(RTLD_NEXT, "clock_gettime");
    }
    if (after > 0 && !filtered && ++clock_calls == after) {
        if (!is_wanted(thread))
            clock_calls = 0;
        else if (tfa_test_filter_syscalls() != 0)
            _exit(99);
        slow = filtered;
    }
    const int result = real(id, time);
    if (result == 0 && filtered)
        tell_time(time);
    return result;
}
