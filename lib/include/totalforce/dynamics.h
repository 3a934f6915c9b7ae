/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A workspace computes: one request in, one reply out. The daemon, the command line and a program
 * that links the library all come through tfa_compute, so they give the same bits.
 *
 * Equations of motion:  M(q) qdd + h(q, v) = tau + J^T wrench,   Lambda^-1 = J M^-1 J^T.
 * Six-vectors at this interface are linear first, angular second. SI units.
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

typedef enum tfa_op {
    TFA_OP_FORWARD_DYNAMICS = 1,    /**< q, v, tau -> qdd (and lambda_inv when tips are given) */
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
#define TFA_OPS_SOLVE (TFA_OPS_FD | TFA_OPS_OSIM) /**< solves with M */
#define TFA_OPS_ALL (TFA_OPS_SOLVE | TFA_OPS_ID | TFA_OPS_M)

/**
 * What a method cannot take. A request with it is refused by name (tfa_compute lists the statuses);
 * nothing else answers in its stead.
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

/* One row for each method:
 * X(NAME, number, name on the command line, ops, method whose factors it uses, cost, what it
 *   refuses, text)
 * d: depth of the tree, m: tips. Adding a method: lib/README.md. */
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

typedef enum tfa_method {
#define TFA_METHOD_ENUM(name, number, text, ops, factors, cost, refuses, summary)                  \
    TFA_METHOD_##name = number,
    TFA_METHOD_LIST(TFA_METHOD_ENUM)
#undef TFA_METHOD_ENUM
} tfa_method;

/** A row of the table of methods. */
typedef struct tfa_method_info {
    tfa_method method;
    const char *name;     /**< "aba": as spelt on the command line and in JSON */
    unsigned ops;         /**< that it answers: TFA_OP_BITs */
    int forward_dynamics; /**< answers qdd */
    int lambda;           /**< answers lambda_inv */
    tfa_method factors;   /**< of this method: pose-dependent, kept between requests */
    const char *cost;     /**< "O(N)" */
    unsigned refuses;     /**< TFA_REFUSES_ bits */
    const char *summary;  /**< one line */
} tfa_method_info;

/** The row of a method, static storage; NULL when there is no such method. Any thread. */
TFA_API const tfa_method_info *tfa_method_describe(uint32_t method);

/** What one TFA_REFUSES_ bit means, "a body of a main chain whose inertia has no inverse"; "" for
 * any other number. Static storage. Any thread. */
TFA_API const char *tfa_refusal_text(unsigned refusal);

typedef enum tfa_estimate {
    /** always for methods that refuse TFA_REFUSES_NO_INVERSE; for the others where the sentinel
     * trips: a joint's projected inertia D is so far below the largest inertia Mbar that it can
     * move that eps Mbar / D > 1e-8 (f32: 1e-3), or not positive. Then the answer is refined
     * once by default, estimated, and falls back where the estimate is too large; flags:
     * TFA_ANSWER_SENTINEL. Cost: about two operations a body */
    TFA_ESTIMATE_DEFAULT = 0,
    TFA_ESTIMATE_NEVER = 1,  /**< the answer of the method alone, refined if asked: no sentinel, no
                                   estimate, no fallback */
    TFA_ESTIMATE_ALWAYS = 2, /**< of every answer */
} tfa_estimate;

/** The frame in which wrenches on links are given and lambda_inv is answered. */
typedef enum tfa_reference_frame {
    TFA_FRAME_LOCAL_WORLD_ALIGNED = 0, /**< at the link frame's origin, axes of the world */
    TFA_FRAME_LOCAL = 1,               /**< at the link frame's origin, axes of the link */
    TFA_FRAME_WORLD = 2,               /**< at the world origin, axes of the world */
} tfa_reference_frame;

typedef enum tfa_precision {
    TFA_F64 = 0,  /**< double */
    TFA_F128 = 1, /**< quadruple precision, about 100 times slower: a reference */
    TFA_F32 =
        2, /**< float: forward dynamics, inverse dynamics and M, without tips, by all methods but
                       hessenberg, scan and scan-two-pass. Double answers everything else, and
                       TFA_ANSWER_RESIDUAL_PRECISION says so */
} tfa_precision;

/**
 * In which arithmetic the residual of a refinement step is computed, and qdd summed up. Where it is
 * not that of the factors, it also answers all that is no solve with factors: inverse dynamics, M,
 * lambda_inv (besides qdd, too: by auto, whatever the method), and poses.
 */
typedef enum tfa_residual {
    TFA_RESIDUAL_SAME = 0, /**< that of the workspace */
    TFA_RESIDUAL_F64 = 1,  /**< double, around factors in float */
    TFA_RESIDUAL_F128 = 2, /**< quadruple precision, around factors in double or float: precise */
} tfa_residual;

#define TFA_MAX_REFINE 3 /**< refinement steps of one request */
/** The default: 1 for methods that invert body inertias, 0 for the others; with a residual in
 * higher precision as many as it takes, up to 3 around float, 2 around double. */
#define TFA_REFINE_DEFAULT UINT32_MAX

/** Wanted besides the plain answer; flags of a request. */
#define TFA_WANT_SPECTRUM 1u /**< rank and extreme eigenvalues: of ops that give lambda_inv */
#define TFA_WANT_POSES 2u    /**< poses of the tips in the world: of every op */

/**
 * One request. Arrays hold `count` states one after the other; NULL where not used.
 * Zero-initialise, then fill in what the op needs.
 */
typedef struct tfa_request {
    tfa_op op;
    tfa_method method;           /**< of the op; TFA_METHOD_AUTO unless asked otherwise */
    tfa_estimate estimate;       /**< error estimate policy */
    tfa_reference_frame frame;   /**< of wrenches and lambda_inv */
    uint32_t refine;             /**< refinement steps 0..TFA_MAX_REFINE or TFA_REFINE_DEFAULT */
    uint32_t flags;              /**< TFA_WANT_* */
    uint32_t count;              /**< states, at least 1 */
    uint32_t tip_count;          /**< 0..TFA_MAX_TIPS */
    uint32_t wrench_count;       /**< 0..TFA_MAX_WRENCHES */
    uint32_t payload_count;      /**< 0..TFA_MAX_PAYLOADS, besides those of the model */
    uint32_t locked_count;       /**< joints that are locked for this request */
    uint32_t tips[TFA_MAX_TIPS]; /**< frame indices */
    uint32_t wrench_frames[TFA_MAX_WRENCHES];  /**< frame indices */
    uint32_t payload_frames[TFA_MAX_PAYLOADS]; /**< frame indices */
    const uint32_t *locked; /**< joint indices, for every state: their qdd is 0, exactly, and
                                 lambda_inv is that of the robot with these joints fixed; their v
                                 (0, as a rule) is kept */

    const double *q;                 /**< count x q_count, rad or m */
    const double *v;                 /**< count x v_count, rad/s or m/s; NULL: at rest */
    const double *tau;               /**< count x v_count, N m or N (forward); NULL: zero */
    const double *qdd;               /**< count x v_count (inverse dynamics); NULL: zero */
    const double *base_pose;         /**< count x 7: x y z (m), quaternion x y z w */
    const double *base_twist;        /**< count x 6, root link frame at its origin; NULL: zero */
    const double *base_wrench;       /**< count x 6 (forward), root link frame; NULL: zero */
    const double *base_acceleration; /**< count x 6 (inverse), root link frame; NULL: zero */
    const double *gravity;           /**< 3, world frame, m/s^2; NULL: the model's */
    const double *wrenches;          /**< count x wrench_count x 6, force then moment */
    const double *payloads; /**< payload_count x TFA_PAYLOAD_NUMBERS: mass, com, inertia as in
                                 tfa_payload, for every state */
} tfa_request;

/** Flags of an answer. */
#define TFA_ANSWER_ESTIMATED 1u /**< error_estimate was measured for this state */
#define TFA_ANSWER_FALLBACK 2u  /**< the method asked for failed here; `method` answered */
/* Why there was a fallback: */
#define TFA_ANSWER_INACCURATE 8u  /**< the estimate was above 1e-4 */
#define TFA_ANSWER_STALLED 16u    /**< a refinement step did not shrink the correction tenfold */
#define TFA_ANSWER_NOT_FINITE 32u /**< the method's answer was not finite */
/** Answered in wider arithmetic than that of the factors: that of the residual, or double instead
 * of float. With TFA_ANSWER_FALLBACK by the method of auto, because the estimate stayed too large;
 * alone by the method of the request, which the narrower arithmetic does not have or refused. */
#define TFA_ANSWER_RESIDUAL_PRECISION 64u
/** The sentinel tripped (TFA_ESTIMATE_DEFAULT): the estimate was computed although the method does
 * not ask for one. */
#define TFA_ANSWER_SENTINEL 128u

/** What is known of the answer for one state. */
typedef struct tfa_answer {
    int32_t status;        /**< TFA_OK, TFA_E_SINGULAR, TFA_E_NOT_COMPUTED */
    uint16_t method;       /**< tfa_method that answered */
    uint16_t flags;        /**< TFA_ANSWER_* */
    double error_estimate; /**< relative 2-norm error of qdd or lambda_inv; NaN if not measured */
} tfa_answer;

/** Rank and extreme eigenvalues of lambda_inv. */
typedef struct tfa_spectrum {
    uint32_t rank;    /**< eigenvalues above 6m x 64 eps x the largest */
    uint32_t padding; /**< 0 */
    double eig_min, eig_max;
} tfa_spectrum;

/** Which input a failed request is about; with `index` it names the invalid entry. */
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

/** "q", "base_pose", ...: as spelt in JSON. Static storage. */
TFA_API const char *tfa_field_name(tfa_field field);

/**
 * One reply. The caller gives the buffers; NULL where an answer is not wanted.
 * n = base freedoms + v_count: rows of M stand base first.
 */
typedef struct tfa_reply {
    int32_t status;            /**< of the request as a whole: the first state that failed */
    tfa_field field;           /**< invalid field of a bad request */
    uint32_t index;            /**< index in that field, of one state; or a link frame */
    uint32_t state;            /**< the state it is about */
    uint64_t model;            /**< tfa_model_tag of the model that answered */
    double *qdd;               /**< count x v_count */
    double *base_acceleration; /**< count x 6: time derivative of the components of base_twist */
    double *tau;               /**< count x v_count (inverse dynamics) */
    double *base_wrench;       /**< count x 6 (inverse dynamics) */
    double *lambda_inv;        /**< count x (6 m) x (6 m), row major (forward dynamics and
                                    operational inertia with m tips) */
    double *mass_matrix;       /**< count x n x n, row major */
    tfa_spectrum *spectrum;    /**< count, with TFA_WANT_SPECTRUM, where lambda_inv is not NULL */
    double *poses;             /**< count x tip_count x 7 with TFA_WANT_POSES: x y z (m), quaternion
                                    x y z w (w >= 0) of the tip's link frame in the world */
    tfa_answer *answers;       /**< count; may be NULL */
} tfa_reply;

/** Everything that changes while computing. One thread uses a workspace at a time. */
typedef struct tfa_workspace tfa_workspace;

/** How many states of a request are computed in one batch, in SIMD lanes. */
typedef enum tfa_states {
    TFA_STATES_AUTO = 0, /**< as many as the machine has lanes, for robots up to 128 bodies */
    TFA_STATES_ONE = 1,  /**< one: the smallest workspace */
} tfa_states;

/** Sets of methods: one bit for each. */
#define TFA_METHOD_BIT(method) (1u << (method))
#define TFA_METHODS_ALL UINT32_MAX

struct tfa_specialised; /* specialised.h */

typedef struct tfa_workspace_options {
    tfa_precision precision; /**< of the factors */
    /** of refinement steps; in another arithmetic the workspace holds the state of both
     * arithmetics */
    tfa_residual residual;
    tfa_states states;
    /** to reserve memory for: TFA_METHOD_BITs. Always among them: auto and what it takes, rnea,
     * aba, propagation, efpa, pv-osimr, scan and scan-two-pass. The mass matrix uses the memory
     * of crba. 0: TFA_METHODS_ALL for robots up to 256 bodies, no others for larger ones */
    uint32_t methods;
    /** the model's specialised kernel, which outlives the workspace: it answers what it takes,
     * in double throughout only; NULL: none */
    const struct tfa_specialised *specialised;
    /** of TFA_F128 only: the sine and the cosine of each joint angle are rounded to double, each
     * on its own. The difference from the answer without it is what no computation in double can
     * avoid. 0: sines and cosines are as exact as the rest */
    int round_sincos;
} tfa_workspace_options;

/** Bytes for a workspace of this model, 64-byte aligned; NULL options: all 0. What it is made of
 *  and its bounds: docs/memory.md. */
TFA_API size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options);

