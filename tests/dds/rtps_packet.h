/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * RTPS 2.x packets by hand (OMG formal/2022-04-01, chapters 9.4 and 9.6), little endian: what
 * discovery says, and samples, for a test that then spoils them.
 */
#ifndef TFA_TESTS_DDS_RTPS_PACKET_H
#define TFA_TESTS_DDS_RTPS_PACKET_H

#include <stddef.h>
#include <stdint.h>

#define RTPS_PACKET_MAX 1400

/* Entity ids as they stand in a packet. */
#define RTPS_SPDP_WRITER 0x000100c2u
#define RTPS_SPDP_READER 0x000100c7u
#define RTPS_PUBLICATIONS_WRITER 0x000003c2u
#define RTPS_PUBLICATIONS_READER 0x000003c7u
#define RTPS_SUBSCRIPTIONS_WRITER 0x000004c2u
#define RTPS_SUBSCRIPTIONS_READER 0x000004c7u
#define RTPS_UNKNOWN 0u
#define RTPS_USER_WRITER(k) (((uint32_t)(k) << 8) + 0x02u) /* of samples with a key */
#define RTPS_USER_READER(k) (((uint32_t)(k) << 8) + 0x07u)

typedef struct rtps_packet {
    size_t size;
    size_t data, serialized; /* offsets of the last DATA and of its content */
    uint8_t bytes[RTPS_PACKET_MAX];
} rtps_packet;

/* A participant that exists in packets only: its GUID prefix follows from `number`. It asks to be
 * answered at this port of the loopback interface. */
typedef struct rtps_participant {
    uint32_t number;
    uint32_t lease_s;
    uint16_t port;
} rtps_participant;

/* An endpoint of it. */
typedef struct rtps_endpoint {
    uint32_t entity;
    const char *topic, *type;
    int reliable, transient_local;
} rtps_endpoint;

/* Header and time stamp. */
rtps_packet rtps_begin(const rtps_participant *p);
/* The sequence numbers that a writer has. */
void rtps_add_heartbeat(rtps_packet *packet, uint32_t reader, uint32_t writer, uint32_t last);
/* A DATA submessage, of which `content` is everything behind the encapsulation. */
void rtps_add_data(rtps_packet *packet, uint32_t reader, uint32_t writer, uint32_t sequence,
                   const void *content, size_t size);

/* Whole packets. */
rtps_packet rtps_announce_participant(const rtps_participant *p, uint32_t sequence);
/* A writer if its entity id is one, else a reader. */
rtps_packet rtps_announce_endpoint(const rtps_participant *p, const rtps_endpoint *e,
                                   uint32_t sequence);

#endif
