/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Held joints: time against true error against certificate. A unit torque acts on one joint of a
 * robot that is in balance otherwise; joints near it are free, the others are held; then the same
 * with the joints that a tolerance allows. Errors in the energy norm, relative; the truth is the
 * quadruple-precision answer. CPU time of one thread, median over repetitions.
 *
 *   bench_hold [--repetitions N] [HUMANOID.urdf] > hold.csv
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "timing.h"

#define LINKS 512
#define SLICE_NS 1e6
#define PUSHED "left_elbow_joint" /* of the humanoid */

struct subject {
    const char *name;
    tfa_model *model;
    tfa_workspace *f64, *f128;
    uint32_t n, nb, joints; /* rows of M, freedoms of the base, joints */
    uint32_t pushed;        /* joint that the torque acts on */
    double *q, *tau, *exact, *mass, *answer, *scratch;
    double pose[7], base_wrench[6];
    uint32_t *nearest; /* joints, the pushed one first */
    double aba_ns;
};

/* ---- chains ---- */

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

static void random_rotation(double quat[4])
{
    double n = 0;
    for (int k = 0; k < 4; k++) {
        quat[k] = uniform();
        n += quat[k] * quat[k];
    }
    for (int k = 0; k < 4; k++)
        quat[k] /= sqrt(n);
}

/* Uniform rods of 1 m, 1 kg, radius 0.1 m. Planar: all axes parallel, rods across them. */
static tfa_model *make_chain(int planar)
{
    static tfa_link links[LINKS + 1];
    static tfa_joint joints[LINKS];
    static char names[LINKS + 1][8];
    const double along = 0.1 * 0.1 / 2, across = (3 * 0.1 * 0.1 + 1) / 12;
    for (int i = 0; i <= LINKS; i++) {
        snprintf(names[i], sizeof names[i], "l%d", i);
        links[i] = (tfa_link){.name = names[i],
                              .mass = 1,
                              .com = {0.5, 0, 0},
                              .quat = {0, 0, 0, 1},
                              .inertia = {along, 0, 0, across, 0, across}};
    }
    for (int i = 0; i < LINKS; i++) {
        joints[i] = (tfa_joint){.name = names[i + 1],
                                .type = TFA_JOINT_CONTINUOUS,
                                .parent = (uint32_t)i,
                                .child = (uint32_t)i + 1,
                                .xyz = {i > 0, 0, 0},
                                .quat = {0, 0, 0, 1},
                                .axis = {0, 0, 1},
                                .mimic = -1};
        if (!planar)
            random_rotation(joints[i].quat);
    }
    const tfa_description d = {.name = "chain",
                               .links = links,
                               .link_count = LINKS + 1,
                               .joints = joints,
                               .joint_count = LINKS};
    tfa_model *model = NULL;
    return tfa_model_create(&d, NULL, NULL, &model) == TFA_OK ? model : NULL;
}

/* ---- a subject in balance, pushed ---- */

/* The number of joints between the pushed one and each, by counting up the tree from both. */
static uint32_t distance(const struct subject *s, uint32_t joint)
{
    int32_t a = (int32_t)tfa_model_joint(s->model, s->pushed).body;
    int32_t b = (int32_t)tfa_model_joint(s->model, joint).body;
    uint32_t steps = 0;
    while (a != b) { /* parents have the lower index */
        if (a > b)
            a = tfa_model_body_parent(s->model, (uint32_t)a);
        else
            b = tfa_model_body_parent(s->model, (uint32_t)b);
        steps++;
    }
    return steps;
}

static const struct subject *sorted;

static int by_distance(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    const uint32_t dx = distance(sorted, x), dy = distance(sorted, y);
    return dx != dy ? (dx > dy) - (dx < dy) : (x > y) - (x < y);
}