/**
 * Initialises a workspace in memory of the caller. The model must outlive it.
 * @return TFA_OK; TFA_E_MEMORY (too small or not aligned); TFA_E_UNSUPPORTED (no such precision or
 *         instruction set, or a residual narrower than the factors); TFA_E_ARGUMENT (a NULL;
 *         options->specialised is the
 *         kernel of another model).
 */
TFA_API TFA_CHECKED int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                                           const tfa_workspace_options *options,
                                           tfa_workspace **workspace);

/** tfa_workspace_size + aligned_alloc + tfa_workspace_init. */
TFA_API TFA_CHECKED int tfa_workspace_create(const tfa_model *model,
                                             const tfa_workspace_options *options,
                                             tfa_workspace **workspace);

/** Methods that it has memory for: TFA_METHOD_BITs. */
TFA_API uint32_t tfa_workspace_methods(const tfa_workspace *workspace);

/** Releases a workspace made by tfa_workspace_create. NULL is allowed. */
TFA_API void tfa_workspace_free(tfa_workspace *workspace);

/**
 * Checks a request against the model without computing: sizes, indices, finiteness, quaternions.
 * Fills status, field, index and state of the reply. Cost: one read of the inputs.
 */
TFA_API int tfa_request_check(const tfa_model *model, const tfa_request *request, tfa_reply *reply);

