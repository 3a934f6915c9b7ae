/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients that ask 10 000 times a second and know, for each of two models, what must come back.
 */
#ifndef TFA_TESTS_SERVICE_LOAD_H
#define TFA_TESTS_SERVICE_LOAD_H

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>

#include <totalforce/model.h>

#include "harness.h"

#define LOAD_PERIOD_NS 100000u /* of one request */
#define LOAD_SLOTS 64
#define LOAD_BEHIND_NS 10000000u /* so late the machine is too slow: it starts the clock anew */
#define LOAD_STATES 16
#define LOAD_JOINTS 7
#define LOAD_MODELS 2
#define LOAD_CLIENTS 2    /* they take turns */
#define LOAD_MAX 2000000u /* requests that are remembered */

/** What is known of one request. */
typedef struct load_sample {
    uint64_t due;         /**< CLOCK_MONOTONIC ns */
    uint32_t latency;     /**< ns from then to its reply */
    uint32_t wait;        /**< ns in the ring before the worker turned to it */
    uint32_t computation; /**< ns of the worker */
    bool first;           /**< the first that this model answered */
} load_sample;

/** A client of one robot, and what its two models answer. */
typedef struct load_client {
    tfa_client *client;
    double expected[LOAD_MODELS][LOAD_STATES][LOAD_JOINTS];
    uint64_t tags[LOAD_MODELS];
    uint64_t id;       /**< of the last reply */
    _Atomic int model; /**< that answered last; -1: none has */
} load_client;

/** All clients in one thread. What is wrong ends it, with `error` saying what. */
typedef struct load {
    load_client clients[LOAD_CLIENTS];
    pthread_t thread;
    _Atomic bool stop;
    _Atomic uint32_t count;
    load_sample *samples;
    uint64_t start, end; /**< CLOCK_MONOTONIC ns */
    uint32_t resyncs;    /**< more than LOAD_BEHIND_NS behind */
    const char *error;
    int status; /**< of the request that failed */
} load;

/** What one client asks. */
typedef struct load_robot {
    const char *name;
    const tfa_model *models[LOAD_MODELS];
} load_robot;

/** Computes what the models answer and starts asking. */
void load_start(load *l, const harness *h, const load_robot robots[LOAD_CLIENTS], tfa_wait wait);
/** Waits until all clients were answered by this model. @return false: they were not */
bool load_count_answers(load *l, int model);
/** Ends the thread and hangs up. @return nothing was wrong */
bool load_stop(load *l);
void load_free(load *l);
/** How long it asked, ns. */
uint64_t load_time(const load *l);

typedef struct load_figures {
    uint32_t count, median, p99, worst; /* ns */
} load_figures;

/** Of one member of the samples from..to that are `first` or not: its offset in load_sample. */
load_figures load_poll(const load *l, uint32_t from, uint32_t to, bool first, size_t member);

#endif
