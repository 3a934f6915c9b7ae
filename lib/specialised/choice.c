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
#define BATCH_TIPS_BODIES_MAX 16

/* It is taken if it is faster by this and no less accurate (root mean square over the states,
 * relative to quadruple precision). */
#define FASTER 0.97
#define ERROR_RATIO_MAX 2
#define ERROR_MIN 2e-16
#define ROUNDS 40

static const char *const algorithms[ALGORITHMS] = {"aba", "crba"};

static const struct {
    const char *macro, *name, *function, *variant; /* tfa_robot_FUNCTION_VARIANT_ALGORITHM */
    tfa_op op;
    uint32_t tips, batch;
} kinds[CHOICES] = {
    [CHOICE_FORWARD] = {"ROBOT_FORWARD_ONE", "forward", "forward", "scalar",
                        TFA_OP_FORWARD_DYNAMICS, 0, 0},
    [CHOICE_LAMBDA] = {"ROBOT_LAMBDA_ONE", "lambda", "lambda", "scalar", TFA_OP_OPERATIONAL_INERTIA,
                       1, 0},
    [CHOICE_FORWARD_LAMBDA] = {"ROBOT_FORWARD_LAMBDA_ONE", "forward+lambda", "forward_lambda",
                               "scalar", TFA_OP_FORWARD_DYNAMICS, 1, 0},
    [CHOICE_FORWARD_BATCH] = {"ROBOT_FORWARD_BATCH", "batch forward", "forward", "batch",
                              TFA_OP_FORWARD_DYNAMICS, 0, 1},
    [CHOICE_LAMBDA_BATCH] = {"ROBOT_LAMBDA_BATCH", "batch lambda", "lambda", "batch",
                             TFA_OP_OPERATIONAL_INERTIA, 1, 1},
    [CHOICE_FORWARD_LAMBDA_BATCH] = {"ROBOT_FORWARD_LAMBDA_BATCH", "batch forward+lambda",
                                     "forward_lambda", "batch", TFA_OP_FORWARD_DYNAMICS, 1, 1},
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
    if ((forward && !lanes && m->bodies > UNROLLED_BODIES_MAX) ||
        (kinds[kind].batch && kinds[kind].tips && m->bodies > BATCH_TIPS_BODIES_MAX))
        text_append(t, "tfa_robot_none\n");
    else if (kind == CHOICE_FORWARD && lanes && algorithm == ALGORITHM_ABA)
        text_append(t, "tfa_robot_forward_body_lanes_aba\n");
    else if (kind == CHOICE_FORWARD_LAMBDA && lanes && algorithm == ALGORITHM_ABA)
        text_append(t, "tfa_robot_two_passes\n");
    else
        text_append(t, "tfa_robot_%s_%s_%s\n", kinds[kind].function, kinds[kind].variant, name);
}

void specialised_choice_write(struct text_buffer *t, const tfa_model *m,
                              const uint8_t choice[CHOICES])
{
    text_append(t, "/* Which function of a kernel answers; written by totalforce. */\n");
    for (int k = 0; k < CHOICES; k++)
        write_function(t, m, k, choice[k]);
    text_append(t,
                "#define ROBOT_INVERSE_ONE tfa_robot_inverse_scalar_aba\n"
                "#define ROBOT_INVERSE_BATCH tfa_robot_inverse_batch_aba\n"
                "#define ROBOT_INVERSE_PAYLOADS tfa_robot_inverse_payloads_aba\n"
                "#define ROBOT_FORWARD_PAYLOADS %s\n#define ROBOT_ALGORITHMS \"",
                m->bodies > UNROLLED_BODIES_MAX ? "tfa_robot_none"
                                                : "tfa_robot_forward_payloads_aba");
    for (int k = 0; k < CHOICES; k++)
        text_append(t, "%s%s %s", k ? ", " : "", kinds[k].name, algorithms[choice[k]]);
    text_append(t, "\"\n");
}

/* ---- time and error of a candidate ---- */

