/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The configuration of the daemon: read once, constant from then on.
 *
 * One table (config_table.c) holds every key with its type, default, range and explanation; the
 * parser, --check and --dump-config come from it.
 */
#ifndef TFA_SERVICE_CONFIG_H
#define TFA_SERVICE_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <totalforce/client.h>
#include <totalforce/model.h>

typedef enum config_estimate {
    CONFIG_ESTIMATE_NEVER,
    CONFIG_ESTIMATE_SAMPLED,
    CONFIG_ESTIMATE_ALWAYS,
} config_estimate;

typedef enum config_backend { CONFIG_BACKEND_SHM, CONFIG_BACKEND_MEMFD } config_backend;

typedef struct config_armature {
    const char *joint;
    double value; /* kg m^2 or kg */
} config_armature;

typedef struct config_robot {
    const char *name, *urdf;
    uint32_t base; /* tfa_base */
    double *gravity;
    size_t gravity_count; /* 3, or 0 for the default */
    config_armature *armature;
    size_t armature_count;
    uint32_t estimate; /* config_estimate */
    uint32_t estimate_every;
    uint32_t wait; /* tfa_wait: what clients get that ask for nothing */
    uint32_t slots, max_batch;
    bool rotor_inertia;
    bool dds;
} config_robot;

typedef struct config_limits {
    uint32_t clients, clients_per_user, memory_mib;
} config_limits;

typedef struct config_realtime {
    uint32_t priority;
    uint32_t *affinity;
    size_t affinity_count;
    bool mlock;
} config_realtime;

typedef struct config_dds {
    bool enabled;
    uint32_t domain;
} config_dds;

typedef struct config {
    const char *runtime_dir, *group, *user;
    uint32_t log_level;
    uint32_t workers, spin_ns, backend;
    bool allow_spin;
    config_limits limits;
    config_realtime realtime;
    config_dds dds;
    config_robot *robots;
    size_t robots_count;

    char *file;        /* the file it came from */
    void *raw;         /* what libcyaml allocated: strings and lists live there */
    char *default_dir; /* runtime_dir when the file says nothing */
} config;

/**
 * Reads and checks a file. Every error goes to `errors` as "FILE:LINE:COLUMN: what; remedy".
 * @return TFA_OK; TFA_E_FILE; TFA_E_PARSE; TFA_E_MEMORY. On error *out is NULL.
 */
TFA_CHECKED int config_load(const char *file, FILE *errors, config **out);
void config_free(config *c);

/** Writes the configuration in effect as YAML, every key with its explanation. */
void config_dump(const config *c, FILE *out);

/** Path of a robot's URDF file: relative ones start at the configuration file. Release with free;
 *  NULL when memory is short. */
char *config_urdf_path(const config *c, const config_robot *robot);

#endif
