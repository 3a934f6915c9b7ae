/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot of the daemon: loaded, compiled, named; and what each worker needs to solve for it.
 */
#ifndef TFA_SERVICE_ROBOT_H
#define TFA_SERVICE_ROBOT_H

#include <totalforce/dynamics.h>
#include <totalforce/model.h>

#include "config.h"
#include "segment.h"
#include "worker.h"

typedef struct tfa_robot {
    const config_robot *config;
    tfa_model *model;
    tfa_wire_shape shape; /**< max_batch as configured */
    tfa_segment names;    /**< see tfa_welcome.names_bytes */
} tfa_robot;

/** Loads and compiles a robot; what the report has to say is logged. @return TFA_OK or why not. */
TFA_CHECKED int tfa_robot_load(const config *settings, const config_robot *from, tfa_robot *robot);
void tfa_robot_unload(tfa_robot *robot);

/** A workspace and an estimate policy: belongs to one worker. */
typedef struct tfa_robot_solver {
    tfa_workspace *workspace;
    void *memory;
    uint32_t estimate; /**< config_estimate */
    uint32_t every, until_next;
} tfa_robot_solver;

TFA_CHECKED int tfa_robot_solver_init(const tfa_robot *robot, tfa_robot_solver *solver);
void tfa_robot_solver_free(tfa_robot_solver *solver);

/** A tfa_solver; `self` is a tfa_robot_solver. */
int tfa_robot_solve(void *self, const tfa_request *request, tfa_reply *reply);

/** Asks the worker one forward dynamics of the robot at q = 0 through a port, as a client would.
 *  @return TFA_OK: it was answered. TFA_E_TIMEOUT; what the worker says. */
TFA_CHECKED int tfa_robot_self_test(const tfa_robot *robot, tfa_worker *worker, uint32_t index);

#endif
