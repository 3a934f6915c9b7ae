/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See messages.h.
 */
#include "messages.h"

#include "test.h"

#include <idl/ros2.h>
#include <idl/ros2_service.h>
#include <idl/unitree.h>

/* Rows of a message whose C struct is S: the compiler checks the names of its members. */
#define FIELD(member) #member, offsetof(S, member), sizeof(((S *)0)->member)
#define ONE(member, type)                                                                          \
    {                                                                                              \
        FIELD(member), type, MSG_ONE, 0, 0, NULL                                                   \
    }
#define ARRAY(member, type, count)                                                                 \
    {                                                                                              \
        FIELD(member), type, MSG_ARRAY, count, 0, NULL                                             \
    }
#define SEQ(member, type)                                                                          \
    {                                                                                              \
        FIELD(member), type, MSG_SEQUENCE, 0, 0, NULL                                              \
    }
#define BOUNDED(member, bound)                                                                     \
    {                                                                                              \
        FIELD(member), MSG_BOUNDED_STRING, MSG_ONE, 0, bound, NULL                                 \
    }
#define SUB(member, m)                                                                             \
    {                                                                                              \
        FIELD(member), MSG_NESTED, MSG_ONE, 0, 0, &(m)                                             \
    }
#define SUB_ARRAY(member, m, count)                                                                \
    {                                                                                              \
        FIELD(member), MSG_NESTED, MSG_ARRAY, count, 0, &(m)                                       \
    }
#define SUB_SEQ(member, m)                                                                         \
    {                                                                                              \
        FIELD(member), MSG_NESTED, MSG_SEQUENCE, 0, 0, &(m)                                        \
    }
#define MSG(rows, name, topic)                                                                     \
    {                                                                                              \
        name, sizeof(S), rows, sizeof(rows) / sizeof *(rows), topic                                \
    }

#define S builtin_interfaces_msg_dds__Time_
static const msg_field time_fields[] = {
    ONE(sec, MSG_INT32),
    ONE(nanosec, MSG_UINT32),
};
static const msg time_stamp = MSG(time_fields, "builtin_interfaces/msg/Time", NULL);
#undef S

#define S builtin_interfaces_msg_dds__Duration_
static const msg_field duration_fields[] = {
    ONE(sec, MSG_INT32),
    ONE(nanosec, MSG_UINT32),
};
static const msg duration = MSG(duration_fields, "builtin_interfaces/msg/Duration", NULL);
#undef S

#define S std_msgs_msg_dds__Header_
static const msg_field header_fields[] = {
    SUB(stamp, time_stamp),
    ONE(frame_id, MSG_STRING),
};
static const msg header = MSG(header_fields, "std_msgs/msg/Header", NULL);
#undef S

#define S std_msgs_msg_dds__String_
static const msg_field string_fields[] = {
    ONE(data, MSG_STRING),
};
static const msg string =
    MSG(string_fields, "std_msgs/msg/String", &std_msgs_msg_dds__String__desc);
#undef S

#define S std_msgs_msg_dds__MultiArrayDimension_
static const msg_field multi_array_dimension_fields[] = {
    ONE(label, MSG_STRING),
    ONE(size, MSG_UINT32),
    ONE(stride, MSG_UINT32),
};
static const msg multi_array_dimension =
    MSG(multi_array_dimension_fields, "std_msgs/msg/MultiArrayDimension", NULL);
#undef S

#define S std_msgs_msg_dds__MultiArrayLayout_
static const msg_field multi_array_layout_fields[] = {
    SUB_SEQ(dim, multi_array_dimension),
    ONE(data_offset, MSG_UINT32),
};
static const msg multi_array_layout =
    MSG(multi_array_layout_fields, "std_msgs/msg/MultiArrayLayout", NULL);
#undef S

#define S std_msgs_msg_dds__Float64MultiArray_
static const msg_field float64_multi_array_fields[] = {
    SUB(layout, multi_array_layout),
    SEQ(data, MSG_DOUBLE),
};
static const msg float64_multi_array =
    MSG(float64_multi_array_fields, "std_msgs/msg/Float64MultiArray",
        &std_msgs_msg_dds__Float64MultiArray__desc);
