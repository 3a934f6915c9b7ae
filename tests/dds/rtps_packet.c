/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * RTPS packets by hand.
 */
#include "rtps_packet.h"

#include <stdlib.h>
#include <string.h>

enum { HEARTBEAT = 0x07, INFO_TS = 0x09, DATA = 0x15, LITTLE_ENDIAN_FLAG = 1, DATA_FLAG = 4 };
enum { CDR_LE = 1, PL_CDR_LE = 3 };

/* Parameters of discovery. */
enum {
    PID_SENTINEL = 0x01,
    PID_LEASE_DURATION = 0x02,
    PID_TOPIC_NAME = 0x05,
    PID_TYPE_NAME = 0x07,
    PID_PROTOCOL_VERSION = 0x15,
    PID_VENDOR_ID = 0x16,
    PID_RELIABILITY = 0x1a,
    PID_DURABILITY = 0x1d,
    PID_UNICAST_LOCATOR = 0x2f,
    PID_DEFAULT_UNICAST_LOCATOR = 0x31,
    PID_METATRAFFIC_UNICAST_LOCATOR = 0x32,
    PID_PARTICIPANT_GUID = 0x50,
    PID_BUILTIN_ENDPOINT_SET = 0x58,
    PID_ENDPOINT_GUID = 0x5a,
};

static const uint8_t version[2] = {2, 1}, vendor[2] = {0x01, 0x10};

static void put(rtps_packet *p, const void *bytes, size_t size)
{
    if (p->size + size > sizeof p->bytes)
        abort();
    memcpy(p->bytes + p->size, bytes, size);
    p->size += size;
}

static void put16(rtps_packet *p, uint32_t value)
{
    const uint8_t bytes[2] = {(uint8_t)value, (uint8_t)(value >> 8)};
    put(p, bytes, sizeof bytes);
}

static void put32(rtps_packet *p, uint32_t value)
{
    put16(p, value);
    put16(p, value >> 16);
}

/* Entity ids are octets, most significant first. */
static void put_entity(rtps_packet *p, uint32_t id)
{
    const uint8_t bytes[4] = {(uint8_t)(id >> 24), (uint8_t)(id >> 16), (uint8_t)(id >> 8),
                              (uint8_t)id};
    put(p, bytes, sizeof bytes);
}

static void put_prefix(rtps_packet *p, const rtps_participant *participant)
{
    static const uint8_t host[4] = {0xfa, 0x15, 0xe0, 0x01};
    put(p, host, sizeof host);
    put32(p, participant->number);
    put32(p, 1);
}

/* ---- submessages ---- */

static size_t begin_submessage(rtps_packet *p, uint8_t kind, uint8_t flags)
{
    const uint8_t head[4] = {kind, (uint8_t)(flags | LITTLE_ENDIAN_FLAG)};
    put(p, head, sizeof head);
    return p->size;
}

static void end_submessage(rtps_packet *p, size_t begin)
{
    const size_t length = p->size - begin;
    p->bytes[begin - 2] = (uint8_t)length;
    p->bytes[begin - 1] = (uint8_t)(length >> 8);
}

rtps_packet rtps_begin(const rtps_participant *participant)
{
    rtps_packet p = {.size = 0};
    put(&p, "RTPS", 4);
    put(&p, version, sizeof version);
    put(&p, vendor, sizeof vendor);
    put_prefix(&p, participant);
    const size_t begin = begin_submessage(&p, INFO_TS, 0);
    put32(&p, 1700000000);
    put32(&p, 0);
    end_submessage(&p, begin);
    return p;
}

void rtps_add_heartbeat(rtps_packet *p, uint32_t reader, uint32_t writer, uint32_t last)
{
    const size_t begin = begin_submessage(p, HEARTBEAT, 0);
    put_entity(p, reader);
    put_entity(p, writer);
    put32(p, 0); /* first: high, low */
    put32(p, 1);
    put32(p, 0);
    put32(p, last);
    put32(p, last); /* the count of heartbeats */
    end_submessage(p, begin);
}

static size_t begin_data(rtps_packet *p, uint32_t reader, uint32_t writer, uint32_t sequence,
                         uint8_t encapsulation)
{
    const uint8_t kind[4] = {0, encapsulation};
    const size_t begin = begin_submessage(p, DATA, DATA_FLAG);
    p->data = begin - 4;
    put16(p, 0);
    put16(p, 16); /* octets to inline QoS */
    put_entity(p, reader);
    put_entity(p, writer);
    put32(p, 0);
    put32(p, sequence);
    p->serialized = p->size;
    put(p, kind, sizeof kind);
    return begin;
}

