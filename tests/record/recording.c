/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The file of a recording: what was written is read; every cut is tolerated, every flipped bit
 * found. And the comparison of answers.
 */
#include "record/recording.h"

#include "record/compare.h"
#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define RECORDS 3
#define RECORD_BYTES (sizeof(tfa_tap_record) + 2 * TFA_WIRE_LINE + 16)

static const char texts[16] = "{}\0\0\0\0\0\0<robot/>";
static const tfa_recording_description description = {2, 8};

static char path[] = "/tmp/recording-XXXXXX";

static void fill(uint64_t *record, uint64_t k)
{
    for (size_t i = 0; i < RECORD_BYTES / 8; i++)
        record[i] = k * 1000 + i;
    *(tfa_tap_record *)(void *)record = (tfa_tap_record){.bytes = RECORD_BYTES,
                                                         .request_bytes = TFA_WIRE_LINE + 8,
                                                         .reply_bytes = TFA_WIRE_LINE + 8,
                                                         .max_batch = 1,
                                                         .max_tips = 1};
}

static void write_file(uint64_t records)
{
    recording_writer w;
    uint64_t record[RECORD_BYTES / 8];
    memcpy(path + sizeof path - 7, "XXXXXX", 6);
    close(mkstemp(path));
    assert_int_equal(recording_create(&w, path, &description, texts), 0);
    for (uint64_t k = 0; k < records; k++) {
        fill(record, k);
        recording_add(&w, (const void *)record);
    }
    assert_int_equal(recording_close(&w), 0);
    assert_int_equal(w.records, records);
}

static unsigned char *read_file(size_t *size)
{
    struct stat info;
    const int fd = open(path, O_RDONLY);
    assert_true(fd >= 0 && fstat(fd, &info) == 0);
    *size = (size_t)info.st_size;
    unsigned char *bytes = malloc(*size);
    assert_int_equal(read(fd, bytes, *size), *size);
    close(fd);
    unlink(path);
    return bytes;
}

/* @return how it ends: RECORDING_END, CUT_OFF or DAMAGED; -1: it does not begin */
static int read_all(const void *bytes, size_t size, uint64_t *records)
{
    recording r;
    char text[200];
    recorded out;
    *records = 0;
    if (recording_open(bytes, size, &r, text, sizeof text) != 0)
        return -1;
    size_t at = r.first;
    for (;; ++*records) {
        const recording_state state = recording_next(&r, &at, &out, text, sizeof text);
        if (state != RECORDING_RECORD)
            return (int)state;
    }
}

TEST(the_checksum_is_the_catalogued_one)
{
    assert_int_equal(recording_crc32(0, "123456789", 9), 0xcbf43926u);
    assert_int_equal(recording_crc32(recording_crc32(0, "1234", 4), "56789", 5), 0xcbf43926u);
}

TEST(written_and_read)
{
    size_t size;
    uint64_t records, expected[RECORD_BYTES / 8];
    recording r;
    recorded out;
    char text[200];
    write_file(RECORDS);
    unsigned char *bytes = read_file(&size);
    assert_int_equal(read_all(bytes, size, &records), RECORDING_END);
    assert_int_equal(records, RECORDS);
    assert_int_equal(recording_open(bytes, size, &r, text, sizeof text), 0);
    assert_int_equal(r.settings_bytes, 2);
    assert_memory_equal(r.urdf, "<robot/>", 8);
    size_t at = r.first;
    for (uint64_t k = 0; k < RECORDS; k++) {
        assert_int_equal(recording_next(&r, &at, &out, text, sizeof text), RECORDING_RECORD);
        fill(expected, k);
        assert_memory_equal(out.request, expected + 4, RECORD_BYTES - 32);
    }
    free(bytes);
}

TEST(another_version_is_named)
{
    recording r;
    char text[200], expected[200];
    size_t size;
    write_file(1);
    unsigned char *bytes = read_file(&size);
    bytes[offsetof(tfa_recording_head, version)] = 2;
    assert_int_equal(recording_open(bytes, size, &r, text, sizeof text), -1);
    snprintf(expected, sizeof expected,
             "it is of version 2 of the format, not %u: use the totalforce that recorded it, or "
             "record again",
             TFA_RECORDING_VERSION);
    assert_string_equal(text, expected);
    free(bytes);
    unlink(path);
}

TEST(every_cut_is_tolerated)
{
    size_t size;
    uint64_t records;
    write_file(RECORDS);
    unsigned char *bytes = read_file(&size);
    const size_t first = size - RECORDS * RECORD_BYTES;
    for (size_t cut = 0; cut < size; cut++) {
        const int end = read_all(bytes, cut, &records);
        if (cut < first) {
            assert_int_equal(end, -1);
            continue;
        }
        assert_int_equal(records, (cut - first) / RECORD_BYTES);
        assert_int_equal(end, (cut - first) % RECORD_BYTES ? RECORDING_CUT_OFF : RECORDING_END);
    }
    free(bytes);
}

