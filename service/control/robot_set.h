/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robots of the daemon and the workers that solve for them.
 */
#ifndef TFA_SERVICE_CONTROL_ROBOT_SET_H
#define TFA_SERVICE_CONTROL_ROBOT_SET_H

#include <pthread.h>

#include "robots/robot.h"
#include "worker/worker.h"

typedef struct tfa_daemon tfa_daemon;

/* A worker, its thread and its solvers */
typedef struct daemon_worker {
    tfa_worker *worker;
    tfa_robot_solver **solvers; /* one for each robot */
    pthread_t thread, long_thread;
    bool started, has_long_thread;
    uint32_t clients;
    uint64_t last_heartbeat; /* for the watchdog */
} daemon_worker;

/* All robots and scenes of a configuration: the served ones, or the ones that a reload made. */
typedef struct robot_set {
    tfa_robot *robots; /* those with dds first: the DDS gateway numbers them as the workers do */
    uint32_t count;
} robot_set;

/* @param descriptions  by robot of the configuration, NULL: its file; NULL: all files */
TFA_CHECKED int robot_set_load(const config *settings, char *const *descriptions, robot_set *f);
/* Loads one robot of the configuration and its scenes into a set like `now`, whose others stay
 * empty. */
TFA_CHECKED int robot_set_load_one(const config *settings, const robot_set *now, size_t robot,
                                   tfa_robot_urdf *urdf, robot_set *f);
void robot_set_unload(robot_set *f);
/* Number of the robot of this name; UINT32_MAX: none, and the error is in `text`. */
uint32_t robot_set_find(const robot_set *f, const char *name, char *text, size_t size);
/* Starts the pool's threads, if configured. */
TFA_CHECKED int daemon_start_pool(tfa_daemon *d);
/* tfa_robot_prepare of each. */
TFA_CHECKED int daemon_prepare_robots(tfa_daemon *d);
TFA_CHECKED int daemon_start_workers(tfa_daemon *d);
TFA_CHECKED int daemon_self_test(tfa_daemon *d);
/* A solver of robot `i` of the set, for a worker or a gateway, into `solvers` by robot, which are
 * made when they are NULL. */
TFA_CHECKED int daemon_make_solver(const tfa_daemon *d, uint32_t i, bool of_worker,
                                   tfa_robot_solver ***solvers, tfa_worker_robot *made);
void daemon_stop_workers(tfa_daemon *d);
void daemon_free_robot_set(tfa_daemon *d);

/* ---- description_segment.c ---- */

/* Settings and URDF of robot `i` (ipc/recording.h), read when they are first asked for and kept
 * until its model is exchanged. @return NULL: the error is in `text` */
const tfa_segment *description_segment(tfa_daemon *d, uint32_t i, char *text, size_t size);

#endif
