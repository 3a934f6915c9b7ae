/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Daemons in simulated time: their messages, clocks and faults, and the laws of every moment.
 */
#include "election_simulation.h"

#include "test.h"

static void start_node(sim_world *w, uint32_t i)
{
    sim_node *n = &w->nodes[i];
    tfa_advertisement self = {.priority = w->v->priority[i], .lease = SIM_LEASE};
    if (w->v->clock)
        self.epoch = (uint64_t)w->now;
    self.daemon[0] = ++w->next_guid;
    *n = (sim_node){.alive = true};
    tfa_election_begin(&n->e, &self, w->now);
}

static void post(sim_world *w, uint32_t from, bool good_bye)
{
    const sim_message m = {good_bye, w->now + w->v->delay, w->nodes[from].e.self};
    if (w->nodes[from].mute)
        return;
    for (uint32_t i = 0; i < w->v->nodes; i++) {
        sim_node *to = &w->nodes[i];
        if (i == from || !to->alive || to->deaf)
            continue;
        if (to->inbox_count == SIM_INBOX) /* a socket's buffer: the newest are lost */
            continue;
        to->inbox[to->inbox_count++] = m;
    }
}

static void read_inbox(sim_world *w, uint32_t i)
{
    sim_node *n = &w->nodes[i];
    uint32_t left = 0;
    for (uint32_t k = 0; k < n->inbox_count; k++) {
        const sim_message m = n->inbox[k];
        if (m.arrives > w->now)
            n->inbox[left++] = m;
        else if (m.good_bye ? tfa_election_leave(&n->e, m.said.daemon, w->now)
                            : tfa_election_hear(&n->e, &m.said, w->now))
            post(w, i, false);
    }
    n->inbox_count = left;
}

static void tick(sim_world *w, uint32_t i)
{
    sim_node *n = &w->nodes[i];
    if (w->now >= tfa_election_next(&n->e) && tfa_election_tick(&n->e, !n->hung, w->now))
        post(w, i, false);
}

static void run_node(sim_world *w, uint32_t i)
{
    sim_node *n = &w->nodes[i];
    if (!n->alive || n->stopped)
        return;
    const bool led = n->e.self.role == TFA_ROLE_LEADING;
    if (w->v->ticks_first)
        tick(w, i);
    read_inbox(w, i);
    if (!w->v->ticks_first)
        tick(w, i);
    const bool leads = n->e.self.role == TFA_ROLE_LEADING;
    if (w->takeovers)
        *w->takeovers += leads && !led;
    /* No preemption: nothing happened to it, and it leads on. */
    if (led && !leads && !w->parted && w->now - n->leads_since > 1 + w->v->delay)
        assert_true(n->disturbed);
    if (leads && !led) {
        n->leads_since = w->now;
        n->disturbed = n->hung;
    }
}

/* ---- laws that hold at every moment ---- */

bool sim_answers(const sim_world *w, uint32_t i)
{
    const sim_node *n = &w->nodes[i];
    return n->alive && !n->stopped && tfa_election_may_answer(&n->e, w->now);
}

uint32_t sim_count_answering(const sim_world *w)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < w->v->nodes; i++)
        count += sim_answers(w, i);
    return count;
}

/* Without a partition at most one daemon answers, however often they are stopped, but for the time
 * that a message takes. One without peers is not fenced: it has not heard of another yet. */
static void check_safety(sim_world *w)
{
    uint32_t answering = 0;
    for (uint32_t i = 0; i < w->v->nodes; i++)
        answering += sim_answers(w, i) && w->nodes[i].e.peer_count > 0;
    if (answering <= 1 || w->parted)
        w->single = w->now;
    assert_true(w->now - w->single <= 1 + w->v->delay);
}

void sim_step(sim_world *w)
{
    w->now++;
    for (uint32_t k = 0; k < w->v->nodes; k++)
        run_node(w, w->v->backwards ? w->v->nodes - 1 - k : k);
    check_safety(w);
}

/* A leader that continues after a takeover does not answer, before it has heard a word. */
static void check_fence(const sim_world *w, uint32_t i)
{
    if (w->parted || w->nodes[i].e.peer_count == 0)
        return;
    for (uint32_t k = 0; k < w->v->nodes; k++)
        assert_false(k != i && sim_answers(w, k) && sim_answers(w, i));
}

/* ---- faults ---- */

bool sim_apply_fault(sim_world *w, uint32_t i, sim_fault kind)
{
    sim_node *n = &w->nodes[i];
    if (!n->alive) {
        if (kind != FAULT_KILL)
            return false;
        start_node(w, i);
        return true;
    }
    n->disturbed = true;
    switch (kind) {
    case FAULT_KILL:
        n->alive = false;
        return true;
    case FAULT_STOP:
        n->stopped = !n->stopped;
        if (!n->stopped)
            check_fence(w, i);
        return true;
    case FAULT_HANG:
        n->hung = !n->hung;
        return true;
    case FAULT_LEAVE:
        if (n->stopped)
            return false;
        post(w, i, true);
        n->alive = false;
        return true;
    case FAULT_CUT:
        n->deaf = !n->deaf;
        w->parted = true;
        return true;
    case FAULT_MUTE:
        n->mute = !n->mute;
        w->parted = true;
        return true;
    default:
        return false;
    }
}

sim_world sim_begin(const sim_variant *v)
{
    sim_world w = {.v = v, .now = 1000, .single = 1000};
    for (uint32_t i = 0; i < v->nodes; i++)
        start_node(&w, i);
    return w;
}

void sim_run(sim_world *w, int ticks)
{
    for (int t = 0; t < ticks; t++)
        sim_step(w);
}

void sim_settle(sim_world *w)
{
    sim_run(w, 3 * SIM_LEASE);
    assert_int_equal(sim_count_answering(w), 1);
}
