/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle answers by dense world-frame Newton-Euler equations in quadruple precision.
 *
 * It reads a description link by link (nothing merged), shares no source with the library, and
 * takes another route on purpose: classical vectors in world axes, explicit Jacobians,
 * M = sum J^T diag(m, I) J, a dense LDL^T. Slow, O(links depth^2 + n^3): for tests only.
 */
#ifndef TESTS_SUPPORT_ORACLE_H
#define TESTS_SUPPORT_ORACLE_H

#include <stdint.h>
#include <totalforce/description.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>

typedef struct oracle oracle;

/** NULL when out of memory or when the joints do not form a tree. `description` must outlive it. */
oracle *oracle_create(const tfa_description *description, tfa_base base);
void oracle_free(oracle *o);

/** Freedoms, the six of a floating base included: rows of M, base first. */
uint32_t oracle_freedoms(const oracle *o);
uint32_t oracle_q_count(const oracle *o);
uint32_t oracle_v_count(const oracle *o);
/** Index in description->joints of the joint that owns freedom `k` of v; `within` counts in it. */
uint32_t oracle_joint_of_freedom(const oracle *o, uint32_t k, uint32_t *within);

/** What becomes of a freedom in a robot that has fewer of them: its velocity is `multiplier` times
 * that of freedom `to`, or it never changes. */
typedef struct oracle_tie {
    uint32_t to; /**< 0 .. rows - 1, or ORACLE_STILL */
    double multiplier;
} oracle_tie;
#define ORACLE_STILL UINT32_MAX

/**
 * Ties the freedoms, base first: qdd = T y, T as the n `ties` say. From the next state on M and h
 * are T^T M T and T^T h of all links and joints, and answers have `rows` rows. q and v of a request
 * still hold all joints: whoever ties sees to it that they fit. A row that nothing is tied to does
 * not move and takes part in nothing: its qdd is 0. NULL: every freedom its own again.
 */
void oracle_tie_freedoms(oracle *o, const oracle_tie *ties, uint32_t rows);

/** From the next state on joints resist with damping times velocity: part of h. Off at first. */
void oracle_use_damping(oracle *o, uint32_t use);

/** The same with friction times v / sqrt(v^2 + velocity^2); velocity 0: off. */
void oracle_use_friction(oracle *o, double velocity);

/**
 * Takes state `state` of the request (q, v, base, gravity, wrenches, payloads; tips, wrench_frames
 * and payload_frames are indices of links) and builds poses, Jacobians, M and h. gravity NULL:
 * 0 0 -9.80665.
 */
void oracle_set_state(oracle *o, const tfa_request *request, uint32_t state);

/* The answers below are for the state set last, rounded to double at the very end. */

/** qdd = M^-1 (tau - h). `base_acceleration` (6) may be NULL for a fixed base. */
void oracle_forward(oracle *o, const double *tau, const double *base_wrench, double *qdd,
                    double *base_acceleration);
/** tau = M qdd + h. */
void oracle_inverse(oracle *o, const double *qdd, const double *base_acceleration, double *tau,
                    double *base_wrench);
/** n x n, row major. */
void oracle_mass_matrix(oracle *o, double *mass_matrix);
/** (6 m) x (6 m), row major, linear rows first. */
void oracle_lambda_inv(oracle *o, const uint32_t *tips, uint32_t tip_count,
                       tfa_reference_frame frame, double *lambda_inv);

/** sqrt(x^T M x) of x = a - b, both as oracle_forward gives them (base apart); b NULL: zero. */
double oracle_energy_norm(const oracle *o, const double *a, const double *a_base, const double *b,
                          const double *b_base);
/** All mass, payloads included, and its centre in the world. */
void oracle_mass(const oracle *o, double *mass, double com[3]);
/** Kinetic energy (rotors included) and potential energy of gravity, J. */
void oracle_energy(oracle *o, double *kinetic, double *potential);
/** Position of the link frame (3) and its rotation matrix (row major) in the world. */
void oracle_pose(const oracle *o, uint32_t link, double position[3], double rotation[9]);

#endif
