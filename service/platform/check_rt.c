/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The properties of a machine that decide its latency, each with a remedy.
 */
#include "platform/check_rt.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Bits of CapEff in /proc/self/status: capabilities(7) */
#define CAP_IPC_LOCK_BIT 14
#define CAP_SYS_NICE_BIT 23
/* Descriptors of a client: socket, segments, doorbell; and of the daemon itself */
#define FILES_PER_CLIENT 4
#define FILES_OF_DAEMON 64
/* A processor that needs longer to wake shows in every round trip that sleeps. */
#define IDLE_LATENCY_US 50
#define IDLE_STATES 16

typedef enum verdict { GOOD, WORSE, MISSING } verdict;

typedef struct finding {
    verdict verdict;
    char value[160];
} finding;

__attribute__((format(printf, 2, 3))) static finding found(verdict v, const char *format, ...)
{
    finding f = {.verdict = v};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(f.value, sizeof f.value, format, arguments);
    va_end(arguments);
    return f;
}

/* The first bytes of a file below the root, without the final newline. @return false: no file */
static bool read_text(const tfa_check_rt *c, const char *path, char *text, size_t size)
{
    char full[512];
    snprintf(full, sizeof full, "%s%s", c->root, path);
    FILE *in = fopen(full, "re");
    text[0] = 0;
    if (!in)
        return false;
    const size_t n = fread(text, 1, size - 1, in);
    fclose(in);
    text[n] = 0;
    if (n && text[n - 1] == '\n')
        text[n - 1] = 0;
    return true;
}

/* ---- properties ---- */

static finding find_kernel(const tfa_check_rt *c)
{
    char realtime[8], version[128];
    (void)read_text(c, "/proc/sys/kernel/osrelease", version, sizeof version);
    const bool rt =
        read_text(c, "/sys/kernel/realtime", realtime, sizeof realtime) && realtime[0] == '1';
    return found(rt ? GOOD : WORSE, "%.100s%s", version, rt ? ", PREEMPT_RT" : ", not PREEMPT_RT");
}

static finding find_hypervisor(const tfa_check_rt *c)
{
    char text[8192];
    (void)read_text(c, "/proc/cpuinfo", text, sizeof text);
    return strstr(text, " hypervisor")
               ? found(WORSE, "a virtual machine: its host takes processors "
                              "away for milliseconds")
               : found(GOOD, "none");
}

static finding find_steal(const tfa_check_rt *c)
{
    char text[512];
    uint64_t t[8] = {0}, sum = 0;
    (void)read_text(c, "/proc/stat", text, sizeof text);
    const int n = sscanf(text,
                         "cpu %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64
                         " %" SCNu64 " %" SCNu64,
                         &t[0], &t[1], &t[2], &t[3], &t[4], &t[5], &t[6], &t[7]);
    for (int i = 0; i < n; i++)
        sum += t[i];
    const double share = sum ? 100.0 * (double)t[7] / (double)sum : 0;
    return found(share > 0.1 ? WORSE : GOOD, "%.2f %% of the time since boot", share);
}

static finding find_priority(const tfa_check_rt *c)
{
    const uint32_t wanted = c->settings ? c->settings->realtime.priority : 0;
    if (c->nice_capability)
        return found(GOOD, "any (CAP_SYS_NICE)");
    return found(wanted > c->rtprio    ? MISSING
                 : wanted || c->rtprio ? GOOD
                                       : WORSE,
                 "up to %" PRIu64 ", realtime.priority is %u", c->rtprio, wanted);
}

static finding find_memlock(const tfa_check_rt *c)
{
    const bool wanted = c->settings && c->settings->realtime.mlock;
    const bool can = c->lock_capability || c->memlock == UINT64_MAX;
    if (can)
        return found(wanted ? GOOD : WORSE, "any%s", wanted ? "" : ", realtime.mlock is off");
    return found(wanted ? MISSING : WORSE, "%" PRIu64 " KiB, realtime.mlock is %s",
                 c->memlock / 1024, wanted ? "on" : "off");
}

static finding find_files(const tfa_check_rt *c)
{
    const uint64_t clients = c->settings ? c->settings->limits.clients : 0;
    const uint64_t wanted = clients * FILES_PER_CLIENT + FILES_OF_DAEMON;
    return found(c->files < wanted ? MISSING : GOOD,
                 "up to %" PRIu64 ", %" PRIu64 " for %" PRIu64 " clients", c->files, wanted,
                 clients);
}

