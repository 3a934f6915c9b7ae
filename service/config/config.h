/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The configuration of the daemon: constant once read; a reload reads another one.
 *
 * One table (config_table.c) holds every key with its type, default, range and explanation; the
 * parser, --check, --dump-config and the keys that a reload may change come from it.
 */
#ifndef TFA_SERVICE_CONFIG_CONFIG_H
#define TFA_SERVICE_CONFIG_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <totalforce/client.h>
#include <totalforce/model.h>

/* Clients of one worker at most */
#define TFA_WORKER_CLIENTS_MAX 256
/* Time of one client's turn: 40 forward dynamics of a 7-joint arm; a part costs 0.1 us more than
 * its states (tests/service/fairness.c prints both) */
#define TFA_WORKER_TURN_US 20
/* Time between two warm-ups */
#define TFA_WORKER_WARM_US 50

typedef enum config_estimate {
    CONFIG_ESTIMATE_DEFAULT,
    CONFIG_ESTIMATE_NEVER,
    CONFIG_ESTIMATE_SAMPLED,
    CONFIG_ESTIMATE_ALWAYS,
} config_estimate;

typedef enum config_precision { CONFIG_PRECISION_F64, CONFIG_PRECISION_F32 } config_precision;

/* Methods that a robot's workspaces have room for: tfa_workspace_options.methods 0 or all */
typedef enum config_methods { CONFIG_METHODS_AUTO, CONFIG_METHODS_ALL } config_methods;

/* Specialised kernels */
typedef enum config_specialise {
    CONFIG_SPECIALISE_OFF,
    CONFIG_SPECIALISE_LOAD,
} config_specialise;

typedef enum config_backend { CONFIG_BACKEND_SHM, CONFIG_BACKEND_MEMFD } config_backend;

typedef struct config_armature {
    const char *joint;
    double value; /* kg m^2 or kg */
} config_armature;

#define CONFIG_BASE_SAME 2u /* of a scene: as its robot; otherwise a tfa_base */

typedef struct config_lock {
    const char *joint;
    double q;     /* of a joint with one coordinate */
    double *pose; /* of one with several */
    size_t pose_count;
} config_lock;

typedef struct config_payload {
    const char *link;
    double mass;
    double *com;
    size_t com_count; /* 3, or 0: the link frame's origin */
    double *inertia;
    size_t inertia_count; /* 6, or 0: a point */
} config_payload;

/* Side of a constraint */
typedef struct config_frame {
    const char *link; /* NULL or "world": the world */
    double *xyz, *rpy;
    size_t xyz_count, rpy_count; /* 3, or 0: zeros */
} config_frame;

typedef struct config_constraint {
    const char *name;
    config_frame first, second;
    uint32_t *hold; /* rows by config_hold_rows */
    size_t hold_count;
    bool unilateral;
} config_constraint;

/* Part and loads of a robot that is served under the name ROBOT.SCENE. */
typedef struct config_scene {
    const char *name, *root;
    const char **tips;
    size_t tips_count;
    config_lock *locked;
    size_t locked_count;
    config_payload *payload;
    size_t payload_count;
    const char **modes;
    size_t modes_count;
    config_constraint *constraints;
    size_t constraints_count;
    const char **actuated;
    size_t actuated_count;
    uint32_t base;
    double *gravity;
    size_t gravity_count; /* 3, or 0: as its robot */
} config_scene;

/* Kinds of requests that a robot may refuse: X(NAME, word of the configuration) */
#define CONFIG_REFUSE_LIST(X)                                                                      \
    X(SEVERAL_TIPS, "several-tips")                                                                \
    X(SPECTRUM, "spectrum")                                                                        \
    X(LAMBDA, "lambda") /* lambda, mu, p, task torques: eigenvalues */                             \
    X(MASS_MATRIX, "mass-matrix")                                                                  \
    X(DERIVATIVES, "derivatives")                                                                  \
    X(METHODS, "methods")     /* other than auto */                                                \
    X(ESTIMATES, "estimates") /* asked for always */                                               \
    X(BATCHES, "batches")

