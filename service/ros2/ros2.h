/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ROS 2 gateway of the daemon: reads states and commands of robots on topics of ROS 2 or
 * Unitree, answers on topics of ROS 2. No part of ROS is needed: Cyclone DDS and the conventions of
 * rmw_cyclonedds (docs/ros2.md).
 *
 * One thread takes the messages of all robots, and computes with solvers of the gateway's own: it
 * shares nothing with the workers. All functions from one other thread, except
 * tfa_ros2_options.description and .leads, which the gateway's thread calls.
 *
 * Order of calls (main.c): tfa_ros2_create before the workers raise their priority (Cyclone's
 * threads inherit it), tfa_ros2_start when everything can be served, tfa_ros2_stop at the end.
 */
#ifndef TFA_SERVICE_ROS2_ROS2_H
#define TFA_SERVICE_ROS2_ROS2_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/model.h>
#include <totalforce/status.h>

#include "config/config.h"
#include "ipc/statistics_layout.h"

/** Of Cyclone: ports end there. */
#define TFA_ROS2_DOMAIN_MAX 230

struct tfa_tap;
struct tfa_worker_robot;

typedef struct tfa_ros2 tfa_ros2;

typedef struct tfa_ros2_robot {
    const char *name;             /**< lives as long as the gateway */
    const config_robot *config;   /**< read by tfa_ros2_create only */
    const tfa_model *model;       /**< must live until another took its place */
    tfa_shared_robot *statistics; /**< where its requests are counted; NULL: nowhere */
    tfa_shared_state *state;      /**< of the robot, in the statistics; NULL: none */
} tfa_ros2_robot;

/** Longest robot_description that is read, bytes. */
#define TFA_ROS2_DESCRIPTION_MAX (1u << 20)
/** Longest message that the domain must take, bytes: a description, or names of many joints. */
#define TFA_ROS2_SAMPLE_MAX (TFA_ROS2_DESCRIPTION_MAX + 65536u)

typedef struct tfa_ros2_options {
    uint32_t domain;      /**< 0..230 */
    const char *settings; /**< Cyclone's XML for the domain, before CYCLONEDDS_URI; NULL: the domain
                               was made already */
    const tfa_ros2_robot *robots;
    uint32_t robot_count;
    void *self; /**< of the functions below */
    /** A robot_description, terminated; `robot` counts from 0 in `robots`. */
    void (*description)(void *self, uint32_t robot, const char *text);
    /** May this daemon answer for the robot? NULL: always. A standby is silent. */
    bool (*leads)(void *self, uint32_t robot);
} tfa_ros2_options;

/**
 * Does the robot's part of the configuration fit the model? Names of topics, joints, links, motors;
 * joints of one coordinate; a source for a floating base. Any thread, nothing else is needed.
 * @param path   receives the key below "ros2" that is wrong: "tips[0]"
 * @param error  what is wrong with it and the remedy
 * @return TFA_OK; TFA_E_ARGUMENT, TFA_E_LINK, TFA_E_JOINT, TFA_E_UNSUPPORTED; TFA_E_MEMORY
 */
TFA_CHECKED int tfa_ros2_check(const config_robot_ros2 *settings, const tfa_model *model,
                               char *path, size_t path_size, char *error, size_t size);

/** Have both robots the same node? Their answers would be on the same topics. */
bool tfa_ros2_same_node(const config_robot_ros2 *a, const config_robot_ros2 *b);

/** Joins the domain and creates every entity, but nothing is read yet. @return TFA_OK;
 *  TFA_E_MEMORY; TFA_E_SYSTEM: see tfa_ros2_error. On error *gateway is NULL. */
TFA_CHECKED int tfa_ros2_create(const tfa_ros2_options *options, tfa_ros2 **gateway);

/** Begins to read and answer. `solvers` (copied), one for each robot, are the gateway's own.
 *  @return TFA_OK; TFA_E_SYSTEM */
TFA_CHECKED int tfa_ros2_start(tfa_ros2 *gateway, const struct tfa_worker_robot *solvers);

/** Another model for a robot: tfa_ros2_check has accepted it. The solver and the model of before
 *  are not used any more when it returns. @return TFA_OK; TFA_E_MEMORY: the robot is silent until
 *  the next exchange */
TFA_CHECKED int tfa_ros2_exchange(tfa_ros2 *gateway, uint32_t robot, const tfa_model *model,
                                  const struct tfa_worker_robot *solver);

/** Requests of the robot go to this tap, too; NULL: to none. The tap of before is not used any more
 *  when it returns. */
void tfa_ros2_set_tap(tfa_ros2 *gateway, uint32_t robot, struct tfa_tap *tap);

/** Outcome of the last robot_description, for diagnostics: NULL: it is the model; else why not. */
void tfa_ros2_describe(tfa_ros2 *gateway, uint32_t robot, const char *error);

/** Ends the thread, leaves the domain, frees. NULL is allowed, and a gateway that never started. */
void tfa_ros2_stop(tfa_ros2 *gateway);

/** Why the last tfa_ros2_create failed, in Cyclone's words. Static storage, one thread. */
const char *tfa_ros2_error(void);

#endif
