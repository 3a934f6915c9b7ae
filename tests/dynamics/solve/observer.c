/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The momentum observer of robots in motion, sampled at irregular times: after a step of external
 * torques it shows tau (1 - exp(- gain t)), begins anew after a gap, a step back in time or another
 * model, and explains a wrench at a link by that wrench.
 */
#include "models.h"
#include "support/step.h"
#include "test.h"

#include <float.h>
#include <math.h>
#include <string.h>
#include <totalforce/totalforce.h>

#define STEP 1e-4 /* s */
static const double gain = 40, step_at = 0.05, gap_at = 0.15, gap_end = 0.3,
                    end = 0.45; /* 1/s, s */
enum { N = 64, Q = 64 };

typedef struct motion {
    const char *name;
    tfa_model *model;
    tfa_workspace *w;
    tfa_observer *observer;
    uint32_t n, six;
    double q[Q], v[N], pose[7]; /* v: base first */
    double known[N];            /* torques that the observer is told */
    double external[N];         /* and those that it is not */
} motion;

static tfa_request state_of(const motion *x)
{
    return (tfa_request){.refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = x->q,
                         .v = x->v + x->six,
                         .base_pose = x->six ? x->pose : NULL,
                         .base_twist = x->six ? x->v : NULL};
}

static void answer(const motion *x, const tfa_request *r, tfa_reply *reply)
{
    if (tfa_compute(x->w, r, reply) != TFA_OK)
        fail_msg("%s: %s", x->name, tfa_status_text(reply->status));
}

/* Torques against gravity and velocities, so that only external ones accelerate */
static void hold(motion *x)
{
    tfa_request r = state_of(x);
    tfa_reply reply = {.tau = x->known + x->six, .base_wrench = x->six ? x->known : NULL};
    r.op = TFA_OP_INVERSE_DYNAMICS;
    answer(x, &r, &reply);
}

static void accelerate(const motion *x, double share, double *qdd)
{
    double tau[N];
    tfa_request r = state_of(x);
    tfa_reply reply = {.qdd = qdd + x->six, .base_acceleration = x->six ? qdd : NULL};
    for (uint32_t j = 0; j < x->n; j++)
        tau[j] = x->known[j] + share * x->external[j];
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.tau = tau + x->six;
    r.base_wrench = x->six ? tau : NULL;
    answer(x, &r, &reply);
}

/* The midpoint rule */
static void move(motion *x, double share)
{
    double qdd[N];
    accelerate(x, share, qdd);
    for (uint32_t j = 0; j < x->n; j++)
        x->v[j] += STEP / 2 * qdd[j];
    step_model(x->model, x->q, x->pose, x->v, STEP, x->q, x->pose);
    hold(x);
    accelerate(x, share, qdd);
    for (uint32_t j = 0; j < x->n; j++)
        x->v[j] += STEP / 2 * qdd[j];
    hold(x);
}

static tfa_observer_event observe_as(motion *x, double t, uint64_t model)
{
    tfa_request r, state = state_of(x);
    tfa_reply reply;
    tfa_observer_request(x->observer, &r, &reply);
    r.q = state.q;
    r.v = state.v;
    r.base_pose = state.base_pose;
    r.base_twist = state.base_twist;
    answer(x, &r, &reply);
    reply.model ^= model;
    return tfa_observer_update(x->observer, t, x->known + x->six, x->known, &reply);
}

static void check_torques(const motion *x, double t, double since, double *worst)
{
    const double *r = tfa_observer_torques(x->observer), share = 1 - exp(-gain * (t - since));
    double size = 0, error = 0;
    for (uint32_t j = 0; j < x->n; j++) {
        size = fmax(size, fabs(x->external[j]));
        error = fmax(error, fabs(r[j] - (t > since ? share * x->external[j] : 0)));
    }
    *worst = fmax(*worst, error / size);
}

/* External torques that accelerate each freedom by at most 2 where they begin */
static void open_motion(motion *x, const char *file, tfa_base base)
{
    static double M[N * N];
    const tfa_model_options options = {.base = base, .rotor_inertia = 1, .damping = 1};
    *x = (motion){
        .name = file, .model = bundled_model(file, &options), .pose = {0, 0, 1, 0, 0, 0, 1}};
    x->w = workspace_for(x->model, NULL);
    x->six = tfa_model_base_freedoms(x->model);
    x->n = x->six + tfa_model_v_count(x->model);
    assert_true(x->n <= N && tfa_model_q_count(x->model) <= Q);
    for (uint32_t j = 0; j < tfa_model_q_count(x->model); j++)
        x->q[j] = 0.4 * sin(1 + j);
    for (uint32_t j = 0; j < x->n; j++)
        x->v[j] = 0.5 * cos(2 + j);
    tfa_request r = state_of(x);
    tfa_reply reply = {.mass_matrix = M};
    r.op = TFA_OP_MASS_MATRIX;
    answer(x, &r, &reply);
    for (uint32_t i = 0; i < x->n; i++)
        for (uint32_t j = 0; j < x->n; j++)
            x->external[i] += M[(size_t)x->n * i + j] * 2 * sin(3 + 5 * j);
    const tfa_observer_options with = {.gain = gain, .max_gap = 0.1};
    assert_int_equal(tfa_observer_create(x->six, x->n - x->six, &with, &x->observer), TFA_OK);
    hold(x);
}

