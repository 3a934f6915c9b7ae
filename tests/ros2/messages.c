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
#define ROW(member, type, shape, capacity, bound, nested)                                          \
    {                                                                                              \
#member, offsetof(S, member), sizeof(((S *)0)->member), type, shape, capacity, bound,      \
            nested                                                                                 \
    }
#define ONE(member, type) ROW(member, MSG_##type, MSG_ONE, 0, 0, NULL)
#define ARRAY(member, type, count) ROW(member, MSG_##type, MSG_ARRAY, count, 0, NULL)
#define SEQ(member, type) ROW(member, MSG_##type, MSG_SEQUENCE, 0, 0, NULL)
#define BOUNDED(member, bound) ROW(member, MSG_BOUNDED_STRING, MSG_ONE, 0, bound, NULL)
#define SUB(member, m) ROW(member, MSG_NESTED, MSG_ONE, 0, 0, m)
#define SUB_ARRAY(member, m, count) ROW(member, MSG_NESTED, MSG_ARRAY, count, 0, m)
#define SUB_SEQ(member, m) ROW(member, MSG_NESTED, MSG_SEQUENCE, 0, 0, m)

/* A function that returns the message: S has its scope. */
#define MESSAGE(function, struct_name, name, topic, ...)                                           \
    static const msg *function(void)                                                               \
    {                                                                                              \
        typedef struct_name S;                                                                     \
        static const msg_field field[] = {__VA_ARGS__};                                            \
        static const msg m = {name, sizeof(S), field, sizeof field / sizeof *field, topic};        \
        return &m;                                                                                 \
    }                                                                                              \
    _Static_assert(sizeof(struct_name) > 0, "")
