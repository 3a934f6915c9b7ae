/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constrained dynamics against the dense system of Gauss's principle in quadruple precision, with M
 * and h by the oracle and J_c by its definition:
 *
 *     [M J^T; J 0] [qdd; -F] = [tau - h; a - J-dot v]
 *
 * solved by elimination with complete pivoting. Redundant rows end it early: qdd and J^T F are
 * unique all the same where a can be met, F is not. And the forces do no work along velocities that
 * the constraints admit.
 */
#include "constrained_robot.h"
#include "support/oracle_motion.h"
#include "test.h"

enum { SIZE = FREEDOMS + ROWS };
enum { QDD, FORCE, JOINT_FORCE, WORK, KINDS };

static constrained_law laws[KINDS] = {{"qdd", {1e-12, 1e-9}, {0}},
                                      {"F", {1e-13, 1e-11}, {0}},
                                      {"J^T F", {1e-11, 1e-11}, {0}},
                                      {"work", {1e-15, 1e-13}, {0}}};
static uint32_t sets, full, redundant;

/* ---- the dense system ---- */

static quad K[SIZE * (SIZE + 1)]; /* with its right side */

static quad *row_of(uint32_t i)
{
    return K + (size_t)i * (SIZE + 1);
}

static quad size_of(quad x)
{
    return x < 0 ? -x : x;
}

static void swap(quad *a, quad *b)
{
    const quad x = *a;
    *a = *b;
    *b = x;
}

/* Largest entry of rows and columns from `k` on to (k, k); `column` is permuted alike. */
static quad pivot(uint32_t k, uint32_t n, uint32_t *column)
{
    uint32_t at = k, to = k;
    for (uint32_t i = k; i < n; i++)
        for (uint32_t j = k; j < n; j++)
            if (size_of(row_of(i)[j]) > size_of(row_of(at)[to])) {
                at = i;
                to = j;
            }
    for (uint32_t j = 0; j <= SIZE; j++)
        if (at != k)
            swap(&row_of(k)[j], &row_of(at)[j]);
    for (uint32_t i = 0; i < n && to != k; i++)
        swap(&row_of(i)[k], &row_of(i)[to]);
    const uint32_t c = column[k];
    column[k] = column[to];
    column[to] = c;
    return size_of(row_of(k)[k]);
}

/* Solves n rows. Returns those that are not met by their own pivot; in `left` what stays of their
 * right sides. */
static uint32_t eliminate(uint32_t n, quad *x, double *left)
{
    uint32_t column[SIZE], k = 0;
    quad first = 0;
    for (uint32_t j = 0; j < n; j++)
        column[j] = j;
    for (; k < n; k++) {
        const quad size = pivot(k, n, column);
        first = k ? first : size;
        if (!(size > (quad)1e-14 * first)) /* poses are rounded to double */
            break;
        for (uint32_t i = k + 1; i < n; i++) {
            const quad f = row_of(i)[k] / row_of(k)[k];
            for (uint32_t j = k; j < n && f != 0; j++)
                row_of(i)[j] -= f * row_of(k)[j];
            row_of(i)[SIZE] -= f * row_of(k)[SIZE];
        }
    }
    memset(x, 0, n * sizeof *x);
    *left = 0;
    for (uint32_t i = k; i < n; i++)
        *left = fmax(*left, (double)size_of(row_of(i)[SIZE]));
    for (uint32_t i = k; i-- > 0;) {
        quad sum = row_of(i)[SIZE];
        for (uint32_t j = i + 1; j < k; j++)
            sum -= row_of(i)[j] * x[column[j]];
        x[column[i]] = sum / row_of(i)[i];
    }
    return n - k;
}

/* ---- one request ---- */

typedef struct problem {
    constrained_robot *c;
    const tfa_request *r;
    relative_motion m;
    uint32_t n, row[ROWS], rows, lost;
    quad h[FREEDOMS], force[FREEDOMS];  /* tau */
    quad x[SIZE], constraint[FREEDOMS]; /* the solution; J^T F of it */
    double wanted[ROWS];
} problem;

