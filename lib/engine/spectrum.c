/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rank and extreme eigenvalues of small symmetric matrices: Householder's tridiagonalisation (Golub
 * and Van Loan, Matrix Computations, 8.3.1), then multisection by Sturm counts (Parlett, The
 * Symmetric Eigenvalue Problem, 3.3; Lo, Philippe and Sameh, 1987; LAPACK's dstebz). 4/3 n^3
 * operations, fewer where the rank is low; absolute error 2 n eps |A|. It cannot fail to converge.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "engine/methods.h"

#define N_MAX (6 * TFA_MAX_TIPS)
/* Pivots of as many numbers at once take the time of one division after the other. */
#define SHIFTS 8
/* Each leaves a fifth of an interval of at most 6 |A|: 1.1 eps |A| in the end. */
#define ROUNDS 23
/* The largest entry is scaled to 1: a column with a smaller square does not change any digit. */
#define NEGLIGIBLE 1e-200
/* A block whose Frobenius norm is below n eps / 4, the largest entry of the matrix being 0.5 to 1,
 * is 0: it changes no eigenvalue by more. */
#define REST 0.25

/* Two entries of a row; rows begin anywhere. */
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
typedef int64_t pair_mask __attribute__((vector_size(16)));

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

/* Diagonal d and squares e > 0 of the subdiagonal of a tridiagonal matrix similar to A. A matrix of
 * rank r is done after r + 1 columns: the rest is rounding.
 * @return its size; A's other eigenvalues are 0, and so is its last entry: they are in the range
 * of its own */
static uint32_t tridiagonalise(double *a, uint32_t n, double *d, double *e)
{
    const double rounding = REST * n * DBL_EPSILON;
    for (uint32_t k = 0; k < n; k++) {
        double *const v = a + k * n;
        double square = 0;
        if (is_rest(a, n, k, rounding * rounding)) {
            d[k] = 0; /* e[k - 1] couples with it */
            return k > 0 ? k + 1 : 0;
        }
        d[k] = v[k] + 0.0; /* -0 becomes 0 */
        for (uint32_t j = k + 1; j < n; j++)
            square += v[j] * v[j];
        e[k] = larger(square, NEGLIGIBLE);
        if (k + 2 >= n || square < NEGLIGIBLE)
            continue;
        const double size = sqrt(square), first = v[k + 1];
        v[k + 1] += copysign(size, first);
        reflect(a, n, k, square + size * fabs(first));
    }
    return n;
}

/* Numbers of eigenvalues below SHIFTS numbers x: negative pivots of T - x (Sturm). A pivot 0 makes
 * the next one infinite, and no NaN: squares e are positive, and no pivot is -0. */
static void count_below(const double *d, const double *e, uint32_t n, const double *x,
                        uint32_t *count)
{
    const pair x0 = {x[0], x[1]}, x1 = {x[2], x[3]}, x2 = {x[4], x[5]}, x3 = {x[6], x[7]};
    pair q0 = d[0] - x0, q1 = d[0] - x1, q2 = d[0] - x2, q3 = d[0] - x3;
    pair_mask c0 = q0 < 0, c1 = q1 < 0, c2 = q2 < 0, c3 = q3 < 0; /* -1 for each */
    for (uint32_t i = 1; i < n; i++) {
        q0 = d[i] - x0 - e[i - 1] / q0;
        q1 = d[i] - x1 - e[i - 1] / q1;
        q2 = d[i] - x2 - e[i - 1] / q2;
        q3 = d[i] - x3 - e[i - 1] / q3;
        c0 += q0 < 0;
        c1 += q1 < 0;
        c2 += q2 < 0;
        c3 += q3 < 0;
    }
    for (uint32_t k = 0; k < 2; k++) {
        count[k] = (uint32_t)-c0[k];
        count[2 + k] = (uint32_t)-c1[k];
        count[4 + k] = (uint32_t)-c2[k];
        count[6 + k] = (uint32_t)-c3[k];
    }
}

/* An interval that holds an eigenvalue: at most `below` are below `low`, more are below
 * `high`. */
struct bracket {
    double low, high;
    uint32_t below;
};

/* Keeps a fifth of the interval; the four numbers of count[] belong to x[]. */
static void narrow(struct bracket *b, const double *x, const uint32_t *count)
{
    for (uint32_t k = 0; k < SHIFTS / 2; k++) {
        if (count[k] > b->below) {
            b->high = x[k];
            return;
        }
        b->low = x[k];
    }
}

/* Every eigenvalue is in [-bound, bound] (Gershgorin). */
static double bound_of(const double *d, const double *e, uint32_t n)
{
    double bound = 0, last = 0;
    for (uint32_t k = 0; k < n; k++) {
        const double next = k + 1 < n ? sqrt(e[k]) : 0;
        bound = larger(bound, last + fabs(d[k]) + next);
        last = next;
    }
    return bound;
}

/* The least and the largest eigenvalue by multisection, both intervals at once. */
static void extremes(const double *d, const double *e, uint32_t n, double *least, double *most)
{
    const double bound = bound_of(d, e, n);
    struct bracket end[2] = {{-bound, bound, 0}, {-bound, bound, n - 1}};
    for (int round = 0; round < ROUNDS; round++) {
        double x[SHIFTS];
        uint32_t count[SHIFTS];
        for (uint32_t k = 0; k < SHIFTS; k++) {
            const struct bracket *const b = &end[k / 4];
            x[k] = b->low + (b->high - b->low) * 0.2 * (1 + k % 4);
        }
        count_below(d, e, n, x, count);
        narrow(&end[0], x, count);
        narrow(&end[1], x + 4, count + 4);
    }
    *least = (end[0].low + end[0].high) / 2;
    *most = (end[1].low + end[1].high) / 2;
}

tfa_spectrum tfa_spectrum_of(const double *matrix, uint32_t n, double *scratch)
{
    double d[N_MAX], e[N_MAX], least = 0, most = 0, x[SHIFTS];
    uint32_t below[SHIFTS];
    int exponent;
    if (!scale(matrix, n, scratch, &exponent))
        return (tfa_spectrum){0, 0, (double)NAN, (double)NAN};
    const uint32_t size = tridiagonalise(scratch, n, d, e);
    if (size > 0)
        extremes(d, e, size, &least, &most);
    tfa_spectrum out = {0, 0, ldexp(least, exponent), ldexp(most, exponent)};
    if (most <= 0)
        return out;
    for (uint32_t k = 0; k < SHIFTS; k++)
        x[k] = n * 64 * DBL_EPSILON * most;
    count_below(d, e, size, x, below);
    out.rank = size - below[0];
    return out;
}
