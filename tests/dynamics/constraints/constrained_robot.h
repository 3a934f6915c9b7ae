/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots with constraints between their links and the world, and the relative motion of the frames
 * by its definition in model.h: from poses, twists and accelerations of links by the oracle, in
 * quadruple precision. Freedoms are counted base first, rows six for each constraint.
 */
#ifndef TESTS_DYNAMICS_CONSTRAINTS_CONSTRAINED_ROBOT_H
#define TESTS_DYNAMICS_CONSTRAINTS_CONSTRAINED_ROBOT_H

#include "support/fixture.h"
#include "support/oracle_operational.h"

enum { MOST = 4, ROWS = 6 * MOST, FREEDOMS = 128 };
#define WORLD UINT32_MAX

typedef struct constrained_robot {
    const test_robot *robot;
    uint32_t count;
    tfa_constraint constraint[MOST];
    uint32_t link[MOST][2]; /**< in the description, or WORLD (the first one only) */
    char name[MOST][8];
    const char *actuated[FREEDOMS]; /**< joints with a motor */
    uint32_t actuated_count;        /**< 0: all */
    tfa_model *model;
    tfa_workspace *f64, *f128;
} constrained_robot;

/** Adds a constraint between two links, their axes at their origins. */
tfa_constraint *constrained_add(constrained_robot *c, uint32_t first, uint32_t second,
                                uint32_t rows);
/** Adds up to `most` random ones: links, frames and rows. */
void constrained_draw(constrained_robot *c, random_source *s, uint32_t most);
/** Compiles the model. @return whether the library has taken it: no link is inside a fused body */
bool constrained_open(constrained_robot *c);
void constrained_close(constrained_robot *c);

/** Relative motion of the frames of all constraints */
typedef struct relative_motion {
    mat3 R[MOST][2];                 /**< axes of the frames */
    vec3 arm[MOST][2];               /**< from the links' origins to the frames', world axes */
    quad J[ROWS * FREEDOMS];         /**< n numbers each */
    quad bias[ROWS], velocity[ROWS]; /**< J-dot v, J v */
    quad position[ROWS];             /**< linear rows only; angular ones are 0 */
} relative_motion;

/** In the state of a request; the oracle is left in that state. */
void relative_motion_of(const constrained_robot *c, const tfa_request *state, relative_motion *m);
/** Row numbers that are held, in their order. @return how many */
uint32_t held_rows(const constrained_robot *c, uint32_t row[ROWS]);
/** x of least norm with J x = e in the held rows of J, as far as they can be met. @return rank */
uint32_t least_norm(const constrained_robot *c, const relative_motion *m, const quad e[ROWS],
                    quad *x);
/** Makes the velocities of state 0 those nearest to them that all held rows admit. */
void admit(const constrained_robot *c, random_states *x);

typedef struct constrained_answer {
    double qdd[FREEDOMS]; /**< base first */
    double F[ROWS], position[ROWS], velocity[ROWS], residual[ROWS];
    double lost[TFA_LOST_MAX * (2 + ROWS)];
    tfa_rank rank;
    tfa_answer answer;
} constrained_answer;

/** Constrained dynamics of the states under all constraints */
tfa_request constrained_request(const constrained_robot *c, const random_states *x);
/** Must answer TFA_OK. */
void constrained_ask(const constrained_robot *c, tfa_workspace *w, const tfa_request *r,
                     constrained_answer *a);

/** A law and how far answers were from it: in f128, in f64 */
typedef struct constrained_law {
    const char *name;
    double bound[2], worst[2];
} constrained_law;

/** |error| / size, of 0 |error|, is within the bound. */
void constrained_within(const constrained_robot *c, constrained_law *law, int set, quad error,
                        quad size);
void constrained_print(const constrained_law *laws, int count);
/** The larger one of a and |b| */
quad larger(quad a, quad b);

#endif
