/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies: what tfa_compute reads and writes, whichever way a request comes.
 *
 * Six-vectors are linear first, angular second; quaternions x y z w; matrices row major; SI units.
 * Coordinates and frames: docs/conventions.md.
 */
#ifndef TOTALFORCE_REQUEST_H
#define TOTALFORCE_REQUEST_H

#include <stdint.h>
#include <totalforce/method.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_MAX_TIPS 32    /**< tips of one request */
#define TFA_DEFAULT_TIPS 8 /**< tips that a workspace and a connection have memory for by default */
#define TFA_MAX_WRENCHES 8 /**< external wrenches of one request */
#define TFA_MAX_PAYLOADS 4 /**< payloads of one request */
#define TFA_PAYLOAD_NUMBERS 10 /**< mass, centre of mass (3), inertia (6) as in tfa_payload */
#define TFA_LINK_PARAMETERS 10 /**< of a link in a regressor (tfa_model_parameters) */
#define TFA_JOINT_PARAMETERS 3 /**< of a freedom in joint_regressor */

/**
 * Policy for error estimates. The estimate of an answer x is |dx| / |x| with the larger of two more
 * corrections dx = solve(tau - RNEA(x)), not applied: of a plain residual, and of one perturbed by
 * a few roundings. The sentinel of aba bounds the rounding error by eps max G_i / D_i, with D_i the
 * projected articulated inertia of joint i and G_i the size of the numbers whose difference it is
 * (docs/methods.md); cost: about six operations for each body.
 */
typedef enum tfa_estimate {
    TFA_ESTIMATE_DEFAULT = 0, /**< methods with TFA_REFUSES_NO_INVERSE: every answer; but qdd by
                                   tfa-cr and cfa-cr over segments as others. Others: if the
                                   sentinel exceeds 1e-9 (f32: 3e-4) or a D_i is not positive; the
                                   answer is then estimated, by default refined once if its estimate
                                   exceeds 1e-7, and falls back if the estimate is too large
                                   (TFA_ANSWER_SENTINEL); and if a step of
                                   `refine` shows an error of 1e-4, or does not converge */
    TFA_ESTIMATE_NEVER = 1,   /**< the method's own answer, refined if asked, also where a step made
                                   it worse: no sentinel, no estimate, no fallback */
    TFA_ESTIMATE_ALWAYS = 2,  /**< every answer */
} tfa_estimate;
/** Their words: X(value, word) */
#define TFA_ESTIMATE_WORDS(X)                                                                      \
    X(TFA_ESTIMATE_DEFAULT, "default")                                                             \
    X(TFA_ESTIMATE_NEVER, "never")                                                                 \
    X(TFA_ESTIMATE_ALWAYS, "always")

/** Frame of everything at a link: wrenches, lambda_inv, Jacobians, twists, accelerations. */
typedef enum tfa_reference_frame {
    TFA_FRAME_LOCAL_WORLD_ALIGNED = 0, /**< at the link frame's origin, axes of the world */
    TFA_FRAME_LOCAL = 1,               /**< at the link frame's origin, axes of the link */
    TFA_FRAME_WORLD = 2,               /**< at the world origin, axes of the world */
} tfa_reference_frame;
/** Their words: X(value, word) */
#define TFA_FRAME_WORDS(X)                                                                         \
    X(TFA_FRAME_LOCAL_WORLD_ALIGNED, "local_world_aligned")                                        \
    X(TFA_FRAME_LOCAL, "local")                                                                    \
    X(TFA_FRAME_WORLD, "world")

/** Rows of every tip in lambda_inv and all that is derived from it. */
typedef enum tfa_rows {
    TFA_ROWS_POSE = 0,  /**< six: linear, then angular */
    TFA_ROWS_POINT = 1, /**< three: linear only, as for a contact point */
} tfa_rows;
/** Their words: X(value, word) */
#define TFA_ROWS_WORDS(X)                                                                          \
    X(TFA_ROWS_POSE, "pose")                                                                       \
    X(TFA_ROWS_POINT, "point")

/**
 * Policy of lambda, mu, p and task torques near a singularity. In the metric of the tips, that is
 * about each tip's point and with a radian counted as `characteristic_length` metres,
 * lambda_inv = V diag(d) V^T; d above a threshold t is always inverted to 1/d. Up to t, instead:
 */
