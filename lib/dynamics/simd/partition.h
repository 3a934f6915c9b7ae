/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One long chain of revolute bodies in partitions of equal length, as many in parallel as a
 * number has lanes: lane l of group g is partition NUM_LANES g + l. Values that partitions exchange
 * is stored by partition, in the interface arrays. How many partitions there are depends on the
 * chain alone, so that an answer is the same for any number of lanes and threads. Behind the last
 * body of the chain the last partitions are filled up with bodies that nothing couples to.
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
#ifndef TFA_DYNAMICS_SIMD_PARTITION_H
#define TFA_DYNAMICS_SIMD_PARTITION_H

#include <totalforce/dynamics.h>

#include "interface/parallel_for.h"
#include "model/arena.h"
#include "model/model.h"
#include "spatial/block5.h"

/* Constants of the bodies at one place of NUM_LANES partitions */
struct partition_body {
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
    num is_body_mask;         /* the same as a factor */
};

/* Factors of one elimination, for back substitution */
struct block_factors {
    sym5 M;  /* D = M diag M^T */
    mat5 ZL; /* M^-1 times the coupling to the row on the left */
    mat5 ZU; /* M^-1 times the coupling to the row on the right */
    vec5 y;  /* M^-1 b */
};

/* State */
struct block_row {
    struct block_factors factors;
    xform X;
    svec v, p; /* of a chain that moves */
    svec a;    /* residual */
    num sine, cosine;
    num qd, tau;
    num rhs; /* tau, or the residual */
    num qdd;
    num unrefined; /* qdd before its corrections */
};

/* Rows of the interface arrays: one number of each partition */
enum {
    /* 12: from the frame before the partition to its last body */
    INTERFACE_XFORM = 0,
    /* 6: velocity of the last body, first where the body before rests; then its acceleration */
    INTERFACE_END_MOTION = 12,
    /* 6: velocity of the body before, then its acceleration by the solution; and the value that
     * is wrong by */
    INTERFACE_MOTION = 18,
    INTERFACE_MOTION_GAP = 24,
    /* 15 + 25 + 5: the last row after elimination: its diagonal block, its coupling to the last row
     * of the partition before, its right-hand side; then x */
    INTERFACE_D = 30,
    INTERFACE_L = INTERFACE_D + 15,
    INTERFACE_B = INTERFACE_L + 25,
    /* 15 + 5: contribution of the partition to that row of the partition before */
    INTERFACE_LEFT_D = INTERFACE_B + 5,
    INTERFACE_LEFT_B = INTERFACE_LEFT_D + 15,
    /* angular acceleration about its axis: of the body before; of the last body with nothing behind
     * it; of the body before the last, about the axis of the last */
    INTERFACE_RATE = INTERFACE_LEFT_B + 5,
    INTERFACE_RATE_FREE,
    INTERFACE_RATE_INBOARD,
    /* 6: force of the partition on the body before as the solution has it, and by inverse dynamics;
     * of the partitions behind on the last body, then its error */
    INTERFACE_FORCE,
    INTERFACE_FORCE_RNEA = INTERFACE_FORCE + 6,
    INTERFACE_FORCE_OUTBOARD = INTERFACE_FORCE_RNEA + 6,
    INTERFACE_ROWS = INTERFACE_FORCE_OUTBOARD + 6
};

struct partition {
    const struct tfa_model *m;
    uint32_t length;     /* bodies of the chain */
    uint32_t partitions; /* a power of 2, at least 8 */
    uint32_t rows;       /* bodies of a partition */
    uint32_t groups;     /* partitions / NUM_LANES */
    uint32_t
        /* of the interface arrays: one column behind that of the last partition is of no
         * partition */
        width;
    struct tfa_executor *executor;
    /* rows + 1 of each group, the first one the body before the partition */
    struct partition_body *body;
    struct block_row *row; /* the same */
    /* of the partitions' last rows, in the order of elimination */
    struct block_factors *interface_factors;
    double *interface; /* INTERFACE_ROWS x width */
    double *unrefined; /* 12 x width: INTERFACE_MOTION and INTERFACE_FORCE before corrections */
    num *finite, *sum_qdd, *sum_dx; /* by group: 0 or not a number; sums of squares */
    double *residual, *change;      /* of all joints, public order */
    /* the request under way */
    const double *q, *qd, *tau; /* public arrays; NULL: zero */
    double *qdd;
    vec3 gravity;
    int moving;
    int flags; /* PARTITION_ bits */
};