/**
 * Answers one request: tfa_request_check, then the method, refinement, estimate and fallback.
 *
 * Reads the arrays of the request, writes the buffers of the reply. No allocation, no lock, no
 * system call, no output. Thread rule: one call per workspace at a time.
 *
 * @return reply->status:
 *   TFA_OK            every state answered (see answers[k].flags for fallbacks);
 *   TFA_E_ARGUMENT    a NULL that is needed, an op, frame or policy that does not exist, a
 *                     payload that no body can be;
 *   TFA_E_SIZE        count 0, or too many tips, wrenches, payloads or locked joints; no tip
 *                     for operational inertia or a spectrum;
 *   TFA_E_VALUE       NaN or infinite input: field, state and index say which (arrays that the op
 *   does
 *                     not read may hold anything);
 *   TFA_E_QUATERNION  base_pose or a floating joint: norm off by more than 1e-3;
 *   TFA_E_LINK        a tip, a wrench or a payload names a frame that does not exist;
 *   TFA_E_JOINT       locked names a joint that does not exist;
 *   TFA_E_METHOD      the method does not exist or cannot answer the op; locked joints
 *                     take rnea, aba and propagation only; projected mimics not tfa-one-sided,
 *                     and only crba where a follower moves no mass of its own; a joint with
 *                     armature on a main chain (a tree's longest path) takes neither cfa nor
 *                     cfa-cr;
 *   TFA_E_UNSUPPORTED the answer needs M and the robot is too large for it (4 Mi entries, a chain
 *                     of 2895 bodies); the workspace has no memory for the method
 *                     (tfa_workspace_options.methods); hessenberg on a main chain of more than 130
 *                     bodies; the mass
 *                     matrix with locked joints, or any answer with them where only crba can
 *                     answer; a spectrum of inverse dynamics or of the mass matrix; a
 *                     payload on a link between fused joints;
 *   TFA_E_SINGULAR    TFA met a body whose inertia cannot be inverted: index is its link frame;
 *   TFA_E_NOT_COMPUTED  an answer is not finite, or no digit of it is certain: M is singular at
 *   this
 *                     q, or nearly; others are valid.
 */
