/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots with constraints. See constrained_robot.h.
 */
#include "constrained_robot.h"

#include "support/oracle_motion.h"
#include "test.h"

tfa_constraint *constrained_add(constrained_robot *c, uint32_t first, uint32_t second,
                                uint32_t rows)
{
    const tfa_link *links = c->robot->description->links;
    const uint32_t k = c->count++;
    assert_true(k < MOST);
    snprintf(c->name[k], sizeof c->name[k], "c%u", (unsigned)k);
    c->link[k][0] = first;
    c->link[k][1] = second;
    c->constraint[k] = (tfa_constraint){.name = c->name[k], .rows = rows};
    c->constraint[k].link[0] = first == WORLD ? NULL : links[first].name;
    c->constraint[k].link[1] = links[second].name;
    return &c->constraint[k];
}

/* Body that carries a link; -1: the world */
static int32_t body_of(const test_robot *robot, uint32_t link)
{
    return link == WORLD ? -1 : tfa_model_frame(robot->model, link).body;
}

void constrained_draw(constrained_robot *c, random_source *s, uint32_t most)
{
    static const uint32_t rows[] = {TFA_CONSTRAINT_POINT, TFA_CONSTRAINT_HINGE, TFA_CONSTRAINT_WELD,
                                    0x05, 0x3c};
    const uint32_t links = (uint32_t)c->robot->description->link_count;
    for (uint32_t k = 0; k < 5 * most && c->count < most; k++) {
        const uint32_t first = random_below(s, 2) ? WORLD : random_below(s, links);
        const uint32_t second = random_below(s, links), kind = random_below(s, 5);
        if (body_of(c->robot, first) == body_of(c->robot, second))
            continue;
        tfa_constraint *x = constrained_add(c, first, second, rows[kind]);
        for (int side = 0; side < 2; side++) {
            for (int e = 0; e < 3; e++)
                x->pose[side][e] = random_uniform(s, -0.3, 0.3);
            random_quaternion(s, x->pose[side] + 3);
        }
    }
}

bool constrained_open(constrained_robot *c)
{
    const tfa_scene scene = {.constraints = c->constraint,
                             .constraint_count = c->count,
                             .actuated = c->actuated,
                             .actuated_count = c->actuated_count};
    tfa_model_options options = fixture_options(c->robot);
    options.scene = &scene;
    tfa_report report = {0};
    c->model = NULL;
    if (c->count == 0)
        return false;
    const int status = tfa_model_create(c->robot->description, &options, &report, &c->model);
    tfa_report_free(&report);
    if (status != TFA_OK)
        return false;
    c->f64 = fixture_workspace(c->model, TFA_F64);
    c->f128 = fixture_workspace(c->model, TFA_F128);
    return true;
}

void constrained_close(constrained_robot *c)
{
    tfa_workspace_free(c->f64);
    tfa_workspace_free(c->f128);
    tfa_model_free(c->model);
}

/* ---- motion ---- */

/* A frame: its axes and arm; velocities, and accelerations while all qdd are 0 */
struct end {
    mat3 R;
    vec3 arm, x, v, w, a, b;
};

static struct end end_of(const constrained_robot *c, uint32_t k, int side)
{
    static const double none[4] = {0, 0, 0, 1};
    const double *pose = c->constraint[k].pose[side], *q = pose + 3;
    const mat3 own = mat_from_quaternion(norm2(q, 4) > 0 ? q : none);
    struct end e = {.R = own, .arm = vec_from(pose), .x = vec_from(pose)};
    if (c->link[k][side] == WORLD)
        return e;
    const struct body *b = &c->robot->o->body[c->link[k][side]];
    e.R = mat_mul(&b->R, &own);
    e.arm = mat_apply(&b->R, e.arm);
    e.x = vec_add(b->p, e.arm);
    e.w = b->w;
    e.b = b->alpha;
    const vec3 turn = vec_cross(e.w, e.arm);
    e.v = vec_add(b->v, turn);
    e.a = vec_add(b->a, vec_add(vec_cross(e.b, e.arm), vec_cross(e.w, turn)));
    return e;
}

static void store(const mat3 *R, vec3 linear, vec3 angular, quad *out)
{
    linear = mat_apply_transposed(R, linear);
    angular = mat_apply_transposed(R, angular);
    memcpy(out, linear.x, sizeof linear.x);
    memcpy(out + 3, angular.x, sizeof angular.x);
}

/* Rows of constraint k: motion of the second frame less that of the first */
static void find_jacobian(const constrained_robot *c, uint32_t k, relative_motion *m)
{
    static quad link[6 * FREEDOMS];
    const uint32_t n = c->robot->n;
    quad *J = m->J + (size_t)6 * k * n, x[6];
    memset(J, 0, (size_t)6 * n * sizeof *J);
    for (int side = 0; side < 2; side++) {
        const oracle_tips tip = {&c->link[k][side], 1, 6, TFA_FRAME_LOCAL_WORLD_ALIGNED};
        if (c->link[k][side] == WORLD)
            continue;
        oracle_jacobian(c->robot->o, &tip, link);
        for (uint32_t j = 0; j < n; j++) {
            const vec3 w = {{link[3 * n + j], link[4 * n + j], link[5 * n + j]}};
            const vec3 v = {{link[j], link[n + j], link[2 * n + j]}};
            store(&m->R[k][0], vec_add(v, vec_cross(w, m->arm[k][side])), w, x);
            for (uint32_t e = 0; e < 6; e++)
                J[(size_t)e * n + j] += side ? x[e] : -x[e];
        }
    }
}

