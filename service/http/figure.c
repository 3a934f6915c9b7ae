/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot's figure: poses of its links, and Lambda^-1 at its tips, by a solver of its own.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "http/http_internal.h"

/* ---- links ---- */

/* A link's line begins at the frame of its body, that of a body at the body before. */
static int32_t parent_of(const tfa_model *model, uint32_t frame)
{
    const int32_t body = tfa_model_frame(model, frame).body;
    int32_t from = body;
    if (body < 0)
        return frame ? 0 : -1;
    if (tfa_model_body_frame(model, (uint32_t)body) == frame)
        from = tfa_model_body_parent(model, (uint32_t)body);
    if (from >= 0)
        return (int32_t)tfa_model_body_frame(model, (uint32_t)from);
    return tfa_model_frame(model, 0).body < 0 ? 0 : -1;
}

static uint32_t depth_of(const tfa_model *model, int32_t body)
{
    uint32_t depth = 0;
    for (; body >= 0; body = tfa_model_body_parent(model, (uint32_t)body))
        depth++;
    return depth;
}

static bool is_leaf_body(const tfa_model *model, int32_t body)
{
    const uint32_t count = tfa_model_summarise(model).bodies;
    for (uint32_t i = 0; i < count; i++)
        if (tfa_model_body_parent(model, i) == body)
            return false;
    return body >= 0;
}

/* Keeps the deepest, each before all of less depth. */
static void add_tip(figure *f, uint32_t frame)
{
    const uint32_t depth = depth_of(f->model, tfa_model_frame(f->model, frame).body);
    uint32_t k = f->tip_count;
    while (k > 0 &&
           depth_of(f->model, tfa_model_frame(f->model, f->tips[k - 1].frame).body) < depth)
        k--;
    if (k == FIGURE_TIPS)
        return;
    f->tip_count += f->tip_count < FIGURE_TIPS;
    memmove(&f->tips[k + 1], &f->tips[k], (f->tip_count - 1 - k) * sizeof *f->tips);
    f->tips[k] = (figure_tip){.frame = frame, .status = TFA_E_NOT_COMPUTED};
}

/* Tips: the last frame of each body that carries no other. */
static void find_tips(figure *f)
{
    const uint32_t bodies = tfa_model_summarise(f->model).bodies;
    uint32_t *last = calloc(bodies ? bodies : 1, sizeof *last);
    f->tip_count = 0;
    for (uint32_t i = 0; last && i < f->frame_count; i++) {
        const int32_t body = tfa_model_frame(f->model, i).body;
        if (body >= 0)
            last[body] = i;
    }
    for (uint32_t i = 0; last && i < bodies; i++)
        if (is_leaf_body(f->model, (int32_t)i))
            add_tip(f, last[i]);
    free(last);
}

/* ---- the figure ---- */

static void free_arrays(figure *f)
{
    free(f->parents);
    free(f->poses);
    f->parents = NULL;
    f->poses = f->q = f->inertia = NULL;
}

/* Without memory there is no figure; the rest goes on. */
static void set_model(figure *f, const tfa_model *model, const tfa_worker_robot *solver)
{
    free_arrays(f);
    f->model = model;
    f->solver = solver ? *solver : (tfa_worker_robot){0};
    f->frame_count = tfa_model_frame_count(model);
    f->tip_count = 0;
    f->computed = 0;
    f->status = TFA_E_MEMORY;
    f->parents = calloc(f->frame_count + 1, sizeof *f->parents);
    f->poses = calloc(f->frame_count * 7 + 36 + tfa_model_q_count(model), sizeof *f->poses);
    if (!f->parents || !f->poses)
        return;
    f->inertia = f->poses + f->frame_count * 7;
    f->q = f->inertia + 36;
    f->status = TFA_E_NOT_COMPUTED;
    for (uint32_t i = 0; i < f->frame_count; i++)
        f->parents[i] = parent_of(model, i);
    find_tips(f);
}

int figure_open(figure *f, const tfa_model *model, const tfa_worker_robot *solver)
{
    *f = (figure){0};
    if (pthread_mutex_init(&f->mutex, NULL) != 0)
        return TFA_E_SYSTEM;
    set_model(f, model, solver);
    return TFA_OK;
}

void figure_close(figure *f)
{
    free_arrays(f);
    pthread_mutex_destroy(&f->mutex);
}

void figure_exchange(figure *f, const tfa_model *model, const tfa_worker_robot *solver)
{
    pthread_mutex_lock(&f->mutex);
    set_model(f, model, solver);
    pthread_mutex_unlock(&f->mutex);
}

/* ---- solving ---- */

/* All joints at 0, floating ones unrotated. */
static void set_neutral(figure *f)
{
    memset(f->q, 0, tfa_model_q_count(f->model) * sizeof *f->q);
    for (uint32_t i = 0; i < tfa_model_joint_count(f->model); i++) {
        const tfa_joint_info joint = tfa_model_joint(f->model, i);
        const int32_t quaternion = tfa_joint_type_describe(joint.type).quaternion;
        if (quaternion >= 0)
            f->q[joint.q_index + (uint32_t)quaternion + 3] = 1;
    }
}

static int solve(figure *f, tfa_request *request, tfa_reply *reply)
{
    return f->solver.solve(f->solver.self, request, reply, 0, 1);
}

/* One tip at a time: a robot may refuse several. */
static void solve_tip(figure *f, tfa_request request, figure_tip *tip)
{
    tfa_answer answer;
    tfa_reply reply = {.lambda_inv = f->inertia, .answers = &answer};
    request.op = TFA_OP_OPERATIONAL_INERTIA;
    request.flags = 0;
    request.estimate = TFA_ESTIMATE_NEVER;
    request.tip_count = 1;
    request.rows = TFA_ROWS_POINT;
    request.tips[0] = tip->frame;
    tip->status = solve(f, &request, &reply);
    for (int i = 0; tip->status == TFA_OK && i < 9; i++) {
        tip->block[i] = f->inertia[i];
        if (!isfinite(tip->block[i]))
            tip->status = TFA_E_NOT_COMPUTED;
    }
    if (tip->status == TFA_OK)
        eigen_symmetric3(tip->block, tip->values, tip->vectors);
}

void figure_update(figure *f, const tfa_robot_state *state, uint64_t now)
{
    static const double origin[7] = {0, 0, 0, 0, 0, 0, 1};
    const uint32_t q_count = tfa_model_q_count(f->model);
    const bool known = state->time && state->q_count == q_count &&
                       (state->floating || !tfa_model_base_freedoms(f->model));
    if (!f->poses || !f->solver.solve || (f->computed && now - f->computed < HTTP_PERIOD_NS))
        return;
    tfa_answer answer;
    tfa_request request = {.op = TFA_OP_KINEMATICS,
                           .estimate = TFA_ESTIMATE_NEVER,
                           .flags = TFA_WANT_FRAME_POSES,
                           .count = 1,
                           .q = f->q};
    tfa_reply reply = {.frame_poses = f->poses, .answers = &answer};
    f->computed = now;
    if (known)
        memcpy(f->q, state->q, q_count * sizeof *f->q);
    else
        set_neutral(f);
    if (tfa_model_base_freedoms(f->model))
        request.base_pose = known ? state->base_pose : origin;
    f->status = solve(f, &request, &reply);
    for (uint32_t i = 0; i < f->tip_count; i++)
        solve_tip(f, request, &f->tips[i]);
}
