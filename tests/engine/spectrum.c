/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues of small symmetric matrices: matrices of known spectrum, Jacobi's rotations in long
 * double as the reference.
 */
#include "engine/methods.h"
#include "test.h"

#include <float.h>

#define N_MAX (6 * TFA_DEFAULT_TIPS)
#define N_LARGEST (6 * TFA_MAX_TIPS)
#define ENTRIES (N_LARGEST * N_LARGEST)

static uint64_t seed = 1;

/* Uniform in [-1, 1) */
static double chance(void)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(int64_t)seed * 0x1p-63;
}

/* a <- H a H, H = I - 2 u u^T / u^T u */
static void reflect(long double *a, uint32_t n, const long double *u)
{
    long double size = 0;
    for (uint32_t k = 0; k < n; k++)
        size += u[k] * u[k];
    for (uint32_t side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t row = side ? 1 : n, step = side ? n : 1;
            long double dot = 0;
            for (uint32_t k = 0; k < n; k++)
                dot += u[k] * a[i * step + k * row];
            for (uint32_t k = 0; k < n; k++)
                a[i * step + k * row] -= 2 * u[k] * dot / size;
        }
}

/* A random orthogonal similarity of diag(value), rounded to double at last. */
static void make(double *out, uint32_t n, const double *value)
{
    static long double a[ENTRIES];
    memset(a, 0, sizeof a);
    for (uint32_t k = 0; k < n; k++)
        a[k * n + k] = value[k];
    for (uint32_t times = 0; n > 1 && times < n; times++) {
        long double u[N_LARGEST];
        for (uint32_t k = 0; k < n; k++)
            u[k] = chance();
        reflect(a, n, u);
    }
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++)
            out[i * n + j] = (double)((a[i * n + j] + a[j * n + i]) / 2);
}

static void rotate(long double *a, uint32_t n, uint32_t p, uint32_t q)
{
    if (a[p * n + q] == 0)
        return;
    const long double theta = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
    const long double t = copysignl(1, theta) / (fabsl(theta) + hypotl(theta, 1));
    const long double c = 1 / sqrtl(t * t + 1), s = t * c;
    for (uint32_t side = 0; side < 2; side++)
        for (uint32_t k = 0; k < n; k++) {
            long double *x = side ? &a[p * n + k] : &a[k * n + p];
            long double *y = side ? &a[q * n + k] : &a[k * n + q];
            const long double was = *x;
            *x = c * was - s * *y;
            *y = s * was + c * *y;
        }
    a[p * n + q] = a[q * n + p] = 0;
}

/* The same by Jacobi's rotations in long double. */
static tfa_spectrum jacobi(const double *matrix, uint32_t n)
{
    static long double a[ENTRIES];
    for (uint32_t k = 0; k < n * n; k++)
        a[k] = matrix[k];
    for (int sweep = 0; sweep < 16; sweep++)
        for (uint32_t p = 0; p + 1 < n; p++)
            for (uint32_t q = p + 1; q < n; q++)
                rotate(a, n, p, q);
    long double low = a[0], high = a[0];
    for (uint32_t k = 1; k < n; k++) {
        low = fminl(low, a[k * n + k]);
        high = fmaxl(high, a[k * n + k]);
    }
    tfa_spectrum out = {.eig_min = (double)low, .eig_max = (double)high};
    for (uint32_t k = 0; k < n; k++)
        out.rank += a[k * n + k] > n * 64 * (long double)DBL_EPSILON * high;
    return out;
}

static void check(const double *matrix, uint32_t n)
{
    static double scratch[ENTRIES];
    const tfa_spectrum expected = jacobi(matrix, n);
    const tfa_spectrum got = tfa_spectrum_of(matrix, n, scratch);
    const double norm = fmax(fabs(expected.eig_min), fabs(expected.eig_max));
    const double allowed = 2 * n * fmax(DBL_EPSILON * norm, DBL_TRUE_MIN);
    if (!(fabs(got.eig_min - expected.eig_min) <= allowed) ||
        !(fabs(got.eig_max - expected.eig_max) <= allowed) || got.rank != expected.rank)
        fail_msg("n %u: rank %u, %.17g to %.17g instead of rank %u, %.17g to %.17g", n, got.rank,
                 got.eig_min, got.eig_max, expected.rank, expected.eig_min, expected.eig_max);
    assert_int_equal(got.padding, 0);
}

enum { RANDOM, GRADED, DEFICIENT, EQUAL, TWO, INDEFINITE, CLUSTERED, LOW, SHAPES };

static double eigenvalue(int shape, uint32_t k, uint32_t n)
{
    switch (shape) {
    case GRADED:
        return pow(10, -30.0 * k / n) * (1.5 + chance() / 4);
    case DEFICIENT:
        return k % 3 ? 0 : 1.5 + chance();
    case EQUAL:
        return 0.7;
    case TWO:
        return k < n / 2 ? 1 : 1e-9;
    case CLUSTERED: /* 1, 1 + 1e-14, 1 + 2e-14; 1e-6 repeated; 0 repeated */
        return k % 3 == 0 ? 1 + 1e-14 * (k % 9 / 3) : k % 3 == 1 ? 1e-6 : 0;
    case LOW: /* as Lambda^-1 of eight tips on an arm: the last ones lie above the threshold */
        return k < 7 ? pow(10, -1.5 * k) : 0;
    case INDEFINITE:
        return chance();
    default:
        return 1.1 + chance();
    }
}

