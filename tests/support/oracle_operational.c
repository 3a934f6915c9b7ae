/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle's operational space. See oracle_operational.h.
 */
#include "oracle_operational.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "oracle_motion.h"

void oracle_jacobian(const oracle *o, const oracle_tips *tips, quad *J)
{
    const size_t n = o->rows;
    quad *six = calloc(6 * n + 1, sizeof *six);
    if (!six)
        abort();
    for (uint32_t t = 0; t < tips->count; t++) {
        memset(six, 0, 6 * n * sizeof *six);
        oracle_tip_rows(o, tips->links[t], tips->frame, six);
        memcpy(J + (size_t)t * tips->rows * n, six, tips->rows * n * sizeof *six);
    }
    free(six);
}

/* Writes two vectors of the world in the axes of the frame. */
static void store(const struct body *b, const oracle_tips *tips, vec3 linear, vec3 angular,
                  uint32_t rows, quad *out)
{
    if (tips->frame == TFA_FRAME_LOCAL) {
        linear = mat_apply_transposed(&b->R, linear);
        angular = mat_apply_transposed(&b->R, angular);
    }
    for (uint32_t i = 0; i < rows; i++)
        out[i] = i < 3 ? linear.x[i] : angular.x[i - 3];
}

void oracle_bias_acceleration(const oracle *o, const oracle_tips *tips, quad *a)
{
    for (uint32_t t = 0; t < tips->count; t++) {
        const struct body *b = &o->body[tips->links[t]];
        vec3 linear = b->a;
        if (tips->frame == TFA_FRAME_LOCAL) /* axes that turn: d(R^T v)/dt = R^T (a - w x v) */
            linear = vec_sub(linear, vec_cross(b->w, b->v));
        if (tips->frame == TFA_FRAME_WORLD) /* d(v - w x p)/dt */
            linear = vec_sub(linear, vec_add(vec_cross(b->alpha, b->p), vec_cross(b->w, b->v)));
        store(b, tips, linear, b->alpha, tips->rows, a + (size_t)t * tips->rows);
    }
}

void oracle_twists(const oracle *o, const oracle_tips *tips, quad *twists)
{
    for (uint32_t t = 0; t < tips->count; t++) {
        const struct body *b = &o->body[tips->links[t]];
        vec3 linear = b->v;
        if (tips->frame == TFA_FRAME_WORLD)
            linear = vec_sub(linear, vec_cross(b->w, b->p));
        store(b, tips, linear, b->w, 6, twists + 6 * (size_t)t);
    }
}

void oracle_accelerate(const oracle *o, quad *x)
{
    for (uint32_t k = 0; k < o->rows; k++) {
        int tied = 0;
        for (uint32_t i = 0; i < o->n && !tied; i++)
            tied = o->tie[i].to == k;
        x[k] = tied ? x[k] : 0;
    }
    oracle_solve(o, x);
}

void oracle_inverse_of_rows(const oracle *o, const quad *J, uint32_t m, quad *A)
{
    const size_t n = o->rows;
    quad *G = calloc(m * n + 1, sizeof *G), *D = calloc(m * n + 1, sizeof *D);
    if (!G || !D)
        abort();
    memcpy(G, J, m * n * sizeof *G);
    for (uint32_t i = 0; i < m; i++) {
        oracle_solve_lower(o, G + i * n);
        for (size_t k = 0; k < n; k++)
            D[i * n + k] = G[i * n + k] / o->LDL[k * n + k];
    }
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j <= i; j++) {
            quad sum = 0;
            for (size_t k = 0; k < n; k++)
                sum += G[i * n + k] * D[j * n + k];
            A[(size_t)i * m + j] = A[(size_t)j * m + i] = sum;
        }
    free(D);
    free(G);
}

oracle_centroid oracle_sums_of(const oracle *o)
{
    const struct oracle_sums *s = &o->moving;
    oracle_centroid c = {
        .mass = s->mass, .kinetic = s->kinetic, .potential = -vec_dot(o->gravity, s->moment)};
    if (!(s->mass > 0))
        return c;
    const vec3 com = vec_scale(1 / s->mass, s->moment);
    const vec3 spin = vec_sub(s->angular, vec_cross(com, s->momentum));
    for (int i = 0; i < 3; i++) {
        c.com[i] = com.x[i];
        c.velocity[i] = s->momentum.x[i] / s->mass;
        c.momentum[i] = s->momentum.x[i];
        c.momentum[3 + i] = spin.x[i];
    }
    return c;
}

void oracle_com_jacobian(const oracle *o, quad *J)
{
    memset(J, 0, 3 * (size_t)o->rows * sizeof *J);
    for (uint32_t k = 0; k < o->n; k++) {
        const oracle_tie *t = &o->tie[k];
        for (int i = 0; i < 3 && t->to != ORACLE_STILL; i++)
            J[(size_t)i * o->rows + t->to] +=
                t->multiplier * o->moment_rate[k].x[i] / o->moving.mass;
    }
}

void oracle_bias_force(const oracle *o, quad *h)
{
    memcpy(h, o->ht, o->rows * sizeof *h);
}

double oracle_pose_error(const oracle *o, uint32_t link, const double pose[7])
{
    double p[3], R[9], far = 0, off = 0, turned = 0;
    const double *q = pose + 3;
    oracle_pose(o, link, p, R);
    for (int i = 0; i < 3; i++) {
        far = hypot(far, p[i]);
        off = hypot(off, pose[i] - p[i]);
    }
    for (int k = 0; k < 3; k++) { /* columns: e_k turned by the quaternion */
        double e[3] = {k == 0, k == 1, k == 2}, t[3], difference = 0;
        for (int i = 0; i < 3; i++)
            t[i] = 2 * (q[(i + 1) % 3] * e[(i + 2) % 3] - q[(i + 2) % 3] * e[(i + 1) % 3]);
        for (int i = 0; i < 3; i++)
            difference =
                hypot(difference, e[i] + q[3] * t[i] + q[(i + 1) % 3] * t[(i + 2) % 3] -
                                      q[(i + 2) % 3] * t[(i + 1) % 3] - R[3 * i + k]);
        turned = fmax(turned, difference);
    }
    const double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double error = fmax(fmax(off / fmax(far, 1), turned), fabs(size - 1));
    return q[3] >= 0 && !isnan(off + turned + size) ? error : (double)INFINITY;
}