TFA_API int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply);

/**
 * States first .. first + count - 1 of a request that tfa_request_check has accepted, for callers
 * that have other things to do between the states of a batch. The request must not change in
 * between, and the states must be its. Writes the buffers of the reply where tfa_compute would;
 * `status` and the failed field stay those of the first failure since the check.
 * @return reply->status, see tfa_compute
 */
TFA_API int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                               uint32_t count, tfa_reply *reply);

/** No request takes more of the calling thread's stack, whatever the robot and the method
 *  (`test_stack` measures it; docs/memory.md). */
#define TFA_STACK_BYTES ((size_t)256 * 1024)

/**
 * Writes to the TFA_STACK_BYTES below the caller's frame, so that no request of this thread meets a
 * page fault there: the system gives a stack its pages when they are first used. To be called once
 * by a real-time thread before its first request; the threads of a tfa_batch_pool have done so.
 * Cost: a page fault for each page not there yet. A thread with a smaller stack must not call it.
 */
TFA_API void tfa_stack_prepare(void);

/** Method of that name ("aba", "tfa", ...), or -1. */
TFA_API int32_t tfa_method_find(const char *name);
/** Name of a method; "unknown" otherwise. */
TFA_API const char *tfa_method_name(uint32_t method);
/** Why a method did not answer itself, from the flags of an answer: "inaccurate", "stalled", "not
 * finite", "not there" (the method does not exist for these tips); "" without TFA_ANSWER_FALLBACK.
 * Static storage. Any thread. */
TFA_API const char *tfa_fallback_text(unsigned flags);
/** The instruction set of the kernels: "avx512", "avx2" or "base"; TFA_ISA in the environment
 * forces one. "none" where TFA_ISA names none that library and processor have: workspaces are then
 * TFA_E_UNSUPPORTED. Static storage. Any thread. */
TFA_API const char *tfa_isa_name(void);
/** The instruction sets that library and processor have, "avx2, base", the best one first: as much
 * as fits of it. Any thread. */
TFA_API void tfa_isa_names(char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
