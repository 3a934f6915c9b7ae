/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible links that are rigid robots: pieces and joints of a rigid robot as one flexible link,
 * whose modes are the angles of these joints, or combinations of them; and infinitely heavy modes.
 *
 * The data of the link are those that the library gives of the pieces on a floating base: M, poses
 * and Jacobians of the frames that child joints hang on. The truth is the library's rigid answer.
 */
#include "models.h"
#include "support/flexible_robot.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

/* root - A; A - B - C and B - D inside; E on C, F on D, G on A. Joint k carries link k + 1. */
enum { A = 1, B, C, D, E, F, G, LINKS };
enum { INNER = 3, OUTER = 3, ALL = 1 + INNER + OUTER }; /* joints: A's, B C D's, E F G's */
static const uint32_t parents[LINKS] = {[B] = A, [C] = B, [D] = B, [E] = C, [F] = D, [G] = A};

/* One rigid robot, and the flexible one that it is */
typedef struct pair {
    small_robot rigid, pieces, flexible;
    double q[INNER], phi[INNER][INNER]; /* pose of the pieces, and angles by modes */
    double momentum[INNER * 6], mass[INNER * INNER], stiffness[INNER * INNER];
    double shapes[OUTER][INNER * 6];
    tfa_mode_shape shape[OUTER];
    tfa_link_modes modes;
    tfa_scene scene;
} pair;

static void copy_mass(tfa_link *to, const tfa_link *from)
{
    const char *name = to->name;
    *to = *from;
    to->name = name;
}

static void copy_joint(tfa_joint *to, const tfa_joint *from, uint32_t parent)
{
    const tfa_joint copy = *to;
    *to = *from;
    to->name = copy.name;
    to->child = copy.child;
    to->parent = parent;
}

static void make_rigid(pair *p, random_source *s)
{
    small_robot_begin(&p->rigid);
    for (uint32_t k = A; k < LINKS; k++) {
        const double x[3] = {1, 0, 0};
        double turn[4], payload[TFA_PAYLOAD_NUMBERS];
        const bool slides = random_below(s, 4) == 0;
        tfa_joint *j = small_robot_add(&p->rigid, parents[k],
                                       slides ? TFA_JOINT_PRISMATIC : TFA_JOINT_REVOLUTE, 0, 0, 0);
        random_quaternion(s, turn);
        rotate_vector(turn, x, j->axis);
        random_quaternion(s, j->quat);
        for (int i = 0; i < 3; i++)
            j->xyz[i] = random_uniform(s, -0.4, 0.4);
        random_payload(s, payload);
        tfa_link *link = &p->rigid.link[k];
        link->mass = payload[0];
        memcpy(link->com, payload + 1, sizeof link->com);
        memcpy(link->inertia, payload + 4, sizeof link->inertia);
    }
    copy_mass(&p->rigid.link[0], &p->rigid.link[B]); /* a floating base has mass */
    for (int k = 0; k < INNER; k++)
        p->q[k] = random_uniform(s, -1, 1);
}

/* A, B, C, D, then a link without mass where each of E, F, G hangs */
static void make_pieces(pair *p)
{
    small_robot_begin(&p->pieces);
    copy_mass(&p->pieces.link[0], &p->rigid.link[A]);
    for (uint32_t k = B; k < LINKS; k++) {
        tfa_joint *j = small_robot_add(&p->pieces, 0, TFA_JOINT_FIXED, 1, 0, 0);
        copy_joint(j, &p->rigid.joint[k - 1], parents[k] - A);
        if (k >= E)
            j->type = TFA_JOINT_FIXED;
        else
            copy_mass(&p->pieces.link[k - A], &p->rigid.link[k]);
    }
}

/* M, and poses and Jacobians of the three frames, of the pieces at rest at the origin */
typedef struct facts {
    double M[(6 + INNER) * (6 + INNER)], poses[OUTER * 7], J[OUTER * 6 * (6 + INNER)];
} facts;

