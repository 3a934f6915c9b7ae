/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Real-time rights of the daemon: asked for by the configuration, reported when they were refused.
 */
#ifndef TFA_SERVICE_PLATFORM_REALTIME_H
#define TFA_SERVICE_PLATFORM_REALTIME_H

#include <pthread.h>
#include <stdint.h>
#include <sys/types.h>

#include "config/config.h"

/** Maps all code and constants of the program and its libraries, so that no request does. */
void tfa_realtime_populate(void);

/** Locks all memory, if configured. A refusal is a warning in the log. */
void tfa_realtime_lock(const config_realtime *wanted);

/** Keeps the processors out of idle states that take long to leave, if configured, until the
 *  process ends. `device`: TFA_CPU_DMA_LATENCY. A refusal is a warning in the log.
 *  @return a descriptor, which holds the wish; -1: none */
int tfa_realtime_limit_idle_states(const config_realtime *wanted, const char *device);
#define TFA_CPU_DMA_LATENCY "/dev/cpu_dma_latency"

/** Gives worker `number` its processor and priority, if configured. */
void tfa_realtime_worker(const config_realtime *wanted, uint32_t number, pthread_t thread);

/** The rest that keeps a worker of this priority below the share of time that the kernel leaves to
 *  real-time threads (`folder`: /proc/sys/kernel), ns for each ms; 0: it needs none. */
uint32_t tfa_realtime_rest_ns(const config_realtime *wanted, const char *folder);

/** As many descriptors as the system lets us have: each client takes some. */
void tfa_realtime_raise_files(void);

/** Do the user and the group of the configuration exist? Said in the log, with key, line and value.
 *  @return TFA_OK; TFA_E_ARGUMENT: not both */
TFA_CHECKED int tfa_identity_check(const config *c);

/** Finds user and group of the configuration. @return TFA_OK; TFA_E_ARGUMENT: there is none of
 *  that name (said in the log). Ids that are not configured become -1. */
TFA_CHECKED int tfa_identity_find(const config *c, uid_t *user, gid_t *user_group, gid_t *group);

/** Becomes the user for good. @return TFA_OK; TFA_E_SYSTEM */
TFA_CHECKED int tfa_identity_become(uid_t user, gid_t user_group, gid_t group);

#endif
