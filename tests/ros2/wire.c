/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bytes of the foreign messages: Cyclone writes and reads by our IDL what ROS 2 expects, and it
 * refuses truncated samples.
 */
#include "cyclone_wire.h"
#include "messages.h"
#include "test.h"

#include <idl/ros2.h>
#include <idl/ros2_service.h>

/* Cyclone writes the sample as these bytes and reads them as the sample. */
static void assert_on_wire(const msg *m, const void *sample, const uint8_t *expected, size_t size)
{
    static msg_bytes written;
    const wire w = wire_open(m);
    struct ddsi_serdata *data = write_bytes(&w, sample, &written);
    assert_same_bytes(written.byte, written.size, expected, size);
    assert_read(m, data->type, &written, sample);
    ddsi_serdata_unref(data);
    wire_close(&w);
}

TEST(joint_state_has_the_known_bytes)
{
    static const uint8_t expected[92] = {
        0x00, 0x01, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x05, 0x00,
        0x00, 0x00, 0x62, 0x61, 0x73, 0x65, 0x00, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00,
        0x03, 0x00, 0x00, 0x00, 0x6a, 0x31, 0x00, 0x00, 0x06, 0x00, 0x00, 0x00, 0x65, 0x6c,
        0x62, 0x6f, 0x77, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0xe0, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0xbf, 0x00, 0x00,
        0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0x40,
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x10, 0x40,
    };
    char *name[] = {"j1", "elbow"};
    double position[] = {0.5, -1}, effort[] = {3, 4};
    const sensor_msgs_msg_dds__JointState_ sample = {
        .header = {{1, 2}, "base"},
        .name = {2, 2, name, false},
        .position = {2, 2, position, false},
        .effort = {2, 2, effort, false},
    };
    const msg *const m = msg_of_topic(&sensor_msgs_msg_dds__JointState__desc);
    assert_on_wire(m, &sample, expected, sizeof expected);
    /* and member by member */
    sensor_msgs_msg_dds__JointState_ copy = {0};
    static msg_bytes bytes;
    const wire w = wire_open(m);
    struct ddsi_serdata *data = write_bytes(&w, &sample, &bytes);
    assert_true(read_bytes(data->type, expected, sizeof expected, &copy));
    assert_int_equal(copy.header.stamp.sec, 1);
    assert_int_equal(copy.header.stamp.nanosec, 2);
    assert_string_equal(copy.header.frame_id, "base");
    assert_int_equal(copy.name._length, 2);
    assert_string_equal(copy.name._buffer[0], "j1");
    assert_string_equal(copy.name._buffer[1], "elbow");
    assert_int_equal(copy.position._length, 2);
    assert_memory_equal(copy.position._buffer, position, sizeof position);
    assert_int_equal(copy.velocity._length, 0);
    assert_int_equal(copy.effort._length, 2);
    assert_memory_equal(copy.effort._buffer, effort, sizeof effort);
    dds_sample_free(&copy, m->topic, DDS_FREE_CONTENTS);
    ddsi_serdata_unref(data);
    wire_close(&w);
}

TEST(service_request_has_the_known_bytes)
{
    static const uint8_t expected[60] = {
        0x00, 0x01, 0x00, 0x00, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11, 0x01, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0xe0, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0xbf, 0x00,
        0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xe0, 0x3f,
    };
    double q[] = {0.5, -1}, tau[] = {0.5};
    const test_srv_dds__Dynamics_Request_ sample = {
        .guid = UINT64_C(0x1122334455667788),
        .seq = 1,
        .q = {2, 2, q, false},
        .tau = {1, 1, tau, false},
    };
    assert_on_wire(msg_of_topic(&test_srv_dds__Dynamics_Request__desc), &sample, expected,
                   sizeof expected);
}

/* A string of two characters is 7 bytes, and one of padding. */
TEST(padding_at_the_end_is_counted_in_the_header)
{
    static const uint8_t expected[] = {0, 1, 0, 1, 3, 0, 0, 0, 'h', 'i', 0, 0};
    const std_msgs_msg_dds__String_ sample = {"hi"};
    assert_on_wire(msg_of_topic(&std_msgs_msg_dds__String__desc), &sample, expected,
                   sizeof expected);
}

/* Cyclone's bytes are those of msg_encode, and no shorter sample is read, whatever its header says
 * of padding. */
static void check_sample(const msg *m, const void *sample, msg_bytes *written,
                         const struct ddsi_sertype *type)
{
    static msg_bytes expected;
    msg_encode(m, sample, &expected);
    assert_same_bytes(written->byte, written->size, expected.byte, expected.size);
    assert_read(m, type, &expected, sample);
    for (uint8_t padding = 0; padding < 4; padding++) {
        expected.byte[3] = padding;
        for (size_t size = 4; size < expected.size - expected.padding; size++)
            assert_false(read_bytes(type, expected.byte, size, NULL));
    }
}

TEST(random_samples_have_the_bytes_of_the_specification_and_truncated_ones_are_refused)
{
    wire_for_samples(messages(), check_sample);
    wire_for_samples(services(), check_sample);
}

int main(void)
{
    return test_run(wire_open_participant, wire_close_participant);
}
