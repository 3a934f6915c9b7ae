/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Algorithms of a kernel: which of its functions answers which kind of request. Where a robot has
 * code by articulated and by composite rigid bodies, both are timed when the kernel is built.
 */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "specialised/self_test.h"

/* Composite rigid bodies take operations that grow with the square of a path. */
#define CRBA_BODIES_MAX 16
/* As in dynamics/specialised/specialised_supports.h */
#define UNROLLED_BODIES_MAX 40

/* It is taken if it is faster by this (one state and batches: geometric mean) and, with every tip,
 * no less accurate: its error (root mean square over the states, relative to quadruple precision)
 * over that of articulated bodies, or over that of rounding. */
#define FASTER 0.97
#define LOSS_MAX 3
#define ERROR_MIN(states) ((states) == BATCH_F32 ? 1e-7 : 2e-16)
#define ROUNDS 40
/* So many times as many at most, while times are nearer than this to where the choice changes:
 * least times approach those of an idle machine from above. */
#define CLOSE 0.05
#define REPETITIONS 10

static const char *const algorithms[ALGORITHMS] = {"aba", "crba"};

static const struct {
    const char *macro, *name, *function, *variant; /* tfa_robot_FUNCTION_VARIANT_ALGORITHM */
    tfa_op op;
    uint32_t tips;
    enum { ONE, BATCH, BATCH_F32 } states;
} kinds[CHOICES] = {
    [CHOICE_FORWARD] = {"ROBOT_FORWARD_ONE", "forward", "forward", "scalar",
                        TFA_OP_FORWARD_DYNAMICS, 0, ONE},
    [CHOICE_LAMBDA] = {"ROBOT_LAMBDA_ONE", "lambda", "lambda", "scalar", TFA_OP_OPERATIONAL_INERTIA,
                       1, ONE},
    [CHOICE_FORWARD_LAMBDA] = {"ROBOT_FORWARD_LAMBDA_ONE", "forward+lambda", "forward_lambda",
                               "scalar", TFA_OP_FORWARD_DYNAMICS, 1, ONE},
    [CHOICE_FORWARD_BATCH] = {"ROBOT_FORWARD_BATCH", "batch forward", "forward", "batch",
                              TFA_OP_FORWARD_DYNAMICS, 0, BATCH},
    [CHOICE_LAMBDA_BATCH] = {"ROBOT_LAMBDA_BATCH", "batch lambda", "lambda", "batch",
                             TFA_OP_OPERATIONAL_INERTIA, 1, BATCH},
    [CHOICE_FORWARD_LAMBDA_BATCH] = {"ROBOT_FORWARD_LAMBDA_BATCH", "batch forward+lambda",
                                     "forward_lambda", "batch", TFA_OP_FORWARD_DYNAMICS, 1, BATCH},
    [CHOICE_FORWARD_BATCH_F32] = {"ROBOT_FORWARD_BATCH_F32", "batch f32 forward", "forward",
                                  "batch_f32", TFA_OP_FORWARD_DYNAMICS, 0, BATCH_F32},
    [CHOICE_LAMBDA_BATCH_F32] = {"ROBOT_LAMBDA_BATCH_F32", "batch f32 lambda", "lambda",
                                 "batch_f32", TFA_OP_OPERATIONAL_INERTIA, 1, BATCH_F32},
    [CHOICE_FORWARD_LAMBDA_BATCH_F32] = {"ROBOT_FORWARD_LAMBDA_BATCH_F32",
                                         "batch f32 forward+lambda", "forward_lambda", "batch_f32",
                                         TFA_OP_FORWARD_DYNAMICS, 1, BATCH_F32},
};

/* ---- what there is ---- */

int specialised_algorithms(const tfa_model *m)
{
    int single = !m->base_freedoms && m->bodies <= CRBA_BODIES_MAX;
    for (uint32_t i = 0; i < m->bodies; i++)
        single &= m->body[i].n == 1;
    return single ? ALGORITHMS : 1;
}

