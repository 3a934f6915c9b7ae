/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Leader election, all orders of events: two and three daemons in simulated time, every sequence of
 * a few faults at every moment, with several delays and orders of delivery.
 */
#include "dds_gateway/election.h"
#include "test.h"

#include <string.h>

#define LEASE 5 /* ticks: one beat each */
#define NODES 3
#define DELAY_MAX 1
#define INBOX 64

typedef enum fault {
    FAULT_KILL,  /* gone without a word, and back with another GUID */
    FAULT_STOP,  /* SIGSTOP; the second one continues it */
    FAULT_HANG,  /* no progress; the second one ends it */
    FAULT_LEAVE, /* stopped cleanly, and back with another GUID */
    FAULT_CUT,   /* nothing reaches it; the second one heals it */
    FAULT_MUTE,  /* nothing that it says arrives; the second one heals it */
    FAULT_KINDS
} fault;

typedef struct message {
    bool good_bye;
    int64_t arrives;
    tfa_advertisement said;
} message;

typedef struct node {
    tfa_election e;
    bool alive, stopped, hung, deaf, mute;
    bool disturbed; /* since it led last: stopped, hung or cut off */
    int64_t leads_since;
    uint32_t inbox_count;
    message inbox[INBOX];
} node;

/* What differs between runs besides the faults. */
typedef struct variant {
    uint32_t nodes;
    uint32_t priority[NODES];
    int64_t delay;
    bool backwards;   /* the order in which daemons run */
    bool ticks_first; /* a daemon looks at the clock before it reads */
    bool clock;       /* the first epoch is the time of the start */
} variant;

typedef struct world {
    const variant *v;
    int64_t now;
    uint8_t next_guid;
    bool parted;    /* a network fault has been */
    int64_t single; /* last time at which at most one answered */
    node nodes[NODES];
} world;

static uint64_t runs, takeovers;

/* ---- the world ---- */

static void start_node(world *w, uint32_t i)
{
    node *n = &w->nodes[i];
    tfa_advertisement self = {.priority = w->v->priority[i], .lease = LEASE};

    if (w->v->clock)
        self.epoch = (uint64_t)w->now;

    self.daemon[0] = ++w->next_guid;
    *n = (node){.alive = true};
    tfa_election_begin(&n->e, &self, w->now);
}

static void post(world *w, uint32_t from, bool good_bye)
{
    const message m = {good_bye, w->now + w->v->delay, w->nodes[from].e.self};

    if (w->nodes[from].mute)
        return;
    for (uint32_t i = 0; i < w->v->nodes; i++) {
        node *to = &w->nodes[i];
        if (i == from || !to->alive || to->deaf)
            continue;
        if (to->inbox_count == INBOX) /* a socket's buffer: the newest are lost */
            continue;
        to->inbox[to->inbox_count++] = m;
    }
}

static void read_inbox(world *w, uint32_t i)
{
    node *n = &w->nodes[i];
    uint32_t left = 0;

    for (uint32_t k = 0; k < n->inbox_count; k++) {
        const message m = n->inbox[k];
        if (m.arrives > w->now)
            n->inbox[left++] = m;
        else if (m.good_bye ? tfa_election_leave(&n->e, m.said.daemon, w->now)
                            : tfa_election_hear(&n->e, &m.said, w->now))
            post(w, i, false);
    }
    n->inbox_count = left;
}

static void tick(world *w, uint32_t i)
{
    node *n = &w->nodes[i];

    if (w->now >= tfa_election_next(&n->e) && tfa_election_tick(&n->e, !n->hung, w->now))
        post(w, i, false);
}

static void run_node(world *w, uint32_t i)
{
    node *n = &w->nodes[i];

    if (!n->alive || n->stopped)
        return;
    const bool led = n->e.self.role == TFA_ROLE_LEADING;
    if (w->v->ticks_first)
        tick(w, i);
    read_inbox(w, i);
    if (!w->v->ticks_first)
        tick(w, i);
    const bool leads = n->e.self.role == TFA_ROLE_LEADING;
    takeovers += leads && !led;
    /* No preemption: nothing happened to it, and it leads on. */
    if (led && !leads && !w->parted && w->now - n->leads_since > 1 + w->v->delay)
        assert_true(n->disturbed);
    if (leads && !led) {
        n->leads_since = w->now;
        n->disturbed = n->hung;
    }
}

