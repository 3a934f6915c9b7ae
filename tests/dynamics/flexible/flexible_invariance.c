/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Laws of mechanics of robots with flexible links, by answers of the library alone: the power of
 * forces and dampers is the rate of the energy; a common velocity, and a common displacement with
 * gravity, change nothing.
 */
#include "models.h"
#include "support/flexible_robot.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

static double energy_of(const flexible_robot *f, tfa_request r)
{
    double energy[2];
    tfa_reply reply = {.energy = energy};
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_ENERGY;
    compute_ok(&f->robot, f->robot.f128, &r, &reply);
    return energy[0] + energy[1];
}

/* All velocities of a state, as flexible_forward orders accelerations */
static void velocities_of(const flexible_robot *f, const flexible_states *s, double *v)
{
    const uint32_t six = f->robot.n - f->robot.nv;
    memcpy(v, s->x->base_twist, six * sizeof *v);
    memcpy(v + six, s->x->v, f->robot.nv * sizeof *v);
    memcpy(v + f->robot.n, s->rates, f->mode_count * sizeof *v);
}

/* Moves `to` from `from` along v and the accelerations x for so long. */
static void step(const flexible_robot *f, const flexible_states *from, const double *v,
                 const double *x, double dt, flexible_states *to)
{
    const uint32_t six = f->robot.n - f->robot.nv;
    step_model(f->robot.model, from->x->q, from->x->base_pose, v, dt, to->x->q, to->x->base_pose);
    for (uint32_t k = 0; k < six; k++)
        to->x->base_twist[k] = from->x->base_twist[k] + dt * x[k];
    for (uint32_t k = 0; k < f->robot.nv; k++)
        to->x->v[k] = from->x->v[k] + dt * x[six + k];
    for (uint32_t k = 0; k < f->mode_count; k++) {
        to->modes[k] = from->modes[k] + dt * v[f->robot.n + k];
        to->rates[k] = from->rates[k] + dt * x[f->robot.n + k];
    }
}

/* tau . v - rate^T D rate, and the sum of the sizes */
static double power_of(const flexible_robot *f, const flexible_states *s, double *size)
{
    double power = 0;
    *size = 0;
    for (uint32_t k = 0; k < f->robot.n; k++) {
        const uint32_t six = f->robot.n - f->robot.nv;
        const double term = k < six ? s->x->base_wrench[k] * s->x->base_twist[k]
                                    : s->x->tau[k - six] * s->x->v[k - six];
        power += term;
        *size += fabs(term);
    }
    for (uint32_t first = 0; first < f->mode_count;) {
        const tfa_mode_info info = tfa_model_mode(f->robot.model, first);
        size_t k = 0;
        while (strcmp(f->modes[k].link, info.link) != 0)
            k++;
        const size_t n = f->modes[k].mode_count;
        for (size_t i = 0; i < n * n; i++) {
            const double term =
                f->modes[k].damping[i] * s->rates[first + i / n] * s->rates[first + i % n];
            power -= term;
            *size += fabs(term);
        }
        first += (uint32_t)n;
    }
    return power;
}

static double worst_power;

/* Differences of dt and dt/2, extrapolated; the largest acceleration chooses dt. */
static void power(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 21, 1, 0),
                    moved = flexible_states_make(f, 21, 1, 0);
    double *x = calloc(f->n, sizeof *x), *v = calloc(f->n, sizeof *v), size, rate[2], scale = 1;
    const tfa_request r = flexible_request(f, &s), there = flexible_request(f, &moved);
    flexible_forward(f, f->robot.f64, &r, x, NULL);
    velocities_of(f, &s, v);
    for (uint32_t k = 0; k < f->n; k++)
        scale = fmax(scale, fabs(x[k]));
    for (int half = 0; half < 2; half++) {
        const double dt = ldexp(0.004 / sqrt(scale), -half);
        rate[half] = 0;
        for (int side = -1; side < 2; side += 2) {
            step(f, &s, v, x, side * dt, &moved);
            rate[half] += side * energy_of(f, there) / (2 * dt);
        }
    }
    const double power = power_of(f, &s, &size);
    assert_within(&f->robot, "power", fabs((4 * rate[1] - rate[0]) / 3 - power) / size, 1e-6,
                  &worst_power);
    free(v);
    free(x);
    flexible_states_free(&moved);
    flexible_states_free(&s);
}

