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

struct team_options {
    uint32_t threads;    /* the caller included */
    uint32_t spin_ns;    /* how long an idle thread spins before it sleeps */
    const int *cpus;     /* NULL, or a processor for each thread, the caller's first (unused) */
    int priority;        /* SCHED_FIFO; 0: as the thread that starts them */
    void (*begin)(void); /* what each thread does first, or NULL */
};

/* Starts threads - 1 threads. Returns 0 or an errno. */
int team_start(struct team **team, const struct team_options *options);

/* Makes the caller the one who may run tasks, unless there is one: returns 0 then, at once. */
int team_take(struct team *team);
/* Gives that back. */
void team_leave(struct team *team);

/* Runs task 0..tasks-1, each once, and returns when all are done. One caller at a time, who knows
 * that he is the only one or has taken the team. tasks <= TEAM_MAX_TASKS. */
void team_run(struct team *team, team_task *task, void *context, uint32_t tasks);

/* Ends and joins the threads. */
void team_stop(struct team *team);

#endif
