/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Everything that changes while a kernel computes: each array declared once.
 */
#ifndef TFA_KERNEL_STATE_H
#define TFA_KERNEL_STATE_H

#include <stddef.h>
#include <string.h>
#include <totalforce/dynamics.h>

#include "model/arena.h"
#include "model/model.h"
#include "spatial/dense.h"
#include "spatial/spatial.h"

/* A body with more than one freedom. H is 6 x n, its columns here as rows of six. */
struct multi {
    place part[6]; /* fused: from the frame of the part before to that of this part */
    uint32_t held; /* bit k: freedom k has no acceleration (hold.c) */
    num H[36];     /* motion subspace */
    num U[36];     /* IA H */
    num L[36];     /* LDL^T factors of D = H^T U + R */
    num u[6];      /* tau - H^T pA */
};

/* A rigid composite: mass, mass times centre of mass, inertia about the origin of its frame. */
struct composite {
    num m;
    vec3 h;
    sym3 I;
};

/* Constant terms of TFA for one body: 1-freedom joints on bodies without side branches. */
struct total {
    sym6 Iinv; /* inverse of the rigid inertia, frame i */
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
 * nb bodies, nv freedoms with the base's, mass entries of M, dense freedoms without mimics. */
#define TFA_MOTION_ARRAYS(ARRAY)                                                                   \
    ARRAY(num, q, m->inner_q, "rad, m", "joint", "load: inner joint coordinates")                  \
    ARRAY(num, qd, nv, "rad/s, m/s", "joint", "load: velocities, base first")                      \
    ARRAY(num, tau, nv, "N m, N", "joint", "load: forces, base first")                             \
    ARRAY(num, qdd, nv, "rad/s2, m/s2", "joint", "solve: accelerations, base first")               \
    ARRAY(num, known, nv, "N m, N", "joint",                                                       \
          "load: forces that follow from q and v: damping, "                                       \
          "wrenches inside fused joints")                                                          \
    ARRAY(num, sine, m->inner_q, "1", "joint", "pose: of q; counts where it is an angle")          \
    ARRAY(num, cosine, m->inner_q, "1", "joint", "pose: of q")                                     \
    ARRAY(place, X, nb, "1, m", "parent -> i", "pose: X_i = Z(q_i) T_i")                           \
    ARRAY(svec, v, nb, "rad/s, m/s", "i", "velocity: body velocity")                               \
    ARRAY(svec, c, nb, "rad/s2, m/s2", "i", "velocity: v x H qd")                                  \
    ARRAY(svec, p, nb, "N m, N", "i", "velocity: v x* I v - wrench")                               \
    ARRAY(svec, wrench, nb, "N m, N", "i", "load: external wrench")                                \
    ARRAY(svec, a, nb, "rad/s2, m/s2", "i", "any: body acceleration, a_0 = -gravity")              \
    ARRAY(svec, f, nb, "N m, N", "i", "rnea: force across joint i")                                \
    ARRAY(sym6, IA, nb, "kg m2, kg m, kg", "i",                                                    \
          "aba: what the children add to the articulated "                                         \
          "inertia; tfa, hold: the whole of it")                                                   \
    ARRAY(svec, pA, nb, "N m, N", "i", "aba: articulated bias force")                              \
    ARRAY(svec, U, nb, "kg m2, kg m", "i", "aba: IA H of a 1-freedom joint")                       \
    ARRAY(num, Dinv, nb, "1/(kg m2)", "joint", "aba: 1 / (H^T IA H + R)")                          \
    ARRAY(num, u, nb, "N m, N", "joint", "aba: tau - H^T pA")                                      \
    ARRAY(struct multi, multi, m->multis, "", "i", "pose, aba: bodies with several freedoms")      \
    ARRAY(uint8_t, stop, nv, "", "joint", "load: STOP_ bits of each freedom")                      \
    ARRAY(uint8_t, posture, nb, "", "", "hold: what held joints make of each body")

/* Of one state at a time only */
#define TFA_SINGLE_ARRAYS(ARRAY)                                                                   \
    ARRAY(double, carry, nv, "", "joint", "refine: what goes to the wider kernel and comes back")  \
    ARRAY(num, dx, nv, "rad/s2, m/s2", "joint", "refine: correction of qdd")                       \
    ARRAY(num, res, nv, "N m, N", "joint", "refine: residual tau - RNEA(qdd)")                     \
    ARRAY(sym6, Ic, nb, "kg m2, kg m, kg", "i",                                                    \
          "crba: composite inertia; efpa: inverse inertias Omega")                                 \
    ARRAY(struct composite, rigid, nb, "kg, kg m, kg m2", "i", "hold: composite without freedom")  \
    ARRAY(struct tfa_body, own, nb, "", "i", "payload: constants of bodies that carry one")        \
    ARRAY(uint8_t, mark, nv, "", "", "load: scratch, by public freedom")                           \
    ARRAY(num, lag, nv, "N m, N", "joint", "hold: M qdd + h - tau, the holding forces")            \
    ARRAY(double, score, nb, "", "i", "hold: what letting go of its joint promises")               \
    ARRAY(num, W, (size_t)m->mimics *nv, "", "joint", "mimic: rows M^-1 G^T")                      \
    ARRAY(num, S, (size_t)m->mimics * m->mimics, "", "mimic", "mimic: LDL factors of G M^-1 G^T")  \
    ARRAY(num, Mr, dense *dense, "kg m2", "joint", "mimic: T^T M T, then its LDL factors")         \
    ARRAY(num, y, m->mimics ? nv : 0, "", "joint", "mimic: right-hand sides of T^T M T and of S")  \
    ARRAY(uint8_t, side, nb, "", "", "tfa: SIDE, CHAIN, CARRIES of each body")                     \
    ARRAY(uint32_t, path, m->depth, "", "", "tfa: a tip's chain, root first")                      \
    ARRAY(char, rows, TFA_V(chain_bytes)(m), "", "", "factor: what a method along chains keeps")   \
    ARRAY(struct total, total, nb, "", "i", "bake: constant terms of tfa")                         \
    ARRAY(num, M, mass, "kg m2", "joint", "crba: rows of M, then its LDL factors")                 \
    ARRAY(num, psi, nv *TFA_TIP_COLUMNS, "1, m", "joint", "lambda: H^T P of each tip column")      \
    ARRAY(num, phi, nv *TFA_TIP_COLUMNS, "1/kg", "joint", "lambda: D^-1 psi, or M^-1 J^T")         \
    ARRAY(num, lambda, TFA_TIP_COLUMNS *TFA_TIP_COLUMNS, "1/kg", "tip", "lambda: answer")          \
    ARRAY(uint8_t, support, nb, "", "", "lambda: bit t set: body supports tip t")

#if NUM_LANES == 1
#define TFA_STATE_ARRAYS(ARRAY) TFA_MOTION_ARRAYS(ARRAY) TFA_SINGLE_ARRAYS(ARRAY)
#else
#define TFA_STATE_ARRAYS(ARRAY) TFA_MOTION_ARRAYS(ARRAY)
#endif

#define TFA_TIP_COLUMNS ((size_t)6 * TFA_MAX_TIPS)

/* What is valid for the q, base pose, payloads and locked joints of the request before. */
enum {
    HAVE_POSE = 1,  /* X, sine, cosine */
    HAVE_ABA = 2,   /* IA, U, Dinv, multi of all freedoms */
    HAVE_HELD = 4,  /* the same with locked or held joints */
    HAVE_CHAIN = 8, /* rows, of the method in chain_method */
    HAVE_M = 16,    /* M as such */
    HAVE_LTDL = 32, /* M factored; or Mr, with mimics */
    HAVE_W = 64,    /* W and S, by the factors of the method in w_method */
};

/* What held joints make of a body (hold.c): no freedom from here to the world; nothing but held
 * joints below, so that it is one rigid composite with them; nobody asks for its motion */
enum { POSTURE_GROUNDED = 1, POSTURE_RIGID = 2, POSTURE_SILENT = 4 };

/* Why a freedom has no acceleration */
enum { STOP_LOCKED = 1, STOP_HELD = 2 };

/* Bodies first .. end - 1 */
struct span {
    uint32_t first, end;
};

/* Bytes of rows that the methods along chains need. */
size_t TFA_V(chain_bytes)(const struct tfa_model *m);

struct state {
    const struct tfa_model *m;
    uint32_t lane[NUM_LANES];    /* the state of the request that each lane holds */
    uint32_t lanes;              /* how many of them count */
    const struct tfa_body *body; /* the model's, or own when the request has payloads */
    uint32_t have;               /* HAVE_ bits */
    tfa_method w_method;
    tfa_method chain_method;
    struct span span[TFA_MAX_TIPS]; /* what the request depends on, ascending */
    uint32_t spans;
    uint32_t payloads; /* applied to own */
    uint32_t payload_frame[TFA_MAX_PAYLOADS];
    double payload[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    num base[7];      /* load: base pose */
    uint32_t stopped; /* STOP_ bits that some freedom has */
    uint32_t holding; /* STOP_ bits in force: hold.c replaces aba.c */
    int skipping;     /* silent bodies are left out */
    int known_any;    /* some known is not zero */
    vec3 gravity;
    int moving;    /* some velocity or wrench is not zero: c and p count */
    int wrenched;  /* some s->wrench is not zero */
    uint32_t tips; /* of the request under way */
    uint32_t tip[TFA_MAX_TIPS];
    const struct tfa_wider *wider; /* of refinement; NULL: none */
    int32_t bad_body;              /* body whose inertia could not be inverted */
#define TFA_STATE_DECLARE(type, name, count, unit, frame, what) type *name;
    TFA_STATE_ARRAYS(TFA_STATE_DECLARE)
#undef TFA_STATE_DECLARE
};

/* One walk: with a base it places the state and its arrays, without it only counts. */
static inline size_t state_walk(const struct tfa_model *m, void *base, struct state **out)
{
    struct arena a = {base, 0};
    const size_t nb = m->bodies, nv = m->freedoms;
#if NUM_LANES == 1
    const size_t mass = m->mass_entries <= TFA_MASS_ENTRIES_MAX ? m->mass_entries : 0;
    const size_t dense = mass && m->mimics ? m->freedoms - m->mimics : 0;
#endif
    struct state *s = arena_take(&a, 1, sizeof *s), count_only;
    struct state *o = s ? s : &count_only;
#define TFA_STATE_TAKE(type, name, count, unit, frame, what)                                       \
    o->name = arena_take(&a, (count) + 1, sizeof(type));
    TFA_STATE_ARRAYS(TFA_STATE_TAKE)
#undef TFA_STATE_TAKE
    o->m = m;
    o->body = m->body;
    *out = s;
    return a.used;
}

/* A state in memory of that size, all zero. */
static inline struct state *state_init(const struct tfa_model *m, void *memory)
{
    struct state *s;
    memset(memory, 0, state_walk(m, NULL, &s));
    (void)state_walk(m, memory, &s);
    return s;
}

#endif
