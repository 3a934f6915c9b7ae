/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Everything that changes while a kernel computes: each array declared once. A kernel of one robot's own
 * has less of it, of sizes that are known (own_state.h).
 */
#ifndef TFA_KERNEL_STATE_H
#define TFA_KERNEL_STATE_H

#include <stddef.h>
#include <string.h>
#include <totalforce/dynamics.h>

#include "kernel/crew.h"
#include "kernel/table.h"
#include "kernel/terms.h"
#include "model/arena.h"
#include "model/model.h"
#include "spatial/dense.h"
#include "spatial/spatial.h"

/* A body with more than one freedom. H is 6 x n, its columns here as rows of six. */
struct multi {
    place part[6];   /* fused: from the frame of the part before to that of this part */
    uint32_t locked; /* bit k: freedom k has no acceleration (lock.c) */
    num H[36];       /* motion subspace */
    num U[36];       /* IA H */
    num L[36];       /* LDL^T factors of D = H^T U + R */
    num u[6];        /* tau - H^T pA */
};

#ifdef TFA_OWN
#include "kernel/own_state.h"
#else

/* A rigid composite: mass, mass times centre of mass, inertia about the origin of its frame. */
struct composite {
    num m;
    vec3 h;
    sym3 I;
};

/* Constant terms of TFA for one body: 1-freedom joints on bodies without side branches. */
struct total {
    sym6 TIT; /* T_i I_{i-1}^-1 T_i^T: the parent's inverse inertia in the joint's frame at q = 0 */
    num TI[36]; /* T_i I_{i-1}^-1 */
};

/* One block row of TFA on the main chain. */
struct row {
    struct lu6 S; /* Schur complement A_ii - A_{i,i-1} S_{i-1}^-1 A_{i-1,i}, factored */
    num XI[36];   /* X_i I_{i-1}^-1, so that A_{i,i-1} = -K_i XI_i */
    num G[36];    /* S_i^-1 A_{i,i+1} */
    sym6 Iinv;    /* inverse of the inertia with side branches folded in */
    num K[36];    /* K_i = 1 - C_i I_i; of a 1-freedom joint only its row that differs from 1 */
    num B[36];    /* B_i = H_i Theta_i^-1, a row of six for each freedom; 1 freedom: 1/Theta */
    num F[36];    /* total forces, frame i: 6 x columns for one right-hand side or six */
};

/* What TFA does with a body: fold it into its parent, keep it on a chain; it carries a side branch */
enum { SIDE = 1, CHAIN = 2, CARRIES = 4 };

/* ARRAY(type, name, count, unit, frame, "writer: meaning")
 * nb bodies, nq inner coordinates, nv freedoms with the base's, mass entries of M, dense freedoms
 * without mimics. In a packed variant steps stand for bodies (terms.h). */
#define TFA_MOTION_ARRAYS(ARRAY)                                                                   \
    ARRAY(num, q, nq, "rad, m", "joint", "load: inner joint coordinates")                          \
    ARRAY(num, qd, nv, "rad/s, m/s", "joint", "load: velocities, base first")                      \
    ARRAY(num, tau, nv, "N m, N", "joint", "load: forces, base first")                             \
    ARRAY(num, qdd, nv, "rad/s2, m/s2", "joint", "solve: accelerations, base first")               \
    ARRAY(num, dx, nv, "rad/s2, m/s2", "joint", "refine: correction of qdd")                       \
    ARRAY(num, qdd_unrefined, nv, "rad/s2, m/s2", "joint", "refine: qdd before its corrections")   \
    ARRAY(num, res, nv, "N m, N", "joint", "refine: residual tau - RNEA(qdd)")                     \
    ARRAY(num, known, nv, "N m, N", "joint",                                                       \
          "load: forces that follow from q and v: damping, "                                       \
          "wrenches inside fused joints")                                                          \
    ARRAY(num, sine, nq, "1", "joint", "pose: of q; counts where it is an angle")                  \
    ARRAY(num, cosine, nq, "1", "joint", "pose: of q")                                             \
    ARRAY(place, X, nb, "1, m", "parent -> i", "pose: X_i = Z(q_i) T_i")                           \
    ARRAY(svec, v, nb, "rad/s, m/s", "i", "velocity: body velocity")                               \
    ARRAY(svec, c, nb, "rad/s2, m/s2", "i", "velocity: v x H qd")                                  \
    ARRAY(svec, p, nb, "N m, N", "i", "velocity: v x* I v - wrench")                               \
    ARRAY(svec, wrench, nb, "N m, N", "i", "load: external wrench")                                \
    ARRAY(svec, a, nb, "rad/s2, m/s2", "i", "any: body acceleration, a_0 = -gravity")              \
    ARRAY(svec, f, nb, "N m, N", "i", "rnea: force across joint i")                                \
    ARRAY(sym6, IA, nb, "kg m2, kg m, kg", "i",                                                    \
          "aba: what the children add to the articulated "                                         \
          "inertia; tfa, lock: the whole of it")                                                   \
    ARRAY(svec, pA, nb, "N m, N", "i", "aba: articulated bias force")                              \
    ARRAY(svec, U, nb, "kg m2, kg m", "i", "aba: IA H of a 1-freedom joint")                       \
    ARRAY(svec, K, nb, "1, m", "i", "aba: U D^-1 of a revolute joint without rotor inertia")       \
    ARRAY(num, Dinv, nb, "1/(kg m2)", "joint", "aba: 1 / (H^T IA H + R)")                          \
    ARRAY(num, u, nb, "N m, N", "joint", "aba: tau - H^T pA")                                      \
    ARRAY(struct multi, multi, m->multis, "", "i", "pose, aba: bodies with several freedoms")      \
    ARRAY(uint8_t, lock, nv, "", "joint", "load: 1: the freedom is locked")                        \
    ARRAY(uint8_t, constraint, nb, "", "", "lock: what locked joints make of each body")

