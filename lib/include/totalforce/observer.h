/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Generalised-momentum observer: joint torques that nothing in the model explains, such as those
 * of a collision or of a contact (De Luca, Albu-Schaeffer, Haddadin, Hirzinger 2006).
 *
 *     dr/dt = gain (tau_ext - r),    tau_ext = dp/dt - tau - momentum_rate,   p = M v
 *
 * A first-order filter with the time constant 1 / gain, without accelerations. Between two samples
 * dt apart it is exact for an external torque that is constant between them:
 *
 *     r <- r + (1 - exp(-gain dt)) ((p - p_before) / dt - u - r),    u: mean of tau + momentum_rate
 *
 * whose error of the mean (trapezoidal rule) is O(dt^2). Nothing is integrated over more than one
 * step: errors do not add up, and samples may be irregular.
 *
 * The observer asks questions of its own; whichever door answers them - tfa_compute, or
 * tfa_client_call to a daemon - decides the robot:
 *
 *     tfa_observer_request(observer, &request, &reply);     then q, v, base_pose, payloads, ...
 *     tfa_compute(workspace, &request, &reply);
 *     event = tfa_observer_update(observer, time, tau, NULL, &reply);
 *     r = tfa_observer_torques(observer);
 *
 * No function allocates but create, none locks or makes a system call. Deterministic. Thread rule:
 * one call for each observer at a time.
 */
#ifndef TOTALFORCE_OBSERVER_H
#define TOTALFORCE_OBSERVER_H

#include <totalforce/request.h>

#ifdef __cplusplus
extern "C" {
#endif

/** State of one robot's observer. */
typedef struct tfa_observer tfa_observer;

/** Zero-initialise, then set the gain. */
typedef struct tfa_observer_options {
    double gain;    /**< 1/s, above 0: the inverse of the time constant */
    double max_gap; /**< s: samples further apart than this restart it; 0: 5 / gain */
} tfa_observer_options;

/** What a sample did. All but UPDATED restart the observer: r is 0, and the next sample is the
 *  first to be compared. */
typedef enum tfa_observer_event {
    TFA_OBSERVER_UPDATED = 0, /**< r is new */
    TFA_OBSERVER_STARTED = 1, /**< the first sample, or the one after INVALID */
    TFA_OBSERVER_GAP = 2,     /**< more than max_gap after the one before */
    TFA_OBSERVER_TIME = 3,    /**< not later than the one before */
    TFA_OBSERVER_MODEL = 4,   /**< answered by another model (tfa_reply.model): a swap, or the
                                   takeover by a standby with other settings */
    TFA_OBSERVER_INVALID = 5, /**< the reply has no answer, or time or tau are not finite; the
                                   sample is not kept */
} tfa_observer_event;
/** Their words: X(value, word) */
#define TFA_OBSERVER_WORDS(X)                                                                      \
    X(TFA_OBSERVER_UPDATED, "updated")                                                             \
    X(TFA_OBSERVER_STARTED, "started")                                                             \
    X(TFA_OBSERVER_GAP, "gap")                                                                     \
    X(TFA_OBSERVER_TIME, "time")                                                                   \
    X(TFA_OBSERVER_MODEL, "model")                                                                 \
    X(TFA_OBSERVER_INVALID, "invalid")

/**
 * Creates an observer that has seen nothing.
 *
 * @param base_freedoms  6 with a floating base, else 0
 * @param v_count        freedoms of the joints
 * @param options        gain and gap
 * @param observer       release with tfa_observer_free; NULL on error
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, other base freedoms); TFA_E_VALUE (gain not above 0 or
 *         not finite, max_gap negative or not finite); TFA_E_MEMORY
 */
TFA_API TFA_CHECKED int tfa_observer_create(uint32_t base_freedoms, uint32_t v_count,
                                            const tfa_observer_options *options,
                                            tfa_observer **observer);
/** Releases it. NULL is allowed. */
TFA_API void tfa_observer_free(tfa_observer *observer);

/** Fills both with the question of the next sample (kinematics, generalised_momentum); buffers of
 *  the reply are the observer's. The caller adds q, v, and where there are such base_pose,
 *  base_twist, gravity, payloads, known wrenches. */
TFA_API void tfa_observer_request(tfa_observer *observer, tfa_request *request, tfa_reply *reply);

/**
 * Takes a sample: q and v of the answered request, torques of the same time.
 *
 * @param observer     its state
 * @param time         s, of any clock that does not jump
 * @param tau          v_count, N m or N, as measured or commanded; NULL: 0
 * @param base_wrench  6, N and N m, root link's frame; NULL: 0
 * @param reply        answer to the request
 * @return what the sample did
 */
TFA_API tfa_observer_event tfa_observer_update(tfa_observer *observer, double time,
                                               const double *tau, const double *base_wrench,
                                               const tfa_reply *reply);

/** r: base freedoms (N, N m, root link's frame), then v_count numbers (N m or N). 0 after a
 *  restart. Valid until the next update. */
TFA_API const double *tfa_observer_torques(const tfa_observer *observer);

/** Forgets all samples: the next one starts it. */
TFA_API void tfa_observer_restart(tfa_observer *observer);

/**
 * Fills both with the question which wrench at one tip explains r (forward_dynamics with r for tau,
 * at rest, without gravity); the caller adds q, base_pose, payloads and, if it is not
 * LOCAL_WORLD_ALIGNED, frame.
 */
TFA_API void tfa_observer_wrench_request(tfa_observer *observer, uint32_t tip, tfa_request *request,
                                         tfa_reply *reply);

/**
 * The wrench on the robot at the tip, N and N m, that explains r by the dynamically consistent
 * inverse: F = Lambda J M^-1 r, for r = J^T F exactly F where the tip has full rank (Khatib 1987).
 * Directions that are lost: reply->rank->lost of them, by the request's rank_loss.
 * @return TFA_OK; the reply's status without an answer, and F is NaN
 */
TFA_API TFA_CHECKED int tfa_observer_wrench(const tfa_observer *observer, const tfa_reply *reply,
                                            double wrench[6]);

#ifdef __cplusplus
}
#endif
#endif