void rtps_add_data(rtps_packet *p, uint32_t reader, uint32_t writer, uint32_t sequence,
                   const void *content, size_t size)
{
    static const uint8_t zeros[4];
    const size_t begin = begin_data(p, reader, writer, sequence, CDR_LE);
    put(p, content, size);
    put(p, zeros, -size & 3);
    end_submessage(p, begin);
}

/* ---- parameters ---- */

static void put_parameter(rtps_packet *p, uint32_t id, size_t size)
{
    put16(p, id);
    put16(p, (uint32_t)(size + 3) & ~3u);
}

static void put_text(rtps_packet *p, uint32_t id, const char *text)
{
    static const uint8_t zeros[4];
    const size_t size = strlen(text) + 1;
    put_parameter(p, id, 4 + size);
    put32(p, (uint32_t)size);
    put(p, text, size);
    put(p, zeros, -size & 3);
}

static void put_guid(rtps_packet *p, uint32_t id, const rtps_participant *participant,
                     uint32_t entity)
{
    put_parameter(p, id, 16);
    put_prefix(p, participant);
    put_entity(p, entity);
}

static void put_locator(rtps_packet *p, uint32_t id, uint16_t port)
{
    static const uint8_t loopback[16] = {[12] = 127, 0, 0, 1};
    put_parameter(p, id, 24);
    put32(p, 1); /* UDPv4 */
    put32(p, port);
    put(p, loopback, sizeof loopback);
}

static void put_identity(rtps_packet *p, const rtps_participant *participant)
{
    put_parameter(p, PID_PROTOCOL_VERSION, 4);
    put(p, version, sizeof version);
    put16(p, 0);
    put_parameter(p, PID_VENDOR_ID, 4);
    put(p, vendor, sizeof vendor);
    put16(p, 0);
    put_guid(p, PID_PARTICIPANT_GUID, participant, 0x000001c1u);
}

rtps_packet rtps_announce_participant(const rtps_participant *participant, uint32_t sequence)
{
    rtps_packet p = rtps_begin(participant);
    const size_t begin = begin_data(&p, RTPS_SPDP_READER, RTPS_SPDP_WRITER, sequence, PL_CDR_LE);
    put_identity(&p, participant);
    put_parameter(&p, PID_BUILTIN_ENDPOINT_SET, 4);
    put32(&p, 0xc3f); /* participant, publications, subscriptions, liveliness: both ends */
    put_parameter(&p, PID_LEASE_DURATION, 8);
    put32(&p, participant->lease_s);
    put32(&p, 0);
    put_locator(&p, PID_DEFAULT_UNICAST_LOCATOR, participant->port);
    put_locator(&p, PID_METATRAFFIC_UNICAST_LOCATOR, participant->port);
    put_parameter(&p, PID_SENTINEL, 0);
    end_submessage(&p, begin);
    return p;
}

rtps_packet rtps_announce_endpoint(const rtps_participant *participant, const rtps_endpoint *e,
                                   uint32_t sequence)
{
    const int writes = (e->entity & 0x0f) <= 3;
    const uint32_t writer = writes ? RTPS_PUBLICATIONS_WRITER : RTPS_SUBSCRIPTIONS_WRITER;
    const uint32_t reader = writes ? RTPS_PUBLICATIONS_READER : RTPS_SUBSCRIPTIONS_READER;
    rtps_packet p = rtps_begin(participant);
    const size_t begin = begin_data(&p, reader, writer, sequence, PL_CDR_LE);
    put_identity(&p, participant);
    put_guid(&p, PID_ENDPOINT_GUID, participant, e->entity);
    put_text(&p, PID_TOPIC_NAME, e->topic);
    put_text(&p, PID_TYPE_NAME, e->type);
    put_parameter(&p, PID_RELIABILITY, 12);
    put32(&p, e->reliable ? 2 : 1);
    put32(&p, 0);
    put32(&p, 0);
    put_parameter(&p, PID_DURABILITY, 4);
    put32(&p, e->transient_local ? 1 : 0);
    put_locator(&p, PID_UNICAST_LOCATOR, participant->port);
    put_parameter(&p, PID_SENTINEL, 0);
    end_submessage(&p, begin);
    rtps_add_heartbeat(&p, reader, writer, sequence);
    return p;
}
