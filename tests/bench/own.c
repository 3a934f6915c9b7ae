/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kernels of robots' own beside the generic one and the peers of this build: code size, the time to
 * compile, to load and test, the largest difference, and the time of what is asked, by turns in one process.
 *
 *   bench_own [--kernels FOLDER] [--compiler PROGRAM] [--snap ANGLE] [--csv] [--turn-us N]
 *       [--rounds N] ROBOT[:floating] ...
 *
 * ROBOT: a URDF file, or one that bench_suite makes (humanoid30, humanoid58, chain64). Kernels are
 * built where FOLDER has none; without it they live as long as the run. --snap: as of `totalforce
 * model`.
 *
 * Warm: 16 states in turn. Chained: each state waits for the answer before it. Cold: no cache holds data or
 * code (suite/flush.c). Batches: 512 states at a time, ns for one. The tip is a link behind the most joints.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "own_kernel.h"
#include "suite/suite.h"

struct options {
    const char *kernels, *compiler;
    int csv;
    double turn_us, snap;
    uint32_t rounds;
    char scratch[64]; /* of this run; "": kernels are to stay */
};

struct subject {
    struct robot robot;
    tfa_model *model;
    struct kernel kernel;
};

static const struct library linked = {.name = "generic",
#define LINKED(call) .call = call,
                                      SUITE_CALLS(LINKED)
#undef LINKED
};

/* ---- what is asked ---- */

/* With a payload, or a gravity, of the request */
enum given { NOTHING, A_PAYLOAD, A_GRAVITY };

#define FD TFA_OP_FORWARD_DYNAMICS
#define ID TFA_OP_INVERSE_DYNAMICS
#define LAMBDA TFA_OP_OPERATIONAL_INERTIA
#define ONE .estimate = TFA_ESTIMATE_NEVER, .states = 1, .threads = 1
#define MANY .estimate = TFA_ESTIMATE_NEVER, .states = 512, .threads = 1

static const struct question {
    struct task task;
    enum given given;
} questions[] = {
    {{"fd", FD, ONE}, NOTHING},
    {{"fd-chained", FD, ONE, .how = HOW_CHAINED}, NOTHING},
    {{"fd-cold", FD, ONE, .how = HOW_COLD}, NOTHING},
    {{"id", ID, ONE}, NOTHING},
    {{"id-cold", ID, ONE, .how = HOW_COLD}, NOTHING},
    {{"lambda", LAMBDA, ONE, .tips = 1}, NOTHING},
    {{"lambda-cold", LAMBDA, ONE, .tips = 1, .how = HOW_COLD}, NOTHING},
    {{"fd+lambda", FD, ONE, .tips = 1}, NOTHING},
    {{"fd+lambda-cold", FD, ONE, .tips = 1, .how = HOW_COLD}, NOTHING},
    {{"batch", FD, MANY}, NOTHING},
    {{"batch-id", ID, MANY}, NOTHING},
    {{"fd+payload", FD, ONE}, A_PAYLOAD},
    {{"batch+payload", FD, MANY}, A_PAYLOAD},
    {{"fd+gravity", FD, ONE}, A_GRAVITY},
    {{"batch+gravity", FD, MANY}, A_GRAVITY},
};

static int is_for(const struct question *q, const struct subject *s)
{
    return q->task.how != HOW_CHAINED || s->robot.base == TFA_BASE_FIXED;
}

static void hang_on(struct contest *c, const struct subject *s, enum given given)
{
    static const double gravity[3] = {1, -2, -9};
    static const double payload[TFA_PAYLOAD_NUMBERS] = {0.8,  0.02, 0,    0.05, 2e-3,
                                                        1e-4, 0,    2e-3, 0,    1e-3};
    c->request.tips[0] = robot_deepest(&s->robot);
    c->request.gravity = given == A_GRAVITY ? gravity : NULL;
    c->request.payload_count = given == A_PAYLOAD;
    c->request.payloads = payload;
    c->request.payload_frames[0] = robot_deepest(&s->robot);
}

/* ---- what is printed ---- */

static const char *base_name(const struct subject *s)
{
    return s->robot.base == TFA_BASE_FLOATING ? "floating" : "fixed";
}

static void print_row(const struct subject *s, const char *who, const char *figure, double value)
{
    printf("%s,%s,%u,%s,%s,%.6g,,\n", s->robot.name, base_name(s), s->robot.joints, who, figure,
           value);
}

static void print_kernel(const struct subject *s, const struct kernel *k, int csv)
{
    const tfa_specialised_info info = tfa_specialised_describe(k->loaded);
    if (!csv) {
        printf("%s, %s base, %u joints, %s: %zu bytes of code, compiled in %.2f s (%.2f s of "
               "processor time) by %s, loaded and "
               "tested in %.2f ms, within %.1g\n",
               s->robot.name, base_name(s), s->robot.joints, k->name, k->text, k->compile_s,
               k->compilers_s, k->compiler, k->load_ms, info.error);
        return;
    }
    print_row(s, k->name, "code_bytes", (double)k->text);
    if (k->compile_s > 0) {
        print_row(s, k->name, "compile_s", k->compile_s);
        print_row(s, k->name, "compilers_s", k->compilers_s);
    }
    print_row(s, k->name, "load_ms", k->load_ms);
    print_row(s, k->name, "error", info.error);
}