static void write_function(struct text_buffer *t, const tfa_model *m, int kind, int algorithm)
{
    const int lanes = specialised_has_body_lanes(m);
    const int forward = kinds[kind].op == TFA_OP_FORWARD_DYNAMICS;
    const char *name = algorithms[algorithm];
    text_append(t, "#define %s ", kinds[kind].macro);
    const int no_forward = forward && !lanes,
              no_tips = kinds[kind].states != ONE && kinds[kind].tips;
    if ((no_forward || no_tips) && m->bodies > UNROLLED_BODIES_MAX)
        text_append(t, "tfa_robot_none\n");
    else if (kind == CHOICE_FORWARD && lanes && algorithm == ALGORITHM_ABA)
        text_append(t, "tfa_robot_forward_body_lanes_aba\n");
    else if (kind == CHOICE_FORWARD_LAMBDA && lanes && algorithm == ALGORITHM_ABA)
        text_append(t, "tfa_robot_two_passes\n");
    else
        text_append(t, "tfa_robot_%s_%s_%s\n", kinds[kind].function, kinds[kind].variant, name);
}

/* Of one algorithm; variant: as macro, as function */
static void write_unchosen(struct text_buffer *t, const char *macro, const char *function,
                           const char *const variant[2])
{
    text_append(t, "#define ROBOT_%s_%s tfa_robot_%s_%s_aba\n", macro, variant[0], function,
                variant[1]);
}

/* The algorithm of a kind of request, and why */
static void write_reason(struct text_buffer *t, const struct choices *c, int kind)
{
    const int chosen = c->algorithm[kind], other = ALGORITHMS - 1 - chosen;
    const double *ns = c->measured[kind].ns;
    text_append(t, "%s%s %s", kind ? ", " : "", kinds[kind].name, algorithms[chosen]);
    if (ns[chosen] > 0)
        text_append(t, " (%.0f ns; %s %.0f ns; error of crba %.2g times that of aba)", ns[chosen],
                    algorithms[other], ns[other], c->measured[kind].loss);
}

void specialised_choice_write(struct text_buffer *t, const tfa_model *m,
                              const struct choices *choices)
{
    const char *const one[] = {"ONE", specialised_has_body_lanes(m) ? "body_lanes" : "scalar"};
    static const char *const states[][2] = {
        {"ONE", "scalar"}, {"BATCH", "batch"}, {"BATCH_F32", "batch_f32"}};
    static const char *const payloads[][2] = {{"PAYLOADS", "payloads"},
                                              {"BATCH_PAYLOADS", "batch_payloads"},
                                              {"BATCH_F32_PAYLOADS", "batch_f32_payloads"}};
    text_append(t, "/* Which function of a kernel answers; written by totalforce. */\n");
    for (int k = 0; k < CHOICES; k++)
        write_function(t, m, k, choices->algorithm[k]);
    for (size_t k = 0; k < sizeof payloads / sizeof *payloads; k++) {
        write_unchosen(t, "INVERSE", "inverse", k ? states[k] : one);
        write_unchosen(t, "MASS", "mass", states[k]);
        write_unchosen(t, "INVERSE", "inverse", payloads[k]);
        write_unchosen(t, "MASS", "mass", payloads[k]);
        if (m->bodies > UNROLLED_BODIES_MAX)
            text_append(t, "#define ROBOT_FORWARD_%s tfa_robot_none\n", payloads[k][0]);
        else
            write_unchosen(t, "FORWARD", "forward", payloads[k]);
    }
    text_append(t, "#define ROBOT_ALGORITHMS \"");
    for (int k = 0; k < CHOICES; k++)
        write_reason(t, choices, k);
    text_append(t, "\"\n");
}

/* ---- times ---- */

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* States at a time; 0: there is no code for them */
static uint32_t lanes_of(const struct tfa_specialised_kernel *kernel, int kind)
{
    const uint32_t lanes[] = {[ONE] = 1, [BATCH] = kernel->lanes, [BATCH_F32] = kernel->lanes_f32};
    return lanes[kinds[kind].states];
}

/* Computes all states; returns whether all have answers. */
static int run_states(struct self_test *t, const struct tfa_specialised_kernel *kernel, int kind)
{
    const uint32_t count = t->request.count, lanes = lanes_of(kernel, kind);
    int answered = 1;
    for (uint32_t k = 0; k < count; k += lanes) {
        const uint32_t some = count - k < lanes ? count - k : lanes;
        const uint32_t all = (UINT32_C(1) << some) - 1;
        const uint32_t done =
            kinds[kind].states == ONE
                ? kernel->solve(&t->host, &t->request, k, &t->tested.reply)
                : (kinds[kind].states == BATCH ? kernel->solve_batch : kernel->solve_batch_f32)(
                      &t->host, &t->request, k, some, &t->tested.reply);
        answered &= (done & all) == all;
    }
    return answered;
}

