/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows of constraints between frames.
 */
#include "dynamics/osim/constraint_rows.h"

#include <math.h>

#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/lambda.h"

/* ---- which ---- */

/* A tip for each side on a link; -1: the world */
static int32_t add_side(struct state *s, const struct tfa_closure *of, uint32_t k, int side)
{
    if (of->frame[side] < 0)
        return -1;
    s->tip[s->tips] = (uint32_t)of->frame[side];
    s->closing_side[s->tips] = (uint8_t)(2 * k + (uint32_t)side);
    return (int32_t)s->tips++;
}

void TFA_V(constraints_activate)(struct state *s, uint32_t constraints)
{
    s->tips = s->closings = s->closing_rows = 0;
    s->tip_rows = 6;
    s->located = 0;
    s->path_body = s->psi_frame = -1;
    for (uint32_t k = 0; k < s->m->constraints; k++) {
        const struct tfa_closure *of = &s->m->closure[k];
        if (!(constraints >> k & 1))
            continue;
        struct closing *c = &s->closing[s->closings];
        c->of = of;
        c->held = (uint32_t)__builtin_popcount(of->rows);
        for (int side = 0; side < 2; side++)
            c->tip[side] = add_side(s, of, s->closings, side);
        for (uint32_t e = 0; e < 6; e++)
            if (of->rows >> e & 1)
                s->closing_row[s->closing_rows++] = (uint8_t)(6 * s->closings + e);
        s->closings++;
    }
}

/* ---- where ---- */

/* A frame of a constraint in the world; motion of it */
struct end {
    mat3 R, link;       /* axes of the frame, of the link, by columns */
    vec3 x, v, w, a, b; /* origin; velocity, angular; bias accelerations, b: angular */
};

static vec3 first_three(const num *x)
{
    return v3(x[0], x[1], x[2]);
}

/* The link's frame in the world, by columns */
static xform link_in_world(struct state *s, int32_t t, struct tip *at)
{
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (t < 0)
        return (xform){m3_load(identity), v3_zero()};
    TFA_V(tip_locate)(s, (uint32_t)t, TFA_FRAME_LOCAL, at);
    at->frame = TFA_FRAME_LOCAL_WORLD_ALIGNED;
    return (xform){at->axes, vec3_of_simd(at->p)};
}

static struct end end_of(struct state *s, struct closing *c, int side)
{
    struct tip at;
    const xform link = link_in_world(s, c->tip[side], &at);
    const vec3 p = c->arm[side] = m3_mul(link.E, v3_load(c->of->p[side]));
    struct end e = {
        .R = m3_mm(link.E, m3_load(c->of->R[side])), .link = link.E, .x = v3_add(link.r, p)};
    e.v = e.w = e.a = e.b = v3_zero();
    if (c->tip[side] < 0)
        return e;
    num twist[6], bias[6];
    struct tip_velocity motion;
    TFA_V(tip_velocity)(s, &at, &motion);
    TFA_V(tip_twist)(&at, &motion, twist);
    TFA_V(tip_acceleration)(s, &at, &motion, NULL, bias);
    e.w = first_three(twist + 3);
    e.b = first_three(bias + 3);
    e.v = v3_add(first_three(twist), v3_cross(e.w, p));
    e.a = v3_add(v3_add(first_three(bias), v3_cross(e.b, p)), v3_cross(e.w, v3_cross(e.w, p)));
    return e;
}

static void store(num *out, vec3 linear, vec3 angular)
{
    out[0] = linear.x;
    out[1] = linear.y;
    out[2] = linear.z;
    out[3] = angular.x;
    out[4] = angular.y;
    out[5] = angular.z;
}

/* Errors of rotation D = R1^T R2 whose rates are those of w where they are 0: where one axis is
 * free, by the direction of that axis; with all three held, of the antisymmetric part. */
static vec3 rotation_error(const mat3 *D, uint32_t rows)
{
    const num half = num_of(0.5);
    switch (rows >> 3) {
    case 3:
        return v3(-D->yz, D->xz, num_of(0));
    case 5:
        return v3(D->zy, num_of(0), -D->xy);
    case 6:
        return v3(num_of(0), -D->zx, D->yx);
    default:
        return v3(half * (D->zy - D->yz), half * (D->xz - D->zx), half * (D->yx - D->xy));
    }
}

void TFA_V(constraints_locate)(struct state *s)
{
    for (uint32_t k = 0; k < s->closings; k++) {
        struct closing *c = &s->closing[k];
        struct relative_motion *motion = &s->relative[k];
        const struct end first = end_of(s, c, 0), second = end_of(s, c, 1);
        const mat3 D = m3_tmm(first.R, second.R);
        const vec3 v = v3_sub(second.v, first.v), w = v3_sub(second.w, first.w);
        const vec3 a = v3_sub(v3_sub(second.a, first.a), v3_cross(first.w, v));
        const vec3 b = v3_sub(v3_sub(second.b, first.b), v3_cross(first.w, w));
        c->R = first.R;
        for (int side = 0; side < 2; side++)
            c->axes[side] = m3_tmm(side ? second.link : first.link, first.R);
        store(motion->position, m3_tmul(first.R, v3_sub(second.x, first.x)),
              rotation_error(&D, c->of->rows));
        store(motion->velocity, m3_tmul(first.R, v), m3_tmul(first.R, w));
        store(motion->bias, m3_tmul(first.R, a), m3_tmul(first.R, b));
    }
}

