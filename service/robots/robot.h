/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot that clients can ask for, or a scene of one: loaded, compiled, named; and the objects
 * that each worker needs to solve for it. Grouped by the file that defines it.
 */
#ifndef TFA_SERVICE_ROBOTS_ROBOT_H
#define TFA_SERVICE_ROBOTS_ROBOT_H

#include <stdio.h>
#include <totalforce/batch_pool.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>
#include <totalforce/specialised.h>

#include "config/config.h"
#include "ipc/handshake.h"
#include "platform/segment.h"
#include "scene.h"
#include "worker/worker.h"

typedef struct tfa_robot {
    char name[TFA_ROBOT_NAME_MAX + 1]; /**< ROBOT or ROBOT.SCENE */
    const config_robot *config;        /**< of a scene: of its robot */
    const config_scene *scene;         /**< NULL: the robot itself */
    tfa_shared_model *shared;
    const tfa_model *model;       /**< of `shared` */
    tfa_wire_shape shape;         /**< max_batch as configured */
    tfa_segment names;            /**< see tfa_welcome.names_bytes */
    tfa_segment description;      /**< settings and URDF, once somebody asked for them */
    tfa_batch_pool *pool;         /**< for large requests, shared by all workers; NULL: none */
    tfa_specialised *specialised; /**< its specialised kernel; NULL: the generic one answers */
    uint32_t max_state_us;        /**< 0: states may take any time */
    struct tfa_cost_parts *parts; /**< what they take; NULL: not measured */
    bool reshaping; /**< a reload changes its shape: no client is attached meanwhile */
} tfa_robot;

/* ---- robot.c: loading ---- */

/** A URDF in place of the robot's file. */
typedef struct tfa_robot_urdf {
    const char *text; /**< NULL: the file after all */
    char error[200];  /**< why the robot was not loaded: the first error */
} tfa_robot_urdf;

/** Served names of a robot: itself and its scenes. */
size_t tfa_robot_count(const config_robot *from);

/**
 * Reads a robot's file once and compiles the robot and its scenes; checks each (tfa_robot_verify).
 * The reports are logged.
 * @param urdf    NULL: the robot's file
 * @param robots  tfa_robot_count(from) of them
 * @return TFA_OK or why not; then nothing is left of any of them.
 */
TFA_CHECKED int tfa_robot_load(const config *settings, const config_robot *from,
                               tfa_robot_urdf *urdf, tfa_robot *robots);
void tfa_robot_unload(tfa_robot *robot);

/** What a robot needs besides to be served with these settings: a pool of these threads, if it can
 * have large requests, and the times of its requests, if they are limited; a warning if forward
 * dynamics takes longer. @return TFA_OK; TFA_E_MEMORY; TFA_E_UNSUPPORTED */
TFA_CHECKED int tfa_robot_prepare(tfa_robot *robot, const config *settings,
                                  tfa_thread_pool *thread_pool);

/** Same arrays, same joints and links in the same order: clients of one can be served by the other
 *  without noticing. */
bool tfa_robot_same_shape(const tfa_robot *a, const tfa_robot *b);

/* ---- describe.c: for recorders ---- */

/** Writes all settings that shape its answers, as JSON.
 *  @param urdf_name  of its file, for people */
void tfa_robot_describe(const tfa_robot *robot, const char *urdf_name, FILE *out);

/* ---- kernel.c: specialised kernels ---- */

/** Looks for the robot's specialised kernel where the configuration says, and logs which kernel
 * answers. */
void tfa_robot_find_kernel(const config *settings, tfa_robot *robot);
/** The same build, or both none. */
bool tfa_robot_same_kernel(const tfa_robot *a, const tfa_robot *b);

/* ---- solver.c: solving ---- */

/** A workspace and an estimate policy: belongs to one worker. */
typedef struct tfa_robot_solver tfa_robot_solver;

/** For a robot whose pool, if it has one, outlives it. @return TFA_OK; TFA_E_MEMORY;
 *  TFA_E_UNSUPPORTED. Every page is there when it returns. @param of_worker  with one for the
 *  thread beside the worker, if it needs one */
TFA_CHECKED int tfa_robot_solver_create(const tfa_robot *robot, const config_pool *pool,
                                        bool of_worker, tfa_robot_solver **solver);
/** NULL is allowed. */
void tfa_robot_solver_free(tfa_robot_solver *solver);

/** A tfa_solver; `self` is a tfa_robot_solver. Large requests go to the pool, unless it serves
 *  another worker. */
int tfa_robot_solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first,
                    uint32_t count);

/** A tfa_warm_up; requests for the pool are left out. */
void tfa_robot_warm_up(void *self, const tfa_request *request, tfa_reply *reply);

/** The robot, for a worker */
tfa_worker_robot tfa_robot_for_worker(const tfa_robot *robot, tfa_robot_solver *solver);

/* ---- self_test.c: is it fit to answer? ---- */

/**
 * Checks a model in a private workspace: one forward dynamics of a robot that moves, put into the
 * equation of motion. The residual of M qdd + h = tau, by inverse dynamics, may be 1e-6 of the
 * forces in it; of flexible links, which have no inverse dynamics, the accelerations of two methods
 * may differ by 1e-6. A robot that is singular there passes: it was answered.
 * @return TFA_OK; TFA_E_NOT_COMPUTED (the residual is logged); TFA_E_MEMORY; errors that
 *         tfa_compute refuses.
 */
TFA_CHECKED int tfa_robot_verify(const tfa_robot *robot);

/** Asks the worker one forward dynamics of the robot at q = 0 through a local client.
 *  @return TFA_OK: it was answered. TFA_E_TIMEOUT; the worker's status. */
TFA_CHECKED int tfa_robot_self_test(const tfa_robot *robot, tfa_worker *worker, uint32_t index);

#endif