#define CONFIG_REFUSE(name, word) CONFIG_REFUSE_##name,
enum { CONFIG_REFUSE_LIST(CONFIG_REFUSE) CONFIG_REFUSALS };
#undef CONFIG_REFUSE

#define CONFIG_STATE_US_MOST 5000       /* kinds that take longer are not measured */
#define CONFIG_DOMAIN_MAX 230           /* of Cyclone: ports end there */
#define CONFIG_ROS_DOMAIN_ID UINT32_MAX /* domain "environment" */

/* A force/torque topic. */
typedef struct config_ros2_wrench {
    const char *topic, *link;
} config_ros2_wrench;

typedef enum config_unitree_type {
    CONFIG_UNITREE_NONE,
    CONFIG_UNITREE_GO,
    CONFIG_UNITREE_HG,
} config_unitree_type;

/* What a robot's commands are answered by. */
typedef enum config_ros2_op {
    CONFIG_ROS2_FORWARD_DYNAMICS,
    CONFIG_ROS2_CONSTRAINED_DYNAMICS,
} config_ros2_op;

/* State of a Unitree robot. */
typedef struct config_unitree {
    uint32_t type; /* config_unitree_type */
    const char *topic;
    const char **motors; /* joint of each motor */
    size_t motors_count;
} config_unitree;

/* External torques by a generalised-momentum observer. */
typedef struct config_observer {
    double gain;    /* 1/s; 0: no observer */
    double max_gap; /* s; 0: 5 / gain */
    const char *tip;
} config_observer;

/* A robot's topics of ROS 2. Names as in ROS: relative ones start at the namespace, "~" is the
 * node. */
typedef struct config_robot_ros2 {
    bool enabled, services;
    const char *scene; /* NULL: the robot itself */
    const char *namespace, *node;
    const char *joint_states, *odometry, *effort_commands, *joint_efforts, *trajectory;
    const char *robot_description;
    const char **joints; /* of effort_commands, in order; none: the robot's */
    size_t joints_count;
    const char **tips;
    size_t tips_count;
    config_ros2_wrench *wrenches;
    size_t wrenches_count;
    uint32_t op; /* config_ros2_op */
    const char *active_constraints;
    const char **constraints; /* active until the first message; none: all */
    size_t constraints_count;
    config_unitree unitree;
    config_observer observer;
    uint32_t domain; /* or CONFIG_ROS_DOMAIN_ID: that of the section ros2 */
    uint32_t state_age_ms, command_age_ms;
} config_robot_ros2;

typedef struct config_robot {
    const char *name, *urdf;
    const char **refuse;
    size_t refuse_count;
    uint32_t base; /* tfa_base */
    double *gravity;
    size_t gravity_count; /* 3, or 0 for the default */
    config_armature *armature;
    size_t armature_count;
    config_armature *rotors; /* kg m^2 */
    size_t rotors_count;
    uint32_t inertia; /* tfa_inertia_policy */
    uint32_t mimic;   /* tfa_mimic_policy */
    config_scene *scenes;
    size_t scenes_count;
    uint32_t estimate; /* config_estimate */
    uint32_t estimate_every;
    uint32_t precision; /* config_precision */
    uint32_t residual;  /* tfa_residual */
    uint32_t wait;      /* tfa_wait: default of clients */
    uint32_t slots, max_batch, max_tips;
    uint32_t methods; /* config_methods */
    double snap, friction_velocity;
    bool rotor_inertia, damping, friction, lock_massless_leaves;
    bool dds;
    config_robot_ros2 ros2;
} config_robot;

typedef struct config_limits {
    uint32_t clients, clients_per_user, memory_mib, memory_mib_per_user;
    uint32_t connects_per_second;
} config_limits;

typedef struct config_realtime {
    uint32_t priority;
    uint32_t *affinity;
    size_t affinity_count;
    bool mlock;
    uint32_t cpu_dma_latency; /* us; CONFIG_ANY_LATENCY: not asked for */
} config_realtime;

