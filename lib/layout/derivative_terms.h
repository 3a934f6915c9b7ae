/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What derivatives keep of a freedom and of a body (dynamics/derivatives).
 */
#ifndef TFA_LAYOUT_DERIVATIVE_TERMS_H
#define TFA_LAYOUT_DERIVATIVE_TERMS_H

#include "spatial/spatial.h"
#include "spatial/vec6.h"

/* In world axes about a reference point: of a freedom, by components e of spatial vectors, angular
 * first. With psi = v x S and psi_dot = a x S + v x psi, v and a before the joint, and rate = psi +
 * v x S, v behind it. A follower's are times its multiplier. */
struct freedom_terms {
    quad vector[6];  /* psi_dot, rate, S, S */
    quad angular[3]; /* psi, S, 0, 0 */
};

/* and of a body: v and a its own, everything else of its subtree */
struct subtree {
    svec v, a, f;
    num m;
    vec3 h, P; /* first moment, linear momentum */
    sym3 I;
    mat3 A; /* Coriolis matrix: moment by rotation */
};

#endif
