/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle of robots with flexible links. See oracle_modes.h.
 */
#include "oracle_modes.h"

#include <stdlib.h>
#include <string.h>

#include "oracle_motion.h"

enum { MODES = TFA_MAX_LINK_MODES, ORDER = 3 };

/* A pose over time: coefficients of 1, t, t^2 */
typedef struct motion {
    mat3 R[ORDER];
    vec3 p[ORDER];
} motion;

/* A link about its origin, with modes or without; s_k = a_k - c x l_k */
struct element {
    uint32_t first, n; /* n modes, the first of which is freedom `first` */
    const tfa_link_modes *modes;
    quad mass, M[MODES * MODES]; /* M - l^T l / m */
    vec3 c, l[MODES], s[MODES];
    mat3 I; /* about the centre of mass */
};

/* How a unit of a freedom moves all that hangs on `link`, world axes, at the point `at` */
struct column {
    uint32_t link, freedom;
    vec3 linear, angular, at;
};

struct force {
    vec3 force, moment; /* about the world's origin */
};

struct oracle_modes {
    oracle *o; /* of the robot without modes: its joints */
    const tfa_request *request;
    uint32_t state, n, joints, links, columns; /* joints: freedoms without modes */
    struct element *element;                   /* of each link */
    const double **shape;                      /* of each joint; NULL: none */
    struct column *column;
    struct force *F;
    motion *pose;
    quad *eta, *v, *zero, *M, *LDL, *h;
};

/* ---- matrices and series ---- */

static mat3 skew(vec3 a)
{
    return (mat3){{{{0, a.x[2], -a.x[1]}}, {{-a.x[2], 0, a.x[0]}}, {{a.x[1], -a.x[0], 0}}}};
}

/* The vector of the skew part */
static vec3 unskew(const mat3 *m)
{
    return (vec3){{(m->col[1].x[2] - m->col[2].x[1]) / 2, (m->col[2].x[0] - m->col[0].x[2]) / 2,
                   (m->col[0].x[1] - m->col[1].x[0]) / 2}};
}

static void mat_add_scaled(mat3 *to, quad s, const mat3 *m)
{
    for (int i = 0; i < 3; i++)
        to->col[i] = vec_add(to->col[i], vec_scale(s, m->col[i]));
}

static void vec_add_scaled(vec3 *to, quad s, vec3 a)
{
    *to = vec_add(*to, vec_scale(s, a));
}

static motion at_rest(mat3 R, vec3 p)
{
    return (motion){.R = {R}, .p = {p}};
}

static motion compose(const motion *a, const motion *b)
{
    motion c = {0};
    for (int k = 0; k < ORDER; k++) {
        c.p[k] = a->p[k];
        for (int i = 0; i <= k; i++) {
            const mat3 R = mat_mul(&a->R[i], &b->R[k - i]);
            mat_add_scaled(&c.R[k], 1, &R);
            c.p[k] = vec_add(c.p[k], mat_apply(&a->R[i], b->p[k - i]));
        }
    }
    return c;
}

/* From the twist (u, w) in axes that move along, and the derivatives of its components:
 * R' = R [w], p' = R u */
static motion from_twist(mat3 R, vec3 p, const vec3 u[2], const vec3 w[2])
{
    motion m = at_rest(R, p);
    const mat3 W = skew(w[0]), dW = skew(w[1]);
    mat3 second = mat_mul(&W, &W);
    mat_add_scaled(&second, 1, &dW);
    m.R[1] = mat_mul(&R, &W);
    second = mat_mul(&R, &second);
    mat_add_scaled(&m.R[2], 0.5, &second);
    m.p[1] = mat_apply(&R, u[0]);
    m.p[2] = vec_scale(0.5, mat_apply(&R, vec_add(u[1], vec_cross(w[0], u[0]))));
    return m;
}

/* Displacement d and rotation with the Rodrigues vector b, both series:
 * R = 1 + 2 ([b] + [b]^2) / (1 + b.b) */
