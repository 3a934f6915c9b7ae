/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A participant that listens to all replies about a robot, and streams torques to it: what really
 * goes over the wire while daemons take over from each other.
 */
#ifndef TFA_TESTS_DDS_WIRE_OBSERVER_H
#define TFA_TESTS_DDS_WIRE_OBSERVER_H

#include <stdint.h>

typedef struct wire_counts {
    uint64_t replies;       /* to calls, by the daemon of the highest epoch so far */
    uint64_t accelerations; /* that answer a sample of torques, likewise */
    uint64_t repeated;      /* of both: the same call or sample was answered in an older epoch */
    uint64_t twice_called, twice_streamed; /* answered before in the same epoch */
    uint64_t outdated;  /* of both: by a daemon of an older epoch; clients drop them */
    uint64_t takeovers; /* since the beginning */
    uint64_t published; /* samples of torques */
} wire_counts;

/* Joins the domain, in a thread of its own. */
void wire_observer_start(uint32_t domain, const char *robot);
wire_counts wire_observer_count(void);
void wire_observer_stop(void);

#endif
