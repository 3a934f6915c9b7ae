/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Computing: a workspace answers one request with one reply. The daemon, the command line and
 * programs that link the library all call tfa_compute, so they give the same bits.
 *
 *     M(q) qdd + h(q, v) = tau + sum J^T wrench        h: gravity and velocity products
 *     Lambda^-1 = J M^-1 J^T                           J: twist of a tip = J v
 *
 * (Featherstone 2008, 3.1; Khatib, IEEE J. Robotics and Automation 3(1), 1987). With a floating
 * base, v stands for (base_twist, v), tau for (base_wrench, tau) and qdd for (base_acceleration,
 * qdd). Six-vectors are linear first, angular second; quaternions x y z w; matrices row major; SI
 * units. Coordinates and frames: docs/conventions.md. In costs, N is the number of bodies, d the
 * depth of the tree and m the number of tips.
 *
 * Literature of the methods (docs/methods.md has the equations):
 *   rnea           Luh, Walker, Paul 1980; Featherstone, Rigid Body Dynamics Algorithms, 2008:
 *                  ch. 5
 *   crba           Walker, Orin 1982; Featherstone 2008, ch. 6, with sparse factors L^T D L
 *   aba            Featherstone 1983; 2008, ch. 7
 *   tfa, tfa-cr    Fijany, Featherstone, A new factorization of the mass matrix for optimal serial
 *                  and parallel calculation of multibody dynamics, Multibody System Dynamics 29,
 *                  2013: (46)-(51); Lambda^-1 by (74)-(78); tfa-one-sided: (74) by elimination
 *   hessenberg     the same, (56)-(57)
 *   cfa, cfa-cr    Fijany, Sharf, D'Eleuterio, IEEE Trans. Robotics and Automation 11(3), 1995;
 *                  Fijany, Featherstone 2013, (60)
 *   dca            Featherstone, Int. J. Robotics Research 18(9), 1999
 *   scan,          elements of Saerkkae, Garcia-Fernandez, arXiv 2104.03186, with bodies in place
 *   scan-two-pass  of time steps
 *   propagation    Lilly, Orin, IEEE Trans. Systems, Man, and Cybernetics 23(5), 1993
 *   efpa           Wensing, Featherstone, Orin, ICRA 2012
 *   pv-osimr       Sathya, Decre, Swevers, arXiv 2310.03676
 *   refinement     Wilkinson; Higham, Accuracy and Stability of Numerical Algorithms, 2002, ch. 12
 */
#ifndef TOTALFORCE_DYNAMICS_H
#define TOTALFORCE_DYNAMICS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/model.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_MAX_TIPS 8         /**< tips of one request */
#define TFA_MAX_WRENCHES 8     /**< external wrenches of one request */
#define TFA_MAX_PAYLOADS 4     /**< payloads of one request */
#define TFA_PAYLOAD_NUMBERS 10 /**< mass, centre of mass (3), inertia (6) as in tfa_payload */

/** Operations: inputs -> answers. */
typedef enum tfa_op {
    TFA_OP_FORWARD_DYNAMICS = 1,    /**< q, v, tau -> qdd; with tips also lambda_inv */
    TFA_OP_INVERSE_DYNAMICS = 2,    /**< q, v, qdd -> tau */
    TFA_OP_OPERATIONAL_INERTIA = 3, /**< q, tips -> lambda_inv */
    TFA_OP_MASS_MATRIX = 4,         /**< q -> M */
} tfa_op;

/** Sets of ops: one bit for each. */
#define TFA_OP_BIT(op) (1u << (op))
#define TFA_OPS_FD TFA_OP_BIT(TFA_OP_FORWARD_DYNAMICS)
#define TFA_OPS_ID TFA_OP_BIT(TFA_OP_INVERSE_DYNAMICS)
#define TFA_OPS_OSIM TFA_OP_BIT(TFA_OP_OPERATIONAL_INERTIA)
#define TFA_OPS_M TFA_OP_BIT(TFA_OP_MASS_MATRIX)
#define TFA_OPS_SOLVE (TFA_OPS_FD | TFA_OPS_OSIM)            /**< solutions of M x = b */
#define TFA_OPS_ALL (TFA_OPS_SOLVE | TFA_OPS_ID | TFA_OPS_M) /**< every op */

/**
 * Robots and requests that a method refuses. The request fails (tfa_compute lists the statuses); no
 * other method answers in its place.
 */
