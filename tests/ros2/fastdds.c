/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A participant of Fast DDS, as rmw_fastrtps sets it up, and a plain one of Cyclone with our types
 * exchange each topic type.
 */
#include "fastdds_peer.h"
#include "ros2_peer.h"

#include "dds/dds_test.h"
#include "dds/ros2/type_hash.h"
#include "fastcdr_wire.h"
#include "fuzz/random.h"
#include "messages.h"

#include <idl/ros2.h>
#include <idl/unitree.h>

#define ROBOT_DESCRIPTION "rt/robot_description"

static dds_entity_t participant;
static fastdds_peer *peer;

static const struct exchange {
    const char *topic;
    const dds_topic_descriptor_t *type;
    const fastdds_qos *qos;
} exchanges[] = {
    {"rt/joint_states", &sensor_msgs_msg_dds__JointState__desc, &fastdds_default},
    {"rt/effort_controller/commands", &std_msgs_msg_dds__Float64MultiArray__desc, &fastdds_default},
    {ROBOT_DESCRIPTION, &std_msgs_msg_dds__String__desc, &fastdds_latched},
    {"rt/wrist/wrench", &geometry_msgs_msg_dds__WrenchStamped__desc, &fastdds_default},
    {"rt/accelerations", &trajectory_msgs_msg_dds__JointTrajectory__desc, &fastdds_default},
    {"rt/diagnostics", &diagnostic_msgs_msg_dds__DiagnosticArray__desc, &fastdds_default},
    {"rt/lowstate", &unitree_hg_msg_dds__LowState__desc, &fastdds_default},
    {"ros_discovery_info", &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
     &fastdds_latched},
};

/* ---- Cyclone's side ---- */

static dds_entity_t cyclone_open(const char *topic, const dds_topic_descriptor_t *type,
                                 const fastdds_qos *qos, bool is_writer)
{
    const ros2_peer_qos same = qos == &fastdds_latched       ? PEER_TRANSIENT_LOCAL
                               : qos == &fastdds_sensor_data ? PEER_SENSOR
                                                             : PEER_DEFAULT;
    return is_writer ? ros2_peer_writer(participant, type, topic, same)
                     : ros2_peer_reader(participant, type, topic, same);
}

static fastdds_matches cyclone_writer_matches(dds_entity_t writer)
{
    dds_publication_matched_status_t matched;
    dds_offered_incompatible_qos_status_t incompatible;
    assert_int_equal(dds_get_publication_matched_status(writer, &matched), DDS_RETCODE_OK);
    assert_int_equal(dds_get_offered_incompatible_qos_status(writer, &incompatible),
                     DDS_RETCODE_OK);
    return (fastdds_matches){(int)matched.current_count, (int)incompatible.total_count,
                             (int)incompatible.last_policy_id};
}

static fastdds_matches cyclone_reader_matches(dds_entity_t reader)
{
    dds_subscription_matched_status_t matched;
    dds_requested_incompatible_qos_status_t incompatible;
    assert_int_equal(dds_get_subscription_matched_status(reader, &matched), DDS_RETCODE_OK);
    assert_int_equal(dds_get_requested_incompatible_qos_status(reader, &incompatible),
                     DDS_RETCODE_OK);
    return (fastdds_matches){(int)matched.current_count, (int)incompatible.total_count,
                             (int)incompatible.last_policy_id};
}

/* ---- A writer and a reader, one of them Cyclone's ---- */

typedef struct pair {
    const dds_topic_descriptor_t *type;
    char topic[64];
    dds_entity_t cyclone;        /* the other end */
    fastdds_writer *fast_writer; /* or NULL */
    fastdds_reader *fast_reader; /* or NULL */
} pair;

/* A pair without its ends. The topic is in a namespace of its own, so that ends of former pairs,
 * whose removal may still be under way, are never taken for these. */
static pair new_pair(const struct exchange *e)
{
    static int number;
    const char *const base = strncmp(e->topic, "rt/", 3) == 0 ? e->topic + 3 : NULL;
    pair p = {.type = e->type};
    if (base != NULL)
        snprintf(p.topic, sizeof p.topic, "rt/n%d/%s", number++, base);
    else
        snprintf(p.topic, sizeof p.topic, "%s", e->topic);
    return p;
}

static void open_cyclone(pair *p, const fastdds_qos *qos, bool is_writer)
{
    p->cyclone = cyclone_open(p->topic, p->type, qos, is_writer);
}

