/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A participant of Fast DDS on the loopback interface, with the names, QoS, encoding and user data
 * of rmw_fastrtps. It meets Cyclone participants that use config/dds/local.xml.
 *
 * A sample is its bytes in XCDR1 with the header of RTPS, as by fastcdr_encode and msg_encode.
 *
 * Fast DDS 2.9 does not notice that Cyclone closes a writer or reader before its participant,
 * unless Cyclone's configuration has Internal/GenerateKeyhash: it takes the key of what is disposed
 * from the key hash alone.
 */
#ifndef TESTS_ROS2_FASTDDS_PEER_H
#define TESTS_ROS2_FASTDDS_PEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fastdds_peer fastdds_peer;
typedef struct fastdds_writer fastdds_writer;
typedef struct fastdds_reader fastdds_reader;

typedef struct fastdds_qos {
    bool reliable, transient_local;
    int depth; /* samples kept */
} fastdds_qos;

/** Profiles of ROS 2: default, sensor data, messages for late joiners as robot_description. */
extern const fastdds_qos fastdds_default, fastdds_sensor_data, fastdds_latched;

/** Partners of a writer or reader, and those refused for their QoS so far. */
typedef struct fastdds_matches {
    int matched, incompatible;
    int policy; /* QoS policy of the last refusal as DDS numbers them */
} fastdds_matches;

/** What another participant announces of a writer or reader. */
typedef struct fastdds_endpoint {
    char type[128];
    char user_data[128];
    uint8_t gid[16];
    bool reliable, transient_local;
} fastdds_endpoint;

/** Opens a participant. Returns NULL if Fast DDS cannot. */
fastdds_peer *fastdds_open(uint32_t domain);
/** Closes it with its writers and readers. */
void fastdds_close(fastdds_peer *p);
/** Identity of the participant in ros_discovery_info. */
void fastdds_gid(const fastdds_peer *p, uint8_t gid[16]);

/** Topic and type are DDS names: rt/joint_states, sensor_msgs::msg::dds_::JointState_. The user
 * data is the hash of the type. Returns NULL if Fast DDS cannot. */
fastdds_writer *fastdds_open_writer(fastdds_peer *p, const char *topic, const char *type,
                                    const fastdds_qos *qos);
fastdds_reader *fastdds_open_reader(fastdds_peer *p, const char *topic, const char *type,
                                    const fastdds_qos *qos);
void fastdds_close_writer(fastdds_peer *p, fastdds_writer *w);
void fastdds_close_reader(fastdds_peer *p, fastdds_reader *r);

bool fastdds_write(fastdds_writer *w, const uint8_t *byte, size_t size);
/** Takes the next sample. Returns its bytes; 0 if none comes or it is larger than `capacity`. */
size_t fastdds_take(fastdds_reader *r, uint8_t *byte, size_t capacity, int timeout_ms);

fastdds_matches fastdds_writer_matches(fastdds_writer *w);
fastdds_matches fastdds_reader_matches(fastdds_reader *r);
void fastdds_writer_gid(const fastdds_writer *w, uint8_t gid[16]);
void fastdds_reader_gid(const fastdds_reader *r, uint8_t gid[16]);

/** Waits until another participant has a writer, or else a reader, of the topic. */
bool fastdds_await_endpoint(fastdds_peer *p, const char *topic, bool is_writer,
                            fastdds_endpoint *out, int timeout_ms);
/** User data of another participant. Returns false if none of this identity is known. */
bool fastdds_participant_user_data(fastdds_peer *p, const uint8_t gid[16], char text[128]);

#ifdef __cplusplus
}
#endif

#endif
