/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations and methods: the table that request checks, tools and documentation read.
 *
 * Literature of the methods (notation and rules: docs/methods.md):
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
 *   hybrid         segments direct, cuts iterative: Engineering with Computers 16, 96-108, 2000;
 *                  equations: docs/methods.md
 *   propagation    Lilly, Orin, IEEE Trans. Systems, Man, and Cybernetics 23(5), 1993
 *   efpa           Wensing, Featherstone, Orin, ICRA 2012
 *   pv-osimr       Sathya, Decre, Swevers, arXiv 2310.03676
 *   refinement     Wilkinson; Higham, Accuracy and Stability of Numerical Algorithms, 2002, ch. 12
 */
#ifndef TOTALFORCE_METHOD_H
#define TOTALFORCE_METHOD_H

#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Operations: inputs -> answers. */
typedef enum tfa_op {
    TFA_OP_FORWARD_DYNAMICS = 1,    /**< q, v, tau -> qdd; with tips also lambda_inv */
    TFA_OP_INVERSE_DYNAMICS = 2,    /**< q, v, qdd -> tau */
    TFA_OP_OPERATIONAL_INERTIA = 3, /**< q, tips -> lambda_inv */
    TFA_OP_MASS_MATRIX = 4,         /**< q -> M */
    TFA_OP_KINEMATICS = 5,          /**< q, v -> answers of the flags only */
    TFA_OP_BIAS = 6,                /**< q, v -> gravity_force, velocity_force, damping_force,
                                         friction_force, external_force; qdd: armature_force */
    TFA_OP_TASK_TORQUES = 7,        /**< q, v, tips, task_acceleration, posture torques in tau ->
                                         tau, lambda_inv, rank */
    TFA_OP_DERIVATIVES = 8,         /**< q, v, tau -> dqdd_dq, dqdd_dv, dqdd_dtau */
    TFA_OP_INVERSE_DYNAMICS_DERIVATIVES = 9, /**< q, v, qdd -> dtau_dq, dtau_dv; dtau/dqdd is M */
    TFA_OP_CONSTRAINED_DYNAMICS = 10, /**< q, v, tau, constraints -> qdd, constraint_wrenches,
                                           constraint_residual, their errors, rank */
    TFA_OP_IMPACT = 11, /**< q, v, constraints -> v and base_twist after the impact, impulses,
                             velocities of the constraints before and after, rank */
    TFA_OP_CONSTRAINED_INVERSE_DYNAMICS = 12, /**< q, v, qdd, constraints -> tau, base_wrench,
                                                   constraint_wrenches, constraint_residual, rank */
    TFA_OP_REGRESSOR =
        13, /**< q, v, qdd, tips -> regressor of the links in tips, joint_regressor */
} tfa_op;
#define TFA_OP_LAST TFA_OP_REGRESSOR /**< largest tfa_op */
/** Their words: X(value, word) */
#define TFA_OP_WORDS(X)                                                                            \
    X(TFA_OP_FORWARD_DYNAMICS, "forward_dynamics")                                                 \
    X(TFA_OP_INVERSE_DYNAMICS, "inverse_dynamics")                                                 \
    X(TFA_OP_OPERATIONAL_INERTIA, "operational_inertia")                                           \
    X(TFA_OP_MASS_MATRIX, "mass_matrix")                                                           \
    X(TFA_OP_KINEMATICS, "kinematics")                                                             \
    X(TFA_OP_BIAS, "bias")                                                                         \
    X(TFA_OP_TASK_TORQUES, "task_torques")                                                         \
    X(TFA_OP_DERIVATIVES, "derivatives")                                                           \
    X(TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, "inverse_dynamics_derivatives")                         \
    X(TFA_OP_CONSTRAINED_DYNAMICS, "constrained_dynamics")                                         \
    X(TFA_OP_IMPACT, "impact")                                                                     \
    X(TFA_OP_CONSTRAINED_INVERSE_DYNAMICS, "constrained_inverse_dynamics")                         \
    X(TFA_OP_REGRESSOR, "regressor")