static void open_fast(pair *p, const fastdds_qos *qos, bool is_writer)
{
    if (is_writer)
        p->fast_writer = fastdds_open_writer(peer, p->topic, p->type->m_typename, qos);
    else
        p->fast_reader = fastdds_open_reader(peer, p->topic, p->type->m_typename, qos);
    assert_true(p->fast_writer != NULL || p->fast_reader != NULL);
}

static fastdds_matches fast_matches(const pair *p)
{
    return p->fast_writer != NULL ? fastdds_writer_matches(p->fast_writer)
                                  : fastdds_reader_matches(p->fast_reader);
}

static fastdds_matches cyclone_matches(const pair *p)
{
    return p->fast_writer != NULL ? cyclone_reader_matches(p->cyclone)
                                  : cyclone_writer_matches(p->cyclone);
}

/* Both ends have as many partners. */
static void await_matches(const pair *p, int count)
{
    fastdds_matches fast = {0}, cyclone = {0};
    if (!WAIT_FOR((fast = fast_matches(p), cyclone = cyclone_matches(p),
                   fast.matched == count && cyclone.matched == count)))
        fail_msg("%s: Fast DDS has %d partners, Cyclone %d", p->topic, fast.matched,
                 cyclone.matched);
}

static pair open_pair(const struct exchange *e, const fastdds_qos *writer_qos,
                      const fastdds_qos *reader_qos, bool fast_writes)
{
    pair p = new_pair(e);
    open_fast(&p, fast_writes ? writer_qos : reader_qos, fast_writes);
    open_cyclone(&p, fast_writes ? reader_qos : writer_qos, !fast_writes);
    return p;
}

static void close_fast(pair *p)
{
    if (p->fast_writer != NULL)
        fastdds_close_writer(peer, p->fast_writer);
    else
        fastdds_close_reader(peer, p->fast_reader);
}

static void close_pair(pair *p)
{
    assert_int_equal(dds_delete(p->cyclone), DDS_RETCODE_OK);
    close_fast(p);
}

static void write_sample(const pair *p, const void *sample)
{
    static msg_bytes bytes;
    if (p->fast_writer == NULL) {
        assert_int_equal(dds_write(p->cyclone, sample), DDS_RETCODE_OK);
        return;
    }
    fastcdr_encode(msg_of_topic(p->type), sample, 0xa5, &bytes);
    assert_true(fastdds_write(p->fast_writer, bytes.byte, bytes.size));
}

static void take_sample(const pair *p, void *sample)
{
    static msg_bytes bytes;
    if (p->fast_reader == NULL) {
        assert_true(ros2_peer_take(p->cyclone, sample, WAIT_MS));
        return;
    }
    bytes.size = fastdds_take(p->fast_reader, bytes.byte, sizeof bytes.byte, WAIT_MS);
    assert_true(fastcdr_decode(msg_of_topic(p->type), &bytes, sample));
}

/* The next sample that the reader has is this one. They are compared by encoding them. */
static void assert_arrives(const pair *p, const void *sample)
{
    static msg_bytes got, expected;
    const msg *const m = msg_of_topic(p->type);
    void *const copy = calloc(1, m->size);
    assert_non_null(copy);
    take_sample(p, copy);
    msg_encode(m, copy, &got);
    msg_encode(m, sample, &expected);
    assert_int_equal(got.size, expected.size);
    assert_memory_equal(got.byte, expected.byte, expected.size);
    dds_sample_free(copy, m->topic, DDS_FREE_CONTENTS);
    free(copy);
}

/* ---- Tests: in the order of the file, and each closes what it opened ---- */

#define SAMPLES 8

static void exchange_samples(const struct exchange *e, const fastdds_qos *writer_qos,
                             const fastdds_qos *reader_qos, bool fast_writes)
{
    const msg *const m = msg_of_topic(e->type);
    pair p = open_pair(e, writer_qos, reader_qos, fast_writes);
    void *const sample = calloc(1, m->size);
    struct random_source seed = {3};
    assert_non_null(sample);
    await_matches(&p, 1);
    for (int i = 0; i < SAMPLES; i++) {
        msg_fill(m, sample, &seed);
        write_sample(&p, sample);
        assert_arrives(&p, sample);
    }
    free(sample);
    close_pair(&p);
}

TEST(every_topic_type_goes_both_ways)
{
    for (size_t i = 0; i < sizeof exchanges / sizeof *exchanges; i++)
        for (int fast_writes = 0; fast_writes < 2; fast_writes++)
            exchange_samples(&exchanges[i], exchanges[i].qos, exchanges[i].qos, fast_writes);
}