TEST(every_flipped_bit_is_found)
{
    size_t size;
    uint64_t records;
    write_file(RECORDS);
    unsigned char *bytes = read_file(&size);
    const size_t first = size - RECORDS * RECORD_BYTES;
    for (size_t bit = 0; bit < 8 * size; bit++) {
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
        const int end = read_all(bytes, size, &records);
        if (bit / 8 < first) {
            assert_int_equal(end, -1);
        } else {
            assert_int_equal(end, RECORDING_DAMAGED);
            assert_int_equal(records, (bit / 8 - first) / RECORD_BYTES);
        }
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    free(bytes);
}

/* A file that may not grow any more: whole records stay. */
TEST(a_full_disk)
{
    const struct rlimit small = {300000, RLIM_INFINITY};
    struct rlimit before;
    recording_writer w;
    uint64_t record[RECORD_BYTES / 8], records;
    size_t size;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    write_file(0);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    assert_int_equal(recording_create(&w, path, &description, texts), 0);
    for (uint64_t k = 0; k < 20000; k++) {
        fill(record, k);
        recording_add(&w, (const void *)record);
    }
    assert_int_equal(recording_close(&w), EFBIG);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    unsigned char *bytes = read_file(&size);
    assert_int_equal(read_all(bytes, size, &records), RECORDING_END);
    assert_int_equal(records, w.records);
    assert_true(records > 1000 && size <= 300000);
    free(bytes);
}

/* ---- answers ---- */

static const tfa_wire_shape shape = {
    .q_count = 2, .v_count = 2, .frames = 3, .max_batch = 2, .max_tips = 1};
static const tfa_wire_reply_shape reply_shape = {
    .count = 2, .want = TFA_WIRE_BIT(ANSWERS) | TFA_WIRE_BIT(OUT_QDD)};

typedef struct slot {
    tfa_wire_reply line;
    tfa_answer answers[2];
    double qdd[4];
} slot;

static slot make_slot(void)
{
    return (slot){.line = {.want = TFA_WIRE_BIT(ANSWERS) | TFA_WIRE_BIT(OUT_QDD)},
                  .answers = {{.method = 3, .error_estimate = __builtin_nan("")},
                              {.method = 3, .error_estimate = 1e-16}},
                  .qdd = {1, 2, 3, 100}};
}

static compared compare(const slot *a, const slot *b, double tolerance)
{
    return compare_replies(&shape, &reply_shape, a, b, tolerance, 0);
}

TEST(differences_are_named)
{
    const slot a = make_slot();
    slot b = make_slot();
    assert_int_equal(compare(&a, &b, 0).differences, 0);
    b.qdd[2] = 3.001;
    compared c = compare(&a, &b, 0);
    assert_int_equal(c.differences, 1);
    assert_string_equal(c.first.field, "qdd");
    assert_int_equal(c.first.state, 1);
    assert_int_equal(c.first.index, 0);
    assert_true(fabs(c.largest.relative - 1e-5) < 1e-12); /* of 100 */
    assert_int_equal(compare(&a, &b, 1.1e-5).differences, 0);
    assert_int_equal(compare(&a, &b, 0.9e-5).differences, 1);
    b.qdd[2] = __builtin_nan("");
    assert_int_equal(compare(&a, &b, 1).differences, 1);
    b = make_slot();
    b.answers[1].method = 4;
    c = compare(&a, &b, 1);
    assert_string_equal(c.first.field, "answers.method");
    b = make_slot();
    b.answers[1].error_estimate = 2e-16;
    assert_int_equal(compare(&a, &b, 0).differences, 1);
    assert_int_equal(compare(&a, &b, 1e-9).differences, 0);
    b.line.status = TFA_E_VALUE;
    assert_string_equal(compare(&a, &b, 1).first.field, "status");
    b = make_slot();
    b.line.model = 7;
    assert_string_equal(compare(&a, &b, 1).first.field, "model");
}

/* -0 is not 0, and a state that failed has no numbers. */
TEST(bits_and_failed_states)
{
    slot a = make_slot(), b = make_slot();
    a.qdd[0] = 0;
    b.qdd[0] = -0.0;
    assert_int_equal(compare(&a, &b, 0).differences, 1);
    assert_int_equal(compare(&a, &b, 1e-300).differences, 0);
    a.line.status = b.line.status = TFA_E_SINGULAR;
    a.answers[0].status = b.answers[0].status = TFA_E_SINGULAR;
    assert_int_equal(compare(&a, &b, 0).differences, 0);
    b.qdd[3] = 5;
    assert_int_equal(compare(&a, &b, 0).differences, 1);
}

/* With no tolerance every word of every block counts, but padding. */
TEST(every_word_counts)
{
    enum { WORDS = 2000 };
    static uint32_t a[WORDS], b[WORDS];
    const tfa_wire_shape floating = {.base_freedoms = 6,
                                     .q_count = 2,
                                     .v_count = 2,
                                     .frames = 3,
                                     .modes = 2,
                                     .max_batch = 2,
                                     .max_tips = 1};
    for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++) {
        const uint64_t want =
            UINT64_C(1) << block | (block == TFA_WIRE_SPECTRUM) * TFA_WIRE_BIT(LAMBDA_INV);
        const tfa_wire_reply_shape wanted = {
            .count = 2, .want = want, .tip_count = 1, .rows = 6, .constraints = 6};
        const size_t bytes = tfa_wire_reply_width(&floating, block, &wanted);
        const size_t before = want == UINT64_C(1) << block
                                  ? 0
                                  : tfa_wire_reply_width(&floating, TFA_WIRE_LAMBDA_INV, &wanted);
        const size_t first = (TFA_WIRE_LINE + before) / 4;
        assert_true(bytes > 0 && first + bytes / 4 <= WORDS);
        for (size_t word = 0; word < bytes / 4; word++) {
            const bool padding =
                block == TFA_WIRE_SPECTRUM &&
                word % (sizeof(tfa_spectrum) / 4) == offsetof(tfa_spectrum, padding) / 4;
            b[first + word] = 1;
            assert_int_equal(compare_replies(&floating, &wanted, a, b, 0, 0).differences, !padding);
            b[first + word] = 0;
        }
    }
}
