/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The regressor Y of inverse dynamics, tau = Y p, which is linear in the inertial parameters of
 * each link (Atkeson, An and Hollerbach 1986; Khalil and Dombre 2002, chapter 12):
 *
 *     Y = J^T A,   force    f = m a + (w'~ + w~ w~) h            a = p'' - gravity
 *                  moment   n = h x a + I w' + w x I w
 *
 * by axes of the link at its origin, with its Jacobian J, p = (m, h = m c, I about the origin).
 */
#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "spatial/friction.h"

/* Motion of a link by its own axes: a = p'' - gravity, w, w' */
struct link_motion {
    vec3 a, w, b;
};

static struct link_motion link_motion(struct state *s, uint32_t t)
{
    struct tip at;
    struct tip_velocity motion;
    num twist[6], acceleration[6];
    TFA_V(tip_locate)(s, t, TFA_FRAME_LOCAL, &at);
    at.frame = TFA_FRAME_LOCAL_WORLD_ALIGNED;
    TFA_V(tip_velocity)(s, &at, &motion);
    TFA_V(tip_twist)(&at, &motion, twist);
    TFA_V(tip_acceleration)(s, &at, &motion, s->qdd, acceleration);
    const vec3 a = v3(acceleration[0], acceleration[1], acceleration[2]),
               b = v3(acceleration[3], acceleration[4], acceleration[5]),
               w = v3(twist[3], twist[4], twist[5]);
    return (struct link_motion){.a = m3_tmul(at.axes, v3_sub(a, s->gravity)),
                                .w = m3_tmul(at.axes, w),
                                .b = m3_tmul(at.axes, b)};
}

/* out = f^T (w'~ + w~ w~) + (n^T a~)^T: what h is multiplied by. x~ y = x x y. */
static vec3 of_moment(const struct link_motion *m, vec3 f, vec3 n)
{
    const vec3 turned = v3_sub(v3_cross(f, m->b), v3_scale(f, v3_dot(m->w, m->w)));
    return v3_add(v3_add(turned, v3_scale(m->w, v3_dot(m->w, f))), v3_cross(m->a, n));
}

/* n . (I w' + w x I w) = n . I w' + (n x w) . I w by entries of I: ixx ixy ixz iyy iyz izz */
static void of_inertia(const struct link_motion *m, vec3 n, num out[6])
{
    const vec3 k = v3_cross(n, m->w), w = m->w, b = m->b;
    out[0] = n.x * b.x + k.x * w.x;
    out[1] = n.x * b.y + n.y * b.x + k.x * w.y + k.y * w.x;
    out[2] = n.x * b.z + n.z * b.x + k.x * w.z + k.z * w.x;
    out[3] = n.y * b.y + k.y * w.y;
    out[4] = n.y * b.z + n.z * b.y + k.y * w.z + k.z * w.y;
    out[5] = n.z * b.z + k.z * w.z;
}

/* The ten numbers of freedom j for the link of tip t, added to the row of its leader */
static int add_row(const struct state *s, const struct link_motion *m, uint32_t j, uint32_t t,
                   double *Y)
{
    const num *J = tip_columns(s, s->psi, j, t);
    const vec3 f = v3(J[0], J[1], J[2]), n = v3(J[3], J[4], J[5]), h = of_moment(m, f, n);
    num row[TFA_LINK_PARAMETERS] = {v3_dot(f, m->a), h.x, h.y, h.z}, multiplier;
    of_inertia(m, n, row + 4);
    const uint32_t to = TFA_V(reduced_freedom)(s->m, j, &multiplier);
    double rest = 0;
    Y += TFA_LINK_PARAMETERS * ((size_t)to * s->tips + t);
    for (int c = 0; c < TFA_LINK_PARAMETERS; c++) {
        Y[c] += (double)(multiplier * row[c]);
        rest += Y[c] - Y[c];
    }
    return rest == 0;
}

/* The columns of a link, which its support moves */
static int add_link(struct state *s, uint32_t t, double *Y)
{
    int32_t i = s->m->frame[s->tip[t]].body;
    int finite = 1;
    if (i < 0)
        return 1;
    const struct link_motion m = link_motion(s, t);
    for (; i >= 0; i = s->body[i].parent)
        for (uint32_t k = 0; k < s->body[i].n; k++)
            finite &= add_row(s, &m, s->body[i].v + k, t, Y);
    return finite;
}

static int store_joints(const struct state *s, double *out)
{
    const num *qdd = TFA_V(world_accelerations)(s);
    int finite = 1;
    for (uint32_t j = s->m->base_freedoms; j < s->freedoms; j++) {
        num multiplier;
        const uint32_t to = TFA_V(reduced_freedom)(s->m, j, &multiplier) - s->m->base_freedoms;
        if (multiplier != 1)
            continue;
        const num v = world_velocity(s, j);
        double *row = out + TFA_JOINT_PARAMETERS * (size_t)to;
        row[0] = (double)qdd[j];
        row[1] = (double)v;
        row[2] = (double)friction_sign(v, num_of(s->m->friction_velocity));
        finite &= row[0] - row[0] + row[1] - row[1] + row[2] - row[2] == 0;
    }
    return finite;
}

int TFA_V(answer_regressor)(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *answer)
{
    const size_t n = (size_t)s->m->base_freedoms + s->m->v_count,
                 columns = (size_t)TFA_LINK_PARAMETERS * s->tips;
    int finite = 1;
    answer->method = (uint16_t)s->by.method;
    if (reply->regressor) {
        double *Y = reply->regressor + n * columns * k;
        for (size_t e = 0; e < n * columns; e++)
            Y[e] = 0;
        TFA_V(jacobian)(s, TFA_FRAME_LOCAL);
        for (uint32_t t = 0; t < s->tips; t++)
            finite &= add_link(s, t, Y);
    }
    if (reply->joint_regressor)
        finite &= store_joints(s, reply->joint_regressor +
                                      (size_t)TFA_JOINT_PARAMETERS * s->m->v_count * k);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
