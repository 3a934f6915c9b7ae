/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon as a whole. Everything here belongs to the control thread.
 */
#ifndef TFA_SERVICE_CONTROL_DAEMON_H
#define TFA_SERVICE_CONTROL_DAEMON_H

#include "control/commands.h"
#include "control/control.h"
#include "control/recordings.h"
#include "control/reload.h"
#include "control/session.h"
#include "platform/runtime_dir.h"

struct tfa_daemon {
    config *settings;
    robot_set robot_set;
    tfa_thread_pool *thread_pool; /* threads of all robots' pools; NULL: none */
    daemon_worker *workers;
    gateway_slot gateways[TFA_GATEWAY_SOURCES]; /* by source */
    robot_descriptions descriptions;
    reload reload;

    int epoll, signals, reserve;
    uint64_t start; /* CLOCK_MONOTONIC ns */
    int command_listener;
    command commands[COMMANDS_MAX];
    int *listeners; /* one for each robot */
    gid_t group;
    tfa_runtime_dir runtime_dir;
    uint64_t runtime_dir_looked; /* CLOCK_MONOTONIC ns */
    tfa_admission admission;
    tfa_connect_rate connect_rate;
    recording *recordings;
    session *sessions;
    uint32_t session_count;
    tfa_segment statistics_segment;
    tfa_statistics_view statistics; /* in it */
    bool stop;
    uint64_t watchdog_ns, watchdog_last; /* 0: no watchdog */
};

#endif
