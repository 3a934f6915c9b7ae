/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Articulated bodies with joints that a request locks: exact.
 */
#ifndef TFA_DYNAMICS_CORE_LOCK_H
#define TFA_DYNAMICS_CORE_LOCK_H

#include "layout/state.h"

/* Classifies the bodies by s->lock: grounded, rigid, skipped. With `may_skip_unused`, bodies whose
 * motion decides nothing are left out of pose and velocity, too. */
void TFA_V(lock_plan)(struct state *s, int may_skip_unused);

/* As aba, aba_factor and aba_solve, while s->locked. */
void TFA_V(lock)(struct state *s, const num *tau, num *qdd);
void TFA_V(lock_factor)(struct state *s);
void TFA_V(lock_solve)(struct state *s, const num *tau, num *qdd);

#endif
