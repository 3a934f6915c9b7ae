/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two daemons for one robot on topics of ROS 2: each command has one answer, the standby writes
 * nothing, and it answers when the leader has died.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_arm.h"

#include <signal.h>
#include <string.h>

static harness first, second;
static arm_node node;

/* The participant that wrote a sample. */
static dds_guid_t writer_of(dds_entity_t reader, dds_instance_handle_t handle)
{
    dds_builtintopic_endpoint_t *e = dds_get_matched_publication_data(reader, handle);
    dds_guid_t guid = {{0}};

    if (e != NULL) {
        guid = e->participant_key;
        dds_builtintopic_free_endpoint(e);
    }
    return guid;
}

/* Takes samples for a while. @return how many; `from` gets the participant, all of one */
static unsigned take_for(dds_entity_t reader, const dds_topic_descriptor_t *type, unsigned ms,
                         dds_guid_t *from)
{
    const uint64_t end = now_ns() + 1000000u * (uint64_t)ms;
    void *sample = calloc(1, type->m_size);
    unsigned count = 0;

    assert_non_null(sample);
    while (now_ns() < end) {
        dds_sample_info_t info;
        if (dds_take(reader, &sample, &info, 1, 1) != 1) {
            dds_sleepfor(DDS_MSECS(1));
            continue;
        }
        if (!info.valid_data)
            continue;
        const dds_guid_t writer = writer_of(reader, info.publication_handle);
        if (count++ > 0)
            assert_memory_equal(&writer, from, sizeof writer);
        *from = writer;
    }
    dds_sample_free(sample, type, DDS_FREE_ALL);
    return count;
}

static unsigned take_answers(unsigned ms, dds_guid_t *from)
{
    return take_for(node.accelerations, &trajectory_msgs_msg_dds__JointTrajectory__desc, ms, from);
}

/* Publishes a motion. @return answers that came, none after a while */
static unsigned answers_to(uint64_t seed, dds_guid_t *from)
{
    const arm_motion m = arm_motion_of(seed);
    unsigned answers = 0;

    arm_publish_state(&node, &m, (int32_t)seed);
    arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, (int32_t)seed);
    for (int k = 0; k < 100 && answers == 0; k++)
        answers = take_answers(5, from);
    return answers;
}

#define COMMANDS 30

/* Waits until there is an answer; then there is one to each command, all of one participant. */
static dds_guid_t assert_one_answers(void)
{
    dds_guid_t from = {{0}}, next;
    unsigned answers = 0;

    for (uint64_t k = 0; k < 100 && answers == 0; k++)
        answers = answers_to(k, &from);
    assert_true(answers > 0);
    while (take_answers(300, &next) > 0)
        ;
    answers = 0;
    for (uint64_t k = 0; k < COMMANDS; k++) {
        answers += answers_to(k, &next);
        assert_memory_equal(&next, &from, sizeof from);
    }
    assert_int_equal(answers + take_answers(300, &next), COMMANDS);
    return from;
}

/* @param domain  of the daemons' own topics */
static void check_takeover(uint32_t domain)
{
    const dds_topic_descriptor_t *diagnostics = &diagnostic_msgs_msg_dds__DiagnosticArray__desc;
    dds_guid_t from;
    char more[128];

    snprintf(more, sizeof more, "dds: {enabled: yes, domain: %u}\n", domain);
    const char *settings = arm_settings(more);
    const char *yaml = arm_yaml("      state_age_ms: 1000\n      command_age_ms: 1000\n");
    harness_serve(&first, yaml, settings);
    assert_true(harness_logged(&first, "leads, epoch"));
    harness_serve(&second, yaml, settings);
    assert_true(harness_logged(&second, "standby, the leader has"));
    arm_node_open(&node);
    dds_sleepfor(DDS_MSECS(1200)); /* the other daemon has matched, too */

    const dds_guid_t leader = assert_one_answers();
    (void)take_for(node.diagnostics, diagnostics, 10, &from);
    assert_in_range(take_for(node.diagnostics, diagnostics, 2500, &from), 1, 4);
    assert_memory_equal(&from, &leader, sizeof from);

    (void)harness_stop(&first, SIGKILL);
    assert_true(harness_logged(&second, "leads, epoch"));
    const dds_guid_t next = assert_one_answers();
    assert_memory_not_equal(&next, &leader, sizeof next);
    while (take_for(node.diagnostics, diagnostics, 100, &from) == 0)
        ;
    assert_memory_equal(&from, &next, sizeof from);

    arm_node_close(&node);
    assert_int_equal(harness_stop(&second, SIGTERM), 0);
    harness_remove(&second);
    harness_remove(&first);
}

TEST(one_daemon_answers_and_another_takes_over)
{
    check_takeover(test_domain());
}

TEST(the_same_where_both_kinds_of_topics_share_a_domain)
{
    check_takeover(arm_domain());
}

int main(void)
{
    return test_run(NULL, NULL);
}