static motion from_rodrigues(const vec3 d[ORDER], const vec3 b[ORDER])
{
    motion m = at_rest(mat_identity(), d[0]);
    quad s[ORDER] = {1}, inverse[ORDER];
    mat3 B[ORDER];
    for (int k = 0; k < ORDER; k++) {
        m.p[k] = d[k];
        B[k] = skew(b[k]);
        for (int i = 0; i <= k; i++) {
            const mat3 x = skew(b[i]), y = skew(b[k - i]), xy = mat_mul(&x, &y);
            mat_add_scaled(&B[k], 1, &xy);
            s[k] += vec_dot(b[i], b[k - i]);
        }
    }
    for (int k = 0; k < ORDER; k++) {
        inverse[k] = k == 0;
        for (int i = 1; i <= k; i++)
            inverse[k] -= s[i] * inverse[k - i];
        inverse[k] /= s[0];
        for (int i = 0; i <= k; i++)
            mat_add_scaled(&m.R[k], 2 * inverse[i], &B[k - i]);
    }
    return m;
}

/* Twist in the axes that move along, w = R^T R', u = R^T p', and its derivative */
static void twist_of(const motion *m, vec3 u[2], vec3 w[2])
{
    const mat3 Rt = mat_transposed(&m->R[0]), dRt = mat_transposed(&m->R[1]);
    const mat3 W = mat_mul(&Rt, &m->R[1]);
    mat3 dW = mat_mul(&dRt, &m->R[1]);
    const mat3 second = mat_mul(&Rt, &m->R[2]);
    mat_add_scaled(&dW, 2, &second);
    w[0] = unskew(&W);
    w[1] = unskew(&dW);
    u[0] = mat_apply(&Rt, m->p[1]);
    u[1] = vec_add(mat_apply(&dRt, m->p[1]), vec_scale(2, mat_apply(&Rt, m->p[2])));
}

void quad_factorise(quad *A, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = k + 1; i < n; i++) {
            const quad l = A[(size_t)i * n + k] / A[(size_t)k * n + k];
            for (uint32_t j = k + 1; j <= i; j++)
                A[(size_t)i * n + j] -= l * A[(size_t)j * n + k];
            A[(size_t)k * n + i] = l; /* above: the column below is still needed */
        }
}

void quad_solve(const quad *A, uint32_t n, quad *x)
{
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = k + 1; i < n; i++)
            x[i] -= A[(size_t)k * n + i] * x[k];
    for (uint32_t k = n; k-- > 0;) {
        x[k] /= A[(size_t)k * n + k];
        for (uint32_t i = k + 1; i < n; i++)
            x[k] -= A[(size_t)k * n + i] * x[i];
    }
}

/* ---- structure ---- */

static void *allocated(size_t count, size_t size)
{
    void *memory = calloc(count + 1, size);
    if (!memory)
        abort();
    return memory;
}

static mat3 joint_turn(const tfa_joint *j)
{
    return mat_from_quaternion_parts(j->quat, j->quat_low);
}

static void add_modes(oracle_modes *o, struct element *e, const tfa_link_modes *modes)
{
    const tfa_description *d = o->o->description;
    e->modes = modes;
    e->n = (uint32_t)modes->mode_count;
    for (uint32_t k = 0; k < e->n; k++) {
        e->l[k] = vec_from(modes->momentum + 6 * (size_t)k);
        e->s[k] = vec_from(modes->momentum + 6 * (size_t)k + 3);
        e->s[k] = vec_sub(e->s[k], vec_cross(e->c, e->l[k]));
        for (uint32_t j = 0; j <= k; j++)
            e->M[k * MODES + j] = e->M[j * MODES + k] =
                modes->mass[k * e->n + j] - vec_dot(e->l[j], e->l[k]) / e->mass;
    }
    for (size_t s = 0; s < modes->shape_count; s++)
        for (size_t j = 0; j < d->joint_count; j++)
            if (strcmp(d->joints[j].name, modes->shapes[s].joint) == 0)
                o->shape[j] = modes->shapes[s].shape;
}