typedef enum tfa_rank_loss {
    TFA_RANK_DEFAULT = 0,  /**< damp with task torques and constraints, otherwise truncate */
    TFA_RANK_TRUNCATE = 1, /**< 0: the pseudoinverse (Moore-Penrose), which jumps at t */
    TFA_RANK_DAMP = 2,     /**< d/t^2: damped least squares by direction, with the damping
                                t^2 - d^2, continuous at d = t (Nakamura and Hanafusa 1986;
                                Chiaverini 1997) */
    TFA_RANK_REFUSE = 3,   /**< TFA_E_RANK */
} tfa_rank_loss;
/** Their words: X(value, word) */
#define TFA_RANK_LOSS_WORDS(X)                                                                     \
    X(TFA_RANK_DEFAULT, "default")                                                                 \
    X(TFA_RANK_TRUNCATE, "truncate")                                                               \
    X(TFA_RANK_DAMP, "damp")                                                                       \
    X(TFA_RANK_REFUSE, "refuse")

/** Rounding of n singular values sqrt(d), relative to the root of the sum of d. */
#define TFA_RANK_ROUNDING(n) (16 * 0x1p-52 * (n))
/** Default thresholds t, relative to the sum of all d. */
#define TFA_RANK_THRESHOLD(n) (TFA_RANK_ROUNDING(n) * TFA_RANK_ROUNDING(n)) /**< truncate, refuse */
#define TFA_RANK_THRESHOLD_DAMP 1e-6                                        /**< damp */

/** Arithmetic of the factors. */
typedef enum tfa_precision {
    TFA_F64 = 0,  /**< double */
    TFA_F128 = 1, /**< quadruple precision, about 100 times slower: a reference */
    TFA_F32 = 2,  /**< float: forward and inverse dynamics and M, without tips, by all methods but
                       hessenberg, scan and scan-two-pass; double computes everything else, with
                       TFA_ANSWER_RESIDUAL_PRECISION */
} tfa_precision;
/** Their words: X(value, word) */
#define TFA_PRECISION_WORDS(X)                                                                     \
    X(TFA_F64, "f64")                                                                              \
    X(TFA_F128, "f128")                                                                            \
    X(TFA_F32, "f32")

/**
 * Arithmetic of refinement residuals and of the sum of the corrections. If it differs from that of
 * the factors, it also computes everything that is no solution with factors: inverse dynamics, M,
 * poses and lambda_inv (with forward dynamics by the method of auto).
 */
typedef enum tfa_residual {
    TFA_RESIDUAL_SAME = 0, /**< that of the factors */
    TFA_RESIDUAL_F64 = 1,  /**< double, with factors in float */
    TFA_RESIDUAL_F128 = 2, /**< quadruple precision, with factors in double or float */
} tfa_residual;
/** Their words: X(value, word) */
#define TFA_RESIDUAL_WORDS(X)                                                                      \
    X(TFA_RESIDUAL_SAME, "same")                                                                   \
    X(TFA_RESIDUAL_F64, "f64")                                                                     \
    X(TFA_RESIDUAL_F128, "f128")

#define TFA_MAX_REFINE 3 /**< refinement steps of one request */
/** Default number of refinement steps: 1 for methods that invert body inertias, 0 for others and
 *  for qdd by tfa-cr and cfa-cr over segments; with
 *  a residual in higher precision as many as needed, up to 3 for float and 2 for double factors. */
#define TFA_REFINE_DEFAULT UINT32_MAX

/* Flags of a request: answers besides those of any op. In tip answers, r is the number of rows. */
#define TFA_WANT_SPECTRUM 0x1u           /**< spectrum, with ops that answer lambda_inv */
#define TFA_WANT_POSES 0x2u              /**< poses of the tips */
#define TFA_WANT_FRAME_POSES 0x4u        /**< frame_poses: of all frames */
#define TFA_WANT_TWISTS 0x8u             /**< twists of the tips; reads v */
#define TFA_WANT_JACOBIAN 0x10u          /**< jacobian of the tips */
#define TFA_WANT_BIAS_ACCELERATION 0x20u /**< bias_acceleration of the tips; reads v */
#define TFA_WANT_COM 0x40u               /**< com, com_velocity, com_jacobian, mass; reads v */
#define TFA_WANT_MOMENTUM 0x80u          /**< momentum; reads v */
#define TFA_WANT_ENERGY 0x100u           /**< energy; reads v and gravity */
#define TFA_WANT_LAMBDA 0x200u           /**< lambda and rank, with ops that answer lambda_inv */
#define TFA_WANT_MU 0x400u               /**< mu and what lambda answers; reads v and gravity */
#define TFA_WANT_P 0x800u                /**< p and what lambda answers; reads gravity */
#define TFA_WANT_JOINT_FORCES 0x1000u    /**< joint_forces, with forward and inverse dynamics */
#define TFA_WANT_DELASSUS 0x2000u        /**< delassus, with constrained_dynamics and impact */
#define TFA_WANT_GENERALISED_MOMENTUM                                                              \
    0x4000u                  /**< generalised_momentum, momentum_rate; reads v, gravity, wrenches */