typedef enum tfa_refusal {
    TFA_REFUSES_NOTHING = 0,
    TFA_REFUSES_NO_INVERSE = 1,         /**< a body of a main chain whose inertia has no inverse */
    TFA_REFUSES_ARMATURE = 2,           /**< rotor inertia on a main chain */
    TFA_REFUSES_LENGTH = 4,             /**< a main chain of more than 130 bodies */
    TFA_REFUSES_SIZE = 8,               /**< robots whose M has more than 4 Mi entries */
    TFA_REFUSES_LOCKED = 16,            /**< joints locked by the request */
    TFA_REFUSES_MIMICS = 32,            /**< mimic joints that are projected */
    TFA_REFUSES_MASSLESS_FOLLOWER = 64, /**< mimic joints that move no mass of their own */
} tfa_refusal;

/* One row for each method: X(NAME, number, name on the command line and in JSON, ops, method whose
 * factors it uses, cost, TFA_REFUSES_ bits, text). Adding a method: lib/README.md. */
#define TFA_CHAIN_REFUSES (TFA_REFUSES_LOCKED | TFA_REFUSES_MASSLESS_FOLLOWER)
#define TFA_INVERSE_REFUSES (TFA_CHAIN_REFUSES | TFA_REFUSES_NO_INVERSE)
#define TFA_METHOD_LIST(X)                                                                         \
    X(AUTO, 0, "auto", TFA_OPS_ALL, AUTO, "O(N)", TFA_REFUSES_NOTHING,                             \
      "chosen by the model and the request")                                                       \
    X(RNEA, 1, "rnea", TFA_OPS_ID, RNEA, "O(N)", TFA_REFUSES_NOTHING,                              \
      "recursive Newton-Euler, inverse dynamics")                                                  \
    X(CRBA, 2, "crba", TFA_OPS_SOLVE | TFA_OPS_M, CRBA, "O(N d^2)",                                \
      TFA_REFUSES_LOCKED | TFA_REFUSES_SIZE, "composite rigid bodies and sparse LTDL")             \
    X(ABA, 3, "aba", TFA_OPS_SOLVE, ABA, "O(N)", TFA_REFUSES_MASSLESS_FOLLOWER,                    \
      "articulated bodies; lambda_inv by force propagation")                                       \
    X(TFA, 4, "tfa", TFA_OPS_SOLVE, TFA, "O(N)", TFA_INVERSE_REFUSES,                              \
      "total force algorithm, block LU; lambda_inv by (74)-(78)")                                  \
    X(TFA_ONE_SIDED, 5, "tfa-one-sided", TFA_OPS_OSIM, TFA, "O(N + m d)",                          \
      TFA_INVERSE_REFUSES | TFA_REFUSES_MIMICS, "lambda_inv by forward elimination of the tip")    \
    X(PROPAGATION, 6, "propagation", TFA_OPS_OSIM, ABA, "O(N + m d)",                              \
      TFA_REFUSES_MASSLESS_FOLLOWER, "force propagation along the tips' supports")                 \
    X(TFA_CR, 7, "tfa-cr", TFA_OPS_SOLVE, TFA_CR, "O(N), O(log N) in parallel",                    \
      TFA_INVERSE_REFUSES, "total force algorithm by block cyclic reduction")                      \
    X(HESSENBERG, 8, "hessenberg", TFA_OPS_SOLVE, HESSENBERG, "O(N^2)",                            \
      TFA_INVERSE_REFUSES | TFA_REFUSES_LENGTH, "the paper's (57): block upper Hessenberg")        \
    X(CFA, 9, "cfa", TFA_OPS_SOLVE, CFA, "O(N)", TFA_INVERSE_REFUSES | TFA_REFUSES_ARMATURE,       \
      "constraint forces, block LDL^T")                                                            \
    X(CFA_CR, 10, "cfa-cr", TFA_OPS_SOLVE, CFA_CR, "O(N), O(log N) in parallel",                   \
      TFA_INVERSE_REFUSES | TFA_REFUSES_ARMATURE, "constraint forces by block cyclic reduction")   \
    X(DCA, 11, "dca", TFA_OPS_SOLVE, DCA, "O(N), O(log N) in parallel", TFA_INVERSE_REFUSES,       \
      "divide and conquer: two-handle inverse inertias, assembly tree")                            \
    X(SCAN, 12, "scan", TFA_OPS_SOLVE, SCAN, "O(N), O(N/P + log P) on P", TFA_CHAIN_REFUSES,       \
      "segment scan of articulated bodies, one pass")                                              \
    X(SCAN_TWO_PASS, 13, "scan-two-pass", TFA_OPS_SOLVE, SCAN_TWO_PASS,                            \
      "O(N), O(N/P + log P) on P", TFA_CHAIN_REFUSES,                                              \
      "segment scan seeded with outboard inertias")                                                \
    X(EFPA, 14, "efpa", TFA_OPS_OSIM, ABA, "O(N + m d + m^2)", TFA_CHAIN_REFUSES,                  \
      "extended force propagation")                                                                \
    X(PV_OSIMR, 15, "pv-osimr", TFA_OPS_OSIM, ABA, "O(N + m^2)", TFA_REFUSES_MASSLESS_FOLLOWER,    \
      "force propagation with shared supports passed in one step")

