/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The compiled model as the kernels read it. Six-vectors are angular first inside the library.
 */
#ifndef TFA_MODEL_MODEL_H
#define TFA_MODEL_MODEL_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/model.h>

/* Joint kinds after compilation: each body frame is turned so that its joint's motion subspace
 * consists of unit axes of that frame. */
enum tfa_kind {
    TFA_KIND_REVOLUTE = 0,  /* H = e_3: rotation about z */
    TFA_KIND_PRISMATIC = 1, /* H = e_6: translation along z */
    TFA_KIND_PLANAR = 2,    /* H = e_4 e_5 e_3: velocity in the moved plane, then rotation */
    TFA_KIND_FREE = 3,      /* H = e_4 e_5 e_6 e_1 e_2 e_3: linear, then angular velocity */
};

/* M is kept by rows of ancestors; a chain of N bodies has N (N+1) / 2 entries. Above this many (a
 * chain of 2895, 32 MiB in double) a workspace has no room for M, and the methods that need it say
 * so: O(N d^2) methods lose to the others long before. */
#define TFA_MASS_ENTRIES_MAX ((size_t)4 << 20)

/* Constants of one body. Frame i is fixed in body i with its origin on joint i. */
struct tfa_body {
    double E[9];     /* rotation from the parent's frame to the joint's frame at q = 0, row major */
    double r[3];     /* origin of the joint in the parent's frame, m */
    double mass;     /* kg */
    double h[3];     /* mass times centre of mass, frame i, kg m */
    double I[6];     /* xx xy xz yy yz zz about the origin of frame i, kg m^2 */
    double armature; /* added to each freedom of the joint */
    int32_t parent;  /* body index, -1: the world; always below the own index */
    uint32_t link;   /* frame of the link that gives it its name */
    uint32_t q, v;   /* first coordinate and first freedom, the base's six freedoms included in v */
    uint8_t kind;    /* enum tfa_kind */
    uint8_t n;       /* freedoms: 1, 3 or 6 */
    uint8_t regular; /* 1: the rigid inertia is safely positive definite */
    uint8_t base;    /* 1: the floating base; its q and v come in fields of their own */
    uint8_t leaf;    /* 1: no body hangs from it */
    uint8_t last;    /* 1: the last child of its parent, the first to be folded inward */
    int32_t multi;   /* index among bodies with n > 1, else -1 */
    int32_t tree;    /* root body of the tree that it stands in */
    uint32_t depth;  /* bodies from the root to here, this one included */
};

/* A link of the file: a frame on a body. */
struct tfa_frame {
    int32_t body; /* -1: fixed to the world */
    double R[9];  /* rotation from the link frame to the body frame (or the world) */
    double p[3];  /* origin of the link frame in the body frame */
    const char *name;
};

/* One main chain of the plan: from the root body of a tree to its deepest leaf. */
struct tfa_chain {
    uint32_t length;
    const uint32_t *body; /* root first */
};

struct tfa_model {
    uint32_t bodies;   /* floating base included */
    uint32_t multis;   /* bodies with more than one freedom */
    uint32_t freedoms; /* all, base included */
    uint32_t q_count;  /* coordinates of the joints, base excluded */
    uint32_t base_freedoms;
    uint32_t depth;          /* bodies on the longest path */
    uint32_t depth_freedoms; /* freedoms on the path with most of them */
    uint32_t frames, joints, trees;
    size_t mass_entries; /* entries of M that are not zero by structure, lower triangle */
    double gravity[3];
    tfa_base base;
    tfa_model_summary summary;
    const struct tfa_body *body;
    const struct tfa_frame *frame;
    const struct tfa_chain *chain; /* one for each tree */
    const tfa_joint_info *joint;
    const char *const *body_name;
    /* freedoms as nodes of Featherstone's expanded tree (2008, 6.1) */
    const int32_t *dof_parent; /* -1: none */
    const uint32_t *dof_depth; /* freedoms above it */
    const size_t *dof_row;     /* start of its row among the mass_entries */
    const char *name;
    uint8_t hash[32];
    char hash_text[65];
};

#endif