struct measured {
    double ns, error; /* of a state; infinite: it does not answer */
};

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Computes all states; returns whether all have answers. */
static int run_states(struct self_test *t, const struct tfa_specialised_kernel *kernel, int kind)
{
    const uint32_t lanes = kinds[kind].batch ? kernel->lanes : 0, count = t->request.count;
    int answered = 1;
    for (uint32_t k = 0; k < count && !lanes; k++)
        answered &= kernel->solve(&t->host, &t->request, k, &t->tested.reply) != 0;
    for (uint32_t k = 0; lanes && k < count; k += lanes)
        answered &=
            kernel->solve_batch(&t->host, &t->request, k, count - k < lanes ? count - k : lanes,
                                &t->tested.reply) != 0;
    return answered;
}

/* Root mean square over the states of |x - exact| / |exact|, largest entries */
static double relative_error(const double *x, const double *exact, size_t n, uint32_t states)
{
    double sum = 0;
    for (uint32_t k = 0; k < states; k++, x += n, exact += n) {
        double most = 0, size = 0;
        for (size_t e = 0; e < n; e++) {
            most = fmax(most, fabs(x[e] - exact[e]));
            size = fmax(size, fabs(exact[e]));
        }
        sum += size > 0 ? most / size * (most / size) : 0;
    }
    return sqrt(sum / states);
}

static double error_of(const struct self_test *t, int kind)
{
    const uint32_t states = t->request.count;
    const tfa_reply *x = &t->tested.reply, *exact = &t->reference.reply;
    double error = 0;
    if (kinds[kind].op == TFA_OP_FORWARD_DYNAMICS)
        error = relative_error(x->qdd, exact->qdd, t->model->v_count, states);
    if (kinds[kind].tips)
        error = fmax(error, relative_error(x->lambda_inv, exact->lambda_inv, 36, states));
    return error;
}

/* Least time of all rounds, in which the candidates take turns */
static void measure_kind(struct self_test *t, tfa_workspace *exact,
                         const struct tfa_specialised_kernel *const kernel[ALGORITHMS], int kind,
                         struct measured m[ALGORITHMS])
{
    const struct self_test_case q = {
        "", kinds[kind].op, kinds[kind].tips, TFA_FRAME_LOCAL_WORLD_ALIGNED, 0, 0};
    self_test_request(t, &q, t->model->bodies - 1);
    t->request.count = SELF_TEST_STATES;
    for (int a = 0; a < ALGORITHMS; a++)
        m[a] = (struct measured){(double)INFINITY, (double)INFINITY};
    if (tfa_compute(exact, &t->request, &t->reference.reply) != TFA_OK)
        return;
    for (int round = 0; round < ROUNDS; round++)
        for (int a = 0; a < ALGORITHMS; a++) {
            if (!kernel[a]->supports(&t->host, &t->request) ||
                (kinds[kind].batch && !kernel[a]->lanes))
                continue;
            const double start = now_ns();
            if (!run_states(t, kernel[a], kind))
                continue;
            m[a].ns = fmin(m[a].ns, (now_ns() - start) / SELF_TEST_STATES);
            m[a].error = error_of(t, kind);
        }
}

/* ---- choosing ---- */

static void choose(struct self_test *t, tfa_workspace *exact,
                   const struct tfa_specialised_kernel *const kernel[ALGORITHMS],
                   uint8_t choice[CHOICES])
{
    for (int kind = 0; kind < CHOICES; kind++) {
        struct measured m[ALGORITHMS];
        measure_kind(t, exact, kernel, kind, m);
        const struct measured *aba = &m[ALGORITHM_ABA], *crba = &m[ALGORITHM_CRBA];
        if (crba->ns < FASTER * aba->ns &&
            crba->error <= ERROR_RATIO_MAX * fmax(aba->error, ERROR_MIN))
            choice[kind] = ALGORITHM_CRBA;
    }
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
                       uint8_t choice[CHOICES])
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
        choose(&t, exact, kernel, choice);
    for (int a = 0; a < ALGORITHMS; a++)
        if (object[a])
            dlclose(object[a]);
    tfa_workspace_free(exact);
    self_test_close(&t);
    return status;
}
