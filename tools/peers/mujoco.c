/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * MuJoCo as a contestant: the least it needs for forward dynamics (composite rigid bodies, sparse
 * factorisation, Newton-Euler bias); no contacts, no constraints, no sensors.
 */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <mujoco/mujoco.h>
#pragma GCC diagnostic pop
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

struct mujoco_robot {
    mjModel *model;
    mjData *data;
    mjtNum *force;
    int n;
    int *at; /* our joint -> its place in qpos and qvel */
};

static void release(void *robot)
{
    struct mujoco_robot *r = robot;
    if (r->data)
        mj_deleteData(r->data);
    if (r->model)
        mj_deleteModel(r->model);
    free(r->force);
    free(r->at);
    free(r);
}

static void *make(const char *path, const tfa_description *description)
{
    char error[1000] = "";
    struct mujoco_robot *r = calloc(1, sizeof *r);
    r->model = mj_loadXML(path, NULL, error, sizeof error);
    if (!r->model) {
        fprintf(stderr, "mujoco: %s\n", error);
        release(r);
        return NULL;
    }
    r->data = mj_makeData(r->model);
    r->n = r->model->nv;
    r->force = calloc((size_t)r->n + 1, sizeof *r->force);
    r->at = calloc((size_t)r->n + 1, sizeof *r->at);
    r->model->opt.gravity[2] = -9.80665;
    int k = 0;
    for (size_t j = 0; j < description->joint_count; j++) {
        if (description->joints[j].type == TFA_JOINT_FIXED)
            continue;
        int id = mj_name2id(r->model, mjOBJ_JOINT, description->joints[j].name);
        if (id < 0 || k >= r->n) {
            release(r);
            return NULL;
        }
        r->at[k++] = r->model->jnt_dofadr[id];
        /* the URDF importer may set armature and damping defaults: all zero here */
        r->model->dof_armature[r->model->jnt_dofadr[id]] = 0;
    }
    return r;
}

static void forward(void *robot, const double *q, const double *v, const double *tau, double *qdd)
{
    struct mujoco_robot *r = robot;
    mjModel *m = r->model;
    mjData *d = r->data;
    for (int k = 0; k < r->n; k++) {
        d->qpos[r->at[k]] = q[k];
        d->qvel[r->at[k]] = v[k];
    }
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_crb(m, d);
    mj_factorM(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 0, d->qfrc_bias);
    for (int k = 0; k < r->n; k++)
        r->force[r->at[k]] = tau[k] - d->qfrc_bias[r->at[k]];
    mj_solveM(m, d, d->qacc, r->force, 1);
    for (int k = 0; k < r->n; k++)
        qdd[k] = d->qacc[r->at[k]];
}

const struct contestant peer_mujoco = {"mujoco", make, forward, release};
