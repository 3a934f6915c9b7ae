/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * struct state of the layouts scalar and body_lanes: each array declared once, with its size, unit,
 * frame and writer. The layout adds its own arrays, TFA_LAYOUT_ARRAYS, and says where coordinates
 * and freedoms come from: source, coordinate, freedom.
 */
#ifndef TFA_LAYOUT_STATE_STRUCT_H
#define TFA_LAYOUT_STATE_STRUCT_H

#include <stddef.h>
#include <totalforce/dynamics.h>

#include "interface/resolved.h"
#include "layout_body.h"
#include "model/model.h"

/* A rigid composite: mass, mass times centre of mass, inertia about the origin of its frame. */
struct composite {
    num m;
    vec3 h;
    sym3 I;
};

/* Constant terms of TFA for one body: 1-freedom joints on bodies without side branches. */
struct model_constants {
    sym6 TIT; /* T_i I_{i-1}^-1 T_i^T: the parent's inverse inertia in the joint's frame at q = 0 */
    num TI[36]; /* T_i I_{i-1}^-1 */
};

/* One block row of TFA on the main chain. */
struct row {
    struct lu6 S; /* Schur complement A_ii - A_{i,i-1} S_{i-1}^-1 A_{i-1,i}, factored */
    num XI[36];   /* X_i I_{i-1}^-1, so that A_{i,i-1} = -K_i XI_i */
    num G[36];    /* S_i^-1 A_{i,i+1} */
    sym6 Iinv;    /* inverse of the inertia with side branches added */
    num K[36];    /* K_i = 1 - C_i I_i; of a 1-freedom joint only its row that differs from 1 */
    num B[36];    /* B_i = H_i Theta_i^-1, a row of six for each freedom; 1 freedom: 1/Theta */
    num F[36];    /* total forces, frame i: 6 x columns for one right-hand side or six */
};

/* Role of a body in TFA: side branch, on a chain, has a side branch */
enum { SIDE = 1, CHAIN = 2, HAS_BRANCH = 4 };

/* ARRAY(type, name, count, unit, frame, "writer: meaning")
 * nb bodies, nq inner coordinates, nv freedoms with the base's, mass entries of M, dense freedoms
 * without mimics. In a body-lanes variant steps stand for bodies (constants.h). */
#define TFA_MOTION_ARRAYS(ARRAY)                                                                   \
    ARRAY(num, q, nq, "rad, m", "joint", "load: inner joint coordinates")                          \
    ARRAY(num, qd, nv, "rad/s, m/s", "joint", "load: velocities, base first")                      \
    ARRAY(num, boost, nv, "m/s", "joint", "load: linear velocity of roots, taken out of qd")       \
    ARRAY(num, boost_rate, nv, "m/s2", "joint",                                                    \
          "load: w x boost, in qdd besides the previous one")                                      \
    ARRAY(num, tau, nv, "N m, N", "joint", "load: forces, base first")                             \
    ARRAY(num, qdd, nv, "rad/s2, m/s2", "joint", "solve: accelerations, base first")               \
    ARRAY(num, dx, nv, "rad/s2, m/s2", "joint", "refine: correction of qdd")                       \
    ARRAY(num, qdd_unrefined, nv, "rad/s2, m/s2", "joint",                                         \
          "refine: qdd before its corrections; sentinel")                                          \
    ARRAY(num, res, nv, "N m, N", "joint", "refine: residual tau - RNEA(qdd)")                     \
    ARRAY(num, passive_force, nv, "N m, N", "joint",                                               \
          "load: forces that follow from q and v: damping, friction, "                             \
          "wrenches inside fused joints")                                                          \
    ARRAY(num, sine, nq, "1", "joint", "pose: of q; counts where it is an angle")                  \
    ARRAY(num, cosine, nq, "1", "joint", "pose: of q")                                             \
    ARRAY(xform, X, nb, "1, m", "parent -> i", "pose: X_i = Z(q_i) T_i")                           \
    ARRAY(svec, v, nb, "rad/s, m/s", "i", "velocity: body velocity")                               \
    ARRAY(svec, c, nb, "rad/s2, m/s2", "i", "velocity: v x H qd")                                  \
    ARRAY(svec, p, nb, "N m, N", "i", "velocity: v x* I v - wrench")                               \
    ARRAY(svec, wrench, nb, "N m, N", "i", "load: external wrench")                                \
    ARRAY(svec, a, nb, "rad/s2, m/s2", "i", "any: body acceleration, a_0 = -gravity")              \
    ARRAY(svec, f, nb, "N m, N", "i", "rnea: force across joint i")                                \
    ARRAY(sym6, IA, nb, "kg m2, kg m, kg", "i",                                                    \
          "aba: contribution of the children to the articulated "                                  \
          "inertia; tfa, lock: the whole of it")                                                   \
    ARRAY(svec, pA, nb, "N m, N", "i", "aba: articulated bias force")                              \
    ARRAY(svec, U, nb, "kg m2, kg m", "i", "aba: IA H of a 1-freedom joint")                       \
    ARRAY(svec, K, nb, "1, m", "i", "aba: U D^-1 of a revolute joint without rotor inertia")       \
    ARRAY(num, Dinv, nb, "1/(kg m2)", "joint", "aba: 1 / (H^T IA H + R)")                          \
    ARRAY(num, u, nb, "N m, N", "joint", "aba: tau - H^T pA")                                      \
    ARRAY(struct joint_nd, joint_nd, m->joints_nd, "", "i",                                        \
          "pose, aba: bodies with several freedoms")                                               \
    ARRAY(uint8_t, lock, nv, "", "joint", "load: 1: the freedom is locked")                        \
    ARRAY(uint8_t, constraint, nb, "", "", "lock: constraint class of each body")

