/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Admission by cost (max_state_us): before a state takes the worker's time.
 */
#include "worker/cost_bound.h"
#include "worker_internal.h"

/* With cost and limit, us */
static int refuse_by_cost(worker_request *at, uint64_t cost_ns)
{
    at->reply.field = TFA_FIELD_COST;
    at->reply.index = (uint32_t)(cost_ns / 1000 + 1);
    at->reply.state = at->robot->max_state_ns / 1000;
    return TFA_E_REFUSED;
}

/* Whether a state may take too long because those of this client took longer than their kinds */
static bool is_doubted(const tfa_worker *w, tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    return client->debt.owed_ns && tfa_cost_doubted(at->cost) > at->robot->max_state_ns &&
           tfa_cost_in_debt(&client->debt, w->now);
}

/* The bound takes longer than the rest: it is asked for kinds that are not in time only. */
int tfa_worker_admit_slowly(const tfa_worker *w, tfa_worker_client *client, bool in_time)
{
    worker_request *at = &client->at;
    const uint32_t most = at->robot->max_state_ns;
    if (in_time && !is_doubted(w, client))
        return TFA_OK;
    const uint32_t bound = tfa_cost_bound(at->robot->parts, &at->request);
    if (!at->cost->least_ns)
        at->cost->least_ns = bound;
    const bool admitted =
        at->cost->least_ns <= most || tfa_cost_admit_again(at->cost, bound, most, w->now);
    if (client->self_test || (admitted && !is_doubted(w, client)))
        return TFA_OK;
    if (at->robot->long_self && !client->direct) {
        at->place = REQUEST_WAITING;
        return TFA_OK;
    }
    return refuse_by_cost(at, admitted ? tfa_cost_doubted(at->cost) : at->cost->least_ns);
}

bool tfa_worker_cut_short(const tfa_worker *w, tfa_worker_client *client)
{
    worker_request *at = &client->at;
    if (!at->first || at->place != REQUEST_HERE || !at->robot->max_state_ns || client->self_test ||
        !is_doubted(w, client))
        return false;
    at->reply.status = refuse_by_cost(at, tfa_cost_doubted(at->cost));
    return true;
}
