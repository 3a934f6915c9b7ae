/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A gateway of the daemon: serves robots in a transport of its own, by solvers of its own. The
 * control thread calls every function; robots are numbered as in the robot set.
 *
 * Order: join before pool and workers, whose priorities its threads would inherit, and gateways in
 * the order of their sources: ROS 2 asks DDS who leads, and DDS makes a domain that both join.
 * start after the self-test. In a reload: detach, until true, where a robot's shape changes; then
 * exchange, the offer to the workers, and announce when every worker has taken it. stop while the
 * workers run; the solvers are the caller's, who may free them when no reload reads them.
 */
#ifndef TFA_SERVICE_GATEWAY_GATEWAY_H
#define TFA_SERVICE_GATEWAY_GATEWAY_H

#include "config/config.h"
#include "ipc/statistics_layout.h"
#include "robots/robot.h"

struct tfa_tap;

/* What a gateway serves, and where it counts. All but the settings outlives it. */
typedef struct gateway_context {
    const config *settings;
    const tfa_robot *robots; /* those with dds first */
    uint32_t robot_count;
    tfa_shared_dds *messages;
    tfa_shared_robot *statistics; /* by robot */
    tfa_shared_state *states;     /* of this source, by robot */
    void *self;                   /* of the functions below, for any thread */
    /* A robot_description, terminated; `robot` is its number in the configuration. */
    void (*description)(void *self, size_t robot, const char *text);
    /* True if this daemon may answer for the robot; false: a standby. */
    bool (*leads)(void *self, uint32_t robot);
} gateway_context;

/* Hot standby of one robot */
typedef struct gateway_leadership {
    bool leads;       /* this daemon may answer for the robot now */
    const char *role; /* listening, standby, leading, unlike (another model than the leader's) */
    uint64_t epoch;   /* of the leadership, or the highest that is known */
    uint32_t peers;   /* other daemons for the robot that advertise */
    double pause_ms;  /* longest between two advertisements of this daemon */
    double silence_ms; /* longest between two of a leader: the lease must be longer */
    char leader[33];   /* participant that it follows, hexadecimal; "": none */
    char origin[192];  /* of that participant, in its own words; free of quotes */
    double follows_ms; /* for so long */
} gateway_leadership;

/* Why a robot cannot be served: the key below the gateway's part of the robot ("tips[0]"), what is
 * wrong with it and the remedy. */
typedef struct gateway_error {
    char path[64], text[256];
} gateway_error;

/* Members may be NULL where a gateway has nothing to do; those of a status return TFA_OK or log. */
struct gateway {
    const char *name; /* "dds", "ros2": its section of the configuration */
    uint32_t source;  /* TFA_SOURCE_: place of its states and its tap */
    /* Checks configuration and environment without joining a domain. */
    int (*check)(const config *settings);
    /* Checks the robot's part of the configuration against its model or that of one of its scenes;
     * any thread. @param served  the robot, then its scenes */
    int (*check_robot)(const config *settings, const config_robot *robot, const tfa_robot *served,
                       gateway_error *error);
    /* Creates every entity; nothing answers yet. @param self  NULL if it is off or on error */
    int (*join)(const gateway_context *context, void **self);
    /* Serves. @param first  worker of long requests; @param solvers  by robot, copied */
    int (*start)(void *self, struct tfa_worker *first, const tfa_worker_robot *solvers);
    bool (*serves)(const void *self, uint32_t robot);
    /* The robot is answered by this model's solver from now on. The previous solver and model are
     * unused when it returns, even if it had no memory and the robot is silent now. */
    void (*exchange)(void *self, uint32_t robot, const tfa_model *next,
                     const tfa_worker_robot *solver);
    /* Gives the robot's ring at the worker back when its requests are answered. @return whether it
     * has; otherwise ask again */
    bool (*detach)(void *self, uint32_t robot);
    /* Tells the domain of the model; takes a ring again. */
    void (*announce)(void *self, uint32_t robot, const tfa_model *model);
    /* Requests that it answers itself go to this tap, too; NULL: to none. The previous tap is not
     * used any more when it returns. */
    void (*set_tap)(void *self, uint32_t robot, struct tfa_tap *tap);
    /* Outcome of the robot's last robot_description; NULL: it is the model. */
    void (*report)(void *self, uint32_t robot, const char *error);
    /* Any thread, after start. @return false: the robot is not served */
    bool (*leadership)(void *self, uint32_t robot, gateway_leadership *leadership);
    /* Its part of the robot's row in the statistics. */
    void (*describe)(const void *self, uint32_t robot, tfa_served_robot *served);
    /* Ends its threads, leaves the domain, frees it; the solvers stay. */
    void (*stop)(void *self);
};

/* A gateway in the daemon. */
typedef struct gateway_slot {
    const struct gateway *kind;
    void *self;                 /* NULL: off */
    tfa_robot_solver **solvers; /* by robot, NULL where it is not served; NULL: none yet */
} gateway_slot;

#endif
