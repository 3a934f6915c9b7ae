/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The benchmark suite: every task for every robot, by the library as it is, by a former build of
 * it, by the robot's specialised kernel and by the peers of this build, in turns in one process.
 * CSV on standard output, a row for each contestant.
 *
 *   bench_suite --library build/release/lib/libtotalforce.so [--baseline OTHER.so]
 *       [--kernels FOLDER [--compiler PROGRAM]] [--turn-us N] [--rounds N] [--tasks A,B] [--error]
 *       [--snap ANGLE] ROBOT ...
 *   bench_suite --list                  the tasks
 *
 * ROBOT: a URDF file or one that is made (humanoid30, humanoid58, chainN), with ":floating" behind
 * it for a floating base. TFA_ISA chooses the instruction set. --kernels: contestant "specialised",
 * whose kernel is built where FOLDER has none; tips are then links behind the most joints. --error:
 * the column `error`, against quadruple precision.
 */
#include "suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LIBRARIES = 2 };

struct options {
    const char *path[LIBRARIES], *tasks, *kernels, *compiler;
    double turn_us, snap;
    uint32_t rounds;
    int error, list;
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

static const char *base_name(const struct robot *r)
{
    return r->base == TFA_BASE_FLOATING ? "floating" : "fixed";
}

static const char *unit_of(const struct task *t)
{
    return t->how == HOW_BYTES ? "B" : "ns";
}

static void measure(struct contest *c, const struct options *o, const char *isa)
{
    struct figures f[SUITE_CONTESTANTS];
    const struct task *t = c->task;
    const struct robot *r = c->robot;
    const uint32_t rounds = contest_measure(c, o->turn_us, o->rounds, f);
    for (uint32_t k = 0; k < c->count; k++) {
        printf("%s,%s,%u,%s,%s,%s,%s,%u,%u,%s,%s,%.1f,%.1f,%.2f,%.3f,%.1e,%u,%s,", r->name,
               base_name(r), r->joints, t->name, c->contestant[k].name, contest_method(c, k),
               estimates[t->estimate], t->states, t->threads, precisions[t->precision],
               c->contestant[k].library ? isa : "", f[k].median, f[k].least,
               f[k].median / r->joints, f[k].times, contest_difference(c, k), rounds, unit_of(t));
        if (o->error && t->states == 1 && t->how < HOW_PARSE)
            printf("%.1e", contest_error(c, k));
        putchar('\n');
    }
    fflush(stdout);
}

/* What is known of a kernel besides its times */
static void print_kernel(const struct robot *r, const char *task, double value, const char *unit)
{
    if (value > 0)
        printf("%s,%s,%u,%s,specialised,,,,,,,%.6g,,,,,,%s,\n", r->name, base_name(r), r->joints,
               task, value, unit);
}

static void run_robot(struct robot *r, const struct options *o, const struct library *libraries,
                      uint32_t many)
{
    for (const struct task *t = suite_tasks; t->name; t++) {
        struct contest c;
        struct task task = *t;
        task.deepest_tip = o->kernels && task.tips == 1;
        if (!is_listed(o->tasks, t->name) || !suite_is_for(t, r) ||
            contest_open(&c, &task, r, libraries, many) != 0)
            continue;
        measure(&c, o, libraries[0].tfa_isa_name());
        contest_close(&c);
    }
}

static int open_robot(struct robot *r, const char *argument, const struct options *o,
                      const struct library *l)
{
    char name[4096];
    const char *colon = strrchr(argument, ':');
    const int floating = colon && strcmp(colon, ":floating") == 0;
    snprintf(name, sizeof name, "%.*s",
             (int)(floating ? (size_t)(colon - argument) : strlen(argument)), argument);
    const int bad = robot_open(r, l, name, floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    r->snap = o->snap;
    return bad;
}

/* Compilers run before this program is pinned to one processor. */
static int build_kernel(const char *argument, const struct options *o, const struct library *l)
{
    struct robot r;
    struct kernel k;
    if (open_robot(&r, argument, o, l) != 0)
        return 1;
    const int bad = kernel_open(&k, l, &r, o->kernels, o->compiler);
    print_kernel(&r, "compile_s", k.compile_s, "s");
    print_kernel(&r, "compilers_s", k.compilers_s, "s");
    kernel_close(&k, l);
    robot_close(&r, l);
    return bad;
}

static int run_suite(const char *argument, const struct options *o, const struct library *libraries)
{
    struct robot r;
    struct kernel kernel = {0};
    struct library answering[LIBRARIES + 1] = {libraries[0]};
    uint32_t many = 1;
    if (open_robot(&r, argument, o, &libraries[0]) != 0)
        return 1;
    int bad = o->kernels && kernel_open(&kernel, &libraries[0], &r, o->kernels, o->compiler) != 0;
    if (o->kernels && !bad) {
        print_kernel(&r, "code_bytes", (double)kernel.text, "B");
        print_kernel(&r, "load_ms", kernel.load_ms, "ms");
        print_kernel(&r, "kernel_error", kernel.error, "");
        answering[many] = libraries[0];
        answering[many].name = "specialised";
        answering[many++].specialised = kernel.loaded;
    }
    if (o->path[1])
        answering[many++] = libraries[1];
    run_robot(&r, o, answering, many);
    kernel_close(&kernel, &libraries[0]);
    robot_close(&r, &libraries[0]);
    return bad;
}

/* The index of the first robot, or 0: the command line is wrong. */
static int parse_arguments(int argc, char **argv, struct options *o)
{
    const struct {
        const char *name;
        int *flag; /* or one of these takes a value */
        const char **text;
        uint32_t *number;
        double *real;
    } known[] = {
        {"--list", .flag = &o->list},       {"--error", .flag = &o->error},
        {"--library", .text = &o->path[0]}, {"--baseline", .text = &o->path[1]},
        {"--kernels", .text = &o->kernels}, {"--compiler", .text = &o->compiler},
        {"--tasks", .text = &o->tasks},     {"--rounds", .number = &o->rounds},
        {"--turn-us", .real = &o->turn_us}, {"--snap", .real = &o->snap},
    };
    int k = 1;
    for (; k < argc && strncmp(argv[k], "--", 2) == 0; k++) {
        size_t at = 0;
        while (at < sizeof known / sizeof *known && strcmp(known[at].name, argv[k]) != 0)
            at++;
        if (at == sizeof known / sizeof *known)
            return 0;
        if (known[at].flag)
            *known[at].flag = 1;
        if (!known[at].text && !known[at].number && !known[at].real)
            continue;
        if (++k == argc)
            return 0;
        if (known[at].text)
            *known[at].text = argv[k];
        else if (known[at].number)
            *known[at].number = (uint32_t)atoi(argv[k]);
        else
            *known[at].real = atof(argv[k]);
    }
    return o->path[0] && o->turn_us > 0 && o->rounds > 0 && k < argc ? k : 0;
}

static int list_tasks(void)
{
    for (const struct task *t = suite_tasks; t->name; t++)
        printf("%-22s %s\n", t->name, t->text);
    return 0;
}

int main(int argc, char **argv)
{
    static const char *const names[LIBRARIES] = {"now", "former"};
    struct options o = {.turn_us = 1000, .rounds = 21};
    static struct library libraries[LIBRARIES];
    int bad = 0;
    const int first = parse_arguments(argc, argv, &o);
    if (o.list)
        return list_tasks();
    if (!first) {
        fputs(
            "bench_suite --library FILE.so [--baseline FILE.so] [--kernels FOLDER] [--turn-us N]\n"
            "    [--rounds N] [--tasks A,B] [--error] ROBOT[:floating] ... | --list\n",
            stderr);
        return 3;
    }
    for (int k = 0; k < LIBRARIES && o.path[k]; k++)
        if (library_open(&libraries[k], names[k], o.path[k]) != 0)
            return 2;
    puts("robot,base,joints,task,contestant,method,estimate,states,threads,precision,isa,ns,least,"
         "ns_per_joint,times,difference,rounds,unit,error");
    for (int k = first; o.kernels && k < argc; k++)
        bad |= build_kernel(argv[k], &o, &libraries[0]);
    cpus_pin();
    for (int k = first; k < argc; k++)
        bad |= run_suite(argv[k], &o, libraries);
    return bad ? 2 : 0;
}
