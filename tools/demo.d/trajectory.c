/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The demonstration: a simulated robot follows a torque trajectory at 1 kHz. Every millisecond its
 * accelerations come three ways, in process, over shared memory and over the DDS stream, and must
 * agree to the bit.
 *
 *   demo_trajectory ROBOT URDF fixed|floating SECONDS DDS_DOMAIN OUTPUT_PREFIX
 */
#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <totalforce/totalforce.h>

#include "dds_client/dds_client.h"
#include "latency/machine/pingpong.h"
#include "skeleton.h"

#define STEP_NS 1000000 /* 1 kHz */
#define TIMEOUT_NS 2000000000u
#define FRAME_STEPS 100 /* a stick figure is drawn every tenth of a second */

/* tau = ID(q, v, qdd_ref + KP (q_ref - q) + KD (v_ref - v)): computed torque, critically damped */
#define KP 100.0
#define KD 20.0

/* An error estimate is relative to |qdd|. Where the torques hold the robot still, qdd is itself the
 * rounding of two large forces that cancel, and the ratio says nothing. */
#define MOVING 1e-3

struct run {
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_client *shm;
    tfa_dds_client *dds;
    struct skeleton *skeleton;
    uint32_t nq, nv;
    int floating;
    double *q, *v, *tau, *desired, *qdd, *other;
    double pose[7], twist[6], wrench[6], acceleration[6], base_other[6];
    tfa_histogram via_shm, via_dds;
    uint64_t buckets[2][TFA_HISTOGRAM_BUCKETS(8, 64)];
    uint64_t steps, different, failed;
    double worst_estimate; /* while the robot accelerates: see MOVING */
    double worst_tracking;
    FILE *motion, *figures;
};

static double *numbers(size_t n)
{
    return calloc(n + 1, sizeof(double));
}

static int connect_all(struct run *r, const char *robot, uint32_t domain)
{
    const tfa_client_options shm = {.robot = robot, .wait = TFA_WAIT_SPIN};
    const tfa_dds_client_options dds = {
        .domain = domain, .robot = robot, .connect_timeout_ms = 20000};
    int status = tfa_client_connect(&shm, &r->shm);
    if (status != TFA_OK) {
        fprintf(stderr, "demo: shared memory: %s\n", tfa_status_text(status));
        return status;
    }
    status = tfa_dds_client_connect(&dds, &r->dds);
    if (status == TFA_OK)
        status = tfa_dds_stream_open(r->dds, 20000);
    if (status != TFA_OK)
        fprintf(stderr, "demo: DDS: %s\n", tfa_status_text(status));
    else if (strcmp(tfa_client_get_info(r->shm)->model_hash, tfa_model_hash_text(r->model)))
        fprintf(stderr, "demo: the daemon runs another model than %s\n", tfa_model_name(r->model));
    return status;
}

static int prepare(struct run *r, const char *urdf, int floating)
{
    const tfa_model_options options = {.base = floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
    int status = tfa_model_load(urdf, &options, NULL, &r->model);
    if (status == TFA_OK)
        status = tfa_workspace_create(r->model, NULL, &r->workspace);
    if (status != TFA_OK) {
        fprintf(stderr, "demo: %s: %s\n", urdf, tfa_status_text(status));
        return status;
    }
    r->nq = tfa_model_q_count(r->model);
    r->nv = tfa_model_v_count(r->model);
    r->floating = floating;
    r->q = numbers(r->nq);
    r->v = numbers(r->nv);
    r->tau = numbers(r->nv);
    r->desired = numbers(r->nv);
    r->qdd = numbers(r->nv);
    r->other = numbers(r->nv);
    r->pose[2] = 1;
    r->pose[6] = 1;
    r->skeleton = skeleton_load(urdf);
    return r->skeleton ? TFA_OK : TFA_E_FILE;
}

/* A smooth wave through all joints, each with its own phase; starts at rest at zero. */
static void reference(uint32_t joint, double t, double *q, double *v, double *a)
{
    double w = 2.0 + 0.1 * (joint % 5), size = 0.5 / (1 + joint % 3);
    double rise = t < 1 ? t * t * (3 - 2 * t) : 1;
    *q = size * rise * sin(w * t);
    *v = size * rise * w * cos(w * t);
    *a = -size * rise * w * w * sin(w * t);
}

/* The controller: torques that make the joints follow the reference. */
static int control(struct run *r, double t)
{
    double worst = 0;
    for (uint32_t j = 0; j < r->nv; j++) {
        double q, v, a;
        reference(j, t, &q, &v, &a);
        r->desired[j] = a + KP * (q - r->q[j]) + KD * (v - r->v[j]);
        worst = fmax(worst, fabs(q - r->q[j]));
    }
    if (t > 2)
        r->worst_tracking = fmax(r->worst_tracking, worst);
    tfa_request request = {.op = TFA_OP_INVERSE_DYNAMICS,
                           .count = 1,
                           .q = r->q,
                           .v = r->v,
                           .qdd = r->desired,
                           .base_pose = r->pose,
                           .base_twist = r->twist};
    tfa_reply reply = {.tau = r->tau, .base_wrench = r->wrench};
    int status = tfa_compute(r->workspace, &request, &reply);
    return status; /* the base wrench that holds the base still is applied to it too */
}

static tfa_request forward_request(const struct run *r)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .count = 1,
                         .estimate = TFA_ESTIMATE_ALWAYS,
                         .refine = TFA_REFINE_DEFAULT,
                         .q = r->q,
                         .v = r->v,
                         .tau = r->tau,
                         .base_pose = r->pose,
                         .base_twist = r->twist,
                         .base_wrench = r->wrench};
}

