/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot with inputs at a fixed seed, buffers for replies, and workspaces of each precision.
 */
#include "answer_robot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { QUAD_BODIES = 64 };

const struct precision precisions[PRECISIONS] = {{"f64", TFA_F64, TFA_RESIDUAL_SAME, 0},
                                                 {"f32", TFA_F32, TFA_RESIDUAL_SAME, 0},
                                                 {"f32+f64", TFA_F32, TFA_RESIDUAL_F64, 0},
                                                 {"f64+f128", TFA_F64, TFA_RESIDUAL_F128, 1},
                                                 {"f128", TFA_F128, TFA_RESIDUAL_SAME, 1}};

static const double scales[INPUTS] = {1.5, 1, 20, 5, 1, 0.5, 30, 2, 10};

void stop(const char *what, const char *name, const char *why)
{
    fprintf(stderr, "answer_hashes: %s '%s': %s\n", what, name, why);
    exit(2);
}

static void *zeros(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        stop("memory", "calloc", "none left");
    return memory;
}

uint64_t mix_bits(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static double uniform(uint64_t *seed, double scale)
{
    *seed += 0x9e3779b97f4a7c15u;
    return scale * ((double)(mix_bits(*seed) >> 11) * 0x1p-52 - 1);
}

static void normalise(double quaternion[4])
{
    double norm = 0;
    for (int i = 0; i < 4; i++)
        norm += quaternion[i] * quaternion[i];
    norm = sqrt(norm);
    for (int i = 0; i < 4; i++)
        quaternion[i] /= norm;
}

static void make_arrays(struct robot *r)
{
    size_t nq = tfa_model_q_count(r->model), nv = tfa_model_v_count(r->model);
    size_t n = nv + tfa_model_base_freedoms(r->model);
    const size_t in_size[INPUTS] = {nq, nv, nv, nv, 7, 6, 6, 6, 6 * (size_t)WRENCHES};
    const size_t out_size[OUTPUTS] = {
        nv, nv, 6, 6, 36 * (size_t)TIPS_MAX * TIPS_MAX, 7 * (size_t)TIPS_MAX, n * n};
    memcpy(r->in_size, in_size, sizeof in_size);
    memcpy(r->out_size, out_size, sizeof out_size);
    for (int i = 0; i < OUTPUTS; i++)
        r->out[i] = zeros(BATCH_MAX * out_size[i], sizeof(double));
    for (int i = 0; i < INPUTS; i++) {
        uint64_t seed = (uint64_t)i;
        r->in[i] = zeros(BATCH_MAX * in_size[i], sizeof(double));
        for (size_t k = 0; k < BATCH_MAX * in_size[i]; k++)
            r->in[i][k] = uniform(&seed, scales[i]);
    }
}

static void make_inputs(struct robot *r)
{
    make_arrays(r);
    uint32_t frames = tfa_model_frame_count(r->model), joints = tfa_model_joint_count(r->model);
    for (size_t k = 0; k < BATCH_MAX; k++) {
        normalise(r->in[POSE] + 7 * k + 3);
        for (uint32_t i = 0; i < joints; i++) {
            const tfa_joint_info joint = tfa_model_joint(r->model, i);
            const int32_t quaternion = tfa_joint_type_describe(joint.type).quaternion;
            if (quaternion >= 0)
                normalise(r->in[Q] + k * r->in_size[Q] + joint.q_index + quaternion);
        }
    }
    const uint32_t picked[4] = {frames - 1, frames / 2, frames / 4, 3 * frames / 4};
    memcpy(r->frames, picked, sizeof picked);
    r->locked[0] = joints / 3;
    r->locked[1] = joints / 2;
}

int robot_has_precision(const struct robot *r, size_t precision)
{
    return !precisions[precision].quad || r->bodies <= QUAD_BODIES;
}

static void make_workspace(struct robot *r, size_t i)
{
    const struct precision *p = &precisions[i];
    tfa_workspace_options options = {
        .precision = p->factors, .residual = p->residual, .methods = TFA_METHODS_ALL};
    tfa_batch_pool_options pool_options = {
        .precision = p->factors, .residual = p->residual, .methods = TFA_METHODS_ALL};
    pool_options.threads = POOL_THREADS;
    int status = tfa_workspace_create(r->model, &options, &r->workspaces[i]);
    if (status == TFA_OK)
        status = tfa_batch_pool_create(r->model, &pool_options, &r->pools[i]);
    if (status != TFA_OK)
        stop("workspace", p->name, tfa_status_text(status));
}

void robot_free(struct robot *r)
{
    for (int i = 0; i < INPUTS; i++)
        free(r->in[i]);
    for (int i = 0; i < OUTPUTS; i++)
        free(r->out[i]);
    for (size_t i = 0; i < PRECISIONS; i++) {
        tfa_workspace_free(r->workspaces[i]);
        tfa_batch_pool_free(r->pools[i]);
    }
    tfa_model_free(r->model);
}

int robot_load(struct robot *r, const char *path, tfa_base base, int with_policies)
{
    tfa_model_options options = {.base = base};
    if (with_policies) {
        options.rotor_inertia = options.damping = options.lock_massless_leaves = 1;
        options.mimic = TFA_MIMIC_PROJECT;
        options.inertia = TFA_INERTIA_REPAIR;
    }
    tfa_report report = {0};
    *r = (struct robot){.base = base == TFA_BASE_FIXED ? "fixed" : "floating"};
    const char *file = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    snprintf(r->name, sizeof r->name, "%.*s%s", (int)strcspn(file, "."), file,
             with_policies ? "+policies" : "");
    int status = tfa_model_load(path, &options, &report, &r->model);
    tfa_report_free(&report);
    if (status != TFA_OK)
        return status;
    r->bodies = tfa_model_summarise(r->model).bodies;
    make_inputs(r);
    for (size_t i = 0; i < PRECISIONS; i++)
        if (robot_has_precision(r, i))
            make_workspace(r, i);
    return TFA_OK;
}
