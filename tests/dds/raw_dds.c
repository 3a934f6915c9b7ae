/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See raw_dds.h.
 */
#include "raw_dds.h"

#include "dds/topics/dds_topics.h"
#include "robots.h"
#include "support/wait.h"
#include "test.h"

#include <string.h>

raw_dds raw_dds_open(uint32_t domain)
{
    const dds_entity_t p = dds_create_participant(domain, NULL, NULL);
    dds_entity_t topics[TFA_DDS_ACCELERATIONS + 1];
    assert_true(p > 0);
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i <= TFA_DDS_ACCELERATIONS; i++)
        topics[i] = tfa_dds_create_topic(p, i);
    const raw_dds r = {
        p,
        tfa_dds_create_writer(p, topics[TFA_DDS_REQUEST], TFA_DDS_REQUEST, NULL),
        tfa_dds_create_reader(p, topics[TFA_DDS_REPLY], TFA_DDS_REPLY, NULL),
        tfa_dds_create_writer(p, topics[TFA_DDS_TORQUES], TFA_DDS_TORQUES, NULL),
        tfa_dds_create_reader(p, topics[TFA_DDS_ACCELERATIONS], TFA_DDS_ACCELERATIONS, NULL),
    };
    assert_true(r.writer > 0 && r.reader > 0 && r.torques > 0 && r.accelerations > 0);
    return r;
}

void raw_dds_close(const raw_dds *r)
{
    assert_int_equal(dds_delete(r->participant), DDS_RETCODE_OK);
}

bool raw_dds_take(dds_entity_t reader, void *out)
{
    dds_sample_info_t info;
    while (dds_take(reader, (void *[]){out}, &info, 1, 1) == 1)
        if (info.valid_data)
            return true;
    return false;
}

bool raw_dds_take_info(dds_entity_t reader, totalforce_dds_RobotInfo *arm, bool withdrawn)
{
    dds_sample_info_t info;
    while (dds_take(reader, (void *[]){arm}, &info, 1, 1) == 1)
        if (strcmp(arm->robot, "arm") == 0 &&
            withdrawn == (info.instance_state != DDS_ALIVE_INSTANCE_STATE))
            return true;
    return false;
}

void raw_dds_ask_in_vain(const raw_dds *r, totalforce_dds_Request *request)
{
    request->id = RAW_DDS_IN_VAIN;
    assert_int_equal(dds_write(r->writer, request), DDS_RETCODE_OK);
    assert_int_equal(dds_wait_for_acks(r->writer, (dds_duration_t)WAIT_NS), DDS_RETCODE_OK);
}

static totalforce_dds_Reply *take_reply(const raw_dds *r)
{
    static totalforce_dds_Reply reply;
    if (!raw_dds_take(r->reader, &reply))
        return NULL;
    assert_int_not_equal(reply.id, RAW_DDS_IN_VAIN);
    return &reply;
}

totalforce_dds_Reply *raw_dds_ask(const raw_dds *r, totalforce_dds_Request *request)
{
    static uint64_t id = 1000;
    totalforce_dds_Reply *reply;
    request->id = ++id;
    assert_int_equal(dds_write(r->writer, request), DDS_RETCODE_OK);
    assert_true(WAIT_FOR((reply = take_reply(r)) != NULL && reply->id == id));
    return reply;
}

/* One hello, and the replies that have come. */
static bool is_greeted(const raw_dds *r, const totalforce_dds_Request *hello, int status)
{
    const totalforce_dds_Reply *reply;
    assert_int_equal(dds_write(r->writer, hello), DDS_RETCODE_OK);
    sleep_ms(10); /* not a thousand hellos a second */
    while ((reply = take_reply(r)) != NULL)
        if (strcmp(reply->robot, hello->robot) == 0) {
            assert_int_equal(reply->status, status);
            return true;
        }
    return false;
}

void raw_dds_await(const raw_dds *r, const char *robot, int status)
{
    totalforce_dds_Request hello = {.op = totalforce_dds_OP_HELLO};
    assert_true(tfa_dds_set_robot(hello.robot, robot));
    assert_true(WAIT_FOR(is_greeted(r, &hello, status)));
}

double raw_dds_zeros[RAW_DDS_JOINTS * TEST_BATCH];

totalforce_dds_Request raw_dds_request(void)
{
    totalforce_dds_Request request = {
        .op = TFA_OP_FORWARD_DYNAMICS,
        .refine = TFA_REFINE_DEFAULT,
        .count = 1,
        .q = {RAW_DDS_JOINTS, RAW_DDS_JOINTS, raw_dds_zeros, false},
    };
    assert_true(tfa_dds_set_robot(request.robot, "arm"));
    return request;
}
