/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Options that `solve` and `call` have in common, and the run from requests to replies.
 */
#ifndef TOOLS_JSONL_JSONL_OPTIONS_H
#define TOOLS_JSONL_JSONL_OPTIONS_H

#include "jsonl_serve.h"

#include <argp.h>

typedef struct jsonl_options {
    jsonl_defaults defaults;
    int strict;       /**< an error reply makes the exit status 1 */
    const char *file; /**< of requests; NULL or "-": standard input */
} jsonl_options;

#define JSONL_OPTIONS_DEFAULT                                                                      \
    {                                                                                              \
        .defaults = JSONL_DEFAULTS                                                                 \
    }

/** --method, --refine, --estimate, --strict; its input is a jsonl_options. */
extern const struct argp jsonl_argp;

/** Keys of a line, for --help */
#define JSONL_HELP                                                                                 \
    "A request is {\"id\":1,\"op\":OP,\"q\":[...],...}. OP, its keys and answers:\n"               \
    "  forward_dynamics     v, tau, wrench, tips -> qdd, lambda_inv\n"                             \
    "  inverse_dynamics     v, qdd, wrench -> tau\n"                                               \
    "  operational_inertia  tips -> lambda_inv, rank, eig_min, eig_max\n"                          \
    "  mass_matrix          -> M\n"                                                                \
    "  kinematics           v, want -> what is wanted\n"                                           \
    "  bias                 v, wrench, qdd -> gravity, velocity, damping, friction,\n"             \
    "                       external, armature\n"                                                  \
    "  task_torques         v, acceleration ({tip: [6 or 3]}), posture_torques,\n"                 \
    "                       wrench, rank_loss (damp, truncate, refuse),\n"                         \
    "                       rank_threshold, characteristic_length -> tau,\n"                       \
    "                       lambda_inv, rank, threshold, condition, length,\n"                     \
    "                       lambda_error_estimate, lost\n"                                         \
    "  derivatives          v, tau, wrench -> dqdd_dq, dqdd_dv, dqdd_dtau\n"                       \
    "  inverse_dynamics_derivatives\n"                                                             \
    "                       v, qdd, wrench -> dtau_dq, dtau_dv\n"                                  \
    "  constrained_dynamics v, tau, wrench, constraints -> qdd, constraint_wrenches\n"             \
    "  impact               v, constraints -> v, constraint_wrenches\n"                            \
    "  constrained_inverse_dynamics\n"                                                             \
    "                       v, qdd, wrench, constraints, torque_weights -> tau,\n"                 \
    "                       constraint_wrenches\n"                                                 \
    "  regressor            v, qdd, tips -> regressor, joint_regressor\n"                          \
    "q, v, tau, qdd are arrays in joint order (`totalforce model --json` prints it) or objects "   \
    "{joint: value}. A floating base has base_pose, base_twist, base_wrench, base_acceleration. "  \
    "Flexible links have modes, mode_velocities. "                                                 \
    "Every op also answers \"want\":[...]: jacobian, bias_acceleration, twist and pose of tips, "  \
    "poses (of all links), com, momentum, energy, generalised_momentum; with lambda_inv "          \
    "spectrum, lambda, mu, p. "                                                                    \
    "Optional: tips (1 to 32 links), rows (pose, point), frame (world, local, "                    \
    "local_world_aligned), method, refine, estimate, gravity, payload ({link, mass, com, "         \
    "inertia} or a list of such), locked ([joint,...]: they do not move), poses (true: those of "  \
    "the tips). "                                                                                  \
    "A line that cannot be answered gets {\"id\":..,\"status\":\"error\",\"error\":..,"            \
    "\"code\":..} and the next line is answered all the same."

/** Serves the requests to standard output. @return an exit status of commands.h. */
int jsonl_run(const char *command, const jsonl_options *options, const jsonl_backend *backend);

#endif
