/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A random robot, reduced by the library in random ways, beside the oracle of the same robot with
 * nothing reduced: every link a body, every joint a joint, those that do not move or that follow
 * others tied to the rest by equations (oracle_tie_freedoms).
 */
#ifndef TESTS_DYNAMICS_REDUCTIONS_REDUCTIONS_H
#define TESTS_DYNAMICS_REDUCTIONS_REDUCTIONS_H

#include <totalforce/totalforce.h>

#include "support/random_robot.h"

/** What is there to reduce; any sum. */
enum {
    REDUCE_FIXED = 1,     /**< fixed joints */
    REDUCE_LOCKED = 2,    /**< joints locked by the scene */
    REDUCE_PAYLOADS = 4,  /**< payloads of the scene, or of a derived model */
    REDUCE_MASSLESS = 8,  /**< links without mass, on moving and on fixed joints */
    REDUCE_MIMICS = 16,   /**< joints that follow others: projected, locked or left free */
    REDUCE_ROOT = 32,     /**< a scene of what hangs from one link */
    REDUCE_TIPS = 64,     /**< a scene of the trees that carry some links */
    REDUCE_ANYTHING = 127 /**< each of these or not, by the seed */
};

#define REDUCTION_LOCKS 8
#define REDUCTION_PAYLOADS 2

/** A joint of the whole robot, and what should have become of it. */
typedef struct reduced_joint {
    int32_t leader; /**< joint of the whole robot that it follows, or -1 */
    double multiplier, offset;
    bool locked;      /**< stands at `at` */
    bool absent;      /**< on a tree that the scene leaves out */
    int32_t index;    /**< public joint, or -1 */
    double at[7];     /**< q where it is locked */
    uint32_t q, v;    /**< its first coordinate and freedom of the whole robot */
    uint32_t q_count; /**< of the type */
    uint32_t v_count;
} reduced_joint;

typedef struct reduction {
    char name[160];
    uint64_t seed;
    uint32_t kinds;
    bool as_it_is; /**< by reduction_open_robot: any condition of M will do */
    tfa_base base;
    tfa_description *file;  /**< what the library compiles */
    tfa_description *whole; /**< what the oracle sees: the same, without what the root leaves out */
    oracle *o;
    reduced_joint *joint; /**< of `whole` */
    oracle_tie *tie;      /**< of the whole robot's freedoms */
    bool coupled;         /**< joints follow others (mimic = project) */
    tfa_scene scene;
    tfa_model_options options;
    double gravity[3];
    tfa_model *undivided; /**< the model that `model` was derived from, or NULL */
    tfa_model *model;
    tfa_workspace *f64, *f128, *mixed; /**< mixed: factors in float, residuals in double */
    uint32_t n, nv, nq; /**< of the reduced model: rows of M, length of v, length of q */
    uint32_t whole_nq, whole_nv;
    double payloads[REDUCTION_PAYLOADS * TFA_PAYLOAD_NUMBERS]; /**< that the model carries */
    uint32_t payload_links[REDUCTION_PAYLOADS], payload_count;
    tfa_lock locks[REDUCTION_LOCKS];
    tfa_payload scene_payloads[REDUCTION_PAYLOADS];
    const char *tips[2];
} reduction;

/** Makes robot, scene, model and oracle. The library must accept all of it. */
void reduction_open(reduction *r, uint64_t seed, uint32_t kinds, tfa_base base);
/** A robot as it stands in `d`, which must outlive it. False, and nothing to close, when the
 * library refuses it. */
bool reduction_open_robot(reduction *r, const char *name, tfa_description *d,
                          const tfa_model_options *options);
void reduction_close(reduction *r);
/** That is in use; 0: no friction */
double reduction_friction_velocity(const tfa_model_options *options);

/** The model of a description, which must be accepted. */
tfa_model *reduction_compile(const reduction *r, const tfa_description *d,
                             const tfa_model_options *options);

/** A law of robots of these seeds with any reductions, on both bases; none without freedoms. */
void reduction_for_seeds(uint64_t first, uint64_t last, void (*law)(reduction *r, uint64_t seed));

/** Asks the library. False when a method that may refuse did so and said why. */
bool reduction_ask(const reduction *r, tfa_workspace *w, const tfa_request *q, tfa_reply *reply);

/** A request in both languages: of the reduced model, and of the whole robot. */
typedef struct question {
    tfa_request r;     /**< for the library */
    tfa_request whole; /**< for the oracle */
    random_states *x;  /**< of the whole robot; base and wrenches are the same in both */
    double *q, *v, *tau, *qdd;
    double *payloads; /**< for the oracle: the model's, then the request's */
} question;

/** `count` states in which M is well conditioned, with `wrenches` wrenches on present links. False
 * when no such states were found. */
bool question_open(question *a, const reduction *r, uint64_t seed, uint32_t count,
                   uint32_t wrenches);
void question_close(question *a);

/** Whether M is well conditioned in every state, as the requests stand now */
bool question_is_good(const question *a, const reduction *r);

/** Adds up to TFA_MAX_PAYLOADS - REDUCTION_PAYLOADS payloads to both requests, not on links between
 * fused joints. `numbers` must outlive the question. */
void question_load(question *a, const reduction *r, random_source *s, uint32_t count,
                   double *numbers);

/** Chooses up to TFA_MAX_TIPS tips from link `first` on, in both requests. Returns the next link,
 * 0 after the last. */
uint32_t question_tips(question *a, const reduction *r, uint32_t first, uint32_t most);

/** State k of a question alone, for the library and for the oracle. */
tfa_request question_state(const question *a, const reduction *r, uint32_t k, tfa_request *whole);

/** What answers may err by: in double, in f128, of factors in float with residuals in double (0:
 * that is not asked), and Lambda^-1 of methods that invert inertias. */
typedef struct reduction_bounds {
    double f64, f128, mixed, inverted;
} reduction_bounds;

#define REDUCTION_MOST 256 /* freedoms of a robot whose answers are compared */
#define REDUCTION_TIPS 3   /* tips of a question whose answers are compared */

/** Fails when the relative error is above the bound; keeps the worst of what has this name. */
void reduction_within(const reduction *r, const char *what, const double *x, const double *want,
                      size_t n, double bound);
/** Answers to one state, for the library and for the oracle, whose freedoms have these ties: qdd
 * with lambda_inv of the tips beside it, by every method, in every precision. Locked joints have
 * zeros. */
void reduction_check_forward(reduction *r, const tfa_request *one, const tfa_request *whole,
                             const oracle_tie *tie, const reduction_bounds *bounds);
/** lambda_inv and poses of the tips in so many frames, by every method, in double and as mixed. */
void reduction_check_lambda(reduction *r, const tfa_request *one, const tfa_request *whole,
                            const oracle_tie *tie, const reduction_bounds *bounds, int frames);
/** tau, also of gravity along each axis, whose torques are the first moments of all masses, and M.
 * Torques that hold locked joints are part of tau, their qdd is 0 whatever the request says. */
void reduction_check_inverse(reduction *r, const tfa_request *one, const tfa_request *whole,
                             const reduction_bounds *bounds);
/** The worst of everything, and how often methods refused; starts again. */
void reduction_print(void);
/** Answers of the op by the method since the program began. */
uint32_t reduction_answered(tfa_op op, uint32_t method);

#endif
