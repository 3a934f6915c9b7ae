/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The transports by name, and their shared clock and sleep.
 */
#include "open.h"

#include <errno.h>
#include <time.h>

#include "common/environment.h"

uint64_t transport_clock(transport *t)
{
    (void)t;
    return clock_ns();
}

void transport_sleep(tfa_wait wait, uint64_t until)
{
    const struct timespec at = {.tv_sec = (time_t)(until / 1000000000u),
                                .tv_nsec = (long)(until % 1000000000u)};
    if (wait == TFA_WAIT_SPIN) {
        while (clock_ns() < until)
            cpu_relax();
        return;
    }
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
}

int transport_open(const latency_options *options, latency_via via, latency_states *states,
                   transport **t, transport_facts *facts)
{
    *t = NULL;
    switch (via) {
    case VIA_PROCESS:
        return transport_process_open(options, states, t, facts);
    case VIA_SOCKET:
        return transport_socket_open(options, states, t, facts);
    case VIA_ROS2:
        return transport_ros2_open(options, states, t, facts);
    default:
        return transport_daemon_open(options, via, states, t, facts);
    }
}
