/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Adviser for scenes: chooses joints that may be locked, from given states of the robot, and bounds
 * the error of the accelerations. It allocates and solves many times: not for a control cycle.
 */
#ifndef TOTALFORCE_ADVISE_H
#define TOTALFORCE_ADVISE_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Result of tfa_advise. Errors are relative, in the energy norm (see tfa_advise). Release with
 *  tfa_advice_free. */
typedef struct tfa_advice {
    uint32_t count;       /**< joints that may be locked together */
    uint32_t freedoms;    /**< their freedoms, which the scene lacks in v, tau and qdd */
    uint32_t *joints;     /**< count public joint indices, in ascending order of single_error */
    double *q;            /**< q_count: position at which each joint would be locked, rad or m */
    double *single_error; /**< joint_count: error bound with that joint alone locked */
    double error;         /**< error bound with all `joints` locked: the largest over the states */
    uint32_t state;       /**< index of the state with that error */
} tfa_advice;

/**
 * Chooses joints that a scene may lock without changing accelerations by more than `tolerance` in
 * any of the given states.
 *
 * With x the accelerations of the robot and y those of the scene (0 for locked joints), the error
 * is |x - y|_M / |x|_M with |a|_M^2 = a^T M a, base included. This is the deviation that Gauss'
 * principle of least constraint minimises (Gauss 1829; Udwadia and Kalaba, Analytical Dynamics,
 * 1996). With the residual r = M y + h - tau of the whole robot, M (x - y) = -r, so
 * |x - y|_M^2 = r^T M^-1 r: one inverse and one forward dynamics. The bound adds 0.1 % and the
 * rounding of these answers, 64 eps (|x|_M + |M^-1 tau|_M) for each body: it is never below the
 * error. A scene keeps a locked joint at rest at one position, so the bound includes its velocity
 * and its distance from that position.
 *
 * A joint is locked in the middle of the range of its positions in the states; planar and floating
 * joints at their position in the first state. Joints are tried in ascending order of single_error;
 * a joint that lifts the common bound above `tolerance` stays free. With a fixed base at least one
 * joint stays free.
 *
 * Compile the scene with the options of the model. With TFA_MIMIC_LOCK do not lock a joint that
 * leads others: its followers would be fixed at another position.
 *
 * Cost: 6 solves for each joint and state. Allocates. Any thread; one call for each advice.
 *
 * @param model      of the whole robot
 * @param states     forward dynamics; read: count, q, v, tau, base_*, gravity, wrenches, payloads
 * @param tolerance  largest error, above 0
 * @param advice     is overwritten; all zero after an error
 * @param reply      status, field, index and state of an invalid request, as tfa_compute
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or a tolerance that is not positive and finite);
 *         TFA_E_UNSUPPORTED (projected mimic joints that move no mass of their own, flexible
 *         links); TFA_E_MEMORY;
 *         the status of tfa_compute for the states.
 */
TFA_API TFA_CHECKED int tfa_advise(const tfa_model *model, const tfa_request *states,
                                   double tolerance, tfa_advice *advice, tfa_reply *reply);

/** Releases the arrays of an advice and sets it to zero. `advice` may not be NULL. */
TFA_API void tfa_advice_free(tfa_advice *advice);

#ifdef __cplusplus
}
#endif
#endif
