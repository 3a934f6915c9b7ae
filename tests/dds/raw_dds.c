/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See raw_dds.h.
 */
#include "raw_dds.h"

#include "dds_gateway/dds_topics.h"
#include "robots.h"
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

bool raw_dds_take(dds_entity_t reader, void *out, int timeout_ms)
{
    for (int i = 0; i <= timeout_ms; i++) {
        void *samples[1] = {out};
        dds_sample_info_t info;
        if (dds_take(reader, samples, &info, 1, 1) == 1 && info.valid_data)
            return true;
        dds_sleepfor(DDS_MSECS(1));
    }
    return false;
}

totalforce_dds_Reply *raw_dds_ask(const raw_dds *r, totalforce_dds_Request *request)
{
    static uint64_t id = 1000;
    static totalforce_dds_Reply reply;

    request->id = ++id;
    assert_int_equal(dds_write(r->writer, request), DDS_RETCODE_OK);
    do
        assert_true(raw_dds_take(r->reader, &reply, 10000));
    while (reply.id != request->id);
    return &reply;
}

void raw_dds_await(const raw_dds *r, const char *robot, int status)
{
    totalforce_dds_Request hello = {.op = totalforce_dds_OP_HELLO};
    static totalforce_dds_Reply reply;

    assert_true(tfa_dds_set_robot(hello.robot, robot));
    for (int i = 0; i < 200; i++) {
        assert_int_equal(dds_write(r->writer, &hello), DDS_RETCODE_OK);
        while (raw_dds_take(r->reader, &reply, 50))
            if (strcmp(reply.robot, robot) == 0) {
                assert_int_equal(reply.status, status);
                return;
            }
    }
    fail_msg("no hello");
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

tfa_dds_client *raw_dds_connect(uint32_t domain)
{
    const tfa_dds_client_options options = {
        .domain = domain, .robot = "arm", .connect_timeout_ms = 20000};
    tfa_dds_client *client;

    assert_int_equal(tfa_dds_client_connect(&options, &client), TFA_OK);
    return client;
}
