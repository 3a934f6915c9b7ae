/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * MuJoCo as a peer: the least it needs for forward dynamics (composite rigid bodies, sparse
 * factorisation, Newton-Euler bias) and for Lambda^-1 (the same factors, half a solve of six
 * columns); no contacts, no constraints, no sensors.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mujoco_inertia.h"
#include "peer.h"

struct mujoco_robot {
    mjModel *model;
    mjData *data;
    mjtNum *force;
    mjtNum *columns; /* lambda: J and D^-1/2 L^-T J^T, six rows each */
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
    free(r->columns);
    free(r->at);
    free(r);
}

/* Warnings, which would go to a file in the working folder: mistakes show in the error. */
static void disable_warnings(const char *text)
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
    mju_user_warning = disable_warnings;
    r->model = mj_loadXML(path, NULL, why, (int)size);
    r->data = r->model ? mj_makeData(r->model) : NULL;
    if (!r->data) {
        release(r);
        return NULL;
    }
    r->n = r->model->nv;
    r->force = calloc((size_t)r->n + 1, sizeof *r->force);
    r->columns = calloc(12 * (size_t)r->n + 1, sizeof *r->columns);
    r->at = calloc((size_t)r->n + 1, sizeof *r->at);
    r->model->opt.gravity[2] = -9.80665;
    peer_mujoco_set_inertias(r->model, description);
    const char *missing = find_joints(r, description);
    if (missing) {
        snprintf(why, size, "no joint %s", missing);
        release(r);
        return NULL;
    }
    return r;
}

/* Composite inertias and their sparse factors */
static void factor(const struct mujoco_robot *r, const double *q)
{
    for (int k = 0; k < r->n; k++)
        r->data->qpos[r->at[k]] = q[k];
    mj_kinematics(r->model, r->data);
    mj_comPos(r->model, r->data);
    mj_crb(r->model, r->data);
    mj_factorM(r->model, r->data);
}

static void forward(void *robot, const double *q, const double *v, const double *tau, double *qdd)
{
    struct mujoco_robot *r = robot;
    mjModel *m = r->model;
    mjData *d = r->data;
    for (int k = 0; k < r->n; k++)
        d->qvel[r->at[k]] = v[k];
    factor(r, q);
    mj_comVel(m, d);
    mj_rne(m, d, 0, d->qfrc_bias);
    for (int k = 0; k < r->n; k++)
        r->force[r->at[k]] = tau[k] - d->qfrc_bias[r->at[k]];
    mj_solveM(m, d, d->qacc, r->force, 1);
    for (int k = 0; k < r->n; k++)
        qdd[k] = d->qacc[r->at[k]];
}

int peer_mujoco_lambda(void *robot, const double *q, const char *link, double *lambda_inv)
{
    struct mujoco_robot *r = robot;
    const int body = mj_name2id(r->model, mjOBJ_BODY, link);
    const int n = r->n;
    mjtNum *J = r->columns, *Y = r->columns + 6 * n;
    if (body < 0)
        return -1;
    factor(r, q);
    mj_jac(r->model, r->data, J, J + 3 * n, r->data->xpos + 3 * body, body);
    mj_solveM2(r->model, r->data, Y, J, 6);
    mju_mulMatMatT(lambda_inv, Y, Y, 6, n, 6);
    return 0;
}

const struct peer peer_mujoco = {"mujoco", make, forward, release};
