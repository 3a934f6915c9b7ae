/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The transports by name. One is opened for each client; the first one draws the states that all
 * send, which outlive it. Errors are printed.
 */
#ifndef TOOLS_LATENCY_TRANSPORTS_OPEN_H
#define TOOLS_LATENCY_TRANSPORTS_OPEN_H

#include "latency/loop/transport.h"
#include "latency/workload/states.h"

TFA_CHECKED int transport_open(const latency_options *options, latency_via via,
                               latency_states *states, transport **t, transport_facts *facts);
TFA_CHECKED int transport_daemon_open(const latency_options *options, latency_via via,
                                      latency_states *states, transport **t,
                                      transport_facts *facts);
TFA_CHECKED int transport_process_open(const latency_options *options, latency_states *states,
                                       transport **t, transport_facts *facts);
TFA_CHECKED int transport_ros2_open(const latency_options *options, latency_states *states,
                                    transport **t, transport_facts *facts);
TFA_CHECKED int transport_socket_open(const latency_options *options, latency_states *states,
                                      transport **t, transport_facts *facts);

/** CLOCK_MONOTONIC, for transport_operations.now. */
uint64_t transport_clock(transport *t);
/** Waits until `until`: spins with TFA_WAIT_SPIN, otherwise sleeps. */
void transport_sleep(tfa_wait wait, uint64_t until);

#endif
