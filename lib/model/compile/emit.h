/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The arrays of a model while a draft is compiled into them.
 */
#ifndef TFA_MODEL_COMPILE_EMIT_H
#define TFA_MODEL_COMPILE_EMIT_H

#include "model/draft/draft.h"

struct layout {
    struct tfa_model *model;
    struct tfa_body *body;
    struct tfa_body_quad *quad;
    struct tfa_mass_properties *without_payload;
    struct tfa_frame *frame;
    struct tfa_xform_quad *frame_quad;
    struct tfa_chain *chain;
    uint32_t *chain_body;
    struct tfa_part *part;
    struct tfa_xform_quad *part_quad;
    tfa_joint_info *joint;
    tfa_declared_joint *declared;
    tfa_body_info *body_info;
    struct tfa_coordinate *coordinate;
    struct tfa_freedom *freedom;
    struct tfa_mimic *mimic;
    double *armature, *damping;
    int32_t *dof_parent;
    uint32_t *dof_depth;
    size_t *dof_row;
    char *text;
    size_t size;
};

/* Bodies with their places in q and v, depths and trees; parts of fused ones. */
void tfa_emit_bodies(struct layout *l, const struct draft *d);

/* The expanded tree of freedoms. */
void tfa_emit_freedoms(struct layout *l);

/* The main chain of each tree. */
void tfa_emit_chains(struct layout *l);

/* Where inner coordinates and freedoms come from; armature, damping, mimics. */
void tfa_emit_maps(struct layout *l, const struct draft *d);

/* Frames, public joints and declared joints with their names. */
void tfa_emit_names(struct layout *l, const struct draft *d);

#endif
