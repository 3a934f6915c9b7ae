/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sines and cosines of one number type. Included by sincos.h, once for each, with its constants.
 */
typedef SINCOS_REAL SINCOS(sincos_vec) __attribute__((vector_size(SINCOS_BYTES)));
typedef SINCOS_BITS SINCOS(sincos_int) __attribute__((vector_size(SINCOS_BYTES)));

/* a b + c, not fused with TFA_EXACT. No compiler looks into it: sums that would cancel are not
 * reordered. */
static inline __attribute__((always_inline)) SINCOS(sincos_vec)
    SINCOS(sincos_sum)(SINCOS(sincos_vec) a, SINCOS(sincos_vec) b, SINCOS(sincos_vec) c)
{
#if defined SINCOS_FUSES && !defined TFA_EXACT
    return SINCOS(sincos_fused)(a, b, c);
#else
    c += a * b;
    __asm__("" : SINCOS_REGISTER(c));
    return c;
#endif
}

enum {
    SINCOS(SINCOS_LANES) = SINCOS_BYTES / sizeof(SINCOS_REAL),
    SINCOS(SINCOS_SINES) = sizeof(SINCOS_REAL) == 8 ? 6 : 3, /* coefficients of each */
};

/* Whole vectors, for instructions that take them from memory. Their places: SINCOS(sincos_of). */
#define EACH(number)                                                                               \
    {                                                                                              \
        [0 ... SINCOS(SINCOS_LANES) - 1] = (SINCOS_REAL)(number)                                   \
    }
#define PARTS(a, b, c) EACH(-a), EACH(-b), EACH(b), EACH(c)
__extension__ static const SINCOS_REAL SINCOS(sincos_constants)[][SINCOS(SINCOS_LANES)]
    __attribute__((aligned(SINCOS_BYTES))) = {
        EACH(0x1.45f306dc9c883p-1), EACH(SINCOS_ROUND), EACH(-0.5),         EACH(1),
        SINCOS_PIO2(PARTS),         SINCOS_SINE(EACH),  SINCOS_COSINE(EACH)};
#undef EACH
#undef PARTS

/* x = n pi/2 + r - low, |r| <= pi/4; *squares += x x. A zero keeps its sign: r less a zero does. */
static inline __attribute__((always_inline)) void SINCOS(sincos_of)(SINCOS(sincos_vec) x,
                                                                    SINCOS(sincos_vec) * s,
                                                                    SINCOS(sincos_vec) * c,
                                                                    SINCOS(sincos_vec) * squares)
{
    typedef SINCOS(sincos_vec) vec;
    typedef SINCOS(sincos_int) bits;
    enum { INVERSE, ROUND, MINUS_HALF, ONE, MINUS_PART, PART = 6, SINE = 8 };
    enum { COSINE = SINE + SINCOS(SINCOS_SINES), END = COSINE + SINCOS(SINCOS_SINES) };
    const int top = 8 * sizeof(SINCOS_REAL) - 1;
    /* Hidden: gcc 12 would fill a register with each before a loop, and save it on the stack. */
    const vec *of = (const vec *)SINCOS(sincos_constants);
    __asm__("" : "+r"(of));
#define SUM SINCOS(sincos_sum)
    const vec k = SUM(x, of[INVERSE], of[ROUND]), n = k - of[ROUND];
    const vec first = SUM(n, of[MINUS_PART], x), r = SUM(n, of[MINUS_PART + 1], first);
    const vec low = SUM(n, of[PART + 1], SUM(n, of[PART], r - first));
    const vec z = r * r, w = SUM(z, of[MINUS_HALF], of[ONE]);
    vec p = of[SINE], q = of[COSINE];
    for (int e = SINE + 1; e < COSINE; e++)
        p = SUM(p, z, of[e]);
    for (int e = COSINE + 1; e < END; e++)
        q = SUM(q, z, of[e]);
    const vec sine = r - SUM(r * z, p, low);
    const vec cosine = w + SUM(z * z, q, SUM(r, low, SUM(z, of[MINUS_HALF], of[ONE] - w)));
#undef SUM
    /* The lowest bits of k are those of n: odd, and negative */
    const bits is_odd = -((bits)k & 1), sign = ((bits)k << (top - 1)) & SINCOS_SIGN;
    const bits swapped = ((bits)sine ^ (bits)cosine) & is_odd;
    *s = (vec)((bits)sine ^ swapped ^ sign);
    *c = (vec)((bits)cosine ^ swapped ^ ((bits)k << top) ^ sign);
    *squares = SINCOS(sincos_sum)(x, x, *squares);
}

static __attribute__((noinline, cold, unused)) void
SINCOS(sincos_large)(const SINCOS_REAL *x, SINCOS_REAL *s, SINCOS_REAL *c, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (x[k] > SINCOS_LIMIT || x[k] < -SINCOS_LIMIT)
            SINCOS_LIBM(x[k], &s[k], &c[k]);
}

/* x[0] .. x[count - 1], at most a vector, and zeros */
static inline __attribute__((always_inline)) SINCOS(sincos_vec)
    SINCOS(sincos_load)(const SINCOS_REAL *x, size_t count)
{
    SINCOS(sincos_vec) v = {0};
    if (count >= SINCOS(SINCOS_LANES))
        memcpy(&v, x, sizeof v);
    else
#pragma GCC unroll 16
        for (size_t l = 0; l < SINCOS(SINCOS_LANES); l++)
            if (l < count)
                v[l] = x[l];
    return v;
}

/* Of x[0] .. x[count - 1], no others are read, of which the last vector may take some again; of
 * less than a vector a whole one is written. */
static inline __attribute__((always_inline)) void
SINCOS(sincos_unpadded)(const SINCOS_REAL *x, SINCOS_REAL *s, SINCOS_REAL *c, size_t count)
{
    const size_t lanes = SINCOS(SINCOS_LANES), last = count < lanes ? 0 : count - lanes;
    SINCOS(sincos_vec) squares = {0}, sine, cosine;
    for (size_t k = 0; k < count; k += lanes) {
        const size_t from = k < last ? k : last;
        SINCOS(sincos_of)(SINCOS(sincos_load)(x + from, count), &sine, &cosine, &squares);
        memcpy(s + from, &sine, sizeof sine);
        memcpy(c + from, &cosine, sizeof cosine);
    }
    const SINCOS(sincos_vec) most = (SINCOS(sincos_vec)){0} + SINCOS_LIMIT * SINCOS_LIMIT;
    if (__builtin_expect(SINCOS(sincos_signs)(~(squares <= most)) != 0, 0))
        SINCOS(sincos_large)(x, s, c, count);
}

/* Of x[first] .. x[end - 1]; whole vectors are read and written, from that of `first` on. */
static inline void SINCOS(sincos)(const SINCOS_REAL *x, SINCOS_REAL *s, SINCOS_REAL *c,
                                  size_t first, size_t end)
{
    const size_t lanes = SINCOS(SINCOS_LANES), from = first / lanes * lanes;
    const size_t count = (end - from + lanes - 1) / lanes * lanes;
    if (count >= lanes)
        SINCOS(sincos_unpadded)(x + from, s + from, c + from, count);
}

#undef SINCOS
#undef SINCOS_REAL
#undef SINCOS_BITS
#undef SINCOS_SIGN
#undef SINCOS_LIBM
#undef SINCOS_LIMIT
#undef SINCOS_ROUND
#undef SINCOS_PIO2
#undef SINCOS_SINE
#undef SINCOS_COSINE
