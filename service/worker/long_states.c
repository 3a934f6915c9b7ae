/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A thread beside a worker answers requests whose states take longer than the worker admits
 * (max_state_us): one at a time, with solvers of its own, while the worker serves the others.
 *
 * A request is the worker's (HERE) until it finds that its kind takes too long (WAITING), then the
 * thread's (AWAY), then the worker's again, which publishes the reply. Its client stays attached
 * until it has come back.
 *   phase  IDLE -> GIVEN  worker, A17 store release  <-> R17 thread, load acquire: the request
 *          GIVEN -> DONE  thread, A18 store release  <-> R18 worker, load acquire: its reply
 *          DONE -> IDLE   worker
 */
#include "worker_internal.h"

#define SETTLE_NS 100000

static uint32_t phase_of(const tfa_worker *w)
{
    return atomic_load_explicit(&w->long_states.phase, memory_order_acquire); /* R18 */
}

bool tfa_worker_long_may_go_on(const tfa_worker *w, const tfa_worker_client *client)
{
    switch (client->at.place) {
    case REQUEST_WAITING:
        return phase_of(w) == LONG_IDLE;
    case REQUEST_AWAY:
        return phase_of(w) == LONG_DONE;
    default:
        return true;
    }
}

void tfa_worker_long_give(tfa_worker *w, tfa_worker_client *client)
{
    worker_long_states *l = &w->long_states;
    client->at.place = REQUEST_AWAY;
    l->at = &client->at;
    atomic_store_explicit(&l->phase, LONG_GIVEN, memory_order_release); /* A17 */
    (void)sem_post(&l->given);
}

uint64_t tfa_worker_long_take_back(tfa_worker *w, tfa_worker_client *client)
{
    client->at.place = REQUEST_HERE;
    client->at.first = client->at.request.count;
    atomic_store_explicit(&w->long_states.phase, LONG_IDLE, memory_order_relaxed);
    return w->long_states.took_ns;
}

/* State by state, so that it ends soon when the worker stops: the request stays without a reply. */
static void solve_given(tfa_worker *w)
{
    worker_long_states *l = &w->long_states;
    worker_request *at = l->at;
    const uint64_t start = tfa_worker_clock();
    int status = TFA_OK;
    for (uint32_t k = 0; k < at->request.count && (k == 0 || tfa_wire_has_answers(status)); k++)
        if (!atomic_load_explicit(&w->stop, memory_order_acquire)) /* R11 */
            status = at->robot->solve(at->robot->long_self, &at->request, &at->reply, k, 1);
    at->reply.status = status;
    l->took_ns = tfa_worker_clock() - start;
    atomic_store_explicit(&l->phase, LONG_DONE, memory_order_release); /* A18 */
    tfa_worker_wake(w);
}

void tfa_worker_long_run(tfa_worker *w)
{
    worker_long_states *l = &w->long_states;
    for (;;) {
        while (sem_wait(&l->given) != 0)
            ;
        if (atomic_load_explicit(&l->phase, memory_order_acquire) != LONG_GIVEN) /* R17 */
            return;
        solve_given(w);
    }
}

void tfa_worker_long_stop(tfa_worker *w)
{
    (void)sem_post(&w->long_states.given);
}

void tfa_worker_long_settle(tfa_worker *w)
{
    while (phase_of(w) == LONG_GIVEN)
        tfa_worker_nap(SETTLE_NS);
}
