/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: the file of a recording. As it is it must be read without harm; with checksums
 * that fit, its settings and records are read as well, decoded for an arm, and answered.
 */
#include <stdlib.h>
#include <string.h>

#include "record/replay.h"

#define BYTES_MAX 65536

static _Alignas(64) unsigned char bytes[BYTES_MAX];
static tfa_model *arm;
static tfa_workspace *workspace;
static void *slot;
static const tfa_wire_shape shape = {
    .q_count = 7, .v_count = 7, .frames = 11, .max_batch = 4, .max_tips = 3};

static void require(int condition)
{
    if (!condition)
        abort();
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    tfa_report report = {0};
    (void)argc;
    (void)argv;
    require(tfa_model_load(TFA_SOURCE_DIR "/config/robots/arm7.urdf", NULL, &report, &arm) ==
            TFA_OK);
    require(tfa_model_frame_count(arm) == shape.frames);
    require(tfa_workspace_create(arm, &(tfa_workspace_options){.max_tips = 3}, &workspace) ==
            TFA_OK);
    slot = aligned_alloc(64, (tfa_wire_reply_capacity(&shape) + 63) / 64 * 64);
    require(slot != NULL);
    tfa_report_free(&report);
    return 0;
}

/* Gives the file the checksums that it should have, as far as its sizes go. */
static void mend(size_t size)
{
    tfa_recording_head head;
    if (size < sizeof head)
        return;
    memcpy(&head, bytes, sizeof head);
    if (head.settings_bytes > size || head.urdf_bytes > size)
        return;
    size_t at = sizeof head + (size_t)tfa_recording_padded(head.settings_bytes) +
                (size_t)tfa_recording_padded(head.urdf_bytes);
    if (at > size)
        return;
    head.checksum = 0;
    head.checksum = recording_crc32(recording_crc32(0, &head, sizeof head), bytes + sizeof head,
                                    at - sizeof head);
    memcpy(bytes, &head, sizeof head);
    for (tfa_tap_record record; at + sizeof record <= size; at += record.bytes) {
        memcpy(&record, bytes + at, sizeof record);
        if (!recording_is_record(&record) || record.bytes > size - at)
            return;
        record.checksum = recording_crc32(0, bytes + at + 8, record.bytes - 8);
        memcpy(bytes + at, &record, sizeof record);
    }
}

/* Answers a request and compares. */
static void play(const replay_request *q)
{
    tfa_reply reply = {0};
    if (q->status != TFA_OK)
        return;
    tfa_wire_reply_buffers(&q->shape, &q->reply_shape, slot, &reply);
    (void)tfa_compute(workspace, &q->request, &reply);
    memset(slot, 0, TFA_WIRE_LINE);
    tfa_wire_encode_reply(&reply, q->reply_shape.want, slot);
    tfa_wire_reply_shape both = q->reply_shape;
    both.want &= q->from.reply->want;
    (void)compare_replies(&q->shape, &both, q->from.reply, slot, 0, 1);
    (void)compare_replies(&q->shape, &both, q->from.reply, slot, 1e-9, 0);
}

static void read_all(size_t size)
{
    static const replay_options options;
    static replay r;
    char text[200];
    recorded record;
    r = (replay){.options = &options, .robot.shape = shape};
    if (recording_open(bytes, size, &r.file, text, sizeof text) != 0)
        return;
    recorded_robot robot;
    if (recorded_robot_read(r.file.settings, r.file.settings_bytes, &robot, text, sizeof text) == 0)
        recorded_robot_free(&robot);
    for (size_t at = r.file.first;
         recording_next(&r.file, &at, &record, text, sizeof text) == RECORDING_RECORD;) {
        replay_request q;
        if (replay_decode(&r, &record, &q) == REPLAY_PLAYED)
            play(&q);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size > sizeof bytes)
        return 0;
    memcpy(bytes, data, size);
    read_all(size);
    mend(size);
    read_all(size);
    return 0;
}