/* A message that is sent by itself, and one that stands only within others */
#define TOPIC(function, package, kind, Name, ...)                                                  \
    MESSAGE(function, package##_##kind##_dds__##Name##_, #package "/" #kind "/" #Name,             \
            &package##_##kind##_dds__##Name##__desc, __VA_ARGS__)
#define PART(function, package, kind, Name, ...)                                                   \
    MESSAGE(function, package##_##kind##_dds__##Name##_, #package "/" #kind "/" #Name, NULL,       \
            __VA_ARGS__)

PART(time_stamp, builtin_interfaces, msg, Time, ONE(sec, INT32), ONE(nanosec, UINT32));
PART(duration, builtin_interfaces, msg, Duration, ONE(sec, INT32), ONE(nanosec, UINT32));
PART(header, std_msgs, msg, Header, SUB(stamp, time_stamp), ONE(frame_id, STRING));
TOPIC(string, std_msgs, msg, String, ONE(data, STRING));
PART(multi_array_dimension, std_msgs, msg, MultiArrayDimension, ONE(label, STRING),
     ONE(size, UINT32), ONE(stride, UINT32));
PART(multi_array_layout, std_msgs, msg, MultiArrayLayout, SUB_SEQ(dim, multi_array_dimension),
     ONE(data_offset, UINT32));
TOPIC(float64_multi_array, std_msgs, msg, Float64MultiArray, SUB(layout, multi_array_layout),
      SEQ(data, DOUBLE));
TOPIC(joint_state, sensor_msgs, msg, JointState, SUB(header, header), SEQ(name, STRING),
      SEQ(position, DOUBLE), SEQ(velocity, DOUBLE), SEQ(effort, DOUBLE));
PART(vector3, geometry_msgs, msg, Vector3, ONE(x, DOUBLE), ONE(y, DOUBLE), ONE(z, DOUBLE));
PART(wrench, geometry_msgs, msg, Wrench, SUB(force, vector3), SUB(torque, vector3));
TOPIC(wrench_stamped, geometry_msgs, msg, WrenchStamped, SUB(header, header), SUB(wrench, wrench));
PART(point, geometry_msgs, msg, Point, ONE(x, DOUBLE), ONE(y, DOUBLE), ONE(z, DOUBLE));
PART(quaternion, geometry_msgs, msg, Quaternion, ONE(x, DOUBLE), ONE(y, DOUBLE), ONE(z, DOUBLE),
     ONE(w, DOUBLE));
PART(pose, geometry_msgs, msg, Pose, SUB(position, point), SUB(orientation, quaternion));
PART(pose_with_covariance, geometry_msgs, msg, PoseWithCovariance, SUB(pose, pose),
     ARRAY(covariance, DOUBLE, 36));
PART(twist, geometry_msgs, msg, Twist, SUB(linear, vector3), SUB(angular, vector3));
PART(twist_with_covariance, geometry_msgs, msg, TwistWithCovariance, SUB(twist, twist),
     ARRAY(covariance, DOUBLE, 36));
PART(transform, geometry_msgs, msg, Transform, SUB(translation, vector3),
     SUB(rotation, quaternion));
TOPIC(multi_dof_joint_state, sensor_msgs, msg, MultiDOFJointState, SUB(header, header),
      SEQ(joint_names, STRING), SUB_SEQ(transforms, transform), SUB_SEQ(twist, twist),
      SUB_SEQ(wrench, wrench));
TOPIC(odometry, nav_msgs, msg, Odometry, SUB(header, header), ONE(child_frame_id, STRING),
      SUB(pose, pose_with_covariance), SUB(twist, twist_with_covariance));
TOPIC(joint_trajectory_point, trajectory_msgs, msg, JointTrajectoryPoint, SEQ(positions, DOUBLE),
      SEQ(velocities, DOUBLE), SEQ(accelerations, DOUBLE), SEQ(effort, DOUBLE),
      SUB(time_from_start, duration));
TOPIC(joint_trajectory, trajectory_msgs, msg, JointTrajectory, SUB(header, header),
      SEQ(joint_names, STRING), SUB_SEQ(points, joint_trajectory_point));
PART(key_value, diagnostic_msgs, msg, KeyValue, ONE(key, STRING), ONE(value, STRING));
PART(diagnostic_status, diagnostic_msgs, msg, DiagnosticStatus, ONE(level, BYTE), ONE(name, STRING),
     ONE(message, STRING), ONE(hardware_id, STRING), SUB_SEQ(values, key_value));
TOPIC(diagnostic_array, diagnostic_msgs, msg, DiagnosticArray, SUB(header, header),
      SUB_SEQ(status, diagnostic_status));
PART(gid, rmw_dds_common, msg, Gid, ARRAY(data, UINT8, 16));
PART(node_entities_info, rmw_dds_common, msg, NodeEntitiesInfo, BOUNDED(node_namespace, 256),
     BOUNDED(node_name, 256), SUB_SEQ(reader_gid_seq, gid), SUB_SEQ(writer_gid_seq, gid));
TOPIC(participant_entities_info, rmw_dds_common, msg, ParticipantEntitiesInfo, SUB(gid, gid),
      SUB_SEQ(node_entities_info_seq, node_entities_info));
PART(hg_imu_state, unitree_hg, msg, IMUState, ARRAY(quaternion, FLOAT, 4),
     ARRAY(gyroscope, FLOAT, 3), ARRAY(accelerometer, FLOAT, 3), ARRAY(rpy, FLOAT, 3),
     ONE(temperature, INT16));
PART(hg_motor_state, unitree_hg, msg, MotorState, ONE(mode, UINT8), ONE(q, FLOAT), ONE(dq, FLOAT),
     ONE(ddq, FLOAT), ONE(tau_est, FLOAT), ARRAY(temperature, INT16, 2), ONE(vol, FLOAT),
     ARRAY(sensor, UINT32, 2), ONE(motorstate, UINT32), ARRAY(reserve, UINT32, 4));
TOPIC(hg_low_state, unitree_hg, msg, LowState, ARRAY(version, UINT32, 2), ONE(mode_pr, UINT8),
      ONE(mode_machine, UINT8), ONE(tick, UINT32), SUB(imu_state, hg_imu_state),
      SUB_ARRAY(motor_state, hg_motor_state, 35), ARRAY(wireless_remote, UINT8, 40),
      ARRAY(reserve, UINT32, 4), ONE(crc, UINT32));
PART(go_imu_state, unitree_go, msg, IMUState, ARRAY(quaternion, FLOAT, 4),
     ARRAY(gyroscope, FLOAT, 3), ARRAY(accelerometer, FLOAT, 3), ARRAY(rpy, FLOAT, 3),
     ONE(temperature, INT8));
PART(go_motor_state, unitree_go, msg, MotorState, ONE(mode, UINT8), ONE(q, FLOAT), ONE(dq, FLOAT),
     ONE(ddq, FLOAT), ONE(tau_est, FLOAT), ONE(q_raw, FLOAT), ONE(dq_raw, FLOAT),
     ONE(ddq_raw, FLOAT), ONE(temperature, INT8), ONE(lost, UINT32), ARRAY(reserve, UINT32, 2));
PART(go_bms_state, unitree_go, msg, BmsState, ONE(version_high, UINT8), ONE(version_low, UINT8),
     ONE(status, UINT8), ONE(soc, UINT8), ONE(current, INT32), ONE(cycle, UINT16),
     ARRAY(bq_ntc, INT8, 2), ARRAY(mcu_ntc, INT8, 2), ARRAY(cell_vol, UINT16, 15));
TOPIC(go_low_state, unitree_go, msg, LowState, ARRAY(head, UINT8, 2), ONE(level_flag, UINT8),
      ONE(frame_reserve, UINT8), ARRAY(sn, UINT32, 2), ARRAY(version, UINT32, 2),
      ONE(bandwidth, UINT16), SUB(imu_state, go_imu_state),
      SUB_ARRAY(motor_state, go_motor_state, 20), SUB(bms_state, go_bms_state),
      ARRAY(foot_force, INT16, 4), ARRAY(foot_force_est, INT16, 4), ONE(tick, UINT32),
      ARRAY(wireless_remote, UINT8, 40), ONE(bit_flag, UINT8), ONE(adc_reel, FLOAT),
      ONE(temperature_ntc1, INT8), ONE(temperature_ntc2, INT8), ONE(power_v, FLOAT),
      ONE(power_a, FLOAT), ARRAY(fan_frequency, UINT16, 4), ONE(reserve, UINT32), ONE(crc, UINT32));
TOPIC(service_request, test, srv, Dynamics_Request, ONE(guid, UINT64), ONE(seq, INT64),
      SEQ(q, DOUBLE), SEQ(v, DOUBLE), SEQ(tau, DOUBLE));
TOPIC(service_call, totalforce_msgs, srv, ForwardDynamics_Request, ONE(guid, UINT64),
      ONE(seq, INT64), SUB(state, joint_state));
TOPIC(service_reply, totalforce_msgs, srv, ForwardDynamics_Response, ONE(guid, UINT64),
      ONE(seq, INT64), ONE(success, BOOLEAN), ONE(message, STRING), SEQ(name, STRING),
      SEQ(acceleration, DOUBLE));

typedef const msg *(*msg_function)(void);

/* clang-format off */
static const msg_function all[] = {
    time_stamp, duration, header, string, multi_array_dimension, multi_array_layout,
    float64_multi_array, joint_state, vector3, wrench, wrench_stamped, point, quaternion, pose,
    pose_with_covariance, twist, twist_with_covariance, transform, multi_dof_joint_state,
    odometry, joint_trajectory_point, joint_trajectory, key_value, diagnostic_status,
    diagnostic_array, gid, node_entities_info, participant_entities_info, hg_imu_state,
    hg_motor_state, hg_low_state, go_imu_state, go_motor_state, go_bms_state, go_low_state,
};
/* clang-format on */

const msg *const *messages(void)
{
    static const msg *list[sizeof all / sizeof *all + 1];
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        list[k] = all[k]();
    return list;
}

const msg *const *services(void)
{
    static const msg *list[4];
    list[0] = service_request();
    list[1] = service_call();
    list[2] = service_reply();
    return list;
}

static const msg *find(const msg *const *m, const dds_topic_descriptor_t *topic)
{
    while (*m != NULL && (*m)->topic != topic)
        m++;
    return *m;
}

const msg *msg_of_topic(const dds_topic_descriptor_t *topic)
{
    const msg *m = find(messages(), topic);
    if (m == NULL && (m = find(services(), topic)) == NULL)
        fail_msg("no message %s", topic->m_typename);
    return m;
}
