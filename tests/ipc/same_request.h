/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A request that went over a wire is the one that was sent, field by field.
 */
#ifndef TFA_TESTS_SAME_REQUEST_H
#define TFA_TESTS_SAME_REQUEST_H

#include <stdint.h>
#include <totalforce/dynamics.h>

/** Sizes of the robot that a request is about. */
typedef struct request_sizes {
    uint32_t q_count, v_count, base_freedoms, modes;
} request_sizes;

/** Fails unless `got` says what `sent` says: numbers, frames, joints and every array to the bit.
 *  Arrays without a number in them (no wrenches, no base) arrive as NULL. */
void assert_same_request(const request_sizes *sizes, const tfa_request *sent,
                         const tfa_request *got);

#endif