TEST(power_of_forces_is_the_rate_of_the_energy)
{
    for_every_flexible_robot(power);
    print_message("  worst %.2g\n", worst_power);
}

/* A pendulum of two flexible links, released: by the method of Runge and Kutta over 0.1 s */
static double drift(uint32_t steps)
{
    flexible_robot f;
    flexible_open_chain(&f, 2, 5, false);
    flexible_states s = flexible_states_make(&f, 4, 1, 0), y = flexible_states_make(&f, 4, 1, 0);
    double *x[4], *v[4];
    for (int k = 0; k < 4; k++) {
        x[k] = calloc(f.n, sizeof **x);
        v[k] = calloc(f.n, sizeof **v);
    }
    for (size_t l = 0; l < f.links; l++) /* no damping: the model has its own copy */
        for (size_t e = 0; e < f.modes[l].mode_count * f.modes[l].mode_count; e++)
            ((double *)(uintptr_t)f.modes[l].damping)[e] = 0;
    const tfa_model_options options = {.scene = &f.scene};
    SCOPED_MODEL *model = compiled(f.robot.description, &options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    tfa_request r = flexible_request(&f, &s), at = flexible_request(&f, &y);
    r.tau = at.tau = NULL;
    const double before = energy_of(&f, r), dt = 0.1 / steps;
    for (uint32_t k = 0; k < steps; k++) {
        for (int stage = 0; stage < 4; stage++) {
            static const double at_time[4] = {0, 0.5, 0.5, 1};
            const int from = stage ? stage - 1 : 0;
            step(&f, &s, v[from], x[from], at_time[stage] * dt, &y);
            velocities_of(&f, &y, v[stage]);
            flexible_forward(&f, w, &at, x[stage], NULL);
        }
        for (uint32_t e = 0; e < f.n; e++) {
            x[0][e] = (x[0][e] + 2 * x[1][e] + 2 * x[2][e] + x[3][e]) / 6;
            v[0][e] = (v[0][e] + 2 * v[1][e] + 2 * v[2][e] + v[3][e]) / 6;
        }
        step(&f, &s, v[0], x[0], dt, &s);
    }
    const double change = fabs(energy_of(&f, r) - before) / (1 + fabs(before));
    for (int k = 0; k < 4; k++) {
        free(x[k]);
        free(v[k]);
    }
    flexible_states_free(&y);
    flexible_states_free(&s);
    flexible_close(&f);
    return change;
}

TEST(a_free_pendulum_keeps_its_energy)
{
    const double coarse = drift(25), fine = drift(50);
    print_message("  %.2g, %.2g\n", coarse, fine);
    assert_true(coarse < 1e-4 && fine < coarse / 8);
}

/* ---- common velocity ---- */

static const tfa_method methods[] = {TFA_METHOD_ABA, TFA_METHOD_SCAN, TFA_METHOD_SCAN_TWO_PASS,
                                     TFA_METHOD_DCA};
#define METHODS (sizeof methods / sizeof *methods)

static void cross(const double *a, const double *b, double out[3])
{
    for (int e = 0; e < 3; e++)
        out[e] = a[(e + 1) % 3] * b[(e + 2) % 3] - a[(e + 2) % 3] * b[(e + 1) % 3];
}

static double worst_velocity, worst_turn;

/* V and w are multiples of 1/64: w x V is exact. */
static void common_velocity(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 31, 1, 2);
    double *x[2] = {calloc(f->n, sizeof **x), calloc(f->n, sizeof **x)}, rate[3];
    if (f->robot.base == TFA_BASE_FIXED)
        goto done;
    tfa_request r = flexible_request(f, &s);
    for (size_t m = 0; m < METHODS; m++) {
        r.method = methods[m];
        if (fixture_refuses(&f->robot, r.method))
            continue;
        for (int e = 0; e < 6; e++)
            s.x->base_twist[e] = e < 3 ? 0 : round(64 * s.x->base_twist[e]) / 64;
        flexible_forward(f, f->robot.f64, &r, x[0], NULL);
        for (int e = 0; e < 3; e++)
            s.x->base_twist[e] = 8000 - 3000 * e;
        cross(s.x->base_twist + 3, s.x->base_twist, rate);
        flexible_forward(f, f->robot.f64, &r, x[1], NULL);
        for (int e = 0; e < 3; e++)
            x[1][e] += rate[e];
        for (uint32_t k = 0; k < f->n; k++)
            x[1][k] -= x[0][k];
        assert_within(&f->robot, tfa_method_name(methods[m]),
                      norm2(x[1], f->n) / (norm2(x[0], f->n) + norm2(rate, 3)), 1e-14,
                      &worst_velocity);
    }
done:
    free(x[1]);
    free(x[0]);
    flexible_states_free(&s);
}