#define TFA_STATE_ARRAYS(ARRAY) TFA_MOTION_ARRAYS(ARRAY) TFA_LAYOUT_ARRAYS(ARRAY)

/* Validity of kept results for the q, base pose, payloads and locked joints of the request
 * before. */
enum {
    HAVE_POSE = 1,   /* X, sine, cosine */
    HAVE_ABA = 2,    /* IA, U, Dinv, multi of all freedoms */
    HAVE_LOCKED = 4, /* the same with locked joints */
    HAVE_CHAIN = 8,  /* rows, of the method in chain_method */
    HAVE_M = 16,     /* M as such */
    HAVE_LTDL = 32,  /* M factored; or Mr, with mimics */
    HAVE_W = 64,     /* W and S, by the factors of the method in w_method */
};

/* Constraint class of a body with locked joints (lock.c): no freedom from here to the world;
 * nothing but locked joints below, so that it is one rigid composite with them; its motion is
 * not requested */
enum { CONSTRAINT_GROUNDED = 1, CONSTRAINT_RIGID = 2, CONSTRAINT_SKIPPED = 4 };

/* Bodies first .. end - 1 */
struct span {
    uint32_t first, end;
};

/* How many of them a state has: those of the model, or those of the schedule. */
struct extent {
    uint32_t bodies, coordinates, freedoms;
    uint32_t methods; /* to reserve: bits 1u << tfa_method */
    uint32_t tips;    /* to reserve */
};

/* Bytes of rows that these methods need along chains: bits 1u << tfa_method. */
size_t TFA_V(chain_bytes)(const struct tfa_model *m, uint32_t methods);

/* Whether this one is reserved */
static inline int reserves_method(uint32_t methods, tfa_method method)
{
    return (int)(methods >> method & 1);
}

/* Whether a method among them inverts body inertias */
static inline int reserves_inverse(uint32_t methods)
{
#define RESERVES_INVERSE(name, number, text, ops, factors, cost, refuses, summary)                 \
    ((refuses)&TFA_REFUSES_NO_INVERSE ? 1u << (number) : 0) |
    return (methods & (TFA_METHOD_LIST(RESERVES_INVERSE) 0)) != 0;
#undef RESERVES_INVERSE
}

struct chain_method;

/* A constraint of the request under way (dynamics/osim/constraint_rows.h) */
struct closing {
    const struct tfa_closure *of;
    int32_t tip[2]; /* that stand for its sides; -1: the world */
    uint32_t held;  /* rows */
    vec3 arm[2];    /* from the origins of the links to those of the frames */
    mat3 R;         /* axes of the first frame in the world, by columns */
    mat3 axes[2];   /* the same in the links */
};

/* Motion of its second frame in the first */
struct relative_motion {
    num position[6]; /* m; rotations of the held rows to first order, rad */
    num velocity[6]; /* w */
    num bias[6];     /* J_c-dot v */
};