#undef S

#define S sensor_msgs_msg_dds__JointState_
static const msg_field joint_state_fields[] = {
    SUB(header, header),       SEQ(name, MSG_STRING),   SEQ(position, MSG_DOUBLE),
    SEQ(velocity, MSG_DOUBLE), SEQ(effort, MSG_DOUBLE),
};
static const msg joint_state =
    MSG(joint_state_fields, "sensor_msgs/msg/JointState", &sensor_msgs_msg_dds__JointState__desc);
#undef S

#define S geometry_msgs_msg_dds__Vector3_
static const msg_field vector3_fields[] = {
    ONE(x, MSG_DOUBLE),
    ONE(y, MSG_DOUBLE),
    ONE(z, MSG_DOUBLE),
};
static const msg vector3 = MSG(vector3_fields, "geometry_msgs/msg/Vector3", NULL);
#undef S

#define S geometry_msgs_msg_dds__Wrench_
static const msg_field wrench_fields[] = {
    SUB(force, vector3),
    SUB(torque, vector3),
};
static const msg wrench = MSG(wrench_fields, "geometry_msgs/msg/Wrench", NULL);
#undef S

#define S geometry_msgs_msg_dds__WrenchStamped_
static const msg_field wrench_stamped_fields[] = {
    SUB(header, header),
    SUB(wrench, wrench),
};
static const msg wrench_stamped = MSG(wrench_stamped_fields, "geometry_msgs/msg/WrenchStamped",
                                      &geometry_msgs_msg_dds__WrenchStamped__desc);
#undef S

#define S geometry_msgs_msg_dds__Point_
static const msg_field point_fields[] = {
    ONE(x, MSG_DOUBLE),
    ONE(y, MSG_DOUBLE),
    ONE(z, MSG_DOUBLE),
};
static const msg point = MSG(point_fields, "geometry_msgs/msg/Point", NULL);
#undef S

#define S geometry_msgs_msg_dds__Quaternion_
static const msg_field quaternion_fields[] = {
    ONE(x, MSG_DOUBLE),
    ONE(y, MSG_DOUBLE),
    ONE(z, MSG_DOUBLE),
    ONE(w, MSG_DOUBLE),
};
static const msg quaternion = MSG(quaternion_fields, "geometry_msgs/msg/Quaternion", NULL);
#undef S

#define S geometry_msgs_msg_dds__Pose_
static const msg_field pose_fields[] = {
    SUB(position, point),
    SUB(orientation, quaternion),
};
static const msg pose = MSG(pose_fields, "geometry_msgs/msg/Pose", NULL);
#undef S

#define S geometry_msgs_msg_dds__PoseWithCovariance_
static const msg_field pose_with_covariance_fields[] = {
    SUB(pose, pose),
    ARRAY(covariance, MSG_DOUBLE, 36),
};
static const msg pose_with_covariance =
    MSG(pose_with_covariance_fields, "geometry_msgs/msg/PoseWithCovariance", NULL);
#undef S

#define S geometry_msgs_msg_dds__Twist_
static const msg_field twist_fields[] = {
    SUB(linear, vector3),
    SUB(angular, vector3),
};
static const msg twist = MSG(twist_fields, "geometry_msgs/msg/Twist", NULL);
#undef S

#define S geometry_msgs_msg_dds__TwistWithCovariance_
static const msg_field twist_with_covariance_fields[] = {
    SUB(twist, twist),
    ARRAY(covariance, MSG_DOUBLE, 36),
};
static const msg twist_with_covariance =
    MSG(twist_with_covariance_fields, "geometry_msgs/msg/TwistWithCovariance", NULL);
#undef S

