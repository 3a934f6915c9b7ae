/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One set of constraints in two descriptions: qdd is the same, and the forces are, as wrenches in
 * the world. The second one lists them the other way round and changes each in one way:
 *
 *     exchanged  the two links, where points or all six rows are held: F becomes -F
 *     turned     the axes of the first frame, about z where a hinge is held
 *     moved      both frames of six rows, to another point common to them
 *
 * At velocities that the constraints admit the descriptions mean the same.
 */
#include "constrained_robot.h"
#include "test.h"

enum { SAME, EXCHANGED, TURNED, MOVED, CHANGES };

static const double bounds[2] = {1e-13, 1e-10}; /* f128: poses are rounded to double; f64 */
static double worst_qdd[2], worst_force[2];
static uint32_t changed[CHANGES];

typedef struct change {
    int kind;
    vec3 d; /* moved by, world */
} change;

static bool is_possible(const constrained_robot *c, uint32_t k, int kind)
{
    const uint32_t rows = c->constraint[k].rows;
    const bool whole = rows == TFA_CONSTRAINT_POINT || rows == TFA_CONSTRAINT_WELD;
    switch (kind) {
    case EXCHANGED:
        return whole && c->link[k][0] != WORLD;
    case TURNED:
        return whole || rows == TFA_CONSTRAINT_HINGE;
    case MOVED:
        return rows == TFA_CONSTRAINT_WELD;
    default:
        return true;
    }
}

static void exchange(constrained_robot *c, uint32_t k)
{
    tfa_constraint *x = &c->constraint[k];
    const char *name = x->link[0];
    const uint32_t link = c->link[k][0];
    double pose[7];
    memcpy(pose, x->pose[0], sizeof pose);
    memcpy(x->pose[0], x->pose[1], sizeof pose);
    memcpy(x->pose[1], pose, sizeof pose);
    x->link[0] = x->link[1];
    x->link[1] = name;
    c->link[k][0] = c->link[k][1];
    c->link[k][1] = link;
}

/* q <- q p */
static void turn(double *q, const double *p)
{
    const double w = q[3] * p[3] - q[0] * p[0] - q[1] * p[1] - q[2] * p[2];
    double u[3];
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        u[i] = q[3] * p[i] + p[3] * q[i] + q[a] * p[b] - q[b] * p[a];
    }
    memcpy(q, u, sizeof u);
    q[3] = w;
}

/* Changes constraint k, whose frames have the axes R. */
static void apply(constrained_robot *c, uint32_t k, const mat3 R[2], change *x, random_source *s)
{
    tfa_constraint *of = &c->constraint[k];
    const double angle = random_uniform(s, -1.5, 1.5);
    double by[4] = {0, 0, sin(angle), cos(angle)};
    if (x->kind == EXCHANGED)
        exchange(c, k);
    if (x->kind == TURNED && of->rows != TFA_CONSTRAINT_HINGE)
        random_quaternion(s, by);
    if (x->kind == TURNED)
        turn(of->pose[0] + 3, by);
    for (int e = 0; e < 3 && x->kind == MOVED; e++)
        x->d.x[e] = random_uniform(s, -0.5, 0.5);
    for (int side = 0; side < 2 && x->kind == MOVED; side++) { /* R d of the frame's axes */
        const mat3 own = mat_from_quaternion(of->pose[side] + 3);
        const vec3 to = mat_apply(&own, mat_apply_transposed(&R[side], x->d));
        for (int e = 0; e < 3; e++)
            of->pose[side][e] += (double)to.x[e];
    }
}

/* The constraints of `c` changed, in the reverse order */
static constrained_robot change_all(const constrained_robot *c, const relative_motion *m,
                                    change changes[MOST], random_source *s)
{
    constrained_robot other = *c;
    for (uint32_t k = 0; k < c->count; k++) {
        const uint32_t to = c->count - 1 - k;
        const int kind = random_below(s, 2) ? EXCHANGED : (int)(TURNED + random_below(s, 2));
        changes[k].kind = is_possible(c, k, kind)     ? kind
                          : is_possible(c, k, TURNED) ? TURNED
                                                      : SAME;
        other.constraint[to] = c->constraint[k];
        memcpy(other.link[to], c->link[k], sizeof c->link[k]);
        apply(&other, to, m->R[k], &changes[k], s);
    }
    return other;
}

