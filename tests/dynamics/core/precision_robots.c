/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Single precision on robots (docs/accuracy.md): answers without a word are right to 2e-2,
 * estimates are at least a thirtieth of the error; but for ten times what the last bits of the
 * request change. Floats alone, and with residuals in double.
 */
#include <math.h>

#include "support/fixture.h"
#include "support/hard_robot.h"
#include "test.h"

#define SILENT 2e-2
#define FLOORS 10
#define ESTIMATE_LOW 30
#define MARKED                                                                                     \
    (TFA_ANSWER_SENTINEL | TFA_ANSWER_FALLBACK | TFA_ANSWER_ESTIMATED |                            \
     TFA_ANSWER_RESIDUAL_PRECISION)
#define NUMBERS (HARD_ROBOT_FREEDOMS + 6)

static const struct {
    tfa_residual residual;
    const char *name;
    double least, unit; /* error that is rounding; last bits, in those of a float */
} precisions[] = {{TFA_RESIDUAL_SAME, "f32", 5e-6, 1},
                  {TFA_RESIDUAL_F64, "f32+f64", 1e-14, 0x1p-29}};
#define PRECISIONS 2

static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_CRBA,
                                     TFA_METHOD_SCAN};

static uint32_t asked, marked, wrong;

static int accelerations(const hard_robot *robot, tfa_workspace *w, const tfa_request *r,
                         double *out, tfa_answer *answer)
{
    tfa_reply reply = {.qdd = out + robot->six, .answers = answer};
    if (robot->six)
        reply.base_acceleration = out;
    return tfa_compute(w, r, &reply);
}

/* Every number one unit of a float up or down */
static void last_bits(random_source *s, double *x, const double *from, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        x[k] = nextafterf((float)from[k], random_below(s, 2) ? INFINITY : -INFINITY);
}

static double floor_of(const hard_robot *robot, random_source *s, const tfa_request *r,
                       const double *want)
{
    static double q[7 * HARD_ROBOT_FREEDOMS], v[HARD_ROBOT_FREEDOMS], tau[HARD_ROBOT_FREEDOMS];
    double got[NUMBERS], floor = 0;
    tfa_answer answer;
    for (int draw = 0; draw < 3; draw++) {
        tfa_request moved = *r;
        last_bits(s, q, r->q, tfa_model_q_count(robot->model));
        last_bits(s, v, robot->v, robot->nv);
        last_bits(s, tau, robot->tau, robot->nv);
        moved.q = q;
        moved.v = r->v ? v : NULL;
        moved.tau = r->tau ? tau : NULL;
        assert_int_equal(accelerations(robot, robot->f128, &moved, got, &answer), TFA_OK);
        floor = fmax(floor, relative_error(got, want, robot->nv + robot->six));
    }
    return floor;
}

static void check(const hard_robot *robot, int precision, const tfa_request *r, double error,
                  double floor, const tfa_answer *a)
{
    const double data = FLOORS * floor * precisions[precision].unit;
    const int low = a->flags & TFA_ANSWER_ESTIMATED &&
                    error > fmax(precisions[precision].least, data) &&
                    !(a->error_estimate >= error / ESTIMATE_LOW);
    const int silent = !(a->flags & MARKED) && !(error <= fmax(SILENT, data));
    asked++;
    marked += (a->flags & TFA_ANSWER_SENTINEL) != 0;
    if ((low || silent) && wrong++ < 20)
        print_message("  %s, %s %s: error %.2g, estimate %.2g, floor %.2g, flags %#x\n",
                      robot->name, precisions[precision].name, tfa_method_name((uint32_t)r->method),
                      error, a->error_estimate, floor, (unsigned)a->flags);
}

static void ask(hard_robot *robot, tfa_workspace *const w[PRECISIONS], random_source *s,
                hard_rhs rhs)
{
    double want[NUMBERS], got[NUMBERS];
    tfa_answer a;
    hard_robot_draw(robot, s, rhs);
    for (uint32_t k = 0; k < tfa_model_q_count(robot->model); k++)
        robot->q[k] = (float)robot->q[k];
    for (int k = 0; k < 7; k++)
        robot->base_pose[k] = (float)robot->base_pose[k];
    tfa_request r = hard_robot_request(robot, rhs);
    r.method = TFA_METHOD_ABA;
    if (accelerations(robot, robot->f128, &r, want, &a) != TFA_OK)
        return;
    const double floor = floor_of(robot, s, &r, want);
    for (int p = 0; p < PRECISIONS; p++)
        for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
            for (int estimate = TFA_ESTIMATE_DEFAULT; estimate <= TFA_ESTIMATE_ALWAYS;
                 estimate += TFA_ESTIMATE_ALWAYS - TFA_ESTIMATE_DEFAULT) {
                r.method = methods[m];
                r.estimate = (tfa_estimate)estimate;
                if (accelerations(robot, w[p], &r, got, &a) == TFA_OK)
                    check(robot, p, &r, relative_error(got, want, robot->nv + robot->six), floor,
                          &a);
            }
}

