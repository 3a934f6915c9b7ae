/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Counting changes no answer, and what is counted is what theory says.
 */
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <vector>

extern "C" {
#include <cmocka.h>
}

#include "count/measure.h"

namespace
{
const count_method methods[] = {TFA_METHOD_ABA,           TFA_METHOD_CRBA,      TFA_METHOD_TFA,
                                TFA_METHOD_TFA_CR,        TFA_METHOD_CFA,       TFA_METHOD_CFA_CR,
                                TFA_METHOD_DCA,           TFA_METHOD_SCAN,      COUNT_SCAN_TREE,
                                TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_HESSENBERG};
count_parts counted(count_method method, unsigned n)
{
    count_robot robot(n, true);
    count_parts parts;
    const int status = robot.measure(method, parts);
    if (status != TFA_OK)
        fail_msg("%s: %s", count_method_name(method), tfa_status_text(status));
    return parts;
}

/* The same operations in the same order: only fused multiply-add can tell them apart. */
void counting_changes_no_answer(void **)
{
    const unsigned n = 100; /* six or so segments */
    for (count_method method : methods)
        for (bool moving : {false, true}) {
            count_robot robot(n, moving);
            std::vector<double> a(n), b(n);
            assert_int_equal(robot.counted(method, a.data()), TFA_OK);
            assert_int_equal(robot.plain(method, b.data()), TFA_OK);
            double error = 0, size = 0;
            for (unsigned k = 0; k < n; k++) {
                assert_true(std::isfinite(a[k]));
                error += (a[k] - b[k]) * (a[k] - b[k]);
                size += b[k] * b[k];
            }
            assert_true(size > 0);
            if (!(std::sqrt(error) <= 1e-9 * std::sqrt(size)))
                fail_msg("%s: differs by %g of %g", count_method_name(method), std::sqrt(error),
                         std::sqrt(size));
        }
}

void a_second_run_counts_the_same(void **)
{
    count_robot robot(16, true);
    count_parts a, b;
    assert_int_equal(robot.measure(TFA_METHOD_TFA, a), TFA_OK);
    assert_int_equal(robot.measure(TFA_METHOD_ABA, b), TFA_OK);
    assert_int_equal(robot.measure(TFA_METHOD_TFA, b), TFA_OK);
    assert_int_equal(a.all.multiplications, b.all.multiplications);
    assert_int_equal(a.all.additions, b.all.additions);
    assert_int_equal(a.all.depth, b.all.depth);
    assert_true(a.all.level == b.all.level);
}

/* Parts add up, every operation stands on a level, no level is empty, and nothing is finished
 * before its longest chain. */
void counts_are_consistent(void **)
{
    for (count_method method : methods) {
        const count_parts p = counted(method, 20);
        assert_int_equal(count_work(p.all),
                         count_work(p.pose) + count_work(p.velocity) + count_work(p.dynamics));
        if (method == TFA_METHOD_ABA) /* shares products between its halves */
            assert_true(count_work(p.dynamics) < count_work(p.factor) + count_work(p.solve));
        else if (method != COUNT_SCAN_TREE)
            assert_int_equal(count_work(p.dynamics), count_work(p.factor) + count_work(p.solve));
        assert_true(p.dynamics.depth <= p.all.depth);
        uint64_t sum = 0;
        for (size_t k = 1; k < p.all.level.size(); k++) {
            assert_true(p.all.level[k] > 0);
            sum += p.all.level[k];
        }
        assert_int_equal(sum, count_work(p.all));
        assert_int_equal(count_schedule(p.all, 1), count_work(p.all));
        assert_int_equal(count_schedule(p.all, sum), p.all.depth);
        for (uint64_t processors = 1; processors < 64; processors *= 2) {
            const uint64_t time = count_schedule(p.all, processors);
            assert_true(time >= count_bound(p.all, processors));
            assert_true(time <= sum / processors + p.all.depth);
        }
    }
}

/* Work and dependency chain of the serial methods grow by the same number for each body. */
void serial_methods_are_linear(void **)
{
    for (count_method method : {TFA_METHOD_ABA, TFA_METHOD_TFA}) {
        count_parts p[3];
        for (unsigned k = 0; k < 3; k++)
            p[k] = counted(method, 16 * (k + 1));
        assert_int_equal(p[2].all.multiplications - p[1].all.multiplications,
                         p[1].all.multiplications - p[0].all.multiplications);
        assert_int_equal(p[2].all.additions - p[1].all.additions,
                         p[1].all.additions - p[0].all.additions);
        assert_int_equal(p[2].all.depth - p[1].all.depth, p[1].all.depth - p[0].all.depth);
        assert_true(p[1].all.depth > p[0].all.depth + 16);
    }
}

/* Twice the bodies, the same number of operations more on the longest chain, when poses and
 * velocities are given. Linear growth would make the second difference four times the first. */
void parallel_methods_are_logarithmic(void **)
{
    for (count_method method : {(count_method)TFA_METHOD_TFA_CR, (count_method)TFA_METHOD_CFA_CR,
                                (count_method)TFA_METHOD_DCA, COUNT_SCAN_TREE}) {
        count_parts p[4];
        unsigned n = 64;
        for (count_parts &parts : p) {
            parts = counted(method, n);
            n *= 2;
        }
        const uint32_t early = p[1].dynamics.depth - p[0].dynamics.depth;
        const uint32_t late = p[3].dynamics.depth - p[2].dynamics.depth;
        assert_true(late < 2 * early);
    }
}

/* Fewer operations than the textbook counts for the articulated-body algorithm: 300 N - 267 and
 * 279 N - 259 (Featherstone 2008). */
void aba_is_below_the_textbook(void **)
{
    const count_parts p[2] = {counted(TFA_METHOD_ABA, 64), counted(TFA_METHOD_ABA, 128)};
    const double m = (double)(p[1].all.multiplications - p[0].all.multiplications) / 64;
    const double a = (double)(p[1].all.additions - p[0].all.additions) / 64;
    assert_true(m > 200 && m < 300);
    assert_true(a > 180 && a < 279);
}

} // namespace

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counting_changes_no_answer),
        cmocka_unit_test(a_second_run_counts_the_same),
        cmocka_unit_test(counts_are_consistent),
        cmocka_unit_test(serial_methods_are_linear),
        cmocka_unit_test(parallel_methods_are_logarithmic),
        cmocka_unit_test(aba_is_below_the_textbook),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