/** TFA_METHOD_AUTO = 0, TFA_METHOD_RNEA = 1, ...: one constant for each row of TFA_METHOD_LIST. */
typedef enum tfa_method {
#define TFA_METHOD_ENUM(name, number, text, ops, factors, cost, refuses, summary)                  \
    TFA_METHOD_##name = number,
    TFA_METHOD_LIST(TFA_METHOD_ENUM)
#undef TFA_METHOD_ENUM
} tfa_method;

/** A row of the table of methods. */
typedef struct tfa_method_info {
    tfa_method method;
    const char *name;     /**< "aba": name on the command line and in JSON */
    unsigned ops;         /**< TFA_OP_BITs that it answers */
    int forward_dynamics; /**< 1: answers qdd */
    int lambda;           /**< 1: answers lambda_inv */
    tfa_method factors;   /**< method whose factors, which depend on q only, it uses */
    const char *cost;     /**< "O(N)" */
    unsigned refuses;     /**< TFA_REFUSES_ bits */
    const char *summary;  /**< one line */
} tfa_method_info;

/** Row of a method, static storage; NULL if it does not exist. Any thread. */
TFA_API const tfa_method_info *tfa_method_describe(uint32_t method);

/** Text of one TFA_REFUSES_ bit, for instance "joints locked by the request"; "" for any other
 *  number. Static storage. Any thread. */
TFA_API const char *tfa_refusal_text(unsigned refusal);

/**
 * Policy for error estimates. The estimate of an answer x is |dx| / |x| with one more correction
 * dx = solve(tau - RNEA(x)), not applied. The sentinel of aba bounds the rounding error by
 * eps max Mbar_i / D_i, with D_i the projected articulated inertia of joint i and Mbar_i the
 * largest inertia that it may move at any q; cost: about two operations for each body.
 */
typedef enum tfa_estimate {
    TFA_ESTIMATE_DEFAULT = 0, /**< methods with TFA_REFUSES_NO_INVERSE: every answer. Others: if the
                                   sentinel exceeds 1e-8 (f32: 1e-3) or a D_i is not positive; the
                                   answer is then refined once, estimated, and falls back if the
                                   estimate is too large (TFA_ANSWER_SENTINEL) */
    TFA_ESTIMATE_NEVER = 1,   /**< the method's own answer, refined if asked: no sentinel, no
                                   estimate, no fallback */
    TFA_ESTIMATE_ALWAYS = 2,  /**< every answer */
} tfa_estimate;

/** Frame of the wrenches on links and of lambda_inv. */
typedef enum tfa_reference_frame {
    TFA_FRAME_LOCAL_WORLD_ALIGNED = 0, /**< at the link frame's origin, axes of the world */
    TFA_FRAME_LOCAL = 1,               /**< at the link frame's origin, axes of the link */
    TFA_FRAME_WORLD = 2,               /**< at the world origin, axes of the world */
} tfa_reference_frame;

/** Arithmetic of the factors. */
typedef enum tfa_precision {
    TFA_F64 = 0,  /**< double */
    TFA_F128 = 1, /**< quadruple precision, about 100 times slower: a reference */
    TFA_F32 = 2,  /**< float: forward and inverse dynamics and M, without tips, by all methods but
                       hessenberg, scan and scan-two-pass; double computes everything else, with
                       TFA_ANSWER_RESIDUAL_PRECISION */
} tfa_precision;

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

#define TFA_MAX_REFINE 3 /**< refinement steps of one request */
/** Default number of refinement steps: 1 for methods that invert body inertias, 0 for others; with
 *  a residual in higher precision as many as needed, up to 3 for float and 2 for double factors. */
#define TFA_REFINE_DEFAULT UINT32_MAX