TEST(best_effort_readers_match_reliable_writers)
{
    for (int fast_writes = 0; fast_writes < 2; fast_writes++)
        exchange_samples(&exchanges[0], &fastdds_default, &fastdds_sensor_data, fast_writes);
}

static const struct exchange description = {ROBOT_DESCRIPTION, &std_msgs_msg_dds__String__desc,
                                            &fastdds_latched};

TEST(a_late_joiner_has_the_robot_description)
{
    const std_msgs_msg_dds__String_ sample = {"<robot name=\"arm\"/>"};
    for (int fast_writes = 0; fast_writes < 2; fast_writes++) {
        pair p = new_pair(&description);
        if (fast_writes)
            open_fast(&p, &fastdds_latched, true);
        else
            open_cyclone(&p, &fastdds_latched, true);
        write_sample(&p, &sample);
        if (fast_writes)
            open_cyclone(&p, &fastdds_latched, false);
        else
            open_fast(&p, &fastdds_latched, false);
        assert_arrives(&p, &sample);
        close_pair(&p);
    }
}

#define LONG_TEXT 200000 /* bytes: in fragments, larger than a datagram */

TEST(a_long_robot_description_arrives_whole)
{
    static uint8_t expected[8 + LONG_TEXT + 1] = {0, 1}, got[sizeof expected + 4];
    const uint32_t length = LONG_TEXT + 1;
    std_msgs_msg_dds__String_ sample = {(char *)expected + 8}, copy = {NULL};
    memcpy(expected + 4, &length, sizeof length);
    for (size_t i = 0; i < LONG_TEXT; i++)
        expected[8 + i] = (uint8_t)('a' + i % 26);
    pair p = open_pair(&description, &fastdds_latched, &fastdds_latched, false);
    assert_int_equal(dds_write(p.cyclone, &sample), DDS_RETCODE_OK);
    assert_in_range(fastdds_take(p.fast_reader, got, sizeof got, WAIT_MS), sizeof expected,
                    sizeof got);
    assert_memory_equal(got + 4, expected + 4, sizeof expected - 4); /* past the padding's count */
    close_pair(&p);
    p = open_pair(&description, &fastdds_latched, &fastdds_latched, true);
    assert_true(fastdds_write(p.fast_writer, expected, sizeof expected));
    assert_true(ros2_peer_take(p.cyclone, &copy, WAIT_MS));
    assert_string_equal(copy.data, sample.data);
    dds_sample_free(&copy, p.type, DDS_FREE_CONTENTS);
    close_pair(&p);
}

/* Cyclone now and then counts a refusal twice, when both ends come up together. */
TEST(a_volatile_writer_does_not_match_a_transient_local_reader_and_both_count_it)
{
    for (int fast_writes = 0; fast_writes < 2; fast_writes++) {
        pair p = open_pair(&description, &fastdds_default, &fastdds_latched, fast_writes);
        fastdds_matches fast = {0}, cyclone = {0};
        assert_true(WAIT_FOR((fast = fast_matches(&p), cyclone = cyclone_matches(&p),
                              fast.incompatible && cyclone.incompatible)));
        assert_int_equal(fast.incompatible, 1);
        assert_in_range(cyclone.incompatible, 1, 2);
        assert_int_equal(fast.policy, DDS_DURABILITY_QOS_POLICY_ID);
        assert_int_equal(cyclone.policy, DDS_DURABILITY_QOS_POLICY_ID);
        assert_int_equal(fast.matched, 0);
        assert_int_equal(cyclone.matched, 0);
        close_pair(&p);
    }
}

TEST(each_notices_that_an_end_of_the_other_is_closed)
{
    for (int fast_writes = 0; fast_writes < 2; fast_writes++) {
        pair p = open_pair(&exchanges[0], &fastdds_default, &fastdds_default, fast_writes);
        await_matches(&p, 1);
        close_fast(&p);
        assert_true(WAIT_FOR(cyclone_matches(&p).matched == 0));
        open_fast(&p, &fastdds_default, fast_writes);
        await_matches(&p, 1);
        assert_int_equal(dds_delete(p.cyclone), DDS_RETCODE_OK);
        assert_true(WAIT_FOR(fast_matches(&p).matched == 0));
        close_fast(&p);
    }
}

