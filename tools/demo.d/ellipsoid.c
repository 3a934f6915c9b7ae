/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot as a stick figure with the ellipsoid of Lambda^-1 at a link: the accelerations of the
 * link's origin by all forces of 1 N there, in an orthographic projection. Its half axes are the
 * eigenvalues of the linear 3 x 3 block, in 1/kg.
 *
 *     demo_ellipsoid URDF LINK AZIMUTH ELEVATION SCALE Q...
 *
 * Angles of the view in degrees, SCALE in m for 1/kg, Q the coordinates of a posture, "q1,q2,...".
 * Prints for gnuplot, for each posture: the bones, the outline, the three axes, each as lines "x y"
 * with two empty lines behind; and "# mass LEAST LARGEST" in kg.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>
#include <totalforce/totalforce.h>

#include "spatial/symmetric3.h"

enum { JOINTS_MAX = 64, OUTLINE = 72 };

#define DEGREE (M_PI / 180.0)

typedef struct figure {
    tfa_description *description;
    tfa_model *model;
    tfa_workspace *workspace;
    double *poses; /* 7 numbers for each frame */
    uint32_t tip;
    double right[3], up[3]; /* of the picture, in the world */
    double scale;
} figure;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void print_point(const figure *f, const double p[3])
{
    printf("%.5f %.5f\n", dot(f->right, p), dot(f->up, p));
}

static void print_bones(const figure *f)
{
    const tfa_description *d = f->description;
    for (size_t j = 0; j < d->joint_count; j++) {
        const int32_t a = tfa_model_find_frame(f->model, d->links[d->joints[j].parent].name);
        const int32_t b = tfa_model_find_frame(f->model, d->links[d->joints[j].child].name);
        if (a < 0 || b < 0)
            continue;
        print_point(f, f->poses + 7 * (size_t)a);
        print_point(f, f->poses + 7 * (size_t)b);
        fputs("\n", stdout);
    }
    fputs("\n", stdout);
}

/* The outline of the projected ellipsoid {A u : |u| = 1}, drawn about `at`: {P A u}, an ellipse */
static void print_outline(const figure *f, const double A[3][3], const double at[3])
{
    double x[3], y[3]; /* rows of P A */
    for (int i = 0; i < 3; i++) {
        const double column[3] = {A[0][i], A[1][i], A[2][i]};
        x[i] = dot(f->right, column);
        y[i] = dot(f->up, column);
    }
    /* Cholesky factor of (P A) (P A)^T */
    const double a = sqrt(dot(x, x)), b = dot(x, y) / a, c = sqrt(fmax(0.0, dot(y, y) - b * b));
    for (int k = 0; k <= OUTLINE; k++) {
        const double s = sin(2.0 * M_PI * k / OUTLINE), t = cos(2.0 * M_PI * k / OUTLINE);
        printf("%.5f %.5f\n", dot(f->right, at) + f->scale * a * t,
               dot(f->up, at) + f->scale * (b * t + c * s));
    }
    fputs("\n\n", stdout);
}

static void print_axes(const figure *f, const double A[3][3], const double at[3])
{
    long double D[3][3], V[3][3];
    for (int i = 0; i < 9; i++)
        D[i / 3][i % 3] = A[i / 3][i % 3];
    symmetric3_diagonalise(D, V);
    double least = INFINITY, largest = 0.0;
    for (int k = 0; k < 3; k++) {
        const double size = (double)D[k][k];
        double ends[2][3];
        for (int i = 0; i < 3; i++) {
            ends[0][i] = at[i] - f->scale * size * (double)V[i][k];
            ends[1][i] = at[i] + f->scale * size * (double)V[i][k];
        }
        print_point(f, ends[0]);
        print_point(f, ends[1]);
        fputs("\n", stdout);
        least = fmin(least, 1.0 / size);
        largest = fmax(largest, 1.0 / size);
    }
    printf("\n# mass %.3g %.3g\n", least, largest);
}