/* ---- laws that hold at every moment ---- */

static bool answers(const world *w, uint32_t i)
{
    const node *n = &w->nodes[i];

    return n->alive && !n->stopped && tfa_election_may_answer(&n->e, w->now);
}

static uint32_t count_answering(const world *w)
{
    uint32_t count = 0;

    for (uint32_t i = 0; i < w->v->nodes; i++)
        count += answers(w, i);
    return count;
}

/* Without a partition at most one daemon answers, however often they are stopped, but for the time
 * that a message takes. One without peers is not fenced: it has not heard of another yet. */
static void check_safety(world *w)
{
    uint32_t answering = 0;

    for (uint32_t i = 0; i < w->v->nodes; i++)
        answering += answers(w, i) && w->nodes[i].e.peer_count > 0;
    if (answering <= 1 || w->parted)
        w->single = w->now;
    assert_true(w->now - w->single <= 1 + w->v->delay);
}

static void step(world *w)
{
    w->now++;
    for (uint32_t k = 0; k < w->v->nodes; k++)
        run_node(w, w->v->backwards ? w->v->nodes - 1 - k : k);
    check_safety(w);
}

/* A leader that continues after a takeover does not answer, before it has heard a word. */
static void check_fence(const world *w, uint32_t i)
{
    if (w->parted || w->nodes[i].e.peer_count == 0)
        return;
    for (uint32_t k = 0; k < w->v->nodes; k++)
        assert_false(k != i && answers(w, k) && answers(w, i));
}

/* ---- faults ---- */