static void compare(struct run *r, const double *base)
{
    size_t bytes = r->nv * sizeof(double);
    int same = memcmp(r->qdd, r->other, bytes) == 0;
    if (r->floating)
        same &= memcmp(r->acceleration, base, sizeof r->acceleration) == 0;
    r->different += !same;
}

static void record_estimate(struct run *r, const tfa_answer *answer)
{
    double size = 0;
    for (uint32_t j = 0; j < r->nv; j++)
        size += r->qdd[j] * r->qdd[j];
    if (answer->flags & TFA_ANSWER_ESTIMATED && sqrt(size) > MOVING)
        r->worst_estimate = fmax(r->worst_estimate, answer->error_estimate);
}

static int call_shm(struct run *r, double *us)
{
    tfa_request request = forward_request(r);
    tfa_answer answer;
    tfa_reply reply = {.qdd = r->other, .base_acceleration = r->base_other, .answers = &answer};
    uint64_t start = clock_ns();
    int status = tfa_client_call(r->shm, &request, &reply, TIMEOUT_NS, NULL);
    uint64_t took = clock_ns() - start;
    tfa_histogram_add(&r->via_shm, took);
    *us = (double)took * 1e-3;
    if (status == TFA_OK) {
        compare(r, r->base_other);
        record_estimate(r, &answer);
    }
    return status;
}

static int call_dds(struct run *r, double *us)
{
    tfa_dds_torques torques = {.seq = r->steps, .q = r->q, .v = r->v, .tau = r->tau};
    if (r->floating) {
        torques.base_pose = r->pose;
        torques.base_twist = r->twist;
        torques.base_wrench = r->wrench;
    }
    tfa_dds_accelerations answer = {.qdd = r->other, .base_acceleration = r->base_other};
    uint64_t start = clock_ns();
    int status = tfa_dds_stream_publish(r->dds, &torques);
    do {
        if (status == TFA_OK)
            status = tfa_dds_stream_take(r->dds, &answer, TIMEOUT_NS);
    } while (status == TFA_OK && answer.seq < r->steps);
    uint64_t took = clock_ns() - start;
    tfa_histogram_add(&r->via_dds, took);
    *us = (double)took * 1e-3;
    if (status == TFA_OK)
        status = answer.status;
    if (status == TFA_OK)
        compare(r, r->base_other);
    return status;
}

/* Semi-implicit Euler. The base is held by the wrench that the controller computed: it stays. */
static void integrate(struct run *r)
{
    const double dt = STEP_NS * 1e-9;
    for (uint32_t j = 0; j < r->nv; j++) {
        r->v[j] += dt * r->qdd[j];
        r->q[j] += dt * r->v[j];
    }
}

static int step(struct run *r, double t)
{
    double shm_us = 0, dds_us = 0;
    int status = control(r, t);
    tfa_request request = forward_request(r);
    tfa_answer answer;
    tfa_reply reply = {.qdd = r->qdd, .base_acceleration = r->acceleration, .answers = &answer};
    if (status == TFA_OK)
        status = tfa_compute(r->workspace, &request, &reply);
    if (status == TFA_OK) {
        record_estimate(r, &answer);
        status = call_shm(r, &shm_us);
    }
    if (status == TFA_OK)
        status = call_dds(r, &dds_us);
    fprintf(r->motion, "%.3f %.3f %.3f", t, shm_us, dds_us);
    for (uint32_t j = 0; j < r->nv && j < 7; j++)
        fprintf(r->motion, " %.6f", r->q[j]);
    fputc('\n', r->motion);
    if (r->steps % FRAME_STEPS == 0)
        skeleton_draw(r->skeleton, r->model, r->q, r->figures);
    integrate(r);
    return status;
}

