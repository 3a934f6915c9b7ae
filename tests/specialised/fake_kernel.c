/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A kernel to test the loading of kernels with: inverse dynamics of a fixed-base robot by the
 * plainest loop, and, with FAKE_KERNEL_FAULT, one that is wrong in a way of its own. Compiled as
 * dynamics/specialised/specialised.c.
 */
#include <math.h>
#include <string.h>

#include "interface/specialised_abi.h"
#include "robot_tables.h"

#ifdef ROBOT_BATCH_LANES /* what is compiled for lanes stays empty */

/* What is wrong with it */
#define FAULT_SOUND 0
#define FAULT_WRONG_ABI 1
#define FAULT_WRONG_SIZES 2
#define FAULT_WRONG_HASH 3
#define FAULT_WRONG_ISA 4
#define FAULT_NO_TABLE 5
#define FAULT_HALF_A_TABLE 6
#define FAULT_WRONG_ANSWER 7     /* one number of one body, by 1e-6 */
#define FAULT_WRONG_SEVERAL 8    /* right one at a time only */
#define FAULT_WRONG_RARELY 9     /* for some states only */
#define FAULT_TAKES_TOO_MUCH 10  /* and does not look at payloads */
#define FAULT_WRITES_TOO_MUCH 11 /* behind the end of tau */
#define FAULT_NEVER_ANSWERS 12
#define FAULT_LEAVES_A_HOLE 13 /* a number is not one */
#define FAULT_WRONG_FLOATS 14  /* right in double only */
#define FAULT_HALF_OF_FLOATS 15
#define FAULT_IGNORES_WRENCHES 16
#define FAULT_OTHER_WHEN_FUSED 17 /* several at a time have other bits if products are fused */
#ifndef FAKE_KERNEL_FAULT
#define FAKE_KERNEL_FAULT FAULT_SOUND
#endif

#define STRING_EXPAND(x) #x
#define STRING(x) STRING_EXPAND(x)

typedef struct vec {
    double x, y, z;
} vec;

static vec add(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static vec times(double s, vec a)
{
    return (vec){s * a.x, s * a.y, s * a.z};
}
static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vec to_child(const double E[9], vec a)
{
    return (vec){E[0] * a.x + E[1] * a.y + E[2] * a.z, E[3] * a.x + E[4] * a.y + E[5] * a.z,
                 E[6] * a.x + E[7] * a.y + E[8] * a.z};
}
static vec to_parent(const double E[9], vec a)
{
    return (vec){E[0] * a.x + E[3] * a.y + E[6] * a.z, E[1] * a.x + E[4] * a.y + E[7] * a.z,
                 E[2] * a.x + E[5] * a.y + E[8] * a.z};
}
static vec inertia_times(const double I[6], vec w)
{
    return (vec){I[0] * w.x + I[1] * w.y + I[2] * w.z, I[1] * w.x + I[3] * w.y + I[4] * w.z,
                 I[2] * w.x + I[4] * w.y + I[5] * w.z};
}

/* Motion of a body's frame, and force and moment that its joint carries; in the body's frame */
struct body {
    double E[9];
    vec r, w, dw, a, force, moment;
};

/* Rotation from the parent at q, row major */
static void rotate(const struct tfa_body *b, double s, double c, double E[9])
{
    for (int k = 0; k < 3; k++) {
        E[k] = c * b->E[k] + s * b->E[3 + k];
        E[3 + k] = -s * b->E[k] + c * b->E[3 + k];
        E[6 + k] = b->E[6 + k];
    }
}

static void transform_motion(const double *g, struct body *all, uint32_t i, double q, double qd,
                             double qdd)
{
    const struct tfa_body *b = &robot_body[i];
    struct body *me = &all[i], still = {.a = {-g[0], -g[1], -g[2]}};
    const struct body *p = b->parent < 0 ? &still : &all[b->parent];
    const int slides = b->kind == TFA_KIND_PRISMATIC;
    rotate(b, slides ? 0 : sin(q), slides ? 1 : cos(q), me->E);
    me->r = (vec){b->r[0], b->r[1], b->r[2]};
    if (slides)
        me->r = add(me->r, to_parent(me->E, (vec){0, 0, q}));
    const vec lever = add(cross(p->dw, me->r), cross(p->w, cross(p->w, me->r)));
    const vec w = to_child(me->E, p->w), z = {0, 0, 1};
    me->w = slides ? w : add(w, times(qd, z));
    me->dw = to_child(me->E, p->dw);
    me->a = to_child(me->E, add(p->a, lever));
    if (slides)
        me->a = add(me->a, add(times(qdd, z), times(2 * qd, cross(w, z))));
    else
        me->dw = add(me->dw, add(times(qdd, z), cross(w, times(qd, z))));
}

static void load(struct body *me, const struct tfa_body *b)
{
    const vec h = {b->h[0], b->h[1], b->h[2]};
    me->force = add(times(b->mass, me->a), add(cross(me->dw, h), cross(me->w, cross(me->w, h))));
    me->moment = add(inertia_times(b->I, me->dw),
                     add(cross(me->w, inertia_times(b->I, me->w)), cross(h, me->a)));
}

static double freedom(const double *array, uint32_t k, uint32_t v)
{
    return array ? robot_freedom[v].multiplier *
                       array[(size_t)ROBOT_V_COUNT * k + robot_freedom[v].from]
                 : 0;
}

static uint32_t solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                      tfa_reply *reply)
{
    struct body all[ROBOT_BODIES] = {0};
    if (FAKE_KERNEL_FAULT == FAULT_NEVER_ANSWERS)
        return 0;
    for (uint32_t i = 0; i < ROBOT_BODIES; i++) {
        const uint32_t v = robot_body[i].v;
        const struct tfa_coordinate *c = &robot_coordinate[robot_body[i].q];
        transform_motion(host->model->gravity, all, i,
                         c->multiplier * r->q[(size_t)ROBOT_Q_COUNT * k + c->from] + c->offset,
                         freedom(r->v, k, v), freedom(r->qdd, k, v));
        load(&all[i], &robot_body[i]);
    }
    double *tau = reply->tau + (size_t)ROBOT_V_COUNT * k;
    for (uint32_t i = ROBOT_BODIES; i-- > 0;) {
        const struct tfa_body *b = &robot_body[i];
        const uint32_t v = b->v, to = robot_freedom[v].from;
        tau[to] = (b->kind == TFA_KIND_PRISMATIC ? all[i].force.z : all[i].moment.z) +
                  robot_armature[v] * freedom(r->qdd, k, v);
        if (ROBOT_DAMPED)
            tau[to] += robot_damping[v] * freedom(r->v, k, v);
        if (ROBOT_HAS_FRICTION)
            tau[to] += robot_friction[v] * freedom(r->v, k, v) /
                       hypot(freedom(r->v, k, v), robot_friction_velocity);
        if (b->parent < 0)
            continue;
        struct body *p = &all[b->parent];
        const vec f = to_parent(all[i].E, all[i].force);
        p->force = add(p->force, f);
        p->moment = add(p->moment, add(to_parent(all[i].E, all[i].moment), cross(all[i].r, f)));
    }
    if (FAKE_KERNEL_FAULT == FAULT_WRONG_ANSWER)
        tau[0] *= 1 + 1e-6;
    if (FAKE_KERNEL_FAULT == FAULT_WRONG_RARELY && k == 41)
        tau[ROBOT_V_COUNT - 1] += 1;
    if (FAKE_KERNEL_FAULT == FAULT_WRITES_TOO_MUCH)
        tau[ROBOT_V_COUNT] = 0;
    if (FAKE_KERNEL_FAULT == FAULT_LEAVES_A_HOLE)
        tau[0] = (double)NAN;
    return 1;
}