/* Sets the request: all states, with a tip on this frame, no sentinel. */
static void set_request(struct self_test *t, tfa_op op, uint32_t tips, uint32_t frame)
{
    const struct self_test_case q = {"", op, tips, TFA_FRAME_LOCAL_WORLD_ALIGNED, 0, 0};
    self_test_request(t, &q, t->model->bodies - 1);
    t->request.count = SELF_TEST_STATES;
    t->request.estimate = TFA_ESTIMATE_NEVER;
    t->request.tips[0] = frame;
}

/* Whether both answer such requests */
static int is_answered(const struct self_test *t,
                       const struct tfa_specialised_kernel *const *kernel, int kind)
{
    int answered = 1;
    for (int a = 0; a < ALGORITHMS; a++)
        answered &= kernel[a]->supports(&t->host, &t->request) && lanes_of(kernel[a], kind);
    return answered;
}

/* Of some rounds, in which the candidates take turns, the least times, where they are less than
 * ns[..]; 0: none yet. Returns time by crba over that by aba; 1 where there is no code. */
static double time_ratio(struct self_test *t, const struct tfa_specialised_kernel *const *kernel,
                         int kind, double ns[ALGORITHMS])
{
    set_request(t, kinds[kind].op, kinds[kind].tips, t->model->body[t->model->bodies - 1].link);
    for (int round = 0; round < ROUNDS && is_answered(t, kernel, kind); round++)
        for (int a = 0; a < ALGORITHMS; a++) {
            const double start = now_ns();
            const int answered = run_states(t, kernel[a], kind);
            const double took = (now_ns() - start) / SELF_TEST_STATES;
            if (answered && !(ns[a] > 0 && ns[a] <= took))
                ns[a] = took;
        }
    const int both = ns[ALGORITHM_CRBA] > 0 && ns[ALGORITHM_ABA] > 0;
    return both ? ns[ALGORITHM_CRBA] / ns[ALGORITHM_ABA] : 1;
}

/* ---- errors ---- */

/* Root mean square over the states of |x - exact| / |exact|, largest entries */
static double relative_error(const double *x, const double *exact, size_t n)
{
    double sum = 0;
    for (uint32_t k = 0; k < SELF_TEST_STATES; k++, x += n, exact += n) {
        double most = 0, size = 0;
        for (size_t e = 0; e < n; e++) {
            most = fmax(most, fabs(x[e] - exact[e]));
            size = fmax(size, fabs(exact[e]));
        }
        sum += size > 0 ? most / size * (most / size) : 0;
    }
    return sqrt(sum / SELF_TEST_STATES);
}

/* Of the accelerations and of Lambda^-1; 0 where the request does not ask for them */
struct errors {
    double qdd, lambda;
};

static struct errors errors_of(const struct self_test *t, int kind)
{
    const tfa_reply *x = &t->tested.reply, *exact = &t->reference.reply;
    struct errors e = {0, 0};
    if (kinds[kind].op == TFA_OP_FORWARD_DYNAMICS)
        e.qdd = relative_error(x->qdd, exact->qdd, t->model->v_count);
    if (kinds[kind].tips)
        e.lambda = relative_error(x->lambda_inv, exact->lambda_inv, 36);
    return e;
}

/* Error by crba over that by aba, of the request that is set; its exact answers are there. */
static double loss_of(struct self_test *t, const struct tfa_specialised_kernel *const *kernel,
                      int kind)
{
    const double least = ERROR_MIN(kinds[kind].states);
    struct errors e[ALGORITHMS];
    for (int a = 0; a < ALGORITHMS; a++) {
        if (!lanes_of(kernel[a], kind))
            return 0;
        if (!is_answered(t, kernel, kind) || !run_states(t, kernel[a], kind))
            return (double)INFINITY;
        e[a] = errors_of(t, kind);
    }
    return fmax(e[ALGORITHM_CRBA].qdd / fmax(e[ALGORITHM_ABA].qdd, least),
                e[ALGORITHM_CRBA].lambda / fmax(e[ALGORITHM_ABA].lambda, least));
}

