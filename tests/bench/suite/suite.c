/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The benchmark suite: every task for every robot, by the library as it is, by former builds of it
 * and by the peers of this build, in turns in one process. CSV on standard output, a row for each
 * contestant; or, under callgrind, the instructions of each call.
 *
 *   bench_suite --library build/release/lib/libtotalforce.so [--baseline OTHER.so]
 *       [--turn-us N] [--rounds N] [--tasks A,B] [--count] ROBOT ...
 *
 * ROBOT: a URDF file or one that is made (humanoid30, humanoid58, chain64, chain256, chain1000,
 * chain4096), with ":floating" behind it for a floating base. TFA_ISA chooses the instruction set.
 */
#include "suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#endif

enum { LIBRARIES = 2, CALLS_COUNTED = 32 };

struct options {
    const char *path[LIBRARIES], *tasks;
    double turn_us;
    uint32_t rounds;
    int count;
};

static const char *const precisions[] = {[TFA_F64] = "f64", [TFA_F32] = "f32", [TFA_F128] = "f128"};
static const char *const estimates[] = {"default", "never", "always"};

static int is_listed(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0'))
            return 1;
    return !list;
}

static int is_for(const struct task *t, const struct robot *r)
{
    if (t->how == HOW_CHAINED && r->base == TFA_BASE_FLOATING)
        return 0;
    return (!t->fewest || (r->chain && r->joints >= t->fewest)) &&
           (!t->most || r->joints <= t->most);
}

static const char *base_name(const struct contest *c)
{
    return c->robot->base == TFA_BASE_FLOATING ? "floating" : "fixed";
}

static void print_head(const struct options *o)
{
    if (!o->count)
        puts("robot,base,joints,task,contestant,method,estimate,states,threads,precision,isa,ns,"
             "least,ns_per_joint,times,difference,rounds");
}

static void measure(struct contest *c, const struct options *o, const char *isa)
{
    struct figures f[SUITE_WHO];
    const struct task *t = c->task;
    const uint32_t rounds = contest_measure(c, o->turn_us, o->rounds, f);
    for (uint32_t k = 0; k < c->count; k++)
        printf("%s,%s,%u,%s,%s,%s,%s,%u,%u,%s,%s,%.1f,%.1f,%.2f,%.3f,%.1e,%u\n", c->robot->name,
               base_name(c), c->robot->joints, t->name, c->who[k].name, contest_method(c, k),
               estimates[t->estimate], t->states, t->threads, precisions[t->precision],
               c->who[k].library ? isa : "", f[k].median, f[k].least,
               f[k].median / c->robot->joints, f[k].times, contest_difference(c, k), rounds);
    fflush(stdout);
}

/* Of one thread only: each call and nothing else is between two toggles, and each dump bears the name
 * of its row. */
static void count(struct contest *c)
{
    if (c->task->threads > 1 || c->task->how != HOW_WARM)
        return;
    for (uint32_t k = 0; k < c->count; k++) {
        char row[160];
        const uint32_t calls = c->task->states > 1 ? 1 : CALLS_COUNTED;
        snprintf(row, sizeof row, "row %s,%s,%u,%s,%s,%u", c->robot->name, base_name(c),
                 c->robot->joints, c->task->name, c->who[k].name, calls * c->task->states);
        for (uint32_t call = 0; call < 4; call++)
            (void)contest_ask(c, k);
#ifdef CALLGRIND_TOGGLE_COLLECT
        CALLGRIND_ZERO_STATS;
        CALLGRIND_TOGGLE_COLLECT;
#endif
        for (uint32_t call = 0; call < calls; call++)
            (void)contest_ask(c, k);
#ifdef CALLGRIND_TOGGLE_COLLECT
        CALLGRIND_TOGGLE_COLLECT;
        CALLGRIND_DUMP_STATS_AT(row);
#endif
    }
}

static void run_robot(struct robot *r, const struct options *o, const struct library *libraries)
{
    const uint32_t many = o->path[1] ? 2 : 1;
    for (const struct task *t = suite_tasks; t->name; t++) {
        struct contest c;
        if (!is_listed(o->tasks, t->name) || !is_for(t, r) ||
            contest_open(&c, t, r, libraries, many) != 0)
            continue;
        if (o->count)
            count(&c);
        else
            measure(&c, o, libraries[0].tfa_isa_name());
        contest_close(&c);
    }
}

static int run(const char *argument, const struct options *o, const struct library *libraries)
{
    struct robot r;
    char name[4096];
    const char *colon = strrchr(argument, ':');
    const int floating = colon && strcmp(colon, ":floating") == 0;
    snprintf(name, sizeof name, "%.*s",
             (int)(floating ? (size_t)(colon - argument) : strlen(argument)), argument);
    if (robot_open(&r, &libraries[0], name, floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED) != 0)
        return 1;
    run_robot(&r, o, libraries);
    robot_close(&r, &libraries[0]);
    return 0;
}

/* The index of the first robot, or 0: the command line is wrong. */
static int parse(int argc, char **argv, struct options *o)
{
    int k = 1;
    for (; k < argc && strncmp(argv[k], "--", 2) == 0; k++) {
        const char *value = k + 1 < argc ? argv[k + 1] : "";
        if (strcmp(argv[k], "--count") == 0) {
            o->count = 1;
            continue;
        }
        if (strcmp(argv[k], "--library") == 0)
            o->path[0] = value;
        else if (strcmp(argv[k], "--baseline") == 0)
            o->path[1] = value;
        else if (strcmp(argv[k], "--tasks") == 0)
            o->tasks = value;
        else if (strcmp(argv[k], "--turn-us") == 0)
            o->turn_us = atof(value);
        else if (strcmp(argv[k], "--rounds") == 0)
            o->rounds = (uint32_t)atoi(value);
        else
            return 0;
        k++;
    }
    return o->path[0] && o->turn_us > 0 && o->rounds > 0 && k < argc ? k : 0;
}

int main(int argc, char **argv)
{
    static const char *const names[LIBRARIES] = {"now", "former"};
    struct options o = {.turn_us = 1000, .rounds = 21};
    static struct library libraries[LIBRARIES];
    int bad = 0;
    const int first = parse(argc, argv, &o);
    if (!first) {
        fputs("bench_suite --library FILE.so [--baseline FILE.so] [--turn-us N] [--rounds N]\n"
              "    [--tasks A,B] [--count] ROBOT[:floating] ...\n",
              stderr);
        return 3;
    }
    for (int k = 0; k < LIBRARIES && o.path[k]; k++)
        if (library_open(&libraries[k], names[k], o.path[k]) != 0)
            return 2;
    cpus_pin();
    print_head(&o);
    for (int k = first; k < argc; k++)
        bad |= run(argv[k], &o, libraries);
    return bad ? 2 : 0;
}
