/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Leader election among the daemons that serve one robot.
 */
#include "dds/standby/election.h"

#include <string.h>

#define NS_PER_MS 1000000
#define LEASE_MAX INT64_C(3600000000000) /* 1 h: a longer one is a mistake or a lie */

/* ---- order ---- */

static bool is_better_candidate(const tfa_advertisement *a, const tfa_advertisement *b)
{
    if (a->priority != b->priority)
        return a->priority > b->priority;
    return memcmp(a->daemon, b->daemon, sizeof a->daemon) < 0;
}

static bool is_better_leader(const tfa_advertisement *a, const tfa_advertisement *b)
{
    return a->epoch != b->epoch ? a->epoch > b->epoch : is_better_candidate(a, b);
}

static bool is_same_daemon(const uint8_t a[16], const uint8_t b[16])
{
    return memcmp(a, b, 16) == 0;
}

/* ---- peers ---- */

static void remove_peer(tfa_election *e, uint32_t i)
{
    e->peers[i] = e->peers[--e->peer_count];
}

static int64_t beat_of(const tfa_election *e)
{
    return e->self.lease / TFA_ELECTION_BEATS;
}

/* Advertisements that have arrived by now are read within two beats. */
static int64_t end_of_grace(const tfa_election *e, int64_t now)
{
    return now + 2 * beat_of(e);
}

/* After a time in which this daemon did not run, advertisements may still wait to be read: those
 * that were live before it get two beats more. */
static void excuse_peers(tfa_election *e, int64_t now)
{
    const int64_t end = end_of_grace(e, now);

    if (end_of_grace(e, e->ran) >= now)
        return;
    for (uint32_t i = 0; i < e->peer_count; i++)
        if (e->peers[i].until >= e->ran && e->peers[i].until < end)
            e->peers[i].until = end;
}

static int64_t end_of_lease(const tfa_election *e, const tfa_advertisement *said, int64_t now)
{
    const int64_t most = TFA_ELECTION_LEASES * e->self.lease;

    return now + (said->lease < most ? said->lease : most);
}

static void listen(tfa_election *e, int64_t now)
{
    e->self.role = TFA_ROLE_LISTENING;
    e->listening_since = now;
}

/* The leader could not advertise for a lease, and others were there: one may lead by now. */
static bool has_lapsed(const tfa_election *e, int64_t now)
{
    return e->self.role == TFA_ROLE_LEADING && e->peer_count > 0 &&
           now - e->advertised >= e->self.lease;
}

/* The first step of each call: a leader has its lease and peers are alive afterwards. */
static void advance(tfa_election *e, int64_t now)
{
    if (has_lapsed(e, now))
        listen(e, now);
    excuse_peers(e, now);
    e->ran = now;
    for (uint32_t i = e->peer_count; i-- > 0;)
        if (e->peers[i].until < now)
            remove_peer(e, i);
}

static tfa_election_peer *find_peer(tfa_election *e, const uint8_t daemon[16])
{
    for (uint32_t i = 0; i < e->peer_count; i++)
        if (is_same_daemon(e->peers[i].said.daemon, daemon))
            return &e->peers[i];
    return NULL;
}

const tfa_election_peer *tfa_election_leader(const tfa_election *e)
{
    const tfa_election_peer *best = NULL;

    for (uint32_t i = 0; i < e->peer_count; i++)
        if (e->peers[i].said.role == TFA_ROLE_LEADING &&
            (best == NULL || is_better_leader(&e->peers[i].said, &best->said)))
            best = &e->peers[i];
    return best;
}

/* ---- roles ---- */

/* Another daemon may have led, and be gone, unseen: its epoch was of an earlier time. */
static void lead(tfa_election *e, int64_t now)
{
    const uint64_t least = e->first_epoch + (uint64_t)((now - e->begun) / NS_PER_MS);

    e->self.role = TFA_ROLE_LEADING;
    e->self.epoch++;
    if (e->self.epoch < least)
        e->self.epoch = least;
    e->model_known = e->superseded = false; /* its own is the leader's now */
}