#define S nav_msgs_msg_dds__Odometry_
static const msg_field odometry_fields[] = {
    SUB(header, header),
    ONE(child_frame_id, MSG_STRING),
    SUB(pose, pose_with_covariance),
    SUB(twist, twist_with_covariance),
};
static const msg odometry =
    MSG(odometry_fields, "nav_msgs/msg/Odometry", &nav_msgs_msg_dds__Odometry__desc);
#undef S

#define S trajectory_msgs_msg_dds__JointTrajectoryPoint_
static const msg_field joint_trajectory_point_fields[] = {
    SEQ(positions, MSG_DOUBLE), SEQ(velocities, MSG_DOUBLE),    SEQ(accelerations, MSG_DOUBLE),
    SEQ(effort, MSG_DOUBLE),    SUB(time_from_start, duration),
};
static const msg joint_trajectory_point =
    MSG(joint_trajectory_point_fields, "trajectory_msgs/msg/JointTrajectoryPoint",
        &trajectory_msgs_msg_dds__JointTrajectoryPoint__desc);
#undef S

#define S trajectory_msgs_msg_dds__JointTrajectory_
static const msg_field joint_trajectory_fields[] = {
    SUB(header, header),
    SEQ(joint_names, MSG_STRING),
    SUB_SEQ(points, joint_trajectory_point),
};
static const msg joint_trajectory =
    MSG(joint_trajectory_fields, "trajectory_msgs/msg/JointTrajectory",
        &trajectory_msgs_msg_dds__JointTrajectory__desc);
#undef S

#define S diagnostic_msgs_msg_dds__KeyValue_
static const msg_field key_value_fields[] = {
    ONE(key, MSG_STRING),
    ONE(value, MSG_STRING),
};
static const msg key_value = MSG(key_value_fields, "diagnostic_msgs/msg/KeyValue", NULL);
#undef S

#define S diagnostic_msgs_msg_dds__DiagnosticStatus_
static const msg_field diagnostic_status_fields[] = {
    ONE(level, MSG_BYTE),         ONE(name, MSG_STRING),      ONE(message, MSG_STRING),
    ONE(hardware_id, MSG_STRING), SUB_SEQ(values, key_value),
};
static const msg diagnostic_status =
    MSG(diagnostic_status_fields, "diagnostic_msgs/msg/DiagnosticStatus", NULL);
#undef S

#define S diagnostic_msgs_msg_dds__DiagnosticArray_
static const msg_field diagnostic_array_fields[] = {
    SUB(header, header),
    SUB_SEQ(status, diagnostic_status),
};
static const msg diagnostic_array =
    MSG(diagnostic_array_fields, "diagnostic_msgs/msg/DiagnosticArray",
        &diagnostic_msgs_msg_dds__DiagnosticArray__desc);
#undef S

#define S rmw_dds_common_msg_dds__Gid_
static const msg_field gid_fields[] = {
    ARRAY(data, MSG_UINT8, 16),
};
static const msg gid = MSG(gid_fields, "rmw_dds_common/msg/Gid", NULL);
#undef S

#define S rmw_dds_common_msg_dds__NodeEntitiesInfo_
static const msg_field node_entities_info_fields[] = {
    BOUNDED(node_namespace, 256),
    BOUNDED(node_name, 256),
    SUB_SEQ(reader_gid_seq, gid),
    SUB_SEQ(writer_gid_seq, gid),
};
static const msg node_entities_info =
    MSG(node_entities_info_fields, "rmw_dds_common/msg/NodeEntitiesInfo", NULL);
#undef S

#define S rmw_dds_common_msg_dds__ParticipantEntitiesInfo_
static const msg_field participant_entities_info_fields[] = {
    SUB(gid, gid),
    SUB_SEQ(node_entities_info_seq, node_entities_info),
};
static const msg participant_entities_info =
    MSG(participant_entities_info_fields, "rmw_dds_common/msg/ParticipantEntitiesInfo",
        &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc);
#undef S

