/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Files of recordings: written record by record, read from memory. The format: ipc/recording.h.
 */
#ifndef TOOLS_RECORD_RECORDING_H
#define TOOLS_RECORD_RECORDING_H

#include <stddef.h>
#include <stdint.h>
#include <zlib.h>

#include "ipc/recording.h"

/* ---- recording_write.c ---- */

/** A file that grows. Zero-initialise. */
typedef struct recording_writer {
    int fd;
    int error;            /**< errno of the first write that failed; nothing is written after it */
    unsigned char *block; /**< whole records that are not in the file yet */
    size_t used;
    uint64_t file_bytes; /**< in the file: a whole number of records */
    uint64_t records;    /**< in the file or in the block */
} recording_writer;

/** Creates a file, or empties it, with head, settings and URDF. @return 0, or errno */
int recording_create(recording_writer *w, const char *path,
                     const tfa_recording_description *description, const void *texts);
/** Adds a record, a copy with its checksum. After an error it does nothing. */
void recording_add(recording_writer *w, const tfa_tap_record *record);
/** Writes what is left; a record that could not be written whole is cut off.
 *  @return 0, or errno of the first failure */
int recording_close(recording_writer *w);

/* ---- recording_read.c ---- */

/** A file in memory; nothing in it is trusted. */
typedef struct recording {
    const unsigned char *bytes;
    size_t size;
    const char *settings; /**< JSON, settings_bytes, without a final 0 */
    size_t settings_bytes;
    const char *urdf;
    size_t urdf_bytes;
    size_t first; /**< of the first record */
} recording;

/** A record. Its request and reply are lines and payloads in wire form, 8 bytes aligned. */
typedef struct recorded {
    const tfa_tap_record *head;
    const tfa_wire_request *request;
    const tfa_wire_reply *reply;
} recorded;

typedef enum recording_state {
    RECORDING_END,     /**< after the last record */
    RECORDING_RECORD,  /**< a record */
    RECORDING_CUT_OFF, /**< the last record is incomplete */
    RECORDING_DAMAGED, /**< the file is not what was written */
} recording_state;

/** Reads head, settings and URDF. `bytes` is 8 bytes aligned and must stay.
 *  @return 0, or -1 and why not in `text` */
int recording_open(const void *bytes, size_t size, recording *r, char *text, size_t text_size);

/** The record at *at, which moves to the next one. `text`: what is damaged or cut off. */
recording_state recording_next(const recording *r, size_t *at, recorded *out, char *text,
                               size_t text_size);

/** A whole record as in a tap or a file: 8-byte multiples that add up. */
int recording_is_record(const tfa_tap_record *head);

/** CRC-32 (IEEE 802.3, reflected) of `size` more bytes; begin with 0. */
static inline uint32_t recording_crc32(uint32_t crc, const void *bytes, size_t size)
{
    return (uint32_t)crc32_z(crc, bytes, size);
}

#endif