/* Flags of a request: answers besides those of the op */
#define TFA_WANT_SPECTRUM 1u /**< tfa_reply.spectrum, with ops that answer lambda_inv */
#define TFA_WANT_POSES 2u    /**< tfa_reply.poses, with every op */

/**
 * One request. Zero-initialise, then set the inputs of the op. An array holds `count` states one
 * after the other; NULL where allowed. Arrays that the op does not use are not read.
 */
typedef struct tfa_request {
    tfa_op op;
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
    uint32_t tips[TFA_MAX_TIPS]; /**< frame indices */
    uint32_t wrench_frames[TFA_MAX_WRENCHES];  /**< frame indices */
    uint32_t payload_frames[TFA_MAX_PAYLOADS]; /**< frame indices */
    const uint32_t *locked; /**< public joint indices, for every state: their qdd is exactly 0,
                                 lambda_inv is that of the robot with these joints fixed; their v
                                 (normally 0) is used */

    const double *q;                 /**< count x q_count, rad or m */
    const double *v;                 /**< count x v_count, rad/s or m/s; NULL: at rest */
    const double *tau;               /**< count x v_count, N m or N (forward); NULL: zero */
    const double *qdd;               /**< count x v_count, rad/s^2 or m/s^2 (inverse); NULL: zero */
    const double *base_pose;         /**< count x 7, world frame: x y z (m), quaternion x y z w;
                                          required with a floating base */
    const double *base_twist;        /**< count x 6, m/s and rad/s, in the root link's frame, at its
                                          origin; NULL: zero */
    const double *base_wrench;       /**< count x 6, N and N m, the same frame (forward); NULL: 0 */
    const double *base_acceleration; /**< count x 6, m/s^2 and rad/s^2, derivatives of the
                                          components of base_twist (inverse); NULL: zero */
    const double *gravity;           /**< 3, m/s^2, world frame; NULL: that of the model */
    const double *wrenches; /**< count x wrench_count x 6, N and N m, exerted on the robot, in
                                 `frame` of their links */
    const double *payloads; /**< payload_count x TFA_PAYLOAD_NUMBERS, for every state: mass (kg),
                                 com (m), inertia (kg m^2) as in tfa_payload */
} tfa_request;

/* Flags of an answer */
#define TFA_ANSWER_ESTIMATED 1u   /**< error_estimate was computed for this state */
#define TFA_ANSWER_FALLBACK 2u    /**< the requested method failed; `method` answered. Reason: */
#define TFA_ANSWER_INACCURATE 8u  /**< the estimate was above 1e-4 */
#define TFA_ANSWER_STALLED 16u    /**< a refinement step did not shrink the correction tenfold */
#define TFA_ANSWER_NOT_FINITE 32u /**< the method's answer was not finite */
/** Computed in higher precision than that of the factors: that of the residual, or double in place
 *  of float. With TFA_ANSWER_FALLBACK by the method of auto, because the estimate stayed too large;
 *  without it by the requested method, which the lower precision lacks or refused. */
#define TFA_ANSWER_RESIDUAL_PRECISION 64u
/** The sentinel tripped (TFA_ESTIMATE_DEFAULT), so the estimate was computed. */
#define TFA_ANSWER_SENTINEL 128u

/** Quality of the answer for one state. */
typedef struct tfa_answer {
    int32_t status;        /**< TFA_OK, TFA_E_SINGULAR or TFA_E_NOT_COMPUTED, as tfa_compute */
    uint16_t method;       /**< tfa_method that answered */
    uint16_t flags;        /**< TFA_ANSWER_ bits */
    double error_estimate; /**< relative 2-norm error of qdd (base included) or lambda_inv; NaN if
                                not computed */
} tfa_answer;

/**
 * Rank and extreme eigenvalues of lambda_inv: Householder tridiagonalisation (Golub and Van Loan,
 * Matrix Computations, 8.3.1), which ends at the rank, and multisection by Sturm counts (Parlett,
 * The Symmetric Eigenvalue Problem, 3.3). Backward stable: the error is absolute, so that an
 * eigenvalue below it has no certain digit or sign. Cost: at most 4/3 (6m)^3 operations and 24 x 6m
 * divisions one after the other; no iteration can fail to converge.
 */
typedef struct tfa_spectrum {
    uint32_t rank;           /**< eigenvalues above 6m x 64 eps x the largest */
    uint32_t padding;        /**< 0 */
    double eig_min, eig_max; /**< absolute error 12 m eps eig_max; units mixed, depend on `frame`.
                                  If lambda_inv is not finite: NaN, and rank 0 */
} tfa_spectrum;

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
    TFA_FIELD_BODY, /**< singular inertia: `index` is the frame of the link that names the body */
} tfa_field;

