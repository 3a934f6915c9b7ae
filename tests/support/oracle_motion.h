/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the two halves of the oracle share: links in motion, and the dense system.
 */
#ifndef TESTS_SUPPORT_ORACLE_MOTION_H
#define TESTS_SUPPORT_ORACLE_MOTION_H

#include "oracle.h"
#include "oracle_text.h"
#include "quad.h"

struct oracle_text {
    mat3 *link;  /* inertial frame in the link frame */
    mat3 *joint; /* joint frame in the parent link frame */
    vec3 *axis;  /* of any length */
};

/* One freedom: what it adds to the velocity of its child link, world axes, child origin. */
struct freedom {
    uint32_t link; /* the child link */
    vec3 linear, angular, at;
};

/* One link of the file: pose, velocity and the acceleration it has while all qdd are zero. */
struct body {
    int32_t joint;    /* the joint above it, -1: the root */
    uint32_t freedom; /* first of its joint's freedoms */
    uint32_t freedoms;
    uint32_t q; /* first of its joint's coordinates */
    mat3 R, I;  /* axes; inertia about the centre of mass, world axes */
    vec3 p, v, w, a, alpha;
    vec3 com, v_com, a_com;
};

/* Sums over the masses that move, payloads included; not over links fixed to the world. */
struct oracle_sums {
    quad mass, kinetic;
    vec3 moment;   /* mass times its centre, world */
    vec3 momentum; /* linear */
    vec3 angular;  /* momentum about the world's origin */
};

struct oracle {
    const tfa_description *description;
    const oracle_text *text;   /* where rotations and axes are read; NULL: the description */
    uint32_t n, base, q_count; /* n: freedoms, the base's included */
    struct body *body;         /* one for each link */
    uint32_t *order;           /* links, parents first, in declared order of their joints */
    struct freedom *freedom;
    oracle_tie *tie;     /* n: what becomes of each freedom */
    uint32_t damped;     /* 1: h holds the damping of the joints */
    quad friction_velocity; /* h holds their friction; 0: it does not */
    uint32_t rows;       /* freedoms left: length of the answers, base included */
    quad *M, *h;         /* n x n, n: of all freedoms */
    quad *Mt, *LDL, *ht; /* rows x rows, rows x rows, rows: T^T M T, its factors, T^T h */
    quad *v;             /* all velocities, base first */
    quad mass;           /* payloads included */
    vec3 moment;         /* mass times its centre, world */
    vec3 gravity;
    struct oracle_sums moving;
    vec3 *moment_rate; /* n: of moving.moment, by each freedom */
};

/* The joint above a link; NULL for the root. */
static inline const tfa_joint *joint_above(const oracle *o, const struct body *b)
{
    return b->joint < 0 ? NULL : &o->description->joints[b->joint];
}

/* Poses, velocities, freedoms and velocity-product accelerations of all links, from q, o->v. */
void oracle_move_links(oracle *o, const double *q, const double *base_pose);

/* Whether anything between the world and the link moves */
int oracle_moves(const oracle *o, uint32_t link);

/* Rows of J T of one tip, linear first, each o->rows long: added to `rows`. */
void oracle_tip_rows(const oracle *o, uint32_t link, tfa_reference_frame frame, quad *rows);

/* x <- L^-1 x and x <- M^-1 x, o->rows numbers, of the factors of T^T M T */
void oracle_solve_lower(const oracle *o, quad *x);
void oracle_solve(const oracle *o, quad *x);

/* Centre of mass, its motion and the inertia of `link`, a mass that moves like `b`; turn: the
 * rotation of its inertial frame. */
void oracle_mass_properties(struct body *b, const tfa_link *link, const mat3 *turn);

#endif