static void make_element(oracle_modes *o, uint32_t link, const tfa_link_modes *modes, size_t count)
{
    const tfa_link *given = &o->o->description->links[link];
    const mat3 turn = mat_from_quaternion_parts(given->quat, given->quat_low);
    struct element *e = &o->element[link];
    struct body b = {.R = mat_identity()};
    oracle_mass_properties(&b, given, &turn);
    *e = (struct element){.mass = given->mass, .c = b.com, .I = b.I, .first = o->n};
    for (size_t k = 0; k < count; k++)
        if (strcmp(modes[k].link, given->name) == 0)
            add_modes(o, e, &modes[k]);
    o->n += e->n;
}

oracle_modes *oracle_modes_create(const tfa_description *d, tfa_base base,
                                  const tfa_link_modes *modes, size_t count)
{
    oracle_modes *o = allocated(1, sizeof *o);
    o->o = oracle_create(d, base);
    if (!o->o)
        abort();
    o->links = (uint32_t)d->link_count;
    o->element = allocated(o->links, sizeof *o->element);
    o->F = allocated(o->links, sizeof *o->F);
    o->pose = allocated(o->links, sizeof *o->pose);
    o->shape = allocated(d->joint_count, sizeof *o->shape);
    o->n = o->joints = o->columns = oracle_freedoms(o->o);
    for (uint32_t k = 0; k < o->links; k++)
        make_element(o, k, modes, count);
    for (size_t j = 0; j < d->joint_count; j++)
        o->columns += o->element[d->joints[j].parent].n;
    o->column = allocated(o->columns, sizeof *o->column);
    o->eta = allocated(o->n, sizeof *o->eta);
    o->v = allocated(o->n, sizeof *o->v);
    o->zero = allocated(o->n, sizeof *o->zero);
    o->h = allocated(o->n, sizeof *o->h);
    o->M = allocated((size_t)o->n * o->n, sizeof *o->M);
    o->LDL = allocated((size_t)o->n * o->n, sizeof *o->LDL);
    return o;
}

void oracle_modes_free(oracle_modes *o)
{
    if (!o)
        return;
    void *all[] = {o->LDL,    o->M,     o->h,    o->zero, o->v,       o->eta,
                   o->column, o->shape, o->pose, o->F,    o->element, o};
    oracle_free(o->o);
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        free(all[k]);
}

uint32_t oracle_modes_freedoms(const oracle_modes *o)
{
    return o->n;
}

/* ---- motion ---- */

/* Freedom of a joint, in the child's axes at its origin */
static struct freedom freedom_of(const oracle_modes *o, uint32_t k)
{
    struct freedom f = o->o->freedom[k];
    f.linear = mat_apply_transposed(&o->o->body[f.link].R, f.linear);
    f.angular = mat_apply_transposed(&o->o->body[f.link].R, f.angular);
    return f;
}

/* Motion of a link in its joint's frame: the pose that it has without modes */
static motion joint_motion(const oracle_modes *o, uint32_t link, const quad *v, const quad *a)
{
    const struct body *b = &o->o->body[link];
    vec3 u[2] = {0}, w[2] = {0}, p = b->p;
    mat3 R = b->R;
    if (b->joint >= 0) {
        const tfa_joint *j = &o->o->description->joints[b->joint];
        const struct body *parent = &o->o->body[j->parent];
        const mat3 turn = joint_turn(j);
        const mat3 frame = mat_mul(&parent->R, &turn), back = mat_transposed(&frame);
        p = vec_sub(p, vec_add(parent->p, mat_apply(&parent->R, vec_from(j->xyz))));
        p = mat_apply(&back, p);
        R = mat_mul(&back, &R);
    }
    for (uint32_t k = b->freedom; k < b->freedom + b->freedoms; k++) {
        const struct freedom f = freedom_of(o, k);
        for (int i = 0; i < 2; i++) {
            vec_add_scaled(&u[i], i ? a[k] : v[k], f.linear);
            vec_add_scaled(&w[i], i ? a[k] : v[k], f.angular);
        }
    }
    return from_twist(R, p, u, w);
}

