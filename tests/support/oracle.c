/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle: dense world-frame Newton-Euler equations in quadruple precision. See oracle.h.
 */
#include "oracle_motion.h"

#include <stdlib.h>

static const uint32_t joint_v_count[] = {
    [TFA_JOINT_FIXED] = 0,     [TFA_JOINT_REVOLUTE] = 1, [TFA_JOINT_CONTINUOUS] = 1,
    [TFA_JOINT_PRISMATIC] = 1, [TFA_JOINT_PLANAR] = 3,   [TFA_JOINT_FLOATING] = 6};

/* ---- structure ---- */

/* Emits a link after the links above it; false when they form a circle. */
static int emit(oracle *o, uint32_t link, uint8_t *done, uint32_t *count)
{
    const tfa_description *d = o->description;
    while (!done[link]) {
        uint32_t top = link, steps = 0;
        for (;;) { /* the highest one that is not done */
            const tfa_joint *j = joint_above(o, &o->body[top]);
            if (!j || done[j->parent])
                break;
            if (++steps > d->link_count)
                return 0;
            top = j->parent;
        }
        done[top] = 1;
        o->order[(*count)++] = top;
    }
    return 1;
}

static int order_links(oracle *o)
{
    const tfa_description *d = o->description;
    uint8_t *done = calloc(d->link_count, 1);
    uint32_t count = 0;
    int good = done != NULL;
    for (size_t k = 0; k < d->link_count; k++)
        o->body[k].joint = -1;
    for (size_t j = 0; j < d->joint_count; j++)
        o->body[d->joints[j].child].joint = (int32_t)j;
    for (size_t j = 0; good && j < d->joint_count; j++)
        good = emit(o, d->joints[j].child, done, &count);
    if (d->joint_count == 0)
        o->order[count++] = 0;
    free(done);
    return good && count == d->link_count;
}

static void number_freedoms(oracle *o)
{
    o->n = o->base;
    o->q_count = 0;
    for (size_t k = 0; k < o->description->link_count; k++) {
        struct body *b = &o->body[o->order[k]];
        const tfa_joint *j = joint_above(o, b);
        b->q = o->q_count;
        b->freedom = j ? o->n : 0;
        b->freedoms = j ? joint_v_count[j->type] : o->base;
        for (uint32_t i = 0; i < b->freedoms; i++)
            o->freedom[b->freedom + i].link = o->order[k];
        o->n += j ? b->freedoms : 0;
        o->q_count += j ? b->freedoms + (j->type == TFA_JOINT_FLOATING) : 0;
    }
}

oracle *oracle_create(const tfa_description *description, tfa_base base)
{
    oracle *o = calloc(1, sizeof *o);
    if (!o)
        return NULL;
    size_t most = 6 * (description->joint_count + 1);
    o->description = description;
    o->base = base == TFA_BASE_FLOATING ? 6 : 0;
    o->body = calloc(description->link_count, sizeof *o->body);
    o->order = calloc(description->link_count + 1, sizeof *o->order);
    o->freedom = calloc(most, sizeof *o->freedom);
    if (!o->body || !o->order || !o->freedom || !order_links(o))
        goto err_free;
    number_freedoms(o);
    size_t n = (size_t)o->n + 1;
    o->tie = calloc(n, sizeof *o->tie);
    o->M = calloc(n * n, sizeof *o->M);
    o->Mt = calloc(n * n, sizeof *o->Mt);
    o->LDL = calloc(n * n, sizeof *o->LDL);
    o->h = calloc(n, sizeof *o->h);
    o->ht = calloc(n, sizeof *o->ht);
    o->v = calloc(n, sizeof *o->v);
    o->moment_rate = calloc(n, sizeof *o->moment_rate);
    if (!o->tie || !o->M || !o->Mt || !o->LDL || !o->h || !o->ht || !o->v || !o->moment_rate)
        goto err_free;
    oracle_tie_freedoms(o, NULL, 0);
    return o;
err_free:
    oracle_free(o);
    return NULL;
}

