/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Leader election: takeovers and their times, partitions, epochs, other models and impossible
 * advertisements, a scenario each.
 */
#include "election_simulation.h"
#include "test.h"

/* Ticks without an answer after a fault of the leader. */
static int64_t measure_gap(const sim_variant *v, sim_fault kind, int moment)
{
    sim_world w = sim_begin(v);
    sim_settle(&w);
    sim_run(&w, moment);
    for (uint32_t i = 0; i < v->nodes; i++)
        if (sim_answers(&w, i)) {
            assert_true(sim_apply_fault(&w, i, kind));
            w.nodes[i].disturbed = true;
            break;
        }
    const int64_t begin_of_gap = w.now;
    while (sim_count_answering(&w) == 0 || (kind == FAULT_HANG && w.now == begin_of_gap))
        sim_step(&w);
    return w.now - begin_of_gap;
}

TEST(a_standby_takes_over_within_the_lease)
{
    for (uint32_t nodes = 2; nodes <= 3; nodes++)
        for (int moment = 0; moment < SIM_LEASE; moment++)
            for (int64_t delay = 0; delay <= SIM_DELAY_MAX; delay++) {
                const sim_variant v = {.nodes = nodes, .priority = {3, 2, 1}, .delay = delay};
                assert_true(measure_gap(&v, FAULT_KILL, moment) <= SIM_LEASE + 2 + delay);
                assert_true(measure_gap(&v, FAULT_STOP, moment) <= SIM_LEASE + 2 + delay);
                assert_true(measure_gap(&v, FAULT_LEAVE, moment) <= 1 + delay);
            }
}

/* A leader without progress gives up, once somebody else is there; alone it goes on. */
TEST(a_leader_without_progress_gives_up)
{
    const sim_variant pair = {.nodes = 2, .priority = {2, 1}}, single = {.nodes = 1};
    sim_world w = sim_begin(&pair);
    sim_settle(&w);
    assert_true(sim_answers(&w, 0));
    assert_true(sim_apply_fault(&w, 0, FAULT_HANG));
    sim_run(&w, SIM_LEASE + 3);
    assert_false(sim_answers(&w, 0));
    assert_true(sim_answers(&w, 1));
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
    assert_true(sim_apply_fault(&w, 0, FAULT_HANG));
    sim_run(&w, 5 * SIM_LEASE);
    assert_true(sim_answers(&w, 1)); /* no preemption */
    w = sim_begin(&single);
    sim_settle(&w);
    assert_true(sim_apply_fault(&w, 0, FAULT_HANG));
    sim_run(&w, 5 * SIM_LEASE);
    assert_true(sim_answers(&w, 0));
}

/* Each side of a partition has a leader; afterwards the one of the higher epoch stays. */
TEST(a_partition_heals)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}};
    sim_world w = sim_begin(&v);
    sim_settle(&w);
    for (int both = 0; both < 2; both++)
        for (uint32_t i = 0; i < 2; i++)
            sim_apply_fault(&w, i, FAULT_CUT);
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].deaf = true;
    sim_run(&w, 3 * SIM_LEASE);
    assert_true(sim_answers(&w, 0) && sim_answers(&w, 1));
    assert_int_equal(w.nodes[0].e.self.epoch, 1);
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].deaf = false;
    sim_run(&w, SIM_LEASE);
    assert_int_equal(w.nodes[0].e.self.role, TFA_ROLE_STANDBY);
    assert_true(sim_answers(&w, 1));
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
}

/* Nobody else leads in between. */
TEST(the_best_standby_takes_over)
{
    const sim_variant v = {.nodes = 3, .priority = {3, 1, 2}};
    sim_world w = sim_begin(&v);
    uint64_t takeovers = 0;
    sim_settle(&w);
    assert_true(sim_answers(&w, 0));
    w.takeovers = &takeovers;
    assert_true(sim_apply_fault(&w, 0, FAULT_KILL));
    sim_run(&w, 2 * SIM_LEASE);
    assert_true(sim_answers(&w, 2));
    assert_int_equal(w.nodes[2].e.self.epoch, 2);
    assert_int_equal(takeovers, 1);
}

/* Both sides of a partition began by themselves: their epochs are equal, and then are not. */
TEST(equal_epochs_are_told_apart)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}, .delay = 1};
    sim_world w = sim_begin(&v);
    w.nodes[0].deaf = w.nodes[1].deaf = w.parted = true;
    sim_run(&w, 3 * SIM_LEASE);
    assert_true(sim_answers(&w, 0) && sim_answers(&w, 1));
    w.nodes[0].deaf = w.nodes[1].deaf = false;
    sim_run(&w, SIM_LEASE);
    assert_true(sim_answers(&w, 0));
    assert_int_equal(w.nodes[0].e.self.epoch, 2);
}

/* All daemons were restarted: the next leader's epoch is higher than that of any before, because
 * its first one comes from a clock; and daemons that join do not raise it. */
