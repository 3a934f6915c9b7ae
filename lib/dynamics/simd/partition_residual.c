/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The residual tau - RNEA(qdd) of a partitioned chain. Each partition starts from the acceleration
 * of the body before it and from the force behind it that the solution has (INTERFACE_MOTION,
 * INTERFACE_FORCE), and ends on a slightly different value than its neighbour started from. These
 * gaps follow from one another along the interfaces,
 *
 *   da before partition l + 1 = X da before partition l + (a of its last body - a before partition
 *   l + 1)
 *   df behind partition l     = X^T df behind partition l + 1 + (f of its first joint - f that
 *   partition l had)
 *
 * and the partitions carry them to all their bodies. So every joint's acceleration and force
 * differs from RNEA's by roundings of its own size. A partition that starts on a body at rest would
 * lose roundings of the sum over the whole partition, which in light bodies between heavy ones
 * is a million times more. Perturbed as in rnea.c; the small da and df need no perturbation.
 */
#include "dynamics/core/perturb.h"
#include "dynamics/core/revolute.h"
#include "dynamics/simd/partition.h"

/* By the row, alike in all partitions */
static inline struct perturb_start row_start(uint32_t k)
{
    return (struct perturb_start){{PERTURB_EACH * k % PERTURB_COUNT}};
}

/* The joint's velocity as a spatial vector */
static inline svec joint_velocity(const struct block_row *r, uint32_t k)
{
    return (svec){v3(num_of(0), num_of(0), r[k].qd), v3_zero()};
}

/* X a + c + H qdd */
static inline svec row_motion(const struct partition *p, const struct block_row *r, uint32_t k,
                              svec a, int perturbed)
{
    const xform X = xform_abs(&r[k].X, 1);
    svec size = xform_motion_abs(&X, sv_abs(a));
    a = xform_motion(&r[k].X, a);
    if (p->moving) {
        a = sv_add(a, revolute_velocity_product(r[k].v, r[k].qd));
        size = sv_add(size, cross_motion_abs(sv_abs(r[k].v), sv_abs(joint_velocity(r, k))));
    }
    a.w.z += r[k].qdd;
    const struct perturb_start start = row_start(k);
    return perturbed ? sv_perturb(a, size, &start, 0) : a;
}

/* I a + p */
static inline svec row_force(const struct partition *p, const struct partition_body *b,
                             const struct block_row *r, uint32_t k, svec a, int perturbed)
{
    svec f = s6_rigid_mul(b[k].I, b[k].h, b[k].mass, a);
    if (p->moving)
        f = sv_add(f, r[k].p);
    if (!perturbed)
        return f;
    const svec v = sv_abs(r[k].v);
    svec size = rigid_mul_abs(b[k].I, b[k].h, b[k].mass, sv_abs(a));
    if (p->moving)
        size = sv_add(size, rigid_bias_abs(b[k].I, b[k].h, b[k].mass, v));
    const struct perturb_start start = row_start(k);
    return sv_perturb(f, size, &start, 6);
}

/* X^T f */
static inline svec row_force_to_parent(const struct block_row *r, uint32_t k, svec f, int perturbed)
{
    const svec up = xform_t_force(&r[k].X, f);
    if (!perturbed)
        return up;
    const xform X = xform_abs(&r[k].X, 1);
    const struct perturb_start start = row_start(k);
    return sv_perturb(up, xform_t_force_abs(&X, sv_abs(f)), &start, 12);
}

/* a of each body, from the one that the solution has before the partition; of the last one to the
 * interface */
static inline __attribute__((always_inline)) void move(const struct partition *p, uint32_t g,
                                                       int perturbed)
{
    struct block_row *r = group_rows(p, g);
    svec a;
    interface_get_many(p, INTERFACE_MOTION, g, &a.w.x, 6);
    for (uint32_t k = 1; k <= p->rows; k++) {
        a = r[k].a = row_motion(p, r, k, a, perturbed);
    }
    interface_put_many(p, INTERFACE_END_MOTION, g, &a.w.x, 6);
}

/* rhs = tau - H^T f with the force behind the partition that the solution has; the force on the
 * body before the partition to the interface */
static inline __attribute__((always_inline)) void inward_force(const struct partition *p,
                                                               uint32_t g, int perturbed)
{
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    svec da, f;
    interface_get_many(p, INTERFACE_MOTION_GAP, g, &da.w.x, 6);
    for (uint32_t k = 1; k <= p->rows; k++) {
        da = xform_motion(&r[k].X, da);
        r[k].a = sv_add(r[k].a, da);
    }
    interface_get_many(p, INTERFACE_FORCE_OUTBOARD, g, &f.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        f = sv_add(f, row_force(p, b, r, k, r[k].a, perturbed));
        r[k].rhs = r[k].tau - f.w.z;
        f = row_force_to_parent(r, k, f, perturbed);
    }
    interface_put_many(p, INTERFACE_FORCE_RNEA, g, &f.w.x, 6);
}

