/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#ifndef TFA_TOOLS_PEERS_MUJOCO_INERTIA_H
#define TFA_TOOLS_PEERS_MUJOCO_INERTIA_H

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <mujoco/mujoco.h>
#pragma GCC diagnostic pop
#include <totalforce/description.h>

/** Sets mass, centre of mass, principal axes and moments of every body that a joint moves. */
void peer_mujoco_set_inertias(mjModel *model, const tfa_description *description);

#endif