static tfa_request plain(const struct subject *s)
{
    static const double weightless[3] = {0, 0, 0};
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .count = 1,
                         .refine = TFA_REFINE_DEFAULT,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .q = s->q,
                         .tau = s->tau,
                         .gravity = s->nb ? NULL : weightless,
                         .base_pose = s->pose,
                         .base_wrench = s->base_wrench};
}

static void solve(struct subject *s, tfa_workspace *w, const tfa_request *r, double *out,
                  tfa_certificate *certificate)
{
    tfa_reply reply = {.qdd = out + s->nb, .base_acceleration = out, .certificate = certificate};
    if (tfa_compute(w, r, &reply) != TFA_OK)
        fprintf(stderr, "%s: %s\n", s->name, tfa_status_text(reply.status));
}

static void find_truth(struct subject *s)
{
    tfa_request r = plain(s);
    solve(s, s->f128, &r, s->exact, NULL);
    r.op = TFA_OP_MASS_MATRIX;
    tfa_reply reply = {.mass_matrix = s->mass};
    if (tfa_compute(s->f128, &r, &reply) != TFA_OK)
        fprintf(stderr, "%s: %s\n", s->name, tfa_status_text(reply.status));
}

static void balance(struct subject *s)
{
    tfa_request r = plain(s);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    tfa_reply reply = {.tau = s->tau, .base_wrench = s->base_wrench};
    if (s->nb && tfa_compute(s->f64, &r, &reply) != TFA_OK)
        fprintf(stderr, "%s: %s\n", s->name, tfa_status_text(reply.status));
    s->tau[s->pushed] += 1;
}

static int open_subject(struct subject *s, const char *name, tfa_model *model, uint32_t pushed)
{
    const tfa_workspace_options quad = {.precision = TFA_F128};
    *s = (struct subject){.name = name, .model = model, .pushed = pushed};
    if (!model || tfa_workspace_create(model, NULL, &s->f64) != TFA_OK ||
        tfa_workspace_create(model, &quad, &s->f128) != TFA_OK)
        return -1;
    s->nb = tfa_model_base_freedoms(model);
    s->joints = tfa_model_joint_count(model);
    s->n = s->nb + s->joints; /* one freedom each */
    s->q = calloc(s->n, sizeof(double));
    s->tau = calloc(s->n, sizeof(double));
    s->exact = calloc(s->n, sizeof(double));
    s->answer = calloc(s->n, sizeof(double));
    s->scratch = calloc(s->n, sizeof(double));
    s->mass = calloc((size_t)s->n * s->n, sizeof(double));
    s->nearest = calloc(s->joints, sizeof(uint32_t));
    s->pose[6] = 1;
    for (uint32_t k = 0; k < s->joints; k++) {
        s->q[k] = uniform();
        s->nearest[k] = k;
    }
    sorted = s;
    qsort(s->nearest, s->joints, sizeof *s->nearest, by_distance);
    balance(s);
    find_truth(s);
    return 0;
}

static void close_subject(struct subject *s)
{
    tfa_workspace_free(s->f64);
    tfa_workspace_free(s->f128);
    tfa_model_free(s->model);
    free(s->q);
    free(s->tau);
    free(s->exact);
    free(s->answer);
    free(s->scratch);
    free(s->mass);
    free(s->nearest);
}

/* ---- measuring ---- */

static double energy(const struct subject *s, const double *x)
{
    double sum = 0;
    for (uint32_t i = 0; i < s->n; i++)
        for (uint32_t j = 0; j < s->n; j++)
            sum += x[i] * s->mass[(size_t)i * s->n + j] * x[j];
    return sqrt(sum);
}

static double true_error(struct subject *s)
{
    for (uint32_t k = 0; k < s->n; k++)
        s->scratch[k] = s->answer[k] - s->exact[k];
    return energy(s, s->scratch) / energy(s, s->exact);
}