static finding find_throttling(const tfa_check_rt *c)
{
    char text[32];
    if (!read_text(c, "/proc/sys/kernel/sched_rt_runtime_us", text, sizeof text))
        return found(GOOD, "none");
    return strcmp(text, "-1") == 0
               ? found(GOOD, "off")
               : found(WORSE,
                       "real-time threads run %s us in a second at most, workers rest "
                       "to stay below",
                       text);
}

static bool is_in_list(const char *list, uint32_t processor)
{
    for (const char *at = list; *at;) {
        char *end;
        const unsigned long first = strtoul(at, &end, 10);
        unsigned long last = first;
        if (end == at)
            return false;
        if (*end == '-')
            last = strtoul(end + 1, &end, 10);
        if (processor >= first && processor <= last)
            return true;
        at = *end == ',' ? end + 1 : end;
        if (*end && *end != ',')
            return false;
    }
    return false;
}

static finding find_isolation(const tfa_check_rt *c)
{
    char list[128];
    (void)read_text(c, "/sys/devices/system/cpu/isolated", list, sizeof list);
    const size_t wished = c->settings ? c->settings->realtime.affinity_count : 0;
    if (!*list && wished)
        return found(WORSE, "no processor is isolated; realtime.affinity names processor %u",
                     c->settings->realtime.affinity[0]);
    for (size_t i = 0; i < wished; i++)
        if (!is_in_list(list, c->settings->realtime.affinity[i]))
            return found(WORSE, "processor %u of realtime.affinity is not among '%s'",
                         c->settings->realtime.affinity[i], list);
    return found(*list ? GOOD : WORSE, "%s", *list ? list : "no processor is isolated");
}

static finding find_processors(const tfa_check_rt *c)
{
    const uint32_t spinners = c->settings && c->settings->allow_spin ? c->settings->workers : 0;
    return found(c->processors > spinners + 1 ? GOOD : WORSE,
                 "%u, %u workers may spin, and a client each", c->processors, spinners);
}

static finding find_governor(const tfa_check_rt *c)
{
    char text[32];
    if (!read_text(c, "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", text, sizeof text))
        return found(GOOD, "not adjustable here");
    return found(strcmp(text, "performance") == 0 ? GOOD : WORSE, "%s", text);
}

static bool can_write(const tfa_check_rt *c, const char *path)
{
    char full[512];
    return snprintf(full, sizeof full, "%s%s", c->root, path) < (int)sizeof full &&
           access(full, W_OK) == 0;
}

static finding find_idle_states(const tfa_check_rt *c)
{
    unsigned long deepest = 0;
    for (int k = 0; k < IDLE_STATES; k++) {
        char path[96], text[32];
        snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cpuidle/state%d/latency", k);
        if (!read_text(c, path, text, sizeof text))
            break;
        const unsigned long us = strtoul(text, NULL, 10);
        deepest = us > deepest ? us : deepest;
    }
    const uint32_t wanted =
        c->settings ? c->settings->realtime.cpu_dma_latency : CONFIG_ANY_LATENCY;
    if (deepest > wanted)
        return found(can_write(c, "/dev/cpu_dma_latency") ? GOOD : MISSING,
                     "waking takes up to %lu us, realtime.cpu_dma_latency is %u", deepest, wanted);
    return found(deepest > IDLE_LATENCY_US ? WORSE : GOOD, "waking takes up to %lu us", deepest);
}

static finding find_clock(const tfa_check_rt *c)
{
    char text[64];
    if (!read_text(c, "/sys/devices/system/clocksource/clocksource0/current_clocksource", text,
                   sizeof text))
        return found(GOOD, "unknown");
    const bool fast = strcmp(text, "tsc") == 0 || strcmp(text, "arch_sys_counter") == 0;
    return found(fast ? GOOD : WORSE, "%s%s", text, fast ? "" : ": reading it is a system call");
}

static finding find_huge_pages(const tfa_check_rt *c)
{
    char text[64];
    (void)read_text(c, "/sys/kernel/mm/transparent_hugepage/enabled", text, sizeof text);
    return found(strstr(text, "[always]") ? WORSE : GOOD, "%s", *text ? text : "none");
}

static finding find_swap(const tfa_check_rt *c)
{
    char text[512];
    const char *second = NULL;
    if (read_text(c, "/proc/swaps", text, sizeof text))
        second = strchr(text, '\n');
    const bool locked = c->settings && c->settings->realtime.mlock;
    return second && second[1] && !locked ? found(WORSE, "on, and memory is not locked")
                                          : found(GOOD, "%s", second && second[1] ? "on" : "off");
}

