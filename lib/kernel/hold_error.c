/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What held joints cost in accuracy, and which of them can be held.
 *
 * With y the answer and lag = M y + h - tau the forces that hold the joints, the error of y in the
 * energy norm is lag^T M^-1 lag (Gauss' principle): an inward pass over lag, the joints free.
 *
 * Which joints to let go of is decided by a bound that needs no factors. A joint force lag_i is a
 * couple n_i on body i and -X^T n_i on its parent with H_i^T n_i = lag_i. If g_i is the sum of the
 * couples on body i, then lag^T qd = sum g_i^T v_i and qd^T M qd >= sum v_i^T I_i v_i, so that
 *   lag^T M^-1 lag <= sum g_i^T I_i^-1 g_i.
 * It is far above the truth (13 to 2400 times on chains), but it ranks the joints.
 */
#include <math.h>

#include "kernel/body.h"
#include "kernel/hold.h"
#include "kernel/kernel.h"

/* The pass that certifies has rounding of its own, and the answer has, too: a certificate is made
 * larger by a thousandth, and by so much of |x|_M + |M^-1 tau|_M for every body. The worst that was
 * seen is 9 units of |x|_M where the torques all but cancel (10 bodies, seed 3594 of
 * test_reductions_hold), 1 on the planar chain of 512 bodies (bench_hold), 2026-11-21. */
#define MARGIN 1.001
#define ROUNDING (64 * ANSWER_EPSILON)

/* A round lets go of as many joints as move already, divided by this, and of one more at least.
 * Slower growth finds smaller sets in more rounds: for 10 % on the 3-D chain of 512 bodies 1 left
 * 182 joints free, 4 left 100 (bench_hold, 2026-11-21). */
#define GROWTH 4
/* Scores by powers of two below the largest; what lies below the last is put into it. */
#define BUCKETS 128

static num dot(const num *a, const num *b, uint32_t n)
{
    num sum = 0;
    for (uint32_t j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* lag = M qdd + h - tau.  Returns qdd^T M qdd. */
static num find_lag(struct state *s)
{
    const uint32_t n = s->m->freedoms;
    TFA_V(rnea)(s, s->qdd, s->res, 0);
    const num energy = dot(s->qdd, s->res, n);
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < n; j++)
        s->lag[j] = s->res[j] - s->tau[j];
    return energy;
}

static uint32_t count_held(const struct state *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const uint32_t joints = b->n == 1 || b->kind == TFA_KIND_FUSED ? b->n : 1;
        for (uint32_t k = 0; k < joints; k++)
            count += (s->stop[b->v + k] & STOP_HELD) != 0;
    }
    return count;
}

/* error and error over |x|_M, where |x|_M^2 = |y|_M^2 + error^2. x is the difference of M^-1 tau and
 * M^-1 h, whose rounding counts where they all but cancel; |M^-1 tau|_M^2 = tau^T M^-1 tau. */
static tfa_certificate certify(const struct state *s, num error2, num energy, num tau2)
{
    const double e = sqrt((double)error2), size = sqrt((double)(energy + error2));
    const double error = MARGIN * e + ROUNDING * s->m->bodies * (size + sqrt((double)tau2));
    return (tfa_certificate){
        .error = error, .relative = size > 0 ? error / size : 0, .held = count_held(s), .exact = 1};
}

static num energy_of(struct state *s, const num *forces)
{
    return s->holding ? TFA_V(hold_energy)(s, forces) : TFA_V(aba_energy)(s, forces);
}

tfa_certificate TFA_V(hold_certificate)(struct state *s)
{
    const num energy = find_lag(s);
    TFA_V(hold_plan)(s, STOP_LOCKED, 0); /* the held joints free, the locked ones locked */
    s->have &= ~(uint32_t)HAVE_HELD;
    (void)TFA_V(factor)(s, TFA_METHOD_ABA);
    const num error2 = energy_of(s, s->lag), tau2 = energy_of(s, s->tau);
    TFA_V(hold_plan)(s, STOP_LOCKED | STOP_HELD, 0);
    s->have &= ~(uint32_t)HAVE_HELD;
    return certify(s, error2, energy > 0 ? energy : 0, tau2);
}

/* ---- auto ---- */

static inline num quadratic(const sym6 *S, svec f)
{
    return sv_dot(f, s6_mul(S, f));
}

/* Joints with one freedom that are not locked can be held. */
static inline int candidate(const struct state *s, const struct tfa_body *b)
{
    return b->n == 1 && !(s->stop[b->v] & STOP_LOCKED);
}

static inline int held(const struct state *s, const struct tfa_body *b)
{
    return b->n == 1 && s->stop[b->v] & STOP_HELD;
}

static uint32_t hold_all(struct state *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        if (!candidate(s, b))
            continue;
        s->stop[b->v] |= STOP_HELD;
        count++;
    }
    s->stopped |= count ? STOP_HELD : 0;
    return count;
}

