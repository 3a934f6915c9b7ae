/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the DDS types and the C types of dynamics.h, for the daemon and for its DDS client.
 *
 * Nothing here allocates or copies an input array: a sample made from a request points at the
 * caller's arrays, a request made from a sample points into the sample. Pure functions, any thread.
 */
#ifndef TFA_SERVICE_DDS_CONVERT_H
#define TFA_SERVICE_DDS_CONVERT_H

#include <stdbool.h>
#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/status.h>

#include <idl/totalforce.h>

#include "ipc/wire_blocks.h"

/* Topic names; the types and the QoS stand in totalforce.idl. */
#define TFA_DDS_TOPIC_ROBOT_INFO "totalforce/robot_info"
#define TFA_DDS_TOPIC_REQUEST "totalforce/request"
#define TFA_DDS_TOPIC_REPLY "totalforce/reply"
#define TFA_DDS_TOPIC_TORQUES "totalforce/joint_torques"
#define TFA_DDS_TOPIC_ACCELERATIONS "totalforce/joint_accelerations"
#define TFA_DDS_TOPIC_LEADER "totalforce/leader"

/** Why a sample was not turned into a request; `status` is TFA_OK when it was. */
typedef struct tfa_dds_field_error {
    int32_t status;
    tfa_field field;
    uint32_t index; /**< E_SIZE: how many numbers the field had */
} tfa_dds_field_error;

/**
 * Views a Request sample as a tfa_request: its pointers lead into the sample.
 *
 * Checks the fields that decide sizes: op, rows, count (1 .. max_batch), numbers of tips, wrenches,
 * payloads and joints, the length of every sequence. Leaves values, frames and methods to
 * tfa_request_check (but a method that has more than 16 bits is refused here).
 * @return error->status: TFA_OK; TFA_E_ARGUMENT (op); TFA_E_SIZE; TFA_E_METHOD.
 */
int tfa_dds_request_view(const totalforce_dds_Request *sample, const tfa_wire_shape *shape,
                         tfa_request *request, tfa_dds_field_error *field_error);

/** Views a JointTorques sample as a forward dynamics request of one state. As above. */
int tfa_dds_torques_view(const totalforce_dds_JointTorques *sample, const tfa_wire_shape *shape,
                         tfa_request *request, tfa_dds_field_error *field_error);

/**
 * Fills everything of a Request sample that comes from a tfa_request (not robot, client, id and
 * stamp). The sequences point at the arrays of the request: write the sample while those live, and
 * never free it.
 * @return TFA_OK; TFA_E_SIZE (more tips than max_tips, more wrenches or payloads than a tfa_request
 *         holds, more locked joints than the robot has).
 */
int tfa_dds_request_fill(const tfa_request *request, const tfa_wire_shape *shape,
                         totalforce_dds_Request *sample);

/**
 * Fills everything of a Reply sample that comes from a tfa_reply (not robot, client, id, times and
 * hash): the arrays of `reply_shape` (tfa_wire_reply_shape_of). The sequences point at the buffers
 * of the reply. They are empty when the request was bad.
 */
void tfa_dds_reply_fill(const tfa_reply *reply, const tfa_wire_shape *shape,
                        const tfa_wire_reply_shape *reply_shape, totalforce_dds_Reply *sample);

/** The same for a JointAccelerations sample (not robot, seq, stamp, time and hash). */
void tfa_dds_accelerations_fill(const tfa_reply *reply, const tfa_wire_shape *shape,
                                totalforce_dds_JointAccelerations *sample);

/**
 * Copies a Reply sample into the buffers of a tfa_reply; buffers that are NULL are passed over.
 * @return TFA_OK; TFA_E_PROTOCOL (a sequence does not have the size that the request implies).
 */
TFA_CHECKED int tfa_dds_reply_read(const totalforce_dds_Reply *sample, const tfa_wire_shape *shape,
                                   const tfa_wire_reply_shape *reply_shape, tfa_reply *reply);

/**
 * Writes the hash of the model that answered: `present`, the one that RobotInfo tells, unless
 * `model` (tfa_reply.model; 0: no answer) is the tag of another, of which no more is known.
 */
void tfa_dds_set_hash(totalforce_dds_Hash hash, const totalforce_dds_Hash present, uint64_t model);

/** Copies a robot's name into the key of a sample. @return whether it fits. */
bool tfa_dds_set_robot(char key[totalforce_dds_ROBOT_NAME_MAX + 1], const char *name);

/** CLOCK_REALTIME in ns: the stamps of all topics. */
int64_t tfa_dds_ros_time(void);

/** Offset from CLOCK_MONOTONIC ns to ROS time; exact to the cost of reading a clock. */
int64_t tfa_dds_ros_offset(void);

#endif