/* The kernel's own value of "no wish" (PM_QOS_CPU_LATENCY_DEFAULT_VALUE), us. */
#define CONFIG_ANY_LATENCY UINT32_MAX /* "any" */

typedef struct config_pool {
    uint32_t threads, priority, spin_ns, from;
    uint32_t *affinity;
    size_t affinity_count;
} config_pool;

typedef struct config_dds {
    bool enabled;
    uint32_t domain, max_age_ms, priority, lease_ms;
} config_dds;

typedef enum config_discovery {
    CONFIG_DISCOVERY_ENVIRONMENT, /* ROS_AUTOMATIC_DISCOVERY_RANGE */
    CONFIG_DISCOVERY_SUBNET,
    CONFIG_DISCOVERY_LOCALHOST,
    CONFIG_DISCOVERY_OFF,
    CONFIG_DISCOVERY_SYSTEM_DEFAULT, /* CYCLONEDDS_URI alone decides */
} config_discovery;

typedef enum config_release {
    CONFIG_RELEASE_ENVIRONMENT, /* ROS_DISTRO */
    CONFIG_RELEASE_HUMBLE,
    CONFIG_RELEASE_IRON,
    CONFIG_RELEASE_JAZZY,
    CONFIG_RELEASE_KILTED,
    CONFIG_RELEASE_ROLLING,
} config_release;

typedef struct config_ros2 {
    bool enabled;
    uint32_t domain;    /* or CONFIG_ROS_DOMAIN_ID */
    uint32_t release;   /* config_release */
    uint32_t discovery; /* config_discovery */
    const char **peers; /* none: ROS_STATIC_PEERS */
    size_t peers_count;
} config_ros2;

typedef struct config {
    const char *runtime_dir, *group, *user;
    const char **allow_users, **allow_groups; /* both empty: every user who can open a socket */
    size_t allow_users_count, allow_groups_count;
    const char *specialise_directory;
    uint32_t specialise; /* config_specialise */
    uint32_t log_level;
    uint32_t workers, spin_ns, turn_us, max_state_us, warm_us, backend;
    bool allow_spin;
    config_limits limits;
    config_realtime realtime;
    config_pool pool;
    config_dds dds;
    config_ros2 ros2;
    config_robot *robots;
    size_t robots_count;

    char *file;                       /* it came from */
    struct yaml_document_s *document; /* owns the texts */
    char *default_dir;                /* runtime_dir when the file says nothing */
} config;

/**
 * Reads and checks a file. Every error goes to `errors` as "FILE:LINE:COLUMN: error; remedy".
 * @return TFA_OK; TFA_E_FILE; TFA_E_PARSE; TFA_E_MEMORY. On error *out is NULL.
 */
TFA_CHECKED int config_load(const char *file, FILE *errors, config **out);
void config_free(config *c);

/** Writes the configuration in effect as YAML, every key with its explanation. */
void config_dump(const config *c, FILE *out);

/** The table of keys, one key a line, fields with tabs between: "key", path, type, "required" or
 *  nothing, default, range, unit, "reload" (may change it), "restart" or nothing, explanation.
 *  @return 0, or EOF */
int config_print_keys(FILE *out);

/**
 * Names the first key that differs although only a restart can change it, in `text`: where it
 * stands, as config_location, and the whole sentence. @return there is one
 */
bool config_needs_restart(const config *now, const config *next, char *text, size_t size);

/** Rows that a constraint holds, as tfa_constraint.rows. */
uint32_t config_constraint_rows(const config_constraint *constraint);

/** Kinds of requests that a robot refuses: bits 1u << CONFIG_REFUSE_x. */
uint32_t config_refusals(const config_robot *robot);

/** Where the value of a path like "robots[1].scenes[0].root" stands: "FILE:LINE:COLUMN", for
 *  messages about it. */
void config_location(const config *c, const char *path, char *text, size_t size);

/** A file that the configuration names, by tfa_urdf_find: relative paths start at the configuration
 *  file. What cannot be found stays as written. Release with free; NULL when memory is short. */
char *config_file_path(const config *c, const char *name);

#endif
