/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Writes recordings: in blocks of whole records, so that a file that ends early is cut off at one.
 */
#include "recording.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BLOCK ((size_t)1 << 20)

/* @return bytes written: fewer than `size` after an error */
static size_t write_bytes(recording_writer *w, const void *bytes, size_t size)
{
    size_t done = 0;
    while (done < size && !w->error) {
        const ssize_t n = write(w->fd, (const char *)bytes + done, size - done);
        if (n < 0 && errno != EINTR)
            w->error = errno;
        else if (n == 0)
            w->error = ENOSPC;
        done += n > 0 ? (size_t)n : 0;
    }
    return done;
}

/* After an error: the end of the last whole record among the first `done` bytes. */
static size_t whole_records(const unsigned char *bytes, size_t done, uint64_t *records)
{
    size_t at = 0;
    for (tfa_tap_record head; at + sizeof head <= done; at += head.bytes) {
        memcpy(&head, bytes + at, sizeof head);
        if (head.bytes > done - at)
            break;
        ++*records;
    }
    return at;
}

/* Writes whole records. */
static void write_records(recording_writer *w, const unsigned char *bytes, size_t size,
                          uint64_t records)
{
    const size_t done = write_bytes(w, bytes, size);
    if (done == size) {
        w->file_bytes += size;
        return;
    }
    uint64_t whole = 0;
    w->file_bytes += whole_records(bytes, done, &whole);
    w->records -= records - whole;
}

static uint64_t count_records(const unsigned char *bytes, size_t size)
{
    uint64_t records = 0;
    (void)whole_records(bytes, size, &records);
    return records;
}

static void flush(recording_writer *w)
{
    if (w->used)
        write_records(w, w->block, w->used, count_records(w->block, w->used));
    w->used = 0;
}

int recording_create(recording_writer *w, const char *path,
                     const tfa_recording_description *description, const void *texts)
{
    const size_t size = tfa_recording_padded(description->settings_bytes) +
                        tfa_recording_padded(description->urdf_bytes);
    tfa_recording_head head = {.magic = TFA_RECORDING_MAGIC,
                               .version = TFA_RECORDING_VERSION,
                               .order = TFA_RECORDING_ORDER,
                               .settings_bytes = description->settings_bytes,
                               .urdf_bytes = description->urdf_bytes,
                               .request_line = sizeof(tfa_wire_request),
                               .reply_line = sizeof(tfa_wire_reply),
                               .record_head = sizeof(tfa_tap_record),
                               .request_blocks = TFA_WIRE_REQUEST_BLOCKS,
                               .reply_blocks = TFA_WIRE_REPLY_BLOCKS};
    head.checksum = recording_crc32(recording_crc32(0, &head, sizeof head), texts, size);
    *w = (recording_writer){
        .fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666)};
    if (w->fd < 0) {
        w->error = errno;
        return w->error;
    }
    w->block = malloc(BLOCK);
    if (!w->block)
        w->error = ENOMEM;
    (void)write_bytes(w, &head, sizeof head);
    (void)write_bytes(w, texts, size);
    w->file_bytes = w->error ? 0 : sizeof head + size;
    return w->error;
}

void recording_add(recording_writer *w, const tfa_tap_record *record)
{
    tfa_tap_record head = *record;
    if (w->error)
        return;
    head.checksum = recording_crc32(recording_crc32(0, &head.request_bytes, sizeof head - 8),
                                    record + 1, head.bytes - sizeof head);
    if (w->used + head.bytes > BLOCK)
        flush(w);
    if (w->error)
        return;
    w->records++;
    if (head.bytes > BLOCK) { /* alone, head and rest */
        const size_t before = write_bytes(w, &head, sizeof head),
                     after = write_bytes(w, record + 1, head.bytes - sizeof head);
        if (before + after == head.bytes)
            w->file_bytes += head.bytes;
        else
            w->records--;
        return;
    }
    memcpy(w->block + w->used, &head, sizeof head);
    memcpy(w->block + w->used + sizeof head, record + 1, head.bytes - sizeof head);
    w->used += head.bytes;
}

int recording_close(recording_writer *w)
{
    if (w->fd < 0)
        return w->error;
    if (!w->error)
        flush(w);
    if (w->error)
        (void)!ftruncate(w->fd, (off_t)w->file_bytes); /* readers accept a part of a record, too */
    if (close(w->fd) != 0 && !w->error)
        w->error = errno;
    w->fd = -1;
    free(w->block);
    w->block = NULL;
    return w->error;
}
