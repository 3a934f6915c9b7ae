/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues of small symmetric matrices: Householder's tridiagonalisation, then QL without square
 * roots (Pal, Walker and Kahan; Parlett, The Symmetric Eigenvalue Problem, 8.15; LAPACK's dsterf).
 * 2 n^3 operations, absolute error 2 n eps |A|.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "engine/methods.h"

#define N_MAX (6 * TFA_MAX_TIPS)
/* QL takes 1.5 to 2 sweeps for an eigenvalue; the limit is LAPACK's. */
#define SWEEPS_MAX 30
/* The largest entry is scaled to 1: a column with a smaller square does not change any digit. */
#define NEGLIGIBLE 1e-200
/* A block whose Frobenius norm is below n eps / 4, the largest entry of the matrix being 0.5 to 1,
 * is 0: half of it changes an eigenvalue less than QL does. */
#define REST 0.25

/* Two entries of a row; rows begin anywhere. */
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));

static double larger(double a, double b)
{
    return b > a ? b : a;
}

/* Copies the matrix, its largest entry scaled by a power of two to 0.5 .. 1. Two chains of
 * comparisons: one alone waits for itself.
 * @return whether every entry is finite */
static int scale(const double *matrix, uint32_t n, double *a, int *exponent)
{
    double even = 0, odd = fabs(matrix[n * n - 1]);
    pair nonfinite = {0, 0 * odd}; /* NaN as soon as an entry is not finite */
    for (uint32_t k = 0; k + 1 < n * n; k += 2) {
        even = larger(even, fabs(matrix[k]));
        odd = larger(odd, fabs(matrix[k + 1]));
        nonfinite += 0 * *(const pair *)(matrix + k);
    }
    (void)frexp(larger(even, odd), exponent);
    if (*exponent < DBL_MIN_EXP) /* the factor of denormal numbers is finite, too */
        *exponent = DBL_MIN_EXP;
    const double factor = ldexp(1, -*exponent);
    for (uint32_t k = 0; k + 1 < n * n; k += 2)
        *(pair *)(a + k) = factor * *(const pair *)(matrix + k);
    a[n * n - 1] = factor * matrix[n * n - 1];
    return nonfinite[0] + nonfinite[1] == 0;
}

/* w += A v for rows and columns first .. n - 1, an even number of them. Of A the upper triangle of
 * 2 x 2 blocks is read, as in update. */
static void multiply(const double *a, uint32_t n, uint32_t first, const double *v, double *w)
{
    for (uint32_t i = first; i < n; i += 2) {
        const double *const row = a + i * n;
        const double v0 = v[i], v1 = v[i + 1];
        pair sum0 = {0, 0}, sum1 = {0, 0};
        *(pair *)(w + i) += v0 * *(const pair *)(row + i) + v1 * *(const pair *)(row + n + i);
        for (uint32_t j = i + 2; j < n; j += 2) {
            const pair x = *(const pair *)(row + j), y = *(const pair *)(row + n + j);
            const pair z = *(const pair *)(v + j);
            *(pair *)(w + j) += v0 * x + v1 * y;
            sum0 += x * z;
            sum1 += y * z;
        }
        w[i] += sum0[0] + sum0[1];
        w[i + 1] += sum1[0] + sum1[1];
    }
}

/* A <- A - v w^T - w v^T there. */
static void update(double *a, uint32_t n, uint32_t first, const double *v, const double *w)
{
    for (uint32_t i = first; i < n; i += 2) {
        double *const row = a + i * n;
        const double v0 = v[i], w0 = w[i], v1 = v[i + 1], w1 = w[i + 1];
        for (uint32_t j = i; j < n; j += 2) {
            const pair x = *(const pair *)(v + j), y = *(const pair *)(w + j);
            *(pair *)(row + j) -= v0 * y + w0 * x;
            *(pair *)(row + n + j) -= v1 * y + w1 * x;
        }
    }
}

/* A <- H A H below and right of entry (k, k), H = I - v v^T / h, v in row k: A - v w^T - w v^T with
 * p = A v / h, w = p - (p . v / 2h) v. With v_k = w_k = 0 row and column k may be among them, so
 * that their number is even. */
static void reflect(double *a, uint32_t n, uint32_t k, double h)
{
    const uint32_t first = (n - k) % 2 ? k + 1 : k;
    double v[N_MAX], w[N_MAX], dot = 0;
    memcpy(v + first, a + k * n + first, (n - first) * sizeof *v);
    memset(w + first, 0, (n - first) * sizeof *w);
    v[k] = 0;
    multiply(a, n, first, v, w);
    w[k] = 0;
    for (uint32_t j = k + 1; j < n; j++)
        dot += w[j] * v[j];
    for (uint32_t j = k + 1; j < n; j++)
        w[j] = (w[j] - dot / (2 * h) * v[j]) / h;
    update(a, n, first, v, w);
}

