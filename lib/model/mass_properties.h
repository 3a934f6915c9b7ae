/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mass properties of a model with its payloads: constants of the bodies, their public description,
 * totals.
 */
#ifndef TFA_MODEL_MASS_PROPERTIES_H
#define TFA_MODEL_MASS_PROPERTIES_H

#include "model/model.h"

/* Scratch: a body with its payloads, and its pose at q = 0 */
struct tfa_mass_scratch {
    struct tfa_mass_properties sum;
    tfa_quad R[9], p[3]; /* body axes to root link axes; origin in the root link's frame */
    double length;       /* m, or m^2: sizes.c */
    uint8_t has_mass;    /* its subtree has mass or inertia */
};

/**
 * Fills mass, h, I and `regular` of body[], the masses of quad[], info[], m->massless_followers and
 * the masses, com and singular_body of m->summary from m->without_payload and the payloads. Reads
 * m->frame, m->part, m->chain, m->coordinate and the rest of body[]. Payloads on links that the
 * model does not have are left out.
 *
 * @param weight  scratch, m->bodies + 1
 * Cannot fail: payloads were checked. Cost: O(bodies + payloads x frames).
 */
void tfa_compute_mass_properties(struct tfa_model *m, struct tfa_body *body,
                                 struct tfa_body_quad *quad, tfa_body_info *info,
                                 struct tfa_mass_scratch *mass_scratch, const tfa_payload *payloads,
                                 size_t payload_count);

/** Fills the masses of link[] and link_quad[] from m->link_without_payload and the payloads, as
 *  tfa_compute_mass_properties does of bodies. */
void tfa_compute_links(const struct tfa_model *m, struct tfa_link_mass *link,
                       struct tfa_mass_properties *quad, const tfa_payload *payloads,
                       size_t payload_count);

#endif
