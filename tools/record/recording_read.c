/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads recordings. Every size is checked before it is used.
 */
#include "recording.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

int recording_is_record(const tfa_tap_record *head)
{
    return head->request_bytes >= TFA_WIRE_LINE && head->reply_bytes >= TFA_WIRE_LINE &&
           head->bytes <= TFA_RECORDING_RECORD_MAX && head->request_bytes < head->bytes &&
           head->reply_bytes < head->bytes && head->request_bytes % 8 == 0 &&
           head->reply_bytes % 8 == 0 &&
           head->bytes == sizeof *head + head->request_bytes + head->reply_bytes;
}

/* Why this head is none of ours, in `text` if it needs words of its own; NULL: it is. */
static const char *fault_of_head(const tfa_recording_head *head, char *text, size_t size)
{
    if (memcmp(head->magic, TFA_RECORDING_MAGIC, sizeof head->magic) != 0)
        return "it is no recording of totalforce";
    if (head->order != TFA_RECORDING_ORDER)
        return "it was written by a machine of another byte order";
    if (head->version != TFA_RECORDING_VERSION) {
        snprintf(text, size,
                 "it is of version %u of the format, not %u: use the totalforce that recorded it, "
                 "or record again",
                 (unsigned)head->version, TFA_RECORDING_VERSION);
        return text;
    }
    if (head->request_line != sizeof(tfa_wire_request) ||
        head->reply_line != sizeof(tfa_wire_reply) || head->record_head != sizeof(tfa_tap_record) ||
        head->request_blocks != TFA_WIRE_REQUEST_BLOCKS ||
        head->reply_blocks != TFA_WIRE_REPLY_BLOCKS)
        return "it has other sizes than this version of the format: the head is damaged";
    return NULL;
}

static uint32_t checksum_of(const tfa_recording_head *head, const void *texts, size_t size)
{
    tfa_recording_head copy = *head;
    copy.checksum = 0;
    return recording_crc32(recording_crc32(0, &copy, sizeof copy), texts, size);
}

int recording_open(const void *bytes, size_t size, recording *r, char *text, size_t text_size)
{
    tfa_recording_head head;
    *r = (recording){.bytes = bytes, .size = size};
    if (size < sizeof head) {
        snprintf(text, text_size, "%zu bytes are too few for a recording", size);
        return -1;
    }
    memcpy(&head, bytes, sizeof head);
    const char *fault = fault_of_head(&head, text, text_size);
    const uint64_t rest = size - sizeof head;
    if (!fault && (head.settings_bytes > TFA_RECORDING_SETTINGS_MAX ||
                   head.urdf_bytes > TFA_RECORDING_URDF_MAX))
        fault = "settings or URDF are too large: the head is damaged";
    const uint64_t settings = tfa_recording_padded(head.settings_bytes),
                   texts = settings + tfa_recording_padded(head.urdf_bytes);
    if (!fault && texts > rest)
        fault = "it is cut off before its first record";
    if (!fault && checksum_of(&head, r->bytes + sizeof head, (size_t)texts) != head.checksum)
        fault = "the checksum of head, settings and URDF is wrong: they are damaged";
    if (fault) {
        if (fault != text)
            snprintf(text, text_size, "%s", fault);
        return -1;
    }
    r->settings = (const char *)r->bytes + sizeof head;
    r->settings_bytes = (size_t)head.settings_bytes;
    r->urdf = r->settings + settings;
    r->urdf_bytes = (size_t)head.urdf_bytes;
    r->first = sizeof head + (size_t)texts;
    return 0;
}

recording_state recording_next(const recording *r, size_t *at, recorded *out, char *text,
                               size_t text_size)
{
    const size_t rest = r->size - *at;
    if (rest == 0)
        return RECORDING_END;
    const tfa_tap_record *head = (const tfa_tap_record *)(const void *)(r->bytes + *at);
    if (rest >= sizeof *head && !recording_is_record(head)) {
        snprintf(text, text_size, "byte %zu: sizes that are no record's: the file is damaged", *at);
        return RECORDING_DAMAGED;
    }
    if (rest < sizeof *head || rest < head->bytes) {
        snprintf(text, text_size, "byte %zu: the last record is cut off", *at);
        return RECORDING_CUT_OFF;
    }
    const uint32_t checksum = recording_crc32(0, &head->request_bytes, head->bytes - 8);
    if (checksum != head->checksum) {
        snprintf(text, text_size,
                 "byte %zu: checksum %08" PRIx32 " in place of %08" PRIx32
                 ": the record is damaged",
                 *at, checksum, head->checksum);
        return RECORDING_DAMAGED;
    }
    *out = (recorded){.head = head,
                      .request = (const void *)(head + 1),
                      .reply =
                          (const void *)((const unsigned char *)(head + 1) + head->request_bytes)};
    *at += head->bytes;
    return RECORDING_RECORD;
}
