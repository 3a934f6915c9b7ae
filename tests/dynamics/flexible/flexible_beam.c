/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A uniform beam, whose frequencies are in the literature (Blevins, Formulas for Natural Frequency
 * and Mode Shape, 1979, tables 8-1 and 8-8): omega = beta^2 sqrt(EI / (rho A L^4)).
 *
 * Along x, bending in the plane x, y, by clamped-free modes
 *     phi = cosh b x - cos b x - s (sinh b x - sin b x),   cosh b L cos b L = -1,
 * of which integrals over 0..L are: phi^2: L;  phi: 2 s / b;  x phi: 2 / b^2;  phi''^2: b^4 L.
 * At the end phi = 2 (-1)^k, k = 0, 1, ..., and phi' = phi b s (-1)^k.
 */
#include "models.h"
#include "support/small_robot.h"
#include "test.h"

#define MODES 5
static const double length = 1.7, line_mass = 2.3, stiffness = 41; /* m, kg/m, N m^2 */

/* A beam behind a joint about z, a load on its end by a fixed joint */
typedef struct beam {
    small_robot r;
    double momentum[MODES * 6], mass[MODES * MODES], K[MODES * MODES], shape[MODES * 6];
    tfa_mode_shape end;
    tfa_link_modes modes;
    tfa_scene scene;
    uint32_t n;
} beam;

/* b L of mode k, by bisection of cos = - 1 / cosh */
static double root(int k)
{
    const double pi = 3.14159265358979323846, middle = (k + 0.5) * pi;
    double low = middle - 0.5, high = middle + 0.5;
    for (int i = 0; i < 100; i++) {
        const double x = (low + high) / 2;
        *((cos(x) + 1 / cosh(x) > 0) == (cos(low) + 1 / cosh(low) > 0) ? &low : &high) = x;
    }
    return low;
}

static void make_beam(beam *x, uint32_t n, double armature, double load)
{
    memset(x, 0, sizeof *x);
    x->n = n;
    small_robot_begin(&x->r);
    small_robot_add(&x->r, 0, TFA_JOINT_REVOLUTE, 0, 0, 1)->armature = armature;
    const double m = line_mass * length, inertia = m * length * length / 12;
    small_robot_load(&x->r, 1, m, 0, inertia, inertia);
    x->r.link[1].com[0] = length / 2;
    tfa_joint *end = small_robot_add(&x->r, 1, TFA_JOINT_FIXED, 1, 0, 0);
    end->xyz[0] = length;
    small_robot_load(&x->r, 2, load, 0, 0, 0);
    for (uint32_t k = 0; k < n; k++) {
        const double bL = root((int)k), b = bL / length, sign = k % 2 ? -1 : 1;
        const double s = (cosh(bL) + cos(bL)) / (sinh(bL) + sin(bL));
        x->momentum[6 * k + 1] = line_mass * 2 * s / b;
        x->momentum[6 * k + 5] = line_mass * 2 / (b * b);
        x->mass[k * n + k] = m;
        x->K[k * n + k] = stiffness * pow(b, 4) * length;
        x->shape[6 * k + 1] = 2 * sign;
        x->shape[6 * k + 5] = 2 * b * s * sign;
    }
    x->end = (tfa_mode_shape){end->name, x->shape};
    x->modes = (tfa_link_modes){.link = x->r.link[1].name,
                                .mode_count = n,
                                .momentum = x->momentum,
                                .mass = x->mass,
                                .stiffness = x->K,
                                .shapes = &x->end,
                                .shape_count = 1};
    x->scene = (tfa_scene){.modes = &x->modes, .modes_count = 1};
}

/* x <- A^-1 x, by elimination; A is changed. */
static void solve(double *A, uint32_t n, double *x)
{
    for (uint32_t k = 0; k < n; k++)
        for (uint32_t i = k + 1; i < n; i++) {
            const double l = A[i * n + k] / A[k * n + k];
            for (uint32_t j = k; j < n; j++)
                A[i * n + j] -= l * A[k * n + j];
            x[i] -= l * x[k];
        }
    for (uint32_t k = n; k-- > 0;) {
        for (uint32_t j = k + 1; j < n; j++)
            x[k] -= A[k * n + j] * x[j];
        x[k] /= A[k * n + k];
    }
}

/* Least eigenvalue of -A by inverse iteration; its vector in x */
static double least(const double *A, uint32_t n, double *x)
{
    double value = 0, *y = calloc(n, sizeof *y), *work = calloc((size_t)n * n, sizeof *work);
    for (uint32_t k = 0; k < n; k++)
        x[k] = 1;
    for (int round = 0; round < 60; round++) {
        double xy = 0, yy = 0;
        memcpy(y, x, n * sizeof *y);
        for (uint32_t k = 0; k < n * n; k++)
            work[k] = -A[k];
        solve(work, n, y);
        for (uint32_t k = 0; k < n; k++) {
            xy += x[k] * y[k];
            yy += y[k] * y[k];
        }
        value = xy / yy;
        for (uint32_t k = 0; k < n; k++)
            x[k] = y[k] / sqrt(yy);
    }
    free(work);
    free(y);
    return value;
}