/* To its joints' places in the array for the error solver */
static inline void store_residual(const struct partition *p, const struct partition_body *b,
                                  num rest)
{
    for (uint32_t l = 0; l < NUM_LANES; l++)
        if (b->real[l])
            p->residual[b->v[l]] = num_lane(rest, l);
}

/* rhs -= H^T df for the error df of the force behind the partition */
static inline __attribute__((always_inline)) void subtract_gap(const struct partition *p,
                                                               uint32_t g, int perturbed)
{
    const struct partition_body *b = group_bodies(p, g);
    struct block_row *r = group_rows(p, g);
    svec df;
    interface_get_many(p, INTERFACE_FORCE_OUTBOARD, g, &df.w.x, 6);
    for (uint32_t k = p->rows; k > 0; k--) {
        r[k].rhs = (r[k].rhs - df.w.z) * b[k].is_body_mask;
        if (perturbed) { /* with the sign that cannot cancel the rest */
            const num e = num_abs(r[k].tau) * NUM_EPSILON;
            r[k].rhs += num_select(r[k].rhs < num_of(0), -e, e);
            store_residual(p, &b[k], r[k].rhs);
        }
        df = xform_t_force(&r[k].X, df);
    }
}

#define PARTITION_TASK(name)                                                                       \
    static void name##_group(void *context, uint32_t g, uint32_t worker)                           \
    {                                                                                              \
        const struct partition *p = context;                                                       \
        (void)worker;                                                                              \
        if (p->flags & PARTITION_PERTURBED)                                                        \
            name(p, g, 1);                                                                         \
        else                                                                                       \
            name(p, g, 0);                                                                         \
    }
PARTITION_TASK(move)
PARTITION_TASK(inward_force)
PARTITION_TASK(subtract_gap)

/* INTERFACE_FORCE_OUTBOARD: the force behind each partition that the solution has on the body
 * before the next one
 */
static void set_outboard_force(const struct partition *p)
{
    for (int e = 0; e < 6; e++) {
        double *behind = p->interface + (size_t)(INTERFACE_FORCE_OUTBOARD + e) * p->width;
        const double *found = p->interface + (size_t)(INTERFACE_FORCE + e) * p->width;
        for (uint32_t l = 0; l < p->partitions; l++)
            behind[l] = l + 1 < p->partitions ? found[l + 1] : 0;
    }
}

/* INTERFACE_FORCE_OUTBOARD: the error of that force */
static void propagate_force_gaps(const struct partition *p)
{
    svec df = sv_zero();
    for (uint32_t l = p->partitions; l-- > 0;) {
        xform X;
        svec pressed, found;
        interface_put_column(p, INTERFACE_FORCE_OUTBOARD, l, df);
        interface_column(p, INTERFACE_XFORM, l, &X.E.xx, 12);
        interface_column(p, INTERFACE_FORCE_RNEA, l, &pressed.w.x, 6);
        interface_column(p, INTERFACE_FORCE, l, &found.w.x, 6);
        df = sv_add(xform_t_force(&X, df), sv_sub(pressed, found));
    }
}

void TFA_V(partition_share_rhs)(const struct partition *p)
{
    for (uint32_t part = 1; part < p->partitions; part++) {
        const struct block_row *from = &group_rows(p, (part - 1) / NUM_LANES)[p->rows];
        struct block_row *to = group_rows(p, part / NUM_LANES);
        ((double *)&to->rhs)[part % NUM_LANES] = num_lane(from->rhs, (part - 1) % NUM_LANES);
    }
}

void TFA_V(partition_residual)(struct partition *p, int perturbed)
{
    p->flags = perturbed ? PARTITION_PERTURBED : 0;
    interface_put_column(p, INTERFACE_MOTION, 0, (svec){v3_zero(), v3_neg(p->gravity)});
    parallel_for(p->executor, move_group, p, p->groups);
    TFA_V(partition_close_gaps)(p);
    set_outboard_force(p);
    parallel_for(p->executor, inward_force_group, p, p->groups);
    propagate_force_gaps(p);
    parallel_for(p->executor, subtract_gap_group, p, p->groups);
    TFA_V(partition_share_rhs)(p);
}
