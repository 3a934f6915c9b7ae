/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_close_loops: Newton iterations by impacts, damped by halving (Dennis and Schnabel 1996, 6.3).
 */
#include <math.h>
#include <string.h>
#include <totalforce/close_loops.h>
#include <totalforce/configuration.h>

#include "engine/methods.h"
#include "engine/workspace.h"
#include "model/model.h"

#define LARGEST_TURN 0.5 /* of an angle in one step, rad */
#define MOST_HALVINGS 8
#define VELOCITY_ROUNDS 3
/* What holds a measured base: its mass, relative to the robot's. A base that moved by the inverse
 * of it is put back, and the next iteration counts on that. */
#define BASE_MASS 1e16

struct search {
    tfa_workspace *w;
    const struct tfa_model *m;
    tfa_request impact;
    tfa_loop_options options;
    tfa_posture *posture;
    double *next, *step; /* base_twist and v: of the impact, of the step under way */
    double merit;        /* sum of squares at the last posture that was accepted */
    double error[6 * TFA_MAX_CONSTRAINTS];
    double base_mass[TFA_PAYLOAD_NUMBERS];
    tfa_rank rank;
};

/* ---- one impact ---- */

static void hold_base(struct search *x)
{
    const double mass = BASE_MASS * fmax(x->m->summary.moving_mass, 1);
    const double inertia = mass * x->m->length * x->m->length;
    const double numbers[TFA_PAYLOAD_NUMBERS] = {mass, 0, 0, 0, inertia, 0, 0, inertia, 0, inertia};
    memcpy(x->base_mass, numbers, sizeof numbers);
    x->impact.payload_count = 1;
    x->impact.payload_frames[0] = x->m->body[0].link;
    x->impact.payloads = x->base_mass;
}

/* The next velocities, of this impact, and the errors before it */
static int collide(struct search *x, int of_velocity)
{
    tfa_reply reply = {.v = x->next + 6, .base_twist = x->next, .rank = &x->rank};
    *(of_velocity ? &reply.constraint_velocity : &reply.constraint_position) = x->error;
    if (tfa_compute(x->w, &x->impact, &reply) != TFA_OK) {
        x->posture->field = reply.field;
        x->posture->index = reply.index;
    }
    return reply.status;
}

/* 1: nothing that is free moves the rows. Their eigenvalues are all rounding then, or those of the
 * mass at a measured base, far below the inverse of the robot's mass. */
static int is_stuck(const struct search *x)
{
    const double sum = x->rank.threshold / *x->impact.rank_threshold;
    return sum * fmax(x->m->summary.moving_mass, 1) < 1 / sqrt(BASE_MASS);
}

/* Sum of squares of the held rows, with a radian as a length of the robot. `*largest` gets the
 * largest one, `*worst` the constraint that has it. */
static double merit_of(const struct search *x, double *largest, uint32_t *worst)
{
    const double *error = x->error;
    double sum = 0;
    *largest = 0;
    *worst = 0;
    for (uint32_t k = 0; k < x->m->constraints; k++) {
        if (!(x->impact.constraints >> k & 1))
            continue;
        for (uint32_t e = 0; e < 6; e++) {
            const double one = x->m->closure[k].rows >> e & 1 ? error[e] : 0;
            const double scaled = e < 3 ? one : one * x->m->length;
            sum += scaled * scaled;
            if (fabs(one) > *largest) {
                *largest = fabs(one);
                *worst = k;
            }
        }
        error += 6;
    }
    return sum;
}

/* ---- posture ---- */

/* Share of a step that turns no angle too far */
static double share_of(const struct search *x)
{
    double turn = 0;
    for (uint32_t k = 0; k < x->m->joints; k++) {
        const tfa_joint_info *joint = &x->m->joint[k];
        const uint32_t lengths = tfa_joint_type_describe(joint->type).lengths;
        for (uint32_t e = lengths; e < joint->v_count; e++)
            turn = fmax(turn, fabs(x->step[6 + joint->v_index + e]));
    }
    for (uint32_t e = 3; x->options.base_is_free && e < 6; e++)
        turn = fmax(turn, fabs(x->step[e]));
    return turn > LARGEST_TURN ? LARGEST_TURN / turn : 1;
}

static void move(struct search *x, double share)
{
    tfa_integrate(x->m, x->step + 6, x->options.base_is_free ? x->step : NULL, share, x->posture->q,
                  x->posture->base_pose);
}