static int run_steps(struct run *r, double seconds)
{
    uint64_t due = clock_ns();
    const uint64_t count = (uint64_t)(seconds * 1e9 / STEP_NS);
    for (r->steps = 0; r->steps < count; r->steps++) {
        int status = step(r, (double)r->steps * STEP_NS * 1e-9);
        if (status != TFA_OK) {
            fprintf(stderr, "demo: step %lu: %s\n", (unsigned long)r->steps,
                    tfa_status_text(status));
            return status;
        }
        due += STEP_NS;
        struct timespec at = {(time_t)(due / 1000000000u), (long)(due % 1000000000u)};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
            ;
    }
    return TFA_OK;
}

static void print_line(const char *name, const tfa_histogram *h)
{
    printf("  %-22s p50 %7.1f us   p99 %7.1f us   max %8.1f us\n", name,
           (double)tfa_histogram_quantile(h, 0.5) * 1e-3,
           (double)tfa_histogram_quantile(h, 0.99) * 1e-3, (double)h->highest * 1e-3);
}

static void print(const struct run *r, const char *robot)
{
    printf("%s: %lu steps at 1 kHz, %u joints%s\n", robot, (unsigned long)r->steps, r->nv,
           r->floating ? " and a floating base" : "");
    print_line("shared memory call", &r->via_shm);
    print_line("DDS torque stream", &r->via_dds);
    printf("  in process, shared memory and DDS: %lu of %lu answers differ in any bit\n",
           (unsigned long)r->different, (unsigned long)(2 * r->steps));
    printf("  worst error estimate of qdd while it moves %.1e; tracking error after 2 s at most "
           "%.1e rad\n",
           r->worst_estimate, r->worst_tracking);
}

static FILE *open_output(const char *prefix, const char *what)
{
    char path[4096];
    snprintf(path, sizeof path, "%s_%s.dat", prefix, what);
    FILE *f = fopen(path, "w");
    if (!f)
        fprintf(stderr, "demo: %s: %s\n", path, strerror(errno));
    return f;
}

static int close_output(FILE *f)
{
    int bad = !f || ferror(f);
    if (f && fclose(f))
        bad = 1;
    if (bad)
        fprintf(stderr, "demo: output could not be written: %s\n", strerror(errno));
    return bad;
}

static void release(struct run *r)
{
    tfa_dds_client_close(r->dds);
    tfa_client_close(r->shm);
    skeleton_free(r->skeleton);
    tfa_workspace_free(r->workspace);
    tfa_model_free(r->model);
    free(r->q);
    free(r->v);
    free(r->tau);
    free(r->desired);
    free(r->qdd);
    free(r->other);
}

int main(int argc, char **argv)
{
    if (argc != 7) {
        fprintf(stderr, "usage: demo_trajectory ROBOT URDF fixed|floating SECONDS DDS_DOMAIN "
                        "OUTPUT_PREFIX\n");
        return 3;
    }
    uint64_t domain;
    double seconds;
    if (tfa_number_read(argv[4], strlen(argv[4]), &seconds) != TFA_NUMBER_OK ||
        tfa_whole_number_read(argv[5], strlen(argv[5]), &domain) != TFA_NUMBER_OK || domain > 230) {
        fprintf(stderr, "demo: %s seconds in domain %s: not two numbers\n", argv[4], argv[5]);
        return 3;
    }
    static struct run r; /* histograms are large */
    (void)!tfa_histogram_init(&r.via_shm, 8, 64, r.buckets[0]);
    (void)!tfa_histogram_init(&r.via_dds, 8, 64, r.buckets[1]);
    int status = prepare(&r, argv[2], strcmp(argv[3], "floating") == 0);
    if (status == TFA_OK)
        status = connect_all(&r, argv[1], (uint32_t)domain);
    r.motion = open_output(argv[6], "motion");
    r.figures = open_output(argv[6], "figures");
    if (status == TFA_OK && r.motion && r.figures) {
        status = run_steps(&r, seconds);
        print(&r, argv[1]);
    }
    int bad = close_output(r.motion) | close_output(r.figures);
    int different = r.different != 0 || r.steps == 0;
    release(&r);
    return status != TFA_OK || bad ? 2 : different;
}
