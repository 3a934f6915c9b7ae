/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The control thread: its loop, statistics, the service manager.
 */
#ifndef TFA_SERVICE_CONTROL_CONTROL_H
#define TFA_SERVICE_CONTROL_CONTROL_H

#include "control/robot_set.h"

/* ---- control.c: the control thread's loop ---- */

/* Opens epoll and the signals, which must be blocked. */
TFA_CHECKED int control_open(tfa_daemon *d);
/* Opens the sockets that are not open: from now on clients come. Notes in the lock file that all
 * are. */
TFA_CHECKED int control_listen(tfa_daemon *d);
/* Descriptions that are received are loaded from now on. */
TFA_CHECKED int control_watch_descriptions(tfa_daemon *d);
/* Until a signal says stop. */
void control_run(tfa_daemon *d);
/* Closes the sockets: no new clients. */
void control_close_listeners(tfa_daemon *d);
void control_close(tfa_daemon *d);
uint64_t control_clock(void);
/* Takes a connection, or hangs up on it where descriptors have run out. @return it, or -1 */
int control_accept(tfa_daemon *d, int listener);

/* ---- statistics.c: counters in shared memory ---- */

/* Makes the segment for the robots of the set and all clients, and describes the robots. */
TFA_CHECKED int statistics_open(tfa_daemon *d);
/* Robots were exchanged: describes them again. */
void statistics_update(tfa_daemon *d);
void statistics_close(tfa_daemon *d);
/* The blocks of a worker. */
tfa_worker_statistics statistics_of_worker(const tfa_daemon *d, uint32_t worker);
/* States that a gateway publishes, by robot. */
tfa_shared_state *statistics_gateway_states(const tfa_daemon *d, uint32_t source);
/* Requests of clients that left; of all clients, those that left and gateways included. */
tfa_tally_sums statistics_departed(const tfa_daemon *d);
tfa_tally_sums statistics_all(const tfa_daemon *d);

/* ---- notify.c: the service manager ---- */

void notify_ready(void);
void notify_reloading(void);
void notify_stopping(void);
void notify_watchdog(void);
/* ns between two signs of life that the service manager wants; 0: none. */
uint64_t notify_watchdog_ns(void);

#endif