static quad *M_of(const problem *p, uint32_t i)
{
    return p->c->robot->o->Mt + (size_t)i * p->n;
}

static double solve(problem *p)
{
    double left;
    memset(K, 0, sizeof K);
    for (uint32_t i = 0; i < p->n; i++) {
        memcpy(row_of(i), M_of(p, i), p->n * sizeof(quad));
        row_of(i)[SIZE] = p->force[i] - p->h[i];
    }
    for (uint32_t k = 0; k < p->rows; k++) {
        const uint32_t i = p->row[k];
        for (uint32_t j = 0; j < p->n; j++)
            row_of(j)[p->n + k] = row_of(p->n + k)[j] = p->m.J[(size_t)i * p->n + j];
        row_of(p->n + k)[SIZE] = p->wanted[i] - p->m.bias[i];
    }
    p->lost = eliminate(p->n + p->rows, p->x, &left);
    memset(p->constraint, 0, sizeof p->constraint);
    for (uint32_t k = 0; k < p->rows; k++)
        for (uint32_t j = 0; j < p->n; j++)
            p->constraint[j] -= p->x[p->n + k] * p->m.J[(size_t)p->row[k] * p->n + j];
    return left;
}

/* Accelerations that some qdd has */
static void want_possible(problem *p, random_source *s)
{
    double qdd[FREEDOMS];
    for (uint32_t j = 0; j < p->n; j++)
        qdd[j] = random_uniform(s, -5, 5);
    for (uint32_t i = 0; i < 6 * p->c->count; i++) {
        quad sum = p->m.bias[i];
        for (uint32_t j = 0; j < p->n; j++)
            sum += p->m.J[(size_t)i * p->n + j] * qdd[j];
        p->wanted[i] = (double)sum;
    }
}

static void begin(problem *p, constrained_robot *c, tfa_request *r, random_source *s)
{
    p->c = c;
    p->n = c->robot->n;
    p->r = r;
    p->rows = held_rows(c, p->row);
    relative_motion_of(c, r, &p->m);
    oracle_bias_force(c->robot->o, p->h);
    const uint32_t six = p->n - c->robot->nv;
    for (uint32_t j = 0; j < p->n; j++)
        p->force[j] = j < six ? r->base_wrench[j] : r->tau[j - six];
    for (uint32_t i = 0; i < ROWS; i++)
        p->wanted[i] = random_uniform(s, -20, 20);
    (void)solve(p);
    if (p->lost) { /* at random nothing meets them */
        want_possible(p, s);
        assert_true(solve(p) < 1e-9);
    }
    r->constraint_acceleration = p->wanted;
}

/* M qdd + h - tau does no work along an admissible velocity. */
static void check_work(const problem *p, int set, const double *qdd, random_source *s)
{
    static quad v[FREEDOMS], less[FREEDOMS];
    quad w[ROWS] = {0}, work = 0, size = 0;
    for (uint32_t j = 0; j < p->n; j++)
        v[j] = random_uniform(s, -1, 1);
    for (uint32_t i = 0; i < 6 * p->c->count; i++)
        for (uint32_t j = 0; j < p->n; j++)
            w[i] += p->m.J[(size_t)i * p->n + j] * v[j];
    (void)least_norm(p->c, &p->m, w, less);
    for (uint32_t i = 0; i < p->n; i++) {
        quad f = p->h[i] - p->force[i], terms = size_of(p->h[i]) + size_of(p->force[i]);
        for (uint32_t j = 0; j < p->n; j++) {
            f += M_of(p, i)[j] * qdd[j];
            terms += size_of(M_of(p, i)[j] * qdd[j]);
        }
        work += (v[i] - less[i]) * f;
        size += size_of(v[i]) * terms;
    }
    constrained_within(p->c, &laws[WORK], set, (double)(size_of(work) / size), 1);
}

/* Of numbers whose reference is in quadruple precision */
static double error_of(const double *x, const quad *reference, uint32_t n)
{
    double rounded[SIZE];
    for (uint32_t k = 0; k < n; k++)
        rounded[k] = (double)reference[k];
    return relative_error(x, rounded, n);
}

