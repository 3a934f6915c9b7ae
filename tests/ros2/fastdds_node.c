/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See fastdds_node.h.
 */
#include "fastdds_node.h"

#include "dds/dds_test.h"
#include "fastcdr_wire.h"
#include "messages.h"

#define ENDPOINTS_MAX 16

typedef rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ graph_info;
typedef rmw_dds_common_msg_dds__NodeEntitiesInfo_ node_info;
typedef rmw_dds_common_msg_dds__Gid_ gid;

/* Writer or reader with its type. */
typedef struct endpoint {
    const void *entity;
    const msg *type;
} endpoint;

struct fastdds_node {
    fastdds_peer *peer;
    endpoint endpoints[ENDPOINTS_MAX];
    size_t count;
    fastdds_writer *graph_writer;
    fastdds_reader *graph_reader;
    node_info info;
    gid readers[ENDPOINTS_MAX], writers[ENDPOINTS_MAX];
};

static const msg *graph_type(void)
{
    return msg_of_topic(&rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc);
}

static void write_encoded(fastdds_writer *w, const msg *m, const void *sample)
{
    static msg_bytes bytes;
    fastcdr_encode(m, sample, 0xa5, &bytes);
    assert_true(fastdds_write(w, bytes.byte, bytes.size));
}

static bool take_decoded(fastdds_reader *r, const msg *m, void *sample, int timeout_ms)
{
    static msg_bytes bytes;
    bytes.size = fastdds_take(r, bytes.byte, sizeof bytes.byte, timeout_ms);
    if (bytes.size == 0)
        return false;
    assert_true(fastcdr_decode(m, &bytes, sample));
    return true;
}

/* Tells others the endpoints of the node, as rmw does whenever one is made. */
static void announce(const fastdds_node *n)
{
    graph_info sample = {.node_entities_info_seq = {1, 1, (node_info *)(uintptr_t)&n->info, false}};
    fastdds_gid(n->peer, sample.gid.data);
    write_encoded(n->graph_writer, graph_type(), &sample);
}

fastdds_node *fastdds_node_open(uint32_t domain, const char *node_namespace, const char *name)
{
    const char *const topic = "ros_discovery_info";
    const char *const type = graph_type()->topic->m_typename;
    fastdds_node *const n = calloc(1, sizeof *n);
    assert_non_null(n);
    n->peer = fastdds_open(domain);
    assert_non_null(n->peer);
    n->graph_writer = fastdds_open_writer(n->peer, topic, type, &fastdds_latched);
    /* the topic has no key: with a depth of 1 the node's own list would replace another's */
    const fastdds_qos all = {.reliable = true, .transient_local = true, .depth = 100};
    n->graph_reader = fastdds_open_reader(n->peer, topic, type, &all);
    assert_true(n->graph_writer != NULL && n->graph_reader != NULL);
    snprintf(n->info.node_namespace, sizeof n->info.node_namespace, "%s", node_namespace);
    snprintf(n->info.node_name, sizeof n->info.node_name, "%s", name);
    n->info.reader_gid_seq._buffer = n->readers;
    n->info.writer_gid_seq._buffer = n->writers;
    announce(n);
    return n;
}

void fastdds_node_close(fastdds_node *n)
{
    fastdds_close(n->peer);
    free(n);
}

fastdds_peer *fastdds_node_peer(fastdds_node *n)
{
    return n->peer;
}

static void add_endpoint(fastdds_node *n, const void *entity, const dds_topic_descriptor_t *type)
{
    assert_non_null(entity);
    assert_true(n->count < ENDPOINTS_MAX);
    n->endpoints[n->count++] = (endpoint){entity, msg_of_topic(type)};
}

static const msg *type_of(const fastdds_node *n, const void *entity)
{
    for (size_t i = 0; i < n->count; i++)
        if (n->endpoints[i].entity == entity)
            return n->endpoints[i].type;
    fail_msg("not an endpoint of the node");
    return NULL;
}

fastdds_writer *fastdds_publisher(fastdds_node *n, const dds_topic_descriptor_t *type,
                                  const char *topic, const fastdds_qos *qos)
{
    char dds_topic[256];
    snprintf(dds_topic, sizeof dds_topic, "rt%s", topic);
    fastdds_writer *const w = fastdds_open_writer(n->peer, dds_topic, type->m_typename, qos);
    add_endpoint(n, w, type);
    fastdds_writer_gid(w, n->writers[n->info.writer_gid_seq._length++].data);
    announce(n);
    return w;
}

fastdds_reader *fastdds_subscription(fastdds_node *n, const dds_topic_descriptor_t *type,
                                     const char *topic, const fastdds_qos *qos)
{
    char dds_topic[256];
    snprintf(dds_topic, sizeof dds_topic, "rt%s", topic);
    fastdds_reader *const r = fastdds_open_reader(n->peer, dds_topic, type->m_typename, qos);
    add_endpoint(n, r, type);
    fastdds_reader_gid(r, n->readers[n->info.reader_gid_seq._length++].data);
    announce(n);
    return r;
}

void fastdds_await_match_of_writer(fastdds_writer *w)
{
    assert_true(WAIT_FOR(fastdds_writer_matches(w).matched > 0));
}

void fastdds_await_match_of_reader(fastdds_reader *r)
{
    assert_true(WAIT_FOR(fastdds_reader_matches(r).matched > 0));
}

void fastdds_publish(fastdds_node *n, fastdds_writer *w, const void *sample)
{
    write_encoded(w, type_of(n, w), sample);
}

bool fastdds_receive(fastdds_node *n, fastdds_reader *r, void *sample, int timeout_ms)
{
    return take_decoded(r, type_of(n, r), sample, timeout_ms);
}

static void copy_gids(fastdds_gids *to, const gid *from, uint32_t count)
{
    assert_true(count <= sizeof to->gid / sizeof to->gid[0]);
    to->count = count;
    for (uint32_t i = 0; i < count; i++)
        memcpy(to->gid[i], from[i].data, sizeof to->gid[i]);
}

/* Looks for the node among those that a participant lists. */
static bool find_node(const graph_info *from, const char *node_namespace, const char *name,
                      fastdds_listed *listed)
{
    for (uint32_t i = 0; i < from->node_entities_info_seq._length; i++) {
        const node_info *node = &from->node_entities_info_seq._buffer[i];
        if (strcmp(node->node_namespace, node_namespace) != 0 || strcmp(node->node_name, name) != 0)
            continue;
        if (listed == NULL)
            return true;
        memcpy(listed->participant, from->gid.data, sizeof listed->participant);
        copy_gids(&listed->readers, node->reader_gid_seq._buffer, node->reader_gid_seq._length);
        copy_gids(&listed->writers, node->writer_gid_seq._buffer, node->writer_gid_seq._length);
        return true;
    }
    return false;
}

bool fastdds_await_node(fastdds_node *n, const char *node_namespace, const char *name,
                        fastdds_listed *listed, int timeout_ms)
{
    const uint64_t end = now_ns() + (uint64_t)timeout_ms * 1000000u;
    uint8_t own[16];
    bool found = false;
    fastdds_gid(n->peer, own);
    while (!found && now_ns() < end) {
        graph_info sample;
        if (!take_decoded(n->graph_reader, graph_type(), &sample, 100))
            continue;
        found = memcmp(sample.gid.data, own, sizeof own) != 0 &&
                find_node(&sample, node_namespace, name, listed);
        dds_sample_free(&sample, graph_type()->topic, DDS_FREE_CONTENTS);
    }
    return found;
}
