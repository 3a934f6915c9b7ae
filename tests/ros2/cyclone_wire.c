/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See cyclone_wire.h.
 */
#include "cyclone_wire.h"

#include "dds/dds_test.h"
#include "fuzz/random.h"

static dds_entity_t participant;

int wire_open_participant(void **state)
{
    (void)state;
    participant = dds_create_participant(test_domain(), NULL, NULL);
    return participant > 0 ? 0 : -1;
}

int wire_close_participant(void **state)
{
    (void)state;
    return dds_delete(participant) == DDS_RETCODE_OK ? 0 : -1;
}

wire wire_open(const msg *m)
{
    const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qos_t *const qos = dds_create_qos();
    wire w;
    dds_qset_data_representation(qos, 1, &xcdr1);
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    w.topic = dds_create_topic(participant, m->topic, m->name, qos, NULL);
    w.writer = dds_create_writer(participant, w.topic, qos, NULL);
    w.reader = dds_create_reader(participant, w.topic, qos, NULL);
    dds_delete_qos(qos);
    assert_true(w.topic > 0 && w.writer > 0 && w.reader > 0);
    return w;
}

void wire_close(const wire *w)
{
    assert_int_equal(dds_delete(w->reader), DDS_RETCODE_OK);
    assert_int_equal(dds_delete(w->writer), DDS_RETCODE_OK);
    assert_int_equal(dds_delete(w->topic), DDS_RETCODE_OK);
}

struct ddsi_serdata *write_bytes(const wire *w, const void *sample, msg_bytes *out)
{
    struct ddsi_serdata *data;
    dds_sample_info_t info;
    assert_int_equal(dds_write(w->writer, sample), DDS_RETCODE_OK);
    assert_int_equal(dds_takecdr(w->reader, &data, 1, &info, DDS_ANY_STATE), 1);
    assert_true(info.valid_data);
    out->size = ddsi_serdata_size(data);
    assert_true(out->size <= MSG_BYTES_MAX);
    ddsi_serdata_to_ser(data, 0, out->size, out->byte);
    return data;
}

bool read_bytes(const struct ddsi_sertype *type, const uint8_t *byte, size_t size, void *sample)
{
    uint8_t *const exact = malloc(size); /* so that a sanitizer sees reads behind the end */
    assert_non_null(exact);
    memcpy(exact, byte, size);
    const ddsrt_iovec_t iov = {.iov_base = exact, .iov_len = size};
    struct ddsi_serdata *data = ddsi_serdata_from_ser_iov(type, SDK_DATA, 1, &iov, size);
    free(exact);
    if (data == NULL)
        return false;
    if (sample != NULL)
        assert_true(ddsi_serdata_to_sample(data, sample, NULL, NULL));
    ddsi_serdata_unref(data);
    return true;
}

void assert_same_bytes(const uint8_t *a, size_t a_size, const uint8_t *b, size_t b_size)
{
    assert_int_equal(a_size, b_size);
    assert_memory_equal(a, b, b_size);
}

void assert_same_sample(const msg *m, const void *a, const void *b)
{
    static msg_bytes a_bytes, b_bytes;
    msg_encode(m, a, &a_bytes);
    msg_encode(m, b, &b_bytes);
    assert_same_bytes(a_bytes.byte, a_bytes.size, b_bytes.byte, b_bytes.size);
}

void assert_read(const msg *m, const struct ddsi_sertype *type, const msg_bytes *bytes,
                 const void *sample)
{
    void *const copy = calloc(1, m->size);
    assert_non_null(copy);
    assert_true(read_bytes(type, bytes->byte, bytes->size, copy));
    assert_same_sample(m, copy, sample);
    dds_sample_free(copy, m->topic, DDS_FREE_CONTENTS);
    free(copy);
}

#define SEEDS 40

static void for_samples_of(const msg *m, wire_check *check)
{
    static msg_bytes written;
    void *const sample = calloc(1, m->size);
    const wire w = wire_open(m);
    struct random_source seed = {1};
    assert_non_null(sample);
    for (int i = 0; i < SEEDS; i++) {
        msg_fill(m, sample, &seed);
        struct ddsi_serdata *data = write_bytes(&w, sample, &written);
        check(m, sample, &written, data->type);
        ddsi_serdata_unref(data);
    }
    free(sample);
    wire_close(&w);
}

void wire_for_samples(const msg *const *list, wire_check *check)
{
    for (const msg *const *m = list; *m != NULL; m++)
        if ((*m)->topic != NULL)
            for_samples_of(*m, check);
}