static facts facts_of(const pair *p)
{
    facts x;
    const double here[7] = {0, 0, 0, 0, 0, 0, 1};
    const tfa_model_options options = {.base = TFA_BASE_FLOATING};
    const tfa_workspace_options quad_precision = {.precision = TFA_F128};
    SCOPED_MODEL *model = compiled(&p->pieces.d, &options);
    SCOPED_WORKSPACE *w = workspace_for(model, &quad_precision);
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1, .q = p->q, .base_pose = here};
    tfa_reply reply = {.mass_matrix = x.M, .poses = x.poses, .jacobian = x.J};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_POSES | TFA_WANT_JACOBIAN;
    r.tip_count = OUTER;
    for (uint32_t t = 0; t < OUTER; t++)
        r.tips[t] = E - A + t;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    return x;
}

/* Mass, centre and inertia of a rigid body from its M, linear first */
static void load_by_mass_matrix(tfa_link *link, const double *M, size_t n)
{
    const double m = M[0], c[3] = {M[n + 5] / m, -M[5] / m, M[4] / m};
    const double cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    link->mass = m;
    memcpy(link->com, c, sizeof c);
    for (uint32_t i = 0, e = 0; i < 3; i++)
        for (uint32_t j = i; j < 3; j++, e++)
            link->inertia[e] = M[(3 + i) * n + 3 + j] - m * ((i == j ? cc : 0) - c[i] * c[j]);
}

/* Columns of J phi, for `modes` modes: rows of six */
static void combine(const pair *p, const double *J, size_t n, uint32_t modes, double *out)
{
    for (uint32_t k = 0; k < modes; k++)
        for (uint32_t e = 0; e < 6; e++) {
            out[6 * k + e] = 0;
            for (uint32_t i = 0; i < INNER; i++)
                out[6 * k + e] += J[e * n + 6 + i] * p->phi[i][k];
        }
}

static void make_flexible(pair *p, uint32_t modes)
{
    const size_t n = 6 + INNER;
    const facts x = facts_of(p);
    small_robot_begin(&p->flexible);
    copy_mass(&p->flexible.link[0], &p->rigid.link[0]);
    copy_joint(small_robot_add(&p->flexible, 0, TFA_JOINT_REVOLUTE, 1, 0, 0), &p->rigid.joint[0],
               0);
    load_by_mass_matrix(&p->flexible.link[1], x.M, n);
    for (uint32_t t = 0; t < OUTER; t++) {
        tfa_joint *j = small_robot_add(&p->flexible, 1, TFA_JOINT_REVOLUTE, 1, 0, 0);
        copy_joint(j, &p->rigid.joint[E - 1 + t], 1);
        memcpy(j->xyz, x.poses + 7 * t, sizeof j->xyz);
        memcpy(j->quat, x.poses + 7 * t + 3, sizeof j->quat);
        copy_mass(&p->flexible.link[2 + t], &p->rigid.link[E + t]);
        combine(p, x.J + t * 6 * n, n, modes, p->shapes[t]);
        p->shape[t] = (tfa_mode_shape){j->name, p->shapes[t]};
    }
    combine(p, x.M, n, modes, p->momentum);
    for (uint32_t k = 0; k < modes; k++)
        for (uint32_t l = 0; l < modes; l++) {
            p->mass[k * modes + l] = 0;
            for (uint32_t i = 0; i < INNER; i++)
                for (uint32_t j = 0; j < INNER; j++)
                    p->mass[k * modes + l] +=
                        p->phi[i][k] * x.M[(6 + i) * n + 6 + j] * p->phi[j][l];
        }
    p->modes = (tfa_link_modes){.link = p->flexible.link[1].name,
                                .mode_count = modes,
                                .momentum = p->momentum,
                                .mass = p->mass,
                                .stiffness = p->stiffness,
                                .shapes = p->shape,
                                .shape_count = OUTER};
    p->scene = (tfa_scene){.modes = &p->modes, .modes_count = 1};
}