/* Motion of a joint's frame in its parent link, by rates and accelerations of the modes */
static motion handle_motion(const oracle_modes *o, uint32_t joint, const quad *v, const quad *a)
{
    const tfa_joint *j = &o->o->description->joints[joint];
    vec3 d[ORDER] = {vec_from(j->xyz)}, b[ORDER] = {0};
    const motion turn = at_rest(joint_turn(j), (vec3){{0, 0, 0}});
    const struct element *e = &o->element[j->parent];
    for (uint32_t k = 0; k < e->n; k++)
        for (int i = 0; i < ORDER; i++) {
            const uint32_t f = e->first + k;
            const quad x = i == 0 ? o->eta[f] : i == 1 ? v[f] : a[f] / 2;
            vec_add_scaled(&d[i], x, vec_from(o->shape[joint] + 6 * (size_t)k));
            vec_add_scaled(&b[i], x / 2, vec_from(o->shape[joint] + 6 * (size_t)k + 3));
        }
    const motion moved = from_rodrigues(d, b);
    return compose(&moved, &turn);
}

static void move(oracle_modes *o, const quad *v, const quad *a)
{
    for (uint32_t k = 0; k < o->links; k++) {
        const uint32_t link = o->o->order[k];
        const int32_t joint = o->o->body[link].joint;
        o->pose[link] = joint_motion(o, link, v, a);
        if (joint < 0)
            continue;
        const motion handle = handle_motion(o, (uint32_t)joint, v, a);
        const motion frame = compose(&o->pose[o->o->description->joints[joint].parent], &handle);
        o->pose[link] = compose(&frame, &o->pose[link]);
    }
}

/* Columns of the Jacobian: of joints by their freedoms; of a mode by the motion that its unit rate
 * gives each handle. */
static void make_columns(oracle_modes *o)
{
    const tfa_description *d = o->o->description;
    uint32_t c = 0;
    move(o, o->zero, o->zero);
    for (; c < o->joints; c++) {
        const struct freedom f = freedom_of(o, c);
        const motion *m = &o->pose[f.link];
        o->column[c] = (struct column){f.link, c, mat_apply(&m->R[0], f.linear),
                                       mat_apply(&m->R[0], f.angular), m->p[0]};
    }
    for (uint32_t j = 0; j < d->joint_count; j++) {
        const struct element *e = &o->element[d->joints[j].parent];
        for (uint32_t k = e->first; k < e->first + e->n; k++, c++) {
            quad *unit = allocated(o->n, sizeof *unit);
            unit[k] = 1;
            const motion handle = handle_motion(o, j, unit, o->zero);
            const motion m = compose(&o->pose[d->joints[j].parent], &handle);
            const mat3 Rt = mat_transposed(&m.R[0]), W = mat_mul(&m.R[1], &Rt);
            o->column[c] = (struct column){d->joints[j].child, k, m.p[1], unskew(&W), m.p[0]};
            free(unit);
        }
    }
}

/* ---- forces ---- */

/* A link in motion, axes of the link: values and first derivatives */
struct moving {
    vec3 w[2], c[2], u[2]; /* angular velocity; centre of mass, and its velocity */
    vec3 L[2];             /* angular momentum about it */
    quad rate[2][MODES];   /* of the modes */
};

static struct moving moving_of(const oracle_modes *o, uint32_t link, const quad *v, const quad *a)
{
    const struct element *e = &o->element[link];
    struct moving m = {.c = {e->c}};
    twist_of(&o->pose[link], m.u, m.w);
    for (uint32_t k = 0; k < e->n; k++) {
        const uint32_t f = e->first + k;
        m.rate[0][k] = v[f];
        m.rate[1][k] = a[f];
        vec_add_scaled(&m.c[0], o->eta[f] / e->mass, e->l[k]);
        vec_add_scaled(&m.c[1], v[f] / e->mass, e->l[k]);
    }
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j <= i; j++)
            m.u[i] = vec_add(m.u[i], vec_cross(m.w[j], m.c[i - j]));
        m.L[i] = mat_apply(&e->I, m.w[i]);
        for (uint32_t k = 0; k < e->n; k++) {
            vec_add_scaled(&m.u[i], m.rate[i][k] / e->mass, e->l[k]);
            vec_add_scaled(&m.L[i], m.rate[i][k], e->s[k]);
        }
    }
    return m;
}

