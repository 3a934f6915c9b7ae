/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Counts the RTPS datagrams that a bridge forwards.
 *
 *   rtps_counter BRIDGE FILE
 *
 * Runs in the bridge's network namespace and replaces FILE every 100 ms, until it is killed, by one
 * line: participant discovery, endpoint discovery, other datagrams, and copies of discovery, all
 * since the start; then the frames that the kernel dropped because this program was slow, and the
 * number of the line.
 * A datagram is counted where it enters the bridge by a port, a copy where it leaves: one multicast
 * datagram leaves by all ports but its own. The bridge's own interface, which receives multicast
 * once more, is left out.
 */
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

enum { ACKNACK = 0x06, HEARTBEAT = 0x07, GAP = 0x08, NACK_FRAG = 0x12, HEARTBEAT_FRAG = 0x13 };
enum { DATA = 0x15, DATA_FRAG = 0x16, LITTLE_ENDIAN_FLAG = 1 };
enum { RTPS_HEADER = 20, SUBMESSAGE_HEADER = 4, UDP_HEADER = 8, PERIOD_MS = 100 };
#define SPDP_WRITER 0x000100c2u

typedef enum rtps_kind { NO_RTPS, OTHER, ENDPOINTS, PARTICIPANTS } rtps_kind;

typedef struct counts {
    uint64_t datagrams[PARTICIPANTS + 1], copies, dropped;
} counts;

/* @return kind of the writer that a submessage is from or for */
static rtps_kind submessage_kind(const uint8_t *at, size_t size)
{
    size_t writer; /* its offset: the reader's id stands before it */
    switch (at[0]) {
    case DATA:
    case DATA_FRAG:
        writer = 4 + 4;
        break;
    case ACKNACK:
    case HEARTBEAT:
    case GAP:
    case NACK_FRAG:
    case HEARTBEAT_FRAG:
        writer = 4;
        break;
    default:
        return OTHER;
    }
    const uint8_t *id = at + SUBMESSAGE_HEADER + writer;
    if (size < SUBMESSAGE_HEADER + writer + 4)
        return OTHER;
    if (((uint32_t)id[0] << 24 | (uint32_t)id[1] << 16 | (uint32_t)id[2] << 8 | id[3]) ==
        SPDP_WRITER)
        return PARTICIPANTS;
    return (id[3] & 0xc0) == 0xc0 ? ENDPOINTS : OTHER; /* built-in entities */
}

/* @return the first kind of discovery in a message: Cyclone does not mix them */
static rtps_kind message_kind(const uint8_t *at, size_t size)
{
    if (size < RTPS_HEADER || memcmp(at, "RTPS", 4) != 0)
        return NO_RTPS;
    at += RTPS_HEADER;
    size -= RTPS_HEADER;
    while (size >= SUBMESSAGE_HEADER) {
        const bool little = at[1] & LITTLE_ENDIAN_FLAG;
        const size_t length = (size_t)at[little ? 3 : 2] << 8 | at[little ? 2 : 3];
        const rtps_kind kind = submessage_kind(at, size);
        if (kind != OTHER)
            return kind;
        if (length == 0 || length + SUBMESSAGE_HEADER > size)
            return OTHER;
        at += SUBMESSAGE_HEADER + length;
        size -= SUBMESSAGE_HEADER + length;
    }
    return OTHER;
}

/* @return kind of an IPv4 packet; NO_RTPS for all but the first fragment of a datagram */
static rtps_kind packet_kind(const uint8_t *at, size_t size)
{
    const size_t header = size > 0 ? (size_t)(at[0] & 15) * 4 : 0;
    if (size < 20 || size < header + UDP_HEADER || at[0] >> 4 != 4 || at[9] != IPPROTO_UDP ||
        ((at[6] & 0x1f) | at[7]) != 0)
        return NO_RTPS;
    return message_kind(at + header + UDP_HEADER, size - header - UDP_HEADER);
}

static bool write_counts(const char *path, const counts *c)
{
    static unsigned line;
    char next[256];
    snprintf(next, sizeof next, "%s.next", path);
    FILE *f = fopen(next, "w");
    if (f == NULL)
        return false;
    fprintf(f, "%ju %ju %ju %ju %ju %u\n", (uintmax_t)c->datagrams[PARTICIPANTS],
            (uintmax_t)c->datagrams[ENDPOINTS], (uintmax_t)c->datagrams[OTHER],
            (uintmax_t)c->copies, (uintmax_t)c->dropped, ++line);
    return fclose(f) == 0 && rename(next, path) == 0;
}

static uint64_t now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000 + (uint64_t)t.tv_nsec / 1000000;
}

static void count_packet(int s, int bridge, counts *c)
{
    static uint8_t packet[65536];
    struct sockaddr_ll from;
    socklen_t from_size = sizeof from;
    const ssize_t size =
        recvfrom(s, packet, sizeof packet, 0, (struct sockaddr *)&from, &from_size);
    if (size <= 0 || from.sll_protocol != htons(ETH_P_IP) || from.sll_ifindex == bridge)
        return;
    const rtps_kind kind = packet_kind(packet, (size_t)size);
    if (from.sll_pkttype != PACKET_OUTGOING)
        c->datagrams[kind]++;
    else if (kind > OTHER)
        c->copies++;
}

/* Packets of all interfaces of the namespace, without their Ethernet headers. */
static int open_socket(void)
{
    const struct timeval period = {.tv_usec = PERIOD_MS * 1000};
    const int s = socket(AF_PACKET, SOCK_DGRAM, htons(ETH_P_ALL)), room = 64 << 20;
    if (s < 0 || setsockopt(s, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0 ||
        setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &period, sizeof period) != 0)
        return -1;
    return s;
}

int main(int argc, char **argv)
{
    counts c = {0};
    const int bridge = argc == 3 ? (int)if_nametoindex(argv[1]) : 0;
    const int s = bridge > 0 ? open_socket() : -1;
    if (s < 0) {
        perror("rtps_counter BRIDGE FILE");
        return 3;
    }
    for (uint64_t next = now_ms();;) {
        if (now_ms() >= next) {
            struct tpacket_stats stats = {0};
            socklen_t size = sizeof stats;
            if (getsockopt(s, SOL_PACKET, PACKET_STATISTICS, &stats, &size) == 0)
                c.dropped += stats.tp_drops;
            if (!write_counts(argv[2], &c))
                return 1;
            next = now_ms() + PERIOD_MS;
        }
        count_packet(s, bridge, &c);
    }
}
