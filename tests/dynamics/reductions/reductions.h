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
void reduction_close(reduction *r);

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

/** Ratio of the extreme eigenvalues of M scaled to unit diagonal. */
double scaled_condition(const double *M, uint32_t n);

/** Euclidean norm of the difference over that of the reference. */
double relative_difference(const double *x, const double *reference, size_t n);

/** Whether the method refuses, by name, bodies with no inverse inertia or joints with armature */
bool reduction_may_refuse(tfa_method method);

#endif