TEST(epochs_survive_a_restart)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}, .clock = true};
    sim_world w = sim_begin(&v);
    uint64_t last = 0;
    for (int i = 0; i < 3; i++) {
        sim_settle(&w);
        for (int k = 0; k < 4; k++) { /* takeovers */
            const uint32_t leader = sim_answers(&w, 1);
            const uint64_t epoch = w.nodes[leader].e.self.epoch;
            assert_true(epoch > last);
            last = epoch;
            assert_true(sim_apply_fault(&w, leader, FAULT_KILL));
            sim_run(&w, 2 * SIM_LEASE);
            assert_true(sim_apply_fault(&w, leader, FAULT_KILL));
            sim_run(&w, 3 * SIM_LEASE);
            assert_true(sim_answers(&w, !leader));
            assert_true(w.nodes[!leader].e.self.epoch > last);
        }
        last = w.nodes[sim_answers(&w, 1)].e.self.epoch;
        for (uint32_t k = 0; k < 2; k++)
            assert_true(sim_apply_fault(&w, k, FAULT_KILL));
        sim_run(&w, SIM_LEASE);
        for (uint32_t k = 0; k < 2; k++)
            assert_true(sim_apply_fault(&w, k, FAULT_KILL));
    }
}

/* Two daemons are stopped in turn, each before it hears that the other leads: clients have seen the
 * epochs of both. */
TEST(epochs_grow_over_leaders_that_were_not_seen)
{
    const int64_t second = 1000000000;
    const tfa_advertisement one = {.daemon = {1}, .lease = second, .epoch = 1000000},
                            two = {.daemon = {2}, .lease = second, .epoch = 1005000};
    tfa_election a, b;
    tfa_election_begin(&a, &one, 0);
    (void)tfa_election_tick(&a, true, second);
    assert_int_equal(a.self.role, TFA_ROLE_LEADING);
    tfa_election_begin(&b, &two, 5 * second);
    (void)tfa_election_hear(&b, &a.self, 5 * second);
    (void)tfa_election_hear(&a, &b.self, 5 * second);
    for (int64_t now = 5 * second; now <= 7 * second; now += second / 10)
        (void)tfa_election_tick(&b, true, now);
    assert_int_equal(b.self.role, TFA_ROLE_LEADING);
    for (int64_t now = 20 * second; now <= 22 * second; now += second / 10)
        (void)tfa_election_tick(&a, true, now);
    assert_int_equal(a.self.role, TFA_ROLE_LEADING);
    assert_true(a.self.epoch > b.self.epoch);
}

TEST(another_model_does_not_follow)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}};
    const uint8_t other[32] = {1}, same[32] = {0};
    sim_world w = sim_begin(&v);
    sim_settle(&w);
    assert_true(tfa_election_set_model(&w.nodes[1].e, other, w.now));
    assert_int_equal(w.nodes[1].e.self.role, TFA_ROLE_UNLIKE);
    sim_world later = w;
    assert_true(sim_apply_fault(&w, 0, FAULT_KILL));
    sim_run(&w, 5 * SIM_LEASE);
    assert_int_equal(sim_count_answering(&w), 0);
    assert_true(tfa_election_set_model(&w.nodes[1].e, same, w.now));
    sim_run(&w, SIM_LEASE);
    assert_true(sim_answers(&w, 1));
    /* The leader gets that model, too. */
    assert_true(tfa_election_set_model(&later.nodes[0].e, other, later.now));
    sim_run(&later, SIM_LEASE);
    assert_int_equal(later.nodes[1].e.self.role, TFA_ROLE_STANDBY);
}

/* A leader with another model comes and is gone: the daemon that it superseded leads again; one
 * that starts does not before it is loaded again. */
TEST(a_superseded_leader_leads_again)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    const tfa_advertisement other = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = 1000, .model = {1}};
    for (int led = 0; led < 2; led++) {
        tfa_election e;
        tfa_election_begin(&e, &self, 0);
        (void)tfa_election_tick(&e, true, led ? 1000 : 500);
        assert_int_equal(e.self.role, led ? TFA_ROLE_LEADING : TFA_ROLE_LISTENING);
        for (int64_t now = 1001; now <= 2001; now += 100) /* again and again */
            (void)tfa_election_hear(&e, &other, now);
        assert_int_equal(e.self.role, TFA_ROLE_UNLIKE);
        for (int64_t now = 2002; now <= 3002; now += 100)
            (void)tfa_election_tick(&e, true, now);
        assert_int_equal(e.self.role, led ? TFA_ROLE_LEADING : TFA_ROLE_UNLIKE);
        assert_true(tfa_election_set_model(&e, self.model, 3003));
        (void)tfa_election_tick(&e, true, 3004);
        assert_true(tfa_election_may_answer(&e, 3004));
        assert_int_equal(e.self.epoch, 6);
    }
}

