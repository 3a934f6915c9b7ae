/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See herald.h.
 */
#include "herald.h"

#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "support/wait.h"
#include "test.h"

#include <string.h>

/* Whether the daemon has that role, or leads. A standby must have the leader's model: it says
 * which. */
static bool has_role(dds_entity_t reader, totalforce_dds_Leader *said, uint32_t role)
{
    totalforce_dds_Leader heard = {0};
    dds_sample_info_t info;
    while (dds_take(reader, (void *[]){&heard}, &info, 1, 1) == 1) {
        if (!info.valid_data || strcmp(heard.robot, said->robot) != 0 ||
            memcmp(heard.daemon, said->daemon, sizeof heard.daemon) == 0)
            continue;
        if (heard.role == role || heard.role == totalforce_dds_LEADER_LEADING)
            return true;
        memcpy(said->model_hash, heard.model_hash, sizeof said->model_hash);
    }
    return false;
}

/* Says it again and again, because the readers of this topic are best effort, but in no flood for
 * a daemon that gets little of a processor. @return the daemon has that role */
static bool is_heard(dds_return_t (*say)(dds_entity_t, const void *), dds_entity_t writer,
                     dds_entity_t reader, totalforce_dds_Leader *said, uint32_t role)
{
    const uint64_t end = now_ns() + WAIT_NS / 5;
    bool heard = false;
    while (!heard && now_ns() < end) {
        assert_int_equal(say(writer, said), DDS_RETCODE_OK);
        sleep_ms(20);
        heard = has_role(reader, said, role);
    }
    return heard;
}

/* The words of a daemon that heard a participant have not reached that one within five minutes,
 * twice in runs of all tests (Cyclone DDS 0.10.2): then another one is made. */
static bool herald(uint32_t domain, const char *robot)
{
    const dds_entity_t p = dds_create_participant(domain, NULL, NULL);
    const dds_entity_t topic = tfa_dds_create_topic(p, TFA_DDS_LEADER);
    const dds_entity_t writer = tfa_dds_create_leader_writer(p, topic, DDS_INFINITY);
    const dds_entity_t reader = tfa_dds_create_reader(p, topic, TFA_DDS_LEADER, NULL);
    totalforce_dds_Leader said = {.role = totalforce_dds_LEADER_LEADING, .lease_ms = WAIT_MS};
    dds_subscription_matched_status_t writers;
    dds_guid_t guid;
    assert_true(p > 0 && topic > 0 && writer > 0 && reader > 0);
    assert_int_equal(dds_get_guid(p, &guid), DDS_RETCODE_OK);
    memcpy(said.daemon, guid.v, sizeof said.daemon);
    assert_true(tfa_dds_set_robot(said.robot, robot));
    const bool followed = is_heard(dds_write, writer, reader, &said, totalforce_dds_LEADER_STANDBY);
    const bool leads =
        followed && is_heard(dds_dispose, writer, reader, &said, totalforce_dds_LEADER_LEADING);
    assert_int_equal(dds_get_subscription_matched_status(reader, &writers), DDS_RETCODE_OK);
    if (!leads)
        print_message("herald of %s: followed %d, %u writers matched\n", robot, followed,
                      writers.current_count);
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
    return leads;
}

void dds_herald(uint32_t domain, const char *robot)
{
    assert_true(WAIT_FOR(herald(domain, robot)));
}

const char *dds_yaml(uint32_t domain, int lease_ms)
{
    static char text[80];
    snprintf(text, sizeof text, "dds: {enabled: yes, domain: %u, lease_ms: %d}\n", domain,
             lease_ms);
    return text;
}

tfa_dds_client *dds_connect(uint32_t domain, const char *robot)
{
    const tfa_dds_client_options options = {
        .domain = domain, .robot = robot, .connect_timeout_ms = WAIT_MS};
    tfa_dds_client *client;
    assert_int_equal(tfa_dds_client_connect(&options, &client), TFA_OK);
    return client;
}
