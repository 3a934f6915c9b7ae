/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The 7-joint arm on topics of ROS 2: a daemon that serves it, and the node that would control it.
 */
#ifndef TESTS_ROS2_ARM_H
#define TESTS_ROS2_ARM_H

#include "harness.h"
#include "ros2_peer.h"

#include <idl/ros2.h>
#include <pthread.h>
#include <stdatomic.h>
#include <totalforce/dynamics.h>
#include <totalforce/statistics.h>

#define JOINTS 7

/** A state of the arm with efforts, and what the daemon shall answer. */
typedef struct arm_motion {
    double q[JOINTS], v[JOINTS], tau[JOINTS];
} arm_motion;

/** The node: its endpoints are made by arm_node_open. */
typedef struct arm_node {
    uint32_t domain;
    dds_entity_t participant;
    dds_entity_t joint_states, effort_commands, joint_efforts, trajectory, description, wrench;
    dds_entity_t accelerations, diagnostics;
} arm_node;

extern char *arm_joints[JOINTS];

/** The domain of arm_settings and arm_node_open. */
uint32_t arm_domain(void);
/** The YAML of the arm with all its topics below /arm, where nothing is ever too old; `more` other
 * keys of its ros2 section. */
const char *arm_yaml(const char *more);
/** The top-level keys: ros2 in the test's domain; `more` others. */
const char *arm_settings(const char *more);
/** Participant and diagnostics only; the daemon runs. */
void arm_node_watch(arm_node *node);
/** Endpoints for all topics of the arm; waits until the daemon answers each kind of command: what
 * is sent before it has matched is lost. */
void arm_node_open(arm_node *node);
void arm_node_close(arm_node *node);
/** Repeats a command until the answer to it comes. */
void arm_assert_answered(const arm_node *node);
/** Every answer to a command of before has come, and is taken. Publishes other motions. */
void arm_settle(const arm_node *node);
/** A motion of the arm, another for each seed. */
arm_motion arm_motion_of(uint64_t seed);
/** Its answer by the library in this process. */
void arm_expect(tfa_workspace *workspace, const arm_motion *m, double qdd[JOINTS]);
/** Whether this is the answer to the motion. */
bool arm_is_answer(const trajectory_msgs_msg_dds__JointTrajectory_ *got, const arm_motion *m,
                   const double qdd[JOINTS]);
/** What the library answers of the motion for tool0 and link_4, and the torques that hold it. */
typedef struct arm_operational {
    double lambda_inv[12 * 12], jacobian[12 * JOINTS], bias[12], gravity[JOINTS];
} arm_operational;
void arm_expect_operational(tfa_workspace *workspace, const tfa_model *model, const arm_motion *m,
                            arm_operational *out);
/** The URDF of the arm, as it is bundled or with another mass, for free(); the model of a URDF. */
char *arm_urdf(bool heavy);
tfa_model *arm_model(const char *urdf);

/** The motion's state as a message with this stamp, and efforts by name. */
sensor_msgs_msg_dds__JointState_ arm_state(const arm_motion *m, int32_t sec);
sensor_msgs_msg_dds__JointState_ arm_efforts(char **name, const double *tau, uint32_t count,
                                             int32_t sec);
/** Publishes positions and velocities of all joints with this stamp. */
void arm_publish_state(const arm_node *node, const arm_motion *m, int32_t sec);
/** Publishes efforts in the order of the joints. */
void arm_publish_efforts(const arm_node *node, const double *tau, uint32_t count);
/** Publishes efforts by a trajectory of two points with this stamp, frame "plan". */
void arm_publish_trajectory(const arm_node *node, const double *tau, int32_t sec);
/** Publishes efforts by name with this stamp, frame "command". */
void arm_publish_named_efforts(const arm_node *node, char **name, const double *tau, uint32_t count,
                               int32_t sec);
/** A client of shared memory that asks all the while, in a thread of its own. */
typedef struct arm_witness {
    pthread_t thread;
    _Atomic bool stop;
    tfa_client *client;
    double right[JOINTS]; /* the answer at the start */
    bool exact;           /* every answer has the same bits */
    _Atomic uint32_t asked;
    uint32_t wrong;
} arm_witness;
void arm_witness_start(arm_witness *w, const harness *h, bool exact);
/** Waits until it has asked often; asserts that it was answered right. */
void arm_witness_stop(arm_witness *w);
/** The level of a status in the message whose name contains `what` and whose message or values
 * contain `text`; -1: there is none */
int arm_level_in(const diagnostic_msgs_msg_dds__DiagnosticArray_ *message, const char *what,
                 const char *text);
/** Waits for a diagnostic status whose name contains `what` and whose message or values contain
 * `text`. @return its level, -1: none came */
int arm_await_diagnostic(const arm_node *node, const char *what, const char *text);
/** The same for a while: where what causes it is published again. */
int arm_find_diagnostic(const arm_node *node, const char *what, const char *text);
/** What a daemon has counted of a robot's topics. */
tfa_ros2_statistics arm_statistics(const harness *h, const char *robot);
/** Messages that it has read from an input, "/arm/joint_states". */
uint64_t arm_received(const harness *h, const char *robot, const char *topic);

#endif
