/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Payloads: their validation, and their addition to bodies.
 */
#ifndef TFA_MODEL_PAYLOAD_H
#define TFA_MODEL_PAYLOAD_H

#include "model/model.h"

/* Problem with the numbers of a payload and its remedy, for a message; NULL: none. */
const char *tfa_payload_error(const tfa_payload *payload);

/* 1: ten finite numbers of a payload are physical: mass not negative, inertia positive
 * semidefinite. No allocation. */
uint8_t tfa_payload_is_physical(const double numbers[10]);

/* Adds a rigid mass m with centre c and inertia s (xx xy xz yy yz zz about c, along the axes that R
 * turns into those of `properties`): I += R s R^T + m (c.c 1 - c c^T), h += m c. */
void tfa_mass_properties_add(struct tfa_mass_properties *properties, tfa_quad m,
                             const tfa_quad c[3], const tfa_quad R[9], const tfa_quad s[6]);

/* Adds a payload to the body that carries it; `frame`: that of its link, fixed in the body. */
void tfa_mass_properties_add_payload(struct tfa_mass_properties *properties,
                                     const struct tfa_xform_quad *frame,
                                     const tfa_payload *payload);

/**
 * Adds a payload to the constants of a body: mass, h, I and `regular`. Double precision, no
 * allocation: for a request's own copy of the body.
 *
 * @param frame    of the link that carries it: fixed in that body (part 0)
 * @param numbers  mass, com (3), inertia (6) as in tfa_payload
 */
void tfa_body_add_payload(struct tfa_body *body, const struct tfa_frame *frame,
                          const double numbers[10]);

/* The same without updating `regular`, which takes longer than the forward dynamics of an arm: for
 * methods that invert no inertia. */
void tfa_body_add_payload_inertia(struct tfa_body *body, const struct tfa_frame *frame,
                                  const double numbers[10]);

/* Sums of their traces of the inertia, at the model's longest lever, kg m^2, and of the mass, kg,
 * for the sentinel */
void tfa_payload_size(const struct tfa_model *m, uint32_t count, const double *numbers,
                      double size[2]);

/* 1: LDL^T of the 6 x 6 inertia, scaled to unit diagonal, has no pivot that is nearly zero. */
uint8_t tfa_inertia_is_regular(const struct tfa_body *body);

#endif
