/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Other models while the daemon runs; robot descriptions that ask for them.
 */
#ifndef TFA_SERVICE_CONTROL_RELOAD_H
#define TFA_SERVICE_CONTROL_RELOAD_H

#include "control/admission.h"
#include "control/gateways.h"

typedef enum reload_phase {
    RELOAD_NONE,
    RELOAD_LOADING,  /* the thread makes everything aside */
    RELOAD_DRAINING, /* robots whose shape changes lose their clients */
    RELOAD_OFFERED,  /* the workers have not all taken the new solvers */
} reload_phase;

/* A reload under way. Up to the commit it owns the new objects, afterwards the old ones: either is
 * released in the same way. */
typedef struct reload {
    reload_phase phase;
    bool requested_again; /* SIGHUP came meanwhile */
    bool of_topic;        /* of one robot, by its description, with the settings as they are */
    pthread_t thread;
    int event;   /* eventfd: the thread is done */
    bool loaded; /* the eventfd said so */
    int status;
    char reason[4096]; /* errors of a load that failed, a line each */
    config *settings;  /* NULL: of one robot, or not read */
    size_t robot;      /* that one, in the configuration */
    char *description; /* its URDF; after the commit: the one before */
    tfa_robot_urdf urdf;
    tfa_admission admission;
    robot_set robot_set;         /* of one robot: the others are empty */
    bool *changed;               /* by robot: it has another model, arithmetic or estimate policy */
    bool *shape_changed;         /* and its clients cannot stay */
    tfa_robot_solver ***solvers; /* by worker, then gateway, and robot; NULL: no change */
    uint64_t start;
} reload;

/* Robot descriptions that came over a topic, by number of the robot in the configuration. */
typedef struct robot_descriptions {
    pthread_mutex_t mutex; /* guards next and last: the gateway's thread writes them */
    int event;             /* eventfd: there is a next one */
    size_t count;
    char **next;   /* received and not yet loaded, or NULL */
    char **last;   /* received last: the same again is no news */
    char **loaded; /* in place of the robot's file, or NULL */
    /* CLOCK_MONOTONIC ns: the next is not taken before, so that no publisher hangs up on clients at
     * will. Control thread. */
    uint64_t *not_before;
} robot_descriptions;

/* After a description with other joints, links or another base */
#define DESCRIPTION_REST_NS UINT64_C(5000000000)

/* ---- reload.c: other models while it runs; reload_load.c: its thread ---- */

/* SIGHUP: begins a reload, or notes that another one is wanted. */
void reload_request(tfa_daemon *d);
/* A robot_description came: loads it when nothing else is under way. */
void reload_described(tfa_daemon *d);
/* The thread is done. */
void reload_event(tfa_daemon *d);
/* Time passed: clients may have left, workers may have taken over. */
void reload_tick(tfa_daemon *d);
/* It waits for workers: look again soon. */
bool reload_is_urgent(const tfa_daemon *d);
/* Ends it whatever its phase; the workers run no more. @return false: its thread still reads, and
 * uses robots and configuration */
bool reload_abandon(tfa_daemon *d);
/* The thread: fills in d->reload from settings to solvers, and status. `d` is only read. */
void *reload_thread(void *d);

/* ---- descriptions.c: robot descriptions from topics ---- */

/* Makes room for those of all robots. @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM */
TFA_CHECKED int descriptions_open(tfa_daemon *d);
void descriptions_close(tfa_daemon *d);
/* A description was received: any thread. */
void descriptions_receive(tfa_daemon *d, size_t robot, const char *text);
/* The next one, for the caller to free, and its robot in the configuration; NULL: there is none, or
 * it rests. */
char *descriptions_take(tfa_daemon *d, size_t *robot);
/* The description that is loaded hung up on clients: the robot's next one rests. */
void descriptions_rest(tfa_daemon *d, size_t robot);

#endif
