/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every key of the configuration, once.
 */
#include "config_table.h"

#include "ipc/ring.h"

#include <totalforce/client.h>
#include <totalforce/model.h>

#define AT(type, member) .at = offsetof(type, member)
#define LIST_AT(type, member)                                                                      \
    .at = offsetof(type, member), .count_at = offsetof(type, member##_count)

#define WORD(value, word) word,
static const char *const base_words[] = {TFA_BASE_WORDS(WORD) NULL};
static const char *const scene_base_words[] = {TFA_BASE_WORDS(WORD) "same", NULL};
static const char *const inertia_words[] = {TFA_INERTIA_WORDS(WORD) NULL};
static const char *const mimic_words[] = {TFA_MIMIC_WORDS(WORD) NULL};
static const char *const estimate_words[] = {"default", "never", "sampled", "always", NULL};
static const char *const precision_words[] = {"f64", "f32", NULL};
static const char *const residual_words[] = {TFA_RESIDUAL_WORDS(WORD) NULL};
static const char *const hold_words[] = {TFA_CONSTRAINT_WORDS(WORD) NULL};
/* in the order of config_methods */
static const char *const methods_words[] = {"auto", "all", NULL};
/* in the order of config_specialise */
static const char *const specialise_words[] = {"off", "load", NULL};
static const char *const backend_words[] = {"shm", "memfd", NULL};
/* the index is tfa_wait; "default" is no value of the configuration */
static const char *const wait_words[] = {TFA_WAIT_WORDS(WORD) NULL};
static const char *const log_words[] = {"error", "warning", "info", "debug", NULL};

/* in the order of config_ros2_op, config_unitree_type, config_release and config_discovery */
static const char *const op_words[] = {"forward_dynamics", "constrained_dynamics", NULL};
static const char *const unitree_words[] = {"none", "go", "hg", NULL};
static const char *const release_words[] = {"environment", "humble",  "iron", "jazzy",
                                            "kilted",      "rolling", NULL};
static const char *const discovery_words[] = {"environment", "subnet",         "localhost",
                                              "off",         "system_default", NULL};

/* A reload may change it. */
#define RELOADABLE .reloadable = true

/* clang-format off */

static const config_row armature_rows[] = {
    {"joint", CONFIG_TEXT, AT(config_armature, joint), .required = true, RELOADABLE,
     .help = "Name of the joint"},
    {"value", CONFIG_NUMBER, AT(config_armature, value), .required = true, RELOADABLE, .low = 0,
     .high = 1e6, .unit = "kg m^2 (revolute) or kg (prismatic)",
     .help = "Reflected rotor inertia, kg m^2 (revolute) or kg (prismatic)"},
    {0}};
static const config_table armature_table = {armature_rows, sizeof(config_armature)};

static const config_row rotor_rows[] = {
    {"joint", CONFIG_TEXT, AT(config_armature, joint), .required = true, RELOADABLE,
     .help = "Name of the joint"},
    {"value", CONFIG_NUMBER, AT(config_armature, value), .required = true, RELOADABLE, .low = 0,
     .high = 1e6, .unit = "kg m^2", .help = "Inertia about the rotor's own axis, kg m^2"},
    {0}};
static const config_table rotor_table = {rotor_rows, sizeof(config_armature)};

static const config_row lock_rows[] = {
    {"joint", CONFIG_TEXT, AT(config_lock, joint), .required = true, RELOADABLE,
     .help = "Name of the joint"},
    {"q", CONFIG_NUMBER, AT(config_lock, q), RELOADABLE, .low = -1e6, .high = 1e6,
     .unit = "rad or m", .help = "Where it stands, rad or m"},
    {"pose", CONFIG_LIST, LIST_AT(config_lock, pose), RELOADABLE, .low = 3, .high = 7,
     .entry = CONFIG_NUMBER,
     .unit = "m, rad",
     .help = "In place of q: planar x y theta; floating x y z and quaternion x y z w"},
    {0}};
static const config_table lock_table = {lock_rows, sizeof(config_lock)};

static const config_row payload_rows[] = {
    {"link", CONFIG_TEXT, AT(config_payload, link), .required = true, RELOADABLE,
     .help = "Link that carries it, rigidly"},
    {"mass", CONFIG_NUMBER, AT(config_payload, mass), .required = true, RELOADABLE, .low = 0,
     .high = 1e9, .unit = "kg", .help = "kg"},
    {"com", CONFIG_LIST, LIST_AT(config_payload, com), RELOADABLE, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .unit = "m",
     .help = "Centre of mass, m, link frame; its origin when absent"},
    {"inertia", CONFIG_LIST, LIST_AT(config_payload, inertia), RELOADABLE, .low = 6, .high = 6,
     .entry = CONFIG_NUMBER,
     .unit = "kg m^2",
     .help = "ixx ixy ixz iyy iyz izz about the centre of mass, kg m^2; a point when absent"},
    {0}};
static const config_table payload_table = {payload_rows, sizeof(config_payload)};

static const config_row frame_rows[] = {
    {"link", CONFIG_TEXT, AT(config_frame, link), RELOADABLE,
     .help = "The link; the world when absent, or 'world'"},
    {"xyz", CONFIG_LIST, LIST_AT(config_frame, xyz), RELOADABLE, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .unit = "m", .help = "Origin in the link, m; its own when absent"},
    {"rpy", CONFIG_LIST, LIST_AT(config_frame, rpy), RELOADABLE, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .unit = "rad",
     .help = "Axes in the link, rad, as rpy of URDF; its own when absent"},
    {0}};
static const config_table frame_table = {frame_rows, sizeof(config_frame)};

static const config_row constraint_rows[] = {
    {"name", CONFIG_TEXT, AT(config_constraint, name), .required = true, RELOADABLE,
     .help = "Name, by which requests call it"},
    {"first", CONFIG_GROUP, AT(config_constraint, first), .table = &frame_table, RELOADABLE,
     .help = "Frame by whose axes it holds; the world when absent"},
    {"second", CONFIG_GROUP, AT(config_constraint, second), .table = &frame_table,
     .required = true, RELOADABLE, .help = "Frame that it holds"},
    {"hold", CONFIG_LIST, LIST_AT(config_constraint, hold), .required = true, RELOADABLE, .low = 1,
     .high = 6, .entry = CONFIG_WORD, .words = hold_words, .one = true,
     .help = "point, hinge (about z), weld, or a list of x, y, z, rx, ry, rz"},
    {"unilateral", CONFIG_BOOL, AT(config_constraint, unilateral), .default_value = false,
     RELOADABLE, .help = "Its force along z of the first frame can only push"},
    {0}};
static const config_table constraint_table = {constraint_rows, sizeof(config_constraint)};

static const config_row scene_rows[] = {
    {"name", CONFIG_TEXT, AT(config_scene, name), .required = true,
     .help = "Served as ROBOT.SCENE, with a socket of its own"},
    {"root", CONFIG_TEXT, AT(config_scene, root), RELOADABLE,
     .help = "Only the subtree of this link, which takes the root's place; all when absent"},
    {"tips", CONFIG_LIST, LIST_AT(config_scene, tips), RELOADABLE, .low = 0, .high = 1000,
     .entry = CONFIG_TEXT,
     .help = "Fixed base: only the trees that carry one of these links; all when absent"},
    {"locked", CONFIG_LIST, LIST_AT(config_scene, locked), RELOADABLE, .low = 0, .high = 100000,
     .table = &lock_table, .help = "Joints that do not move: absent from q, v, tau and qdd"},
    {"payload", CONFIG_LIST, LIST_AT(config_scene, payload), RELOADABLE, .low = 0, .high = 1000,
     .table = &payload_table, .help = "Loads on links"},
    {"modes", CONFIG_LIST, LIST_AT(config_scene, modes), RELOADABLE, .low = 0, .high = 1000,
     .entry = CONFIG_TEXT,
     .help = "Files of modes of flexible links, YAML; relative to this file"},
    {"constraints", CONFIG_LIST, LIST_AT(config_scene, constraints), RELOADABLE, .low = 0,
     .high = TFA_MAX_CONSTRAINTS, .table = &constraint_table,
     .help = "Closed loops and contacts, besides the loop joints of the file"},
    {"actuated", CONFIG_LIST, LIST_AT(config_scene, actuated), RELOADABLE, .low = 0,
     .high = 100000, .entry = CONFIG_TEXT,
     .help = "Joints with a motor, for constrained_inverse_dynamics; all when absent"},
    {"base", CONFIG_WORD, AT(config_scene, base), RELOADABLE, .default_value = CONFIG_BASE_SAME,
     .words = scene_base_words, .help = "fixed, floating, or same: as the robot"},
    {"gravity", CONFIG_LIST, LIST_AT(config_scene, gravity), RELOADABLE, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .unit = "m/s^2",
     .help = "m/s^2, world frame; the robot's when absent"},
    {0}};
static const config_table scene_table = {scene_rows, sizeof(config_scene)};

static const config_row ros2_wrench_rows[] = {
    {"topic", CONFIG_TEXT, AT(config_ros2_wrench, topic), .required = true,
     .help = "geometry_msgs/WrenchStamped: exerted on the link, in its frame"},
    {"link", CONFIG_TEXT, AT(config_ros2_wrench, link), .required = true,
     .help = "The link; frame_id of the messages is its name, or empty"},
    {0}};
static const config_table ros2_wrench_table = {ros2_wrench_rows, sizeof(config_ros2_wrench)};

static const config_row unitree_rows[] = {
    {"type", CONFIG_WORD, AT(config_unitree, type), .default_value = CONFIG_UNITREE_NONE,
     .words = unitree_words, .help = "none; go: quadrupeds; hg: humanoids"},
    {"topic", CONFIG_TEXT, AT(config_unitree, topic), .help = "/lowstate when absent"},
    {"motors", CONFIG_LIST, LIST_AT(config_unitree, motors), .low = 0, .high = 35,
     .entry = CONFIG_TEXT,
     .help = "Joint of each motor, in the order of motor_state; '-' for one that is not used"},
    {0}};
static const config_table unitree_table = {unitree_rows, sizeof(config_unitree)};

static const config_row observer_rows[] = {
    {"gain", CONFIG_NUMBER, AT(config_observer, gain), .required = true, .low = 1e-6, .high = 1e6,
     .unit = "1/s", .help = "1/s: the inverse of the time constant"},
    {"max_gap", CONFIG_NUMBER, AT(config_observer, max_gap), .low = 1e-6, .high = 1e6, .unit = "s",
     .help = "States further apart than this, s, restart it; 5 / gain when absent"},
    {"tip", CONFIG_TEXT, AT(config_observer, tip),
     .help = "Link at which ~/external_wrench explains the torques"},
    {0}};
static const config_table observer_table = {observer_rows, sizeof(config_observer)};

static const config_row robot_ros2_rows[] = {
    {"enabled", CONFIG_BOOL, AT(config_robot_ros2, enabled), .default_value = false,
     .help = "Serve this robot on topics of ROS 2, if ros2 is enabled"},
    {"domain", CONFIG_COUNT, AT(config_robot_ros2, domain), .default_value = CONFIG_ROS_DOMAIN_ID,
     .low = 0, .high = CONFIG_DOMAIN_MAX, .word = "environment",
     .help = "DDS domain id; environment: that of 'ros2'"},
    {"scene", CONFIG_TEXT, AT(config_robot_ros2, scene),
     .help = "Scene that these topics serve; the robot itself when absent"},
    {"namespace", CONFIG_TEXT, AT(config_robot_ros2, namespace),
     .help = "Where relative topics start; / when absent"},
    {"node", CONFIG_TEXT, AT(config_robot_ros2, node),
     .help = "Name of the node, below which the answers are; totalforce when absent"},
    {"joint_states", CONFIG_TEXT, AT(config_robot_ros2, joint_states),
     .help = "sensor_msgs/JointState: positions, velocities; joint_states when absent"},
    {"odometry", CONFIG_TEXT, AT(config_robot_ros2, odometry),
     .help = "nav_msgs/Odometry: pose and twist of a floating base"},
    {"effort_commands", CONFIG_TEXT, AT(config_robot_ros2, effort_commands),
     .help = "std_msgs/Float64MultiArray: efforts in the order of 'joints'"},
    {"joint_efforts", CONFIG_TEXT, AT(config_robot_ros2, joint_efforts),
     .help = "sensor_msgs/JointState: efforts by name, as commands"},
    {"trajectory", CONFIG_TEXT, AT(config_robot_ros2, trajectory),
     .help = "trajectory_msgs/JointTrajectory: efforts of its first point by name, as commands"},
    {"joints", CONFIG_LIST, LIST_AT(config_robot_ros2, joints), .low = 0, .high = 100000,
     .entry = CONFIG_TEXT, .help = "Joints of effort_commands; all, in the robot's order, if none"},
    {"robot_description", CONFIG_TEXT, AT(config_robot_ros2, robot_description),
     .help = "std_msgs/String: a URDF that takes the place of the robot's file"},
    {"wrenches", CONFIG_LIST, LIST_AT(config_robot_ros2, wrenches), .low = 0,
     .high = TFA_MAX_WRENCHES, .table = &ros2_wrench_table, .help = "External wrenches"},
    {"op", CONFIG_WORD, AT(config_robot_ros2, op), .default_value = CONFIG_ROS2_FORWARD_DYNAMICS,
     .words = op_words, .help = "Of ~/accelerations: forward_dynamics, constrained_dynamics"},
    {"active_constraints", CONFIG_TEXT, AT(config_robot_ros2, active_constraints),
     .help = "std_msgs/String: names of the active constraints of the scene, between blanks"},
    {"constraints", CONFIG_LIST, LIST_AT(config_robot_ros2, constraints), .low = 0,
     .high = TFA_MAX_CONSTRAINTS, .entry = CONFIG_TEXT,
     .help = "Active until the first message of active_constraints; all, if none"},
    {"tips", CONFIG_LIST, LIST_AT(config_robot_ros2, tips), .low = 0, .high = TFA_MAX_TIPS,
     .entry = CONFIG_TEXT,
     .help = "Links whose Lambda^-1, Jacobian and bias acceleration are published"},
    {"unitree", CONFIG_GROUP, AT(config_robot_ros2, unitree), .table = &unitree_table,
     .help = "State of a Unitree robot in place of joint_states"},
    {"observer", CONFIG_GROUP, AT(config_robot_ros2, observer), .table = &observer_table,
     .help = "Publish ~/external_torques: a generalised-momentum observer"},
    {"services", CONFIG_BOOL, AT(config_robot_ros2, services), .default_value = false,
     .help = "Answer calls of ~/forward_dynamics (clients of rmw_cyclonedds only)"},
    {"state_age_ms", CONFIG_COUNT, AT(config_robot_ros2, state_age_ms), .default_value = 100,
     .low = 1, .high = 3600000,
     .unit = "ms",
     .help = "Positions, velocities, wrenches and active constraints received earlier are refused"},
    {"command_age_ms", CONFIG_COUNT, AT(config_robot_ros2, command_age_ms), .default_value = 100,
     .low = 1, .high = 3600000, .unit = "ms",
     .help = "Efforts that were received earlier are refused"},
    {0}};
static const config_table robot_ros2_table = {robot_ros2_rows, sizeof(config_robot_ros2)};

static const config_row robot_rows[] = {
    {"name", CONFIG_TEXT, AT(config_robot, name), .required = true,
     .help = "Name for clients and of the socket: letters, digits, '-', '_', '.'"},
    {"urdf", CONFIG_TEXT, AT(config_robot, urdf), .required = true, RELOADABLE,
     .help = "The robot's file, relative to this one, ~/FILE, package://PACKAGE/FILE or "
             "$(find PACKAGE)/FILE"},
    {"base", CONFIG_WORD, AT(config_robot, base), RELOADABLE, .default_value = TFA_BASE_FIXED,
     .words = base_words, .help = "fixed or floating"},
    {"gravity", CONFIG_LIST, LIST_AT(config_robot, gravity), RELOADABLE, .low = 3, .high = 3,
     .entry = CONFIG_NUMBER, .unit = "m/s^2",
     .help = "m/s^2, world frame; 0 0 -9.80665 when absent"},
    {"armature", CONFIG_LIST, LIST_AT(config_robot, armature), RELOADABLE, .low = 0,
     .high = 100000, .table = &armature_table,
     .help = "Rotor inertias by joint; URDF cannot say them"},
    {"rotors", CONFIG_LIST, LIST_AT(config_robot, rotors), RELOADABLE, .low = 0, .high = 100000,
     .table = &rotor_table,
     .help = "Rotors by joint: times its reduction in the file squared they add to its armature"},
    {"rotor_inertia", CONFIG_BOOL, AT(config_robot, rotor_inertia), RELOADABLE,
     .default_value = false,
     .help = "Apply drake:rotor_inertia of the file"},
    {"inertia", CONFIG_WORD, AT(config_robot, inertia), RELOADABLE,
     .default_value = TFA_INERTIA_STRICT, .words = inertia_words,
     .help = "Inertias that no body can have: strict, warn, repair, strict-physical"},
    {"mimic", CONFIG_WORD, AT(config_robot, mimic), RELOADABLE, .default_value = TFA_MIMIC_FREE,
     .words = mimic_words,
     .help = "Joints that mimic others: free (ordinary joints), project (exact), lock"},
    {"damping", CONFIG_BOOL, AT(config_robot, damping), RELOADABLE, .default_value = false,
     .help = "Subtract the file's joint damping times velocity from tau"},
    {"friction", CONFIG_BOOL, AT(config_robot, friction), RELOADABLE, .default_value = false,
     .help = "Subtract the file's joint friction times a smooth sign of velocity from tau"},
    {"friction_velocity", CONFIG_NUMBER, AT(config_robot, friction_velocity), RELOADABLE,
     .low = 0, .high = 1e6, .unit = "rad/s or m/s",
     .help = "Joints slower than this (rad/s or m/s) have part of their friction; 0: 0.01"},
    {"lock_massless_leaves", CONFIG_BOOL, AT(config_robot, lock_massless_leaves), RELOADABLE,
     .default_value = false,
     .help = "Joints that move nothing with mass become fixed at 0; otherwise they are an error"},
    {"snap", CONFIG_NUMBER, AT(config_robot, snap), RELOADABLE, .default_value = 0, .low = 0,
     .high = TFA_SNAP_MAX,
     .unit = "rad",
     .help = "Rotations within this angle (rad) of right angles become exact; 0: as written"},
    {"scenes", CONFIG_LIST, LIST_AT(config_robot, scenes), .low = 0, .high = 1000,
     .table = &scene_table, .help = "Parts or loads of the robot, each served as ROBOT.SCENE"},
    {"estimate", CONFIG_WORD, AT(config_robot, estimate), RELOADABLE,
     .default_value = CONFIG_ESTIMATE_DEFAULT, .words = estimate_words,
     .help = "Estimates, unless a request says: default (sentinel), never, sampled, always"},
    {"estimate_every", CONFIG_COUNT, AT(config_robot, estimate_every), RELOADABLE,
     .default_value = 100, .low = 1, .high = 1e9, .help = "sampled: one request in so many"},
    {"precision", CONFIG_WORD, AT(config_robot, precision), RELOADABLE,
     .default_value = CONFIG_PRECISION_F64, .words = precision_words,
     .help = "Arithmetic of the factors: f64, f32 (docs/methods.md)"},
    {"residual", CONFIG_WORD, AT(config_robot, residual), RELOADABLE,
     .default_value = TFA_RESIDUAL_SAME, .words = residual_words,
     .help = "Arithmetic of residuals and of all other answers: same, f64, f128"},
    {"wait", CONFIG_WORD, AT(config_robot, wait), .default_value = TFA_WAIT_HYBRID,
     .words = wait_words, .low = TFA_WAIT_SPIN,
     .help = "For clients that leave it open: spin, hybrid, block"},
    {"slots", CONFIG_COUNT, AT(config_robot, slots), RELOADABLE, .default_value = 64, .low = 1,
     .high = TFA_RING_SLOTS_MAX, .help = "Most requests a client may have outstanding"},
    {"max_batch", CONFIG_COUNT, AT(config_robot, max_batch), .default_value = 64, .low = 1,
     .high = 65536, .help = "Most states of one request"},
    {"max_tips", CONFIG_COUNT, AT(config_robot, max_tips), .default_value = TFA_DEFAULT_TIPS,
     .low = 1, .high = TFA_MAX_TIPS, .help = "Most tips of one request"},
    {"methods", CONFIG_WORD, AT(config_robot, methods), RELOADABLE,
     .default_value = CONFIG_METHODS_AUTO, .words = methods_words,
     .help = "Memory for all methods, or, beyond 256 bodies, for those of auto only: auto, all"},
    {"refuse", CONFIG_LIST, LIST_AT(config_robot, refuse), RELOADABLE, .low = 0, .high = 16,
     .entry = CONFIG_TEXT,
     .help = "Refused: several-tips, spectrum, lambda, mass-matrix, derivatives, methods, "
             "estimates, batches"},
    {"dds", CONFIG_BOOL, AT(config_robot, dds), .default_value = true,
     .help = "Answer for this robot over DDS, if dds is enabled"},
    {"ros2", CONFIG_GROUP, AT(config_robot, ros2), .table = &robot_ros2_table,
     .help = "Topics of ROS 2 (docs/ros2.md)"},
    {0}};
static const config_table robot_table = {robot_rows, sizeof(config_robot)};

static const config_row limit_rows[] = {
    {"clients", CONFIG_COUNT, AT(config_limits, clients), RELOADABLE, .default_value = 64, .low = 1,
     .high = TFA_WORKER_CLIENTS_MAX - 32, .help = "Most clients at once"},
    {"clients_per_user", CONFIG_COUNT, AT(config_limits, clients_per_user), RELOADABLE,
     .default_value = 32, .low = 1, .high = TFA_WORKER_CLIENTS_MAX - 32,
     .help = "Most clients of one user at once"},
    {"memory_mib", CONFIG_COUNT, AT(config_limits, memory_mib), RELOADABLE, .default_value = 512,
     .low = 1,
     .high = 1048576, .unit = "MiB", .help = "Most shared memory for all clients together, MiB"},
    {"memory_mib_per_user", CONFIG_COUNT, AT(config_limits, memory_mib_per_user), RELOADABLE,
     .default_value = 256, .low = 1, .high = 1048576,
     .unit = "MiB", .help = "Most shared memory for all clients of one user, MiB"},
    {"connects_per_second", CONFIG_COUNT, AT(config_limits, connects_per_second), RELOADABLE,
     .default_value = 100, .low = 1, .high = 100000,
     .unit = "1/s", .help = "Connections of one user a second, after twice as many at once"},
    {0}};
static const config_table limit_table = {limit_rows, sizeof(config_limits)};

static const config_row realtime_rows[] = {
    {"priority", CONFIG_COUNT, AT(config_realtime, priority), .default_value = 0, .low = 0,
     .high = 99,
     .help = "SCHED_FIFO priority of the workers; 0: the ordinary scheduler"},
    {"affinity", CONFIG_LIST, LIST_AT(config_realtime, affinity), .low = 0, .high = 1024,
     .entry = CONFIG_COUNT, .help = "Processor of each worker, in order; none: any"},
    {"mlock", CONFIG_BOOL, AT(config_realtime, mlock), .default_value = false,
     .help = "Lock all memory of the daemon"},
    {"cpu_dma_latency", CONFIG_COUNT, AT(config_realtime, cpu_dma_latency),
     .default_value = CONFIG_ANY_LATENCY, .low = 0, .high = 2e9, .word = "any", .unit = "us",
     .help = "Idle states that take longer to leave, us, are not entered while the daemon runs "
             "(/dev/cpu_dma_latency)"},
    {0}};
static const config_table realtime_table = {realtime_rows, sizeof(config_realtime)};

static const config_row pool_rows[] = {
    {"threads", CONFIG_COUNT, AT(config_pool, threads), .default_value = 0, .low = 0, .high = 256,
     .help = "Threads that work on one large request, the worker's own included; 0: no pool"},
    {"from", CONFIG_COUNT, AT(config_pool, from), .default_value = 1000, .low = 1, .high = 1e9,
     .help = "Large: so many bodies times states"},
    {"spin_ns", CONFIG_COUNT, AT(config_pool, spin_ns), .default_value = 50000, .low = 1,
     .high = 4e9,
     .unit = "ns",
     .help = "An idle thread spins so long before it sleeps; waking it is a system call"},
    {"priority", CONFIG_COUNT, AT(config_pool, priority), .default_value = 0, .low = 0, .high = 99,
     .help = "SCHED_FIFO priority of its threads; 0: the ordinary scheduler"},
    {"affinity", CONFIG_LIST, LIST_AT(config_pool, affinity), .low = 0, .high = 256,
     .entry = CONFIG_COUNT,
     .help = "Processor of each thread besides the workers, in order; none: any"},
    {0}};
static const config_table pool_table = {pool_rows, sizeof(config_pool)};

static const config_row dds_rows[] = {
    {"enabled", CONFIG_BOOL, AT(config_dds, enabled), .default_value = false,
     .help = "Join a DDS domain and answer there, too"},
    {"domain", CONFIG_COUNT, AT(config_dds, domain), .default_value = 0, .low = 0,
     .high = CONFIG_DOMAIN_MAX, .help = "DDS domain id"},
    {"max_age_ms", CONFIG_COUNT, AT(config_dds, max_age_ms), .default_value = 0, .low = 0,
     .high = 3600000,
     .unit = "ms",
     .help = "Streamed torques with an older stamp are refused; 0: none. Clocks must agree"},
    {"priority", CONFIG_COUNT, AT(config_dds, priority), .default_value = 0, .low = 0,
     .high = 1000000,
     .help = "Hot standby: of several daemons for one robot the highest leads, if none does yet"},
    {"lease_ms", CONFIG_COUNT, AT(config_dds, lease_ms), .default_value = 200, .low = 10,
     .high = 60000,
     .unit = "ms",
     .help = "Hot standby: a standby replaces this daemon when it is silent for so long"},
    {0}};
static const config_table dds_table = {dds_rows, sizeof(config_dds)};

static const config_row ros2_rows[] = {
    {"enabled", CONFIG_BOOL, AT(config_ros2, enabled), .default_value = false,
     .help = "Read and write topics of ROS 2 for the robots that have it"},
    {"domain", CONFIG_COUNT, AT(config_ros2, domain), .default_value = CONFIG_ROS_DOMAIN_ID,
     .low = 0, .high = CONFIG_DOMAIN_MAX, .word = "environment",
     .help = "DDS domain id; environment: ROS_DOMAIN_ID, else 0"},
    {"release", CONFIG_WORD, AT(config_ros2, release),
     .default_value = CONFIG_RELEASE_ENVIRONMENT, .words = release_words,
     .help = "Of the nodes: environment (ROS_DISTRO, else one after humble), humble, iron, jazzy, "
             "kilted, rolling"},
    {"discovery_range", CONFIG_WORD, AT(config_ros2, discovery),
     .default_value = CONFIG_DISCOVERY_ENVIRONMENT, .words = discovery_words,
     .help = "environment (ROS_AUTOMATIC_DISCOVERY_RANGE, else subnet), subnet, localhost, off, "
             "system_default"},
    {"static_peers", CONFIG_LIST, LIST_AT(config_ros2, peers), .low = 0, .high = 100,
     .entry = CONFIG_TEXT, .help = "Hosts that are asked, too; none: ROS_STATIC_PEERS"},
    {0}};
static const config_table ros2_table = {ros2_rows, sizeof(config_ros2)};

static const config_row top_rows[] = {
    {"runtime_dir", CONFIG_TEXT, AT(config, runtime_dir),
     .help = "Sockets and lock; $TOTALFORCE_RUNTIME_DIR, else /run/totalforce ($XDG_RUNTIME_DIR/"
             "totalforce if not root)"},
    {"group", CONFIG_TEXT, AT(config, group),
     .help = "Group that may connect (sockets are 0660); that of the daemon's user when absent"},
    {"allow_users", CONFIG_LIST, LIST_AT(config, allow_users), .low = 0, .high = 1000,
     .entry = CONFIG_TEXT, RELOADABLE,
     .help = "Users of that group that may connect, besides root and the daemon's own; all when "
             "both are absent"},
    {"allow_groups", CONFIG_LIST, LIST_AT(config, allow_groups), .low = 0, .high = 1000,
     .entry = CONFIG_TEXT, RELOADABLE,
     .help = "Groups whose members, if they are of that group, too, may connect"},
    {"user", CONFIG_TEXT, AT(config, user),
     .help = "Started by root: becomes this user when priorities and locks are held"},
    {"log", CONFIG_WORD, AT(config, log_level), .default_value = 2, .words = log_words,
     .help = "error, warning, info, debug"},
    {"workers", CONFIG_COUNT, AT(config, workers), .default_value = 1, .low = 1, .high = 64,
     .help = "Threads that answer; a client belongs to one"},
    {"spin_ns", CONFIG_COUNT, AT(config, spin_ns), .default_value = 50000, .low = 0, .high = 1e9,
     .unit = "ns",
     .help = "hybrid: spins so long before it sleeps; longer than the worst computation"},
    {"turn_us", CONFIG_COUNT, AT(config, turn_us), .default_value = TFA_WORKER_TURN_US, .low = 1,
     .high = 100000,
     .unit = "us",
     .help = "A client waits so long for others at most; longer requests are answered in parts"},
    {"max_state_us", CONFIG_COUNT, AT(config, max_state_us), RELOADABLE, .default_value = 500,
     .low = 0, .high = CONFIG_STATE_US_MOST,
     .unit = "us",
     .help = "Requests whose states take longer are refused: none is interrupted; 0: any time"},
    {"warm_us", CONFIG_COUNT, AT(config, warm_us), .default_value = TFA_WORKER_WARM_US, .low = 0,
     .high = 100000,
     .unit = "us",
     .help = "A worker that spins solves the last request again so often, to stay fast; 0: off"},
    {"allow_spin", CONFIG_BOOL, AT(config, allow_spin), .default_value = true,
     .help = "Clients may ask for spin, which takes the worker's core while they are connected"},
    {"backend", CONFIG_WORD, AT(config, backend), .default_value = CONFIG_BACKEND_SHM,
     .words = backend_words, .help = "Memory shared with clients: shm or memfd"},
    {"specialise", CONFIG_WORD, AT(config, specialise), .default_value = CONFIG_SPECIALISE_OFF,
     .words = specialise_words, RELOADABLE,
     .help = "Specialised kernels of totalforce specialise: off, load"},
    {"specialise_directory", CONFIG_TEXT, AT(config, specialise_directory), RELOADABLE,
     .help = "Where they are; only root and the daemon's user may write there and above"},
    {"limits", CONFIG_GROUP, AT(config, limits), .table = &limit_table,
     .help = "Limits of clients"},
    {"realtime", CONFIG_GROUP, AT(config, realtime), .table = &realtime_table,
     .help = "Each needs a permission; settings that fail are reported"},
    {"pool", CONFIG_GROUP, AT(config, pool), .table = &pool_table,
     .help = "Several cores for large requests; whichever worker has one may use it"},
    {"dds", CONFIG_GROUP, AT(config, dds), .table = &dds_table, .help = "The DDS gateway"},
    {"ros2", CONFIG_GROUP, AT(config, ros2), .table = &ros2_table,
     .help = "Topics of ROS 2 (docs/ros2.md)"},
    {"robots", CONFIG_LIST, LIST_AT(config, robots), .required = true, .low = 1, .high = 1000,
     .table = &robot_table, .help = "The robots that are served"},
    {0}};
const config_table config_top = {top_rows, sizeof(config)};

/* clang-format on */

_Static_assert(sizeof top_rows / sizeof *top_rows <= CONFIG_ROWS_MAX, "more keys: raise the limit");
_Static_assert(sizeof robot_rows / sizeof *robot_rows <= CONFIG_ROWS_MAX, "as above");

size_t config_entry_size(const config_row *row)
{
    if (row->table)
        return row->table->size;
    switch (row->entry) {
    case CONFIG_COUNT:
    case CONFIG_WORD:
        return sizeof(uint32_t);
    case CONFIG_TEXT:
        return sizeof(const char *);
    default:
        return sizeof(double);
    }
}