static const double weightless[3];

/* Least frequency, times L^2 sqrt(rho A / EI), of the modes: accelerations of unit coordinates */
static double frequency(const beam *x)
{
    const tfa_model_options options = {.scene = &x->scene, .gravity = weightless};
    SCOPED_MODEL *model = compiled(&x->r.d, &options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    double A[MODES * MODES], column[MODES], eta[MODES], vector[MODES], q = 0.4, qdd;
    tfa_request r = request_fd(&q, NULL, NULL);
    r.modes = eta;
    for (uint32_t k = 0; k < x->n; k++) {
        const double unit = 1e-9; /* terms in eta itself are below rounding of the linear ones */
        memset(eta, 0, sizeof eta);
        eta[k] = unit;
        tfa_reply reply = {.qdd = &qdd, .modes = column};
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        for (uint32_t i = 0; i < x->n; i++)
            A[i * x->n + k] = column[i] / unit;
    }
    return sqrt(least(A, x->n, vector)) * length * length * sqrt(line_mass / stiffness);
}

TEST(frequencies_of_a_beam)
{
    static const struct {
        const char *what;
        uint32_t modes;
        double armature, load, want, bound; /* load: of the mass of the beam */
    } rows[] = {
        {"clamped", 1, 1e12, 0, 3.516015, 1e-6},
        {"clamped", MODES, 1e12, 0, 3.516015, 1e-6},
        {"hinged", MODES, 0, 0, 15.41821, 2e-3}, /* modes of the wrong end converge slowly */
        {"clamped, load", MODES, 1e12, 1, 1.55730, 5e-4},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        beam x;
        make_beam(&x, rows[k].modes, rows[k].armature, rows[k].load * line_mass * length);
        const double got = frequency(&x), error = fabs(got / rows[k].want - 1);
        print_message("  %s, %u modes: %.6f, literature %.6f\n", rows[k].what,
                      (unsigned)rows[k].modes, got, rows[k].want);
        if (!(error <= rows[k].bound))
            fail_msg("%s: %.7f, literature %.7f", rows[k].what, got, rows[k].want);
    }
}

/* ---- pieces and springs ---- */

/* The beam in `n` rigid pieces, with springs between: half of one at the wall. */
static double frequency_of_pieces(uint32_t n)
{
    small_robot r;
    const double piece = length / n, m = line_mass * piece, inertia = m * piece * piece / 12;
    double A[SMALL_ROBOT_LINKS * SMALL_ROBOT_LINKS], q[SMALL_ROBOT_LINKS],
        vector[SMALL_ROBOT_LINKS];
    double tau[SMALL_ROBOT_LINKS], column[SMALL_ROBOT_LINKS];
    const tfa_model_options options = {.gravity = weightless};
    small_robot_begin(&r);
    for (uint32_t k = 0; k < n; k++) {
        small_robot_add(&r, k, TFA_JOINT_REVOLUTE, 0, 0, 1)->xyz[0] = k ? piece : 0;
        small_robot_load(&r, k + 1, m, 0, inertia, inertia);
        r.link[k + 1].com[0] = piece / 2;
    }
    SCOPED_MODEL *model = compiled(&r.d, &options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    for (uint32_t k = 0; k < n; k++) {
        memset(q, 0, sizeof q);
        memset(tau, 0, sizeof tau);
        tau[k] = -(k ? 1 : 2) * stiffness / piece;
        const tfa_request request = request_fd(q, NULL, tau);
        tfa_reply reply = {.qdd = column};
        assert_int_equal(tfa_compute(w, &request, &reply), TFA_OK);
        for (uint32_t i = 0; i < n; i++)
            A[i * n + k] = column[i];
    }
    return sqrt(least(A, n, vector)) * length * length * sqrt(line_mass / stiffness);
}

/* Half the pieces have four times the error. */
TEST(pieces_with_springs_converge_to_the_beam)
{
    beam x;
    make_beam(&x, MODES, 1e12, 0);
    const double want = frequency(&x), seven = frequency_of_pieces(7) - want;
    const double fourteen = frequency_of_pieces(14) - want;
    print_message("  7 pieces %.2g, 14 pieces %.2g\n", seven, fourteen);
    assert_true(fabs(fourteen) < 0.01 && fabs(seven / fourteen - 4) < 0.5);
}