#define TFA_WANT_ALL 0x7fffu /**< every flag */

/**
 * One request. Zero-initialise, then set the inputs of the op. An array holds `count` states one
 * after the other; NULL where allowed. Arrays that the op does not use are not read.
 */
typedef struct tfa_request {
    tfa_op op;                   /**< operation */
    tfa_method method;           /**< one that answers the op; 0: TFA_METHOD_AUTO */
    tfa_estimate estimate;       /**< policy for error estimates */
    tfa_reference_frame frame;   /**< of wrenches and lambda_inv */
    uint32_t refine;             /**< refinement steps, 0..TFA_MAX_REFINE or TFA_REFINE_DEFAULT */
    uint32_t flags;              /**< TFA_WANT_ bits */
    uint32_t count;              /**< states, at least 1 */
    uint32_t tip_count;          /**< m: 0..TFA_MAX_TIPS */
    uint32_t wrench_count;       /**< 0..TFA_MAX_WRENCHES */
    uint32_t payload_count;      /**< 0..TFA_MAX_PAYLOADS, in addition to those of the model */
    uint32_t locked_count;       /**< joints locked for this request, at most joint_count */
    tfa_rows rows;               /**< of every tip */
    tfa_rank_loss rank_loss;     /**< of lambda, task torques and constraints */
    uint32_t constraints;        /**< active ones: bits of tfa_model_constraint (ops of
                                      TFA_OPS_CONSTRAINED); each of their frames on a link takes
                                      one of the workspace's max_tips */
    uint32_t tips[TFA_MAX_TIPS]; /**< frame indices */
    uint32_t wrench_frames[TFA_MAX_WRENCHES];  /**< frame indices */
    uint32_t payload_frames[TFA_MAX_PAYLOADS]; /**< frame indices */
    const uint32_t *locked; /**< public joint indices, for every state: qdd is exactly 0, their v
                                 (normally 0) is used, lambda_inv is that of the robot with them
                                 fixed, Jacobians are not. The mass matrix refuses it */

    const double *q;                 /**< count x q_count, rad or m */
    const double *v;                 /**< count x v_count, rad/s or m/s; NULL: at rest */
    const double *tau;               /**< count x v_count, N m or N (forward, derivatives; task
                                          torques: posture torques); NULL: zero */
    const double *qdd;               /**< count x v_count, rad/s^2 or m/s^2 (inverse, bias); NULL:
                                          zero */
    const double *base_pose;         /**< count x 7, world frame: x y z (m), quaternion x y z w;
                                          required with a floating base */
    const double *base_twist;        /**< count x 6, m/s and rad/s, in the root link's frame, at its
                                          origin; NULL: zero */
    const double *base_wrench;       /**< count x 6, N and N m, the same frame (as tau); NULL: 0 */
    const double *base_acceleration; /**< count x 6, m/s^2 and rad/s^2, derivatives of the
                                          components of base_twist (inverse); NULL: zero */
    const double *gravity;           /**< 3, m/s^2, world frame; NULL: that of the model */
    const double *wrenches; /**< count x wrench_count x 6, N and N m, exerted on the robot, in
                                 `frame` of their links */
    const double *task_acceleration; /**< count x r m, m/s^2 and rad/s^2: desired accelerations of
                                          the tips (task torques), as J qdd + bias_acceleration */
    const double
        *constraint_acceleration; /**< count x 6 c, m/s^2 and rad/s^2: wanted dw/dt of the c
                                       active constraints, of which the held rows are read; NULL:
                                       zero */
    const double
        *stabilisation; /**< 2, 1/s^2 and 1/s, not negative: gains of the errors of position
                                       and velocity (Baumgarte 1972), k0 and k1 of
                                       dw/dt = wanted - k0 position - k1 w; of impact k0 in 1/s,
                                       w = - k0 position after it; NULL: zero */
    const double *torque_weights;    /**< v_count, above 0: weights of squared torques
                                       (constrained_inverse_dynamics); NULL: 1 */
    const double *rank_threshold;    /**< 1, relative to the sum of the eigenvalues d, above 0 and
                                       below 1; NULL: TFA_RANK_THRESHOLD_DAMP where directions are
                                       damped, else TFA_RANK_THRESHOLD */
    const double *characteristic_length; /**< 1, m, above 0: what a radian of a tip counts beside a
                                       metre; NULL: tfa_model_characteristic_length */
    const double *payloads; /**< payload_count x TFA_PAYLOAD_NUMBERS, for every state: mass (kg),
                                 com (m), inertia (kg m^2) as in tfa_payload */
    const double *modes;    /**< count x mode_count, modal coordinates eta; NULL: 0 */
    const double *mode_velocities; /**< count x mode_count, 1/s: their rates; NULL: 0 */
} tfa_request;