/* By what is left of a product that was rounded once only */
static int products_are_fused(void)
{
    const volatile double a = 1 + 0x1p-30;
    const volatile double rounded = a * a;
    return a * a - rounded != 0;
}

static uint32_t solve_batch(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                            uint32_t count, tfa_reply *reply)
{
    uint32_t done = 0;
    for (uint32_t l = 0; l < count; l++)
        done |= solve(host, r, k + l, reply) << l;
    if (FAKE_KERNEL_FAULT == FAULT_WRONG_SEVERAL)
        reply->tau[(size_t)ROBOT_V_COUNT * k] += 1;
    if (FAKE_KERNEL_FAULT == FAULT_OTHER_WHEN_FUSED)
        reply->tau[(size_t)ROBOT_V_COUNT * k] += 1e-14 * products_are_fused();
    return done;
}

static uint32_t solve_batch_f32(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                                uint32_t count, tfa_reply *reply)
{
    const uint32_t done = solve_batch(host, r, k, count, reply);
    if (FAKE_KERNEL_FAULT == FAULT_WRONG_FLOATS)
        reply->tau[(size_t)ROBOT_V_COUNT * (k + count - 1)] += 1;
    return done;
}

static int supports(const struct tfa_host_api *host, const tfa_request *r)
{
    (void)host;
    return r->op == TFA_OP_INVERSE_DYNAMICS && !r->gravity && !r->locked_count &&
           (FAKE_KERNEL_FAULT == FAULT_IGNORES_WRENCHES || !r->wrench_count) &&
           (FAKE_KERNEL_FAULT == FAULT_TAKES_TOO_MUCH || !r->payload_count);
}

__attribute__((visibility("default"))) const struct tfa_specialised_kernel
#if FAKE_KERNEL_FAULT == FAULT_NO_TABLE
    another_name
#else
    tfa_specialised_kernel
#endif
    = {
        .abi = FAKE_KERNEL_FAULT == FAULT_WRONG_ABI ? TFA_SPECIALISED_ABI + 1 : TFA_SPECIALISED_ABI,
        .request_bytes = sizeof(tfa_request) + (FAKE_KERNEL_FAULT == FAULT_WRONG_SIZES ? 8 : 0),
        .reply_bytes = sizeof(tfa_reply),
        .model_bytes = sizeof(struct tfa_model),
#if FAKE_KERNEL_FAULT != FAULT_WRONG_HASH
        .model = ROBOT_HASH,
#endif
        .isa = FAKE_KERNEL_FAULT == FAULT_WRONG_ISA ? "vax" : STRING(TFA_ISA_NAME),
        .compiler = __VERSION__,
        .algorithms = "inverse rnea",
        .bodies = ROBOT_BODIES,
        .lanes = 4,
        .lanes_f32 = 8,
        .supports = supports,
        .supports_f32 = FAKE_KERNEL_FAULT == FAULT_HALF_OF_FLOATS ? NULL : supports,
        .solve_batch_f32 = solve_batch_f32,
        .solve = FAKE_KERNEL_FAULT == FAULT_HALF_A_TABLE ? NULL : solve,
        .solve_batch = solve_batch,
};
#endif