static int print_posture(const figure *f, const double *q)
{
    double lambda_inv[36], A[3][3];
    tfa_answer answer;
    const tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                 .count = 1,
                                 .flags = TFA_WANT_FRAME_POSES,
                                 .tip_count = 1,
                                 .tips = {f->tip},
                                 .q = q};
    tfa_reply reply = {.lambda_inv = lambda_inv, .frame_poses = f->poses, .answers = &answer};
    const int status = tfa_compute(f->workspace, &request, &reply);
    if (status != TFA_OK)
        return status;
    for (int i = 0; i < 9; i++)
        A[i / 3][i % 3] = lambda_inv[6 * (i / 3) + i % 3];
    const double *at = f->poses + 7 * (size_t)f->tip;
    print_bones(f);
    print_outline(f, (const double(*)[3])A, at);
    print_axes(f, (const double(*)[3])A, at);
    return TFA_OK;
}

static int read_number(const char *text, size_t length, double *number)
{
    return tfa_number_read(text, length, number) == TFA_NUMBER_OK ? TFA_OK : TFA_E_VALUE;
}

/* "q1,q2,..." */
static int read_posture(const figure *f, const char *text, double *q)
{
    const uint32_t count = tfa_model_q_count(f->model);
    if (count > JOINTS_MAX)
        return TFA_E_SIZE;
    for (uint32_t k = 0; k < count; k++) {
        const size_t length = strcspn(text, ",");
        if (read_number(text, length, &q[k]) != TFA_OK || (text[length] == ',') != (k + 1 < count))
            return TFA_E_VALUE;
        text += length + 1;
    }
    return TFA_OK;
}

static int open_figure(figure *f, char **argv)
{
    double angles[2];
    tfa_report report = {0};
    for (int i = 0; i < 2; i++)
        if (read_number(argv[3 + i], strlen(argv[3 + i]), &angles[i]) != TFA_OK)
            return TFA_E_VALUE;
    if (read_number(argv[5], strlen(argv[5]), &f->scale) != TFA_OK)
        return TFA_E_VALUE;
    const double a = DEGREE * angles[0], e = DEGREE * angles[1];
    const double right[3] = {-sin(a), cos(a), 0.0};
    const double up[3] = {-cos(a) * sin(e), -sin(a) * sin(e), cos(e)};
    memcpy(f->right, right, sizeof right);
    memcpy(f->up, up, sizeof up);
    int status = tfa_urdf_load(argv[1], &f->description, &report);
    tfa_report_free(&report);
    if (status == TFA_OK)
        status = tfa_model_create(f->description, NULL, NULL, &f->model);
    if (status == TFA_OK)
        status = tfa_workspace_create(f->model, NULL, &f->workspace);
    if (status != TFA_OK)
        return status;
    const int32_t tip = tfa_model_find_frame(f->model, argv[2]);
    f->tip = (uint32_t)tip;
    f->poses = calloc(7 * (size_t)tfa_model_frame_count(f->model), sizeof *f->poses);
    return tip < 0 ? TFA_E_LINK : f->poses ? TFA_OK : TFA_E_MEMORY;
}

int main(int argc, char **argv)
{
    figure f = {0};
    double q[JOINTS_MAX];
    if (argc < 7) {
        fprintf(stderr, "usage: demo_ellipsoid URDF LINK AZIMUTH ELEVATION SCALE Q...\n");
        return 3;
    }
    int status = open_figure(&f, argv);
    for (int k = 6; status == TFA_OK && k < argc; k++) {
        status = read_posture(&f, argv[k], q);
        if (status == TFA_OK)
            status = print_posture(&f, q);
    }
    if (status != TFA_OK)
        fprintf(stderr, "demo: %s\n", tfa_status_text(status));
    free(f.poses);
    tfa_workspace_free(f.workspace);
    tfa_model_free(f.model);
    tfa_description_free(f.description);
    return status == TFA_OK && fflush(stdout) == 0 && !ferror(stdout) ? 0 : 2;
}
