/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One long chain of revolute bodies in pieces of equal length, as many of them side by side as a
 * number has lanes: lane l of group g walks piece NUM_LANES g + l. What pieces tell each other
 * stands in arrays by piece, at their borders. How many pieces there are depends on the chain
 * alone, so that an answer is the same for any number of lanes and threads. Behind the last body of
 * the chain the last pieces are filled up with bodies that nothing couples to.
 *
 * The block rows are five wide. H^T I_i times row i of the total force system (tfa_row.h) is
 * H^T F_i = tau_i for a joint without rotor inertia; with that component known and eliminated,
 * F_i = Wa tau_i + W x_i, the other five rows of A are those of a symmetric positive definite
 * system, that of the constraint forces (cfa_row.h):
 *
 *   D_i = W^T (I_i^-1 + Z TIT Z^T) W,   L_i = A_{i,i-1} = -W^T Z TI W,   Z: the joint's rotation
 *   b_i = W^T (c_i - e_i + X_i e_{i-1}),   e_i = I_i^-1 (Wa tau_i - X_{i+1}^T Wa tau_{i+1} - p_i)
 *
 * so that no row needs pivots and half of each block product is spared.
 */
#ifndef TFA_KERNEL_PIECES_H
#define TFA_KERNEL_PIECES_H

#include <totalforce/dynamics.h>

#include "kernel/crew.h"
#include "model/arena.h"
#include "model/model.h"
#include "spatial/block5.h"

/* Constants of the bodies at one place of NUM_LANES pieces */
struct piece_body {
    mat3 E; /* tree transform T */
    vec3 r;
    sym3 I;
    vec3 h;
    num mass;
    num damping;
    vec3 next_z; /* the axis of the next body's joint in this frame; 0: none */
    sym6 Iinv;
    sym5 TIT;              /* W^T T I_{i-1}^-1 T^T W */
    mat5 minus_TI;         /* -W^T T I_{i-1}^-1 W, transposed */
    uint32_t q[NUM_LANES]; /* public coordinate and freedom; of any joint where there is none */
    uint32_t v[NUM_LANES];
    uint32_t real[NUM_LANES]; /* 1: a body of the chain, 0: filling */
    num live;                 /* the same as a factor */
};

/* What one elimination leaves for back substitution */
struct piece_factors {
    sym5 M;  /* D = M diag M^T */
    mat5 ZL; /* M^-1 times the coupling to the row on the left */
    mat5 ZU; /* M^-1 times the coupling to the row on the right */
    vec5 y;  /* M^-1 b */
};

/* What changes */
struct piece_row {
    struct piece_factors factors;
    place X;
    svec v, p; /* of a chain that moves */
    svec a;    /* residual */
    num sine, cosine;
    num qd, tau;
    num rhs; /* tau, or the residual */
    num qdd;
    num unrefined; /* qdd before its corrections */
};

/* Rows of the border: one number of each piece */
enum {
    /* 12: from the frame before the piece to its last body */
    BORDER_PLACE = 0,
    /* 6: velocity of the last body, first where the body before rests; then its acceleration */
    BORDER_MOVED = 12,
    /* 6: velocity of the body before, then its acceleration as the solution has it; and what that
     * is wrong by */
    BORDER_V = 18,
    BORDER_DV = 24,
    /* 15 + 25 + 5: what is left of the last row, its diagonal block, its coupling to the last row
     * of the piece before, its right-hand side; then x */
    BORDER_D = 30,
    BORDER_L = BORDER_D + 15,
    BORDER_B = BORDER_L + 25,
    /* 15 + 5: what the piece adds to that row of the piece before */
    BORDER_LEFT_D = BORDER_B + 5,
    BORDER_LEFT_B = BORDER_LEFT_D + 15,
    /* angular acceleration about its axis: of the body before; of the last body with nothing behind
     * it; of the body before the last, about the axis of the last */
    BORDER_RATE = BORDER_LEFT_B + 5,
    BORDER_ALONE,
    BORDER_CARRIED,
    /* 6: force of the piece on the body before as the solution has it, and by inverse dynamics; of
     * the pieces behind on the last body, then what that is wrong by */
    BORDER_FORCE,
    BORDER_PRESSED = BORDER_FORCE + 6,
    BORDER_BEHIND = BORDER_PRESSED + 6,
    BORDER_ROWS = BORDER_BEHIND + 6
};

