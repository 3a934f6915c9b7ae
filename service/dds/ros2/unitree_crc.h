/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The CRC that Unitree's robots put into the last word of a LowState_.
 *
 * It covers the message as a C struct of natural alignment without that word, padding zero, taken
 * as little-endian 32-bit words. These are not the bytes on the wire, where CDR pads less.
 */
#ifndef TFA_ROS2_UNITREE_CRC_H
#define TFA_ROS2_UNITREE_CRC_H

#include <stddef.h>
#include <stdint.h>

#include <idl/unitree.h>

/** CRC-32/MPEG-2 of words, each with its highest bit first: polynomial 0x04c11db7, start value
 * 0xffffffff, nothing reflected or inverted. */
uint32_t tfa_unitree_crc32(const uint32_t *word, size_t count);

/** What state->crc of a quadruped has to be. Reads all other members, no padding. */
uint32_t tfa_unitree_go_crc(const unitree_go_msg_dds__LowState_ *state);

/** What state->crc of a humanoid has to be. Reads all other members, no padding. */
uint32_t tfa_unitree_hg_crc(const unitree_hg_msg_dds__LowState_ *state);

#endif