void oracle_free(oracle *o)
{
    if (!o)
        return;
    free(o->moment_rate);
    free(o->v);
    free(o->ht);
    free(o->h);
    free(o->LDL);
    free(o->Mt);
    free(o->M);
    free(o->tie);
    free(o->freedom);
    free(o->order);
    free(o->body);
    free(o);
}

uint32_t oracle_freedoms(const oracle *o)
{
    return o->n;
}

uint32_t oracle_q_count(const oracle *o)
{
    return o->q_count;
}

uint32_t oracle_v_count(const oracle *o)
{
    return o->n - o->base;
}

uint32_t oracle_joint_of_freedom(const oracle *o, uint32_t k, uint32_t *within)
{
    const struct body *b = &o->body[o->freedom[o->base + k].link];
    *within = o->base + k - b->freedom;
    return (uint32_t)b->joint;
}

void oracle_tie_freedoms(oracle *o, const oracle_tie *ties, uint32_t rows)
{
    o->rows = ties ? rows : o->n;
    for (uint32_t k = 0; k < o->n; k++)
        o->tie[k] = ties ? ties[k] : (oracle_tie){k, 1};
}

void oracle_use_damping(oracle *o, uint32_t use)
{
    o->damped = use;
}

void oracle_use_friction(oracle *o, double velocity)
{
    o->friction_velocity = velocity;
}

/* ---- equations ---- */

/* Velocity of the point of `link` that is now at `point`, per unit of each freedom that moves it.
 * Lists the freedoms, at most n of them, and returns how many. */
static uint32_t jacobian(const oracle *o, uint32_t link, vec3 point, uint32_t *index, vec3 *linear,
                         vec3 *angular)
{
    uint32_t count = 0;
    for (;;) {
        const struct body *b = &o->body[link];
        for (uint32_t i = 0; i < b->freedoms; i++) {
            const struct freedom *f = &o->freedom[b->freedom + i];
            vec3 arm = vec_sub(point, f->at);
            index[count] = b->freedom + i;
            linear[count] = vec_add(f->linear, vec_cross(f->angular, arm));
            angular[count++] = f->angular;
        }
        if (b->joint < 0)
            return count;
        link = o->description->joints[b->joint].parent;
    }
}

/* Scratch for a Jacobian: reused by every link. */
struct columns {
    uint32_t *index;
    vec3 *linear, *angular;
};

static struct columns columns_make(const oracle *o)
{
    struct columns c = {calloc((size_t)o->n + 1, sizeof *c.index),
                        calloc((size_t)o->n + 1, sizeof *c.linear),
                        calloc((size_t)o->n + 1, sizeof *c.angular)};
    if (!c.index || !c.linear || !c.angular)
        abort(); /* a test without memory has nothing to say */
    return c;
}

static void columns_free(struct columns *c)
{
    free(c->angular);
    free(c->linear);
    free(c->index);
}

int oracle_moves(const oracle *o, uint32_t link)
{
    for (;;) {
        const struct body *b = &o->body[link];
        for (uint32_t i = 0; i < b->freedoms; i++)
            if (o->tie[b->freedom + i].to != ORACLE_STILL)
                return 1;
        if (b->joint < 0)
            return 0;
        link = o->description->joints[b->joint].parent;
    }
}

/* Adds a mass of `count` freedoms to the sums over what moves. */
static void add_moving(oracle *o, const struct body *b, quad m, const struct columns *c,
                       uint32_t count)
{
    struct oracle_sums *s = &o->moving;
    vec3 p = vec_scale(m, b->v_com), spin = mat_apply(&b->I, b->w);
    s->mass += m;
    s->kinetic += (vec_dot(p, b->v_com) + vec_dot(spin, b->w)) / 2;
    s->moment = vec_add(s->moment, vec_scale(m, b->com));
    s->momentum = vec_add(s->momentum, p);
    s->angular = vec_add(s->angular, vec_add(spin, vec_cross(b->com, p)));
    for (uint32_t i = 0; i < count; i++) {
        vec3 *rate = &o->moment_rate[c->index[i]];
        *rate = vec_add(*rate, vec_scale(m, c->linear[i]));
    }
}