/* Of J^T F, relative to its terms */
static double force_error(const problem *p, const constrained_answer *a)
{
    double error[FREEDOMS], terms[FREEDOMS] = {0};
    for (uint32_t j = 0; j < p->n; j++) {
        quad sum = -p->constraint[j];
        for (uint32_t i = 0; i < 6 * p->c->count; i++) {
            const quad term = a->F[i] * p->m.J[(size_t)i * p->n + j];
            sum += term;
            terms[j] += fabs((double)term);
        }
        error[j] = (double)sum;
    }
    return norm2(error, p->n) / norm2(terms, p->n);
}

static void check(const problem *p, tfa_workspace *w, int set, random_source *s)
{
    static constrained_answer a;
    double F[ROWS];
    constrained_ask(p->c, w, p->r, &a);
    if (a.rank.lost != p->lost)
        fail_msg("%s: %u directions lost, not %u", p->c->robot->name, (unsigned)a.rank.lost,
                 (unsigned)p->lost);
    assert_int_equal(!!(a.answer.flags & TFA_ANSWER_RANK_LOSS), p->lost != 0);
    constrained_within(p->c, &laws[QDD], set, error_of(a.qdd, p->x, p->n), 1);
    constrained_within(p->c, &laws[JOINT_FORCE], set, force_error(p, &a), 1);
    for (uint32_t k = 0; k < p->rows; k++)
        F[k] = -a.F[p->row[k]];
    if (p->lost == 0)
        constrained_within(p->c, &laws[FORCE], set, error_of(F, p->x + p->n, p->rows), 1);
    check_work(p, set, a.qdd, s);
}

/* Every constraint twice, under another name */
static void repeat(constrained_robot *c)
{
    for (uint32_t k = 0, count = c->count; k < count; k++) {
        tfa_constraint *x = constrained_add(c, c->link[k][0], c->link[k][1], c->constraint[k].rows);
        memcpy(x->pose, c->constraint[k].pose, sizeof x->pose);
    }
}

/* The four feet of a quadruped on the ground: 24 rows for 18 freedoms */
static void weld_feet(constrained_robot *c)
{
    const tfa_description *d = c->robot->description;
    for (uint32_t k = 0; k < d->link_count && strstr(c->robot->name, "quadruped.urdf"); k++)
        if (strstr(d->links[k].name, "_foot"))
            constrained_add(c, WORLD, k, TFA_CONSTRAINT_WELD);
}

static void law_of(constrained_robot *c, random_source *s)
{
    static problem p;
    if (!constrained_open(c))
        return;
    random_states *states = fixture_states(c->robot, 6, 1, 0);
    tfa_request r = constrained_request(c, states);
    r.rank_loss = TFA_RANK_TRUNCATE;
    begin(&p, c, &r, s);
    check(&p, c->f128, 0, s);
    check(&p, c->f64, 1, s);
    sets++;
    full += p.lost == 0;
    redundant += p.lost != 0;
    random_states_free(states);
    constrained_close(c);
}

static void law(test_robot *robot)
{
    enum { ONE, SEVERAL, TWICE, FEET, SCENES };
    if (robot->n > 64)
        return;
    for (uint32_t scene = 0; scene < SCENES; scene++) {
        random_source s = {10 * robot->seed + 2 * scene + robot->base};
        constrained_robot c = {.robot = robot};
        if (scene == FEET)
            weld_feet(&c);
        else
            constrained_draw(&c, &s, scene == SEVERAL ? MOST : scene == TWICE ? MOST / 2 : 1);
        if (scene == TWICE)
            repeat(&c);
        law_of(&c, &s);
    }
}

TEST(dense_system_in_quadruple_precision)
{
    for_every_robot(law, false);
    constrained_print(laws, KINDS);
    print_message("  %u sets of constraints, %u of full rank\n", (unsigned)sets, (unsigned)full);
    assert_true(sets > 60 && full > 20 && redundant > 40);
}