TEST(a_common_velocity_changes_no_acceleration)
{
    for_every_flexible_robot(common_velocity);
    print_message("  worst %.2g\n", worst_velocity);
}

/* ---- common displacement ---- */

static void multiply(const double *a, const double *b, double *out)
{
    double c[4];
    cross(a, b, c);
    c[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
    for (int i = 0; i < 3; i++)
        c[i] += a[3] * b[i] + b[3] * a[i];
    memcpy(out, c, sizeof c);
}

static void displace(const double turn[4], const double shift[3], double *position, double *quat)
{
    rotate_vector(turn, position, position);
    for (int i = 0; i < 3; i++)
        position[i] += shift[i];
    multiply(turn, quat, quat);
}

/* The floating base, or the joints on the fixed one */
static void common_displacement(flexible_robot *f)
{
    const uint32_t root = description_root(f->robot.description);
    const tfa_model_options options = {.base = f->robot.base, .scene = &f->scene};
    tfa_description *d = f->robot.description;
    flexible_states s = flexible_states_make(f, 41, 1, 2);
    random_source source = {f->robot.seed};
    double *x[2] = {calloc(f->n, sizeof **x), calloc(f->n, sizeof **x)}, turn[4];
    const double shift[3] = {3, -2, 1};
    tfa_request r = flexible_request(f, &s);
    r.frame = TFA_FRAME_LOCAL;
    r.wrench_count = f->robot.base == TFA_BASE_FLOATING ? 2 : 0; /* none turns with the world */
    SCOPED_MODEL *before = compiled(d, &options);
    SCOPED_WORKSPACE *w = workspace_for(before, NULL);
    flexible_forward(f, w, &r, x[0], NULL);
    random_quaternion(&source, turn);
    for (size_t j = 0; j < d->joint_count; j++)
        if (f->robot.base == TFA_BASE_FIXED && d->joints[j].parent == root) {
            displace(turn, shift, d->joints[j].xyz, d->joints[j].quat);
            memset(d->joints[j].quat_low, 0, sizeof d->joints[j].quat_low);
        }
    if (f->robot.base == TFA_BASE_FLOATING)
        displace(turn, shift, s.x->base_pose, s.x->base_pose + 3);
    rotate_vector(turn, s.x->gravity, s.x->gravity);
    SCOPED_MODEL *after = compiled(d, &options);
    SCOPED_WORKSPACE *displaced = workspace_for(after, NULL);
    flexible_forward(f, displaced, &r, x[1], NULL);
    assert_within(&f->robot, "displaced", relative_error(x[1], x[0], f->n), 1e-11, &worst_turn);
    free(x[1]);
    free(x[0]);
    flexible_states_free(&s);
}

TEST(a_common_displacement_changes_no_acceleration)
{
    for_every_flexible_robot(common_displacement);
    print_message("  worst %.2g\n", worst_turn);
}
