/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bytes of the foreign messages as Cyclone writes and reads them by our IDL.
 */
#ifndef TESTS_ROS2_CYCLONE_WIRE_H
#define TESTS_ROS2_CYCLONE_WIRE_H

#include "messages.h"

#include <dds/ddsi/ddsi_serdata.h>

/** Topic, writer and reader of one type, all in XCDR1. */
typedef struct wire {
    dds_entity_t topic, writer, reader;
} wire;

/** Fixtures of test_run: a participant on the loopback interface. */
int wire_open_participant(void **state);
int wire_close_participant(void **state);

wire wire_open(const msg *m);
void wire_close(const wire *w);

/** Bytes that Cyclone sends for a sample. Returns the sample as Cyclone holds it, for release. */
struct ddsi_serdata *write_bytes(const wire *w, const void *sample, msg_bytes *out);
/** What Cyclone does with bytes from the network. Returns false if it refuses them. */
bool read_bytes(const struct ddsi_sertype *type, const uint8_t *byte, size_t size, void *sample);
/** Cyclone reads these bytes as the sample. */
void assert_read(const msg *m, const struct ddsi_sertype *type, const msg_bytes *bytes,
                 const void *sample);
void assert_same_bytes(const uint8_t *a, size_t a_size, const uint8_t *b, size_t b_size);
/** Compares two samples by encoding them: every member contributes its bytes. */
void assert_same_sample(const msg *m, const void *a, const void *b);

/** Runs `check` on random samples of each of these types that is a topic, and on what Cyclone
 * writes for them. */
typedef void wire_check(const msg *m, const void *sample, msg_bytes *written,
                        const struct ddsi_sertype *type);
void wire_for_samples(const msg *const *list, wire_check *check);

#endif