/* Is the square of the Frobenius norm of rows and columns first .. n - 1 at most `square`? Ends at
 * the first row that exceeds it. */
static int is_rest(const double *a, uint32_t n, uint32_t first, double square)
{
    double sum = 0;
    for (uint32_t i = first; i < n && sum <= square; i++)
        for (uint32_t j = i; j < n; j++)
            sum += (j > i ? 2 : 1) * a[i * n + j] * a[i * n + j];
    return sum <= square;
}

/* Diagonal d and squares e of the subdiagonal of a tridiagonal matrix similar to A. A matrix of
 * rank r is done after r + 1 columns: the rest is rounding. */
static void tridiagonalise(double *a, uint32_t n, double *d, double *e)
{
    const double rounding = REST * n * DBL_EPSILON;
    for (uint32_t k = 0; k < n; k++) {
        double *const v = a + k * n;
        double square = 0;
        d[k] = v[k];
        e[k] = 0;
        if (is_rest(a, n, k, rounding * rounding)) {
            memset(d + k, 0, (n - k) * sizeof *d);
            memset(e + k, 0, (n - k) * sizeof *e);
            return;
        }
        for (uint32_t j = k + 1; j < n; j++)
            square += v[j] * v[j];
        e[k] = square < NEGLIGIBLE ? 0 : square;
        if (k + 2 >= n || e[k] == 0)
            continue;
        const double size = sqrt(square), first = v[k + 1];
        v[k + 1] += copysign(size, first);
        reflect(a, n, k, square + size * fabs(first));
    }
}

/* One sweep over the unreduced block l .. m; d[l] and e[l] converge. */
static void sweep(double *d, double *e, uint32_t l, uint32_t m)
{
    const double root = sqrt(e[l]), half = (d[l + 1] - d[l]) / (2 * root);
    const double shift = d[l] - root / (half + copysign(sqrt(half * half + 1), half));
    double c = 1, s = 0, gamma = d[m] - shift, p = gamma * gamma;
    for (uint32_t i = m; i-- > l;) {
        const double square = e[i], r = p + square, c_last = c, gamma_last = gamma;
        if (i + 1 != m)
            e[i + 1] = s * r;
        c = p / r;
        s = square / r;
        gamma = c * (d[i] - shift) - s * gamma_last;
        d[i + 1] = gamma_last + (d[i] - gamma);
        p = c != 0 ? gamma * gamma / c : c_last * square;
    }
    e[l] = s * p;
    d[l] = shift + gamma;
}

/* Eigenvalues, in no order, in d. An off-diagonal entry below 2 eps times the largest one is
 * rounding; at half of eps QL cycles now and then. @return sweeps; -1: no convergence */
static int diagonalise(double *d, double *e, uint32_t n)
{
    const int most = SWEEPS_MAX * (int)n;
    double largest = 0;
    int sweeps = 0;
    for (uint32_t k = 0; k < n; k++)
        largest = fmax(largest, fmax(d[k] * d[k], e[k]));
    const double tiny = 4 * DBL_EPSILON * DBL_EPSILON * largest;
    for (uint32_t l = 0; l < n; l++)
        for (;; sweeps++) {
            uint32_t m = l;
            while (m + 1 < n && !(e[m] <= tiny))
                m++;
            if (m == l)
                break;
            if (sweeps == most)
                return -1;
            sweep(d, e, l, m);
        }
    return sweeps;
}

int tfa_eigenvalues(const double *matrix, uint32_t n, double *value, double *scratch)
{
    double e[N_MAX];
    int exponent;
    if (!scale(matrix, n, scratch, &exponent))
        return -1;
    tridiagonalise(scratch, n, value, e);
    const int sweeps = diagonalise(value, e, n);
    for (uint32_t k = 0; k < n; k++)
        value[k] = ldexp(value[k], exponent);
    return sweeps;
}

tfa_spectrum tfa_spectrum_of(const double *matrix, uint32_t n, double *scratch)
{
    double value[N_MAX];
    if (tfa_eigenvalues(matrix, n, value, scratch) < 0)
        return (tfa_spectrum){0, 0, (double)NAN, (double)NAN};
    tfa_spectrum out = {0, 0, value[0], value[0]};
    for (uint32_t k = 1; k < n; k++) {
        out.eig_min = fmin(out.eig_min, value[k]);
        out.eig_max = fmax(out.eig_max, value[k]);
    }
    for (uint32_t k = 0; k < n; k++)
        out.rank += value[k] > n * 64 * DBL_EPSILON * out.eig_max;
    return out;
}