/* Flags of an answer */
#define TFA_ANSWER_ESTIMATED 1u   /**< error_estimate was computed for this state */
#define TFA_ANSWER_FALLBACK 2u    /**< the requested method failed; `method` answered. Reason: */
#define TFA_ANSWER_INACCURATE 8u  /**< the estimate was above 1e-4 */
#define TFA_ANSWER_STALLED                                                                         \
    16u                           /**< a refinement step did not shrink the correction tenfold; or
                                       forces at the cuts of a chain have no digits, or took too
                                       many iterations (hybrid, tfa-cr, cfa-cr): replaced also
                                       with TFA_ESTIMATE_NEVER */
#define TFA_ANSWER_NOT_FINITE 32u /**< the method's answer was not finite */
/** Computed in higher precision than that of the factors: that of the residual, or double in place
 *  of float. With TFA_ANSWER_FALLBACK by the method of auto, because the estimate stayed too large;
 *  without it by the requested method, which the lower precision lacks or refused, or for which
 *  float by itself has too few digits. */
#define TFA_ANSWER_RESIDUAL_PRECISION 64u
/** The sentinel tripped (TFA_ESTIMATE_DEFAULT), so the estimate was computed; of derivatives: those
 *  by q and v may have lost digits, and there is no estimate (unless TFA_ESTIMATE_NEVER). */
#define TFA_ANSWER_SENTINEL 128u
/** Directions of the tips are at or below the threshold of rank_loss: they were damped or cut off,
 *  see tfa_rank and tfa_reply.lost. */
#define TFA_ANSWER_RANK_LOSS 256u
/** A unilateral constraint would have to pull: its force along z of the first frame is below 0. */
#define TFA_ANSWER_PULLS 1024u
/** A modal coordinate exceeds the limit of its mode: the answer is that of the modes beyond it. */
#define TFA_ANSWER_MODE_LIMIT 512u

/** Quality of the answer for one state. */
typedef struct tfa_answer {
    int32_t status;        /**< TFA_OK, TFA_E_SINGULAR or TFA_E_NOT_COMPUTED, as tfa_compute */
    uint16_t method;       /**< tfa_method that answered; cfa-cr and tfa-cr are one computation on
                              chains of 48 and more revolute joints without armature */
    uint16_t flags;        /**< TFA_ANSWER_ bits */
    double error_estimate; /**< relative 2-norm error of qdd (base included; task torques: that of
                                the posture torques, constraints: without their forces, to which
                                tfa_rank.error_estimate adds theirs; derivatives: where they are
                                taken) or lambda_inv; NaN if not computed. That of lambda, mu, p
                                and task torques: tfa_rank.error_estimate */
} tfa_answer;

/**
 * Rank and extreme eigenvalues of lambda_inv: Householder tridiagonalisation (Golub and Van Loan,
 * Matrix Computations, 8.3.1), which ends at the rank, and multisection by Sturm counts (Parlett,
 * The Symmetric Eigenvalue Problem, 3.3). Backward stable: the error is absolute, so that an
 * eigenvalue below it has no certain digit or sign. Cost: at most 4/3 (6m)^3 operations and 24 x 6m
 * divisions one after the other; no iteration can fail to converge.
 */
