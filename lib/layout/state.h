/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Everything that changes while a kernel computes, struct state, as the layout has it
 * (layout_state.h of the layout's folder).
 */
#ifndef TFA_LAYOUT_STATE_H
#define TFA_LAYOUT_STATE_H

#include "layout_body.h"
#include "spatial/dense.h"
#include "spatial/spatial.h"

/* A body with more than one freedom. H is 6 x n, its columns here as rows of six. */
struct joint_nd {
    xform part[6];   /* fused: from the frame of the part before to that of this part */
    uint32_t locked; /* bit k: freedom k has no acceleration (lock.c) */
    num H[36];       /* motion subspace */
    num U[36];       /* IA H */
    num L[36];       /* LDL^T factors of D = H^T U + R */
    num u[6];        /* tau - H^T pA */
};

#include "layout_state.h"

/* The projected inertia of a body without children, which a specialised kernel hides
 * (specialised_state.h). */
#ifndef hide_inertia
#define hide_inertia(S) ((void)(S))
#endif

#endif
