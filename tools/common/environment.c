/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads /proc, /sys and getrusage.
 */
#include "environment.h"

#include "allocations.h"

#include <ctype.h>
#include <dirent.h>
#include <inttypes.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <time.h>
#include <totalforce/dynamics.h>
#include <totalforce/version.h>
#include <unistd.h>

/* First line of a small file, or JSON null. */
static json_t *first_line(const char *path)
{
    char line[256];
    FILE *file = fopen(path, "re");
    json_t *text = NULL;
    if (file && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = '\0';
        if (line[0])
            text = json_string(line);
    }
    if (file)
        fclose(file);
    return text ? text : json_null();
}

static void add_processor(json_t *facts)
{
    char *line = NULL;
    size_t size = 0;
    int hypervisor = 0;
    FILE *file = fopen("/proc/cpuinfo", "re");
    while (file && getline(&line, &size, file) > 0) {
        char *value = strchr(line, ':');
        if (!value)
            break; /* the first processor is enough */
        value += value[1] == ' ' ? 2 : 1;
        value[strcspn(value, "\n")] = '\0';
        if (strncmp(line, "model name", 10) == 0)
            json_object_set_new(facts, "processor", json_string(value));
        if (strncmp(line, "flags", 5) == 0)
            hypervisor = strstr(value, " hypervisor") != NULL;
    }
    free(line);
    if (file)
        fclose(file);
    json_object_set_new(facts, "hypervisor", json_boolean(hypervisor));
    json_object_set_new(facts, "processors_online", json_integer(sysconf(_SC_NPROCESSORS_ONLN)));
}

const char *environment_policy(int policy)
{
    switch (policy) {
    case SCHED_OTHER:
        return "SCHED_OTHER";
    case SCHED_FIFO:
        return "SCHED_FIFO";
    case SCHED_RR:
        return "SCHED_RR";
    default:
        return "other";
    }
}

/* Processors this thread may run on. */
static void add_affinity(json_t *facts)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        json_object_set_new(facts, "client_processors", json_integer(CPU_COUNT(&set)));
}

json_t *environment_read(void)
{
    static const char *const files[][2] = {
        {"governor", "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"},
        {"isolated_processors", "/sys/devices/system/cpu/isolated"},
        {"clock_source", "/sys/devices/system/clocksource/clocksource0/current_clocksource"},
    };
    struct utsname system;
    json_t *facts = json_object();
    json_object_set_new(facts, "version", json_string(TFA_VERSION));
    json_object_set_new(facts, "client_kernels", json_string(tfa_isa_name()));
    if (uname(&system) == 0) {
        json_object_set_new(facts, "kernel", json_string(system.release));
        json_object_set_new(facts, "kernel_build", json_string(system.version));
        json_object_set_new(facts, "preempt_rt",
                            json_boolean(strstr(system.version, "PREEMPT_RT") != NULL));
    }
    add_processor(facts);
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        json_object_set_new(facts, files[i][0], first_line(files[i][1]));
    add_affinity(facts);
    return facts;
}

uint64_t environment_steal_ticks(void)
{
    uint64_t steal = 0;
    FILE *file = fopen("/proc/stat", "re");
    if (!file)
        return 0;
    /* cpu user nice system idle iowait irq softirq steal */
    if (fscanf(file, "cpu %*u %*u %*u %*u %*u %*u %*u %" SCNu64, &steal) != 1)
        steal = 0;
    fclose(file);
    return steal;
}

static void read_switches(const char *directory, thread_usage *thread)
{
    char path[400], line[256];
    snprintf(path, sizeof path, "%s/status", directory);
    FILE *file = fopen(path, "re");
    while (file && fgets(line, sizeof line, file)) {
        if (sscanf(line, "Name: %31[^\n]", thread->name) == 1)
            continue;
        if (sscanf(line, "voluntary_ctxt_switches: %" SCNd64, &thread->voluntary) == 1)
            continue;
        if (sscanf(line, "nonvoluntary_ctxt_switches: %" SCNd64, &thread->involuntary) == 1)
            continue;
    }
    if (file)
        fclose(file);
}

static void read_faults(const char *directory, thread_usage *thread)
{
    char path[400], line[1024];
    snprintf(path, sizeof path, "%s/stat", directory);
    FILE *file = fopen(path, "re");
    /* the name may hold blanks and brackets: the numbers start after the last bracket */
    if (file && fgets(line, sizeof line, file)) {
        const char *after = strrchr(line, ')');
        if (after && sscanf(after + 1, " %*c %*d %*d %*d %*d %*d %*u %" SCNd64 " %*u %" SCNd64,
                            &thread->minor_faults, &thread->major_faults) != 2)
            thread->minor_faults = thread->major_faults = 0;
    }
    if (file)
        fclose(file);
}

static void read_cpu_time(const char *directory, thread_usage *thread)
{
    char path[400];
    snprintf(path, sizeof path, "%s/schedstat", directory);
    FILE *file = fopen(path, "re");
    if (!file || fscanf(file, "%" SCNd64, &thread->cpu_ns) != 1)
        thread->cpu_ns = -1;
    if (file)
        fclose(file);
}

/* tid 0 is the calling thread. */
static void read_policy(thread_usage *thread)
{
    struct sched_param parameters = {0};
    thread->policy = sched_getscheduler(thread->tid);
    sched_getparam(thread->tid, &parameters);
    thread->priority = parameters.sched_priority;
}

int environment_threads(pid_t process, thread_usage threads[THREADS_MAX])
{
    char path[64];
    int count = 0;
    snprintf(path, sizeof path, "/proc/%d/task", (int)process);
    DIR *tasks = process > 0 ? opendir(path) : NULL;
    struct dirent *entry;
    while (tasks && count < THREADS_MAX && (entry = readdir(tasks))) {
        char directory[64 + sizeof entry->d_name + 1];
        if (!isdigit((unsigned char)entry->d_name[0]))
            continue;
        snprintf(directory, sizeof directory, "%s/%s", path, entry->d_name);
        threads[count] = (thread_usage){.tid = (pid_t)atoi(entry->d_name), .allocations = -1};
        read_cpu_time(directory, &threads[count]);
        read_switches(directory, &threads[count]);
        read_faults(directory, &threads[count]);
        read_policy(&threads[count]);
        count++;
    }
    if (tasks)
        closedir(tasks);
    return count;
}

thread_usage environment_this_thread(void)
{
    struct rusage usage = {0};
    struct timespec cpu = {0};
    getrusage(RUSAGE_THREAD, &usage);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
    thread_usage thread = {.name = "client",
                           .voluntary = usage.ru_nvcsw,
                           .involuntary = usage.ru_nivcsw,
                           .minor_faults = usage.ru_minflt,
                           .major_faults = usage.ru_majflt,
                           .cpu_ns = (int64_t)cpu.tv_sec * 1000000000 + cpu.tv_nsec,
                           .allocations = allocations_count()};
    read_policy(&thread);
    return thread;
}

thread_usage environment_difference(const thread_usage *before, const thread_usage *after)
{
    thread_usage change = *after;
    change.voluntary -= before->voluntary;
    change.involuntary -= before->involuntary;
    change.minor_faults -= before->minor_faults;
    change.major_faults -= before->major_faults;
    change.cpu_ns = after->cpu_ns < 0 || before->cpu_ns < 0 ? -1 : after->cpu_ns - before->cpu_ns;
    change.allocations = after->allocations < 0 ? -1 : after->allocations - before->allocations;
    return change;
}
