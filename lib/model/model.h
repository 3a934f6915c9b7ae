/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The compiled model as the kernels read it. Six-vectors are angular first.
 */
#ifndef TFA_MODEL_MODEL_H
#define TFA_MODEL_MODEL_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/model.h>

#include "model/joint_type.h"
#include "model/quad.h"

/* Limit of the entries of M (a chain of N bodies has N (N + 1) / 2; the limit is a chain of 2895,
 * 32 MiB in double). Larger robots have no memory for M, and methods that need it refuse them. */
#define TFA_MASS_ENTRIES_MAX ((size_t)4 << 20)

/* Robots up to this size get memory for every method by default, larger ones for the choices of
 * auto only: 3 KB a body instead of 7 KB and M. */
#define TFA_RESERVE_ALL_BODIES_MAX 256

/* Inner freedoms of robots with derivatives: 3 x n x n numbers in every workspace (1.5 MiB in
 * double). */
#define TFA_DERIVATIVES_FREEDOMS_MAX 256
/* and of those whose batches have them in lanes: as many numbers in each lane. A state in a batch
 * of 512 takes 0.58 of the time of one alone with 36 freedoms (humanoid30, floating), and 0.72 with
 * 53 (humanoid), with AVX2 0.79 and 0.93 (bench_suite, Intel Xeon VM, gcc 12, 2026-11-28). */
#define TFA_DERIVATIVES_LANES_FREEDOMS_MAX 40

/* Longest main chain of the method hessenberg: it keeps 36 N (N - 1) / 2 numbers (2.4 MB in double)
 * in every workspace of the model. */
#define TFA_HESSENBERG_LONGEST 130

/* A joint of a fused body, in order from the parent. Its frame is fixed in the part that it moves;
 * the frame of the last part is the body's. */
struct tfa_part {
    double E[9], r[3]; /* from the frame of the previous part (the first: of the parent) at q = 0 */
    uint8_t kind;      /* revolute or prismatic */
};

/* Mass properties of a body from its links */
struct tfa_mass_properties {
    tfa_quad mass, h[3], I[6]; /* as in tfa_body */
};

/* Constants in quadruple precision, for f128 and derived models */
struct tfa_xform_quad {
    tfa_quad E[9], r[3];
};
struct tfa_body_quad {
    struct tfa_xform_quad xform;
    struct tfa_mass_properties mass; /* payloads included */
};

/* Constants of one body. Frame i is fixed in body i, its origin on the axis of its (last) joint. */
struct tfa_body {
    double E[9];     /* rotation from the parent's frame to the joint's frame at q = 0, row major */
    double r[3];     /* origin of the joint's frame in the parent's frame, m */
    double mass;     /* kg */
    double h[3];     /* mass times centre of mass, frame i, kg m */
    double I[6];     /* xx xy xz yy yz zz about the origin of frame i, kg m^2 */
    double armature; /* of a joint with one freedom; see tfa_model.armature for all freedoms */
    double d;        /* axial: shift along z */
    int32_t parent;  /* body index, -1: the world; always below the own index */
    uint32_t link;   /* frame of the link that gives it its name */
    uint32_t q, v;   /* first inner coordinate and freedom; the base counts in v only */
    uint8_t kind;    /* enum tfa_kind */
    uint8_t n;       /* freedoms: 1 to 6 */
    uint8_t regular; /* 1: the rigid inertia is safely positive definite */
    uint8_t base;    /* 1: the floating base; its q and v come in fields of their own */
    uint8_t leaf;    /* 1: no body hangs from it */
    uint8_t last;    /* 1: the last child of its parent, the first to be folded inward */
    /* 1: revolute, and E = Rz(theta) Rx(alpha), r = (a, -d sin alpha, d cos alpha), the frames
     * of Denavit and Hartenberg: see spatial/screw.h */
    uint8_t axial;
    int32_t joint_nd;                 /* index among bodies with n > 1, else -1 */
    int32_t flexible, handle; /* own modes; handle of the parent that carries the joint; or -1 */
    uint32_t part;                    /* fused: its n parts start here in tfa_model.part */
    int32_t tree;                     /* root body of its tree */
    uint32_t depth;                   /* bodies from the root to here, this one included */
    double outboard[2];               /* of the sentinel: kg m^2, kg (sizes.h) */
    const struct tfa_body_quad *quad; /* the same constants, not rounded */
};

/* A link of the file: a frame on a body. */
struct tfa_frame {
    int32_t body; /* -1: fixed to the world */
    uint8_t part; /* 0: fixed in the body; k: moved by the first k parts of a fused body only, and
                     R and p are those in the frame of part k */
    double R[9];  /* rotation from the link frame to the body frame (or the world) */
    double p[3];  /* origin of the link frame in the body frame */
    int32_t handle; /* of the body that carries it: R and p are those without deformation; or -1 */
    const char *name;
};

/* What a link weighs by itself, payloads of the model included: for the forces across joints */
struct tfa_link_mass {
    double mass, h[3], I[6]; /* as in tfa_body, about the origin of its body's frame */
    const struct tfa_mass_properties *quad; /* the same, not rounded */
    int32_t parent;                         /* the link before its joint; -1: it is the root */
    uint8_t is_first;                       /* 1: its joint is that of its body */
};

