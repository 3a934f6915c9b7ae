/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots and states for the laws of operational space, each as a request to the library and to the
 * oracle: the robots of the fixture; the test mechanisms; and random robots that the library
 * reduced (mimics, fused joints, locked joints, payloads, damping), whose oracle has nothing
 * reduced.
 */
#ifndef TESTS_DYNAMICS_OPERATIONAL_OPERATIONAL_H
#define TESTS_DYNAMICS_OPERATIONAL_OPERATIONAL_H

#include <totalforce/totalforce.h>

#include "interface/fields.h"
#include "support/fixture.h"
#include "support/oracle_operational.h"
#include "support/random_robot.h"

#define OP_STATES 3
#define OP_FREEDOMS 256 /* most rows of M */
#define OP_TIPS 4       /* most tips of the tests that choose some */
#define OP_ROWS (6 * OP_TIPS)
#define OP_SETS 4 /* of bounds */

/** A robot with OP_STATES random states. */
typedef struct op_case {
    char name[160];
    tfa_base base;
    const tfa_model *model;
    tfa_workspace *f64, *f128, *f32; /**< f32: residuals may be in double */
    const tfa_description *whole;    /**< what the oracle sees */
    oracle *o;
    const oracle_tie *tie;   /**< of the oracle's freedoms to those of the model; NULL: the same */
    uint32_t n, six, nv, nq; /**< of the model: rows of M, base freedoms, lengths of v and q */
    uint32_t whole_nv;
    bool file;       /**< of config/robots or ../shared/robots: large */
    bool chain;      /**< a test mechanism: no methods that invert inertias of single bodies */
    bool heavy;      /**< in which light links carry others 1e6 times as heavy: six digits less */
    uint32_t set;    /**< whose bounds count */
    uint32_t damped; /**< 1: the model has damping, and the oracle uses it */
    double friction_velocity;   /**< the same of friction; 0: none */
    uint32_t link_count;        /**< frames of the model */
    uint32_t link[OP_FREEDOMS]; /**< link of `whole` of each frame */
    tfa_request r, whole_r;     /**< the states, without op, tips and flags */
    double numbers[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS]; /**< payloads of the request */
    double all_numbers[2 * TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    uint32_t locked[OP_FREEDOMS]; /**< of the request, once op_lock has chosen */
    oracle_tie locked_tie[OP_FREEDOMS], free_tie[OP_FREEDOMS];
    uint32_t motion_of; /**< state of the oracle by op_set_motion, plus 1; 0: another */
    random_source s;
} op_case;

/** What the cases are drawn from. */
typedef enum op_robots {
    OP_FIXTURE = 1, /**< robots of fixture.h on both bases */
    OP_REDUCED = 2, /**< reduced robots on both bases */
    OP_CHAINS = 4,  /**< the test mechanisms of chains_scan.h on both bases */
    OP_ALL = 7,
} op_robots;

void op_for_each(op_robots robots, void (*law)(op_case *c));

/** Locks about a third of the joints by the request. False if nothing was locked. */
bool op_lock(op_case *c);
void op_unlock(op_case *c);

/** Chooses `count` tips at random (doubles and fixed links too), a frame for everything and the
 * rows, in both requests. */
void op_choose_tips(op_case *c, uint32_t count, tfa_rows rows, tfa_reference_frame frame);
/** A method at random that answers the op and refuses nothing of the robot and the request, and a
 * policy for estimates. */
void op_choose_method(op_case *c, tfa_request *r);
/** The tips of the request in the oracle's words. */
oracle_tips op_tips(const op_case *c);
/** 6 or 3 for each tip. */
uint32_t op_rows(const op_case *c);

/** Sets state k of the oracle: kinematics of all joints, or with the joints locked by the request
 * still. */
void op_set_state(op_case *c, uint32_t k);
/** As op_set_state, for what neither wrenches nor tips matter to: nothing if it was called last,
 * for the same state. */
void op_set_motion(op_case *c, uint32_t k);
void op_set_state_locked(op_case *c, uint32_t k);

/** All velocities of state k, base first. */
void op_velocities(const op_case *c, uint32_t k, double *v);

/** One state of the library's request. */
tfa_request op_state(const op_case *c, uint32_t k);

/** Buffers of all answers to `count` states; NaN until they are written. */
typedef struct op_answers {
    uint32_t count, n, nv, rows, tips, frames;
    double *qdd, *base_acceleration, *tau, *base_wrench, *lambda_inv, *mass_matrix, *poses;
    double *frame_poses, *twists, *jacobian, *bias_acceleration, *com, *com_velocity, *com_jacobian;
    double *mass, *momentum, *energy, *lambda, *lost, *mu, *p;
    double *gravity_force, *velocity_force, *damping_force, *external_force, *armature_force;
    double *joint_forces, *friction_force, *generalised_momentum, *momentum_rate;
    double *regressor, *joint_regressor;
    tfa_rank *rank;
    tfa_spectrum *spectrum;
    tfa_answer *answers;
    tfa_reply reply; /**< into all of them */
    double *memory;
    size_t size; /**< numbers in `memory` */
} op_answers;

op_answers *op_answers_create(const op_case *c, const tfa_request *r);
/** NaN everywhere again. */
void op_answers_clear(op_answers *a);
void op_answers_free(op_answers *a);

/** Answers `r` into cleared `a`; must be TFA_OK. */
void op_compute(const op_case *c, tfa_workspace *w, const tfa_request *r, op_answers *a);
/** The same into new ones. */
op_answers *op_answer(const op_case *c, tfa_workspace *w, const tfa_request *r);

/** The ops that answer kinematics, and whether an op answers lambda_inv */
#define OP_OPS 8
extern const tfa_op op_ops[OP_OPS];
bool op_has_lambda(tfa_op op);
/** Flags that any op answers */
#define OP_KINEMATICS                                                                              \
    (TFA_WANT_POSES | TFA_WANT_FRAME_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |                 \
     TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY |             \
     TFA_WANT_GENERALISED_MOMENTUM)
/** All that the op answers */
uint32_t op_flags(tfa_op op);

/** Outputs of interface/fields.h: names, items of one state, and those of state k. */
extern const char *const op_output_names[TFA_WIRE_REPLY_BLOCKS];
size_t op_numbers(const op_answers *a, uint32_t output);
void *op_output(const op_answers *a, uint32_t output, uint32_t state);
/** Whether the request asks for the output by its op or a flag */
bool op_asked(const tfa_request *r, uint32_t output);
/** State `k` of a and `l` of b have the same bits in the outputs of this mask. */
#define OP_OUTPUT(name) (1ull << TFA_WIRE_##name)
uint64_t op_outputs_of(uint32_t flags);
void op_same(const op_case *c, const char *what, const op_answers *a, uint32_t k,
             const op_answers *b, uint32_t l, uint64_t outputs);

/** tau of state k, base first */
void op_forces(const op_case *c, const op_answers *a, uint32_t k, double *tau);
/** Accelerations of state k with the torques given, both base first */
void op_move(const op_case *c, tfa_workspace *w, uint32_t k, const double *tau, double *qdd);
/** x = J qdd + bias_acceleration of state k by answers. @return the size of the terms */
double op_tip_acceleration(const op_answers *a, uint32_t k, const double *qdd, double *x);

/** A quantity that a test bounds, in each set of cases. */
typedef struct op_bound {
    const char *name;
    double bound[OP_SETS], worst[OP_SETS];
} op_bound;

/** Fails unless the error is within the bound of the case's set. */
void op_within(const op_case *c, op_bound *bound, double error);
void op_print(const op_bound *bounds, size_t count);

/** |x - want| / max(|want|, scale), 2-norms. */
double op_error(const double *x, const quad *want, size_t n, double scale);
/** The same of two arrays of doubles. */
double op_difference(const double *x, const double *want, size_t n, double scale);
double op_norm_quad(const quad *x, size_t n);
void *op_alloc(size_t count, size_t size);

#endif
