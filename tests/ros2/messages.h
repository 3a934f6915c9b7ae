/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Descriptions of the foreign messages, written from their .msg files, and what can be done by them
 * without Cyclone: random samples and their encoding.
 */
#ifndef TESTS_ROS2_MESSAGES_H
#define TESTS_ROS2_MESSAGES_H

#include <dds/dds.h>

#ifdef __cplusplus
extern "C" {
#endif

struct random_source; /* fuzz/random.h */

/* As type_interfaces/msg/FieldType numbers them */
typedef enum msg_type {
    MSG_NESTED = 1,
    MSG_INT8 = 2,
    MSG_UINT8 = 3,
    MSG_INT16 = 4,
    MSG_UINT16 = 5,
    MSG_INT32 = 6,
    MSG_UINT32 = 7,
    MSG_INT64 = 8,
    MSG_UINT64 = 9,
    MSG_FLOAT = 10,
    MSG_DOUBLE = 11,
    MSG_BOOLEAN = 15,
    MSG_BYTE = 16,
    MSG_STRING = 17,
    MSG_BOUNDED_STRING = 21,
} msg_type;

/* To be added to the type of the elements */
typedef enum msg_shape { MSG_ONE = 0, MSG_ARRAY = 48, MSG_SEQUENCE = 144 } msg_shape;

typedef struct msg msg;

typedef struct msg_field {
    const char *name;
    size_t offset, size; /* bytes, in the C struct */
    msg_type type;       /* of one element */
    msg_shape shape;
    size_t capacity;            /* elements of an array, or 0 */
    size_t bound;               /* bytes of a bounded string, which is kept in place, or 0 */
    const msg *(*nested)(void); /* or NULL */
} msg_field;

struct msg {
    const char *name; /* package/msg/Name */
    size_t size;      /* bytes of the C struct */
    const msg_field *field;
    size_t fields;
    const dds_topic_descriptor_t *topic; /* NULL: only within others */
};

#define MESSAGES_MAX 40
/** All messages, ended by NULL. */
const msg *const *messages(void);
/** A request of a test's service, and call and reply of totalforce_msgs/srv/ForwardDynamics, as
 * rmw_cyclonedds sends them, ended by NULL; not messages of their own. */
const msg *const *services(void);

/** The message or service of a topic; fails the test if there is none. */
const msg *msg_of_topic(const dds_topic_descriptor_t *topic);
/** Bytes of an element in the C struct. */
size_t msg_element_size(const msg_field *field);

/** A sample of random bytes, strings of random lengths and short sequences. It lives until the
 * process ends; `sample` holds nothing that would be freed. Padding is not written. */
void msg_fill(const msg *m, void *sample, struct random_source *seed);

#define MSG_BYTES_MAX 65536
typedef struct msg_bytes {
    size_t size, padding; /* bytes, header and padding included; at the end */
    uint8_t byte[MSG_BYTES_MAX];
} msg_bytes;

/** Encodes a sample: XCDR1 (classic CDR), little endian, with the header of RTPS. From OMG CORBA
 * 9.3 (CDR) and DDS-XTypes 1.3, 7.6.3.1: alignment counts from after the header; the end is padded
 * to a multiple of four, and the last two bits of the header say by how much. */
void msg_encode(const msg *m, const void *sample, msg_bytes *out);

#ifdef __cplusplus
}
#endif

#endif
