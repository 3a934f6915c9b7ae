/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A real daemon whose DDS ports get packets that no participant sends: random ones, spoilt
 * discovery, thousands of participants and endpoints that exist in packets only, samples that are
 * none. Clients over shared memory and DDS get the same bits all the time, and the daemon gives its
 * memory back.
 *
 *   test_dds_discovery [PACKETS]    of each kind; 8000
 *
 * Runs in a network namespace that has the loopback interface alone: a spoilt packet may tell the
 * daemon to answer anywhere. Exits with 77 where that is not permitted.
 */
#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "fuzz/random.h"
#include "harness.h"
#include "herald.h"
#include "rtps_packet.h"
#include "support/sanitized.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <totalforce/statistics.h>

#define JOINTS 7
#define PORTS_MAX 8
#define BURST 32 /* packets between two calls of the polite clients */
#define GROWTH_KIB (256 * 1024)
#define REPEAT_KIB (16 * 1024) /* a repetition finds the memory that was given back */

static int packets = 8000;

/* ---- the scene: a daemon, two polite clients, a socket ---- */

typedef struct scene {
    harness h;
    tfa_client *shm;
    tfa_dds_client *dds;
    double expected[JOINTS];
    int socket; /* sends, and receives what the daemon answers */
    uint16_t port;
    uint16_t ports[PORTS_MAX]; /* of the daemon, in the domain's range */
    int port_count;
    uint32_t answers;
} scene;

/* The inodes of the daemon's sockets are those of /proc/net/udp. */
static bool has_socket(pid_t pid, unsigned long inode)
{
    char directory[64], path[400], wanted[48], target[64];
    bool found = false;
    snprintf(directory, sizeof directory, "/proc/%d/fd", (int)pid);
    snprintf(wanted, sizeof wanted, "socket:[%lu]", inode);
    DIR *d = opendir(directory);
    assert_non_null(d);
    for (const struct dirent *e; !found && (e = readdir(d)) != NULL;) {
        snprintf(path, sizeof path, "%s/%s", directory, e->d_name);
        const ssize_t n = readlink(path, target, sizeof target - 1);
        target[n > 0 ? n : 0] = 0;
        found = strcmp(target, wanted) == 0;
    }
    closedir(d);
    return found;
}

/* Ports of a domain: 7400 + 250 x domain, and 250 from there. */
static void find_ports(scene *s)
{
    const unsigned first = 7400 + 250 * test_domain();
    char line[512];
    FILE *in = fopen("/proc/net/udp", "r");
    assert_non_null(in);
    while (fgets(line, sizeof line, in) != NULL) {
        unsigned port;
        unsigned long inode;
        if (sscanf(line, "%*d: %*x:%x %*x:%*x %*x %*x:%*x %*x:%*x %*x %*u %*u %lu", &port,
                   &inode) == 2 &&
            port >= first && port < first + 250 && s->port_count < PORTS_MAX &&
            has_socket(s->h.pid, inode))
            s->ports[s->port_count++] = (uint16_t)port;
    }
    fclose(in);
    assert_true(s->port_count >= 2); /* discovery and data */
}

static void open_socket(scene *s)
{
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof here;
    s->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(s->socket, (struct sockaddr *)&here, sizeof here), 0);
    assert_int_equal(getsockname(s->socket, (struct sockaddr *)&here, &size), 0);
    s->port = ntohs(here.sin_port);
}

static scene open_scene(void)
{
    scene s = {.h = harness_serve(ARM, dds_yaml(test_domain(), TEST_LEASE_MS))};
    assert_true(harness_logged(&s.h, "ready:"));
    dds_herald(test_domain(), "arm");
    s.shm = harness_connect(&s.h, "arm", TFA_WAIT_HYBRID);
    assert_int_equal(ask_arm(s.shm, 1, s.expected, WAIT_NS), TFA_OK);
    s.dds = dds_connect(test_domain(), "arm");
    open_socket(&s);
    find_ports(&s);
    return s;
}

