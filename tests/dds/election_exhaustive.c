/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Leader election, all orders of events: two and three daemons, every sequence of a few faults at
 * every moment, with several delays and orders of delivery.
 */
#include "election_simulation.h"
#include "test.h"

static uint64_t runs, takeovers; /* of a test */

/* Faults are over: one leads, the others follow it, and know its epoch. */
static void check_agreement(sim_world *w)
{
    const tfa_election *leader = NULL;
    uint32_t alive = 0;
    for (uint32_t i = 0; i < w->v->nodes; i++) {
        sim_node *n = &w->nodes[i];
        n->stopped = n->hung = n->deaf = n->mute = false;
        alive += n->alive;
    }
    w->parted = true; /* two leaders may be there now */
    sim_run(w, 4 * SIM_LEASE);
    for (uint32_t i = 0; i < w->v->nodes; i++)
        if (sim_answers(w, i)) {
            assert_null(leader);
            leader = &w->nodes[i].e;
        }
    assert_true((leader != NULL) == (alive > 0));
    for (uint32_t i = 0; i < w->v->nodes; i++) {
        const sim_node *n = &w->nodes[i];
        if (!n->alive || &n->e == leader)
            continue;
        assert_int_equal(n->e.self.role, TFA_ROLE_STANDBY);
        assert_true(n->e.self.epoch == leader->self.epoch);
    }
    runs++;
}

/* Every sequence of `faults` faults, each at every moment of the next `window` ticks. */
static void explore(const sim_world *from, uint32_t faults, int window)
{
    sim_world w = *from;
    if (faults == 0) {
        check_agreement(&w);
        return;
    }
    for (int t = 0; t < window; t++) {
        for (uint32_t i = 0; i < w.v->nodes; i++)
            for (sim_fault kind = 0; kind < FAULT_KINDS; kind++) {
                sim_world next = w;
                if (sim_apply_fault(&next, i, kind))
                    explore(&next, faults - 1, window);
            }
        sim_step(&w);
    }
}

static void explore_variants(uint32_t nodes, uint32_t faults, int window)
{
    runs = takeovers = 0;
    for (int64_t delay = 0; delay <= SIM_DELAY_MAX; delay++)
        for (int bits = 0; bits < 4; bits++) {
            const sim_variant v = {.nodes = nodes,
                                   .priority = {1, bits & 1 ? 1 : 2, 1},
                                   .delay = delay,
                                   .backwards = bits & 1,
                                   .ticks_first = bits & 2,
                                   .clock = bits & 2};
            sim_world w = sim_begin(&v);
            w.takeovers = &takeovers;
            sim_settle(&w);
            explore(&w, faults, window);
        }
    print_message("%u daemons, %u faults: %llu runs, %llu takeovers\n", nodes, faults,
                  (unsigned long long)runs, (unsigned long long)takeovers);
    assert_true(takeovers > runs / 10); /* faults did something */
}

/* From the very start: nobody has led yet. */
TEST(daemons_that_start)
{
    for (int bits = 0; bits < 4; bits++) {
        const sim_variant v = {.nodes = 3,
                               .priority = {1, 2, 2},
                               .delay = 1,
                               .backwards = bits & 1,
                               .ticks_first = bits & 2};
        const sim_world w = sim_begin(&v);
        explore(&w, 2, 2 * SIM_LEASE);
        sim_world calm = w;
        sim_settle(&calm);
        assert_true(sim_answers(&calm, 1)); /* priority 2, the smaller GUID */
    }
}

TEST(two_daemons)
{
    explore_variants(2, 3, SIM_LEASE + 2);
}

TEST(three_daemons)
{
    explore_variants(3, 2, SIM_LEASE + 4);
}
