/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Drafts: models under construction, in quadruple precision.
 */
#ifndef TFA_MODEL_DRAFT_DRAFT_H
#define TFA_MODEL_DRAFT_DRAFT_H

#include "model/ext.h"
#include "model/mass_properties.h"
#include "model/model.h"
#include "model/report/report_messages.h"

/* Most joints of a fused body: its freedoms */
#define TFA_PARTS_MAX 6

/* State of a link */
struct draft_link {
    long double inertia[6]; /* as the description states it, or repaired */
    uint8_t present;        /* part of the scene */
    uint8_t has_mass;       /* later: or its subtree has */
    uint8_t loaded;         /* it carries a payload */
    uint8_t tip;            /* the scene names it as a tip */
    int32_t handle;         /* on which it rides, fixed to a flexible link; or -1 */
    uint8_t moves;          /* with a joint that is not fixed, or with the base */
    uint32_t carrier;       /* first link of the body that it is part of */
    long double best;       /* of a carrier: largest least moment of a link of its body */
};

/* State of a joint. Mimics are resolved: the leader follows none. */
struct draft_joint {
    uint8_t fate;     /* enum tfa_fate */
    uint8_t actuated; /* the scene names it */
    uint8_t has_rotor; /* of the scene: `rotor` is its inertia as seen by the joint */
    uint8_t freedom; /* index among its body's joints: 0 unless fused */
    int32_t body;    /* the body that it moves, when it moves */
    int32_t leader;  /* description joint that it mimics, or -1 */
    double rotor;
    ext multiplier, offset;
    ext q[7];                  /* where it is locked */
    uint32_t q_index, v_index; /* public: its first coordinate in q, its first freedom in v */
    uint32_t number;           /* public: its index */
};

/* New frame of a body in its present one: turned about z (cosine, sine), origin moved along z. */
struct draft_move {
    ext c, s, w;
};

struct draft_body {
    ext E[9], r[3];
    struct tfa_mass_properties sum; /* of its links, payloads excluded */
    double armature;
    int32_t parent;
    uint32_t link;  /* the link that gives the body its name: the child of its (last) joint */
    int32_t joint;  /* description joint, -1 for the floating base; fused: the last one */
    uint32_t first; /* fused: its n parts start here in draft.part */
    uint8_t kind, n, base;
    uint8_t loaded;  /* a link of it carries a payload */
    uint8_t aligned; /* its x axis lies on the common normal with a child's axis */
    int32_t flexible, handle; /* as in tfa_body */
    uint8_t axial;            /* as in tfa_body, and its a and d */
    ext a, d;
    struct draft_move move;
};

struct draft_part {
    ext E[9], r[3];
    uint8_t kind;
    uint32_t joint; /* of the description */
};

struct draft_frame {
    int32_t body;
    uint8_t part;    /* as in tfa_frame */
    uint32_t number; /* its index among the links that are present */
    ext R[9], p[3];
};

/* A flexible link on its body; a child joint of one (draft_modes.c) */
struct draft_flexible {
    const tfa_link_modes *modes;
    uint32_t link, body;
};
struct draft_handle {
    uint32_t flexible, joint; /* of the description */
    const double *shape;
};

struct draft {
    const tfa_description *description;
    const tfa_model_options *options; /* never NULL */
    struct draft_link *link;          /* one for each link */
    struct draft_frame *frame;        /* one for each link */
    struct draft_joint *joint;        /* one for each joint */
    struct draft_body *body;          /* parents first; when finished, tree by tree */
    struct draft_part *part;
    struct draft_body world; /* merged links that do not move, in the frame of the root */
    ext mass;                /* of all links that are present */
    long double rounding;    /* rounding of inertias in the file, kg m^2 (draft_inertias.c) */
    struct tfa_mass_scratch *mass_scratch; /* scratch of tfa_compute_mass_properties: bodies + 1 */
    uint32_t *order;                       /* joints, parents first, document order otherwise */
    struct draft_flexible *flexible;       /* in the order of their links */
    struct draft_handle *handle;
    uint32_t flexible_bodies, handles, modes;
    const tfa_constraint *constraint[TFA_MAX_CONSTRAINTS]; /* those of the file first */
    uint32_t constraints;
    uint32_t bodies, parts;
    uint32_t joints, frames;   /* public */
    uint32_t q_count, v_count; /* public, base excluded */
    uint32_t root;             /* root link of the scene */
    uint8_t bests;             /* link.best is computed */
};

static inline int draft_moves(const struct draft *d, size_t joint)
{
    const uint8_t fate = d->joint[joint].fate;
    return fate == TFA_FATE_MOVES || fate == TFA_FATE_FUSED || fate == TFA_FATE_FOLLOWS;
}

/* Armature of a joint with these options */
static inline double draft_armature(const struct draft *d, size_t joint)
{
    const tfa_joint *j = &d->description->joints[joint];
    return j->armature + (d->options->rotor_inertia ? j->rotor : 0) + d->joint[joint].rotor;
}

/* Damping and friction in use, on each of its freedoms */
static inline double draft_damping(const struct draft *d, size_t joint)
{
    return d->options->damping ? d->description->joints[joint].damping : 0;
}

static inline double draft_friction(const struct draft *d, size_t joint)
{
    return d->options->friction ? d->description->joints[joint].friction : 0;
}

/* ---- passes of tfa_draft_make, in this order; each reports its refusals ---- */