static void assert_right(const scene *s)
{
    double q[JOINTS], v[JOINTS], tau[JOINTS], qdd[JOINTS] = {0};
    const tfa_request request = arm_request(1, q, v, tau);
    tfa_reply reply = {.qdd = qdd};
    assert_int_equal(ask_arm(s->shm, 1, qdd, WAIT_NS), TFA_OK);
    assert_memory_equal(qdd, s->expected, sizeof qdd);
    memset(qdd, 0, sizeof qdd);
    assert_int_equal(tfa_dds_client_call(s->dds, &request, &reply, WAIT_NS, NULL), TFA_OK);
    assert_memory_equal(qdd, s->expected, sizeof qdd);
}

static void close_scene(scene *s)
{
    for (int i = 0; i < 10; i++)
        assert_right(s);
    close(s->socket);
    tfa_dds_client_close(s->dds);
    tfa_client_close(s->shm);
    assert_int_equal(harness_log_lines(&s->h, "Sanitizer"), 0);
    assert_int_equal(harness_stop(&s->h, SIGTERM), 0);
    harness_remove(&s->h);
}
#define SCOPED_SCENE SCOPED(close_scene) scene

static void send_packet(scene *s, const rtps_packet *p, int index)
{
    struct sockaddr_in there = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    char answer[64];
    there.sin_port = htons(s->ports[index % s->port_count]);
    (void)!sendto(s->socket, p->bytes, p->size, 0, (struct sockaddr *)&there, sizeof there);
    while (recv(s->socket, answer, sizeof answer, MSG_DONTWAIT) > 0)
        s->answers++;
}

/* After a burst the daemon takes what has come before it answers: nothing of it is lost. */
static void breathe(const scene *s, int index)
{
    if (index % BURST == BURST - 1)
        assert_right(s);
}