typedef struct tfa_spectrum {
    uint32_t rank;    /**< eigenvalues above 6m x 64 eps x the largest */
    uint32_t padding; /**< 0 */
    double eig_min;   /**< smallest eigenvalue, as eig_max */
    double eig_max;   /**< absolute error 12 m eps eig_max; units mixed, depend on `frame`.
                                  If lambda_inv is not finite: NaN, and rank 0 */
} tfa_spectrum;

/**
 * Rank of the tips as lambda, mu, p and task torques used it. They come from factors of
 * B = D^-1/2 L^-1 J^T, M = L D L^T of the articulated bodies (with mimics of T^T M T), for every
 * method: lambda_inv = B^T B is not formed, so that errors grow with the condition of B, the root
 * of `condition`. Pivoted Gram-Schmidt, and one-sided Jacobi rotations where directions are near
 * the threshold.
 */
typedef struct tfa_rank {
    uint32_t rank;         /**< eigenvalues d above the threshold */
    uint32_t lost;         /**< directions at or below it: rm - rank */
    double threshold;      /**< t: rank_threshold times the sum of all d, 1/kg */
    double condition;      /**< sum of d times sum of 1/d, but of those that are rounding
                                (TFA_RANK_THRESHOLD); infinite if there is none */
    double length;         /**< characteristic length, m */
    double error_estimate; /**< relative 2-norm error of lambda, mu, p, of the task's forces and of
                                the accelerations that they reach, in the metric of the tips: the
                                rounding of B; with TFA_ANSWER_ESTIMATED the error of the factors
                                of M, too, by a refined solution */
} tfa_rank;

/** Most directions in `lost` of a reply */
#define TFA_LOST_MAX 6

/** Input that a failed request is about; with `index` it names the invalid entry. */
typedef enum tfa_field {
    TFA_FIELD_NONE = 0,
    TFA_FIELD_OP,
    TFA_FIELD_METHOD,
    TFA_FIELD_COUNT,
    TFA_FIELD_TIPS,
    TFA_FIELD_WRENCHES,
    TFA_FIELD_Q,
    TFA_FIELD_V,
    TFA_FIELD_TAU,
    TFA_FIELD_QDD,
    TFA_FIELD_BASE_POSE,
    TFA_FIELD_BASE_TWIST,
    TFA_FIELD_BASE_WRENCH,
    TFA_FIELD_BASE_ACCELERATION,
    TFA_FIELD_GRAVITY,
    TFA_FIELD_REFINE,
    TFA_FIELD_FRAME,
    TFA_FIELD_ESTIMATE,
    TFA_FIELD_LOCKED,
    TFA_FIELD_PAYLOADS,
    TFA_FIELD_ROWS,
    TFA_FIELD_RANK_LOSS,
    TFA_FIELD_RANK_THRESHOLD,
    TFA_FIELD_CHARACTERISTIC_LENGTH,
    TFA_FIELD_TASK_ACCELERATION,
    TFA_FIELD_FLAGS,
    TFA_FIELD_MODES,
    TFA_FIELD_MODE_VELOCITIES,
    TFA_FIELD_BODY, /**< singular inertia: `index` is the frame of the link that names the body */
    TFA_FIELD_COST, /**< a daemon refuses it (max_state_us): a state of this kind takes `index` us,
                         `state` us are the most */
    TFA_FIELD_CONSTRAINTS, /**< active ones; of a limit `index` is the number */
    TFA_FIELD_CONSTRAINT_ACCELERATION,
    TFA_FIELD_STABILISATION,
    TFA_FIELD_TORQUE_WEIGHTS,
} tfa_field;

/** Name of a field in JSON: "q", "base_pose", ...; "" for any other number. Static storage. Any
 *  thread. */
TFA_API const char *tfa_field_name(tfa_field field);

/** Field of a floating base that goes with a field of the joints, both by name: "base_pose" for
 *  "q", "base_twist" for "v", "base_wrench" for "tau" and "posture_torques", "base_acceleration"
 *  for "qdd"; "" for any other. Static storage. Any thread. */
TFA_API const char *tfa_base_field_name(const char *joint_field);

