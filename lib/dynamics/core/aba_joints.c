/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Steps of the articulated-body algorithm that the files of a kernel share.
 */
#include "dynamics/core/aba_step.h"

#include "dynamics/core/aba_joints.h"

void TFA_V(aba_backward_body)(struct state *s, uint32_t i, const num *tau, int flags)
{
    aba_backward_step(s, i, tau, flags);
}
