/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Functions that read a model.
 */
#include <string.h>

#include "model/model.h"

const char *tfa_model_name(const tfa_model *model)
{
    return model->name;
}

const uint8_t *tfa_model_hash(const tfa_model *model)
{
    return model->hash;
}

const char *tfa_model_hash_text(const tfa_model *model)
{
    return model->hash_text;
}

uint64_t tfa_model_tag(const tfa_model *model)
{
    uint64_t tag = 0; /* unrolled it becomes one load */
#pragma GCC unroll 8
    for (int k = 0; k < 8; k++)
        tag |= (uint64_t)model->hash[k] << (56 - 8 * k);
    return tag;
}

tfa_model_summary tfa_model_summarise(const tfa_model *model)
{
    return model->summary;
}

double tfa_model_characteristic_length(const tfa_model *model)
{
    return model->length;
}

uint32_t tfa_model_q_count(const tfa_model *model)
{
    return model->q_count;
}

uint32_t tfa_model_v_count(const tfa_model *model)
{
    return model->v_count;
}

uint32_t tfa_model_base_freedoms(const tfa_model *model)
{
    return model->base_freedoms;
}

uint32_t tfa_model_joint_count(const tfa_model *model)
{
    return model->joints;
}

tfa_joint_info tfa_model_joint(const tfa_model *model, uint32_t joint)
{
    return joint < model->joints ? model->joint[joint] : (tfa_joint_info){0};
}

int32_t tfa_model_find_joint(const tfa_model *model, const char *name)
{
    for (uint32_t k = 0; k < model->joints; k++)
        if (strcmp(model->joint[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

uint32_t tfa_model_mode_count(const tfa_model *model)
{
    return model->modes;
}

tfa_mode_info tfa_model_mode(const tfa_model *model, uint32_t mode)
{
    for (uint32_t k = 0; k < model->flexible_bodies; k++) {
        const struct tfa_flexible *f = &model->flexible[k];
        if (mode - f->first < f->n)
            return (tfa_mode_info){model->frame[f->frame].name, mode - f->first,
                                   f->limit[mode - f->first]};
    }
    return (tfa_mode_info){0};
}

uint32_t tfa_model_constraint_count(const tfa_model *model)
{
    return model->constraints;
}

tfa_constraint_info tfa_model_constraint(const tfa_model *model, uint32_t constraint)
{
    if (constraint >= model->constraints)
        return (tfa_constraint_info){NULL, {-1, -1}, 0, 0};
    const struct tfa_closure *c = &model->closure[constraint];
    return (tfa_constraint_info){c->name, {c->frame[0], c->frame[1]}, c->rows, c->unilateral};
}

int32_t tfa_model_find_constraint(const tfa_model *model, const char *name)
{
    for (uint32_t k = 0; k < model->constraints; k++)
        if (strcmp(model->closure[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

uint32_t tfa_model_frame_count(const tfa_model *model)
{
    return model->frames;
}

tfa_frame_info tfa_model_frame(const tfa_model *model, uint32_t frame)
{
    if (frame >= model->frames)
        return (tfa_frame_info){NULL, -1};
    return (tfa_frame_info){model->frame[frame].name, model->frame[frame].body};
}

int32_t tfa_model_find_frame(const tfa_model *model, const char *name)
{
    for (uint32_t k = 0; k < model->frames; k++)
        if (strcmp(model->frame[k].name, name) == 0)
            return (int32_t)k;
    return -1;
}

uint32_t tfa_model_declared_count(const tfa_model *model)
{
    return model->declared_joints;
}

tfa_declared_joint tfa_model_declared(const tfa_model *model, uint32_t index)
{
    if (index >= model->declared_joints)
        return (tfa_declared_joint){.body = -1, .joint = -1, .leader = -1};
    return model->declared[index];
}

tfa_body_info tfa_model_body(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body_info[body] : (tfa_body_info){0};
}

const char *tfa_model_body_name(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body_info[body].name : "";
}

uint32_t tfa_model_body_frame(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body[body].link : 0;
}

int32_t tfa_model_body_parent(const tfa_model *model, uint32_t body)
{
    return body < model->bodies ? model->body[body].parent : -1;
}
