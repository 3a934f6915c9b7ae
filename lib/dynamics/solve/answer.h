/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Steps that the answers of all operations share.
 */
#ifndef TFA_DYNAMICS_SOLVE_ANSWER_H
#define TFA_DYNAMICS_SOLVE_ANSWER_H

#include "interface/kernel_table.h"
#include "layout/state.h"

/* The visible part of an error times this is the estimate. Without it 1 answer in 10 000 of
 * test_estimates was wrong by more than 30 estimates, by 86 at most (2026-11-22). */
#define ESTIMATE_SAFETY 4

/* Above this an estimate is no bound of the error where factors have no digits: they measure their
 * own. Of 150 estimates below a thirtieth of the error, in float to 1/2620 of it and in double at
 * mass ratios of 7e14, none was smaller; but for one of crba in float, where the sentinel trips
 * (2026-11-25). */
#define ESTIMATE_UNCERTAIN 1e-2

/* A step that does not shrink the correction tenfold is not converging, unless it is already at
 * the level of rounding, 450 units of the answer. */
#define SHRINK 10.0
#define ROUNDING (1e-13 * (ANSWER_EPSILON / 0x1p-52))

/* Is a correction at least half of the first one, above rounding? Then the step made the answer no
 * better, or worse: factors have lost a direction, or the residual is all rounding. On light-heavy
 * 1e12 with 1000 bodies under gravity aba went from 2e-16 to 1e-12, on heavy-tip 1e12 with 48
 * bodies tfa-cr from 1e-13 to 4e-6 (test_refined, 2026-11-22). */
static inline int refinement_stagnated(double first, double correction)
{
    return !(2 * correction <= first || correction <= ROUNDING);
}

/* Of an answer and the one before its corrections, by their estimates: both are of the residual's
 * rounding where neither is better, and then the one before stands. */
static inline int refined_is_better(double unrefined, double refined)
{
    return unrefined > 3 * refined;
}

/* An estimate relative to |qdd| in the frame that moves along (load.h): where |qdd| in the world is
 * smaller relative to that, with the roundings of the difference. */
static inline double estimate_in_world(double estimate, double boosted, double world)
{
    return world > 0 && world < boosted ? (estimate + 2 * (double)NUM_EPSILON) * boosted / world
                                        : estimate;
}

/* 0, or the reason (TFA_ANSWER_*) why an answer with this estimate is not to be given; of several,
 * why some of them is not. */
uint16_t TFA_V(needs_fallback)(const num_doubles *estimate, int converging);

/* The estimates of all answers, unless the request wants none. */
void TFA_V(store_estimate)(const struct state *s, const tfa_request *r, const num_doubles *estimate,
                           tfa_answer *out);

/* Is an error estimate to be computed because the sentinel tripped? The answer is then flagged. */
int TFA_V(sentinel_asks_estimate)(struct state *s, const tfa_request *r, tfa_method method,
                                  tfa_answer *out);

/* Is the estimate meaningful? Up to ESTIMATE_UNCERTAIN it is. Above it M may be singular but for
 * rounding: where one is above 1 and the sentinel trips, and where the factors that estimate have
 * lost all but two digits of a body. Otherwise forces balance, and qdd itself is of the size of
 * rounding. In float by itself, for which double answers then: not above ESTIMATE_UNCERTAIN, and
 * not where the sentinel trips. `method`: of the answer; the factors of the estimate are there. */
int TFA_V(estimate_is_valid)(struct state *s, const tfa_request *r, tfa_method method,
                             const num_doubles *estimate);

/* A policy of the request, with the method's default. */
int TFA_V(wants_estimate)(const tfa_request *r, tfa_method method);
uint32_t TFA_V(refine_steps)(const struct state *s, const tfa_request *r, tfa_method method);

/* Reports the body whose projected inertia D is not positive, or furthest below the safe limit. */
void TFA_V(report_singular_body)(struct state *s, tfa_reply *reply);

/* Lambda^-1 with the factors that the method left, copied out. Returns 1 when all is finite. */
int TFA_V(lambda_after)(struct state *s, const tfa_request *r, uint32_t k, tfa_method method,
                        uint32_t refine, tfa_reply *reply);

/* ---- ops ---- */

/* States k .. k + count - 1 of a checked request, at most NUM_LANES, and as many answers. Several
 * that cannot be computed together, or one of which has no answer, get none that counts: a status
 * that is not TFA_OK. */
int TFA_V(answer)(struct state *s, const tfa_request *request, struct tfa_resolved by, uint32_t k,
                  uint32_t count, tfa_reply *reply, tfa_answer *answer);
int TFA_V(answer_forward)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                          tfa_answer *out);
/* As a kernel offers it, see kernel_table.h. */
int TFA_V(estimate_forward)(struct state *s, const tfa_request *r, uint32_t k,
                            const tfa_reply *reply, double limit, tfa_answer *out);