/* Orders the joints parents first: TFA_E_MODEL on loops, two parents and unreachable links. */
int tfa_draft_order(struct draft *d, tfa_report *report);

/* Refuses numbers that are not finite, negative masses and armatures, invalid quaternions. */
int tfa_draft_values(struct draft *d, tfa_report *report);

/* Applies root, tips, payloads and rotors of the scene. */
int tfa_draft_scene(struct draft *d, tfa_report *report);

/* Applies the locks of the scene. */
int tfa_draft_locks(struct draft *d, tfa_report *report);

/* Resolves chained mimics and applies the policy for them. */
int tfa_draft_mimics(struct draft *d, tfa_report *report);

/* Removes the trees that carry none of the tips. */
int tfa_draft_trees(struct draft *d, tfa_report *report);

/* Refuses, repairs or warns of inertias that no rigid body has. */
int tfa_draft_inertias(struct draft *d, tfa_report *report);

/* Refuses or locks joints that move no mass. */
int tfa_draft_leaves(struct draft *d, tfa_report *report);

/* Merges rigidly connected links into bodies, aligns frames, sums inertias. */
int tfa_draft_merge(struct draft *d, tfa_report *report);

/* Refuses a floating base without mass that its joints do not constrain. */
int tfa_draft_base(struct draft *d, tfa_report *report);

/* Fuses massless bodies with the one body that hangs from them. */
int tfa_draft_fuse(struct draft *d, tfa_report *report);

/* Refuses robots whose M is singular at every q. */
int tfa_draft_singular(struct draft *d, tfa_report *report);

/* Turns and moves frames so that as many constant transforms as possible are screws. */
int tfa_draft_axial(struct draft *d, tfa_report *report);

/* Sorts bodies tree by tree, parents first; numbers frames, joints and coordinates. */
int tfa_draft_sort(struct draft *d, tfa_report *report);

/* Finds flexible bodies, and what rides on their handles. */
int tfa_draft_modes(struct draft *d, tfa_report *report);

/* Collects the constraints of file and scene. Those of the scene whose frames are not there, or do
 * not move against each other, are refused; those of the file are left out with a note. */
int tfa_draft_constraints(struct draft *d, tfa_report *report);

/* Marks the joints that the scene says have a motor. */
int tfa_draft_actuated(struct draft *d, tfa_report *report);

/* Momentum per rate of a mode about the origin of its body, body axes: angular, linear */
void tfa_draft_momentum(const struct draft *d, const struct draft_flexible *x, size_t mode,
                        ext a[3], ext l[3]);

/* ---- notes, for a robot without errors ---- */

/* Notes the mass of a fixed base, which is not used. Nothing where the root is `world`. */
void tfa_draft_note_base(const struct draft *d, tfa_report *report);

/* Warns of a robot with a fixed base in which all joints are fixed. */
void tfa_draft_note_immobile(const struct draft *d, tfa_report *report);

/* Notes the items of the description that the model does not use. */
void tfa_draft_note_unused(const struct draft *d, tfa_report *report);

/* Notes how many rotations were snapped, and the largest change. */
void draft_note_snaps(const struct draft *d, tfa_report *report);

/* ---- functions of the passes ---- */

/* Index of the link, or -1. */
int32_t tfa_draft_find_link(const struct draft *d, const char *name);

/* Refuses an unknown link and names the most similar links. */
int tfa_draft_refuse_link(const struct draft *d, const char *code, const char *name,
                          const char *what, tfa_report *report);

/* Index of the joint, or -1. */
int32_t tfa_draft_find_joint(const struct draft *d, const char *name);

/* Refuses an unknown joint and names the most similar joints. */
int tfa_draft_refuse_joint(const struct draft *d, const char *code, const char *name,
                           const char *what, tfa_report *report);

/* Axes of a constraint's frame in its link, by columns */
void tfa_constraint_axes(ext R[9], const double pose[7]);

/* Adds the inertia of a link, about the origin of the frame that its own frame is in: its body's,
 * or the root's. */
void tfa_draft_add_link(const struct draft *d, size_t link, struct tfa_mass_properties *sum);

/* Replaces R by the rotation by right angles within `limit` (rad) of it, if there is one. Returns
 * the angle of the change, rad. */
long double draft_snap(ext R[9], double limit);

/* Warns of links that move by themselves and have no <inertial>; an error with the policy
 * strict-physical. next: by body, the one that it is fused with; 0: none. */
int tfa_draft_check_massless(const struct draft *d, const uint32_t *next, tfa_report *report);

/* Writes the options with which a refused description compiles, in the syntax of the report; NULL
 * if there are none. Compiles it with each candidate. */
const char *tfa_find_remedy(const tfa_description *description, const tfa_model_options *options,
                            const tfa_report *report, char *text, size_t size);

/* Fills *d; release with tfa_draft_free also after an error. */
int tfa_draft_make(struct draft *d, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report);
void tfa_draft_free(struct draft *d);

/* Axes (columns of R, row major) that a joint's body frame has in the joint frame: z along the
 * joint axis, x and y those of a planar joint (docs/conventions.md). TFA_E_MODEL: no direction. */
int tfa_joint_axes(ext R[9], const tfa_joint *joint);

/* Pose of a joint's child at q: rotation (child axes to joint axes) and translation in the joint
 * frame */
int tfa_joint_transform(const tfa_joint *joint, const ext *q, ext R[9], ext t[3]);

#endif