/* Writers of requests that the daemon knows, or knew a second ago; one is the client's. */
static uint64_t count_writers(const scene *s)
{
    tfa_statistics *statistics;
    tfa_snapshot *snapshot;
    assert_int_equal(tfa_statistics_open(s->h.runtime_dir, WAIT_MS, &statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(statistics, &snapshot), TFA_OK);
    assert_true(WAIT_FOR(tfa_statistics_read(statistics, snapshot) == TFA_OK)); /* else busy */
    const uint64_t writers = snapshot->dds.request_writers;
    tfa_snapshot_free(snapshot);
    tfa_statistics_close(statistics);
    return writers;
}

static void assert_bounded(const scene *s, const char *what, long before)
{
    const long grown = harness_resident_kib(&s->h) - before;
    const unsigned lines = harness_log_lines(&s->h, "");
    print_message("%s: %ld KiB grown, %u answers, %u lines of log\n", what, grown, s->answers,
                  lines);
    assert_true(lines < (unsigned)packets / 4); /* 20 of a kind in 8.6 s */
#ifndef SANITIZED                               /* sanitizers keep memory that was freed */
    assert_true(grown < GROWTH_KIB);
#endif
}

/* ---- random and spoilt packets ---- */

static struct random_source bits = {1};

static uint32_t below(size_t limit)
{
    return (uint32_t)random_below(&bits, limit);
}

static const rtps_endpoint endpoints[] = {
    {RTPS_USER_WRITER(1), TFA_DDS_TOPIC_REQUEST, "totalforce::dds::Request", 1, 0},
    {RTPS_USER_WRITER(2), TFA_DDS_TOPIC_TORQUES, "totalforce::dds::JointTorques", 0, 0},
    {RTPS_USER_WRITER(3), TFA_DDS_TOPIC_LEADER, "totalforce::dds::Leader", 1, 1},
    {RTPS_USER_READER(4), TFA_DDS_TOPIC_REPLY, "totalforce::dds::Reply", 1, 0},
    {RTPS_USER_READER(5), TFA_DDS_TOPIC_ROBOT_INFO, "totalforce::dds::RobotInfo", 1, 1},
};

enum { ENDPOINTS = sizeof endpoints / sizeof *endpoints };

/* Noise, in half of the packets behind a good header. */
static rtps_packet random_packet(const rtps_participant *participant)
{
    rtps_packet p = rtps_begin(participant);
    const size_t begin = below(2) ? p.size : 0;
    p.size = begin + below(sizeof p.bytes - begin);
    for (size_t i = begin; i < p.size; i++)
        p.bytes[i] = (uint8_t)random_next(&bits);
    return p;
}

static rtps_packet good_packet(const rtps_participant *participant)
{
    const uint32_t kind = below(ENDPOINTS + 2);
    uint8_t sample[64];
    if (kind < ENDPOINTS)
        return rtps_announce_endpoint(participant, &endpoints[kind], 1 + below(8));
    if (kind == ENDPOINTS)
        return rtps_announce_participant(participant, 1);
    for (size_t i = 0; i < sizeof sample; i++)
        sample[i] = (uint8_t)random_next(&bits);
    rtps_packet p = rtps_begin(participant);
    rtps_add_data(&p, RTPS_UNKNOWN, RTPS_USER_WRITER(1 + below(3)), 1 + below(8), sample,
                  sizeof sample);
    return p;
}

/* Lengths, parameter ids, sequence numbers and any other 16 or 32 bits become extreme or any;
 * the list ends early, or goes on behind its end. */
static void spoil(rtps_packet *p)
{
    static const uint32_t extremes[] = {0,      1,          3,           0x7fff,     0x8000,
                                        0xffff, 0x7fffffff, 0x80000000u, 0xffffffffu};
    const size_t number = p->data + 4 + 12; /* of the sample */
    const uint32_t value = below(2) ? extremes[below(9)] : (uint32_t)random_next(&bits);
    const size_t place = 4 * below(p->size / 4);
    switch (below(7)) {
    case 0: /* of a parameter: id or length */
        memcpy(p->bytes + place + 2 * below(2), &value, 2);
        break;
    case 1:
        memcpy(p->bytes + place, &value, 4);
        break;
    case 2: /* the length of DATA */
        memcpy(p->bytes + p->data + 2, &value, 2);
        break;
    case 3:
        memcpy(p->bytes + number + 4 * below(2), &value, 4);
        break;
    case 4:
        p->size -= below(p->size - 20);
        break;
    case 5: /* kind of the encapsulation */
        memcpy(p->bytes + p->serialized, &value, 2);
        break;
    default:
        p->bytes[below(p->size)] ^= (uint8_t)(1u << below(8));
    }
}

static rtps_packet spoilt_packet(const rtps_participant *participant)
{
    rtps_packet p = good_packet(participant);
    for (uint32_t i = below(4); p.size > p.serialized + 4; i--) {
        spoil(&p);
        if (i == 0)
            break;
    }
    return p;
}

TEST(packets_without_sense)
{
    SCOPED_SCENE s = open_scene();
    const long before = harness_resident_kib(&s.h);
    for (int i = 0; i < 2 * packets; i++) {
        const rtps_participant p = {.number = below(16), .lease_s = 100, .port = s.port};
        if (i % 256 == 0) { /* somebody to spoil the words of */
            const rtps_packet good = rtps_announce_participant(&p, 1);
            send_packet(&s, &good, i / 256);
        }
        const rtps_packet bad = i % 2 ? random_packet(&p) : spoilt_packet(&p);
        send_packet(&s, &bad, i / 2);
        breathe(&s, i);
    }
    assert_true(s.answers > 0); /* some of them were believed */
    assert_bounded(&s, "packets without sense", before);
}

/* ---- participants and endpoints that exist in packets only ---- */

static void invent_participant(scene *s, uint32_t number)
{
    const rtps_participant p = {.number = number, .lease_s = 1, .port = s->port};
    rtps_packet words = rtps_announce_participant(&p, 1);
    send_packet(s, &words, 0);
    for (uint32_t k = 0; k < ENDPOINTS; k++) {
        words = rtps_announce_endpoint(&p, &endpoints[k], 1 + k);
        send_packet(s, &words, 0);
    }
}

static void invent_participants(scene *s, uint32_t wave, int count)
{
    for (int i = 0; i < count; i++) {
        invent_participant(s, wave * 100000 + (uint32_t)i);
        breathe(s, (ENDPOINTS + 1) * i % BURST < ENDPOINTS + 1 ? BURST - 1 : 0);
    }
}

/* The last one lives until it is seen; then none does. */
static void await_oblivion(scene *s, uint32_t number)
{
    assert_true(WAIT_FOR((invent_participant(s, number), assert_right(s), count_writers(s) > 1)));
    assert_true(WAIT_FOR((assert_right(s), count_writers(s) == 1)));
}

/* A wave is forgotten when its leases are over: the next ones find its memory. */
TEST(invented_participants)
{
    enum { WAVES = 3 };
    const int count = packets / 8;
    long after[WAVES];
    SCOPED_SCENE s = open_scene();
    const long before = harness_resident_kib(&s.h);
    for (uint32_t wave = 0; wave < WAVES; wave++) {
        invent_participants(&s, wave, count);
        after[wave] = harness_resident_kib(&s.h);
        await_oblivion(&s, wave * 100000 + (uint32_t)count);
    }
    print_message("%d participants: %ld, %ld, %ld KiB\n", count, after[0] - before,
                  after[1] - before, after[2] - before);
    assert_true(s.answers > (uint32_t)count / 2); /* acknowledgements of their endpoints */
    assert_bounded(&s, "invented participants", before);
#ifndef SANITIZED
    assert_true(after[WAVES - 1] - after[0] < REPEAT_KIB);
#endif
}

/* ---- samples that are none ---- */

/* A participant with a writer of torques; the reader asks for no acknowledgements. */
static void announce_writer(scene *s, const rtps_participant *p)
{
    const rtps_packet self = rtps_announce_participant(p, 1);
    const rtps_packet writer = rtps_announce_endpoint(p, &endpoints[1], 1);
    send_packet(s, &self, 0);
    assert_right(s);
    send_packet(s, &writer, 0);
}

static void send_malformed(scene *s, const rtps_participant *p, uint32_t number)
{
    uint8_t sample[32];
    rtps_packet words = rtps_begin(p);
    memset(sample, 0xff, sizeof sample); /* a string of 4 GiB */
    rtps_add_data(&words, RTPS_UNKNOWN, endpoints[1].entity, number, sample, sizeof sample);
    send_packet(s, &words, (int)number);
}

/* Cyclone reports each of them from its receiving thread: the log has a few lines, and says that
 * there were more. */
TEST(malformed_samples_do_not_flood_the_log)
{
    uint32_t number = 0;
    scene s = open_scene();
    const unsigned lines = harness_log_lines(&s.h, "dds: ");
    const rtps_participant p = {.number = 7, .lease_s = 100, .port = s.port};
    assert_true(WAIT_FOR((announce_writer(&s, &p), send_malformed(&s, &p, ++number),
                          harness_log_lines(&s.h, "dds: ") > lines)));
    const long before = harness_resident_kib(&s.h);
    for (int i = 0; i < packets; i++) {
        send_malformed(&s, &p, ++number);
        breathe(&s, i);
    }
    assert_bounded(&s, "malformed samples", before);
    assert_true(harness_log_lines(&s.h, "dds: ") > 10);
    tfa_dds_client_close(s.dds);
    tfa_client_close(s.shm);
    close(s.socket);
    assert_int_equal(harness_stop(&s.h, SIGTERM), 0);
    assert_true(harness_logged(&s.h, "more messages like 'dds: %s'"));
    harness_remove(&s.h);
}

/* ---- a thousand endpoints of one participant ---- */

/* By number: every mixture that a reader or writer may ask for. */
static dds_qos_t *mixed_qos(uint32_t number)
{
    static const dds_duration_t leases[] = {DDS_MSECS(20), DDS_SECS(1), DDS_INFINITY};
    dds_qos_t *qos = dds_create_qos();
    const char *partition = "elsewhere";
    dds_qset_reliability(qos, number & 1 ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         DDS_MSECS(100));
    dds_qset_durability(qos, number & 2 ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, number & 4 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, 1);
    dds_qset_ownership(qos, number & 8 ? DDS_OWNERSHIP_EXCLUSIVE : DDS_OWNERSHIP_SHARED);
    dds_qset_liveliness(qos,
                        number & 16 ? DDS_LIVELINESS_MANUAL_BY_TOPIC : DDS_LIVELINESS_AUTOMATIC,
                        leases[number % 3]);
    if (number % 5 == 0)
        dds_qset_partition(qos, 1, &partition);
    if (number % 7 == 0)
        dds_qset_deadline(qos, DDS_MSECS(5));
    return qos;
}

static dds_entity_t create_endpoints(uint32_t count)
{
    const dds_entity_t p = dds_create_participant(test_domain(), NULL, NULL);
    dds_entity_t topics[TFA_DDS_TOPIC_COUNT];
    assert_true(p > 0);
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i < TFA_DDS_TOPIC_COUNT; i++)
        topics[i] = tfa_dds_create_topic(p, i);
    for (uint32_t i = 0; i < count; i++) {
        dds_qos_t *qos = mixed_qos(i);
        const dds_entity_t topic = topics[i / 2 % TFA_DDS_TOPIC_COUNT];
        const dds_entity_t end =
            i % 2 ? dds_create_writer(p, topic, qos, NULL) : dds_create_reader(p, topic, qos, NULL);
        assert_true(end > 0);
        dds_delete_qos(qos);
    }
    return p;
}