/* Of every size and shape, and from the smallest to the largest numbers that a double holds. */
TEST(spectra_are_those_that_were_made)
{
    static const double scales[] = {1, 1e-3, 1e12, 1e-300, 1e-150, 1e150, 1e300};
    static double matrix[ENTRIES];
    double value[N_MAX];
    for (int shape = 0; shape < SHAPES; shape++)
        for (uint32_t n = 1; n <= N_MAX; n += n < 13 ? 1 : 7)
            for (size_t s = 0; s < sizeof scales / sizeof *scales; s++) {
                for (uint32_t k = 0; k < n; k++)
                    value[k] = scales[s] * eigenvalue(shape, k, n);
                make(matrix, n, value);
                check(matrix, n);
            }
}

TEST(the_largest_matrices)
{
    static const uint32_t sizes[] = {96, 192, 95, 191};
    static double matrix[ENTRIES];
    double value[N_LARGEST];
    for (int shape = 0; shape < SHAPES; shape++)
        for (size_t i = 0; i < test_extent(shape ? 1 : 2, 4); i++) {
            for (uint32_t k = 0; k < sizes[i]; k++)
                value[k] = eigenvalue(shape, k, sizes[i]);
            make(matrix, sizes[i], value);
            check(matrix, sizes[i]);
        }
}

/* Zero, diagonal, with a single pair, already tridiagonal, of denormal numbers */
TEST(special_matrices)
{
    static double matrix[ENTRIES];
    for (uint32_t n = 1; n <= N_MAX; n += n < 7 ? 1 : 41) {
        memset(matrix, 0, sizeof matrix);
        check(matrix, n);
        for (uint32_t k = 0; k < n; k++)
            matrix[k * n + k] = k % 4 ? chance() : 0;
        check(matrix, n);
        for (uint32_t k = 1; k < n; k++)
            matrix[k * n + k - 1] = matrix[(k - 1) * n + k] = 1;
        check(matrix, n);
        memset(matrix, 0, sizeof matrix);
        matrix[(n - 1) * n] = matrix[n - 1] = -3;
        check(matrix, n);
        for (uint32_t k = 0; k < n * n; k++)
            matrix[k] = 1;
        check(matrix, n);
        for (uint32_t k = 0; k < n * n; k++)
            matrix[k] = 5e-310;
        check(matrix, n);
        for (uint32_t k = 0; k < n * n; k++)
            matrix[k] = 0;
        for (uint32_t k = 0; k < n; k++)
            matrix[k * n + k] = ldexp(1, -20 * (int)k);
        check(matrix, n);
    }
}

/* Decoupled blocks, each of its own size: a column without entries below the diagonal */
TEST(blocks)
{
    static double matrix[ENTRIES], block[ENTRIES];
    double value[N_MAX];
    for (uint32_t size = 1; size < 18; size++) {
        memset(matrix, 0, sizeof matrix);
        for (uint32_t first = 0; first + size <= N_MAX; first += size) {
            for (uint32_t k = 0; k < size; k++)
                value[k] = pow(10, -4 * chance()) * (k % 5 ? 1 : 0);
            make(block, size, value);
            for (uint32_t i = 0; i < size; i++)
                for (uint32_t j = 0; j < size; j++)
                    matrix[(first + i) * N_MAX + first + j] = block[i * size + j];
        }
        check(matrix, N_MAX);
    }
}

/* Already tridiagonal; -0 on the diagonal gives pivots of -0. */
TEST(tridiagonal_matrices)
{
    static double matrix[ENTRIES];
    for (uint32_t n = 1; n <= N_MAX; n++)
        for (int zero = 0; zero < 3; zero++) {
            memset(matrix, 0, sizeof matrix);
            for (uint32_t k = 0; k < n; k++)
                matrix[k * n + k] = zero ? -0.0 : 3 + chance();
            for (uint32_t k = 1; k < n && zero < 2; k++)
                matrix[k * n + k - 1] = matrix[(k - 1) * n + k] = k % 7 ? chance() : 0;
            check(matrix, n);
        }
}

TEST(no_number_is_said_of_large_matrices)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    static double matrix[ENTRIES], scratch[ENTRIES];
    for (uint32_t n = N_MAX - 1; n <= N_MAX; n++)
        for (uint32_t k = 0; k < n * n; k++) {
            matrix[k] = bad[k % 3];
            const tfa_spectrum got = tfa_spectrum_of(matrix, n, scratch);
            matrix[k] = 0;
            if (got.rank != 0 || !isnan(got.eig_min) || !isnan(got.eig_max))
                fail_msg("n %u: entry %u is not finite", n, k);
        }
}

TEST(no_number_is_said)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    double matrix[36] = {0}, scratch[36];
    for (size_t k = 0; k < 3 * 36; k++) {
        matrix[k / 3] = bad[k % 3];
        const tfa_spectrum got = tfa_spectrum_of(matrix, 6, scratch);
        assert_int_equal(got.rank, 0);
        assert_true(isnan(got.eig_min) && isnan(got.eig_max));
        matrix[k / 3] = 0;
    }
}