/* A leader that was stopped in a reload: another leads when the new model comes. */
TEST(a_model_does_not_renew_a_lease)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}};
    const uint8_t other[32] = {1};
    sim_world w = sim_begin(&v);
    sim_settle(&w);
    assert_true(sim_apply_fault(&w, 0, FAULT_STOP));
    sim_run(&w, 2 * SIM_LEASE);
    assert_true(sim_answers(&w, 1));
    assert_true(tfa_election_set_model(&w.nodes[0].e, other, w.now));
    assert_false(tfa_election_may_answer(&w.nodes[0].e, w.now));
    assert_int_equal(w.nodes[0].e.self.role, TFA_ROLE_LISTENING);
}

TEST(a_daemon_that_starts_is_silent_for_a_lease)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    tfa_election e;
    tfa_election_begin(&e, &self, 0);
    for (int64_t now = 0; now < 1000; now += 100)
        (void)tfa_election_tick(&e, true, now);
    assert_int_equal(e.self.role, TFA_ROLE_LISTENING);
    assert_true(tfa_election_next(&e) == 1000);
    assert_true(tfa_election_tick(&e, true, 1000));
    assert_true(tfa_election_may_answer(&e, 1000));
}

TEST(a_good_bye_needs_no_lease)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    const tfa_advertisement other = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = 1000};
    tfa_election e;
    tfa_election_begin(&e, &self, 0);
    assert_true(tfa_election_tick(&e, true, 200));
    assert_true(tfa_election_hear(&e, &other, 201));
    assert_int_equal(e.self.role, TFA_ROLE_STANDBY);
    assert_true(tfa_election_leave(&e, other.daemon, 202));
    assert_true(tfa_election_may_answer(&e, 202));
    assert_int_equal(e.self.epoch, 6);
}

/* A lease of an hour from a daemon that is silent: it counts for five of the own leases. */
TEST(a_long_lease_is_capped)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    const tfa_advertisement other = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = INT64_C(3600000000000)};
    tfa_election e;
    tfa_election_begin(&e, &self, 0);
    (void)tfa_election_hear(&e, &other, 0);
    for (int64_t now = 100; now <= 5000; now += 100)
        (void)tfa_election_tick(&e, true, now);
    assert_int_equal(e.self.role, TFA_ROLE_STANDBY);
    assert_true(tfa_election_next(&e) == 5001);
    assert_true(tfa_election_tick(&e, true, 5001));
    assert_true(tfa_election_may_answer(&e, 5001));
    assert_int_equal(e.self.epoch, 6);
}

/* The writer of a leader is gone: two beats, and another daemon leads; a leader whose writer is
 * back within them goes on. */
TEST(a_leader_without_a_writer_is_forgotten)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    const tfa_advertisement other = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = 4000};
    for (int back = 0; back < 2; back++) {
        tfa_election e;
        tfa_election_begin(&e, &self, 0);
        (void)tfa_election_hear(&e, &other, 0);
        tfa_election_lose(&e, other.daemon, 100);
        (void)tfa_election_tick(&e, true, 400);
        assert_int_equal(e.self.role, TFA_ROLE_STANDBY);
        if (back)
            (void)tfa_election_hear(&e, &other, 450);
        (void)tfa_election_tick(&e, true, 501);
        assert_int_equal(e.self.role, back ? TFA_ROLE_STANDBY : TFA_ROLE_LEADING);
    }
}

TEST(impossible_advertisements_are_ignored)
{
    tfa_advertisement self = {.daemon = {9}, .lease = SIM_LEASE};
    const tfa_advertisement good = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = SIM_LEASE};
    tfa_advertisement lies[] = {good, good, good, good, good};
    tfa_election e;
    lies[0].epoch = UINT64_MAX;
    lies[1].role = (tfa_role)77;
    lies[2].lease = 0;
    lies[3].lease = INT64_MAX;
    memcpy(lies[4].daemon, self.daemon, sizeof lies[4].daemon);
    tfa_election_begin(&e, &self, 0);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++)
        assert_false(tfa_election_hear(&e, &lies[i], 1));
    assert_int_equal(e.peer_count, 0);
    for (uint8_t i = 0; i < 2 * TFA_ELECTION_PEERS; i++) {
        tfa_advertisement one = good;
        one.daemon[1] = i;
        (void)tfa_election_hear(&e, &one, 1);
    }
    assert_int_equal(e.peer_count, TFA_ELECTION_PEERS);
    assert_int_equal(e.self.role, TFA_ROLE_STANDBY);
}

/* The next look at the clock lies in the future, always: nobody spins. */
TEST(time_moves_on)
{
    const sim_variant v = {.nodes = 2, .priority = {2, 1}};
    sim_world w = sim_begin(&v);
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].e.self.lease = 1000; /* parts of a tick are not rounded away */
    for (int t = 0; t < 10000; t++) {
        if (t == 4000)
            assert_true(sim_apply_fault(&w, 0, FAULT_HANG));
        sim_step(&w);
        for (uint32_t i = 0; i < 2; i++)
            assert_true(tfa_election_next(&w.nodes[i].e) > w.nodes[i].e.ran);
    }
}