/** Sets of ops: one bit for each. */
#define TFA_OP_BIT(op) (1u << (op))
#define TFA_OPS_FD TFA_OP_BIT(TFA_OP_FORWARD_DYNAMICS)      /**< one op */
#define TFA_OPS_ID TFA_OP_BIT(TFA_OP_INVERSE_DYNAMICS)      /**< one op */
#define TFA_OPS_OSIM TFA_OP_BIT(TFA_OP_OPERATIONAL_INERTIA) /**< one op */
#define TFA_OPS_M TFA_OP_BIT(TFA_OP_MASS_MATRIX)            /**< one op */
#define TFA_OPS_TASK TFA_OP_BIT(TFA_OP_TASK_TORQUES)        /**< one op */
#define TFA_OPS_DERIVATIVES TFA_OP_BIT(TFA_OP_DERIVATIVES)  /**< one op */
#define TFA_OPS_ID_DERIVATIVES TFA_OP_BIT(TFA_OP_INVERSE_DYNAMICS_DERIVATIVES) /**< one op */
#define TFA_OPS_CONSTRAINED_FD TFA_OP_BIT(TFA_OP_CONSTRAINED_DYNAMICS)         /**< one op */
#define TFA_OPS_IMPACT TFA_OP_BIT(TFA_OP_IMPACT)                               /**< one op */
#define TFA_OPS_CONSTRAINED_ID TFA_OP_BIT(TFA_OP_CONSTRAINED_INVERSE_DYNAMICS) /**< one op */
#define TFA_OPS_REGRESSOR TFA_OP_BIT(TFA_OP_REGRESSOR)                         /**< one op */
/** Ops with constraints */
#define TFA_OPS_CONSTRAINED (TFA_OPS_CONSTRAINED_FD | TFA_OPS_IMPACT | TFA_OPS_CONSTRAINED_ID)
/** Those of them that solve M x = b */
#define TFA_OPS_CONSTRAINED_SOLVE (TFA_OPS_CONSTRAINED_FD | TFA_OPS_IMPACT)
/** Passes of the recursive Newton-Euler algorithm, and its derivatives */
#define TFA_OPS_RNEA                                                                               \
    (TFA_OPS_ID | TFA_OP_BIT(TFA_OP_KINEMATICS) | TFA_OP_BIT(TFA_OP_BIAS) |                        \
     TFA_OPS_ID_DERIVATIVES | TFA_OPS_CONSTRAINED_ID | TFA_OPS_REGRESSOR)
#define TFA_OPS_SOLVE (TFA_OPS_FD | TFA_OPS_OSIM | TFA_OPS_TASK) /**< solutions of M x = b */
#define TFA_OPS_ALL                                                                                \
    (TFA_OPS_SOLVE | TFA_OPS_RNEA | TFA_OPS_M | TFA_OPS_DERIVATIVES |                              \
     TFA_OPS_CONSTRAINED_SOLVE) /**< every op */

/**
 * Robots and requests that a method refuses. The request fails (tfa_compute lists the statuses); no
 * other method answers in its place.
 */
typedef enum tfa_refusal {
    TFA_REFUSES_NOTHING = 0,            /**< none */
    TFA_REFUSES_NO_INVERSE = 1,         /**< a body of a main chain whose inertia has no inverse */
    TFA_REFUSES_ARMATURE = 2,           /**< rotor inertia on a main chain */
    TFA_REFUSES_LENGTH = 4,             /**< a main chain of more than 130 bodies */
    TFA_REFUSES_SIZE = 8,               /**< robots whose M has more than 4 Mi entries */
    TFA_REFUSES_LOCKED = 16,            /**< joints locked by the request */
    TFA_REFUSES_MIMICS = 32,            /**< mimic joints that are projected */
    TFA_REFUSES_MASSLESS_FOLLOWER = 64, /**< mimic joints that move no mass of their own */
    TFA_REFUSES_TIPS = 128,             /**< tips */
    TFA_REFUSES_MODES = 256,            /**< robots with flexible links */
} tfa_refusal;

/** Refusals that methods share */
#define TFA_CHAIN_REFUSES (TFA_REFUSES_LOCKED | TFA_REFUSES_MASSLESS_FOLLOWER)
/** Those of methods that invert the inertias of bodies */
#define TFA_INVERSE_REFUSES (TFA_CHAIN_REFUSES | TFA_REFUSES_NO_INVERSE)
/** The same, of rigid bodies only */
#define TFA_RIGID_REFUSES (TFA_INVERSE_REFUSES | TFA_REFUSES_MODES)
/** One row for each method: X(NAME, number, name on the command line and in JSON, ops, method whose
 * factors it uses, cost, TFA_REFUSES_ bits, text). Adding a method: lib/README.md. */