/* ns a call. q changes in the last bit from call to call, so that nothing is kept from before. */
static double time_of(struct subject *s, const tfa_request *r, size_t repetitions)
{
    double *samples = calloc(repetitions, sizeof *samples);
    const double q = s->q[0];
    tfa_certificate c;
    double median;
    for (size_t k = 0; k < repetitions; k++) {
        const double start = cpu_ns();
        size_t calls = 0;
        do {
            s->q[0] = calls % 2 ? q : nextafter(q, 2);
            solve(s, s->f64, r, s->answer, &c);
            calls++;
        } while (cpu_ns() - start < SLICE_NS);
        samples[k] = (cpu_ns() - start) / (double)calls;
    }
    s->q[0] = q;
    qsort(samples, repetitions, sizeof *samples, by_value);
    median = samples[repetitions / 2];
    free(samples);
    return median;
}

static void report(struct subject *s, const char *kind, tfa_request *r, size_t repetitions)
{
    tfa_certificate certificate;
    r->flags = 0;
    const double ns = time_of(s, r, repetitions);
    solve(s, s->f64, r, s->answer, &certificate);
    const double error = true_error(s);
    r->flags = TFA_WANT_CERTIFICATE;
    const double certified = time_of(s, r, repetitions);
    solve(s, s->f64, r, s->answer, &certificate);
    printf("%s,%s,%g,%u,%u,%.0f,%.0f,%.3f,%.3f,%.6e,%.6e\n", s->name, kind, r->tolerance, s->joints,
           certificate.held, ns, certified, ns / s->aba_ns, certified / s->aba_ns, error,
           certificate.relative);
    fflush(stdout);
}

static void measure(struct subject *s, size_t repetitions)
{
    static const double tolerances[] = {0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 1e-3, 1e-4, 1e-6};
    tfa_request r = plain(s);
    s->aba_ns = time_of(s, &r, repetitions);
    solve(s, s->f64, &r, s->answer, NULL);
    printf("%s,aba,0,%u,0,%.0f,%.0f,1,1,%.6e,0\n", s->name, s->joints, s->aba_ns, s->aba_ns,
           true_error(s));
    for (uint32_t free_joints = 1; free_joints < s->joints; free_joints += 1 + free_joints / 4) {
        r = plain(s);
        r.hold = TFA_HOLD_GIVEN;
        r.held = s->nearest + free_joints;
        r.held_count = s->joints - free_joints;
        report(s, "given", &r, repetitions);
    }
    for (size_t k = 0; k < sizeof tolerances / sizeof *tolerances; k++) {
        r = plain(s);
        r.hold = TFA_HOLD_AUTO;
        r.tolerance = tolerances[k];
        report(s, "auto", &r, repetitions);
    }
}

static tfa_model *load_humanoid(const char *path, uint32_t *pushed)
{
    const tfa_model_options options = {.base = TFA_BASE_FLOATING};
    tfa_model *model = NULL;
    if (tfa_model_load(path, &options, NULL, &model) != TFA_OK)
        return NULL;
    *pushed = (uint32_t)tfa_model_find_joint(model, PUSHED);
    return model;
}

int main(int argc, char **argv)
{
    const char *path = "config/robots/humanoid.urdf";
    size_t repetitions = 15;
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--repetitions") == 0 && k + 1 < argc)
            repetitions = (size_t)atoi(argv[++k]);
        else
            path = argv[k];
    }
    puts("mechanism,kind,tolerance,joints,held,ns,ns_certified,time_over_aba,certified_over_aba,"
         "true,certificate");
    for (int k = 0; k < 3; k++) {
        static const char *const names[] = {"planar 512", "3-D 512", "humanoid"};
        uint32_t pushed = LINKS / 2;
        tfa_model *model = k < 2 ? make_chain(k == 0) : load_humanoid(path, &pushed);
        struct subject s;
        if (open_subject(&s, names[k], model, pushed) != 0) {
            fprintf(stderr, "%s: cannot be made\n", names[k]);
            return 2;
        }
        measure(&s, repetitions);
        close_subject(&s);
    }
    return 0;
}
