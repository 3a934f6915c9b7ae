/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compilation of a draft into a model: one block of memory, constants rounded to double once.
 */
#ifndef TFA_MODEL_COMPILE_COMPILE_H
#define TFA_MODEL_COMPILE_COMPILE_H

#include "model/draft/draft.h"

/* Arrays of a model: X(type, field of tfa_model, elements), with the draft d and its freedoms */
#define TFA_MODEL_ARRAYS(X)                                                                        \
    X(struct tfa_body, body, d->bodies)                                                            \
    X(struct tfa_mass_properties, without_payload, d->bodies + 1u)                                 \
    X(struct tfa_frame, frame, d->frames)                                                          \
    X(struct tfa_xform_quad, frame_quad, d->frames)                                                \
    X(struct tfa_link_mass, link, d->frames)                                                       \
    X(uint32_t, link_order, d->frames)                                                             \
    X(struct tfa_mass_properties, link_without_payload, d->frames)                                 \
    X(struct tfa_chain, chain, d->bodies)                                                          \
    X(struct tfa_part, part, d->parts)                                                             \
    X(struct tfa_xform_quad, part_quad, d->parts)                                                  \
    X(struct tfa_flexible, flexible, d->flexible_bodies)                                           \
    X(struct tfa_handle, handle, d->handles)                                                       \
    X(struct tfa_closure, closure, d->constraints)                                                 \
    X(tfa_joint_info, joint, d->joints)                                                            \
    X(tfa_declared_joint, declared, d->description->joint_count)                                   \
    X(tfa_body_info, body_info, d->bodies)                                                         \
    X(struct tfa_coordinate, coordinate, (size_t)d->bodies + freedoms)                             \
    X(struct tfa_freedom, freedom, freedoms)                                                       \
    X(struct tfa_mimic, mimic, followers)                                                          \
    X(double, armature, freedoms)                                                                  \
    X(double, damping, freedoms)                                                                   \
    X(double, friction, freedoms)                                                                  \
    X(int32_t, dof_parent, freedoms)                                                               \
    X(uint32_t, dof_depth, freedoms)                                                               \
    X(size_t, dof_row, freedoms)

/* The arrays while the draft is compiled into them */
struct layout {
    struct tfa_model *model;
#define TFA_MODEL_FIELD(type, name, count) type *name;
    TFA_MODEL_ARRAYS(TFA_MODEL_FIELD)
#undef TFA_MODEL_FIELD
    struct tfa_body_quad *quad; /* of each body */
    struct tfa_mass_properties *link_quad; /* of each link */
    uint32_t *chain_body;       /* of all chains */
    double *modal;              /* numbers of flexible bodies */
    char *text;                 /* names; advances as they are stored */
    size_t size;                /* of all, bytes */
};

/* Size of the compiled model in bytes. */
size_t tfa_compiled_size(const struct draft *d);

/* Compiles into `memory`: 64-byte aligned, tfa_compiled_size bytes. Cannot fail. */
const struct tfa_model *tfa_compile(const struct draft *d, void *memory);

/* Refuses a gravity that is not finite: TFA_E_VALUE. NULL is allowed. */
int tfa_check_gravity(const double *gravity, tfa_report *report);

/* Bodies with their indices in q and v, depths and trees; parts of fused bodies. */
void tfa_emit_bodies(struct layout *l, const struct draft *d);

/* Expanded tree of freedoms (Featherstone 2008, 6.1). */
void tfa_emit_freedoms(struct layout *l);

/* Main chain of each tree. */
void tfa_emit_chains(struct layout *l);

/* Maps from public to inner coordinates and freedoms; armature, damping, mimics. */
void tfa_emit_maps(struct layout *l, const struct draft *d);

/* Flexible bodies, their handles and what rides on these; how many numbers they keep. */
void tfa_emit_modes(struct layout *l, const struct draft *d);
size_t tfa_modal_numbers(const struct draft *d);

/* Frames, links, public joints, declared joints and constraints with their names. */
void tfa_emit_names(struct layout *l, const struct draft *d);

#endif