/* Constants that are not rounded: in quadruple precision only */
#ifdef NUM_QUAD
#define STATE_QUADS(count) (count)
#else
#define STATE_QUADS(count) 0
#endif

/* Of one state at a time only */
#define TFA_SINGLE_ARRAYS(ARRAY)                                                                   \
    ARRAY(double, carry, nv, "", "joint", "refine: what goes to the wider kernel and comes back")  \
    ARRAY(sym6, Ic, nb, "kg m2, kg m, kg", "i",                                                    \
          "crba: composite inertia; efpa: inverse inertias Omega")                                 \
    ARRAY(struct composite, rigid, nb, "kg, kg m, kg m2", "i", "lock: composite without freedom")  \
    ARRAY(struct tfa_body, own, nb, "", "i", "payload: constants of bodies that carry one")        \
    ARRAY(struct tfa_body_quad, own_quad, STATE_QUADS(nb), "", "i", "payload: the same in quad")   \
    ARRAY(uint8_t, mark, nv, "", "", "load: scratch, by public freedom")                           \
    ARRAY(num, W, (size_t)m->mimics *nv, "", "joint", "mimic: rows M^-1 G^T")                      \
    ARRAY(num, S, (size_t)m->mimics * m->mimics, "", "mimic", "mimic: LDL factors of G M^-1 G^T")  \
    ARRAY(num, Mr, dense *dense, "kg m2", "joint", "mimic: T^T M T, then its LDL factors")         \
    ARRAY(num, y, m->mimics ? nv : 0, "", "joint", "mimic: right-hand sides of T^T M T and of S")  \
    ARRAY(uint8_t, side, nb, "", "", "tfa: SIDE, CHAIN, CARRIES of each body")                     \
    ARRAY(uint32_t, path, m->depth, "", "", "tfa: a tip's chain, root first")                      \
    ARRAY(char, rows, TFA_V(chain_bytes)(m, methods), "", "",                                      \
          "factor: what a method along chains keeps")                                              \
    ARRAY(sym6, Iinv, nb, "1/(kg m2), 1/kg", "i", "bake: inverse of the rigid inertia")            \
    ARRAY(struct total, total, room_inverts(methods) ? nb : 0, "", "i",                            \
          "bake: constant terms of tfa")                                                           \
    ARRAY(num, M, mass, "kg m2", "joint", "crba: rows of M, then its LDL factors")                 \
    ARRAY(num, psi, nv *tips, "1, m", "joint", "lambda: H^T P of each tip column")                 \
    ARRAY(num, phi, nv *tips, "1/kg", "joint", "lambda: D^-1 psi, or M^-1 J^T")                    \
    ARRAY(num, lambda, tips *tips, "1/kg", "tip", "lambda: answer")                                \
    ARRAY(uint8_t, support, nb, "", "", "lambda: bit t set: body supports tip t")

