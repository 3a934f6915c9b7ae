/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the joint types of bodies. Each body frame is turned so that the joint's motion subspace
 * H consists of unit axes of that frame. The transform X(q) is in pose_step.h.
 */
#ifndef TFA_MODEL_JOINT_TYPE_H
#define TFA_MODEL_JOINT_TYPE_H

#include <stdint.h>
#include <totalforce/description.h>

/* Axes of spatial vectors, angular first: rotation about x y z, translation along x y z */
enum { AXIS_RX, AXIS_RY, AXIS_RZ, AXIS_TX, AXIS_TY, AXIS_TZ };

enum tfa_kind {
    TFA_KIND_REVOLUTE = 0,
    TFA_KIND_PRISMATIC = 1,
    TFA_KIND_PLANAR = 2, /* velocity in the moved plane, then rotation */
    TFA_KIND_FREE = 3,   /* linear, then angular velocity */
    TFA_KIND_FUSED = 4,  /* several joints without mass between them: H depends on q */
};

struct joint_type {
    const char *name;
    uint32_t declared;             /* bits 1u << tfa_joint_type of descriptions */
    uint8_t freedoms, coordinates; /* 0: as many as it has parts */
    int8_t quaternion;             /* coordinate that is its first; -1: none */
    uint8_t axis[6];               /* of each freedom */
};

#define DECLARED(type) (1u << TFA_JOINT_##type)
static const struct joint_type joint_types[] = {
    [TFA_KIND_REVOLUTE] =
        {"revolute", DECLARED(REVOLUTE) | DECLARED(CONTINUOUS), 1, 1, -1, {AXIS_RZ}},
    [TFA_KIND_PRISMATIC] = {"prismatic", DECLARED(PRISMATIC), 1, 1, -1, {AXIS_TZ}},
    [TFA_KIND_PLANAR] = {"planar", DECLARED(PLANAR), 3, 3, -1, {AXIS_TX, AXIS_TY, AXIS_RZ}},
    [TFA_KIND_FREE] = {"free",
                       DECLARED(FLOATING),
                       6,
                       7,
                       3,
                       {AXIS_TX, AXIS_TY, AXIS_TZ, AXIS_RX, AXIS_RY, AXIS_RZ}},
    [TFA_KIND_FUSED] = {"fused", 0, 0, 0, -1, {0}},
};
#undef DECLARED
#define JOINT_TYPES ((uint8_t)(sizeof joint_types / sizeof *joint_types))

/* The row of a declared joint that moves; JOINT_TYPES if there is none */
static inline uint8_t joint_type_of(tfa_joint_type declared)
{
    uint8_t kind = 0;
    while (kind < JOINT_TYPES &&
           !((uint32_t)declared < 32 && joint_types[kind].declared >> (uint32_t)declared & 1))
        kind++;
    return kind;
}

static inline int is_revolute(uint8_t kind)
{
    return kind == TFA_KIND_REVOLUTE;
}

static inline int is_prismatic(uint8_t kind)
{
    return kind == TFA_KIND_PRISMATIC;
}

static inline int is_planar(uint8_t kind)
{
    return kind == TFA_KIND_PLANAR;
}

static inline int is_free(uint8_t kind)
{
    return kind == TFA_KIND_FREE;
}

static inline int is_fused(uint8_t kind)
{
    return kind == TFA_KIND_FUSED;
}

/* Several freedoms along constant axes */
static inline int has_constant_axes(uint8_t kind)
{
    return joint_types[kind].freedoms > 1;
}

/* 1: freedom k of a joint that is not fused is a rotation */
static inline int freedom_rotates(uint8_t kind, uint32_t k)
{
    return joint_types[kind].axis[k] <= AXIS_RZ;
}

/* Coordinates of a joint with n freedoms */
static inline uint32_t joint_coordinates(uint8_t kind, uint32_t n)
{
    return joint_types[kind].freedoms ? joint_types[kind].coordinates : n;
}

#endif