static bool has_leaders_model(const tfa_election *e)
{
    return !e->model_known || memcmp(e->model, e->self.model, sizeof e->self.model) == 0;
}

static void follow(tfa_election *e)
{
    const bool led = e->self.role == TFA_ROLE_LEADING;

    e->superseded = !has_leaders_model(e) && (led || e->superseded);
    e->self.role = has_leaders_model(e) ? TFA_ROLE_STANDBY : TFA_ROLE_UNLIKE;
}

/* A live daemon will lead before this one does: standbys before daemons that start, then the better
 * one. */
static bool waits_for(const tfa_election *e, const tfa_advertisement *peer)
{
    if (peer->role == TFA_ROLE_STANDBY)
        return e->self.role == TFA_ROLE_LISTENING || is_better_candidate(peer, &e->self);
    return peer->role == TFA_ROLE_LISTENING && e->self.role == TFA_ROLE_LISTENING &&
           is_better_candidate(peer, &e->self);
}

static bool waits_for_another(const tfa_election *e)
{
    for (uint32_t i = 0; i < e->peer_count; i++)
        if (waits_for(e, &e->peers[i].said))
            return true;
    return false;
}

/* Without a leader: true if this daemon shall lead */
static bool may_take_over(const tfa_election *e, int64_t now)
{
    if (e->self.role == TFA_ROLE_LISTENING && now - e->listening_since < e->self.lease)
        return false;
    return (e->self.role != TFA_ROLE_UNLIKE || e->superseded) && !waits_for_another(e);
}

/* The decision. @return the role or the epoch changed */
static bool decide(tfa_election *e, int64_t now)
{
    const tfa_election_peer *leader = tfa_election_leader(e);
    const tfa_role role = e->self.role;
    const uint64_t epoch = e->self.epoch;

    if (leader != NULL) {
        if (role == TFA_ROLE_LEADING && is_better_leader(&e->self, &leader->said)) {
            e->self.epoch += leader->said.epoch == epoch; /* replies of both are told apart */
            return e->self.epoch != epoch;
        }
        e->model_known = true;
        memcpy(e->model, leader->said.model, sizeof e->model);
        follow(e);
    } else if (role != TFA_ROLE_LEADING && may_take_over(e, now)) {
        lead(e, now);
    } else if (role == TFA_ROLE_STANDBY || role == TFA_ROLE_UNLIKE) {
        follow(e);
    }
    return e->self.role != role;
}

/* For the next advertisement. */
static void note_leader(tfa_election *e, int64_t now)
{
    static const uint8_t none[sizeof e->self.leader] = {0};
    const tfa_election_peer *leader =
        e->self.role != TFA_ROLE_LEADING ? tfa_election_leader(e) : NULL;
    const uint8_t *daemon = leader != NULL ? leader->said.daemon : none;

    if (is_same_daemon(daemon, e->self.leader))
        return;
    memcpy(e->self.leader, daemon, sizeof e->self.leader);
    e->follows_since = now;
}

static void note_longest(int64_t *longest, int64_t time)
{
    *longest = time > *longest ? time : *longest;
}

/* ---- events ---- */

void tfa_election_begin(tfa_election *e, const tfa_advertisement *self, int64_t now)
{
    *e = (tfa_election){.self = *self,
                        .first_epoch = self->epoch,
                        .begun = now,
                        .advertised = now,
                        .ran = now,
                        .progress = true};
    e->self.epoch = 0;
    memset(e->self.leader, 0, sizeof e->self.leader);
    listen(e, now);
}

bool tfa_election_tick(tfa_election *e, bool progress, int64_t now)
{
    advance(e, now);
    e->progress = progress;
    if (!progress && (e->self.role != TFA_ROLE_LEADING || e->peer_count > 0))
        return false;
    const bool changed = decide(e, now);
    note_leader(e, now);
    if (!changed && now - e->advertised < beat_of(e))
        return false;
    note_longest(&e->longest_pause, now - e->advertised);
    e->advertised = now;
    return true;
}