/* Derivative of R x, whose coefficients are x[2] in axes of the link */
static vec3 rate_in_world(const motion *at, const vec3 x[2])
{
    return vec_add(mat_apply(&at->R[0], x[1]), mat_apply(&at->R[1], x[0]));
}

static vec3 centre_of(const motion *at, const struct moving *m)
{
    return vec_add(at->p[0], mat_apply(&at->R[0], m->c[0]));
}

/* Rate of change of the link's momenta in the world, less its weight */
static struct force force_of(const oracle_modes *o, uint32_t link, const struct moving *m,
                             vec3 gravity)
{
    const motion *at = &o->pose[link];
    const vec3 weightless = vec_sub(rate_in_world(at, m->u), gravity);
    const vec3 force = vec_scale(o->element[link].mass, weightless);
    return (struct force){force,
                          vec_add(rate_in_world(at, m->L), vec_cross(centre_of(at, m), force))};
}

/* d/dt dT/d rate - dT/d eta + dV/d eta of mode k; springs and dampers if loaded */
static quad mode_force(const oracle_modes *o, uint32_t link, uint32_t k, const struct moving *m,
                       vec3 gravity, int loaded)
{
    const struct element *e = &o->element[link];
    const vec3 weight = mat_apply_transposed(&o->pose[link].R[0], gravity);
    quad sum = vec_dot(e->l[k], vec_sub(m->u[1], weight)) + vec_dot(e->s[k], m->w[1]);
    sum -= vec_dot(m->u[0], vec_cross(m->w[0], e->l[k]));
    for (uint32_t j = 0; j < e->n; j++) {
        sum += e->M[k * MODES + j] * m->rate[1][j];
        if (loaded)
            sum += e->modes->stiffness[k * e->n + j] * o->eta[e->first + j];
        if (loaded && e->modes->damping)
            sum += e->modes->damping[k * e->n + j] * m->rate[0][j];
    }
    return sum;
}

static void subtract_wrench(oracle_modes *o, uint32_t link, const double *wrench,
                            tfa_reference_frame frame)
{
    const motion *x = &o->pose[link];
    vec3 force = vec_from(wrench), moment = vec_from(wrench + 3);
    if (frame == TFA_FRAME_LOCAL) {
        force = mat_apply(&x->R[0], force);
        moment = mat_apply(&x->R[0], moment);
    }
    if (frame != TFA_FRAME_WORLD)
        moment = vec_add(moment, vec_cross(x->p[0], force));
    o->F[link].force = vec_sub(o->F[link].force, force);
    o->F[link].moment = vec_sub(o->F[link].moment, moment);
}

/* f = M a + h(v); not loaded: without gravity, wrenches, springs and dampers */
static void inverse(oracle_modes *o, const quad *v, const quad *a, int loaded, quad *f)
{
    const tfa_description *d = o->o->description;
    const tfa_request *r = o->request;
    const vec3 gravity = loaded ? o->o->gravity : (vec3){{0, 0, 0}};
    move(o, v, a);
    memset(f, 0, o->n * sizeof *f);
    for (uint32_t k = 0; k < o->links; k++) {
        const struct moving m = moving_of(o, k, v, a);
        o->F[k] = force_of(o, k, &m, gravity);
        for (uint32_t i = 0; i < o->element[k].n; i++)
            f[o->element[k].first + i] = mode_force(o, k, i, &m, gravity, loaded);
    }
    for (uint32_t w = 0; loaded && w < r->wrench_count; w++)
        subtract_wrench(o, r->wrench_frames[w],
                        r->wrenches + ((size_t)o->state * r->wrench_count + w) * 6, r->frame);
    for (uint32_t k = o->links; k-- > 0;) {
        const uint32_t link = o->o->order[k];
        const int32_t joint = o->o->body[link].joint;
        if (joint < 0)
            continue;
        struct force *to = &o->F[d->joints[joint].parent];
        to->force = vec_add(to->force, o->F[link].force);
        to->moment = vec_add(to->moment, o->F[link].moment);
    }
    for (const struct column *c = o->column; c < o->column + o->columns; c++) {
        const struct force *F = &o->F[c->link];
        const vec3 moment = vec_sub(F->moment, vec_cross(c->at, F->force));
        f[c->freedom] += vec_dot(c->linear, F->force) + vec_dot(c->angular, moment);
    }
    for (uint32_t k = o->o->base; k < o->joints; k++)
        f[k] += d->joints[o->o->body[o->o->freedom[k].link].joint].armature * a[k];
}