static bool apply_fault(world *w, uint32_t i, fault kind)
{
    node *n = &w->nodes[i];

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

/* ---- laws at the end ---- */

/* Faults are over: one leads, the others follow it, and know its epoch. */
static void check_agreement(world *w)
{
    const tfa_election *leader = NULL;
    uint32_t alive = 0;

    for (uint32_t i = 0; i < w->v->nodes; i++) {
        node *n = &w->nodes[i];
        n->stopped = n->hung = n->deaf = n->mute = false;
        alive += n->alive;
    }
    w->parted = true; /* two leaders may be there now */
    for (int t = 0; t < 4 * LEASE; t++)
        step(w);
    for (uint32_t i = 0; i < w->v->nodes; i++)
        if (answers(w, i)) {
            assert_null(leader);
            leader = &w->nodes[i].e;
        }
    assert_true((leader != NULL) == (alive > 0));
    for (uint32_t i = 0; i < w->v->nodes; i++) {
        const node *n = &w->nodes[i];
        if (!n->alive || &n->e == leader)
            continue;
        assert_int_equal(n->e.self.role, TFA_ROLE_STANDBY);
        assert_true(n->e.self.epoch == leader->self.epoch);
    }
    runs++;
}

/* Every sequence of `faults` faults, each at every moment of the next `window` ticks. */
static void explore(const world *from, uint32_t faults, int window)
{
    world w = *from;

    if (faults == 0) {
        check_agreement(&w);
        return;
    }
    for (int t = 0; t < window; t++) {
        for (uint32_t i = 0; i < w.v->nodes; i++)
            for (fault kind = 0; kind < FAULT_KINDS; kind++) {
                world next = w;
                if (apply_fault(&next, i, kind))
                    explore(&next, faults - 1, window);
            }
        step(&w);
    }
}

static world begin(const variant *v)
{
    world w = {.v = v, .now = 1000, .single = 1000};

    for (uint32_t i = 0; i < v->nodes; i++)
        start_node(&w, i);
    return w;
}

static void settle(world *w)
{
    for (int t = 0; t < 3 * LEASE; t++)
        step(w);
    assert_int_equal(count_answering(w), 1);
}

static void explore_variants(uint32_t nodes, uint32_t faults, int window)
{
    for (int64_t delay = 0; delay <= DELAY_MAX; delay++)
        for (int bits = 0; bits < 4; bits++) {
            const variant v = {.nodes = nodes,
                               .priority = {1, bits & 1 ? 1 : 2, 1},
                               .delay = delay,
                               .backwards = bits & 1,
                               .ticks_first = bits & 2,
                               .clock = bits & 2};
            world w = begin(&v);
            settle(&w);
            explore(&w, faults, window);
        }
    print_message("%u daemons, %u faults: %llu runs, %llu takeovers\n", nodes, faults,
                  (unsigned long long)runs, (unsigned long long)takeovers);
    assert_true(takeovers > runs / 10); /* faults did something */
    runs = takeovers = 0;
}

static void two_daemons(void **state)
{
    (void)state;
    explore_variants(2, 3, LEASE + 2);
}

static void three_daemons(void **state)
{
    (void)state;
    explore_variants(3, 2, LEASE + 4);
}

/* From the very start: nobody has led yet. */
static void daemons_that_start(void **state)
{
    (void)state;
    for (int bits = 0; bits < 4; bits++) {
        const variant v = {.nodes = 3,
                           .priority = {1, 2, 2},
                           .delay = 1,
                           .backwards = bits & 1,
                           .ticks_first = bits & 2};
        const world w = begin(&v);
        explore(&w, 2, 2 * LEASE);
        world calm = w;
        settle(&calm);
        assert_true(answers(&calm, 1)); /* priority 2, the smaller GUID */
    }
}

/* ---- times ---- */

/* How long nobody answers after a fault of the leader. */
static int64_t measure_gap(const variant *v, fault kind, int moment)
{
    world w = begin(v);

    settle(&w);
    for (int t = 0; t < moment; t++)
        step(&w);
    for (uint32_t i = 0; i < v->nodes; i++)
        if (answers(&w, i)) {
            assert_true(apply_fault(&w, i, kind));
            w.nodes[i].disturbed = true;
            break;
        }
    const int64_t begin_of_gap = w.now;
    while (count_answering(&w) == 0 || (kind == FAULT_HANG && w.now == begin_of_gap))
        step(&w);
    return w.now - begin_of_gap;
}

static void a_standby_takes_over_within_the_lease(void **state)
{
    (void)state;
    for (uint32_t nodes = 2; nodes <= 3; nodes++)
        for (int moment = 0; moment < LEASE; moment++)
            for (int64_t delay = 0; delay <= DELAY_MAX; delay++) {
                const variant v = {.nodes = nodes, .priority = {3, 2, 1}, .delay = delay};
                assert_true(measure_gap(&v, FAULT_KILL, moment) <= LEASE + 2 + delay);
                assert_true(measure_gap(&v, FAULT_STOP, moment) <= LEASE + 2 + delay);
                assert_true(measure_gap(&v, FAULT_LEAVE, moment) <= 1 + delay);
            }
}

/* A leader without progress gives up, once somebody else is there; alone it goes on. */
static void a_leader_without_progress_gives_up(void **state)
{
    const variant pair = {.nodes = 2, .priority = {2, 1}}, single = {.nodes = 1};
    world w = begin(&pair);

    (void)state;
    settle(&w);
    assert_true(answers(&w, 0));
    assert_true(apply_fault(&w, 0, FAULT_HANG));
    for (int t = 0; t < LEASE + 3; t++)
        step(&w);
    assert_false(answers(&w, 0));
    assert_true(answers(&w, 1));
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
    assert_true(apply_fault(&w, 0, FAULT_HANG));
    for (int t = 0; t < 5 * LEASE; t++)
        step(&w);
    assert_true(answers(&w, 1)); /* no preemption */

    w = begin(&single);
    settle(&w);
    assert_true(apply_fault(&w, 0, FAULT_HANG));
    for (int t = 0; t < 5 * LEASE; t++)
        step(&w);
    assert_true(answers(&w, 0));
}

/* Each side of a partition has a leader; afterwards the one of the higher epoch stays. */
static void a_partition_heals(void **state)
{
    const variant v = {.nodes = 2, .priority = {2, 1}};
    world w = begin(&v);

    (void)state;
    settle(&w);
    for (int both = 0; both < 2; both++)
        for (uint32_t i = 0; i < 2; i++)
            apply_fault(&w, i, FAULT_CUT);
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].deaf = true;
    for (int t = 0; t < 3 * LEASE; t++)
        step(&w);
    assert_true(answers(&w, 0) && answers(&w, 1));
    assert_int_equal(w.nodes[0].e.self.epoch, 1);
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].deaf = false;
    for (int t = 0; t < LEASE; t++)
        step(&w);
    assert_int_equal(w.nodes[0].e.self.role, TFA_ROLE_STANDBY);
    assert_true(answers(&w, 1));
    assert_int_equal(w.nodes[1].e.self.epoch, 2);
}