/* Nobody takes over, waits or grows: of readers that never read, and writers of each kind. */
TEST(a_thousand_endpoints)
{
    enum { ROUNDS = 3, COUNT = 1000 };
    long after[ROUNDS];
    SCOPED_SCENE s = open_scene();
    const long before = harness_resident_kib(&s.h);
    for (int round = 0; round < ROUNDS; round++) {
        const dds_entity_t p = create_endpoints(COUNT);
        for (int i = 0; i < 50; i++)
            assert_right(&s);
        after[round] = harness_resident_kib(&s.h);
        assert_true(WAIT_FOR(count_writers(&s) > 1));
        assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
        assert_true(WAIT_FOR((assert_right(&s), count_writers(&s) == 1)));
    }
    print_message("%d endpoints: %ld, %ld, %ld KiB\n", COUNT, after[0] - before, after[1] - before,
                  after[2] - before);
    assert_bounded(&s, "a thousand endpoints", before);
#ifndef SANITIZED
    assert_true(after[ROUNDS - 1] - after[0] < REPEAT_KIB);
#endif
}

/* ---- the namespace ---- */

static bool enter_loopback(void)
{
    struct ifreq lo = {.ifr_name = "lo", .ifr_flags = IFF_UP | IFF_RUNNING};
    if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
        return false;
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const bool up = fd >= 0 && ioctl(fd, SIOCSIFFLAGS, &lo) == 0;
    close(fd);
    return up;
}

int main(int argc, char **argv)
{
    signal(SIGPIPE, SIG_IGN);
    if (argc > 1)
        packets = atoi(argv[1]) > 100 ? atoi(argv[1]) : 100;
    if (!enter_loopback()) {
        fputs("dds_discovery: skipped: not allowed to make a network namespace\n", stderr);
        return 77;
    }
    return test_run(NULL, NULL);
}
