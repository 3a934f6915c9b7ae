/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the benchmark asks of a contestant: forward dynamics of a fixed-base robot.
 */
#ifndef TFA_BENCH_H
#define TFA_BENCH_H

#include <stddef.h>
#include <totalforce/description.h>

#ifdef __cplusplus
extern "C" {
#endif

struct contestant {
    const char *name;
    /* Makes the robot from its URDF file and its description; NULL when it cannot. */
    void *(*make)(const char *path, const tfa_description *description);
    /* qdd = M^-1 (tau - h); arrays in the order of the description's joints, one number each */
    void (*forward)(void *robot, const double *q, const double *v, const double *tau, double *qdd);
    void (*release)(void *robot);
};

extern const struct contestant peer_mujoco;
extern const struct contestant peer_kdl;

/* Writes a chain of `links` unit rods (radius 0.1 m, 1 kg, 1 m) with random joint axes and twists,
 * the mechanism "random" of the accuracy charts, as URDF. Returns 0 or -1. */
int chain_urdf(const char *path, int links, unsigned seed);

#ifdef __cplusplus
}
#endif
#endif