#define S unitree_hg_msg_dds__IMUState_
static const msg_field hg_imu_state_fields[] = {
    ARRAY(quaternion, MSG_FLOAT, 4),    ARRAY(gyroscope, MSG_FLOAT, 3),
    ARRAY(accelerometer, MSG_FLOAT, 3), ARRAY(rpy, MSG_FLOAT, 3),
    ONE(temperature, MSG_INT16),
};
static const msg hg_imu_state = MSG(hg_imu_state_fields, "unitree_hg/msg/IMUState", NULL);
#undef S

#define S unitree_hg_msg_dds__MotorState_
static const msg_field hg_motor_state_fields[] = {
    ONE(mode, MSG_UINT8),        ONE(q, MSG_FLOAT),
    ONE(dq, MSG_FLOAT),          ONE(ddq, MSG_FLOAT),
    ONE(tau_est, MSG_FLOAT),     ARRAY(temperature, MSG_INT16, 2),
    ONE(vol, MSG_FLOAT),         ARRAY(sensor, MSG_UINT32, 2),
    ONE(motorstate, MSG_UINT32), ARRAY(reserve, MSG_UINT32, 4),
};
static const msg hg_motor_state = MSG(hg_motor_state_fields, "unitree_hg/msg/MotorState", NULL);
#undef S

#define S unitree_hg_msg_dds__LowState_
static const msg_field hg_low_state_fields[] = {
    ARRAY(version, MSG_UINT32, 2),
    ONE(mode_pr, MSG_UINT8),
    ONE(mode_machine, MSG_UINT8),
    ONE(tick, MSG_UINT32),
    SUB(imu_state, hg_imu_state),
    SUB_ARRAY(motor_state, hg_motor_state, 35),
    ARRAY(wireless_remote, MSG_UINT8, 40),
    ARRAY(reserve, MSG_UINT32, 4),
    ONE(crc, MSG_UINT32),
};
static const msg hg_low_state =
    MSG(hg_low_state_fields, "unitree_hg/msg/LowState", &unitree_hg_msg_dds__LowState__desc);
#undef S

#define S unitree_go_msg_dds__IMUState_
static const msg_field go_imu_state_fields[] = {
    ARRAY(quaternion, MSG_FLOAT, 4),    ARRAY(gyroscope, MSG_FLOAT, 3),
    ARRAY(accelerometer, MSG_FLOAT, 3), ARRAY(rpy, MSG_FLOAT, 3),
    ONE(temperature, MSG_INT8),
};
static const msg go_imu_state = MSG(go_imu_state_fields, "unitree_go/msg/IMUState", NULL);
#undef S

#define S unitree_go_msg_dds__MotorState_
static const msg_field go_motor_state_fields[] = {
    ONE(mode, MSG_UINT8),
    ONE(q, MSG_FLOAT),
    ONE(dq, MSG_FLOAT),
    ONE(ddq, MSG_FLOAT),
    ONE(tau_est, MSG_FLOAT),
    ONE(q_raw, MSG_FLOAT),
    ONE(dq_raw, MSG_FLOAT),
    ONE(ddq_raw, MSG_FLOAT),
    ONE(temperature, MSG_INT8),
    ONE(lost, MSG_UINT32),
    ARRAY(reserve, MSG_UINT32, 2),
};
static const msg go_motor_state = MSG(go_motor_state_fields, "unitree_go/msg/MotorState", NULL);
#undef S

#define S unitree_go_msg_dds__BmsState_
static const msg_field go_bms_state_fields[] = {
    ONE(version_high, MSG_UINT8), ONE(version_low, MSG_UINT8), ONE(status, MSG_UINT8),
    ONE(soc, MSG_UINT8),          ONE(current, MSG_INT32),     ONE(cycle, MSG_UINT16),
    ARRAY(bq_ntc, MSG_INT8, 2),   ARRAY(mcu_ntc, MSG_INT8, 2), ARRAY(cell_vol, MSG_UINT16, 15),
};
static const msg go_bms_state = MSG(go_bms_state_fields, "unitree_go/msg/BmsState", NULL);
#undef S

