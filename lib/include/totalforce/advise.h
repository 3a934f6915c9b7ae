/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * An adviser for scenes: which joints may be locked, by states that a robot is in, and the error of
 * its accelerations for that. Not for a request's path: it allocates, and solves many times.
 */
#ifndef TOTALFORCE_ADVISE_H
#define TOTALFORCE_ADVISE_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Zero-initialise; release with tfa_advice_free. */
typedef struct tfa_advice {
    uint32_t count;       /**< joints that may be locked together */
    uint32_t freedoms;    /**< of these: absent from v, tau and qdd of the scene */
    uint32_t *joints;     /**< count: their indices, the smallest bound alone first */
    double *q;            /**< q_count of the model: where each joint would be locked, rad or m */
    double *single_error; /**< joint_count of the model: the bound with that joint alone locked */
    double error;         /**< the bound with all of them locked: the largest over the states */
    uint32_t state;       /**< the state that has it */
} tfa_advice;

/**
 * Chooses joints that a scene may lock without changing accelerations by more than `tolerance` in
 * any of the given states.
 *
 * With x the accelerations of the robot and y those of the scene, 0 for its locked joints, the
 * error is |x - y|_M / |x|_M, |a|_M^2 = a^T M a, base included: the deviation that Gauss' principle
 * of least constraint minimises. M (x - y) = -r with r = M y + h - tau of the whole robot, so that
 * |x - y|_M^2 = r^T M^-1 r, by one inverse and one forward dynamics. The bound is 0.1 % above that,
 * and by the rounding of these answers, 64 eps (|x|_M + |M^-1 tau|_M) for each body: it is never
 * below the error. A scene has its locked joints at rest in one place, so the bound counts their
 * velocity and their distance from there as well.
 *
 * A joint is locked in the middle of the range that it has in the states (planar and floating
 * joints: where it is in the first). Joints are tried in the order of their bounds alone, and one
 * that brings the bound of all above `tolerance` stays free. A fixed base keeps one joint free.
 *
 * The scene is to be compiled with the options of the model; of a model with TFA_MIMIC_LOCK joints
 * that lead others are not to be locked: its followers would stand elsewhere then.
 *
 * @param states     count, q, v, tau, base_*, gravity, wrenches and payloads of forward dynamics;
 *                   the rest is not read
 * @param tolerance  largest error, above 0
 * @param reply      status, field, index and state of a bad request, as tfa_compute
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, a tolerance that is not positive); TFA_E_UNSUPPORTED
 *         (projected mimic joints that move no mass of their own); TFA_E_MEMORY; what tfa_compute
 *         returns for the states. Cost: 6 solves for each joint and state.
 */
TFA_API TFA_CHECKED int tfa_advise(const tfa_model *model, const tfa_request *states,
                                   double tolerance, tfa_advice *advice, tfa_reply *reply);

/** Releases what tfa_advise allocated. */
TFA_API void tfa_advice_free(tfa_advice *advice);

#ifdef __cplusplus
}
#endif
#endif
