/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A draft is a model under construction: ordered, merged, aligned, in extended precision.
 */
#ifndef TFA_MODEL_DRAFT_H
#define TFA_MODEL_DRAFT_H

#include "model/model.h"

typedef long double ext; /* rounding of the constants happens once, when the draft is finished */

struct draft_body {
    ext E[9], r[3];
    ext mass, h[3], I[6];
    double armature;
    int32_t parent;
    uint32_t link; /* the link that gives the body its name: the child of its joint */
    int32_t joint; /* description joint, -1 for the floating base */
    uint8_t kind, n, base;
};

struct draft_frame {
    int32_t body;
    ext R[9], p[3];
};

struct draft {
    const tfa_description *description;
    struct draft_body *body;
    struct draft_frame *frame; /* one for each link */
    uint32_t *order;           /* joints, parents first, document order otherwise */
    uint32_t *joint_body;      /* body moved by a joint of the description */
    uint32_t bodies;
    uint32_t root;    /* root link */
    uint32_t movable; /* joints that are not fixed */
};

/* Orders the joints parents first: TFA_E_MODEL on loops, two parents and unreachable links. */
int tfa_draft_order(struct draft *d, tfa_report *report);

/* Refuses numbers that are none, negative masses and armatures, quaternions without direction. */
int tfa_draft_values(const struct draft *d, const tfa_model_options *options, tfa_report *report);

/* Merges fixed joints, aligns frames, sums inertias. Needs the order. */
int tfa_draft_merge(struct draft *d, const tfa_model_options *options, tfa_report *report);

/* Refuses what cannot be computed: inertias that are not positive semidefinite, massless leaves. */
int tfa_draft_check(const struct draft *d, tfa_report *report);

/* Fills *d; release with tfa_draft_free also after an error. */
int tfa_draft_make(struct draft *d, const tfa_description *description,
                   const tfa_model_options *options, tfa_report *report);
void tfa_draft_free(struct draft *d);

#endif
