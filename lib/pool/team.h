/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A team of threads runs numbered tasks in phases: the caller works too and returns when all are
 * done. Knows nothing of dynamics.
 */
#ifndef TFA_POOL_TEAM_H
#define TFA_POOL_TEAM_H

#include <stdint.h>

struct team;

#define TEAM_MAX_TASKS ((1u << 20) - 1)

/* One task; `worker` is 0 for the caller of team_run, below the number of threads otherwise. */
typedef void team_task(void *context, uint32_t task, uint32_t worker);

/* Starts threads - 1 threads. cpus: NULL or one processor for each, the caller's first (unused).
 * Returns 0 or an errno. */
int team_start(struct team **team, uint32_t threads, uint32_t spin_ns, const int *cpus);

/* Runs task 0..tasks-1, each once, and returns when all are done. One caller at a time.
 * tasks <= TEAM_MAX_TASKS. */
void team_run(struct team *team, team_task *task, void *context, uint32_t tasks);

/* Ends and joins the threads. */
void team_stop(struct team *team);

#endif
