/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway when a robot gets another model.
 */
#include "dds/topics/dds_internal.h"

#include <string.h>

void tfa_dds_set_model(dds_robot *robot, const tfa_model *model)
{
    robot->model = model;
    memcpy(robot->hash, tfa_model_hash(model), sizeof robot->hash);
    robot->shape.q_count = tfa_model_q_count(model);
    robot->shape.v_count = tfa_model_v_count(model);
    robot->shape.base_freedoms = tfa_model_base_freedoms(model);
    robot->shape.frames = tfa_model_frame_count(model);
    robot->shape.modes = tfa_model_mode_count(model);
}

/* As tfa_model_tag. */
static uint64_t tag_of(const uint8_t *hash)
{
    uint64_t tag = 0;

    for (int i = 0; i < 8; i++)
        tag = tag << 8 | hash[i];
    return tag;
}

const uint8_t *tfa_dds_hash_of(const dds_robot *robot, uint64_t tag)
{
    return tag != tag_of(robot->hash) && tag == tag_of(robot->other) ? robot->other : robot->hash;
}

void tfa_dds_exchange(void *self, uint32_t index, const tfa_model *next,
                      const tfa_worker_robot *solver)
{
    const tfa_dds *gateway = self;
    dds_robot *robot = &gateway->robots[index];

    pthread_mutex_lock(&robot->mutex);
    memcpy(robot->other, tfa_model_hash(next), sizeof robot->other);
    robot->own.solver = *solver;
    pthread_mutex_unlock(&robot->mutex);
}

void tfa_dds_set_tap(void *self, uint32_t index, struct tfa_tap *tap)
{
    const tfa_dds *gateway = self;
    dds_robot *robot = &gateway->robots[index];

    pthread_mutex_lock(&robot->mutex);
    robot->own.tap = tap;
    pthread_mutex_unlock(&robot->mutex);
}

bool tfa_dds_detach(void *self, uint32_t index)
{
    const tfa_dds *gateway = self;
    dds_robot *robot = &gateway->robots[index];
    struct tfa_dds_ring *ring = NULL;

    pthread_mutex_lock(&robot->mutex);
    robot->leaving = true;
    const bool idle = robot->ring == NULL || tfa_dds_ring_is_empty(robot->ring);
    if (idle) { /* the dds thread waits at rings only that are not empty */
        ring = robot->ring;
        robot->ring = NULL;
    }
    pthread_mutex_unlock(&robot->mutex);
    tfa_dds_ring_close(ring);
    return idle;
}

int tfa_dds_announce(void *self, uint32_t index, const tfa_model *model)
{
    tfa_dds *gateway = self;
    dds_robot *robot = &gateway->robots[index];
    int status = TFA_OK;

    pthread_mutex_lock(&robot->mutex);
    memcpy(robot->other, robot->hash, sizeof robot->other);
    tfa_dds_set_model(robot, model);
    if (robot->ring == NULL)
        status = tfa_dds_ring_open(gateway->worker, robot, gateway->slots, &robot->ring);
    robot->leaving = status != TFA_OK;
    robot->announced = false;
    if (status == TFA_OK)
        tfa_dds_set_leader_model(gateway, robot);
    else
        tfa_dds_step_down(gateway, robot);
    if (robot->election.self.role == TFA_ROLE_LEADING && !robot->announced)
        status = TFA_E_SYSTEM;
    pthread_mutex_unlock(&robot->mutex);
    return status;
}