/* What the holding force of joint i alone adds to the bound. An inertia without inverse resists
 * nothing: infinite. */
static double score(const struct state *s, const struct tfa_body *b, uint32_t i)
{
    if (s->lag[b->v] == 0)
        return 0;
    svec n = sv_zero();
    sv_put(&n, body_axis(b), s->lag[b->v]);
    if (!(s->Iinv[i].A.xx > 0))
        return INFINITY;
    num sum = quadratic(&s->Iinv[i], n);
    if (b->parent < 0)
        return (double)sum;
    if (!(s->Iinv[b->parent].A.xx > 0))
        return INFINITY;
    return (double)(sum + quadratic(&s->Iinv[b->parent], x_t_force(&s->X[i], n)));
}

static void rank(struct state *s)
{
    for (uint32_t i = 0; i < s->m->bodies; i++)
        if (held(s, &s->body[i]))
            s->score[i] = score(s, &s->body[i], i);
}

/* The exponent above which joints are let go of, so that they are at least `few`. */
static int threshold(const struct state *s, uint32_t few)
{
    uint32_t count[BUCKETS] = {0}, sum = 0;
    double largest = 0;
    for (uint32_t i = 0; i < s->m->bodies; i++)
        if (held(s, &s->body[i]) && s->score[i] > largest && isfinite(s->score[i]))
            largest = s->score[i];
    const int top = largest > 0 ? ilogb(largest) : 0;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        if (!held(s, &s->body[i]) || !(s->score[i] > 0))
            continue;
        const int k = isfinite(s->score[i]) ? top - ilogb(s->score[i]) : 0;
        count[k < BUCKETS ? k : BUCKETS - 1]++;
    }
    int k = 0;
    while (k < BUCKETS && (sum += count[k]) < few)
        k++;
    return top - k - 1;
}

/* Lets go of the joints whose score is above the threshold, or of all. Returns how many. */
static uint32_t let_go(struct state *s, int exponent, int all)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        if (!held(s, b))
            continue;
        if (!all && (s->score[i] == 0 || (isfinite(s->score[i]) && ilogb(s->score[i]) <= exponent)))
            continue;
        s->stop[b->v] &= (uint8_t)~STOP_HELD;
        count++;
    }
    return count;
}

static void solve_held(struct state *s)
{
    s->have &= ~(uint32_t)(HAVE_HELD | HAVE_ABA);
    TFA_V(hold_plan)(s, STOP_LOCKED | STOP_HELD, 0);
    if (s->holding)
        TFA_V(hold)(s, s->tau, s->qdd);
    else
        TFA_V(aba)(s, s->tau, s->qdd);
}

tfa_certificate TFA_V(hold_auto)(struct state *s, double tolerance)
{
    const uint32_t all = hold_all(s);
    uint32_t held_now = all;
    for (;;) {
        solve_held(s);
        const tfa_certificate c = TFA_V(hold_certificate)(s);
        if (held_now == 0 || c.relative <= tolerance)
            return c;
        rank(s);
        /* a round that finds nothing to let go of (no force is left to see) lets go of all */
        const uint32_t few = 1 + (all - held_now) / GROWTH;
        uint32_t gone = few >= held_now ? 0 : let_go(s, threshold(s, few), 0);
        if (gone == 0)
            gone = let_go(s, 0, 1);
        held_now -= gone;
        if (held_now == 0)
            s->stopped &= ~(uint32_t)STOP_HELD;
    }
}
