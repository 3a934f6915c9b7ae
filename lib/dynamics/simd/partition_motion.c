/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint transforms of a partitioned chain, and the velocities at their interfaces: each partition
 * moves on a body at rest first, which gives its transform as a whole; then the interfaces follow
 * one from the other.
 */
#include "dynamics/core/revolute.h"
#include "dynamics/simd/partition.h"

static inline num gather_coordinate(const double *array, const uint32_t *index)
{
    return array ? num_gather(array, 1, index) : num_of(0);
}

static inline void load_row(const struct partition *p, const struct partition_body *b,
                            struct block_row *r)
{
    num q = gather_coordinate(p->q, b->q);
    num_sincos_many(&q, &r->sine, &r->cosine, 0, 1);
    r->X = (xform){revolute_rotate(b->E, r->sine, r->cosine), b->r};
    r->qd = gather_coordinate(p->qd, b->v) * b->is_body_mask;
    r->rhs = r->tau = (gather_coordinate(p->tau, b->v) - b->damping * r->qd) * b->is_body_mask;
}

/* X of the bodies of a group, and where they move the last body of each partition */
static void move_group(void *context, uint32_t g, uint32_t worker)
{
    const struct partition *p = context;
    const struct partition_body *body = group_bodies(p, g);
    struct block_row *row = group_rows(p, g);
    (void)worker;
    load_row(p, &body[0], &row[0]);
    load_row(p, &body[1], &row[1]);
    xform whole = row[1].X;
    svec v = {{num_of(0), num_of(0), row[1].qd}, v3_zero()};
    for (uint32_t k = 2; k <= p->rows; k++) {
        load_row(p, &body[k], &row[k]);
        whole = xform_compose(&whole, &row[k].X);
        v = xform_motion(&row[k].X, v);
        v.w.z += row[k].qd;
    }
    interface_put_many(p, INTERFACE_XFORM, g, &whole.E.xx, 12);
    interface_put_many(p, INTERFACE_END_MOTION, g, &v.w.x, 6);
}

/* v of every body from INTERFACE_MOTION, and of the last one to INTERFACE_END_MOTION */
static void step_group(void *context, uint32_t g, uint32_t worker)
{
    const struct partition *p = context;
    struct block_row *row = group_rows(p, g);
    svec v;
    (void)worker;
    interface_get_many(p, INTERFACE_MOTION, g, &v.w.x, 6);
    row[0].v = v;
    for (uint32_t k = 1; k <= p->rows; k++) {
        v = xform_motion(&row[k].X, v);
        v.w.z += row[k].qd;
        row[k].v = v;
    }
    interface_put_many(p, INTERFACE_END_MOTION, g, &v.w.x, 6);
}

/* Before partition l + 1 from before partition l. The same in every lane. */
static void propagate_velocities(const struct partition *p)
{
    svec v = sv_zero();
    for (uint32_t l = 0; l < p->partitions; l++) {
        xform X;
        svec moved;
        interface_put_column(p, INTERFACE_MOTION, l, v);
        interface_column(p, INTERFACE_XFORM, l, &X.E.xx, 12);
        interface_column(p, INTERFACE_END_MOTION, l, &moved.w.x, 6);
        v = sv_add(xform_motion(&X, v), moved);
    }
}

/* The rounding of a whole partition's transform, by which no velocity may jump where partitions
 * meet:
 *   dv before partition l + 1 = X dv before partition l + (v of its last body - v before
 *   partition l + 1) */
void TFA_V(partition_close_gaps)(const struct partition *p)
{
    svec dv = sv_zero();
    interface_put_column(p, INTERFACE_MOTION_GAP, 0, dv);
    for (uint32_t l = 0; l + 1 < p->partitions; l++) {
        xform X;
        svec moved, v;
        interface_column(p, INTERFACE_XFORM, l, &X.E.xx, 12);
        interface_column(p, INTERFACE_END_MOTION, l, &moved.w.x, 6);
        interface_column(p, INTERFACE_MOTION, l + 1, &v.w.x, 6);
        dv = sv_add(xform_motion(&X, dv), sv_sub(moved, v));
        interface_put_column(p, INTERFACE_MOTION_GAP, l + 1, dv);
    }
}

void TFA_V(partition_motion)(struct partition *p)
{
    parallel_for(p->executor, move_group, p, p->groups);
    if (!p->moving)
        return;
    propagate_velocities(p);
    parallel_for(p->executor, step_group, p, p->groups);
    TFA_V(partition_close_gaps)(p);
}