/* M and h of the rigid robot, base first */
static void equations(const tfa_model *model, tfa_request r, double *M, double *h)
{
    const tfa_workspace_options quad_precision = {.precision = TFA_F128};
    const uint32_t n = tfa_model_base_freedoms(model) + ALL;
    double gravity[6 + ALL], velocity[6 + ALL];
    tfa_reply reply = {.mass_matrix = M, .gravity_force = gravity, .velocity_force = velocity};
    SCOPED_WORKSPACE *w = workspace_for(model, &quad_precision);
    r.op = TFA_OP_BIAS;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r.op = TFA_OP_MASS_MATRIX;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    for (uint32_t k = 0; k < n; k++)
        h[k] = gravity[k] + velocity[k];
}

/* T^T M T z = T^T (tau - h): z has the base, A's joint, E F G's joints, then the modes, as answers
 * of the flexible robot have. */
static void project(const pair *p, const double *M, const double *h, const double *tau,
                    uint32_t six, uint32_t modes, double *want)
{
    const uint32_t n = six + ALL, rows = n - INNER + modes;
    quad T[6 + ALL][6 + ALL] = {{0}}, TMT[(6 + ALL) * (6 + ALL)] = {0}, z[6 + ALL] = {0};
    for (uint32_t k = 0; k < n; k++) {
        if (k <= six)
            T[k][k] = 1;
        else if (k > six + INNER)
            T[k][k - INNER] = 1;
        else
            for (uint32_t m = 0; m < modes; m++)
                T[k][n - INNER + m] = p->phi[k - six - 1][m];
    }
    for (uint32_t i = 0; i < rows; i++)
        for (uint32_t k = 0; k < n; k++) {
            z[i] += T[k][i] * ((quad)tau[k] - h[k]);
            for (uint32_t j = 0; j < rows; j++)
                for (uint32_t l = 0; l < n; l++)
                    TMT[i * rows + j] += T[k][i] * M[k * n + l] * T[l][j];
        }
    quad_factorise(TMT, rows);
    quad_solve(TMT, rows, z);
    for (uint32_t k = 0; k < rows; k++)
        want[k] = (double)z[k];
}

static const tfa_method methods[] = {TFA_METHOD_ABA, TFA_METHOD_SCAN, TFA_METHOD_SCAN_TWO_PASS,
                                     TFA_METHOD_DCA};
#define METHODS (sizeof methods / sizeof *methods)

/* All that is inboard of the pieces is at rest: products of velocities of the pieces are of second
 * order in their displacement, which modes leave out. */
static void compare(const pair *p, random_source *s, tfa_base base, uint32_t modes, double *worst)
{
    const uint32_t six = base ? 6 : 0, rows = six + 1 + OUTER + modes;
    const tfa_model_options rigid_options = {.base = base};
    const tfa_model_options flexible_options = {.base = base, .scene = &p->scene};
    double q[ALL], v[ALL] = {0}, tau[6 + ALL] = {0}, pose[7] = {0.3, -0.2, 0.1}, gravity[3];
    double M[(6 + ALL) * (6 + ALL)], h[6 + ALL], want[6 + ALL], q1[1 + OUTER], v1[1 + OUTER],
        tau1[1 + OUTER];
    random_quaternion(s, pose + 3);
    for (uint32_t k = 0; k < ALL; k++) {
        const bool inner = k > 0 && k <= INNER;
        q[k] = inner ? p->q[k - 1] : random_uniform(s, -2, 2);
        v[k] = k > INNER ? random_uniform(s, -2, 2) : 0;
        tau[six + k] = inner ? 0 : random_uniform(s, -5, 5);
    }
    for (uint32_t k = 0; k < 1 + OUTER; k++) {
        const uint32_t from = k ? k + INNER : 0;
        q1[k] = q[from];
        v1[k] = v[from];
        tau1[k] = tau[six + from];
    }
    for (int i = 0; i < 3; i++)
        gravity[i] = random_uniform(s, -10, 10);
    tfa_request r = {.count = 1, .q = q, .v = v, .base_pose = pose, .gravity = gravity};
    SCOPED_MODEL *rigid = compiled(&p->rigid.d, &rigid_options);
    equations(rigid, r, M, h);
    project(p, M, h, tau, six, modes, want);
    flexible_robot f = {.robot = {.base = base, .name = "pieces", .nv = 1 + OUTER}};
    f.robot.n = six + 1 + OUTER;
    f.n = rows;
    f.mode_count = modes;
    SCOPED_MODEL *flexible = compiled(&p->flexible.d, &flexible_options);
    f.robot.model = flexible;
    SCOPED_WORKSPACE *w = workspace_for(flexible, NULL);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.q = q1;
    r.v = v1;
    r.tau = tau1;
    for (size_t m = 0; m < METHODS; m++) {
        double got[6 + ALL];
        r.method = methods[m];
        flexible_forward(&f, w, &r, got, NULL);
        assert_within(&f.robot, tfa_method_name(methods[m]), relative_error(got, want, rows), 1e-12,
                      worst);
    }
}