/**
 * One reply. The caller provides the buffers; NULL: that answer is not wanted. n = base freedoms +
 * v_count, the base first; r = 6 or 3 rows for each of m tips, in the order of the request.
 *
 *     tip: twist = J v,   acceleration = J qdd + bias_acceleration
 *     Lambda (J qdd + bias_acceleration) + mu + p = F   for   tau = J^T F
 *     tau_inverse = M qdd + gravity + velocity + damping + friction + external
 *                 = regressor p + armature + damping + friction + external
 *     d(generalised_momentum)/dt = tau + momentum_rate
 *
 * (Khatib 1987; Featherstone 2008, 8.4.) Accelerations of tips are time derivatives of the
 * components of their twists in `frame`: with LOCAL_WORLD_ALIGNED that of the point and of the
 * angular velocity.
 */
typedef struct tfa_reply {
    int32_t status;            /**< of the request: that of the first state that failed */
    tfa_field field;           /**< invalid input of a failed request */
    uint32_t index;            /**< index in that field, within one state; or a frame index */
    uint32_t state;            /**< index of the state that failed */
    uint64_t model;            /**< tfa_model_tag of the model that answered */
    double *qdd;               /**< count x v_count, rad/s^2 or m/s^2 */
    double *base_acceleration; /**< count x 6, m/s^2 and rad/s^2: time derivatives of the components
                                    of base_twist */
    double *tau;               /**< count x v_count, N m or N (inverse dynamics, task torques) */
    double *base_wrench;       /**< count x 6, N and N m, root link's frame (the same) */
    double *lambda_inv;        /**< count x rm x rm (forward dynamics, operational inertia, task
                                    torques) */
    double *mass_matrix;       /**< count x n x n */
    tfa_spectrum *spectrum;    /**< count, with TFA_WANT_SPECTRUM and a buffer lambda_inv */
    double *poses;             /**< count x m x 7, with TFA_WANT_POSES: x y z (m), quaternion
                                    x y z w (w >= 0) of the tip's link frame in the world */
    double *frame_poses;       /**< count x frames x 7, as poses, of every frame of the model */
    double *twists;            /**< count x m x 6, m/s and rad/s, in `frame` */
    double *jacobian;          /**< count x rm x n */
    double *bias_acceleration; /**< count x rm, m/s^2 and rad/s^2: J-dot v */
    double *com;               /**< count x 3, m, world: centre of mass of all bodies that move,
                                    payloads included */
    double *com_velocity;      /**< count x 3, m/s, world */
    double *com_jacobian;      /**< count x 3 x n, world: com_velocity = com_jacobian v */
    double *mass;              /**< count, kg: of these bodies */
    double *momentum;          /**< count x 6, N s and N m s, axes of the world: linear; angular
                                    about the centre of mass. Rotors (armature) do not count */
    double *energy;            /**< count x 2, J: kinetic, v^T M v / 2 with armature; potential,
                                    - sum of m gravity . com, 0 at the world's origin */
    double *lambda;            /**< count x rm x rm: inverse of lambda_inv, by rank_loss */
    tfa_rank *rank;            /**< count: of lambda, mu, p, task torques */
    double *lost;              /**< count x TFA_LOST_MAX x (2 + rm), with `rank`: directions at or
                                    below the threshold by ascending singular value, a row for each,
                                    the rest 0: singular value sqrt(d), 1/sqrt(kg); what is given up
                                    along it of the acceleration asked for (task torques), m/s^2;
                                    the direction, as an acceleration of the tips of length 1 in
                                    their metric. What no motion of the tips can follow is one
                                    direction with the singular value 0 */
    double *mu;                /**< count x rm, N and N m: Lambda (J M^-1 (velocity + damping +
                                    friction + external) - bias_acceleration) */
    double *p;                 /**< count x rm, N and N m: Lambda J M^-1 gravity */
    double *gravity_force;     /**< count x n, N m and N (bias): holds the robot against gravity */
    double *velocity_force;    /**< count x n: Coriolis and centrifugal forces */
    double *damping_force;     /**< count x n: damping times v */
    double *external_force;    /**< count x n: - sum of J^T wrench */
    double *armature_force;    /**< count x n: armature times qdd, part of M qdd */
    double *dqdd_dq;           /**< count x n x n: row i is the gradient of acceleration i by joint
                                    motion along each component of v; of a floating base and of
                                    joints with quaternions along their twist (derivatives) */
    double *dqdd_dv;           /**< count x n x n (derivatives) */
    double *dqdd_dtau;         /**< count x n x n: M^-1 (derivatives) */
    double *joint_forces;      /**< count x frames x 6, N and N m, in `frame`: the wrench that each
                                    link's joint exerts on it, at the origin of the link's frame,
                                    which is the joint's; of the root link what base or world exert.
                                    From the accelerations of the answer (of forward dynamics: needs
                                    the buffers qdd and, of a floating base, base_acceleration; else
                                    TFA_E_NOT_COMPUTED): F = I a + v x* I v - wrench + sum of the
                                    children's F, H^T F = tau - damping - friction - armature qdd.
                                    Joints that follow others, and locked ones, carry what their
                                    constraint takes; links left out pull at none. Cost: at most one
                                    inverse dynamics more, of one state and of each of a batch,
                                    counted in instructions (docs/performance.md); more where the
                                    state is not kept: behind a specialised kernel, by the parallel
                                    methods of a long chain (1.35 of 256 bodies), and in batches in
                                    float, whose forces are computed in double, state by state */
    double *modes;             /**< count x mode_count, 1/s^2: accelerations of the modal
                                    coordinates (forward dynamics) */
    double *dtau_dq;           /**< count x n x n: row i is the gradient of force i of inverse
                                    dynamics, the base first, columns as dqdd_dq
                                    (inverse_dynamics_derivatives) */
    double *dtau_dv;           /**< count x n x n (inverse_dynamics_derivatives) */
    double *constraint_wrenches; /**< count x 6 c, N and N m (ops of TFA_OPS_CONSTRAINED, as the
                                    next three): of each active constraint the wrench F on its
                                    second frame, at that frame's origin, and -F on its first one,
                                    axes of the first; 0 in rows that it does not hold. Of impact
                                    impulses, N s and N m s */
    double *constraint_position; /**< count x 6 c: where the second frame stands in the first, m;
                                    rotation, rad: of the held rows, to first order, 0 where they
                                    are met */
    double *constraint_velocity; /**< count x 6 c: w, m/s and rad/s; before the impact */
    double *constraint_residual; /**< count x 6 c: dw/dt - (wanted - k0 position - k1 w), m/s^2 and
                                    rad/s^2, of the held rows: rounding, and what a lost rank gives
                                    up; of impact w + k0 position after it */
    double *delassus;            /**< count x 6 c x 6 c, with TFA_WANT_DELASSUS: J_c M^-1 J_c^T of
                                    the held rows, 0 in the others */
    double *v;                   /**< count x v_count, rad/s or m/s: after the impact */
    double *base_twist;          /**< count x 6, m/s and rad/s: after the impact */
    double *friction_force;      /**< count x n (bias): friction times v / sqrt(v^2 + s^2) with the
                                    model's friction_velocity s */
    double *regressor;           /**< count x n x 10 m: Y, ten columns for each link in tips, in its
                                    frame, so that the sum of Y p over all bodies, each by one
                                    link, is M qdd + gravity + velocity without armature; p as
                                    tfa_model_parameters writes it (regressor) */
    double *joint_regressor;     /**< count x v_count x 3: of each freedom what its armature,
                                    damping and friction are multiplied by, qdd, v and
                                    v / sqrt(v^2 + s^2) (regressor) */
    double *generalised_momentum; /**< count x n, kg m^2/s and kg m/s: M v, with armature */
    double *momentum_rate;     /**< count x n, N m and N: dM/dt v - velocity - gravity - damping -
                                    friction - external, which with tau is the rate of
                                    generalised_momentum where nothing else acts */
    tfa_answer *answers;       /**< count */
} tfa_reply;

/** Limit of the robot's size that made a reply TFA_E_UNSUPPORTED, and what answers instead; "" if
 *  it was none (memory, another reason). Static storage. Any thread. */
TFA_API const char *tfa_limit_text(const tfa_reply *reply);

/** Reason of a fallback, from the flags of an answer: "inaccurate", "stalled", "not finite", "not
 *  there" (the method does not exist for these tips); "" without TFA_ANSWER_FALLBACK. Static
 *  storage. Any thread. */
TFA_API const char *tfa_fallback_text(unsigned flags);

#ifdef __cplusplus
}
#endif
#endif