/* Source of an inner coordinate or freedom. Public arrays follow the declared order without
 * followers; inner ones follow the bodies, tree by tree.
 *     q_inner = multiplier q[from] + offset,  v_inner = multiplier v[from] */
struct tfa_coordinate {
    uint32_t from;
    double multiplier, offset;
};
struct tfa_freedom {
    uint32_t from;
    double multiplier;
};

/* A freedom that follows another one: v_follower = multiplier v_leader, the leader follows none.
 * Inner freedoms, the base's included. */
struct tfa_mimic {
    uint32_t follower, leader;
    double multiplier;
};

/* One main chain of the plan: from the root body of a tree to its deepest leaf. The tree's bodies
 * are first .. end - 1, and nothing else stands between. */
struct tfa_chain {
    uint32_t first, end;
    uint32_t length;
    const uint32_t *body; /* root first */
};

/* A body whose one flexible link has modes (dynamics/core/modes.h); in the frame of the body, about
 * its origin */
struct tfa_flexible {
    uint32_t body, frame; /* of the link */
    uint32_t n, first;    /* modes; the first of them among all */
    uint32_t v;           /* inner freedom of its first mode; all modes follow the joints */
    double mass, c[3];       /* of the link alone, and its centre */
    const double *B;         /* n rows: momentum per rate of a mode at eta = 0, angular first */
    const double *M, *K, *D; /* n x n */
    const double *limit;     /* n */
    int32_t riders;          /* first handle with a mass; -1: none */
};

/* What stands behind one child joint of a flexible link moves with its modes. Frame of the body,
 * without deformation. */
struct tfa_handle {
    uint32_t flexible;   /* index */
    double p[3];         /* origin of the joint */
    const double *shape; /* n rows of six: rotation, translation of that point */
    double mass, h[3], I[6]; /* of the links that are fixed to it, as in tfa_body */
    int32_t next;            /* the next one of that body with a mass; -1: none */
};

/* A constraint: its two frames on their links */
struct tfa_closure {
    int32_t frame[2];          /* of the links; -1: the world */
    uint32_t rows, unilateral; /* as in tfa_constraint */
    double R[2][9];            /* axes in the link, by columns */
    double p[2][3];            /* origin in the link */
    const char *name;
};

struct tfa_model {
    uint32_t flexible_bodies, handles, modes;
    uint32_t constraints;
    uint32_t bodies;           /* floating base included */
    uint32_t joints_nd;        /* bodies with more than one freedom */
    uint32_t parts;            /* of all fused bodies */
    uint32_t freedoms;         /* inner, base included */
    uint32_t inner_q;          /* inner coordinates, base excluded */
    uint32_t q_count, v_count; /* public: base excluded, followers excluded */
    uint32_t base_freedoms;
    uint32_t mimics;
    /* freedoms that move no mass or armature by themselves, only together with their leader or
     * followers: M is singular before the projection and regular after it */
    uint32_t massless_followers;
    uint32_t depth;          /* bodies on the longest path */
    uint32_t depth_freedoms; /* freedoms on the path with most of them */
    uint32_t frames, joints, trees;
    size_t mass_entries; /* entries of M that are not zero by structure, lower triangle */
    double gravity[3];
    double length; /* characteristic: metres that a radian counts in the metric of tips */
    double lever;  /* the largest of all bodies, m^2 */
    tfa_base base;
    tfa_model_summary summary;
    const struct tfa_body *body;
    /* bodies + 1; the last is the world */
    const struct tfa_mass_properties *without_payload;
    tfa_quad mass_without_payload; /* of all links, kg */
    const struct tfa_frame *frame;
    const struct tfa_xform_quad *frame_quad; /* of each frame: R and p */
    const struct tfa_link_mass *link;        /* of each frame */
    const uint32_t *link_order;              /* frames, parents first */
    const struct tfa_mass_properties *link_without_payload;
    const struct tfa_chain *chain;           /* one for each tree */
    const struct tfa_part *part;
    const struct tfa_xform_quad *part_quad;  /* of each part */
    const struct tfa_coordinate *coordinate; /* inner_q */
    const struct tfa_freedom *freedom;       /* freedoms - base_freedoms */
    const struct tfa_mimic *mimic;
    const double *armature; /* of each inner freedom */
    const double *damping;  /* of each inner freedom; NULL: none */
    const double *friction; /* the same */
    double friction_velocity;
    const struct tfa_flexible *flexible;
    const struct tfa_handle *handle;
    const struct tfa_closure *closure; /* one for each constraint */
    const tfa_joint_info *joint;
    const tfa_declared_joint *declared;
    uint32_t declared_joints;
    const tfa_body_info *body_info; /* its `name` is the body's */
    /* freedoms as nodes of Featherstone's expanded tree (2008, 6.1) */
    const int32_t *dof_parent; /* -1: none */
    const uint32_t *dof_depth; /* freedoms above it */
    const size_t *dof_row;     /* start of its row among the mass_entries */
    const char *name;
    uint8_t hash[32];
    char hash_text[65];
};

/* 1: the body of a frame has modes, of which a payload there would be a part */
static inline int tfa_frame_is_flexible(const struct tfa_model *m, uint32_t frame)
{
    const int32_t body = m->frame[frame].body;
    return body >= 0 && m->body[body].flexible >= 0;
}

#endif
