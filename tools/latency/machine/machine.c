/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The machine beside the round trips.
 */
#include "machine.h"

#include "pingpong.h"

#include <errno.h>
#include <sched.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

static void sleep_until(uint64_t at)
{
    const struct timespec t = {.tv_sec = (time_t)(at / 1000000000u),
                               .tv_nsec = (long)(at % 1000000000u)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR)
        ;
}

void machine_measure_timer(machine_timer *timer, uint64_t interval_ns, uint64_t duration_ns)
{
    timer->interval_ns = interval_ns;
    uint64_t at = clock_ns();
    for (uint64_t left = duration_ns / interval_ns; left > 0; left--) {
        at += interval_ns;
        sleep_until(at);
        const uint64_t now = clock_ns();
        tfa_histogram_add(&timer->late.h, now > at ? now - at : 0);
        if (now > at + interval_ns)
            at = now; /* as cyclictest: intervals that were slept over are left out */
    }
}

void machine_measure_gaps(machine_gaps *gaps, uint64_t duration_ns)
{
    const uint64_t start = clock_ns();
    uint64_t last = start;
    while (last - start < duration_ns) {
        const uint64_t now = clock_ns();
        if (now - last > MACHINE_GAP_NS) {
            tfa_histogram_add(&gaps->gaps.h, now - last);
            gaps->lost_ns += now - last;
        }
        last = now;
    }
    gaps->elapsed_ns = last - start;
}

int machine_set_priority(int priority)
{
    const struct sched_param param = {.sched_priority = priority};
    if (sched_setscheduler(0, priority ? SCHED_FIFO : SCHED_OTHER, &param) == 0)
        return 0;
    fprintf(stderr,
            "totalforce latency: --priority %d: %s: raise the limit (rtprio in "
            "/etc/security/limits.conf, LimitRTPRIO= of a unit), or give CAP_SYS_NICE\n",
            priority, strerror(errno));
    return -1;
}

int machine_lock_memory(void)
{
    if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0)
        return 0;
    fprintf(stderr,
            "totalforce latency: --mlock: %s: raise the limit (memlock in "
            "/etc/security/limits.conf, LimitMEMLOCK= of a unit), or give CAP_IPC_LOCK\n",
            strerror(errno));
    return -1;
}

int machine_processors(void)
{
    cpu_set_t ours;
    return sched_getaffinity(0, sizeof ours, &ours) == 0 ? CPU_COUNT(&ours) : 1;
}

double machine_load(void)
{
    double load = 0;
    return getloadavg(&load, 1) == 1 ? load : -1;
}

__attribute__((format(printf, 2, 3))) static void append(machine_busy *busy, const char *format,
                                                         ...)
{
    const size_t length = strlen(busy->text), comma = length ? 2 : 0;
    va_list arguments;
    if (length + comma >= sizeof busy->text)
        return;
    memcpy(busy->text + length, ", ", comma);
    va_start(arguments, format);
    vsnprintf(busy->text + length + comma, sizeof busy->text - length - comma, format, arguments);
    va_end(arguments);
}

void machine_judge(machine_busy *busy)
{
    memset(busy->text, 0, sizeof busy->text);
    if (busy->gap_share > MACHINE_BUSY_GAPS)
        append(busy, "gaps took %.1f %% of a spinning thread's time", 100 * busy->gap_share);
    if (busy->steal > MACHINE_BUSY_STEAL)
        append(busy, "the host stole %.1f %% of the processors' time", 100 * busy->steal);
    if (busy->load > busy->processors)
        append(busy, "load %.1f on %d processors", busy->load, busy->processors);
    busy->busy = busy->text[0] != '\0';
}