struct pieces {
    const struct tfa_model *m;
    uint32_t length; /* bodies of the chain */
    uint32_t pieces; /* a power of 2, at least 8 */
    uint32_t rows;   /* bodies of a piece */
    uint32_t groups; /* pieces / NUM_LANES */
    uint32_t width;  /* of the border: one column behind that of the last piece is of no piece */
    struct tfa_crew *crew;
    struct piece_body *body; /* rows + 1 of each group, the first one the body before the piece */
    struct piece_row *row;   /* the same */
    struct piece_factors *last;     /* of the pieces' last rows, in the order of elimination */
    double *border;                 /* BORDER_ROWS x width */
    double *unrefined;              /* 12 x width: BORDER_V and BORDER_FORCE before corrections */
    num *finite, *sum_qdd, *sum_dx; /* by group: 0 or not a number; sums of squares */
    double *residual, *change;      /* of all joints, public order */
    /* the request under way */
    const double *q, *qd, *tau; /* public arrays; NULL: zero */
    double *qdd;
    vec3 gravity;
    int moving;
    int what; /* PIECES_ bits */
};

/* What a step computes. BIAS: velocities, gravity and wrenches count; without it the right-hand
 * side is a residual, and what is found is added to qdd. */
enum { PIECES_FACTOR = 1, PIECES_BIAS = 2, PIECES_PERTURBED = 4 };

static inline struct piece_body *piece_bodies(const struct pieces *p, uint32_t group)
{
    return p->body + (size_t)group * (p->rows + 1);
}

static inline struct piece_row *piece_rows(const struct pieces *p, uint32_t group)
{
    return p->row + (size_t)group * (p->rows + 1);
}

/* Row `e` of the border, at the first piece of a group */
static inline double *border_at(const struct pieces *p, int e, uint32_t group)
{
    return p->border + (size_t)e * p->width + (size_t)group * NUM_LANES;
}

static inline num border_get(const struct pieces *p, int e, uint32_t group)
{
    return *(const num *)(const void *)border_at(p, e, group);
}

static inline void border_put(const struct pieces *p, int e, uint32_t group, num x)
{
    *(num *)(void *)border_at(p, e, group) = x;
}

static inline void border_put_many(const struct pieces *p, int e, uint32_t group, const num *x,
                                   int count)
{
    for (int k = 0; k < count; k++)
        border_put(p, e + k, group, x[k]);
}

static inline void border_get_many(const struct pieces *p, int e, uint32_t group, num *x, int count)
{
    for (int k = 0; k < count; k++)
        x[k] = border_get(p, e + k, group);
}

/* Column `piece` of rows of the border in every lane */
static inline void border_column(const struct pieces *p, int e, uint32_t piece, num *x, int count)
{
    for (int k = 0; k < count; k++)
        x[k] = num_of(p->border[(size_t)(e + k) * p->width + piece]);
}

static inline void border_put_column(const struct pieces *p, int e, uint32_t piece, svec x)
{
    const num out[6] = {x.w.x, x.w.y, x.w.z, x.v.x, x.v.y, x.v.z};
    for (int k = 0; k < 6; k++)
        p->border[(size_t)(e + k) * p->width + piece] = num_lane(out[k], 0);
}

/* pieces.c: memory and constants */
size_t TFA_V(pieces_walk)(const struct tfa_model *m, void *base, struct pieces **out);
struct pieces *TFA_V(pieces_init)(const struct tfa_model *m, void *memory);

/* pieces_motion.c: X of every body, velocities and what they are wrong by at the borders. BORDER_DV
 * from BORDER_V and BORDER_MOVED */
void TFA_V(pieces_motion)(struct pieces *p);
void TFA_V(pieces_close_gaps)(const struct pieces *p);

/* pieces_last.c: x of the last row of each piece, in place of BORDER_B */
void TFA_V(pieces_last)(struct pieces *p);

/* pieces_solve.c: factors of all rows but the pieces' last; with them, the same rows of another
 * rhs; qdd; qdd += M^-1 rhs with kept factors, and the sums of squares. The last two leave BORDER_V
 * and BORDER_FORCE of the solution. */
void TFA_V(pieces_factor)(struct pieces *p);
void TFA_V(pieces_eliminate)(struct pieces *p);
void TFA_V(pieces_forward)(struct pieces *p);
void TFA_V(pieces_correct)(struct pieces *p);

/* pieces_lambda.c: Lambda^-1 of a checked request for one tip on the last body */
void TFA_V(pieces_lambda)(struct pieces *p, const tfa_request *r, double *lambda);

/* pieces_residual.c: rhs = tau - RNEA(qdd), perturbed (perturb.h) or not; rhs of the joint before each
 * piece from that of the piece before */
void TFA_V(pieces_residual)(struct pieces *p, int perturbed);
void TFA_V(pieces_tell_next)(const struct pieces *p);

#endif
