/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Closing loops: from measured joints to a posture and velocities that meet the constraints.
 *
 * Newton iterations on the held rows, of which each is one impact (op 11) of a robot at rest with
 * the gains {1, 0} and the measured joints locked:
 *
 *     J_c dq = - error,   (dq, M dq) least
 *
 * Errors of position are those of tfa_reply.constraint_position, of rotations to first order, so
 * that the error squares with each iteration near a solution. Then one impact ends the velocities
 * that the constraints do not admit.
 */
#ifndef TOTALFORCE_CLOSE_LOOPS_H
#define TOTALFORCE_CLOSE_LOOPS_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_LOOP_ITERATIONS 50   /**< default of tfa_loop_options.iterations */
#define TFA_LOOP_TOLERANCE 1e-10 /**< default of tfa_loop_options.tolerance */
/** tfa_request.rank_threshold where the request has none. Steps that are too long for the equations
 *  are halved, so that near singular directions may count. */
#define TFA_LOOP_RANK_THRESHOLD 1e-12

/** Zero-initialise for the defaults. */
typedef struct tfa_loop_options {
    uint32_t iterations;   /**< at most; 0: TFA_LOOP_ITERATIONS */
    uint32_t base_is_free; /**< 1: a floating base moves with the joints that are not measured;
                                0: its pose and twist are measured */
    double tolerance;      /**< largest error of a held row, m and rad, of velocities m/s and rad/s;
                                0: TFA_LOOP_TOLERANCE */
} tfa_loop_options;

/** What tfa_close_loops finds. The caller provides the buffers, which may be the arrays of the
 *  request. */
typedef struct tfa_posture {
    int32_t status;      /**< as returned */
    tfa_field field;     /**< invalid input; TFA_FIELD_CONSTRAINTS with TFA_E_OPEN */
    uint32_t index;      /**< in that field; with TFA_E_OPEN the constraint with the largest error,
                              as in the model */
    uint32_t iterations; /**< steps of the posture, those that were halved included */
    uint32_t rank;       /**< of the held rows, by the joints that are free */
    uint32_t lost;       /**< held rows less the rank: redundant, or out of reach */
    double position;     /**< largest error of a held row, m or rad; pi: a rotation is met half a
                              turn away */
    double velocity;     /**< the same of velocities, m/s or rad/s; 0 without v */
    double *q;           /**< q_count; required */
    double *base_pose;   /**< 7; required with a floating base */
    double *v;           /**< v_count; NULL: no velocities */
    double *base_twist;  /**< 6; required with v and a floating base */
} tfa_posture;

/**
 * Closes the active constraints of a request.
 *
 * Of the request it reads one state: `q`, `v`, `base_pose`, `base_twist`; `constraints`; `locked`,
 * the measured joints, which keep their q and v; `method`, and `rank_loss`, `rank_threshold` and
 * `characteristic_length` as impact. Of joints that are not measured q and v are where the search
 * begins: the posture is near that start, and v nearest to the given one by kinetic energy. A
 * measured floating base is held by a mass that the robot cannot move.
 *
 * An iteration turns no joint by more than 0.5 rad. Where the sum of squared errors does not fall,
 * the step is halved, up to 8 times. Bounds of joints are not known. A start that is off by more
 * than a quarter turn may end half a turn away, which is TFA_E_OPEN.
 *
 * No allocation, no lock, no system call. Cost: one impact for each iteration and one more, and two
 * or three for velocities. Thread rule: that of tfa_compute.
 *
 * @param workspace  of the robot, with memory for the tips of the constraints
 * @param request    valid as for tfa_compute of an impact
 * @param options    NULL: all defaults
 * @param posture    what is found
 * @return posture->status:
 *   TFA_OK      both errors are within the tolerance;
 *   TFA_E_OPEN  the posture or its velocities are the best that were found, but do not meet the
 *               constraints: loops that these measured joints leave open, or no way there from this
 *               start;
 *   TFA_E_ARGUMENT  a required pointer is NULL, or a fixed base is to be free
 *               (TFA_FIELD_BASE_POSE);
 *   others      as tfa_compute of an impact; without answers in `posture`
 */
TFA_API TFA_CHECKED int tfa_close_loops(tfa_workspace *workspace, const tfa_request *request,
                                        const tfa_loop_options *options, tfa_posture *posture);

#ifdef __cplusplus
}
#endif
#endif