void relative_motion_of(const constrained_robot *c, const tfa_request *state, relative_motion *m)
{
    static const vec3 zero = {{0}};
    assert_true(c->robot->n <= FREEDOMS);
    oracle_set_state(c->robot->o, state, 0);
    for (uint32_t k = 0; k < c->count; k++) {
        const struct end first = end_of(c, k, 0), second = end_of(c, k, 1);
        const vec3 v = vec_sub(second.v, first.v), w = vec_sub(second.w, first.w);
        m->R[k][0] = first.R;
        m->R[k][1] = second.R;
        m->arm[k][0] = first.arm;
        m->arm[k][1] = second.arm;
        store(&first.R, v, w, m->velocity + 6 * k);
        store(&first.R, vec_sub(vec_sub(second.a, first.a), vec_cross(first.w, v)),
              vec_sub(vec_sub(second.b, first.b), vec_cross(first.w, w)), m->bias + 6 * k);
        store(&first.R, vec_sub(second.x, first.x), zero, m->position + 6 * k);
        find_jacobian(c, k, m);
    }
}

uint32_t held_rows(const constrained_robot *c, uint32_t row[ROWS])
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < 6 * c->count; k++)
        if (c->constraint[k / 6].rows >> k % 6 & 1)
            row[count++] = k;
    return count;
}

/* ---- admissible motion ---- */

static quad dot(const quad *a, const quad *b, uint32_t n)
{
    quad sum = 0;
    for (uint32_t j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* Gram-Schmidt, each row twice; e goes with its row. */
uint32_t least_norm(const constrained_robot *c, const relative_motion *m, const quad e[ROWS],
                    quad *x)
{
    static quad Q[ROWS * FREEDOMS];
    const uint32_t n = c->robot->n;
    uint32_t row[ROWS], rank = 0;
    const uint32_t rows = held_rows(c, row);
    quad f[ROWS];
    memset(x, 0, n * sizeof *x);
    for (uint32_t i = 0; i < rows; i++) {
        quad *q = Q + (size_t)rank * n;
        memcpy(q, m->J + (size_t)row[i] * n, n * sizeof *q);
        f[rank] = e[row[i]];
        const quad size = quad_sqrt(dot(q, q, n));
        for (uint32_t pass = 0; pass < 2 * rank; pass++) {
            const quad *p = Q + (size_t)(pass % rank) * n, along = dot(p, q, n);
            f[rank] -= along * f[pass % rank];
            for (uint32_t j = 0; j < n; j++)
                q[j] -= along * p[j];
        }
        const quad left = quad_sqrt(dot(q, q, n));
        if (!(left > (quad)1e-13 * size)) /* poses are rounded to double */
            continue;
        f[rank] /= left;
        for (uint32_t j = 0; j < n; j++) {
            q[j] /= left;
            x[j] += f[rank] * q[j];
        }
        rank++;
    }
    return rank;
}

void admit(const constrained_robot *c, random_states *x)
{
    static relative_motion m;
    static quad less[FREEDOMS];
    const tfa_request r = constrained_request(c, x);
    const uint32_t n = c->robot->n, six = n - c->robot->nv;
    for (int pass = 0; pass < 2; pass++) { /* the second one for the rounding of the first */
        relative_motion_of(c, &r, &m);
        (void)least_norm(c, &m, m.velocity, less);
        for (uint32_t j = 0; j < n; j++) {
            double *v = j < six ? &x->base_twist[j] : &x->v[j - six];
            *v = (double)(*v - less[j]);
        }
    }
}

/* ---- requests ---- */

tfa_request constrained_request(const constrained_robot *c, const random_states *x)
{
    tfa_request r = fixture_request(c->robot, x);
    r.op = TFA_OP_CONSTRAINED_DYNAMICS;
    r.constraints = (1u << c->count) - 1;
    return r;
}

void constrained_ask(const constrained_robot *c, tfa_workspace *w, const tfa_request *r,
                     constrained_answer *a)
{
    memset(a, 0xff, sizeof *a);
    tfa_reply reply = {.qdd = a->qdd + (c->robot->n - c->robot->nv),
                       .base_acceleration = a->qdd,
                       .constraint_wrenches = a->F,
                       .constraint_position = a->position,
                       .constraint_velocity = a->velocity,
                       .constraint_residual = a->residual,
                       .rank = &a->rank,
                       .lost = a->lost,
                       .answers = &a->answer};
    compute_ok(c->robot, w, r, &reply);
}

void constrained_within(const constrained_robot *c, constrained_law *law, int set, quad error,
                        quad size)
{
    const double relative = (double)((error < 0 ? -error : error) / (size > 0 ? size : 1));
    assert_within(c->robot, law->name, relative, law->bound[set], &law->worst[set]);
}

void constrained_print(const constrained_law *laws, int count)
{
    for (int k = 0; k < count; k++)
        print_message("  %-8s within %.1e, in double %.1e\n", laws[k].name, laws[k].worst[0],
                      laws[k].worst[1]);
}

quad larger(quad a, quad b)
{
    const quad size = b < 0 ? -b : b;
    return a > size ? a : size;
}