static bool is_possible(const tfa_election *e, const tfa_advertisement *said)
{
    return said->epoch < TFA_ELECTION_EPOCH_MAX && (unsigned)said->role < TFA_ROLE_COUNT &&
           said->lease > 0 && said->lease <= LEASE_MAX &&
           !is_same_daemon(said->daemon, e->self.daemon);
}

/* A standby that follows this daemon has followed a leader of a higher epoch. */
static bool is_outdated(const tfa_election *e, const tfa_advertisement *standby)
{
    return e->self.role == TFA_ROLE_LEADING && standby->epoch > e->self.epoch &&
           is_same_daemon(standby->leader, e->self.daemon);
}

bool tfa_election_hear(tfa_election *e, const tfa_advertisement *said, int64_t now)
{
    if (!is_possible(e, said))
        return false;
    advance(e, now);
    tfa_election_peer *peer = find_peer(e, said->daemon);
    if (peer == NULL && e->peer_count == TFA_ELECTION_PEERS)
        return false;
    if (peer == NULL)
        peer = &e->peers[e->peer_count++];
    else if (peer->said.role == TFA_ROLE_LEADING)
        note_longest(&e->longest_silence, now - peer->last);
    *peer = (tfa_election_peer){.said = *said, .last = now, .until = end_of_lease(e, said, now)};
    /* Silence is judged by tfa_election_tick alone, at the end of a lease. */
    bool changed = tfa_election_leader(e) != NULL && decide(e, now);
    if (e->self.role != TFA_ROLE_LEADING && said->epoch > e->self.epoch)
        e->self.epoch = said->epoch;
    if (is_outdated(e, said)) {
        e->self.epoch = said->epoch + 1;
        changed = true;
    }
    note_leader(e, now);
    if (changed)
        e->advertised = now;
    return changed;
}

bool tfa_election_leave(tfa_election *e, const uint8_t daemon[16], int64_t now)
{
    advance(e, now);
    tfa_election_peer *peer = find_peer(e, daemon);
    if (peer == NULL)
        return false;
    const bool led = peer->said.role == TFA_ROLE_LEADING;
    remove_peer(e, (uint32_t)(peer - e->peers));
    const bool changed = led && e->progress && decide(e, now);
    note_leader(e, now);
    if (changed)
        e->advertised = now;
    return changed;
}

void tfa_election_lose(tfa_election *e, const uint8_t daemon[16], int64_t now)
{
    advance(e, now);
    tfa_election_peer *peer = find_peer(e, daemon);
    const int64_t end = end_of_grace(e, now);

    if (peer != NULL && peer->until > end)
        peer->until = end;
}

bool tfa_election_set_model(tfa_election *e, const uint8_t model[32], int64_t now)
{
    advance(e, now);
    memcpy(e->self.model, model, sizeof e->self.model);
    e->model_known = e->model_known && tfa_election_leader(e) != NULL;
    e->superseded = false;
    if (e->self.role == TFA_ROLE_STANDBY || e->self.role == TFA_ROLE_UNLIKE)
        follow(e);
    e->advertised = now;
    return true;
}

int64_t tfa_election_next(const tfa_election *e)
{
    const tfa_election_peer *leader = tfa_election_leader(e);
    const int64_t soon = e->ran + beat_of(e) / 4; /* without progress it looks again */
    const int64_t beat = e->advertised + beat_of(e);
    const int64_t next = beat > e->ran ? beat : soon;
    const int64_t end = leader != NULL                       ? leader->until + 1
                        : e->self.role == TFA_ROLE_LISTENING ? e->listening_since + e->self.lease
                                                             : next;

    return end < next && end > e->ran ? end : next;
}

bool tfa_election_may_answer(const tfa_election *e, int64_t now)
{
    return e->self.role == TFA_ROLE_LEADING && !has_lapsed(e, now);
}
