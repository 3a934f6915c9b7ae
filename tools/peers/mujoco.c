/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * MuJoCo as a peer: the least it needs for forward dynamics (composite rigid bodies, sparse
 * factorisation, Newton-Euler bias); no contacts, no constraints, no sensors.
 */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <mujoco/mujoco.h>
#pragma GCC diagnostic pop
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "peer.h"

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

/* Warnings, which would go to a file in the working folder: what is wrong shows in the error. */
static void be_quiet(const char *text)
{
    (void)text;
}

/* Our joints by name. @return the first that is not there, or NULL */
static const char *find_joints(struct mujoco_robot *r, const tfa_description *description)
{
    int k = 0;
    for (size_t j = 0; j < description->joint_count; j++) {
        if (description->joints[j].type == TFA_JOINT_FIXED)
            continue;
        const int id = mj_name2id(r->model, mjOBJ_JOINT, description->joints[j].name);
        if (id < 0 || k >= r->n)
            return description->joints[j].name;
        r->at[k++] = r->model->jnt_dofadr[id];
        /* the URDF importer may set armature and damping defaults: all zero here */
        r->model->dof_armature[r->model->jnt_dofadr[id]] = 0;
    }
    return NULL;
}

static void *make(const char *path, const tfa_description *description, char *why, size_t size)
{
    struct mujoco_robot *r = calloc(1, sizeof *r);
    mju_user_warning = be_quiet;
    r->model = mj_loadXML(path, NULL, why, (int)size);
    r->data = r->model ? mj_makeData(r->model) : NULL;
    if (!r->data) {
        release(r);
        return NULL;
    }
    r->n = r->model->nv;
    r->force = calloc((size_t)r->n + 1, sizeof *r->force);
    r->at = calloc((size_t)r->n + 1, sizeof *r->at);
    r->model->opt.gravity[2] = -9.80665;
    const char *missing = find_joints(r, description);
    if (missing) {
        snprintf(why, size, "no joint %s", missing);
        release(r);
        return NULL;
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

const struct peer peer_mujoco = {"mujoco", make, forward, release};
