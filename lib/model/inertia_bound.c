/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Upper bounds of the inertia that each joint moves at any q. The sentinel compares the projected
 * articulated inertia D with them (dynamics/core/sentinel.h).
 *
 * For the subtree of a body, with rho an upper bound of the distance of its mass from the origin of
 * the body's frame: mass, first moment (integral of rho) and second moment (integral of rho^2). In
 * a frame whose origin is at most L away:  mass,  first + L mass,  second + 2 L first + L^2 mass.
 */
#include "model/inertia_bound.h"

#include <math.h>

/* Assumed travel of prismatic, planar and floating joints, m: the model has no limits. */
#define JOINT_TRAVEL 1.0

static struct tfa_moments shifted(struct tfa_moments s, double length)
{
    return (struct tfa_moments){.mass = s.mass,
                                .first = s.first + length * s.mass,
                                .second = s.second + length * (2 * s.first + length * s.mass)};
}

static void add(struct tfa_moments *to, struct tfa_moments s)
{
    to->mass += s.mass;
    to->first += s.first;
    to->second += s.second;
}

static double norm(const double *x, int n)
{
    double sum = 0;
    for (int k = 0; k < n; k++)
        sum += x[k] * x[k];
    return sqrt(sum);
}

static double joint_travel(uint8_t kind)
{
    return is_revolute(kind) ? 0 : JOINT_TRAVEL;
}

/* Largest distance between the origins of the parent's frame and the body's, joints that slide no
 * farther than this share of their travel */
static double distance(const struct tfa_model *m, const struct tfa_body *b, double travel)
{
    if (!is_fused(b->kind))
        return norm(b->r, 3) + travel * joint_travel(b->kind);
    double sum = 0;
    for (uint32_t k = 0; k < b->n; k++)
        sum += norm(m->part[b->part + k].r, 3) + travel * joint_travel(m->part[b->part + k].kind);
    return sum;
}

static double reach(const struct tfa_model *m, const struct tfa_body *b)
{
    return distance(m, b, 1);
}

/* Largest distance of the body's origin from the axis z of its parent */
static double reach_from_axis(const struct tfa_model *m, const struct tfa_body *b)
{
    return is_fused(b->kind) ? reach(m, b) : norm(b->r, 2) + joint_travel(b->kind);
}

/* Of one body: the second moment about a point is half the trace of the inertia there, and
 * first^2 <= mass second (Cauchy, Schwarz). */
static struct tfa_moments moments_of(const struct tfa_body *b)
{
    const double second = (b->I[0] + b->I[3] + b->I[5]) / 2;
    return (struct tfa_moments){b->mass, sqrt(b->mass * fmax(second, 0)), second, b->I[5]};
}

/* Bounds of the freedoms of a body whose subtree has these moments */
static void bound_freedoms(const struct tfa_model *m, struct tfa_body *b, struct tfa_moments s)
{
    double length = 0; /* from the axis of a fused part to the body's origin */
    for (uint32_t k = b->n; k-- > 0;) {
        const struct tfa_part *part = &m->part[b->part + k];
        const int fused = is_fused(b->kind);
        const int angular = fused ? is_revolute(part->kind) : freedom_rotates(b->kind, k);
        const double all = is_free(b->kind) || fused ? shifted(s, length).second : s.about_z;
        b->bound[k] = (angular ? all : s.mass) + m->armature[b->v + k];
        if (fused)
            length += norm(part->r, 3) + joint_travel(part->kind);
    }
}

static struct tfa_moments *moments_at(struct tfa_moments *scratch, size_t stride, uint32_t body)
{
    return (struct tfa_moments *)((char *)scratch + body * stride);
}

/* ---- characteristic length ---- */

/* Share of the longest path */
#define LENGTH_SHARE 0.25

/* A quarter of the longest way from a root along joints to a centre of mass, at any q. It has the
 * unit of the model, so that nothing depends on it. 1 where there is no way. */
static double characteristic_length(const struct tfa_model *m, const struct tfa_body *body,
                                    struct tfa_moments *scratch, size_t stride)
{
    double longest = 0;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &body[i];
        double *const path = &moments_at(scratch, stride, i)->first;
        *path = distance(m, b, 0);
        if (b->parent >= 0)
            *path += moments_at(scratch, stride, (uint32_t)b->parent)->first;
        longest = fmax(longest, *path + (b->mass > 0 ? norm(b->h, 3) / b->mass : 0));
    }
    return longest > 0 ? LENGTH_SHARE * longest : 1;
}

void tfa_inertia_bounds(struct tfa_model *m, struct tfa_body *body, struct tfa_moments *scratch,
                        size_t stride)
{
    m->reach = 0;
    m->length = characteristic_length(m, body, scratch, stride);
    for (uint32_t i = 0; i < m->bodies; i++) {
        struct tfa_moments *s = moments_at(scratch, stride, i);
        *s = moments_of(&body[i]);
        m->reach += reach(m, &body[i]);
    }
    for (uint32_t i = m->bodies; i-- > 0;) {
        struct tfa_body *b = &body[i];
        const struct tfa_moments *s = moments_at(scratch, stride, i);
        bound_freedoms(m, b, *s);
        if (b->parent < 0)
            continue;
        struct tfa_moments *parent = moments_at(scratch, stride, (uint32_t)b->parent);
        parent->about_z += shifted(*s, reach_from_axis(m, b)).second;
        add(parent, shifted(*s, reach(m, b)));
    }
}