static void close_motion(motion *x)
{
    tfa_observer_free(x->observer);
    tfa_workspace_free(x->w);
    tfa_model_free(x->model);
}

/* A wrench at a link instead of torques: the observer's, given time, is that wrench. */
static void check_wrench(motion *x, double t)
{
    static const double push[6] = {30, -20, 10, 2, -3, 4};
    const uint32_t tip = tfa_model_frame_count(x->model) - 1;
    double tau[N] = {0}, found[6];
    tfa_request r = state_of(x);
    tfa_reply reply = {.external_force = tau};
    r.op = TFA_OP_BIAS;
    r.wrench_count = 1;
    r.wrench_frames[0] = tip;
    r.wrenches = push;
    answer(x, &r, &reply);
    /* at rest in place of known + J^T F */
    memset(x->v, 0, sizeof x->v);
    hold(x);
    for (uint32_t j = 0; j < x->n; j++)
        x->known[j] += tau[j];
    tfa_observer_restart(x->observer);
    for (int k = 0; k < 60; k++)
        (void)observe_as(x, t + k / gain, 0);
    tfa_observer_wrench_request(x->observer, tip, &r, &reply);
    r.q = x->q;
    r.base_pose = x->six ? x->pose : NULL;
    answer(x, &r, &reply);
    assert_int_equal(tfa_observer_wrench(x->observer, &reply, found), TFA_OK);
    for (int e = 0; e < 6 && reply.rank->lost == 0; e++)
        assert_true(fabs(found[e] - push[e]) < 1e-8);
}

static void law(const char *file, tfa_base base)
{
    motion x;
    double worst = 0, t = 0;
    uint32_t updates = 0, gaps = 0;
    open_motion(&x, file, base);
    double since = step_at;
    for (uint32_t k = 0, next = 0; t < end; k++) {
        t = k * STEP;
        const int silent = t > gap_at && t < gap_end;
        if (k >= next && !silent) {
            const tfa_observer_event event = observe_as(&x, t, 0);
            assert_int_equal(event, k == 0      ? TFA_OBSERVER_STARTED
                                    : next == 0 ? TFA_OBSERVER_GAP
                                                : TFA_OBSERVER_UPDATED);
            if (event == TFA_OBSERVER_GAP) {
                since = t;
                gaps++;
            }
            check_torques(&x, t, since, &worst);
            next = k + 1 + (k * 2654435761u >> 16) % 8;
            updates++;
        }
        if (silent)
            next = 0;
        move(&x, t >= step_at);
    }
    print_message("  %s: %u samples, error %.1e of the external torques\n", file, updates, worst);
    assert_true(gaps == 1 && worst < 1e-3);
    assert_int_equal(observe_as(&x, t + 1e-3, 0), TFA_OBSERVER_UPDATED);
    assert_int_equal(observe_as(&x, t + 1e-3, 0), TFA_OBSERVER_TIME);
    assert_int_equal(observe_as(&x, t + 2e-3, 1), TFA_OBSERVER_MODEL);
    assert_int_equal(observe_as(&x, t + 3e-3, 1), TFA_OBSERVER_UPDATED);
    check_wrench(&x, t + 1);
    close_motion(&x);
}

TEST(a_step_of_external_torques)
{
    law("arm7.urdf", TFA_BASE_FIXED);
    law("quadruped.urdf", TFA_BASE_FLOATING);
    law("humanoid.urdf", TFA_BASE_FLOATING);
}

TEST(what_is_not_finite)
{
    motion x;
    open_motion(&x, "arm7.urdf", TFA_BASE_FIXED);
    assert_int_equal(observe_as(&x, 0, 0), TFA_OBSERVER_STARTED);
    assert_int_equal(observe_as(&x, 1e-3, 0), TFA_OBSERVER_UPDATED);
    assert_int_equal(observe_as(&x, (double)NAN, 0), TFA_OBSERVER_INVALID);
    assert_true(tfa_observer_torques(x.observer)[0] == 0);
    assert_int_equal(observe_as(&x, 2e-3, 0), TFA_OBSERVER_STARTED);
    x.known[2] = (double)INFINITY;
    assert_int_equal(observe_as(&x, 3e-3, 0), TFA_OBSERVER_INVALID);
    tfa_reply refused = {.status = TFA_E_SIZE};
    assert_int_equal(tfa_observer_update(x.observer, 4e-3, NULL, NULL, &refused),
                     TFA_OBSERVER_INVALID);
    close_motion(&x);
}

TEST(options_out_of_range)
{
    static const tfa_observer_options bad[] = {{.gain = 0},
                                               {.gain = -1},
                                               {.gain = (double)NAN},
                                               {.gain = 10, .max_gap = -1},
                                               {.gain = 10, .max_gap = (double)INFINITY}};
    tfa_observer *o;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(tfa_observer_create(0, 3, &bad[k], &o), TFA_E_VALUE);
    assert_int_equal(tfa_observer_create(5, 3, &(tfa_observer_options){.gain = 1}, &o),
                     TFA_E_ARGUMENT);
    assert_int_equal(tfa_observer_create(0, 3, NULL, &o), TFA_E_ARGUMENT);
    assert_null(o);
}
