/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Daemons that elect a leader, in simulated time: a tick is a beat of each. A world is a value; a
 * copy of it is another future. Every tick asserts that at most one daemon answers, and that
 * nothing but a fault ends a leadership.
 */
#ifndef TFA_TESTS_ELECTION_SIMULATION_H
#define TFA_TESTS_ELECTION_SIMULATION_H

#include "dds/standby/election.h"

#define SIM_LEASE 5 /* ticks */
#define SIM_NODES 3
#define SIM_DELAY_MAX 1
#define SIM_INBOX 64

typedef enum sim_fault {
    FAULT_KILL,  /* gone without a word, and back with another GUID */
    FAULT_STOP,  /* SIGSTOP; the second one continues it */
    FAULT_HANG,  /* no progress; the second one ends it */
    FAULT_LEAVE, /* stopped cleanly, and back with another GUID */
    FAULT_CUT,   /* nothing reaches it; the second one heals it */
    FAULT_MUTE,  /* nothing that it says arrives; the second one heals it */
    FAULT_KINDS
} sim_fault;

typedef struct sim_message {
    bool good_bye;
    int64_t arrives;
    tfa_advertisement said;
} sim_message;

typedef struct sim_node {
    tfa_election e;
    bool alive, stopped, hung, deaf, mute;
    bool disturbed; /* since it led last: stopped, hung or cut off */
    int64_t leads_since;
    uint32_t inbox_count;
    sim_message inbox[SIM_INBOX];
} sim_node;

/* Differences between runs besides the faults */
typedef struct sim_variant {
    uint32_t nodes;
    uint32_t priority[SIM_NODES];
    int64_t delay;
    bool backwards;   /* the order in which daemons run */
    bool ticks_first; /* a daemon looks at the clock before it reads */
    bool clock;       /* the first epoch is the time of the start */
} sim_variant;

typedef struct sim_world {
    const sim_variant *v;
    int64_t now;
    uint8_t next_guid;
    bool parted;         /* a network fault has been */
    int64_t single;      /* last time at which at most one answered */
    uint64_t *takeovers; /* counts those of this world and of its copies; or NULL */
    sim_node nodes[SIM_NODES];
} sim_world;

/** All daemons start. */
sim_world sim_begin(const sim_variant *v);
void sim_step(sim_world *w);
void sim_run(sim_world *w, int ticks);
/** Runs until one leads: asserts that one does. */
void sim_settle(sim_world *w);
/** @return false: no such fault in the state of that daemon */
bool sim_apply_fault(sim_world *w, uint32_t i, sim_fault kind);
bool sim_answers(const sim_world *w, uint32_t i);
uint32_t sim_count_answering(const sim_world *w);

#endif