static void run(world *w, int ticks)
{
    for (int t = 0; t < ticks; t++)
        step(w);
}

/* Nobody else leads in between. */
static void the_best_standby_takes_over(void **state)
{
    const variant v = {.nodes = 3, .priority = {3, 1, 2}};
    world w = begin(&v);

    (void)state;
    settle(&w);
    assert_true(answers(&w, 0));
    takeovers = 0;
    assert_true(apply_fault(&w, 0, FAULT_KILL));
    run(&w, 2 * LEASE);
    assert_true(answers(&w, 2));
    assert_int_equal(w.nodes[2].e.self.epoch, 2);
    assert_int_equal(takeovers, 1);
}

/* Both sides of a partition began by themselves: their epochs are equal, and then are not. */
static void equal_epochs_are_told_apart(void **state)
{
    const variant v = {.nodes = 2, .priority = {2, 1}, .delay = 1};
    world w = begin(&v);

    (void)state;
    w.nodes[0].deaf = w.nodes[1].deaf = w.parted = true;
    run(&w, 3 * LEASE);
    assert_true(answers(&w, 0) && answers(&w, 1));
    w.nodes[0].deaf = w.nodes[1].deaf = false;
    run(&w, LEASE);
    assert_true(answers(&w, 0));
    assert_int_equal(w.nodes[0].e.self.epoch, 2);
}

/* All daemons were restarted: the next leader's epoch is higher than that of any before, because
 * its first one comes from a clock; and daemons that join do not raise it. */
static void epochs_survive_a_restart(void **state)
{
    const variant v = {.nodes = 2, .priority = {2, 1}, .clock = true};
    world w = begin(&v);
    uint64_t last = 0;

    (void)state;
    for (int i = 0; i < 3; i++) {
        settle(&w);
        for (int k = 0; k < 4; k++) { /* takeovers */
            const uint32_t leader = answers(&w, 1);
            const uint64_t epoch = w.nodes[leader].e.self.epoch;
            assert_true(epoch > last);
            last = epoch;
            assert_true(apply_fault(&w, leader, FAULT_KILL));
            run(&w, 2 * LEASE);
            assert_true(apply_fault(&w, leader, FAULT_KILL));
            run(&w, 3 * LEASE);
            assert_true(answers(&w, !leader));
            assert_true(w.nodes[!leader].e.self.epoch > last);
        }
        last = w.nodes[answers(&w, 1)].e.self.epoch;
        for (uint32_t k = 0; k < 2; k++)
            assert_true(apply_fault(&w, k, FAULT_KILL));
        run(&w, LEASE);
        for (uint32_t k = 0; k < 2; k++)
            assert_true(apply_fault(&w, k, FAULT_KILL));
    }
}