/* Of one state whose bodies share lanes: what packed.c writes once */
#define TFA_PACKED_ARRAYS(ARRAY)                                                                   \
    ARRAY(terms, packed, nb, "", "i", "constant terms in lane order")                              \
    ARRAY(struct fork, fork, m->bodies, "", "", "what steps take from other lanes")                \
    ARRAY(struct slot, child, m->bodies, "", "", "children of each body, the last one first")      \
    ARRAY(uint32_t, child_of, m->bodies, "", "", "a body's first among them")                      \
    ARRAY(coordinate, coordinates_of, nq, "", "", "where coordinates come from")                   \
    ARRAY(freedom, freedoms_of, nv, "", "", "where freedoms come from and go to")                  \
    ARRAY(num, friction, nv, "N m s", "joint", "damping of each freedom")                          \
    ARRAY(num, inner, m->freedoms, "", "joint", "limbs: freedoms in the order of the bodies")      \
    ARRAY(uint32_t, step_of, m->bodies, "", "", "where a body stands: its step")                   \
    ARRAY(uint32_t, lane_of, m->bodies, "", "", "and its lane")                                    \
    ARRAY(uint32_t, children, m->bodies, "", "", "how many a body has")

#ifdef TFA_PACKED
#define TFA_STATE_ARRAYS(ARRAY) TFA_MOTION_ARRAYS(ARRAY) TFA_PACKED_ARRAYS(ARRAY)
#else
#define TFA_STATE_ARRAYS(ARRAY) TFA_MOTION_ARRAYS(ARRAY) TFA_SINGLE_ARRAYS(ARRAY)
#endif

#define TFA_TIP_COLUMNS ((size_t)6 * TFA_MAX_TIPS)

/* What is valid for the q, base pose, payloads and locked joints of the request before. */
enum {
    HAVE_POSE = 1,   /* X, sine, cosine */
    HAVE_ABA = 2,    /* IA, U, Dinv, multi of all freedoms */
    HAVE_LOCKED = 4, /* the same with locked joints */
    HAVE_CHAIN = 8,  /* rows, of the method in chain_method */
    HAVE_M = 16,     /* M as such */
    HAVE_LTDL = 32,  /* M factored; or Mr, with mimics */
    HAVE_W = 64,     /* W and S, by the factors of the method in w_method */
};

/* What locked joints make of a body (lock.c): no freedom from here to the world; nothing but locked
 * joints below, so that it is one rigid composite with them; nobody asks for its motion */
enum { CONSTRAINT_GROUNDED = 1, CONSTRAINT_RIGID = 2, CONSTRAINT_SILENT = 4 };

/* Bodies first .. end - 1 */
struct span {
    uint32_t first, end;
};

/* Where inner coordinates and freedoms come from: the number of a public one, or one for each lane. */
#ifdef TFA_PACKED
typedef struct each source;
typedef struct coordinate {
    source from;
    double multiplier, offset; /* without mimics the same in all lanes */
} coordinate;
typedef struct freedom {
    source from;
    double multiplier;
    uint32_t held; /* bit l: lane l holds a body, others repeat one */
} freedom;
#else
typedef uint32_t source;
typedef struct tfa_coordinate coordinate;
typedef struct tfa_freedom freedom;
#endif

/* How many of them a state has: those of the model, or what they are packed into. */
struct extent {
    uint32_t bodies, coordinates, freedoms;
    uint32_t methods; /* to have room for: bits 1u << tfa_method */
};

/* Bytes of rows that these methods need along chains: bits 1u << tfa_method. */
size_t TFA_V(chain_bytes)(const struct tfa_model *m, uint32_t methods);

/* Is there room for this one? */
static inline int room_for(uint32_t methods, tfa_method method)
{
    return (int)(methods >> method & 1);
}

/* Is a method among them that inverts body inertias? */
static inline int room_inverts(uint32_t methods)
{
#define ROOM_INVERTS(name, number, text, ops, factors, cost, refuses, what)                        \
    ((refuses)&TFA_REFUSES_NO_INVERSE ? 1u << (number) : 0) |
    return (methods & (TFA_METHOD_LIST(ROOM_INVERTS) 0)) != 0;
#undef ROOM_INVERTS
}

struct chain_method;

