/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two totalforced that serve one robot over DDS, a client that calls without a pause and compares
 * every answer, and an observer that streams torques. A daemon without a processor may be replaced
 * at any time, rightly: who leads is asked for, not remembered.
 */
#ifndef TESTS_DDS_STANDBY_PAIR_H
#define TESTS_DDS_STANDBY_PAIR_H

#include "harness.h"
#include "wire_observer.h"

#include <stdatomic.h>
#include <stddef.h>

typedef struct standby_pair {
    harness nodes[2];
    uint32_t domain;
    harness *leader, *standby;
    uint64_t epoch; /* of the leader */
    _Atomic uint64_t answered, wrong, failed;
    _Atomic uint64_t longest_ns; /* between two answers; whoever reads it sets it to 0 */
} standby_pair;

extern standby_pair pair;

void pair_start(int lease_ms);
void pair_stop(void);

/** Waits until one leads and the other one stands by; sets leader, standby and epoch. */
void pair_settle(void);
/** So many more calls are answered, or torques: by whoever leads now. */
void pair_await_answers(uint64_t more);
void pair_await_stream(uint64_t more);

/** Leaderships, by the logs of both. */
unsigned pair_leaderships(void);
/** What a daemon says about who leads. @return false: it does not answer */
bool pair_leadership(const harness *h, char *out, size_t size);

/** Clients over shared memory that keep both daemons busy, until the pair is stopped. */
void pair_load(void);
uint64_t pair_load_answered(void);

/** What can happen to the leader; the last one can be continued. */
void pair_kill_leader(void);
void pair_end_leader(void);
void pair_pause_leader(void);
/** The leader is struck and the standby answers; the old leader is back, started or continued.
 *  @return ns in which nobody answered */
uint64_t pair_fail_over(void (*strike)(void));

#endif
