/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations per body of every method on chains of revolute joints, and the time they would take
 * on many processors. Everything is counted in a run over a number type that counts (count/); a
 * second run gives the same figures.
 *
 * A body with modes too.
 *
 *   bench_count [--csv] [--largest N]
 *
 * With --csv: factors and solve of a moving chain on P = 1, 2, 4, ..., N processors.
 */
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "count/measure.h"

namespace
{
const count_method methods[] = {TFA_METHOD_ABA,           TFA_METHOD_CRBA,      TFA_METHOD_TFA,
                                TFA_METHOD_TFA_CR,        TFA_METHOD_CFA,       TFA_METHOD_CFA_CR,
                                TFA_METHOD_DCA,           TFA_METHOD_SCAN,      COUNT_SCAN_TREE,
                                TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_HESSENBERG};
/* O(N^2) and O(N^3) in work: counted up to this size only */
const unsigned dense_largest = 256;
struct part_name {
    const char *name;
    count_part count_parts::*part;
};
const part_name part_names[] = {
    {"pose", &count_parts::pose},     {"velocity", &count_parts::velocity},
    {"factor", &count_parts::factor}, {"solve", &count_parts::solve},
    {"refine", &count_parts::refine}, {"dynamics", &count_parts::dynamics},
    {"all", &count_parts::all},
};

bool dense(count_method method)
{
    return method == TFA_METHOD_CRBA || method == TFA_METHOD_HESSENBERG;
}

/* ---- operations per body: a line through N = 64 and 128 ---- */

struct line {
    double slope, intercept;
};

line through(uint64_t at_64, uint64_t at_128)
{
    const double slope = (double)(at_128 - at_64) / 64;
    return {slope, (double)at_64 - 64 * slope};
}

struct operations_row {
    line multiplications, additions, divisions, comparisons, idle;
};

operations_row fit(const count_part &a, const count_part &b)
{
    return {through(a.multiplications, b.multiplications), through(a.additions, b.additions),
            through(a.divisions, b.divisions), through(a.comparisons, b.comparisons),
            through(a.idle, b.idle)};
}

void print_row(const char *method, const char *part, const operations_row &r)
{
    std::printf("%-14s %-9s %8.1f %+9.1f %8.1f %+9.1f %6.1f %6.1f %8.1f\n", method, part,
                r.multiplications.slope, r.multiplications.intercept, r.additions.slope,
                r.additions.intercept, r.divisions.slope, r.comparisons.slope, r.idle.slope);
}

void operations_of(count_method method, count_robot &small, count_robot &large)
{
    const char *name = count_method_name(method);
    count_parts a, b;
    const int status = small.measure(method, a);
    if (status != TFA_OK || large.measure(method, b) != TFA_OK) {
        std::printf("%-14s refused: %s\n", name, tfa_status_text(status));
        return;
    }
    for (const part_name &p : part_names) {
        if (!count_work(b.*p.part) && &(b.*p.part) != &b.velocity)
            continue; /* the tree has no halves */
        print_row(name, p.name, fit(a.*p.part, b.*p.part));
    }
}

void print_operations(bool moving)
{
    count_robot small(64, moving), large(128, moving);
    std::printf("Operations on a chain of N revolute joints, %s: slope x N + intercept through "
                "N = 64 and 128.\nSines excluded. Idle: of the operations of a body, those by "
                "0 or +-1 and with 0.\n\n%-14s %-9s %18s %18s %6s %6s %8s\n",
                moving ? "moving" : "at rest", "method", "part", "multiplications", "additions",
                "div", "comp", "idle");
    for (count_method method : methods)
        operations_of(method, small, large);
    std::printf("\nFrom the literature (each fixed base, revolute, sines excluded):\n"
                "  tfa  Fijany & Featherstone 2013: 1239 N - 916 multiplications, "
                "1055 N - 811 additions\n"
                "  aba  Featherstone 2008:           300 N - 267 multiplications,  "
                "279 N - 259 additions\n\n");
}

/* ---- flexible links ---- */

void print_modes()
{
    std::printf("Operations of a body with modes, moving, pose and velocity included: "
                "multiplications, additions, divisions.\n\n%-14s %6s\n",
                "method", "modes");
    for (count_method method : {TFA_METHOD_ABA, TFA_METHOD_SCAN, TFA_METHOD_DCA})
        for (unsigned modes : {0u, 1u, 2u, 4u, 8u, 12u}) {
            count_robot small(64, true, modes), large(128, true, modes);
            count_parts a, b;
            if (small.measure(method, a) != TFA_OK || large.measure(method, b) != TFA_OK)
                std::abort();
            const operations_row r = fit(a.all, b.all);
            std::printf("%-14s %6u %8.1f %8.1f %6.1f\n", count_method_name(method), modes,
                        r.multiplications.slope, r.additions.slope, r.divisions.slope);
        }
    std::printf("\n");
}

/* ---- the longest dependency chain ---- */

struct depth_lines {
    std::string all, dynamics, on_n;
};

void append(std::string &line, uint64_t number)
{
    char text[32];
    std::snprintf(text, sizeof text, " %8llu", (unsigned long long)number);
    line += text;
}

void depth_of(count_method method, bool moving, unsigned largest)
{
    const char *name = count_method_name(method);
    depth_lines lines;
    for (unsigned n = 8; n <= largest && !(dense(method) && n > dense_largest); n *= 2) {
        count_robot robot(n, moving);
        count_parts parts;
        if (robot.measure(method, parts) != TFA_OK)
            return;
        append(lines.all, parts.all.depth);
        append(lines.dynamics, parts.dynamics.depth);
        append(lines.on_n, count_schedule(parts.dynamics, n));
    }
    std::printf("%-14s %-11s%s\n", name, "all", lines.all.c_str());
    std::printf("%-14s %-11s%s\n", name, "dynamics", lines.dynamics.c_str());
    std::printf("%-14s %-11s%s\n", name, "same, P = N", lines.on_n.c_str());
}

void print_depths(bool moving, unsigned largest)
{
    std::printf(
        "Longest dependency chain, %s, in operations: the time on processors without "
        "number.\nDynamics: factors and solve when poses and velocities are given; P = N: on N "
        "processors.\n\n"
        "%-14s %-11s",
        moving ? "moving" : "at rest", "method", "N =");
    for (unsigned n = 8; n <= largest; n *= 2)
        std::printf(" %8u", n);
    std::printf("\n");
    for (count_method method : methods)
        depth_of(method, moving, largest);
    std::printf("\n");
}

/* ---- time on P processors ---- */

void processors_of(count_method method, count_robot &robot, unsigned n)
{
    const char *name = count_method_name(method);
    count_parts parts;
    if (robot.measure(method, parts) != TFA_OK)
        return;
    const count_part &part = parts.dynamics;
    std::printf("%-14s", name);
    for (unsigned p = 1; p <= n; p *= 2)
        std::printf(" %8llu", (unsigned long long)count_schedule(part, p));
    std::printf(" %8u\n", part.depth);
}

void print_processors(unsigned n)
{
    count_robot robot(n, true);
    std::printf(
        "Time of factors and solve on P processors in operations, N = %u, moving, level by "
        "level:\nless than work / P + longest chain, which is at most twice what any schedule "
        "needs.\n\n%-14s",
        n, "P =");
    for (unsigned p = 1; p <= n; p *= 2)
        std::printf(" %8u", p);
    std::printf(" %8s\n", "any");
    for (count_method method : methods)
        processors_of(method, robot, n);
}

/* ---- for the picture ---- */

void write_steps(count_method method, unsigned n)
{
    count_robot robot(n, true);
    count_parts parts;
    if (robot.measure(method, parts) != TFA_OK)
        return;
    const count_part &part = parts.dynamics;
    for (unsigned p = 1; p <= n; p *= 2)
        std::printf("%s,%u,%u,%llu,%u,%llu,%llu\n", count_method_name(method), n, p,
                    (unsigned long long)count_schedule(part, p), part.depth,
                    (unsigned long long)part.multiplications, (unsigned long long)part.additions);
}

void write_csv(unsigned largest)
{
    std::printf("method,bodies,processors,steps,depth,multiplications,additions\n");
    for (count_method method : methods)
        for (unsigned n = 16; n <= largest && !(dense(method) && n > dense_largest); n *= 2)
            write_steps(method, n);
}

} // namespace

int main(int argc, char **argv)
{
    unsigned largest = 1024;
    const bool csv = argc > 1 && !std::strcmp(argv[1], "--csv");
    argc -= csv;
    argv += csv;
    if (argc == 3 && !std::strcmp(argv[1], "--largest")) {
        largest = (unsigned)std::strtoul(argv[2], nullptr, 10);
    } else if (argc > 1) {
        std::fprintf(stderr, "usage: bench_count [--csv] [--largest N]\n");
        return 2;
    }
    if (csv) {
        write_csv(largest);
        return 0;
    }
    for (bool moving : {true, false})
        print_operations(moving);
    print_modes();
    for (bool moving : {true, false})
        print_depths(moving, largest);
    print_processors(largest < 256 ? largest : 256);
    return 0;
}