struct state {
    const struct tfa_model *m;
    uint32_t methods;                       /* there is room for: bits 1u << tfa_method */
    uint32_t bodies, coordinates, freedoms; /* of the arrays, see struct extent */
    const coordinate *coordinate;
    const freedom *freedom; /* joints only */
    int straight; /* inner coordinates and freedoms of joints are the public ones; never when packed */
    uint32_t lane[NUM_LANES]; /* the state of the request that each lane holds */
    uint32_t lanes;           /* how many of them count */
    const terms *body;        /* the model's, own when the request has payloads, or packed */
    uint32_t have;            /* HAVE_ bits */
    struct tfa_resolved by;   /* the methods of the request under way */
    tfa_method w_method;
    const struct chain_method *chain_method;
    struct span span[TFA_MAX_TIPS]; /* what the request depends on, ascending */
    uint32_t spans;
    uint32_t payloads; /* applied to own */
    uint32_t payload_frame[TFA_MAX_PAYLOADS];
    double payload[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    num base[7];       /* load: base pose */
    int locked;        /* some freedom is locked: lock.c replaces aba.c */
    int skipping;      /* silent bodies are left out */
    int known_any;     /* some known is not zero */
    num margin;        /* aba: below zero where the sentinel trips (sentinel.h) */
    num payload_bound; /* inertia of the request's payloads about any joint, at most */
    vec3 gravity;
    int moving;    /* some velocity or wrench is not zero: c and p count */
    int wrenched;  /* some s->wrench is not zero */
    uint32_t tips; /* of the request under way */
    uint32_t tip[TFA_MAX_TIPS];
    const struct tfa_wider *wider; /* of refinement; NULL: none */
    struct tfa_crew *crew;         /* of the request under way; NULL: the caller alone */
    int round_sincos;              /* sines and cosines are rounded to double */
    int apart;                     /* lanes were to go different ways: nothing counts */
    int32_t bad_body;              /* body whose inertia could not be inverted */
#define TFA_STATE_DECLARE(type, name, count, unit, frame, what) type *name;
    TFA_STATE_ARRAYS(TFA_STATE_DECLARE)
#undef TFA_STATE_DECLARE
};

#ifndef TFA_PACKED
static inline int model_is_straight(const struct tfa_model *m)
{
    int straight = m->inner_q == m->q_count && m->freedoms - m->base_freedoms == m->v_count;
    for (uint32_t k = 0; straight && k < m->inner_q; k++)
        straight = m->coordinate[k].from == k && m->coordinate[k].multiplier == 1 &&
                   m->coordinate[k].offset == 0;
    for (uint32_t k = 0; straight && k < m->v_count; k++)
        straight = m->freedom[k].from == k && m->freedom[k].multiplier == 1;
    return straight;
}
#endif

static inline struct extent model_extent(const struct tfa_model *m, uint32_t methods)
{
    return (struct extent){m->bodies, m->inner_q, m->freedoms, methods};
}

/* One walk: with a base it places the state and its arrays, without it only counts. */
static inline size_t state_walk(const struct tfa_model *m, struct extent n, void *base,
                                struct state **out)
{
    struct arena a = {base, 0};
    const size_t nb = n.bodies, nq = n.coordinates, nv = n.freedoms;
#ifndef TFA_PACKED
    const uint32_t methods = n.methods;
    const size_t tips = NUM_LANES == 1 ? TFA_TIP_COLUMNS : 0; /* batches have none */
    const size_t mass = room_for(methods, TFA_METHOD_CRBA) ? m->mass_entries : 0;
    const size_t dense = mass && m->mimics ? m->freedoms - m->mimics : 0;
#endif
    struct state *s = arena_take(&a, 1, sizeof *s), count_only;
    struct state *o = s ? s : &count_only;
#define TFA_STATE_TAKE(type, name, count, unit, frame, what)                                       \
    o->name = arena_take(&a, (count) + 1, sizeof(type));
    TFA_STATE_ARRAYS(TFA_STATE_TAKE)
#undef TFA_STATE_TAKE
    o->m = m;
    o->bodies = n.bodies;
    o->coordinates = n.coordinates;
    o->freedoms = n.freedoms;
    o->methods = n.methods;
#ifndef TFA_PACKED
    o->body = m->body;
    o->coordinate = m->coordinate;
    o->freedom = m->freedom;
    o->straight = model_is_straight(m);
#endif
    *out = s;
    return a.used;
}

/* All bodies are folded: the factors stand where those of TFA's side branches and of locked joints did. */
static inline void have_aba(struct state *s)
{
    s->have = (s->have | HAVE_ABA) & ~(uint32_t)(HAVE_CHAIN | HAVE_LOCKED);
}

/* H of planar and free joints, which is constant: unit axes, linear freedoms first (pose.c). */
void TFA_V(unit_axes)(struct state *s);

/* A state in memory of that size, all zero but for what is constant. */
static inline struct state *state_init(const struct tfa_model *m, struct extent n, void *memory)
{
    struct state *s;
    memset(memory, 0, state_walk(m, n, NULL, &s));
    (void)state_walk(m, n, memory, &s);
    TFA_V(unit_axes)(s);
    return s;
}

#endif
#endif
