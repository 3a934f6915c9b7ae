/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the joint types of bodies. Each body frame is turned so that the joint's motion subspace
 * H consists of unit axes of that frame. The transform X(q) is in pose_step.h.
 */
#ifndef TFA_MODEL_JOINT_TYPE_H
#define TFA_MODEL_JOINT_TYPE_H

#include <stdint.h>

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
    uint8_t freedoms, coordinates; /* 0: as many as it has parts */
    uint8_t axis[6];               /* of each freedom */
    const char *text;
};

static const struct joint_type joint_types[] = {
    [TFA_KIND_REVOLUTE] = {1, 1, {AXIS_RZ}, "is revolute"},
    [TFA_KIND_PRISMATIC] = {1, 1, {AXIS_TZ}, "is prismatic"},
    [TFA_KIND_PLANAR] = {3, 3, {AXIS_TX, AXIS_TY, AXIS_RZ}, "is planar"},
    [TFA_KIND_FREE] = {6, 7, {AXIS_TX, AXIS_TY, AXIS_TZ, AXIS_RX, AXIS_RY, AXIS_RZ}, "is free"},
    [TFA_KIND_FUSED] = {0, 0, {0}, "moves a massless link: it is fused with the next"},
};

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