#define S unitree_go_msg_dds__LowState_
static const msg_field go_low_state_fields[] = {
    ARRAY(head, MSG_UINT8, 2),
    ONE(level_flag, MSG_UINT8),
    ONE(frame_reserve, MSG_UINT8),
    ARRAY(sn, MSG_UINT32, 2),
    ARRAY(version, MSG_UINT32, 2),
    ONE(bandwidth, MSG_UINT16),
    SUB(imu_state, go_imu_state),
    SUB_ARRAY(motor_state, go_motor_state, 20),
    SUB(bms_state, go_bms_state),
    ARRAY(foot_force, MSG_INT16, 4),
    ARRAY(foot_force_est, MSG_INT16, 4),
    ONE(tick, MSG_UINT32),
    ARRAY(wireless_remote, MSG_UINT8, 40),
    ONE(bit_flag, MSG_UINT8),
    ONE(adc_reel, MSG_FLOAT),
    ONE(temperature_ntc1, MSG_INT8),
    ONE(temperature_ntc2, MSG_INT8),
    ONE(power_v, MSG_FLOAT),
    ONE(power_a, MSG_FLOAT),
    ARRAY(fan_frequency, MSG_UINT16, 4),
    ONE(reserve, MSG_UINT32),
    ONE(crc, MSG_UINT32),
};
static const msg go_low_state =
    MSG(go_low_state_fields, "unitree_go/msg/LowState", &unitree_go_msg_dds__LowState__desc);
#undef S

#define S test_srv_dds__Dynamics_Request_
static const msg_field service_request_fields[] = {
    ONE(guid, MSG_UINT64), ONE(seq, MSG_INT64),  SEQ(q, MSG_DOUBLE),
    SEQ(v, MSG_DOUBLE),    SEQ(tau, MSG_DOUBLE),
};
const msg service_request =
    MSG(service_request_fields, "test/srv/Dynamics_Request", &test_srv_dds__Dynamics_Request__desc);
#undef S

#define S totalforce_msgs_srv_dds__ForwardDynamics_Request_
static const msg_field call_fields[] = {
    ONE(guid, MSG_UINT64),
    ONE(seq, MSG_INT64),
    SUB(state, joint_state),
};
const msg service_call = MSG(call_fields, "totalforce_msgs/srv/ForwardDynamics_Request",
                             &totalforce_msgs_srv_dds__ForwardDynamics_Request__desc);
#undef S

#define S totalforce_msgs_srv_dds__ForwardDynamics_Response_
static const msg_field reply_fields[] = {
    ONE(guid, MSG_UINT64),    ONE(seq, MSG_INT64),   ONE(success, MSG_BOOLEAN),
    ONE(message, MSG_STRING), SEQ(name, MSG_STRING), SEQ(acceleration, MSG_DOUBLE),
};
const msg service_reply = MSG(reply_fields, "totalforce_msgs/srv/ForwardDynamics_Response",
                              &totalforce_msgs_srv_dds__ForwardDynamics_Response__desc);
#undef S

const msg *const messages[MESSAGES_MAX] = {
    &time_stamp,
    &duration,
    &header,
    &string,
    &multi_array_dimension,
    &multi_array_layout,
    &float64_multi_array,
    &joint_state,
    &vector3,
    &wrench,
    &wrench_stamped,
    &point,
    &quaternion,
    &pose,
    &pose_with_covariance,
    &twist,
    &twist_with_covariance,
    &odometry,
    &joint_trajectory_point,
    &joint_trajectory,
    &key_value,
    &diagnostic_status,
    &diagnostic_array,
    &gid,
    &node_entities_info,
    &participant_entities_info,
    &hg_imu_state,
    &hg_motor_state,
    &hg_low_state,
    &go_imu_state,
    &go_motor_state,
    &go_bms_state,
    &go_low_state,
};

const msg *msg_of_topic(const dds_topic_descriptor_t *topic)
{
    for (const msg *const *m = messages; *m != NULL; m++)
        if ((*m)->topic == topic)
            return *m;
    fail_msg("no message %s", topic->m_typename);
    return NULL;
}