int TFA_V(answer_bias)(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out);
/* The generalised momentum and its rate, after all other answers: s->tau is overwritten. Returns 1
 * when all of it is finite. */
int TFA_V(answer_momentum)(struct state *s, uint32_t k, tfa_reply *reply);
/* Needs pose, velocities and accelerations loaded. */
int TFA_V(answer_regressor)(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *answer);
int TFA_V(answer_derivatives)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *out);
int TFA_V(answer_inverse_derivatives)(struct state *s, const tfa_request *r, tfa_reply *reply,
                                      tfa_answer *out);
/* Of s->keeps_force: c and u of bodies that carry tips are those of another kernel */
enum { KEEPS_FORCE_GIVEN = 2 };
/* Desired accelerations of the tips and posture forces, for answer_operational. Needs s->qdd and
 * s->tau; writes s->dx, s->a and s->f. With s->keeps_force there are neither qdd nor forces. */
void TFA_V(task_error)(struct state *s, const tfa_request *r, uint32_t k);
/* Task torques, lambda, mu and p. Returns TFA_OK, TFA_E_RANK or TFA_E_NOT_COMPUTED; this, too,
 * where directions are lost and forces were given. */
int TFA_V(answer_operational)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *answer);
/* Constrained dynamics; the same. Needs constraints_activate before forward dynamics. */
int TFA_V(answer_constrained)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *answer);
/* Its steps: forces, and with s->keeps_force what they leave of u; the residual of s->qdd. Returns
 * 1 when all of it is finite. */
int TFA_V(constraint_forces)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                             tfa_answer *answer);
int TFA_V(constraint_residual)(struct state *s, uint32_t k, tfa_reply *reply);
/* As a kernel offers it, see kernel_table.h. */
int TFA_V(residual_of_reply)(struct state *s, uint32_t k, tfa_reply *reply);
/* The same of impact, and of inverse dynamics under constraints */
int TFA_V(answer_impact)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *answer);
int TFA_V(answer_constrained_inverse)(struct state *s, const tfa_request *r, uint32_t k,
                                      tfa_reply *reply, tfa_answer *answer);
/* ---- steps of several of them ---- */
/* Errors of position and velocity to the reply; s->relative */
void TFA_V(constraint_errors)(struct state *s, uint32_t k, tfa_reply *reply);
/* x = a - J_c-dot v of held rows: what J_c qdd is to be */
void TFA_V(constraint_wanted)(const struct state *s, const tfa_request *r, uint32_t k, num *x);
/* Held rows to their places among all six, 0 elsewhere. Returns 1 when all are finite. */
int TFA_V(store_held)(const struct state *s, const num *x, double *out);
/* The same of forces, with the flag of those that pull */
int TFA_V(store_wrenches)(const struct state *s, const num *F, uint32_t k, tfa_reply *reply,
                          tfa_answer *answer);
/* Whose factors the rows of tips need */
tfa_method TFA_V(method_of_tips)(const struct state *s);
/* These factors and those for the tips, whichever method answers the rest. 0: not computed */
int TFA_V(factor_tips)(struct state *s, const tfa_request *r, int estimated, tfa_rank *rank);
/* s->task_force = s->tau - h */
void TFA_V(subtract_bias)(struct state *s);
/* y = Lambda (J M^-1 tau - x) */
void TFA_V(force_of)(struct state *s, const num *tau, const num *x, num *y);
int TFA_V(answer_lambda)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *out);
/* As a kernel offers it, see kernel_table.h. */
int TFA_V(answer_motion)(struct state *s, const tfa_request *r, struct tfa_resolved by,
                         uint32_t flags, uint32_t k, tfa_reply *reply);
/* The same for the state that is loaded */
int TFA_V(answer_motion_loaded)(struct state *s, const tfa_request *r, uint32_t flags, uint32_t k,
                                tfa_reply *reply);
/* As a kernel offers it, see kernel_table.h. */
int TFA_V(answer_joint_forces)(struct state *s, const tfa_request *r, struct tfa_resolved by,
                               uint32_t k, int given, tfa_reply *reply);
/* The same for the states that are loaded, whose forces rnea left in s->f if the op is inverse
 * dynamics. Overwrites s->qdd, s->dx, s->a and s->f. */
int TFA_V(answer_joint_forces_loaded)(struct state *s, const tfa_request *r, tfa_reply *reply);
/* As a kernel offers them, see kernel_table.h. */
struct tfa_factor_buffers TFA_V(factor_buffers)(struct state *s);
int TFA_V(answer_tips)(struct state *s, const tfa_request *r, struct tfa_resolved by, uint32_t k,
                       tfa_reply *reply, tfa_answer *out);

#endif
