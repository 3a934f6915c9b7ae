/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon as a whole, and its clients. Grouped by the file that defines it. Everything here
 * belongs to the control thread.
 */
#ifndef TFA_SERVICE_DAEMON_H
#define TFA_SERVICE_DAEMON_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "client/hello.h"
#include "config.h"
#include "robot.h"
#include "segment.h"
#include "worker.h"

/* A worker, its thread and what only it uses. */
typedef struct daemon_worker {
    tfa_worker *worker;
    tfa_segment pulse;
    tfa_robot_solver *solvers; /* one for each robot */
    pthread_t thread;
    bool started;
    uint32_t clients;
    uint64_t last_beat; /* for the watchdog */
} daemon_worker;

typedef enum session_state {
    SESSION_GREETING, /* connected, HELLO has not come */
    SESSION_SEATED,   /* has a ring */
    SESSION_LEAVING,  /* the worker was asked to let go */
} session_state;

/* One connection on the control socket. */
typedef struct session {
    struct session *next;
    session_state state;
    int socket, doorbell;
    uint32_t robot;
    uid_t user;
    pid_t process;
    uint64_t since; /* CLOCK_MONOTONIC ns of the connection */
    daemon_worker *worker;
    tfa_seat *seat;
    tfa_segment requests, replies;
} session;

typedef struct daemon_totals {
    uint64_t connections, refused, requests, rejected;
} daemon_totals;

typedef struct tfa_daemon {
    const config *settings;
    tfa_robot *robots; /* those with dds first: the DDS door numbers them as the workers do */
    uint32_t robot_count, dds_count;
    daemon_worker *workers;

    int epoll, signals, reserve;
    int *listeners; /* one for each robot */
    gid_t group;
    session *sessions;
    uint32_t session_count;
    uint64_t memory; /* bytes of all segments of clients */
    daemon_totals totals;
    bool stop;
    uint64_t watchdog_ns, watchdog_last; /* 0: nobody watches */
} tfa_daemon;

/* ---- fleet.c: robots and workers ---- */

TFA_CHECKED int daemon_load_robots(tfa_daemon *d);
TFA_CHECKED int daemon_start_workers(tfa_daemon *d);
TFA_CHECKED int daemon_self_test(tfa_daemon *d);
void daemon_stop_workers(tfa_daemon *d);
void daemon_free_fleet(tfa_daemon *d);

/* ---- control.c: the control thread's loop ---- */

/* Opens epoll and the signals, which must be blocked. */
TFA_CHECKED int control_open(tfa_daemon *d);
/* Opens the sockets: from now on clients come. */
TFA_CHECKED int control_listen(tfa_daemon *d);
/* Until a signal says stop. */
void control_run(tfa_daemon *d);
/* Closes the sockets; nobody new comes. */
void control_deafen(tfa_daemon *d);
void control_close(tfa_daemon *d);
uint64_t control_clock(void);

/* ---- session.c: clients ---- */

/* A connection was accepted. */
void session_begin(tfa_daemon *d, uint32_t robot, int socket);
/* Something happened on its socket. */
void session_event(tfa_daemon *d, session *s);
/* Time passed: late greetings, broken protocols, seats to give back. */
void session_tick(tfa_daemon *d);
/* Ends all of them; the workers run no more. */
void session_end_all(tfa_daemon *d);
/* Some session waits for its worker: look again soon. */
bool session_any_leaving(const tfa_daemon *d);

/* ---- notify.c: the service manager ---- */

void notify_ready(void);
void notify_stopping(void);
void notify_watchdog(void);
/* ns between two signs of life that the service manager wants; 0: none. */
uint64_t notify_watchdog_ns(void);

#endif
