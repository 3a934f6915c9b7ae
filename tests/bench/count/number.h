/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: a double that counts what is done with it and when that could be done at the
 * earliest. For tests and benchmarks only; the kernels are compiled as C++ for it.
 *
 * A value carries the time at which it is known: one more than that of the latest operand. The
 * latest time of all is the length of the longest dependency chain: the time on as many processors
 * as could be of use, when each operation takes one unit and moving numbers takes none.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#define NUM_EPSILON 0x1p-52
#define NUM_NO_VECTORS

/* C words that C++ lacks */
#define restrict __restrict__
#define _Static_assert static_assert

struct num_tally {
    uint64_t multiplications, additions, divisions, comparisons;
    /* of these, operations whose result was known before: x * 0, x * +-1, x + 0 */
    uint64_t idle;
    /* operations that can be done at time 1, 2, ...; [0] is not used */
    std::vector<uint64_t> level;
};

/* One thread only. */
inline num_tally num_counts;
inline uint32_t num_epoch; /* values known at this time or before are given */

class num;

/* Result of a comparison, used by num_select; plain branches follow it without waiting. */
struct num_outcome {
    bool is;
    uint32_t time;
    num_outcome(bool value, uint32_t known = 0) : is(value), time(known) {}
    operator bool() const
    {
        return is;
    }
};

class num
{
  public:
    num() = default; /* trivial: the kernels clear and copy memory */

    template <typename T, typename = std::enable_if_t<std::is_arithmetic<T>::value>>
    constexpr num(T x) : value(static_cast<double>(x)), time(0)
    {
    }

    num(double x, uint32_t when) : value(x), time(when) {}

    explicit operator double() const
    {
        return value;
    }

    /* The same value, known no earlier than that */
    num not_before(uint32_t when) const
    {
        return num(value, when > time ? when : time);
    }

    /* a sign costs nothing: it joins the operation that follows */
    num operator-() const
    {
        return num(-value, time);
    }

    /* Time since num_forget() */
    uint32_t age() const
    {
        return time > num_epoch ? time - num_epoch : 0;
    }

    bool is_zero() const
    {
        return value <= 0 && value >= 0;
    }

    bool is_unit() const
    {
        const double size = value < 0 ? -value : value;
        return is_zero() || (size <= 1 && size >= 1);
    }

  private:
    double value;
    uint32_t time;
};

static_assert(std::is_trivially_copyable<num>::value, "the kernels copy memory");

/* When the result of an operation on a and b is known, and one more operation of that time */
inline uint32_t num_step(num a, num b)
{
    const uint32_t x = a.age(), y = b.age(), done = (x > y ? x : y) + 1;
    if (done >= num_counts.level.size())
        num_counts.level.resize(2 * static_cast<size_t>(done) + 2);
    num_counts.level[done]++;
    return num_epoch + done;
}

/* An operation and its assignment; `is_idle`: the result was known before. */
#define NUM_OPERATION(op, tally, is_idle)                                                          \
    inline num operator op(num a, num b)                                                           \
    {                                                                                              \
        num_counts.tally++;                                                                        \
        num_counts.idle += (is_idle);                                                              \
        return num(static_cast<double>(a) op static_cast<double>(b), num_step(a, b));              \
    }                                                                                              \
    inline num &operator op##=(num &a, num b)                                                      \
    {                                                                                              \
        return a = a op b;                                                                         \
    }
NUM_OPERATION(*, multiplications, a.is_unit() || b.is_unit())
NUM_OPERATION(/, divisions, false)
NUM_OPERATION(+, additions, a.is_zero() || b.is_zero())
NUM_OPERATION(-, additions, a.is_zero() || b.is_zero())
#undef NUM_OPERATION

#define NUM_COMPARISON(op)                                                                         \
    inline num_outcome operator op(num a, num b)                                                   \
    {                                                                                              \
        num_counts.comparisons++;                                                                  \
        return num_outcome(static_cast<double>(a) op static_cast<double>(b), num_step(a, b));      \
    }
NUM_COMPARISON(<)
NUM_COMPARISON(>)
NUM_COMPARISON(<=)
NUM_COMPARISON(>=)
NUM_COMPARISON(==)
NUM_COMPARISON(!=)
#undef NUM_COMPARISON

/* A square root counts as a division: both take one unit, about as long. */
inline num num_sqrt(num a)
{
    num_counts.divisions++;
    return num(std::sqrt(static_cast<double>(a)), num_step(a, a));
}

/* Both values wait for the comparison. */
inline num num_choose(num_outcome m, num a, num b)
{
    return (m.is ? a : b).not_before(m.time);
}
#define num_select(m, a, b) num_choose((m), (a), (b))

/* Counts from zero; everything that is known now is given. */
inline void num_forget()
{
    std::vector<uint64_t> level;
    level.swap(num_counts.level);
    uint32_t latest = 0;
    for (size_t k = 0; k < level.size(); k++)
        if (level[k])
            latest = static_cast<uint32_t>(k);
    level.assign(level.size(), 0);
    num_epoch += latest;
    num_counts = num_tally{};
    num_counts.level.swap(level);
}

/* Sines are not counted. */
inline void num_sincos(num x, num *s, num *c)
{
    const double angle = static_cast<double>(x);
    *s = num(std::sin(angle)).not_before(num_epoch + x.age());
    *c = num(std::cos(angle)).not_before(num_epoch + x.age());
}

#endif
