/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The peers of this build.
 */
#include "peer.h"

const struct peer *const peer_table[] = {
#ifdef HAVE_MUJOCO
    &peer_mujoco,
#endif
#ifdef HAVE_KDL
    &peer_kdl,
#endif
    NULL};

const struct peer_lambda peer_lambda_table[] = {
#ifdef HAVE_MUJOCO
    {&peer_mujoco, peer_mujoco_lambda},
#endif
    {NULL, NULL}};