struct state {
    const struct tfa_model *m;
    uint32_t methods;                       /* reserved: bits 1u << tfa_method */
    uint32_t bodies, coordinates, freedoms; /* of the arrays, see struct extent */
    const coordinate *coordinate;
    const freedom *freedom; /* joints only */
    /* inner coordinates and freedoms of joints are the public ones; never with body lanes */
    int identity_map;
    uint32_t lane[NUM_LANES]; /* the state of the request that each lane holds */
    uint32_t lanes;           /* how many of them count */
    /* the model's, payload_body when the request has payloads, or lane_constants */
    const body_constants *body;
    int in_segments;        /* a chain that tfa_cut_segments takes */
    uint32_t have;          /* HAVE_ bits */
    struct tfa_resolved by; /* the methods of the request under way */
    tfa_method w_method;
    const struct chain_method *chain_method;
    struct span span[TFA_MAX_TIPS]; /* bodies that the request depends on, ascending */
    uint32_t spans;
    uint32_t payloads; /* applied to own */
    uint32_t payload_frame[TFA_MAX_PAYLOADS];
    double payload[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    num base[7];            /* load: base pose */
    int locked;             /* some freedom is locked: lock.c replaces aba.c */
    int skips_unused;       /* skipped bodies are left out */
    int has_passive_force;  /* some known is not zero */
    num margin;             /* aba: below zero where the sentinel trips (sentinel.h) */
    num mass_margin;        /* of the factors of M */
    double payload_size[2]; /* tfa_payload_size */
    vec3 gravity;
    int boosted;       /* some boost is not zero (load.h): qd and qdd are those beside it */
    int moving;        /* some velocity or wrench is not zero: c and p count */
    int wrenched;      /* some s->wrench is not zero */
    uint32_t tips;     /* of the request under way */
    uint32_t located;  /* bit t set: the support of tip t has world poses */
    int32_t path_body; /* whose support stands in tip_path; -1: none */
    uint32_t tip_rows; /* of each tip in answers: 6 or 3 */
    uint32_t tip[TFA_MAX_TIPS];
    uint32_t closings;     /* constraints whose sides are the tips; 0: the tips are the request's */
    uint32_t closing_rows; /* that they hold */
    uint8_t closing_side[TFA_MAX_TIPS]; /* of each tip: 2 x place in closing + side */
    int keeps_psi;         /* Lambda is asked for: propagation is to keep psi of one tip */
    int32_t psi_frame;     /* tfa_reference_frame of psi that a propagation kept; -1: none */
    int keeps_force;       /* task: aba leaves what it makes of s->tau in u, and no qdd */
    uint32_t tip_freedoms; /* tip_rows: rows of B */
    uint32_t tip_rank;     /* lambda_factor: of B, all but rounding */
    int spectral;          /* lambda_factor: singular directions stand in `direction` */
    num tip_length;        /* lambda_factor: metres that a radian counts */
    num tip_threshold;     /* lambda_factor: eigenvalues up to this are not inverted */
    const struct tfa_residual_kernel *residual_kernel; /* of refinement; NULL: none */
    struct tfa_executor *executor; /* of the request under way; NULL: the caller alone */
    int round_sincos;              /* sines and cosines are rounded to double */
    int lanes_diverged;            /* lanes were to go different ways: nothing counts */
    int stalled;                   /* iterations of the method did not suffice */
    int32_t bad_body;              /* body whose inertia could not be inverted */
#define TFA_STATE_DECLARE(type, name, count, unit, frame, meaning) type *name;
    TFA_STATE_ARRAYS(TFA_STATE_DECLARE)
#undef TFA_STATE_DECLARE
};

/* The constants of body i */
TFA_INLINE const body_constants *body_constants_of(const struct state *s, uint32_t i)
{
    return &s->body[i];
}

/* The same, with the payloads of the request: only for mass, h and I. */
TFA_INLINE const body_constants *body_with_payload(const struct state *s, uint32_t i)
{
    return &s->body[i];
}

/* Velocity of freedom j in the world */
static inline num world_velocity(const struct state *s, uint32_t j)
{
    return s->boosted ? s->qd[j] + s->boost[j] : s->qd[j];
}

/* Whether the request has payloads */
static inline int state_payloads(const struct state *s)
{
    return s->payloads > 0;
}

/* Rotor inertia of freedom k */
static inline num joint_armature(const struct state *s, const body_constants *b, uint32_t k)
{
    return b->n == 1 ? body_armature(b) : num_of(s->m->armature[body_first_freedom(b) + k]);
}

#endif
