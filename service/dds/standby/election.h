/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Leader election among the daemons that serve one robot: hot standby with a lease. A decision
 * without clock, thread or I/O: the state changes by the calls below only, each with the time.
 *
 * Each daemon advertises itself five times a lease. Rules:
 *  - A daemon that starts is silent for one lease. If it discovers a leader, it is a standby.
 *  - A standby that sees no leader for the leader's lease leads, unless a live standby of higher
 *    priority (equal: of smaller GUID) will. Its epoch is higher than any that it has seen.
 *  - No preemption: a standby does not replace a live leader, whatever their priorities.
 *  - Of two leaders (after a partition) the higher epoch stays; equal: the higher priority, then
 *    the smaller GUID, and it counts its epoch up. The other becomes a standby at once.
 *  - A leader whose standby knows of a higher epoch takes a higher one.
 *  - A leader takes no lower epoch than milliseconds of ROS time, as it was given at its begin and
 *    has passed since: epochs grow although all daemons were restarted, or led unseen.
 *  - A leader that could not advertise for a lease (stopped, or its worker made no progress) does
 *    not answer: others may lead by now. It begins as a daemon that starts. One without
 *    peers goes on: if another came meanwhile, both lead until they discover each other.
 *  - A standby whose model differs from the leader's does not take over from it, unless it led when
 *    that leader came: clients had its model before. A new model that it is given without a live
 *    leader (a reload) lets it lead.
 *  - Time in which this daemon did not run counts against no other.
 *  - A peer counts as live for its own lease, but for at most TFA_ELECTION_LEASES of this daemon's,
 *    and for two beats after its writer is gone: nobody holds the lead by a word alone.
 * Replies carry the epoch; clients drop those of an older one. So two leaders, which a partition or
 * two stopped processes may cause, never answer the same client both.
 *
 * Times are ns of any monotonic clock of this process; leases are durations. Not thread-safe.
 */
#ifndef TFA_SERVICE_DDS_ELECTION_H
#define TFA_SERVICE_DDS_ELECTION_H

#include <stdbool.h>
#include <stdint.h>

enum {
    TFA_ELECTION_PEERS = 8, /* other daemons for the same robot; more are ignored */
    TFA_ELECTION_BEATS = 5, /* advertisements in one lease: four may be lost in a row */
    /* A peer whose lease is up to 25 times as long still advertises itself in time. */
    TFA_ELECTION_LEASES = 5,
};

/* An epoch that no takeover reaches: such an advertisement is not believed. */
#define TFA_ELECTION_EPOCH_MAX (UINT64_C(1) << 62)

typedef enum tfa_role {
    TFA_ROLE_LISTENING, /* it starts, or it could not advertise for a lease */
    TFA_ROLE_STANDBY,
    TFA_ROLE_LEADING,
    TFA_ROLE_UNLIKE, /* a standby with another model than the leader's */
    TFA_ROLE_COUNT
} tfa_role;

/** What a daemon tells the others about itself and one robot. */
typedef struct tfa_advertisement {
    uint8_t daemon[16]; /**< GUID of its participant */
    uint64_t epoch;     /**< LEADING: of its leadership; otherwise the highest that it knows of */
    uint32_t priority;  /**< the higher one leads */
    tfa_role role;
    int64_t lease;      /**< ns: a daemon that is silent for longer is gone */
    uint8_t model[32];  /**< hash */
    uint8_t leader[16]; /**< GUID of the leader that it follows; 0: none, or itself */
} tfa_advertisement;

typedef struct tfa_election_peer {
    tfa_advertisement said;
    int64_t last;  /* advertisement */
    int64_t until; /* gone if silent until then */
} tfa_election_peer;

typedef struct tfa_election {
    tfa_advertisement self;
    uint64_t first_epoch; /* it leads with no lower one, and one more for each ms since */
    int64_t begun;
    int64_t listening_since;
    int64_t advertised;      /* last time */
    int64_t ran;             /* last time: of any call */
    int64_t longest_pause;   /* between two advertisements */
    int64_t longest_silence; /* of the leader, between two of its advertisements */
    int64_t follows_since;   /* the leader in self.leader */
    bool progress;           /* at the last tick */
    bool superseded;         /* it led, and a leader with another model came */
    bool model_known;        /* another led: */
    uint8_t model[32];       /* the last one's */
    uint32_t peer_count;
    tfa_election_peer peers[TFA_ELECTION_PEERS];
} tfa_election;

/** Begins to listen. Of `self`, role and leader are ignored; epoch is the lowest to lead with. */
void tfa_election_begin(tfa_election *e, const tfa_advertisement *self, int64_t now);

/* Each of these returns true when this daemon shall advertise itself now (e->self), and may have
 * changed its role. */

/** Time passed: to be called at tfa_election_next at the latest. `progress`: the worker and the
 *  receiving threads have shown that they run; without, the daemon neither advertises nor leads,
 *  unless it is alone. */
bool tfa_election_tick(tfa_election *e, bool progress, int64_t now);

/** Another daemon advertised itself. One with an impossible epoch, role or lease is ignored. */
bool tfa_election_hear(tfa_election *e, const tfa_advertisement *said, int64_t now);

/** Another daemon said good-bye. */
bool tfa_election_leave(tfa_election *e, const uint8_t daemon[16], int64_t now);

/** The writer of another daemon is gone, or its liveliness was lost: two beats, then it is gone. */
void tfa_election_lose(tfa_election *e, const uint8_t daemon[16], int64_t now);

/** This daemon was loaded again, perhaps with another model. */
bool tfa_election_set_model(tfa_election *e, const uint8_t model[32], int64_t now);

/** When tfa_election_tick wants to be called next. */
int64_t tfa_election_next(const tfa_election *e);

/** May this daemon answer now? It leads, and its lease has not run out, or it is alone. */
bool tfa_election_may_answer(const tfa_election *e, int64_t now);

/** The live leader; NULL: none, or this daemon itself. */
const tfa_election_peer *tfa_election_leader(const tfa_election *e);

#endif
