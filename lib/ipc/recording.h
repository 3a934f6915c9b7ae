/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A recording: a file of requests and answers of one robot, little endian.
 *
 *   tfa_recording_head   64 bytes
 *   settings             JSON: the robot, and all that shapes its answers
 *                        (service/robots/describe.c)
 *   URDF                 the text of the robot's file
 *   records              tfa_tap_record (tap.h), each with its checksum
 *
 * Settings and URDF are filled up with zeros to a multiple of 8. The last record may be cut off: a
 * file is readable up to there. Checksums are CRC-32 (IEEE 802.3, reflected, as zlib's), of
 * head (with a checksum of 0), settings and URDF as they stand in the file, and of a record after
 * its first 8 bytes.
 */
#ifndef TFA_IPC_RECORDING_H
#define TFA_IPC_RECORDING_H

#include "ipc/tap.h"

#define TFA_RECORDING_MAGIC "TFARECRD"
/** Incremented with every change of this file, of tap.h and of wire.h. */
#define TFA_RECORDING_VERSION 8u
#define TFA_RECORDING_ORDER 0x01020304u
#define TFA_RECORDING_SETTINGS_MAX ((uint64_t)16 << 20)
#define TFA_RECORDING_URDF_MAX ((uint64_t)256 << 20)
/** Bytes of one record. */
#define TFA_RECORDING_RECORD_MAX TFA_TAP_RING_MAX

typedef struct tfa_recording_head {
    char magic[8];
    uint32_t version, order;             /**< order: TFA_RECORDING_ORDER as its writer stores it */
    uint64_t settings_bytes, urdf_bytes; /**< without the zeros */
    uint32_t checksum;                   /**< of this head and of both, with the zeros */
    uint16_t request_line, reply_line, record_head; /**< sizes, as a check */
    uint16_t request_blocks, reply_blocks;          /**< TFA_WIRE_REQUEST_BLOCKS, _REPLY_BLOCKS */
    uint16_t reserved[9];
} tfa_recording_head;

_Static_assert(sizeof(tfa_recording_head) == 64, "a recording's head is one cache line");

/** Description of a robot by the daemon: this head, then settings and URDF as in a recording. */
typedef struct tfa_recording_description {
    uint64_t settings_bytes, urdf_bytes;
} tfa_recording_description;

static inline uint64_t tfa_recording_padded(uint64_t bytes)
{
    return (bytes + 7) & ~(uint64_t)7;
}

#endif
