/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Integrators of q'' = a(q, q') with a fixed step. The extrapolated midpoint rule: Hairer, Norsett,
 * Wanner, Solving Ordinary Differential Equations I, 1993, II.9, with 2, 4, 6, 8 substeps.
 */
#include "drift.h"

#include <string.h>

const char *const drift_integrator_words[DRIFT_INTEGRATOR_COUNT] = {
#define DRIFT_INTEGRATOR_WORD(name, word, what) word,
    DRIFT_INTEGRATOR_LIST(DRIFT_INTEGRATOR_WORD)
#undef DRIFT_INTEGRATOR_WORD
};

/* A state is q, then v: derivative of y into f */
static int derive(const drift_system *s, const double *y, double *f)
{
    memcpy(f, y + s->n, s->n * sizeof *f);
    return s->accelerate(s->context, y, y + s->n, f + s->n);
}

/* z = y + h f */
static void add(const drift_system *s, double *z, const double *y, double h, const double *f)
{
    for (uint32_t i = 0; i < 2 * s->n; i++)
        z[i] = y[i] + h * f[i];
}

static int euler(const drift_system *s, double h, double *y)
{
    double *q = y, *v = y + s->n, *a = s->scratch;
    const int status = s->accelerate(s->context, q, v, a);
    for (uint32_t i = 0; status == TFA_OK && i < s->n; i++) {
        v[i] += h * a[i];
        q[i] += h * v[i];
    }
    return status;
}

static int runge_kutta(const drift_system *s, double h, double *y)
{
    static const double after[] = {0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    const size_t width = 2 * (size_t)s->n;
    double *z = s->scratch, *f = z + width, *sum = f + width;
    int status = TFA_OK;
    memcpy(z, y, width * sizeof *z);
    memset(sum, 0, width * sizeof *sum);
    for (int k = 0; status == TFA_OK && k < 4; k++) {
        status = derive(s, z, f);
        add(s, sum, sum, weight[k], f);
        if (k < 3)
            add(s, z, y, after[k] * h, f);
    }
    if (status == TFA_OK)
        add(s, y, y, h / 6.0, sum);
    return status;
}

/* Change of y by n substeps of the midpoint rule, smoothed (Gragg), into `change`; f0 is the
 * derivative at y. */
static int midpoint(const drift_system *s, double h, int n, const double *y, const double *f0,
                    double *change, double *room)
{
    const size_t width = 2 * (size_t)s->n;
    double *before = room, *z = before + width, *f = z + width;
    const double sub = h / n;
    int status = TFA_OK;
    memcpy(before, y, width * sizeof *before);
    add(s, z, y, sub, f0);
    for (int m = 1; status == TFA_OK && m <= n; m++) {
        status = derive(s, z, f);
        if (m == n)
            break;
        for (size_t i = 0; i < width; i++) {
            const double next = before[i] + 2.0 * sub * f[i];
            before[i] = z[i];
            z[i] = next;
        }
    }
    for (size_t i = 0; i < width; i++)
        change[i] = 0.5 * ((z[i] - y[i]) + (before[i] - y[i]) + sub * f[i]);
    return status;
}

enum { ROWS = 4 };

/* Changes, not states, are extrapolated: their rounding is h times smaller. */
static int extrapolate(const drift_system *s, double h, double *y)
{
    const size_t width = 2 * (size_t)s->n;
    double *f0 = s->scratch, *room = f0 + width, *row[ROWS];
    for (int k = 0; k < ROWS; k++)
        row[k] = room + (3 + (size_t)k) * width;
    int status = derive(s, y, f0);
    for (int k = 0; status == TFA_OK && k < ROWS; k++) {
        status = midpoint(s, h, 2 * (k + 1), y, f0, row[k], room);
        for (int j = k - 1; j >= 0; j--) {
            const double ratio = (k + 1.0) / (j + 1.0);
            for (size_t i = 0; i < width; i++)
                row[j][i] = row[j + 1][i] + (row[j + 1][i] - row[j][i]) / (ratio * ratio - 1.0);
        }
    }
    if (status == TFA_OK)
        add(s, y, y, 1.0, row[0]);
    return status;
}

int drift_step(drift_integrator integrator, const drift_system *system, double h, double *q,
               double *v)
{
    drift_system s = *system;
    double *y = system->scratch;
    const size_t bytes = s.n * sizeof *y;
    s.scratch += 2 * (size_t)s.n;
    memcpy(y, q, bytes);
    memcpy(y + s.n, v, bytes);
    const int status = integrator == DRIFT_EULER ? euler(&s, h, y)
                       : integrator == DRIFT_RK4 ? runge_kutta(&s, h, y)
                                                 : extrapolate(&s, h, y);
    memcpy(q, y, bytes);
    memcpy(v, y + s.n, bytes);
    return status;
}
