/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The task of a peer: forward dynamics of a robot on a fixed base, one number for each joint,
 * and perhaps Lambda^-1.
 */
#ifndef TFA_TOOLS_PEER_H
#define TFA_TOOLS_PEER_H

#include <stddef.h>
#include <totalforce/description.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Their costs grow as N^2 to N^3, and so does loading: minutes above this many bodies. */
#define PEER_BODIES_MAX 300

struct peer {
    const char *name;
    /** Makes the robot from its URDF file and its description; NULL when it cannot, and `why` says
     * so in one line. */
    void *(*make)(const char *path, const tfa_description *description, char *why, size_t size);
    /** qdd = M^-1 (tau - h) under gravity 0 0 -9.80665; arrays in the order of the description's
     * joints, fixed ones left out. */
    void (*forward)(void *robot, const double *q, const double *v, const double *tau, double *qdd);
    void (*release)(void *robot);
};

/** The peers that are built in (-DTFA_PEERS=ON); NULL behind the last. */
extern const struct peer *const peer_table[];

/** A peer that has Lambda^-1, too */
struct peer_lambda {
    const struct peer *peer; /**< NULL behind the last */
    /** J M^-1 J^T (6 x 6, linear rows first) of a link that a joint moves, at its origin in axes of
     * the world. Returns 0, or -1: no such link. */
    int (*lambda)(void *robot, const double *q, const char *link, double *lambda_inv);
};

extern const struct peer_lambda peer_lambda_table[];

/** As in that table */
int peer_mujoco_lambda(void *robot, const double *q, const char *link, double *lambda_inv);

extern const struct peer peer_mujoco;
extern const struct peer peer_kdl;

#ifdef __cplusplus
}
#endif
#endif
