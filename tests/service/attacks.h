/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile sessions at the sockets of a daemon with an arm.
 */
#ifndef TFA_TESTS_SERVICE_ATTACKS_H
#define TFA_TESTS_SERVICE_ATTACKS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "harness.h"

typedef struct attack {
    const char *name;
    int sessions;
    void (*run)(const harness *h); /* in a thread of each session */
    unsigned steps;                /* in all sessions, until it is under way */
    bool busy;                     /* takes the processors, too */
} attack;

extern const attack attacks[];
extern const size_t attack_count;

/** Threads on one futex word. */
extern int attack_parked;

/** Of which every kind of request is asked. */
extern const char *attack_robot;

/** Takes a processor and asks for nothing. */
void attack_loop(const harness *h);

/** Starts the sessions in a process of their own, which runs until it or this one is killed. */
pid_t attack_start(const attack *a, harness *h);
/** What the sessions of the last attack have done: requests, connections, rings of the doorbell. */
unsigned long attack_steps(void);
/** Kills it. */
void attack_stop(pid_t process);

#endif
