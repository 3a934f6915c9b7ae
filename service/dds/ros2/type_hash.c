/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type hashes as constants: a hash changes only with the fields of its message, and
 * tests/ros2/type_hash.c computes them from descriptions of the messages.
 */
#include "dds/ros2/type_hash.h"

#include <stddef.h>
#include <string.h>

#define HASH(hex) "typehash=RIHS01_" hex ";"

static const struct {
    const char *dds_type, *user_data;
} hashes[] = {
    {"std_msgs::msg::dds_::String_",
     HASH("df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18")},
    {"std_msgs::msg::dds_::Float64MultiArray_",
     HASH("1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f")},
    {"sensor_msgs::msg::dds_::JointState_",
     HASH("a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e")},
    {"sensor_msgs::msg::dds_::MultiDOFJointState_",
     HASH("4d4ded702cfba7ff3ec783835c1a1425f75e53939a430ff355d1fee4b3bbc40b")},
    {"geometry_msgs::msg::dds_::WrenchStamped_",
     HASH("8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77")},
    {"trajectory_msgs::msg::dds_::JointTrajectoryPoint_",
     HASH("de8907036d8bd45aac6f30cc9044a3d4a329c42cbf719aff7d95a584cfa532d7")},
    {"trajectory_msgs::msg::dds_::JointTrajectory_",
     HASH("179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e")},
    {"diagnostic_msgs::msg::dds_::DiagnosticArray_",
     HASH("5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e")},
    {"nav_msgs::msg::dds_::Odometry_",
     HASH("3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0")},
    {"rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
     HASH("91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e")},
    {"unitree_go::msg::dds_::LowState_",
     HASH("db5172cac933e3cfc0e705903343eb4eea42e65e224e9d726d3e672aec0caf0f")},
    {"unitree_hg::msg::dds_::LowState_",
     HASH("aee6c5bd4b4d2eeca854bf47e32e4e3d34c47c2cafa05c08b6b0fa4bc51c6b3a")},
    {"totalforce_msgs::srv::dds_::ForwardDynamics_Request_",
     HASH("9547883d320f7fc2e0286823c9c017516a7031134aeb88619e111af52a0a8534")},
    {"totalforce_msgs::srv::dds_::ForwardDynamics_Response_",
     HASH("56b7ff69997a0f2b7d96c563557e4a8974db53f1e1a1479aeaaedbac8cd62c62")},
};

const char *tfa_ros2_user_data(const char *dds_type)
{
    for (size_t i = 0; i < sizeof hashes / sizeof *hashes; i++)
        if (strcmp(hashes[i].dds_type, dds_type) == 0)
            return hashes[i].user_data;
    return NULL;
}