/* F of constraint k, axes of the world */
static void in_world(const relative_motion *m, const constrained_answer *a, uint32_t k, vec3 F[2])
{
    F[0] = mat_apply(&m->R[k][0], vec_from(a->F + 6 * k));
    F[1] = mat_apply(&m->R[k][0], vec_from(a->F + 6 * k + 3));
}

static double force_error(const constrained_robot *c, const relative_motion *m,
                          const constrained_answer *a, const change *changes)
{
    double error = 0, size = 1e-300;
    for (uint32_t k = 0; k < c->count; k++) {
        vec3 F[2], G[2];
        in_world(&m[0], &a[0], k, F);
        in_world(&m[1], &a[1], c->count - 1 - k, G);
        F[1] = vec_sub(F[1], vec_cross(changes[k].d, F[0]));
        for (int i = 0; i < 6; i++) {
            const double f = (double)F[i / 3].x[i % 3], g = (double)G[i / 3].x[i % 3];
            size = fmax(size, fabs(f));
            error = fmax(error, fabs(g - (changes[k].kind == EXCHANGED ? -f : f)));
        }
    }
    return error / size;
}

static void compare(const constrained_robot *c, const constrained_robot *other,
                    const random_states *x, const change *changes)
{
    static relative_motion m[2];
    static constrained_answer a[2];
    tfa_request r = constrained_request(c, x);
    r.rank_loss = TFA_RANK_TRUNCATE;
    relative_motion_of(c, &r, &m[0]);
    relative_motion_of(other, &r, &m[1]);
    for (int set = 0; set < 2; set++) {
        constrained_ask(c, set ? c->f64 : c->f128, &r, &a[0]);
        constrained_ask(other, set ? other->f64 : other->f128, &r, &a[1]);
        if (a[0].rank.lost || a[0].rank.rank == c->robot->n || a[0].rank.condition > 1e7)
            return; /* redundant forces have no one value; immobile: qdd is 0 */
        const double bound = bounds[set];
        assert_within(c->robot, "qdd", relative_error(a[1].qdd, a[0].qdd, c->robot->n), bound,
                      &worst_qdd[set]);
        assert_within(c->robot, "forces", force_error(c, m, a, changes), bound, &worst_force[set]);
    }
    for (uint32_t k = 0; k < c->count; k++)
        changed[changes[k].kind]++;
}

static void law_of(test_robot *robot, uint32_t round)
{
    static relative_motion m;
    change changes[MOST] = {0};
    random_source s = {31 * robot->seed + 7 * round + robot->base};
    constrained_robot c = {.robot = robot};
    constrained_draw(&c, &s, 1 + round % 2);
    if (!constrained_open(&c))
        return;
    random_states *x = fixture_states(robot, 7, 1, 0);
    admit(&c, x);
    const tfa_request r = constrained_request(&c, x);
    relative_motion_of(&c, &r, &m);
    constrained_robot other = change_all(&c, &m, changes, &s);
    assert_true(constrained_open(&other));
    compare(&c, &other, x, changes);
    constrained_close(&other);
    constrained_close(&c);
    random_states_free(x);
}

static void law(test_robot *robot)
{
    for (uint32_t round = 0; round < 6 && robot->n <= 40; round++)
        law_of(robot, round);
}

TEST(one_set_of_constraints_in_two_descriptions)
{
    for_every_robot(law, false);
    print_message(
        "  qdd within %.1e, in double %.1e; forces %.1e and %.1e; %u exchanged, %u turned, "
        "%u moved\n",
        worst_qdd[0], worst_qdd[1], worst_force[0], worst_force[1], (unsigned)changed[EXCHANGED],
        (unsigned)changed[TURNED], (unsigned)changed[MOVED]);
    for (int k = 0; k < CHANGES; k++)
        assert_true(changed[k] >= 5);
}
