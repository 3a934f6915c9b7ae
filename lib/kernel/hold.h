/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joints without acceleration: locked ones, exactly; held ones, as an approximation with a
 * certificate. methods.md section 7.
 */
#ifndef TFA_KERNEL_HOLD_H
#define TFA_KERNEL_HOLD_H

#include "kernel/state.h"

/* Puts the STOP_ bits given in force: which bodies are grounded, rigid, silent. With `silent`,
 * bodies whose motion decides nothing are left out of pose and velocity, too. */
void TFA_V(hold_plan)(struct state *s, uint32_t bits, int silent);

/* As aba, aba_factor, aba_solve and aba_energy, while s->holding. */
void TFA_V(hold)(struct state *s, const num *tau, num *qdd);
void TFA_V(hold_factor)(struct state *s);
void TFA_V(hold_solve)(struct state *s, const num *tau, num *qdd);
num TFA_V(hold_energy)(struct state *s, const num *tau);

/* The error of s->qdd, which held joints led astray, by the factors with them free. */
tfa_certificate TFA_V(hold_certificate)(struct state *s);

/* Holds every joint, then lets go of those that matter until the relative error in the energy norm
 * is within the tolerance. Leaves s->qdd. */
tfa_certificate TFA_V(hold_auto)(struct state *s, double tolerance);

#endif
