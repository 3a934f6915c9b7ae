/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encoding by Fast CDR as the type support of rmw_fastrtps drives it: field after field in the
 * order of the .msg file, here of the description in messages.h.
 */
#ifndef TESTS_ROS2_FASTCDR_WIRE_H
#define TESTS_ROS2_FASTCDR_WIRE_H

#include "messages.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Encodes a sample, header included. Fast CDR skips padding and leaves there what the buffer had:
 * `filling`. It ends with the last field; `out->padding` becomes what is missing to a multiple of
 * four. */
void fastcdr_encode(const msg *m, const void *sample, uint8_t filling, msg_bytes *out);

/** Decodes into a sample, which dds_sample_free frees. Its former contents are forgotten.
 * @return false: the bytes end too early, or more than padding is left */
bool fastcdr_decode(const msg *m, const msg_bytes *in, void *sample);

#ifdef __cplusplus
}
#endif

#endif