/* Adds a mass m that moves with `link`: b holds its centre, its motion and its inertia. */
static void add_mass(oracle *o, uint32_t link, const struct body *b, quad m, struct columns *c)
{
    o->mass += m;
    o->moment = vec_add(o->moment, vec_scale(m, b->com));
    vec3 momentum_rate = vec_scale(m, vec_sub(b->a_com, o->gravity));
    vec3 spin_rate = vec_add(mat_apply(&b->I, b->alpha), vec_cross(b->w, mat_apply(&b->I, b->w)));
    uint32_t count = jacobian(o, link, b->com, c->index, c->linear, c->angular);
    if (oracle_moves(o, link))
        add_moving(o, b, m, c, count);
    for (uint32_t i = 0; i < count; i++) {
        vec3 mJ = vec_scale(m, c->linear[i]), IJ = mat_apply(&b->I, c->angular[i]);
        quad *row = o->M + (size_t)c->index[i] * o->n;
        for (uint32_t k = 0; k < count; k++)
            row[c->index[k]] += vec_dot(mJ, c->linear[k]) + vec_dot(IJ, c->angular[k]);
        o->h[c->index[i]] +=
            vec_dot(c->linear[i], momentum_rate) + vec_dot(c->angular[i], spin_rate);
    }
}

/* A payload: TFA_PAYLOAD_NUMBERS numbers, rigidly on a link. */
static void add_payload(oracle *o, uint32_t link, const double *x, struct columns *c)
{
    tfa_link load = {.mass = x[0], .com = {x[1], x[2], x[3]}, .quat = {0, 0, 0, 1}};
    for (int i = 0; i < 6; i++)
        load.inertia[i] = x[4 + i];
    struct body b = o->body[link];
    const mat3 turn = mat_identity();
    oracle_mass_properties(&b, &load, &turn);
    add_mass(o, link, &b, load.mass, c);
}

/* h -= J^T wrench, the wrench taken to the origin of the link's frame and to world axes. */
static void subtract_wrench(oracle *o, uint32_t link, const double *wrench,
                            tfa_reference_frame frame, struct columns *c)
{
    const struct body *b = &o->body[link];
    vec3 force = vec_from(wrench), moment = vec_from(wrench + 3);
    if (frame == TFA_FRAME_LOCAL) {
        force = mat_apply(&b->R, force);
        moment = mat_apply(&b->R, moment);
    } else if (frame == TFA_FRAME_WORLD) {
        moment = vec_sub(moment, vec_cross(b->p, force));
    }
    uint32_t count = jacobian(o, link, b->p, c->index, c->linear, c->angular);
    for (uint32_t i = 0; i < count; i++)
        o->h[c->index[i]] -= vec_dot(c->linear[i], force) + vec_dot(c->angular[i], moment);
}

/* Mt = T^T M T, ht = T^T h. Rows that nothing is tied to become 1 0 0 ... = 0. */
static void tie(oracle *o)
{
    uint32_t n = o->n, rows = o->rows;
    for (size_t i = 0; i < (size_t)rows * rows; i++)
        o->Mt[i] = 0;
    for (uint32_t i = 0; i < rows; i++)
        o->ht[i] = 0;
    for (uint32_t i = 0; i < n; i++) {
        if (o->tie[i].to == ORACLE_STILL)
            continue;
        o->ht[o->tie[i].to] += o->tie[i].multiplier * o->h[i];
        quad *row = o->Mt + (size_t)o->tie[i].to * rows;
        for (uint32_t k = 0; k < n; k++)
            if (o->tie[k].to != ORACLE_STILL)
                row[o->tie[k].to] +=
                    o->tie[i].multiplier * (o->tie[k].multiplier * o->M[(size_t)i * n + k]);
    }
    for (uint32_t i = 0; i < rows; i++)
        if (o->Mt[(size_t)i * rows + i] == 0)
            o->Mt[(size_t)i * rows + i] = 1;
}