/** Name of a field in JSON: "q", "base_pose", ...; "" for any other number. Static storage. Any
 *  thread. */
TFA_API const char *tfa_field_name(tfa_field field);

/**
 * One reply. The caller provides the buffers; NULL: that answer is not wanted. n = base freedoms +
 * v_count; the base comes first in M.
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
    double *tau;               /**< count x v_count, N m or N (inverse dynamics) */
    double *base_wrench;       /**< count x 6, N and N m, root link's frame (inverse dynamics) */
    double *lambda_inv;        /**< count x 6m x 6m, tips in the order of the request (forward
                                    dynamics and operational inertia) */
    double *mass_matrix;       /**< count x n x n */
    tfa_spectrum *spectrum;    /**< count, with TFA_WANT_SPECTRUM and a buffer lambda_inv */
    double *poses;             /**< count x m x 7, with TFA_WANT_POSES: x y z (m), quaternion
                                    x y z w (w >= 0) of the tip's link frame in the world */
    tfa_answer *answers;       /**< count */
} tfa_reply;

/** Memory of one computation: factors, intermediate vectors, batches. One thread at a time. */
typedef struct tfa_workspace tfa_workspace;

/** States of a request that are computed together, one in each SIMD lane. */
typedef enum tfa_states {
    TFA_STATES_AUTO = 0, /**< as many as the processor has lanes, for robots up to 128 bodies */
    TFA_STATES_ONE = 1,  /**< one: the smallest workspace */
} tfa_states;

/** Sets of methods: one bit for each. */
#define TFA_METHOD_BIT(method) (1u << (method))
#define TFA_METHODS_ALL UINT32_MAX

struct tfa_specialised; /* specialised.h */

/** Zero-initialise for the defaults. */
typedef struct tfa_workspace_options {
    tfa_precision precision; /**< of the factors */
    tfa_residual residual;   /**< of refinement; another precision needs memory for both */
    tfa_states states;       /**< computed together */
    uint32_t methods; /**< TFA_METHOD_BITs to reserve memory for, in addition to auto, its choices,
                           rnea, aba, propagation, efpa, pv-osimr, scan and scan-two-pass. The mass
                           matrix uses the memory of crba. 0: TFA_METHODS_ALL for robots up to 256
                           bodies, no more for larger ones */
    const struct tfa_specialised *specialised; /**< specialised kernel of the model, outlives the
                           workspace; answers the requests that it supports, in TFA_F64 with
                           TFA_RESIDUAL_SAME only; NULL: none */
    int round_sincos; /**< TFA_F128 only. 1: rounds sine and cosine of each joint angle to double;
                           the difference from the answer with 0 is the error that no computation
                           in double can avoid */
} tfa_workspace_options;

/** Size of a workspace of this model in bytes; 0 for a NULL model or options that
 *  tfa_workspace_init does not support. options NULL: all defaults. Memory by robot size:
 *  docs/real-time.md. Any thread. */
TFA_API size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options);

/**
 * Initialises a workspace in memory of the caller. The model must outlive it. Cost: O(size). Any
 * thread.
 *
 * @param memory   64-byte aligned, at least tfa_workspace_size() bytes
 * @param options  NULL: all defaults
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or options->specialised is for another model);
 *         TFA_E_UNSUPPORTED (no such precision or instruction set, or a residual of lower precision
 *         than the factors); TFA_E_MEMORY (too small or not aligned). *workspace is NULL on error.
 */
TFA_API TFA_CHECKED int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                                           const tfa_workspace_options *options,
                                           tfa_workspace **workspace);

/** As tfa_workspace_init, in memory that it allocates; TFA_E_MEMORY: the allocation failed. Release
 *  with tfa_workspace_free. */
TFA_API TFA_CHECKED int tfa_workspace_create(const tfa_model *model,
                                             const tfa_workspace_options *options,
                                             tfa_workspace **workspace);

/** Methods that the workspace has memory for: TFA_METHOD_BITs. */
TFA_API uint32_t tfa_workspace_methods(const tfa_workspace *workspace);

/** Releases a workspace of tfa_workspace_create. NULL is allowed. */
TFA_API void tfa_workspace_free(tfa_workspace *workspace);

/**
 * Checks a request against the model without computing: sizes, indices, finiteness, quaternions.
 * Sets status, field, index, state and model of the reply. Cost: one read of the inputs. Any
 * thread.
 * @return reply->status as tfa_compute, except TFA_E_SINGULAR and TFA_E_NOT_COMPUTED
 */
