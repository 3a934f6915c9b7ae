/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory locks, processors, priorities; and giving up root.
 */
#include "realtime.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <link.h>
#include <pwd.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "log.h"

/* Before Linux 5.14 there is no such advice, and the first request of a kind faults its code in. */
static int populate(struct dl_phdr_info *object, size_t size, void *unused)
{
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    (void)size;
    (void)unused;
    for (int k = 0; k < object->dlpi_phnum; k++) {
        const ElfW(Phdr) *segment = &object->dlpi_phdr[k];
        const uintptr_t start = object->dlpi_addr + segment->p_vaddr, first = start / page * page;
        if (segment->p_type == PT_LOAD && !(segment->p_flags & PF_W))
            (void)madvise((void *)first, start + segment->p_memsz - first, MADV_POPULATE_READ);
    }
    return 0;
}

void tfa_realtime_populate(void)
{
    (void)dl_iterate_phdr(populate, NULL);
}

void tfa_realtime_lock(const config_realtime *wanted)
{
    if (!wanted->mlock)
        return;
    if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0)
        tfa_log(TFA_LOG_INFO, "memory is locked");
    else
        tfa_log(TFA_LOG_WARNING,
                "realtime.mlock: not had: %s; raise LimitMEMLOCK or give "
                "CAP_IPC_LOCK",
                strerror(errno));
}

int tfa_realtime_limit_idle_states(const config_realtime *wanted, const char *device)
{
    const int32_t us = (int32_t)wanted->cpu_dma_latency;
    if (wanted->cpu_dma_latency == CONFIG_ANY_LATENCY)
        return -1;
    const int fd = open(device, O_WRONLY | O_CLOEXEC);
    if (fd >= 0 && write(fd, &us, sizeof us) == (ssize_t)sizeof us) {
        tfa_log(TFA_LOG_INFO, "idle states of more than %d us are not entered", us);
        return fd;
    }
    tfa_log(TFA_LOG_WARNING,
            "realtime.cpu_dma_latency: not had: %s: %s; let the daemon's user write there (unit: "
            "PrivateDevices=no, DevicePolicy=closed, DeviceAllow=/dev/cpu_dma_latency rw; udev: "
            "KERNEL==\"cpu_dma_latency\", GROUP=\"totalforce\", MODE=\"0660\")",
            device, strerror(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}

static void set_processor(uint32_t processor, uint32_t number, pthread_t thread)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    int error = pthread_setaffinity_np(thread, sizeof set, &set);
    if (error)
        tfa_log(TFA_LOG_WARNING, "realtime.affinity: worker %u may not run on processor %u: %s",
                number, processor, strerror(error));
}

void tfa_realtime_worker(const config_realtime *wanted, uint32_t number, pthread_t thread)
{
    const struct sched_param parameter = {.sched_priority = (int)wanted->priority};
    if (number < wanted->affinity_count)
        set_processor(wanted->affinity[number], number, thread);
    if (!wanted->priority)
        return;
    int error = pthread_setschedparam(thread, SCHED_FIFO, &parameter);
    if (error)
        tfa_log(TFA_LOG_WARNING,
                "realtime.priority: worker %u stays with the ordinary scheduler: "
                "%s; raise LimitRTPRIO or give CAP_SYS_NICE",
                number, strerror(error));
    else
        tfa_log(TFA_LOG_INFO, "worker %u runs at FIFO priority %u", number, wanted->priority);
}

static long long read_number(const char *folder, const char *name)
{
    char path[256];
    long long number = -1;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *in = fopen(path, "re");
    if (in && fscanf(in, "%lld", &number) != 1)
        number = -1;
    if (in)
        fclose(in);
    return number;
}

uint32_t tfa_realtime_rest_ns(const config_realtime *wanted, const char *folder)
{
    const long long runs = read_number(folder, "sched_rt_runtime_us");
    const long long period = read_number(folder, "sched_rt_period_us");
    if (!wanted->priority || runs <= 0 || period <= runs)
        return 0;
    /* a quarter more than the part that is not left: clocks and other real-time threads */
    return (uint32_t)(1e6 * 1.25 * (double)(period - runs) / (double)runs);
}

void tfa_realtime_raise_files(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < limit.rlim_max) {
        limit.rlim_cur = limit.rlim_max;
        (void)setrlimit(RLIMIT_NOFILE, &limit);
    }
}

static void report_unknown(const config *c, const char *key, const char *name, const char *list)
{
    char location[512];
    config_location(c, key, location, sizeof location);
    tfa_log(TFA_LOG_ERROR, "%s: %s: there is no %s '%s' on this machine; getent %s lists them",
            location, key, key, name, list);
}

static const struct passwd *find_user(const config *c)
{
    const struct passwd *entry = getpwnam(c->user);
    if (!entry)
        report_unknown(c, "user", c->user, "passwd");
    return entry;
}

static const struct group *find_group(const config *c)
{
    const struct group *entry = getgrnam(c->group);
    if (!entry)
        report_unknown(c, "group", c->group, "group");
    return entry;
}

int tfa_identity_check(const config *c)
{
    const bool user = !c->user || find_user(c), group = !c->group || find_group(c);
    return user && group ? TFA_OK : TFA_E_ARGUMENT;
}

int tfa_identity_find(const config *c, uid_t *user, gid_t *user_group, gid_t *group)
{
    *user = (uid_t)-1;
    *user_group = *group = (gid_t)-1;
    if (c->user && geteuid() == 0) {
        const struct passwd *entry = find_user(c);
        if (!entry)
            return TFA_E_ARGUMENT;
        *user = entry->pw_uid;
        *user_group = entry->pw_gid;
    }
    if (c->group) {
        const struct group *entry = find_group(c);
        if (!entry)
            return TFA_E_ARGUMENT;
        *group = entry->gr_gid;
    }
    return TFA_OK;
}

int tfa_identity_become(uid_t user, gid_t user_group, gid_t group)
{
    /* the sockets' group must stay ours, or we could not give them to it */
    const size_t groups = group == (gid_t)-1 ? 0 : 1;
    if (setgroups(groups, &group) != 0 || setresgid(user_group, user_group, user_group) != 0 ||
        setresuid(user, user, user) != 0)
        return TFA_E_SYSTEM;
    return setuid(0) == 0 ? TFA_E_SYSTEM : TFA_OK; /* no way back */
}