static finding find_quota(const tfa_check_rt *c)
{
    char group[256], path[512], text[64];
    if (!read_text(c, "/proc/self/cgroup", group, sizeof group) || strncmp(group, "0::", 3) != 0)
        return found(GOOD, "none");
    group[strcspn(group, "\n")] = 0;
    snprintf(path, sizeof path, "/sys/fs/cgroup%s/cpu.max", group + 3);
    if (!read_text(c, path, text, sizeof text) || strncmp(text, "max", 3) == 0)
        return found(GOOD, "none");
    return found(WORSE, "%s us: threads stand still when it is used up", text);
}

/* ---- the list ---- */

static const struct {
    const char *name;
    finding (*find)(const tfa_check_rt *c);
    const char *remedy;
} properties[] = {
    {"kernel", find_kernel, "apt install linux-image-rt-amd64, or another PREEMPT_RT kernel"},
    {"hypervisor", find_hypervisor, "run on the machine itself, or pin the virtual processors"},
    {"steal time", find_steal, "ask the host for processors of your own"},
    {"priority", find_priority,
     "systemd: LimitRTPRIO=99; login: 'USER - rtprio 99' in /etc/security/limits.d/"},
    {"locked memory", find_memlock,
     "realtime.mlock: yes; systemd: LimitMEMLOCK=infinity; login: 'USER - memlock unlimited' in "
     "/etc/security/limits.d/"},
    {"descriptors", find_files,
     "systemd: LimitNOFILE=4096; login: 'USER - nofile 4096' in /etc/security/limits.d/"},
    {"throttling", find_throttling,
     "sysctl kernel.sched_rt_runtime_us=-1, if nothing else starves"},
    {"isolation", find_isolation,
     "kernel command line: isolcpus=N nohz_full=N; then realtime.affinity: [N]"},
    {"processors", find_processors, "allow_spin: no, or fewer workers, or more processors"},
    {"governor", find_governor, "cpupower frequency-set -g performance"},
    {"idle states", find_idle_states,
     "realtime.cpu_dma_latency: 0, and /dev/cpu_dma_latency writable for the daemon's user; or "
     "tuned-adm profile latency-performance"},
    {"clock source", find_clock, "kernel command line: clocksource=tsc tsc=reliable"},
    {"huge pages", find_huge_pages, "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled"},
    {"swap", find_swap, "realtime.mlock: yes, or swapoff -a"},
    {"cpu quota", find_quota, "systemd: CPUQuota= (empty); containers: no --cpus"},
};

unsigned tfa_check_rt_print(const tfa_check_rt *check, FILE *out)
{
    static const char *const words[] = {[GOOD] = "ok", [WORSE] = "warning", [MISSING] = "missing"};
    unsigned missing = 0;
    for (size_t i = 0; i < sizeof properties / sizeof *properties; i++) {
        const finding f = properties[i].find(check);
        fprintf(out, "%-8s %-14s %s\n", words[f.verdict], properties[i].name, f.value);
        if (f.verdict != GOOD)
            fprintf(out, "%-23s -> %s\n", "", properties[i].remedy);
        missing += f.verdict == MISSING;
    }
    return missing;
}

/* `hard`: the daemon raises its limit; for others the kernel asks for the soft one. */
static uint64_t limit_of(int resource, bool hard)
{
    struct rlimit limit;
    if (getrlimit((__rlimit_resource_t)resource, &limit) != 0)
        return 0;
    const rlim_t value = hard ? limit.rlim_max : limit.rlim_cur;
    return value == RLIM_INFINITY ? UINT64_MAX : (uint64_t)value;
}

tfa_check_rt tfa_check_rt_here(const config *settings)
{
    char text[4096];
    tfa_check_rt c = {.root = "",
                      .settings = settings,
                      .rtprio = limit_of(RLIMIT_RTPRIO, false),
                      .memlock = limit_of(RLIMIT_MEMLOCK, false),
                      .files = limit_of(RLIMIT_NOFILE, true),
                      .processors = (uint32_t)sysconf(_SC_NPROCESSORS_ONLN)};
    (void)read_text(&c, "/proc/self/status", text, sizeof text);
    const char *effective = strstr(text, "CapEff:");
    const uint64_t bits = effective ? strtoull(effective + 7, NULL, 16) : 0;
    c.nice_capability = bits >> CAP_SYS_NICE_BIT & 1;
    c.lock_capability = bits >> CAP_IPC_LOCK_BIT & 1;
    return c;
}