/* Iterates until the errors are within the tolerance, or no step makes them smaller. The posture is
 * the best one. */
static int find_posture(struct search *x)
{
    const size_t numbers = 6 + (size_t)x->m->v_count;
    double share = 0, largest;
    uint32_t halvings = 0, worst;
    for (x->merit = INFINITY;;) {
        const int status = collide(x, 0);
        if (status != TFA_OK)
            return status;
        const double merit = merit_of(x, &largest, &worst);
        const int is_last = x->posture->iterations >= x->options.iterations;
        if (merit < x->merit) {
            x->merit = merit;
            x->posture->position = largest;
            x->posture->index = worst;
            halvings = 0;
            if (largest <= x->options.tolerance)
                return TFA_OK;
            if (is_last || is_stuck(x))
                return TFA_E_OPEN;
            memcpy(x->step, x->next, numbers * sizeof *x->step);
            share = share_of(x);
            move(x, share);
        } else if (is_last || ++halvings > MOST_HALVINGS) {
            move(x, -share);
            return TFA_E_OPEN;
        } else {
            move(x, -(share /= 2));
        }
        x->posture->iterations++;
    }
}

/* ---- half turns ---- */

/* R = R_link R_frame; a link of the world has none. */
static void axes_of(const double *pose, const double frame[9], double R[9])
{
    const double *u = pose + 3;
    for (int j = 0; j < 3; j++) {
        double v[3], t[3];
        for (int i = 0; i < 3; i++)
            v[i] = frame[3 * i + j];
        for (int i = 0; i < 3; i++)
            t[i] = 2 * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
        for (int i = 0; i < 3; i++)
            R[3 * i + j] = v[i] + u[3] * t[i] + u[(i + 1) % 3] * t[(i + 2) % 3] -
                           u[(i + 2) % 3] * t[(i + 1) % 3];
    }
}

/* Pose of a link in the world; NULL: the world itself */
static void locate(struct search *x, int32_t frame, double pose[7])
{
    static const double world[7] = {0, 0, 0, 0, 0, 0, 1};
    tfa_request r = {.op = TFA_OP_KINEMATICS,
                     .count = 1,
                     .flags = TFA_WANT_POSES,
                     .tip_count = 1,
                     .tips = {(uint32_t)frame},
                     .q = x->impact.q,
                     .base_pose = x->impact.base_pose};
    tfa_reply reply = {.poses = pose};
    if (frame < 0 || tfa_compute(x->w, &r, &reply) != TFA_OK)
        memcpy(pose, world, sizeof world);
}

/* 1: the angular rows are 0 because the frames are half a turn apart: of three rows the trace of
 * R1^T R2 shows it, of two the product of the axes that turn about each other. */
static int is_turned(struct search *x, const struct tfa_closure *c)
{
    double R[2][9], along[3], trace = 0, pose[7];
    const uint32_t held = c->rows >> 3;
    if (held < 3 || held == 4)
        return 0;
    for (int side = 0; side < 2; side++) {
        locate(x, c->frame[side], pose);
        axes_of(pose, c->R[side], R[side]);
    }
    for (int i = 0; i < 3; i++) {
        along[i] = R[0][i] * R[1][i] + R[0][3 + i] * R[1][3 + i] + R[0][6 + i] * R[1][6 + i];
        trace += along[i];
    }
    return held == 7 ? trace < 1 : along[held == 3 ? 2 : held == 5 ? 1 : 0] < 0;
}

static int check_turns(struct search *x)
{
    for (uint32_t k = 0; k < x->m->constraints; k++)
        if (x->impact.constraints >> k & 1 && is_turned(x, &x->m->closure[k])) {
            x->posture->position = M_PI;
            x->posture->index = k;
            return TFA_E_OPEN;
        }
    return TFA_OK;
}

/* ---- velocities ---- */

/* Several rounds, because a measured base is put back. */
static int find_velocities(struct search *x)
{
    tfa_posture *p = x->posture;
    uint32_t worst;
    x->impact.v = p->v;
    x->impact.base_twist = x->m->base_freedoms ? p->base_twist : NULL;
    x->impact.stabilisation = NULL;
    for (int round = 0;; round++) {
        const int status = collide(x, 1);
        if (status != TFA_OK)
            return status;
        (void)merit_of(x, &p->velocity, &worst);
        if (p->velocity <= x->options.tolerance)
            return TFA_OK;
        if (round == VELOCITY_ROUNDS || is_stuck(x)) {
            p->index = p->position <= x->options.tolerance ? worst : p->index;
            return TFA_E_OPEN;
        }
        memcpy(p->v, x->next + 6, x->m->v_count * sizeof *p->v);
        if (x->options.base_is_free)
            memcpy(p->base_twist, x->next, 6 * sizeof *p->base_twist);
    }
}