void oracle_modes_set_state(oracle_modes *o, const tfa_request *r, uint32_t state)
{
    const size_t modes = o->n - o->joints;
    quad *unit = allocated(o->n, sizeof *unit), *f = allocated(o->n, sizeof *f);
    oracle_set_state(o->o, r, state);
    o->request = r;
    o->state = state;
    memcpy(o->v, o->o->v, o->joints * sizeof *o->v);
    for (size_t k = 0; k < modes; k++) {
        o->eta[o->joints + k] = r->modes ? r->modes[state * modes + k] : 0;
        o->v[o->joints + k] = r->mode_velocities ? r->mode_velocities[state * modes + k] : 0;
    }
    make_columns(o);
    for (uint32_t k = 0; k < o->n; k++) {
        unit[k] = 1;
        inverse(o, o->zero, unit, 0, f);
        unit[k] = 0;
        for (uint32_t i = 0; i < o->n; i++)
            o->M[(size_t)i * o->n + k] = f[i];
    }
    memcpy(o->LDL, o->M, (size_t)o->n * o->n * sizeof *o->LDL);
    quad_factorise(o->LDL, o->n);
    inverse(o, o->v, o->zero, 1, o->h); /* leaves the poses of this motion */
    free(f);
    free(unit);
}

/* ---- answers ---- */

const quad *oracle_modes_mass_matrix(const oracle_modes *o)
{
    return o->M;
}

void oracle_modes_forward(const oracle_modes *o, const double *tau, const double *base_wrench,
                          double *x)
{
    const uint32_t base = o->o->base;
    quad *y = allocated(o->n, sizeof *y);
    for (uint32_t k = 0; k < o->n; k++) {
        const double *given = k < base ? base_wrench : k < o->joints ? tau : NULL;
        y[k] = (given ? given[k < base ? k : k - base] : 0) - o->h[k];
    }
    quad_solve(o->LDL, o->n, y);
    for (uint32_t k = 0; k < o->n; k++)
        x[k] = (double)y[k];
    free(y);
}

static void store(vec3 linear, vec3 angular, quad out[6])
{
    for (int i = 0; i < 3; i++) {
        out[i] = linear.x[i];
        out[3 + i] = angular.x[i];
    }
}

oracle_modes_tip oracle_modes_tip_of(const oracle_modes *o, uint32_t link,
                                     tfa_reference_frame frame)
{
    const motion *m = &o->pose[link];
    oracle_modes_tip tip = {.p = m->p[0], .R = m->R[0]};
    vec3 u[2], w[2];
    twist_of(m, u, w);
    if (frame != TFA_FRAME_LOCAL) { /* R w in world axes has the derivative R w' */
        u[0] = m->p[1];
        u[1] = vec_scale(2, m->p[2]);
        for (int i = 0; i < 2; i++)
            w[i] = mat_apply(&m->R[0], w[i]);
    }
    if (frame == TFA_FRAME_WORLD) {
        u[1] = vec_sub(u[1], vec_add(vec_cross(w[1], m->p[0]), vec_cross(w[0], m->p[1])));
        u[0] = vec_sub(u[0], vec_cross(w[0], m->p[0]));
    }
    store(u[0], w[0], tip.twist);
    store(u[1], w[1], tip.bias);
    return tip;
}