#define TFA_METHOD_LIST(X)                                                                         \
    X(AUTO, 0, "auto", TFA_OPS_ALL, AUTO, "O(N)", TFA_REFUSES_NOTHING,                             \
      "chosen by the model and the request")                                                       \
    X(RNEA, 1, "rnea", TFA_OPS_RNEA, RNEA, "O(N)", TFA_REFUSES_NOTHING,                            \
      "recursive Newton-Euler: inverse dynamics, derivatives, regressor, bias, kinematics")        \
    X(CRBA, 2, "crba",                                                                             \
      TFA_OPS_SOLVE | TFA_OPS_M | TFA_OPS_DERIVATIVES | TFA_OPS_CONSTRAINED_SOLVE, CRBA,           \
      "O(N d^2)", TFA_REFUSES_LOCKED | TFA_REFUSES_SIZE | TFA_REFUSES_MODES,                       \
      "composite rigid bodies and sparse LTDL")                                                    \
    X(ABA, 3, "aba", TFA_OPS_SOLVE | TFA_OPS_DERIVATIVES | TFA_OPS_CONSTRAINED_SOLVE, ABA, "O(N)", \
      TFA_REFUSES_MASSLESS_FOLLOWER, "articulated bodies; lambda_inv by force propagation")        \
    X(TFA, 4, "tfa", TFA_OPS_SOLVE, TFA, "O(N)", TFA_RIGID_REFUSES,                                \
      "total force algorithm, block LU; lambda_inv by (74)-(78)")                                  \
    X(TFA_ONE_SIDED, 5, "tfa-one-sided", TFA_OPS_OSIM, TFA, "O(N + m d)",                          \
      TFA_RIGID_REFUSES | TFA_REFUSES_MIMICS, "lambda_inv by forward elimination of the tip")      \
    X(PROPAGATION, 6, "propagation", TFA_OPS_OSIM, ABA, "O(N + m d)",                              \
      TFA_REFUSES_MASSLESS_FOLLOWER, "force propagation along the tips' supports")                 \
    X(TFA_CR, 7, "tfa-cr", TFA_OPS_SOLVE, TFA_CR, "O(N), O(log N) in parallel", TFA_RIGID_REFUSES, \
      "total force algorithm by block cyclic reduction; long revolute chains: as cfa-cr")          \
    X(HESSENBERG, 8, "hessenberg", TFA_OPS_SOLVE, HESSENBERG, "O(N^2)",                            \
      TFA_RIGID_REFUSES | TFA_REFUSES_LENGTH, "the paper's (57): block upper Hessenberg")          \
    X(CFA, 9, "cfa", TFA_OPS_SOLVE, CFA, "O(N)", TFA_RIGID_REFUSES | TFA_REFUSES_ARMATURE,         \
      "constraint forces, block LDL^T")                                                            \
    X(CFA_CR, 10, "cfa-cr", TFA_OPS_SOLVE, CFA_CR, "O(N), O(log N) in parallel",                   \
      TFA_RIGID_REFUSES | TFA_REFUSES_ARMATURE,                                                    \
      "constraint forces by block cyclic reduction; long revolute chains: over segments")          \
    X(DCA, 11, "dca", TFA_OPS_SOLVE, DCA, "O(N), O(log N) in parallel", TFA_INVERSE_REFUSES,       \
      "divide and conquer: two-handle inverse inertias, assembly tree")                            \
    X(SCAN, 12, "scan", TFA_OPS_SOLVE, SCAN, "O(N), O(N/P + log P) on P", TFA_CHAIN_REFUSES,       \
      "segment scan of articulated bodies, one pass")                                              \
    X(SCAN_TWO_PASS, 13, "scan-two-pass", TFA_OPS_SOLVE, SCAN_TWO_PASS,                            \
      "O(N), O(N/P + log P) on P", TFA_CHAIN_REFUSES,                                              \
      "segment scan seeded with outboard inertias")                                                \
    X(EFPA, 14, "efpa", TFA_OPS_OSIM, ABA, "O(N + m d + m^2)",                                     \
      TFA_CHAIN_REFUSES | TFA_REFUSES_MODES, "extended force propagation")                         \
    X(PV_OSIMR, 15, "pv-osimr", TFA_OPS_OSIM, ABA, "O(N + m^2)",                                   \
      TFA_REFUSES_MASSLESS_FOLLOWER | TFA_REFUSES_MODES,                                           \
      "force propagation with shared supports passed in one step")                                 \
    X(HYBRID, 16, "hybrid", TFA_OPS_FD, HYBRID, "O(N), O(N/P + iterations) on P",                  \
      TFA_CHAIN_REFUSES | TFA_REFUSES_TIPS | TFA_REFUSES_MODES,                                    \
      "segments of articulated bodies, forces at their cuts by conjugate gradients")

/** TFA_METHOD_AUTO = 0, TFA_METHOD_RNEA = 1, ...: one constant for each row of TFA_METHOD_LIST. */
typedef enum tfa_method {
#define TFA_METHOD_ENUM(name, number, text, ops, factors, cost, refuses, summary)                  \
    TFA_METHOD_##name = number,
    TFA_METHOD_LIST(TFA_METHOD_ENUM)
#undef TFA_METHOD_ENUM
} tfa_method;

/** A row of the table of methods. */
typedef struct tfa_method_info {
    tfa_method method;    /**< this method */
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

/** Number of the method with this name ("aba", "tfa", ...), or -1. Any thread. */
TFA_API int32_t tfa_method_find(const char *name);
/** Name of a method; "unknown" if it does not exist. Static storage. Any thread. */
TFA_API const char *tfa_method_name(uint32_t method);

#ifdef __cplusplus
}
#endif
#endif