/* ---- the call ---- */

/* Copies what is given; zeros where nothing is. The buffers may be the same. */
static void copy(double *to, const double *from, size_t count)
{
    if (to && from)
        memmove(to, from, count * sizeof *to);
    else if (to)
        memset(to, 0, count * sizeof *to);
}

/* The start into the posture, and the request of each impact */
static int begin(struct search *x, const tfa_request *r, const tfa_loop_options *options)
{
    static const double to_position[2] = {1, 0}, threshold = TFA_LOOP_RANK_THRESHOLD;
    const tfa_loop_options none = {0};
    const struct tfa_model *m = x->m;
    tfa_posture *p = x->posture;
    x->options = options ? *options : none;
    if (!x->options.iterations)
        x->options.iterations = TFA_LOOP_ITERATIONS;
    if (!(x->options.tolerance > 0))
        x->options.tolerance = TFA_LOOP_TOLERANCE;
    p->field = TFA_FIELD_Q;
    if (m->q_count && (!r->q || !p->q))
        return TFA_E_ARGUMENT;
    p->field = TFA_FIELD_BASE_POSE;
    if (m->base_freedoms ? !r->base_pose || !p->base_pose : x->options.base_is_free)
        return TFA_E_ARGUMENT;
    p->field = TFA_FIELD_BASE_TWIST;
    if (m->base_freedoms && p->v && !p->base_twist)
        return TFA_E_ARGUMENT;
    copy(p->q, r->q, m->q_count);
    copy(p->v, r->v, m->v_count);
    if (m->base_freedoms) {
        copy(p->base_pose, r->base_pose, 7);
        copy(p->base_twist, r->base_twist, 6);
    }
    x->impact = (tfa_request){.op = TFA_OP_IMPACT,
                              .method = r->method,
                              .estimate = TFA_ESTIMATE_NEVER,
                              .refine = TFA_REFINE_DEFAULT,
                              .count = 1,
                              .locked_count = r->locked_count,
                              .locked = r->locked,
                              .rank_loss = r->rank_loss,
                              .constraints = r->constraints,
                              .q = p->q,
                              .base_pose = m->base_freedoms ? p->base_pose : NULL,
                              .stabilisation = to_position,
                              .rank_threshold = r->rank_threshold ? r->rank_threshold : &threshold,
                              .characteristic_length = r->characteristic_length};
    if (m->base_freedoms && !x->options.base_is_free)
        hold_base(x);
    return TFA_OK;
}

static int end(struct search *x, int status)
{
    tfa_posture *p = x->posture;
    p->rank = is_stuck(x) ? 0 : x->rank.rank;
    p->lost = x->rank.rank + x->rank.lost - p->rank;
    if (status == TFA_OK || status == TFA_E_OPEN)
        p->field = status == TFA_OK ? TFA_FIELD_NONE : TFA_FIELD_CONSTRAINTS;
    if (status == TFA_OK)
        p->index = 0;
    return p->status = status;
}

int tfa_close_loops(tfa_workspace *workspace, const tfa_request *request,
                    const tfa_loop_options *options, tfa_posture *posture)
{
    if (!posture)
        return TFA_E_ARGUMENT;
    posture->field = TFA_FIELD_NONE;
    posture->index = posture->iterations = 0;
    posture->position = posture->velocity = 0;
    posture->rank = posture->lost = 0;
    if (!workspace || !request)
        return posture->status = TFA_E_ARGUMENT;
    struct search x = {.w = workspace, .m = workspace->model, .posture = posture};
    x.next = workspace->loop;
    x.step = x.next + 6 + x.m->v_count;
    int status = begin(&x, request, options);
    if (status != TFA_OK)
        return posture->status = status;
    status = find_posture(&x);
    if (status == TFA_OK)
        status = check_turns(&x);
    /* velocities of a posture that stays open, too: they belong to the best one */
    if (posture->v && (status == TFA_OK || status == TFA_E_OPEN)) {
        const int of_velocities = find_velocities(&x);
        status = status == TFA_OK ? of_velocities : status;
    }
    return end(&x, status);
}