static int carries(const oracle_modes *o, uint32_t link, uint32_t tip)
{
    while (tip != link && o->o->body[tip].joint >= 0)
        tip = o->o->description->joints[o->o->body[tip].joint].parent;
    return tip == link;
}

void oracle_modes_jacobian(const oracle_modes *o, uint32_t link, tfa_reference_frame frame, quad *J)
{
    const motion *m = &o->pose[link];
    for (const struct column *c = o->column; c < o->column + o->columns; c++) {
        if (!carries(o, c->link, link))
            continue;
        const vec3 point = frame == TFA_FRAME_WORLD ? (vec3){{0, 0, 0}} : m->p[0];
        vec3 angular = c->angular;
        vec3 linear = vec_add(c->linear, vec_cross(angular, vec_sub(point, c->at)));
        if (frame == TFA_FRAME_LOCAL) {
            linear = mat_apply_transposed(&m->R[0], linear);
            angular = mat_apply_transposed(&m->R[0], angular);
        }
        quad six[6];
        store(linear, angular, six);
        for (int i = 0; i < 6; i++)
            J[(size_t)i * o->n + c->freedom] += six[i];
    }
}

void oracle_modes_lambda_inv(const oracle_modes *o, const uint32_t *tips, uint32_t count,
                             tfa_reference_frame frame, double *lambda_inv)
{
    const uint32_t n = o->n, m = 6 * count;
    quad *J = allocated((size_t)m * n, sizeof *J), *x = allocated(n, sizeof *x);
    for (uint32_t t = 0; t < count; t++)
        oracle_modes_jacobian(o, tips[t], frame, J + (size_t)t * 6 * n);
    for (uint32_t i = 0; i < m; i++) {
        memcpy(x, J + (size_t)i * n, n * sizeof *x);
        quad_solve(o->LDL, n, x);
        for (uint32_t j = 0; j < m; j++) {
            quad sum = 0;
            for (uint32_t k = 0; k < n; k++)
                sum += J[(size_t)j * n + k] * x[k];
            lambda_inv[(size_t)j * m + i] = (double)sum;
        }
    }
    free(x);
    free(J);
}

oracle_modes_sums oracle_modes_sums_of(const oracle_modes *o)
{
    oracle_modes_sums s = {0};
    vec3 moment = {{0, 0, 0}};
    for (uint32_t k = 0; k < o->links; k++) {
        const struct element *e = &o->element[k];
        const motion *at = &o->pose[k];
        const struct moving m = moving_of(o, k, o->v, o->zero);
        if (!oracle_moves(o->o, k))
            continue;
        const vec3 P = mat_apply(&at->R[0], vec_scale(e->mass, m.u[0])), c = centre_of(at, &m);
        s.mass += e->mass;
        s.kinetic += e->mass * vec_dot(m.u[0], m.u[0]) / 2;
        s.kinetic += vec_dot(mat_apply(&e->I, m.w[0]), m.w[0]) / 2;
        s.momentum = vec_add(s.momentum, P);
        s.angular = vec_add(s.angular, vec_add(mat_apply(&at->R[0], m.L[0]), vec_cross(c, P)));
        vec_add_scaled(&moment, e->mass, c);
        for (uint32_t i = 0; i < e->n; i++) {
            s.kinetic += m.rate[0][i] * vec_dot(e->s[i], m.w[0]);
            for (uint32_t j = 0; j < e->n; j++) {
                s.kinetic += m.rate[0][i] * e->M[i * MODES + j] * m.rate[0][j] / 2;
                s.potential += o->eta[e->first + i] * e->modes->stiffness[i * e->n + j] *
                               o->eta[e->first + j] / 2;
            }
        }
    }
    for (uint32_t k = o->o->base; k < o->joints; k++)
        s.kinetic += o->o->description->joints[o->o->body[o->o->freedom[k].link].joint].armature *
                     o->v[k] * o->v[k] / 2;
    s.potential -= vec_dot(o->o->gravity, moment);
    s.com = s.mass > 0 ? vec_scale(1 / s.mass, moment) : moment;
    s.angular = vec_sub(s.angular, vec_cross(s.com, s.momentum));
    return s;
}
