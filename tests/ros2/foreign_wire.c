/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bytes of the foreign messages against an encoder that is not ours: Fast CDR, which rmw_fastrtps
 * encodes with. It walks the description in messages.h, whose fields definitions.c compares with
 * Debian's .msg files.
 *
 * Cyclone and Fast CDR differ in padding alone:
 *  - before a field that has to be aligned Cyclone writes zeros; Fast CDR skips bytes, which keep
 *    what the buffer had;
 *  - Cyclone pads the end with zeros to a multiple of four and writes the number of these bytes
 *    into the last two bits of the header (DDS-XTypes 1.3, 7.6.3.1.2). Fast CDR 1 ends with the
 *    last field and writes 0; Fast DDS then pads the RTPS submessage, so that readers see the same
 *    length.
 */
#include "cyclone_wire.h"
#include "fastcdr_wire.h"
#include "test.h"

/* As it is on the network after Fast DDS padded the submessage. */
static void pad(msg_bytes *bytes)
{
    for (size_t i = 0; i < bytes->padding; i++)
        bytes->byte[bytes->size++] = 0;
}

static void check_same_bytes(const msg *m, const void *sample, msg_bytes *written,
                             const struct ddsi_sertype *type)
{
    static msg_bytes expected;
    (void)type;
    fastcdr_encode(m, sample, 0, &expected);
    pad(&expected);
    assert_int_equal(expected.byte[3], 0);
    assert_int_equal(written->byte[3], expected.padding);
    written->byte[3] = 0;
    assert_same_bytes(written->byte, written->size, expected.byte, expected.size);
}

TEST(cyclone_writes_the_bytes_of_fast_cdr)
{
    wire_for_samples(messages(), check_same_bytes);
}

static void check_fast_cdr_reads(const msg *m, const void *sample, msg_bytes *written,
                                 const struct ddsi_sertype *type)
{
    void *const copy = calloc(1, m->size);
    (void)type;
    assert_non_null(copy);
    assert_true(fastcdr_decode(m, written, copy));
    assert_same_sample(m, copy, sample);
    dds_sample_free(copy, m->topic, DDS_FREE_CONTENTS);
    free(copy);
}

TEST(fast_cdr_reads_what_cyclone_writes)
{
    wire_for_samples(messages(), check_fast_cdr_reads);
}

/* With the padding of the submessage and without. */
static void check_cyclone_reads(const msg *m, const void *sample, msg_bytes *written,
                                const struct ddsi_sertype *type)
{
    static msg_bytes bytes;
    (void)written;
    fastcdr_encode(m, sample, 0xa5, &bytes);
    assert_read(m, type, &bytes, sample);
    pad(&bytes);
    assert_read(m, type, &bytes, sample);
}

TEST(cyclone_reads_what_fast_cdr_writes)
{
    wire_for_samples(messages(), check_cyclone_reads);
}

int main(void)
{
    return test_run(wire_open_participant, wire_close_participant);
}