/* Modes 3 of 3: phi is the identity, which is the rigid robot itself. */
static void pieces_as_modes(uint32_t modes)
{
    double worst = 0;
    for (uint64_t seed = 1; seed <= test_extent(10, 100); seed++)
        for (int floating = 0; floating < 2; floating++) {
            random_source s = {seed};
            pair p = {0};
            make_rigid(&p, &s);
            make_pieces(&p);
            for (uint32_t i = 0; i < INNER; i++)
                for (uint32_t k = 0; k < modes; k++)
                    p.phi[i][k] = modes == INNER ? i == k : random_uniform(&s, -1, 1);
            make_flexible(&p, modes);
            compare(&p, &s, floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED, modes, &worst);
        }
    print_message("  worst %.2g\n", worst);
}

TEST(joints_as_modes_are_the_rigid_robot)
{
    pieces_as_modes(INNER);
}

TEST(combinations_of_joints_are_the_projected_robot)
{
    for (uint32_t modes = 1; modes < INNER; modes++)
        pieces_as_modes(modes);
}

/* ---- heavy modes ---- */

/* Modes that are heavier by 1e14 do not accelerate, and the robot is that of rigid links: the
 * oracle's, with the same payloads. */
static void heavy_modes(flexible_robot *given)
{
    test_robot *r = &given->robot;
    flexible_states s = flexible_states_make(given, 3, 1, 2);
    double *want = calloc(r->n, sizeof *want), *got = calloc(given->n, sizeof *got);
    double *heavy = calloc(given->links * TFA_MAX_LINK_MODES * TFA_MAX_LINK_MODES, sizeof *heavy);
    tfa_link_modes *modes = calloc(given->links, sizeof *modes);
    const tfa_scene scene = {.modes = modes, .modes_count = given->links};
    const tfa_model_options options = {.base = r->base, .scene = &scene};
    tfa_request request = fixture_request(r, s.x);
    for (size_t k = 0; k < given->links; k++) {
        const size_t n = given->modes[k].mode_count;
        double *M = heavy + k * TFA_MAX_LINK_MODES * TFA_MAX_LINK_MODES;
        for (size_t e = 0; e < n * n; e++)
            M[e] = 1e14 * given->modes[k].mass[e];
        modes[k] = given->modes[k];
        modes[k].mass = M;
    }
    SCOPED_MODEL *model = compiled(r->description, &options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    oracle_set_state(r->o, &request, 0);
    oracle_forward(r->o, s.x->tau, s.x->base_wrench, want + r->n - r->nv, want);
    for (size_t m = 0; m < METHODS; m++) {
        request.method = methods[m];
        if (fixture_refuses(r, methods[m]))
            continue;
        flexible_forward(given, w, &request, got, NULL);
        assert_within(r, tfa_method_name(methods[m]), relative_error(got, want, r->n), 1e-9, NULL);
        assert_within(r, "modes", norm2(got + r->n, given->mode_count), 1e-9 * norm2(want, r->n),
                      NULL);
    }
    free(modes);
    free(heavy);
    free(got);
    free(want);
    flexible_states_free(&s);
}

EVERY_FLEXIBLE_ROBOT(heavy_modes_do_not_move, heavy_modes)