static int tied_to(const oracle *o, uint32_t row)
{
    for (uint32_t k = 0; k < o->n; k++)
        if (o->tie[k].to == row)
            return 1;
    return 0;
}

/* M = L D L^T, L unit lower, D on the diagonal. */
static void factorise(oracle *o)
{
    uint32_t n = o->rows;
    quad *A = o->LDL;
    for (size_t i = 0; i < (size_t)n * n; i++)
        A[i] = o->Mt[i];
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = k + 1; i < n; i++) {
            quad l = A[(size_t)i * n + k] / A[(size_t)k * n + k];
            for (uint32_t j = k + 1; j <= i; j++)
                A[(size_t)i * n + j] -= l * A[(size_t)j * n + k];
            A[(size_t)k * n + i] = l; /* kept above: the column below is still needed */
        }
}

void oracle_solve_lower(const oracle *o, quad *x)
{
    for (uint32_t k = 0; k < o->rows; k++)
        for (uint32_t i = k + 1; i < o->rows; i++)
            x[i] -= o->LDL[(size_t)k * o->rows + i] * x[k];
}

void oracle_solve(const oracle *o, quad *x)
{
    uint32_t n = o->rows;
    oracle_solve_lower(o, x);
    for (uint32_t k = n; k-- > 0;) {
        x[k] /= o->LDL[(size_t)k * n + k];
        for (uint32_t i = k + 1; i < n; i++)
            x[k] -= o->LDL[(size_t)k * n + i] * x[i];
    }
}

void oracle_set_state(oracle *o, const tfa_request *r, uint32_t state)
{
    static const double earth[3] = {0, 0, -9.80665};
    const tfa_description *d = o->description;
    uint32_t v_count = oracle_v_count(o);
    for (uint32_t k = 0; k < o->n; k++) {
        const double *v = k < o->base ? r->base_twist : r->v;
        size_t at = k < o->base ? (size_t)state * 6 + k : (size_t)state * v_count + k - o->base;
        o->v[k] = v ? v[at] : 0;
        o->h[k] = 0;
        o->moment_rate[k] = (vec3){{0, 0, 0}};
    }
    for (size_t i = 0; i < (size_t)o->n * o->n; i++)
        o->M[i] = 0;
    o->gravity = vec_from(r->gravity ? r->gravity : earth);
    o->mass = 0;
    o->moment = (vec3){{0, 0, 0}};
    o->moving = (struct oracle_sums){0};
    oracle_move_links(o, r->q ? r->q + (size_t)state * o->q_count : NULL,
                      r->base_pose ? r->base_pose + (size_t)state * 7 : NULL);
    struct columns c = columns_make(o);
    for (uint32_t k = 0; k < d->link_count; k++)
        add_mass(o, k, &o->body[k], d->links[k].mass, &c);
    for (uint32_t k = 0; k < r->payload_count; k++)
        add_payload(o, r->payload_frames[k], r->payloads + (size_t)k * TFA_PAYLOAD_NUMBERS, &c);
    for (uint32_t w = 0; w < r->wrench_count; w++)
        subtract_wrench(o, r->wrench_frames[w],
                        r->wrenches + ((size_t)state * r->wrench_count + w) * 6, r->frame, &c);
    columns_free(&c);
    for (uint32_t k = o->base; k < o->n; k++) {
        const tfa_joint *j = &d->joints[o->body[o->freedom[k].link].joint];
        o->M[(size_t)k * o->n + k] += j->armature;
        if (o->tie[k].to != ORACLE_STILL)
            o->moving.kinetic += j->armature * o->v[k] * o->v[k] / 2;
        o->h[k] += o->damped ? j->damping * o->v[k] : 0;
        const quad s = o->friction_velocity;
        o->h[k] += s > 0 ? j->friction * o->v[k] / quad_sqrt(o->v[k] * o->v[k] + s * s) : 0;
    }
    tie(o);
    factorise(o);
}