/* ---- rows ---- */

void TFA_V(closing_at)(const struct state *s, uint32_t t, mat3 *R, vec3 *p)
{
    const struct closing *c = &s->closing[s->closing_side[t] / 2];
    const uint32_t side = s->closing_side[t] % 2;
    const xform link = frame_in_body(s, s->tip[t]);
    const mat3 axes = m3_mm(link.E, c->axes[side]);
    const num sign = num_of(side ? 1 : -1);
    *R = (mat3){sign * axes.xx, sign * axes.xy, sign * axes.xz, sign * axes.yx, sign * axes.yy,
                sign * axes.yz, sign * axes.zx, sign * axes.zy, sign * axes.zz};
    *p = v3_add(link.r, m3_mul(link.E, v3_load(c->of->p[side])));
}

void TFA_V(constraint_jacobian)(struct state *s)
{
    TFA_V(jacobian)(s, TFA_FRAME_LOCAL);
    for (uint32_t k = 0; k < s->closings; k++) {
        const int32_t *tip = s->closing[k].tip;
        for (uint32_t j = 0; tip[0] >= 0 && tip[1] >= 0 && j < s->m->freedoms; j++)
            for (uint32_t e = 0; e < 6; e++)
                tip_columns(s, s->psi, j, (uint32_t)tip[1])[e] +=
                    tip_columns(s, s->psi, j, (uint32_t)tip[0])[e];
    }
}

uint32_t TFA_V(constraint_column)(const struct state *s, uint32_t row)
{
    const int32_t *tip = s->closing[s->closing_row[row] / 6].tip;
    return 6 * (uint32_t)(tip[1] >= 0 ? tip[1] : tip[0]) + s->closing_row[row] % 6;
}

int TFA_V(delassus)(const struct state *s, double *out)
{
    const uint32_t n = 6 * s->closings, stride = row_stride(s->closing_rows);
    double rest = 0;
    for (uint32_t k = 0; k < n * n; k++)
        out[k] = 0;
    for (uint32_t i = 0; i < s->closing_rows; i++)
        for (uint32_t j = i; j < s->closing_rows; j++) {
            const uint32_t row = s->closing_row[i], column = s->closing_row[j];
            num sum = num_of(0);
            for (uint32_t a = 0; a < s->tip_freedoms; a++)
                sum += s->phi[(size_t)stride * a + i] * s->phi[(size_t)stride * a + j];
            sum /= tip_row_scale(s, row % 6) * tip_row_scale(s, column % 6);
            out[n * row + column] = out[n * column + row] = (double)sum;
            rest += out[n * row + column] - out[n * row + column];
        }
    return rest == 0;
}

/* ---- products ---- */

/* Of the link on a side, at its frame's origin, by axes of the first: motion from that of the
 * link; wrench on the link from one on the frame */
static void to_frame(const struct closing *c, int side, const num *link, num *out)
{
    const vec3 w = first_three(link + 3), v = v3_add(first_three(link), v3_cross(w, c->arm[side]));
    store(out, m3_tmul(c->R, v), m3_tmul(c->R, w));
}

static void to_link(const struct closing *c, int side, const num *F, num *out)
{
    const vec3 f = m3_mul(c->R, first_three(F)), n = m3_mul(c->R, first_three(F + 3));
    store(out, f, v3_add(n, v3_cross(c->arm[side], f)));
}

void TFA_V(constraint_motion)(struct state *s, const num *x, num *out)
{
    num relative[6], link[6], frame[6];
    uint32_t row = 0;
    for (uint32_t k = 0; k < s->closings; k++) {
        const struct closing *c = &s->closing[k];
        for (int e = 0; e < 6; e++)
            relative[e] = num_of(0);
        for (int side = 0; side < 2; side++) {
            struct tip at;
            if (c->tip[side] < 0)
                continue;
            TFA_V(tip_locate)(s, (uint32_t)c->tip[side], TFA_FRAME_LOCAL_WORLD_ALIGNED, &at);
            TFA_V(tip_jacobian_mul)(s, &at, x, link);
            to_frame(c, side, link, frame);
            for (int e = 0; e < 6; e++)
                relative[e] += side ? frame[e] : -frame[e];
        }
        for (; row < s->closing_rows && s->closing_row[row] / 6 == k; row++)
            out[row] = relative[s->closing_row[row] % 6];
    }
}

void TFA_V(constraint_force)(struct state *s, const num *F, num *tau)
{
    uint32_t row = 0;
    for (uint32_t k = 0; k < s->closings; k++) {
        const struct closing *c = &s->closing[k];
        num f[6] = {num_of(0), num_of(0), num_of(0), num_of(0), num_of(0), num_of(0)}, link[6];
        for (; row < s->closing_rows && s->closing_row[row] / 6 == k; row++)
            f[s->closing_row[row] % 6] = F[row];
        for (int side = 0; side < 2; side++) {
            struct tip at;
            if (c->tip[side] < 0)
                continue;
            to_link(c, side, f, link);
            for (int e = 0; e < 6; e++)
                link[e] = side ? link[e] : -link[e];
            TFA_V(tip_locate)(s, (uint32_t)c->tip[side], TFA_FRAME_LOCAL_WORLD_ALIGNED, &at);
            TFA_V(tip_jacobian_tmul)(s, &at, link, tau);
        }
    }
}