static void a_good_bye_needs_no_lease(void **state)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    const tfa_advertisement other = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = 1000};
    tfa_election e;

    (void)state;
    tfa_election_begin(&e, &self, 0);
    assert_true(tfa_election_tick(&e, true, 200));
    assert_true(tfa_election_hear(&e, &other, 201));
    assert_int_equal(e.self.role, TFA_ROLE_STANDBY);
    assert_true(tfa_election_leave(&e, other.daemon, 202));
    assert_true(tfa_election_may_answer(&e, 202));
    assert_int_equal(e.self.epoch, 6);
}

static void a_daemon_that_starts_is_silent_for_a_lease(void **state)
{
    const tfa_advertisement self = {.daemon = {9}, .lease = 1000};
    tfa_election e;

    (void)state;
    tfa_election_begin(&e, &self, 0);
    for (int64_t now = 0; now < 1000; now += 100)
        (void)tfa_election_tick(&e, true, now);
    assert_int_equal(e.self.role, TFA_ROLE_LISTENING);
    assert_true(tfa_election_next(&e) == 1000);
    assert_true(tfa_election_tick(&e, true, 1000));
    assert_true(tfa_election_may_answer(&e, 1000));
}

/* ---- models and lies ---- */

static void another_model_does_not_follow(void **state)
{
    const variant v = {.nodes = 2, .priority = {2, 1}};
    const uint8_t other[32] = {1}, same[32] = {0};
    world w = begin(&v);

    (void)state;
    settle(&w);
    assert_true(tfa_election_set_model(&w.nodes[1].e, other, w.now));
    assert_int_equal(w.nodes[1].e.self.role, TFA_ROLE_UNLIKE);
    world later = w;
    assert_true(apply_fault(&w, 0, FAULT_KILL));
    for (int t = 0; t < 5 * LEASE; t++)
        step(&w);
    assert_int_equal(count_answering(&w), 0);
    assert_true(tfa_election_set_model(&w.nodes[1].e, same, w.now));
    for (int t = 0; t < LEASE; t++)
        step(&w);
    assert_true(answers(&w, 1));

    /* The leader gets that model, too. */
    assert_true(tfa_election_set_model(&later.nodes[0].e, other, later.now));
    for (int t = 0; t < LEASE; t++)
        step(&later);
    assert_int_equal(later.nodes[1].e.self.role, TFA_ROLE_STANDBY);
}

static void impossible_advertisements_are_ignored(void **state)
{
    tfa_advertisement self = {.daemon = {9}, .lease = LEASE};
    const tfa_advertisement good = {
        .daemon = {1}, .role = TFA_ROLE_LEADING, .epoch = 5, .lease = LEASE};
    tfa_advertisement lies[] = {good, good, good, good, good};
    tfa_election e;

    (void)state;
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
static void time_moves_on(void **state)
{
    const variant v = {.nodes = 2, .priority = {2, 1}};
    world w = begin(&v);

    (void)state;
    for (uint32_t i = 0; i < 2; i++)
        w.nodes[i].e.self.lease = 1000; /* parts of a tick are not rounded away */
    for (int t = 0; t < 10000; t++) {
        if (t == 4000)
            assert_true(apply_fault(&w, 0, FAULT_HANG));
        step(&w);
        for (uint32_t i = 0; i < 2; i++)
            assert_true(tfa_election_next(&w.nodes[i].e) > w.nodes[i].e.ran);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_standby_takes_over_within_the_lease),
        cmocka_unit_test(a_leader_without_progress_gives_up),
        cmocka_unit_test(a_partition_heals),
        cmocka_unit_test(the_best_standby_takes_over),
        cmocka_unit_test(equal_epochs_are_told_apart),
        cmocka_unit_test(epochs_survive_a_restart),
        cmocka_unit_test(a_good_bye_needs_no_lease),
        cmocka_unit_test(a_daemon_that_starts_is_silent_for_a_lease),
        cmocka_unit_test(another_model_does_not_follow),
        cmocka_unit_test(impossible_advertisements_are_ignored),
        cmocka_unit_test(time_moves_on),
        cmocka_unit_test(daemons_that_start),
        cmocka_unit_test(two_daemons),
        cmocka_unit_test(three_daemons),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