/* Of each kind of request the largest over all frames that can be tips */
static void measure_losses(struct self_test *t, tfa_workspace *exact,
                           const struct tfa_specialised_kernel *const *kernel,
                           struct choices *choices)
{
    for (uint32_t f = 0; f < t->model->frames; f++) {
        if (t->model->frame[f].body < 0 || t->model->frame[f].part)
            continue;
        set_request(t, TFA_OP_FORWARD_DYNAMICS, 1, f);
        const int status = tfa_compute(exact, &t->request, &t->reference.reply);
        for (int kind = 0; kind < CHOICES; kind++) {
            t->request.op = kinds[kind].op;
            t->request.tip_count = kinds[kind].tips;
            double *loss = &choices->measured[kind].loss;
            *loss = status == TFA_OK ? fmax(*loss, loss_of(t, kernel, kind)) : (double)INFINITY;
        }
    }
}

/* ---- choosing ---- */

/* Of requests of two kinds together */
static int is_crba_better(struct self_test *t, const struct tfa_specialised_kernel *const *kernel,
                          int kind, int other, struct choices *c)
{
    double ratio;
    int turn = 0;
    do
        ratio = sqrt(time_ratio(t, kernel, kind, c->measured[kind].ns) *
                     time_ratio(t, kernel, other, c->measured[other].ns));
    while (++turn < REPETITIONS && fabs(ratio / FASTER - 1) < CLOSE);
    return fmax(c->measured[kind].loss, c->measured[other].loss) <= LOSS_MAX && ratio < FASTER;
}

/* In double one algorithm for a state alone and for batches: a state has the same bits in both. */
static void choose(struct self_test *t, tfa_workspace *exact,
                   const struct tfa_specialised_kernel *const *kernel, struct choices *c)
{
    measure_losses(t, exact, kernel, c);
    for (int kind = 0; kind < CHOICE_FORWARD_BATCH; kind++)
        if (is_crba_better(t, kernel, kind, kind + CHOICE_FORWARD_BATCH, c))
            c->algorithm[kind] = c->algorithm[kind + CHOICE_FORWARD_BATCH] = ALGORITHM_CRBA;
    for (int kind = CHOICE_FORWARD_BATCH_F32; kind < CHOICES; kind++)
        if (is_crba_better(t, kernel, kind, kind, c))
            c->algorithm[kind] = ALGORITHM_CRBA;
}

static const struct tfa_specialised_kernel *open_candidate(const char *path, const tfa_model *model,
                                                           void **object)
{
    struct error_text none = {NULL, 0};
    *object = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const struct tfa_specialised_kernel *k =
        *object ? dlsym(*object, TFA_SPECIALISED_SYMBOL) : NULL;
    return k && specialised_check_table(path, k, model, &none) == TFA_OK ? k : NULL;
}

int specialised_choose(const tfa_model *model, const char *const path[ALGORITHMS],
                       struct choices *choices)
{
    const tfa_workspace_options quadruple = {.precision = TFA_F128, .states = TFA_STATES_ONE};
    const struct tfa_specialised_kernel *kernel[ALGORITHMS];
    void *object[ALGORITHMS];
    tfa_workspace *exact = NULL;
    struct self_test t;
    int status = self_test_open(&t, model), complete = 1;
    if (status == TFA_OK)
        status = tfa_workspace_create(model, &quadruple, &exact);
    for (int a = 0; a < ALGORITHMS; a++) {
        kernel[a] = open_candidate(path[a], model, &object[a]);
        complete &= kernel[a] != NULL;
    }
    if (status == TFA_OK &&
        complete) /* what is wrong with them is said when the kernel is loaded */
        choose(&t, exact, kernel, choices);
    for (int a = 0; a < ALGORITHMS; a++)
        if (object[a])
            dlclose(object[a]);
    tfa_workspace_free(exact);
    self_test_close(&t);
    return status;
}

int specialised_same_bits(const tfa_model *model, const char *path)
{
    void *object;
    const struct tfa_specialised_kernel *kernel = open_candidate(path, model, &object);
    const int same = !kernel || self_test_same_bits(model, kernel);
    if (object)
        dlclose(object);
    return same;
}