/* Parts of a step. BIAS: velocities, gravity and wrenches count; without it the right-hand
 * side is a residual, and the solution is added to qdd. */
enum { PARTITION_FACTOR = 1, PARTITION_BIAS = 2, PARTITION_PERTURBED = 4 };

static inline struct partition_body *group_bodies(const struct partition *p, uint32_t group)
{
    return p->body + (size_t)group * (p->rows + 1);
}

static inline struct block_row *group_rows(const struct partition *p, uint32_t group)
{
    return p->row + (size_t)group * (p->rows + 1);
}

/* Row `e` of the interface, at the first partition of a group */
static inline double *interface_at(const struct partition *p, int e, uint32_t group)
{
    return p->interface + (size_t)e * p->width + (size_t)group * NUM_LANES;
}

static inline num interface_get(const struct partition *p, int e, uint32_t group)
{
    return *(const num *)(const void *)interface_at(p, e, group);
}

static inline void interface_put(const struct partition *p, int e, uint32_t group, num x)
{
    *(num *)(void *)interface_at(p, e, group) = x;
}

static inline void interface_put_many(const struct partition *p, int e, uint32_t group,
                                      const num *x, int count)
{
    for (int k = 0; k < count; k++)
        interface_put(p, e + k, group, x[k]);
}

static inline void interface_get_many(const struct partition *p, int e, uint32_t group, num *x,
                                      int count)
{
    for (int k = 0; k < count; k++)
        x[k] = interface_get(p, e + k, group);
}

/* Column `part` of rows of the interface arrays in every lane */
static inline void interface_column(const struct partition *p, int e, uint32_t part, num *x,
                                    int count)
{
    for (int k = 0; k < count; k++)
        x[k] = num_of(p->interface[(size_t)(e + k) * p->width + part]);
}

static inline void interface_put_column(const struct partition *p, int e, uint32_t part, svec x)
{
    const num out[6] = {x.w.x, x.w.y, x.w.z, x.v.x, x.v.y, x.v.z};
    for (int k = 0; k < 6; k++)
        p->interface[(size_t)(e + k) * p->width + part] = num_lane(out[k], 0);
}

/* partition.c: memory and constants */
size_t TFA_V(partition_walk)(const struct tfa_model *m, void *base, struct partition **out);
struct partition *TFA_V(partition_init)(const struct tfa_model *m, void *memory);

/* partition_motion.c: X of every body, velocities and their errors at the interfaces.
 * INTERFACE_MOTION_GAP from INTERFACE_MOTION and INTERFACE_END_MOTION */
void TFA_V(partition_motion)(struct partition *p);
void TFA_V(partition_close_gaps)(const struct partition *p);

/* partition_interface_solve.c: x of the last row of each partition, in place of INTERFACE_B */
void TFA_V(partition_interface_solve)(struct partition *p);

/* partition_solve.c: factors of all rows but the partitions' last; with them, the same rows of
 * another rhs; qdd; qdd += M^-1 rhs with kept factors, and the sums of squares. The last two leave
 * INTERFACE_MOTION and INTERFACE_FORCE of the solution. */
void TFA_V(partition_factor)(struct partition *p);
void TFA_V(partition_eliminate)(struct partition *p);
void TFA_V(partition_forward)(struct partition *p);
void TFA_V(partition_correct)(struct partition *p);

/* partition_lambda.c: Lambda^-1 of a checked request for one tip on the last body */
void TFA_V(partition_lambda)(struct partition *p, const tfa_request *r, double *lambda);

/* partition_residual.c: rhs = tau - RNEA(qdd), perturbed (perturb.h) or not; rhs of the joint
 * before each partition from that of the partition before */
void TFA_V(partition_residual)(struct partition *p, int perturbed);
void TFA_V(partition_share_rhs)(const struct partition *p);

#endif