/* Peers know neither payloads nor another gravity. */
static void print_times(const struct subject *s, struct contest *c, enum given given,
                        const struct figures *f, int csv)
{
    if (!csv)
        printf("  %-15s", c->task->name);
    for (uint32_t k = 0; k < c->count; k++) {
        if (c->who[k].peer && given != NOTHING)
            continue;
        if (csv)
            printf("%s,%s,%u,%s,%s,%.1f,%.3f,%.1e\n", s->robot.name, base_name(s), s->robot.joints,
                   c->who[k].name, c->task->name, f[k].median, f[k].times,
                   contest_difference(c, k));
        else
            printf("  %s %.0f", c->who[k].name, f[k].median);
    }
    if (!csv)
        putchar('\n');
    fflush(stdout);
}

/* ---- one robot ---- */

static void measure(struct subject *s, const struct options *o)
{
    struct library answering[2] = {linked, linked};
    struct figures f[SUITE_WHO];
    answering[1].name = s->kernel.name;
    answering[1].specialised = s->kernel.loaded;
    print_kernel(s, &s->kernel, o->csv);
    for (size_t q = 0; q < sizeof questions / sizeof *questions; q++) {
        struct contest c;
        if (!is_for(&questions[q], s) ||
            contest_open(&c, &questions[q].task, &s->robot, answering, 2) != 0)
            continue;
        hang_on(&c, s, questions[q].given);
        (void)contest_measure(&c, o->turn_us, o->rounds, f);
        print_times(s, &c, questions[q].given, f, o->csv);
        contest_close(&c);
    }
}

static int measure_loaded(struct subject *s, const struct options *o)
{
    const int bad = kernel_load(&s->kernel, s->model);
    if (!bad)
        measure(s, o);
    kernel_close(&s->kernel);
    return bad;
}

/* Compilers run before this program is pinned to one processor. */
static int open_subject(struct subject *s, const char *argument, const struct options *o)
{
    char name[4096];
    const char *colon = strrchr(argument, ':');
    const int floating = colon && strcmp(colon, ":floating") == 0;
    snprintf(name, sizeof name, "%.*s",
             (int)(floating ? (size_t)(colon - argument) : strlen(argument)), argument);
    if (robot_open(&s->robot, &linked, name, floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED) != 0)
        return -1;
    s->robot.snap = o->snap;
    const tfa_model_options options = {
        .base = s->robot.base, .lock_massless_leaves = 1, .snap = o->snap};
    if (tfa_model_create(s->robot.description, &options, NULL, &s->model) != TFA_OK)
        return -1;
    s->kernel.name = "own";
    return kernel_build(&s->kernel, s->model, o->kernels, o->compiler);
}

static void close_subject(struct subject *s, const struct options *o)
{
    if (o->scratch[0])
        unlink(s->kernel.path);
    tfa_model_free(s->model);
    if (s->robot.description)
        robot_close(&s->robot, &linked);
}

/* ---- all of them ---- */

/* The index of the first robot, or 0: the command line is wrong. */
static int parse(int argc, char **argv, struct options *o)
{
    int k = 1;
    for (; k < argc && strncmp(argv[k], "--", 2) == 0; k++) {
        const char *value = k + 1 < argc ? argv[k + 1] : "";
        if (strcmp(argv[k], "--csv") == 0) {
            o->csv = 1;
            continue;
        }
        if (strcmp(argv[k], "--kernels") == 0)
            o->kernels = value;
        else if (strcmp(argv[k], "--compiler") == 0)
            o->compiler = value;
        else if (strcmp(argv[k], "--snap") == 0)
            o->snap = atof(value);
        else if (strcmp(argv[k], "--turn-us") == 0)
            o->turn_us = atof(value);
        else if (strcmp(argv[k], "--rounds") == 0)
            o->rounds = (uint32_t)atoi(value);
        else
            return 0;
        k++;
    }
    return o->turn_us > 0 && o->rounds > 0 && k < argc ? k : 0;
}

int main(int argc, char **argv)
{
    struct options o = {.turn_us = 1000, .rounds = 41};
    const int first = parse(argc, argv, &o);
    if (!first) {
        fputs("bench_own [--kernels FOLDER] [--compiler PROGRAM] [--snap ANGLE] [--csv]\n"
              "    [--turn-us N] [--rounds N] ROBOT[:floating] ...\n",
              stderr);
        return 3;
    }
    if (!o.kernels) {
        snprintf(o.scratch, sizeof o.scratch, "/tmp/tfa-bench-own-XXXXXX");
        o.kernels = mkdtemp(o.scratch);
    }
    const uint32_t count = (uint32_t)(argc - first);
    struct subject *subjects = calloc(count, sizeof *subjects);
    int bad = !subjects || !o.kernels;
    for (uint32_t k = 0; !bad && k < count; k++)
        bad = open_subject(&subjects[k], argv[first + (int)k], &o);
    cpus_pin();
    if (!bad && o.csv)
        puts("robot,base,joints,contestant,figure,value,times,difference");
    for (uint32_t k = 0; !bad && k < count; k++)
        bad = measure_loaded(&subjects[k], &o);
    for (uint32_t k = 0; subjects && k < count; k++)
        close_subject(&subjects[k], &o);
    if (o.scratch[0])
        rmdir(o.scratch);
    free(subjects);
    return bad ? 2 : 0;
}