static void ask_states(hard_robot *robot, uint32_t states)
{
    tfa_workspace *w[PRECISIONS];
    random_source s = {states};
    for (int p = 0; p < PRECISIONS; p++)
        w[p] = fixture_mixed(robot->model, TFA_F32, precisions[p].residual);
    for (uint32_t k = 0; k < states; k++)
        for (int rhs = 0; rhs < HARD_RHS_COUNT; rhs++)
            ask(robot, w, &s, (hard_rhs)rhs);
    for (int p = 0; p < PRECISIONS; p++)
        tfa_workspace_free(w[p]);
}

static void of_file(test_robot *file)
{
    static hard_robot robot;
    if (file->random)
        return;
    robot = (hard_robot){.base = file->base,
                         .model = file->model,
                         .f64 = file->f64,
                         .f128 = file->f128,
                         .nv = file->nv,
                         .six = file->n - file->nv};
    snprintf(robot.name, sizeof robot.name, "%s", file->name);
    ask_states(&robot, test_extent(20, 500));
}

EVERY_ROBOT(robots_have_a_word_where_float_is_short, of_file, false)

/* A head that is almost a point, on rings of which each turns the next about an axis that nearly
 * meets the others: humanoids have such necks. Two pivots of M are small there, and what each loses
 * the other loses once more. Offset between the axes, mass of a ring, gyration radius. */
static const struct {
    double offset, ring, radius;
} necks[] = {{0.01, 0.1, 1e-6}, {0.003, 0.1, 1e-6}, {0.01, 0.001, 3e-3},
             {0.03, 0.1, 1e-3}, {0.001, 1, 1e-4},   {0.01, 1e-5, 1e-5}};
#define INERTIA                                                                                    \
    "<inertial><origin xyz='%g 0 %g'/><mass value='%g'/><inertia ixx='%g' iyy='%g' izz='%g' "      \
    "ixy='0' ixz='0' iyz='0'/></inertial>"
#define HINGE(name, parent, child, axis)                                                           \
    "<joint name='" name "' type='continuous'><parent link='" parent "'/><child link='" child      \
    "'/><axis xyz='" axis "'/><origin xyz='%g 0 0'/></joint>"
static const char neck[] =
    "<robot name='neck'><link name='chest'>" INERTIA "</link><link name='a'>" INERTIA
    "</link><link name='b'>" INERTIA "</link><link name='head'>" INERTIA
    "</link>" HINGE("pitch", "chest", "a", "0 1 0") HINGE("roll", "a", "b", "1 0 0")
        HINGE("yaw", "b", "head", "0 0 1") "</robot>";

TEST(necks_have_a_word_where_float_is_short)
{
    static hard_robot robot;
    char text[2000];
    for (size_t k = 0; k < sizeof necks / sizeof *necks; k++)
        for (int base = 0; base < 2; base++) {
            const double m = necks[k].ring, r2 = necks[k].radius * necks[k].radius;
            snprintf(text, sizeof text, neck, 0.0, 0.1, 5.0, 0.07, 0.08, 0.01, 0.0, 0.0, m, m * r2,
                     m * r2, m * r2, 0.0, 0.0, m, m * r2, m * r2, m * r2, 0.02, 0.11, 1.3, 1.3 * r2,
                     1.3 * r2, 1.3 * r2, 0.002, necks[k].offset, 0.0);
            hard_robot_urdf(text, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED, &robot);
            snprintf(robot.name, sizeof robot.name, "neck %zu, base %d", k, base);
            ask_states(&robot, test_extent(100, 1000));
            hard_robot_close(&robot);
        }
}

TEST(no_answer_is_wrong_in_silence)
{
    print_message("  %u answers, %u marked by the sentinel, %u break the rule\n", asked, marked,
                  wrong);
    assert_int_equal(wrong, 0);
}