TEST(fast_dds_sees_type_hash_and_qos_of_cyclone)
{
    for (int is_writer = 0; is_writer < 2; is_writer++) {
        pair p = new_pair(&description);
        fastdds_endpoint seen;
        dds_guid_t guid;
        open_cyclone(&p, &fastdds_latched, is_writer);
        assert_int_equal(dds_get_guid(p.cyclone, &guid), DDS_RETCODE_OK);
        assert_true(fastdds_await_endpoint(peer, p.topic, is_writer, &seen, WAIT_MS));
        assert_memory_equal(seen.gid, guid.v, sizeof guid.v);
        assert_string_equal(seen.type, "std_msgs::msg::dds_::String_");
        assert_string_equal(seen.user_data, tfa_ros2_user_data(seen.type));
        assert_true(seen.reliable && seen.transient_local);
        assert_int_equal(dds_delete(p.cyclone), DDS_RETCODE_OK);
    }
}

static void assert_user_data(const dds_qos_t *qos, const char *expected, size_t size)
{
    void *user_data;
    size_t got;
    assert_true(dds_qget_userdata(qos, &user_data, &got));
    assert_int_equal(got, size);
    assert_memory_equal(user_data, expected, size);
    dds_free(user_data);
}

static void assert_xcdr1(const dds_qos_t *qos)
{
    dds_data_representation_id_t *representation;
    uint32_t count;
    assert_true(dds_qget_data_representation(qos, &count, &representation));
    assert_int_equal(count, 1);
    assert_int_equal(representation[0], DDS_DATA_REPRESENTATION_XCDR1);
    dds_free(representation);
}

TEST(cyclone_sees_type_hash_encoding_and_gids_of_fast_dds)
{
    pair p = open_pair(&exchanges[0], &fastdds_default, &fastdds_default, true);
    const char *const hash = tfa_ros2_user_data("sensor_msgs::msg::dds_::JointState_");
    uint8_t writer_gid[16], participant_gid[16];
    dds_instance_handle_t handle;
    await_matches(&p, 1);
    fastdds_writer_gid(p.fast_writer, writer_gid);
    fastdds_gid(peer, participant_gid);
    assert_int_equal(dds_get_matched_publications(p.cyclone, &handle, 1), 1);
    dds_builtintopic_endpoint_t *seen = dds_get_matched_publication_data(p.cyclone, handle);
    assert_non_null(seen);
    assert_memory_equal(seen->key.v, writer_gid, sizeof writer_gid);
    assert_memory_equal(seen->participant_key.v, participant_gid, sizeof participant_gid);
    assert_string_equal(seen->topic_name, p.topic);
    assert_string_equal(seen->type_name, "sensor_msgs::msg::dds_::JointState_");
    assert_user_data(seen->qos, hash, strlen(hash));
    assert_xcdr1(seen->qos);
    dds_builtintopic_free_endpoint(seen);
    close_pair(&p);
}

TEST(cyclone_sees_the_enclave_of_fast_dds)
{
    static const char enclave[] = "enclave=/;";
    const dds_entity_t reader =
        dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL);
    dds_builtintopic_participant_t *sample = NULL;
    dds_sample_info_t info;
    uint8_t gid[16];
    bool found = false;
    fastdds_gid(peer, gid);
    assert_true(reader > 0);
    while (!found && dds_take(reader, (void **)&sample, &info, 1, 1) == 1) {
        found = memcmp(sample->key.v, gid, sizeof gid) == 0;
        if (found)
            assert_user_data(sample->qos, enclave, sizeof enclave);
        assert_int_equal(dds_return_loan(reader, (void **)&sample, 1), DDS_RETCODE_OK);
    }
    assert_true(found);
    assert_int_equal(dds_delete(reader), DDS_RETCODE_OK);
}

/* So that Fast DDS notices what Cyclone closes, see fastdds_peer.h; and by that alone. */
static void set_key_hashes(void)
{
    char uri[512];
    test_domain();
    snprintf(uri, sizeof uri,
             "%s,<CycloneDDS><Domain><Internal><GenerateKeyhash>true</GenerateKeyhash></Internal>"
             "<Discovery><LeaseDuration>3600 s</LeaseDuration></Discovery></Domain></CycloneDDS>",
             getenv("CYCLONEDDS_URI"));
    setenv("CYCLONEDDS_URI", uri, 1);
}

static int open_participants(void **state)
{
    (void)state;
    set_key_hashes();
    participant = dds_create_participant(test_domain(), NULL, NULL);
    peer = fastdds_open(test_domain());
    return participant > 0 && peer != NULL ? 0 : -1;
}

static int close_participants(void **state)
{
    (void)state;
    fastdds_close(peer);
    return dds_delete(participant) == DDS_RETCODE_OK ? 0 : -1;
}

int main(void)
{
    return test_run(open_participants, close_participants);
}