void oracle_forward(oracle *o, const double *tau, const double *base_wrench, double *qdd,
                    double *base_acceleration)
{
    quad *x = calloc((size_t)o->rows + 1, sizeof *x);
    for (uint32_t k = 0; k < o->rows; k++) {
        const double *given = k < o->base ? base_wrench : tau;
        if (tied_to(o, k))
            x[k] = (given ? given[k < o->base ? k : k - o->base] : 0) - o->ht[k];
    }
    oracle_solve(o, x);
    for (uint32_t k = 0; k < o->rows; k++) {
        if (k >= o->base)
            qdd[k - o->base] = (double)x[k];
        else if (base_acceleration)
            base_acceleration[k] = (double)x[k];
    }
    free(x);
}

void oracle_inverse(oracle *o, const double *qdd, const double *base_acceleration, double *tau,
                    double *base_wrench)
{
    for (uint32_t i = 0; i < o->rows; i++) {
        quad sum = o->ht[i];
        for (uint32_t k = 0; k < o->rows; k++) {
            const double *given = k < o->base ? base_acceleration : qdd;
            if (given)
                sum += o->Mt[(size_t)i * o->rows + k] * given[k < o->base ? k : k - o->base];
        }
        if (i >= o->base)
            tau[i - o->base] = (double)sum;
        else if (base_wrench)
            base_wrench[i] = (double)sum;
    }
}

void oracle_mass_matrix(oracle *o, double *mass_matrix)
{
    for (size_t i = 0; i < (size_t)o->rows * o->rows; i++)
        mass_matrix[i] = (double)o->Mt[i];
}

void oracle_tip_rows(const oracle *o, uint32_t link, tfa_reference_frame frame, quad *rows)
{
    const struct body *b = &o->body[link];
    struct columns c = columns_make(o);
    vec3 origin = {{0, 0, 0}};
    uint32_t count =
        jacobian(o, link, frame == TFA_FRAME_WORLD ? origin : b->p, c.index, c.linear, c.angular);
    for (uint32_t k = 0; k < count; k++) {
        const oracle_tie *t = &o->tie[c.index[k]];
        vec3 linear = c.linear[k], angular = c.angular[k];
        if (t->to == ORACLE_STILL)
            continue;
        if (frame == TFA_FRAME_LOCAL) {
            linear = mat_apply_transposed(&b->R, linear);
            angular = mat_apply_transposed(&b->R, angular);
        }
        for (int i = 0; i < 3; i++) {
            rows[(size_t)i * o->rows + t->to] += t->multiplier * linear.x[i];
            rows[(size_t)(3 + i) * o->rows + t->to] += t->multiplier * angular.x[i];
        }
    }
    columns_free(&c);
}

void oracle_lambda_inv(oracle *o, const uint32_t *tips, uint32_t tip_count,
                       tfa_reference_frame frame, double *lambda_inv)
{
    uint32_t n = o->rows, m = 6 * tip_count;
    quad *G = calloc((size_t)m * n + 1, sizeof *G);
    for (uint32_t t = 0; t < tip_count; t++)
        oracle_tip_rows(o, tips[t], frame, G + (size_t)t * 6 * n);
    for (uint32_t i = 0; i < m; i++)
        oracle_solve_lower(o, G + (size_t)i * n);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < m; j++) {
            quad sum = 0;
            for (uint32_t k = 0; k < n; k++)
                sum += G[(size_t)i * n + k] * G[(size_t)j * n + k] / o->LDL[(size_t)k * n + k];
            lambda_inv[(size_t)i * m + j] = (double)sum;
        }
    free(G);
}
