/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforced --check-rt` on machines made of files: a bare virtual machine, a real-time machine,
 * a container with a quota.
 */
#include "platform/check_rt.h"
#include "platform/realtime.h"
#include "test.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define CPU "/sys/devices/system/cpu"
#define CLOCK "/sys/devices/system/clocksource/clocksource0/current_clocksource"

typedef struct file {
    const char *path, *text;
} file;

static char root[64];

static void write_file(const file *f)
{
    char path[512], command[600];
    snprintf(path, sizeof path, "%s%s", root, f->path);
    snprintf(command, sizeof command, "mkdir -p \"$(dirname %s)\"", path);
    assert_int_equal(system(command), 0);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(f->text, out);
    fclose(out);
}

/* What is printed for a machine of these files. */
static char *check(tfa_check_rt c, const file *files, unsigned missing)
{
    char *text = NULL, command[128];
    size_t size = 0;
    strcpy(root, "/tmp/tfa-machine-XXXXXX");
    assert_non_null(mkdtemp(root));
    for (; files->path; files++)
        write_file(files);
    c.root = root;
    FILE *out = open_memstream(&text, &size);
    assert_int_equal(tfa_check_rt_print(&c, out), missing);
    fclose(out);
    snprintf(command, sizeof command, "rm -rf %s", root);
    assert_int_equal(system(command), 0);
    return text;
}

/* A line begins with this verdict and name and contains this value. */
static void assert_line(const char *text, const char *begin, const char *value)
{
    for (const char *line = text; line; line = strchr(line, '\n'), line += line != NULL)
        if (strncmp(line, begin, strlen(begin)) == 0 && strcspn(line, "\n") >= strlen(value)) {
            const char *end = strchr(line, '\n'), *at = strstr(line, value);
            assert_true(at && (!end || at < end));
            return;
        }
    fail_msg("no line '%s' in\n%s", begin, text);
}

TEST(bare_virtual_machine)
{
    static const file files[] = {
        {"/proc/sys/kernel/osrelease", "6.1.0-18-amd64\n"},
        {"/proc/cpuinfo", "flags\t: fpu sse hypervisor lahf_lm\n"},
        {"/proc/stat", "cpu 900 0 50 1000 0 0 0 50\n"},
        {"/proc/sys/kernel/sched_rt_runtime_us", "950000\n"},
        {CLOCK, "hpet\n"},
        {CPU "/isolated", "\n"},
        {"/sys/kernel/mm/transparent_hugepage/enabled", "[always] never\n"},
        {"/proc/swaps", "Filename\n/dev/sda2 partition\n"},
        {NULL, NULL}};
    const config wishes = {.workers = 2,
                           .allow_spin = true,
                           .limits = {.clients = 500},
                           .realtime = {.priority = 80, .mlock = true}};
    const tfa_check_rt c = {.settings = &wishes, .memlock = 65536, .files = 1024, .processors = 2};
    SCOPED_TEXT *text = check(c, files, 3);
    assert_line(text, "warning  kernel", "6.1.0-18-amd64, not PREEMPT_RT");
    assert_line(text, "warning  hypervisor", "virtual machine");
    assert_line(text, "warning  steal time", "2.50 %");
    assert_line(text, "missing  priority", "realtime.priority is 80");
    assert_line(text, "missing  locked memory", "64 KiB");
    assert_line(text, "missing  descriptors", "2064 for 500 clients");
    assert_line(text, "warning  throttling", "950000");
    assert_line(text, "warning  processors", "2 workers may spin");
    assert_line(text, "warning  clock source", "hpet");
    assert_line(text, "warning  huge pages", "[always]");
    assert_line(text, "warning  isolation", "no processor is isolated");
    assert_non_null(strstr(text, "LimitRTPRIO"));
}

TEST(real_time_machine)
{
    static uint32_t affinity[] = {3};
    static const file files[] = {{"/proc/sys/kernel/osrelease", "6.1.0-18-rt-amd64\n"},
                                 {"/sys/kernel/realtime", "1\n"},
                                 {"/proc/cpuinfo", "flags\t: fpu sse\n"},
                                 {"/proc/stat", "cpu 900 0 50 1000 0 0 0 0\n"},
                                 {"/proc/sys/kernel/sched_rt_runtime_us", "-1\n"},
                                 {CLOCK, "tsc\n"},
                                 {CPU "/isolated", "1,3-5\n"},
                                 {CPU "/cpu0/cpufreq/scaling_governor", "performance\n"},
                                 {CPU "/cpu0/cpuidle/state0/latency", "0\n"},
                                 {CPU "/cpu0/cpuidle/state1/latency", "2\n"},
                                 {"/proc/self/cgroup", "0::/user\n"},
                                 {"/sys/fs/cgroup/user/cpu.max", "max 100000\n"},
                                 {NULL, NULL}};
    const config wishes = {.workers = 1,
                           .allow_spin = true,
                           .limits = {.clients = 64},
                           .realtime = {.priority = 80,
                                        .mlock = true,
                                        .affinity = affinity,
                                        .affinity_count = 1,
                                        .cpu_dma_latency = CONFIG_ANY_LATENCY}};
    const tfa_check_rt c = {
        .settings = &wishes, .rtprio = 99, .memlock = UINT64_MAX, .files = 4096, .processors = 8};
    char *text = check(c, files, 0);
    assert_null(strstr(text, "warning"));
    assert_null(strstr(text, "->"));
    affinity[0] = 2;
    free(text);
    text = check(c, files, 0);
    assert_line(text, "warning  isolation",
                "processor 2 of realtime.affinity is not among '1,3-5'");
    free(text);
}

/* Wishes for processors, on machines with and without the kernel's list. */
TEST(no_processor_is_isolated)
{
    static uint32_t affinity[] = {3, 1};
    static const file empty[] = {{CPU "/isolated", "\n"}, {NULL, NULL}}, absent[] = {{NULL, NULL}};
    const config wishes = {.workers = 2, .realtime = {.affinity = affinity, .affinity_count = 2}};
    const tfa_check_rt c = {.settings = &wishes, .files = 4096, .processors = 8};
    for (int i = 0; i < 2; i++) {
        SCOPED_TEXT *text = check(c, i ? absent : empty, 0);
        assert_line(text, "warning  isolation",
                    "no processor is isolated; realtime.affinity names processor 3");
        assert_non_null(strstr(text, "-> kernel command line: isolcpus=N nohz_full=N"));
        assert_null(strstr(text, "''"));
    }
}

TEST(container_with_a_quota)
{
    static const file files[] = {{"/proc/self/cgroup", "0::/pod/box\n"},
                                 {"/sys/fs/cgroup/pod/box/cpu.max", "50000 100000\n"},
                                 {CPU "/cpu0/cpufreq/scaling_governor", "powersave\n"},
                                 {CPU "/cpu0/cpuidle/state0/latency", "0\n"},
                                 {CPU "/cpu0/cpuidle/state1/latency", "133\n"},
                                 {NULL, NULL}};
    SCOPED_TEXT *text = check((tfa_check_rt){.files = 1024, .processors = 4}, files, 0);
    assert_line(text, "warning  cpu quota", "50000 100000 us");
    assert_line(text, "warning  governor", "powersave");
    assert_line(text, "warning  idle states", "133 us");
}

/* The kernel asks for the soft limits of priorities and locked memory. */
TEST(soft_limits)
{
    struct rlimit before, lower;
    assert_int_equal(getrlimit(RLIMIT_MEMLOCK, &before), 0);
    lower = before;
    lower.rlim_cur = 4096;
    if (before.rlim_max < lower.rlim_cur)
        skip();
    assert_int_equal(setrlimit(RLIMIT_MEMLOCK, &lower), 0);
    const tfa_check_rt c = tfa_check_rt_here(NULL);
    assert_int_equal(setrlimit(RLIMIT_MEMLOCK, &before), 0);
    assert_int_equal(c.memlock, 4096);
}

/* Rests of a worker: for each ms a quarter more than what the kernel does not leave it. */
TEST(rests_are_as_long_as_the_kernel_asks)
{
    static const struct {
        uint32_t priority;
        const char *runtime, *period;
        uint32_t rest_ns;
    } rows[] = {{80, "950000", "1000000", 65789}, {1, "500000\n", "1000000\n", 1250000},
                {0, "950000", "1000000", 0},      {80, "-1", "1000000", 0},
                {80, "1000000", "1000000", 0},    {80, "", "1000000", 0}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const config_realtime wanted = {.priority = rows[i].priority};
        const file files[] = {{"/sched_rt_runtime_us", rows[i].runtime},
                              {"/sched_rt_period_us", rows[i].period}};
        char command[128];
        strcpy(root, "/tmp/tfa-machine-XXXXXX");
        assert_non_null(mkdtemp(root));
        assert_int_equal(tfa_realtime_rest_ns(&wanted, root), 0); /* no such files */
        write_file(&files[0]);
        write_file(&files[1]);
        assert_int_equal(tfa_realtime_rest_ns(&wanted, root), rows[i].rest_ns);
        snprintf(command, sizeof command, "rm -rf %s", root);
        assert_int_equal(system(command), 0);
    }
}

TEST(idle_states_that_are_not_wanted)
{
    static const file bare[] = {{CPU "/cpu0/cpuidle/state0/latency", "0\n"},
                                {CPU "/cpu0/cpuidle/state1/latency", "133\n"},
                                {NULL, NULL}},
                      device[] = {{CPU "/cpu0/cpuidle/state0/latency", "133\n"},
                                  {"/dev/cpu_dma_latency", ""},
                                  {NULL, NULL}};
    const config wishes = {.workers = 1, .realtime.cpu_dma_latency = 10};
    const tfa_check_rt c = {
        .settings = &wishes, .memlock = UINT64_MAX, .files = 4096, .processors = 4};
    char *text = check(c, bare, 1);
    assert_line(text, "missing  idle states", "133 us, realtime.cpu_dma_latency is 10");
    free(text);
    text = check(c, device, 0);
    assert_line(text, "ok       idle states", "133 us, realtime.cpu_dma_latency is 10");
    free(text);
}

/* The wish is a number in the device, as long as the descriptor is open; without one, a warning. */
TEST(the_wish_is_written)
{
    const config_realtime ten = {.cpu_dma_latency = 10},
                          none = {.cpu_dma_latency = CONFIG_ANY_LATENCY};
    char path[] = "/tmp/tfa-device-XXXXXX";
    const int opened = mkstemp(path);
    int32_t us = 0;
    assert_true(opened >= 0);
    const int fd = tfa_realtime_limit_idle_states(&ten, path);
    assert_true(fd >= 0);
    assert_int_equal(pread(opened, &us, sizeof us, 0), sizeof us);
    assert_int_equal(us, 10);
    close(fd);
    assert_int_equal(ftruncate(opened, 0), 0);
    assert_int_equal(tfa_realtime_limit_idle_states(&none, path), -1);
    assert_int_equal(pread(opened, &us, sizeof us, 0), 0);
    unlink(path);
    close(opened);
    assert_int_equal(tfa_realtime_limit_idle_states(&ten, path), -1);
}