TFA_API int tfa_request_check(const tfa_model *model, const tfa_request *request, tfa_reply *reply);

/**
 * Answers one request: tfa_request_check, method, refinement, estimate, fallback.
 *
 * Reads the arrays of the request and writes the buffers of the reply. No allocation, no lock, no
 * system call, no output. Cost: TFA_METHOD_LIST. Thread rule: one call per workspace at a time. The
 * answer depends on model, options and request only: not on the machine's load, the batch or the
 * number of threads; between instruction sets it differs by rounding.
 *
 * @return reply->status:
 *   TFA_OK              every state is answered (fallbacks: answers[k].flags);
 *   TFA_E_ARGUMENT      a required pointer is NULL; an op, frame, policy or number of refinement
 *                       steps does not exist; a payload's mass or inertia is negative;
 *   TFA_E_SIZE          count 0; too many tips, wrenches, payloads or locked joints; no tip for
 *                       operational inertia or a spectrum;
 *   TFA_E_VALUE         an input is NaN or infinite: field, state and index name it;
 *   TFA_E_QUATERNION    the norm of base_pose's or a floating joint's quaternion differs from 1 by
 *                       more than 1e-3;
 *   TFA_E_LINK          a tip, wrench or payload has a frame index that does not exist;
 *   TFA_E_JOINT         a locked joint index does not exist;
 *   TFA_E_METHOD        the method does not exist, does not answer the op, or refuses the request
 *                       (tfa_method_info.refuses): locked joints, armature on a main chain,
 *                       projected mimics, followers without mass of their own;
 *   TFA_E_UNSUPPORTED   the answer needs M, which has more than 4 Mi entries (a chain of 2895
 *                       bodies); the workspace has no memory for the method
 *                       (tfa_workspace_options.methods); hessenberg on a main chain of more than
 *                       130 bodies; locked joints with the mass matrix, or with followers without
 *                       mass of their own; a spectrum of an op without lambda_inv; a payload on a
 *                       link between fused joints;
 *   TFA_E_SINGULAR      the method cannot invert the inertia of a main-chain body: index is the
 *                       frame of the link that names it;
 *   TFA_E_NOT_COMPUTED  an answer is not finite or has no certain digit: M is singular at this q,
 *                       or nearly. Answers of other states are valid.
 */
TFA_API int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply);

/**
 * As tfa_compute, for states first .. first + count - 1 of a request that tfa_request_check has
 * accepted: for callers that do other work between the states of a batch. Do not change the request
 * in between; first + count may not exceed request->count. Writes the buffers of the reply at the
 * places of these states; `status` and the failed field stay those of the first failure since the
 * check.
 * @return reply->status as tfa_compute
 */
TFA_API int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                               uint32_t count, tfa_reply *reply);

/** Upper bound of the stack that any request uses (`test_stack`; docs/real-time.md). */
#define TFA_STACK_BYTES ((size_t)256 * 1024)

/**
 * Writes to the TFA_STACK_BYTES below the caller's frame, so that no later request of this thread
 * causes a page fault there. A real-time thread calls it once before its first request; the threads
 * of a tfa_batch_pool have done so. Cost: one page fault for each page not yet mapped. Not for a
 * thread with a smaller stack.
 */
TFA_API void tfa_stack_prepare(void);

/** Number of the method with this name ("aba", "tfa", ...), or -1. Any thread. */
TFA_API int32_t tfa_method_find(const char *name);
/** Name of a method; "unknown" if it does not exist. Static storage. Any thread. */
TFA_API const char *tfa_method_name(uint32_t method);
/** Reason of a fallback, from the flags of an answer: "inaccurate", "stalled", "not finite", "not
 *  there" (the method does not exist for these tips); "" without TFA_ANSWER_FALLBACK. Static
 *  storage. Any thread. */
TFA_API const char *tfa_fallback_text(unsigned flags);
/** Instruction set of the kernels: "avx512", "avx2" or "base", the best that library and processor
 *  have unless TFA_ISA in the environment forces one. "none" if TFA_ISA names no such one: creating
 *  a workspace is then TFA_E_UNSUPPORTED. Static storage. Any thread. */
TFA_API const char *tfa_isa_name(void);
/** Writes the instruction sets that library and processor have, the best first: "avx2, base".
 *  Terminated; as much as fits; size > 0. Any thread. */
TFA_API void tfa_isa_names(char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
