/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names of ROS 2, its environment as settings of Cyclone, and errors of the configuration where
 * they stand in the file.
 */
#include "dds/common/ros_domain.h"
#include "dds/ros2/ros2_names.h"

#include "dds/dds_test.h"
#include "harness.h"

#include <dds/dds.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

/* ---- names: design.ros2.org, topic and service names ---- */

TEST(names_become_full_names)
{
    static const struct {
        const char *space, *node, *name, *full; /* NULL: no name */
    } rows[] = {
        {"/", "totalforce", "joint_states", "/joint_states"},
        {"/arm", "totalforce", "joint_states", "/arm/joint_states"},
        {"/a/b", "n", "x/y", "/a/b/x/y"},
        {"/arm", "totalforce", "/joint_states", "/joint_states"},
        {"/arm", "totalforce", "~/x", "/arm/totalforce/x"},
        {"/", "n", "~/x", "/n/x"},
        {"/", "n", "~", "/n"},
        {"/", "n", "_x1", "/_x1"},
        {"/arm", "n", "~", "/arm/n"},
        {"/a", "n", "x/y_z/_", "/a/x/y_z/_"},
        {"/", "n", "/a/b", "/a/b"},
        {"/", "n", "~x", NULL},
        {"/", "n", "~/", NULL},
        {"/", "n", "~~", NULL},
        {"/", "n", "~//x", NULL},
        {"/", "n", "x/~", NULL},
        {"/", "n", "/~/x", NULL},
        {"/", "n", "//x", NULL},
        {"/", "n", "__x", NULL},
        {"/", "n", "x_/_y", "/x_/_y"},
        {"/", "n", "x\n", NULL},
        {"/", "n", ".x", NULL},
        {"/", "n", "", NULL},
        {"/", "n", "/", NULL},
        {"/", "n", "x/", NULL},
        {"/", "n", "x//y", NULL},
        {"/", "n", "1x", NULL},
        {"/", "n", "x/1y", NULL},
        {"/", "n", "x__y", NULL},
        {"/", "n", "x y", NULL},
        {"/", "n", "x-y", NULL},
        {"/", "n", "\xc3\xa4", NULL},
        {"/", "n", "{x}", NULL},
    };
    char full[TFA_ROS2_NAME_MAX + 1];
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const bool good = tfa_ros2_full_name(rows[i].space, rows[i].node, rows[i].name, full);
        if (rows[i].full ? !good || strcmp(full, rows[i].full) != 0 : good || full[0] != 0)
            fail_msg("'%s' in '%s': '%s'", rows[i].name, rows[i].space, full);
    }
}

TEST(names_are_as_long_as_a_topic_of_dds)
{
    char name[TFA_ROS2_NAME_MAX + 2] = "/", full[TFA_ROS2_NAME_MAX + 1];
    memset(name + 1, 'x', TFA_ROS2_NAME_MAX - 1);
    assert_true(tfa_ros2_full_name("/", "n", name, full));
    assert_string_equal(name, full);
    name[TFA_ROS2_NAME_MAX] = 'x';
    assert_false(tfa_ros2_full_name("/", "n", name, full));
    assert_false(tfa_ros2_is_namespace(name));
    name[TFA_ROS2_NAME_MAX] = 0;
    assert_true(tfa_ros2_is_namespace(name));
    /* relative, below "/arm/"; private, below "/arm/n/" */
    assert_false(tfa_ros2_full_name("/arm", "n", name + 4, full));
    assert_true(tfa_ros2_full_name("/arm", "n", name + 5, full));
    assert_int_equal(strlen(full), TFA_ROS2_NAME_MAX);
    memcpy(name + 4, "~/", 2);
    assert_false(tfa_ros2_full_name("/arm", "n", name + 4, full));
    memcpy(name + 5, "~/", 2);
    assert_true(tfa_ros2_full_name("/arm", "n", name + 5, full));
    assert_int_equal(strlen(full), TFA_ROS2_NAME_MAX);
}

TEST(nodes_and_namespaces)
{
    assert_true(tfa_ros2_is_node_name("totalforce") && tfa_ros2_is_node_name("_a1"));
    assert_false(tfa_ros2_is_node_name("") || tfa_ros2_is_node_name("a/b") ||
                 tfa_ros2_is_node_name("1a") || tfa_ros2_is_node_name("a__b"));
    assert_true(tfa_ros2_is_namespace("/") && tfa_ros2_is_namespace("/a/b_c"));
    assert_false(tfa_ros2_is_namespace("") || tfa_ros2_is_namespace("a") ||
                 tfa_ros2_is_namespace("/a/") || tfa_ros2_is_namespace("//a") ||
                 tfa_ros2_is_namespace("/a//b") || tfa_ros2_is_namespace("/1") ||
                 tfa_ros2_is_namespace("/~") || tfa_ros2_is_namespace("//"));
}

/* ---- the environment ---- */

static void set_variable(const char *name, const char *value)
{
    if (value != NULL)
        setenv(name, value, 1);
    else
        unsetenv(name);
}

static int find_domain(const config_ros2 *c, uint32_t *id, char **settings, char *error,
                       size_t size)
{
    const int status = tfa_ros2_domain(c, id, settings, error, size);
    assert_true((status == TFA_OK) == (*settings != NULL));
    return status;
}

/* Cyclone takes the settings as they are. */
static void assert_taken_by_cyclone(const char *settings)
{
    const dds_entity_t domain = dds_create_domain(test_domain(), settings);
    assert_true(domain > 0);
    assert_int_equal(dds_delete(domain), DDS_RETCODE_OK);
}

TEST(the_environment_becomes_settings)
{
    static const struct {
        const char *id, *range, *peers;
        uint32_t domain;
        const char *has, *lacks; /* in the settings */
    } rows[] = {
        {NULL, NULL, NULL, 0, "<MaxAutoParticipantIndex>32<", "AllowMulticast"},
        {"", "", "", 0, "<ParticipantIndex>auto<", "<Peer "},
        {"42", "SUBNET", "10.0.0.1;host-2.local", 42, "<Peer address=\"host-2.local\"/>", "Tag"},
        {"230", "LOCALHOST", NULL, 230, "<AllowMulticast>false<", "Tag"},
        {"7", "LOCALHOST", "fe80::1%eth0", 7, "<Peer address=\"fe80::1%eth0\"/>", "Tag"},
        {"0", "OFF", "10.0.0.1", 0, "<Tag>ros_discovery_off_", "Peer"},
        {"1", "SYSTEM_DEFAULT", "10.0.0.1", 1, "", "Discovery"},
        {NULL, NULL, ";;a;", 0, "<Peer address=\"a\"/>", "address=\"\""},
    };
    const config_ros2 c = {.enabled = true, .domain = CONFIG_ROS_DOMAIN_ID};
    char *settings, error[200];
    uint32_t id;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        set_variable("ROS_DOMAIN_ID", rows[i].id);
        set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", rows[i].range);
        set_variable("ROS_STATIC_PEERS", rows[i].peers);
        assert_int_equal(find_domain(&c, &id, &settings, error, sizeof error), TFA_OK);
        assert_int_equal(id, rows[i].domain);
        if (!strstr(settings, rows[i].has) || strstr(settings, rows[i].lacks))
            fail_msg("row %zu: %s", i, settings);
        if (*settings && !rows[i].peers) /* names of hosts are looked up */
            assert_taken_by_cyclone(settings);
        free(settings);
    }
}

TEST(the_release_is_that_of_the_environment)
{
    static const struct {
        const char *distro;
        config_release release;
        bool humble;
    } rows[] = {
        {NULL, CONFIG_RELEASE_ENVIRONMENT, false},    {"", CONFIG_RELEASE_ENVIRONMENT, false},
        {"jazzy", CONFIG_RELEASE_ENVIRONMENT, false}, {"humble", CONFIG_RELEASE_ENVIRONMENT, true},
        {"humble", CONFIG_RELEASE_IRON, false},       {NULL, CONFIG_RELEASE_HUMBLE, true}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const config_ros2 c = {.enabled = true, .release = rows[i].release};
        set_variable("ROS_DISTRO", rows[i].distro);
        assert_int_equal(tfa_ros2_is_humble(&c), rows[i].humble);
    }
    set_variable("ROS_DISTRO", NULL);
}

/* Jazzy still honours it, before the newer variable. */
TEST(localhost_only_comes_first)
{
    static const struct {
        const char *only, *range;
        bool local;
    } rows[] = {{"1", NULL, true},      {"1", "SUBNET", true}, {"0", "SUBNET", false},
                {"", "SUBNET", false},  {"0", NULL, false},    {"0", "LOCALHOST", true},
                {"1", "nonsense", true}};
    const config_ros2 c = {.enabled = true, .domain = CONFIG_ROS_DOMAIN_ID};
    config_ros2 subnet = c;
    char *settings, error[200];
    uint32_t id;
    subnet.discovery = CONFIG_DISCOVERY_SUBNET;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        set_variable("ROS_LOCALHOST_ONLY", rows[i].only);
        set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", rows[i].range);
        assert_int_equal(find_domain(&c, &id, &settings, error, sizeof error), TFA_OK);
        assert_int_equal(strstr(settings, "<Peer address=\"localhost\"/>") != NULL, rows[i].local);
        free(settings);
        assert_int_equal(find_domain(&subnet, &id, &settings, error, sizeof error), TFA_OK);
        assert_null(strstr(settings, "localhost"));
        free(settings);
    }
    set_variable("ROS_LOCALHOST_ONLY", NULL);
    set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", NULL);
}

TEST(a_bad_environment_is_named)
{
    static const struct {
        const char *variable, *value, *says;
    } rows[] = {
        {"ROS_DOMAIN_ID", "x", "ROS_DOMAIN_ID: 'x' is not a whole number from 0 to 230"},
        {"ROS_DOMAIN_ID", "231", "'231'"},
        {"ROS_DOMAIN_ID", "-1", "'-1'"},
        {"ROS_DOMAIN_ID", "1 ", "'1 '"},
        {"ROS_DOMAIN_ID", "18446744073709551616", "whole number"},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost", "'localhost' is not SUBNET, LOCALHOST"},
        {"ROS_DOMAIN_ID", "0x10", "'0x10'"},
        {"ROS_DOMAIN_ID", "+1", "'+1'"},
        {"ROS_DOMAIN_ID", " 1", "' 1'"},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNETS", "'SUBNETS' is not SUBNET, LOCALHOST"},
        {"ROS_STATIC_PEERS", "a;b\"/><x", "ROS_STATIC_PEERS: 'b\"/><x' is not a host"},
        {"ROS_STATIC_PEERS", "a b", "ROS_STATIC_PEERS: 'a b' is not a host"},
        {"ROS_STATIC_PEERS", "&amp;", "'&amp'"},
        {"ROS_STATIC_PEERS", "${HOME}", "'${HOME}'"},
        {"ROS_STATIC_PEERS", "\xc3\xa4", "is not a host"},
    };
    const config_ros2 c = {.enabled = true, .domain = CONFIG_ROS_DOMAIN_ID};
    char *settings, error[200];
    uint32_t id;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        set_variable("ROS_DOMAIN_ID", NULL);
        set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", NULL);
        set_variable("ROS_STATIC_PEERS", NULL);
        set_variable(rows[i].variable, rows[i].value);
        assert_int_equal(find_domain(&c, &id, &settings, error, sizeof error), TFA_E_ARGUMENT);
        if (!strstr(error, rows[i].says))
            fail_msg("row %zu: %s", i, error);
        set_variable(rows[i].variable, NULL);
    }
}

TEST(keys_come_before_the_environment)
{
    const char *peers[] = {"10.0.0.9"};
    const config_ros2 c = {.enabled = true,
                           .domain = 12,
                           .discovery = CONFIG_DISCOVERY_LOCALHOST,
                           .peers = peers,
                           .peers_count = 1};
    char *settings, error[200];
    uint32_t id;
    set_variable("ROS_DOMAIN_ID", "nonsense");
    set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", "nonsense");
    set_variable("ROS_STATIC_PEERS", "<nonsense>");
    assert_int_equal(find_domain(&c, &id, &settings, error, sizeof error), TFA_OK);
    assert_int_equal(id, 12);
    assert_non_null(strstr(settings, "<AllowMulticast>false<"));
    assert_non_null(strstr(settings, "10.0.0.9"));
    free(settings);
    set_variable("ROS_DOMAIN_ID", NULL);
    set_variable("ROS_AUTOMATIC_DISCOVERY_RANGE", NULL);
    set_variable("ROS_STATIC_PEERS", NULL);
}

TEST(a_bad_host_of_the_configuration_is_named)
{
    const char *peers[] = {"10.0.0.9", "a\"/><Tag>x</Tag><Peer address=\"b"};
    const config_ros2 c = {.enabled = true,
                           .domain = 12,
                           .discovery = CONFIG_DISCOVERY_SUBNET,
                           .peers = peers,
                           .peers_count = 2};
    char *settings, error[200];
    uint32_t id;
    assert_int_equal(find_domain(&c, &id, &settings, error, sizeof error), TFA_E_ARGUMENT);
    assert_non_null(
        strstr(error, "ros2.static_peers: 'a\"/><Tag>x</Tag><Peer address=\"b' is not"));
}

/* ---- the file ---- */

#define LONG_48 "n23456789_n23456789_n23456789_n23456789_n2345678"
#define LONG LONG_48 LONG_48 LONG_48 LONG_48 LONG_48

#define ROS2 ARM "    ros2:\n      enabled: yes\n"

#define HELD                                                                                       \
    ARM "    scenes:\n      - name: held\n        constraints:\n"                                  \
        "          - {name: tip, second: {link: tool0}, hold: point}\n"                            \
        "          - {name: at tip, second: {link: tool0}, hold: weld}\n"                          \
        "    ros2:\n      enabled: yes\n      scene: held\n      op: constrained_dynamics\n"

/* Check and start both end with 2 and say so; ":1:2: ..." is in the configuration's file.
 * @param more  other keys of section ros2 */
static void assert_refused(const char *robots, const char *more, const char *says)
{
    char section[128], expected[512];
    snprintf(section, sizeof section, "ros2: {enabled: yes%s}\n", more);
    SCOPED_HARNESS h = harness_make(robots, section);
    snprintf(expected, sizeof expected, "%s%s", says[0] == ':' ? h.config : "", says);
    harness_assert_mistake(&h, expected);
}

TEST(errors_stand_where_the_key_is)
{
    static const struct {
        const char *robots, *says;
    } rows[] = {
        {ROS2 "      namespace: arm\n",
         ":8:18: robots[0].ros2.namespace: 'arm' is no namespace of ROS; write it like /arm"},
        {ROS2 "      node: a/b\n", ":8:13: robots[0].ros2.node: 'a/b' is no name of a node"},
        {ROS2 "      joint_states: x y\n", ":8:21: robots[0].ros2.joint_states: 'x y'"},
        {ROS2 "      tips: [tool1]\n",
         ":8:14: robots[0].ros2.tips[0]: the robot has no link 'tool1'; nearest: 'tool0'"},
        {ROS2 "      joints: [joint_1, joint_12]\n",
         ":8:25: robots[0].ros2.joints[1]: the robot has no joint 'joint_12'; nearest: 'joint_1'"},
        {ROS2 "      joints: [joint_1, joint_2, joint_1]\n",
         ":8:34: robots[0].ros2.joints[2]: 'joint_1' is there twice, first as number 0"},
        {ROS2 "      wrenches: [{topic: ft, link: hand}]\n",
         ":8:36: robots[0].ros2.wrenches[0].link: the robot has no link 'hand'"},
        {ROS2 "      wrenches: [{topic: 'f t', link: tool0}]\n",
         ":8:26: robots[0].ros2.wrenches[0].topic: 'f t'"},
        {ROS2 "      scene: hold\n    scenes: [{name: held}]\n",
         ":8:14: robots[0].ros2.scene: the robot has no scene 'hold'; nearest: 'held'"},
        {ROS2 "      scene: held\n", ":8:14: robots[0].ros2.scene: the robot has no scene 'held'; "
                                     "nearest: none"},
        {ROS2 "      op: constrained_dynamics\n", ":8:11: robots[0].ros2.op: the robot has no "
                                                  "constraints; give them to a scene of the robot "
                                                  "and name it by ros2.scene"},
        {ROS2 "      op: constrained_dynamics\n      scene: held\n    scenes: [{name: held}]\n",
         ":8:11: robots[0].ros2.op: the scene has no constraints"},
        {ROS2 "      active_constraints: contacts\n",
         ":8:27: robots[0].ros2.active_constraints: forward_dynamics has no constraints; write op: "
         "constrained_dynamics"},
        {ROS2 "      constraints: [tip]\n", ":8:20: robots[0].ros2.constraints: forward_dynamics"},
        {HELD "      constraints: [tip, top]\n",
         "robots[0].ros2.constraints[1]: the robot has no constraint 'top'; nearest: 'tip'"},
        {HELD "      active_constraints: a b\n", "robots[0].ros2.active_constraints: 'a b'"},
        {HELD "      active_constraints: contacts\n",
         "robots[0].ros2.active_constraints: constraint 'at tip' has a blank in its name"},
        {ROS2 "      unitree: {type: go}\n",
         "robots[0].ros2.unitree.motors: the joint of each motor is needed"},
        {ROS2 "      unitree:\n        type: go\n        motors: [-, -, -, -, -, -, -, -, -, -, "
              "-, -, -, -, -, -, -, -, -, -, -]\n",
         ":10:17: robots[0].ros2.unitree.motors: 21 motors; a LowState of this type has 20"},
        {ROS2 "      joint_states: x\n      unitree: {type: go, motors: [joint_1]}\n",
         ":8:21: robots[0].ros2.joint_states: the state comes from unitree.topic"},
        {ROS2 "      unitree: {type: hg, motors: [joint_9]}\n",
         "robots[0].ros2.unitree.motors[0]: the robot has no joint 'joint_9'"},
        {ARM "    base: floating\n    ros2: {enabled: yes}\n",
         "robots[0].ros2.odometry: a robot with a floating base needs its pose and twist"},
        {ROS2 "      odometry: o\n      unitree: {type: go, motors: [joint_1]}\n",
         ":8:17: robots[0].ros2.odometry: the base's orientation comes from unitree.topic"},
        {ROS2 "      unitree:\n        motors: [joint_1, '-', joint_2]\n        type: hg\n",
         ":9:17: robots[0].ros2.unitree.motors: joint 'joint_3' has no motor"},
        {ROS2 "      unitree: {type: hg, motors: [joint_1, '-', '-', joint_1]}\n",
         "robots[0].ros2.unitree.motors[3]: 'joint_1' is there twice, first as number 0"},
        {ROS2 "      observer: {tip: tool0}\n",
         ":8:17: robots[0].ros2.observer: the key 'gain' is missing: 1/s: the inverse"},
        {ROS2 "      observer: {}\n", ":8:17: robots[0].ros2.observer: the key 'gain' is missing"},
        {ROS2 "      observer: {gain: 0}\n", ":8:24: robots[0].ros2.observer.gain: '0' is not a "
                                             "number from 1e-06 to 1000000"},
        {ROS2 "      observer: {gain: -20}\n", ":8:24: robots[0].ros2.observer.gain: '-20' is not"},
        {ROS2 "      observer: {gain: 20 Hz}\n", ":8:24: robots[0].ros2.observer.gain: '20 Hz' is "
                                                 "not a number from 1e-06 to 1000000; write "
                                                 "20"},
        {ROS2 "      observer: {gain: 20, max_gap: 0}\n",
         ":8:37: robots[0].ros2.observer.max_gap: '0' is not a number from 1e-06 to 1000000"},
        {ROS2 "      observer: {gain: 20, max_gap: 100 ms}\n", "; write 0.1"},
        {ROS2 "      observer: {gain: 20, max_gap: ~}\n", "; write it like 2.5 or -1e-3"},
        {ROS2 "      observer: {gain: 20, tip: tool1}\n",
         ":8:33: robots[0].ros2.observer.tip: the robot has no link 'tool1'; nearest: 'tool0'"},
        {ROS2 "      observer: {gain: 20, tip: tool0}\n    refuse: [lambda]\n",
         ":8:33: robots[0].ros2.observer.tip: its wrench takes lambda, which the robot's key "
         "'refuse' refuses; leave out one of them"},
        {ARM "    base: floating\n    ros2:\n      enabled: yes\n      observer: {gain: 20}\n"
             "      unitree: {type: hg, motors: [joint_1]}\n",
         "robots[0].ros2.observer: it needs the linear velocity of the base, which a LowState does "
         "not have; use joint_states and odometry"},
        {"  - name: arm\n    urdf: @/config/robots/flexible_arm.urdf\n"
         "    scenes: [{name: bent, modes: [@/config/robots/flexible_arm.yaml]}]\n"
         "    ros2: {enabled: yes, scene: bent, observer: {gain: 20}}\n",
         "robots[0].ros2.observer: a robot with flexible links has none; leave out its modes"},
        {ROS2 "      namespace: /" LONG "\n", ":8:18: robots[0].ros2.namespace: too long: "},
        {ROS2 "      node: " LONG "\n", ":8:13: robots[0].ros2.node: too long: "},
        {"  - name: cart\n    urdf: @/tests/tools/data/cart.urdf\n    ros2:\n      enabled: yes\n",
         ":7:16: robots[0].ros2.enabled: joint 'wheels' has 3 coordinates, a JointState has one "
         "for "
         "each joint; lock it in a scene or use the totalforce topics"},
        {ROS2 "      state_age_ms: 0\n", ":8:21: robots[0].ros2.state_age_ms: '0'"},
        {ROS2 "      domain: 231\n",
         ":8:15: robots[0].ros2.domain: '231' is not a whole number from 0 to 230, or environment"},
        {ROS2 "      tipps: [tool0]\n", ":8:7: robots[0].ros2: there is no key 'tipps'"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_refused(rows[i].robots, "", rows[i].says);
}

/* Each robot has a node of its own in its domain. */
TEST(nodes_of_one_name_are_refused)
{
#define OTHER                                                                                      \
    "  - name: other\n    urdf: @/config/robots/arm6.urdf\n    ros2:\n      enabled: yes\n"
    assert_refused(ROS2 OTHER, "",
                   ":11:7: robots[1].ros2: namespace and node are those of robot 'arm'");
    assert_refused(ROS2 "      namespace: /\n      domain: 0\n" OTHER "      node: totalforce\n",
                   "", "robots[1].ros2: namespace and node are those of robot 'arm'");
    SCOPED_HARNESS h =
        harness_make(ROS2 OTHER "      domain: 1\n"
                                "  - name: more\n    urdf: @/config/robots/arm6.urdf\n"
                                "    ros2: {enabled: yes, node: more}\n"
                                "  - name: most\n    urdf: @/config/robots/arm6.urdf\n"
                                "    ros2: {enabled: yes, namespace: /most}\n"
                                "  - name: off\n    urdf: @/config/robots/arm6.urdf\n",
                     "ros2: {enabled: yes}\n");
    assert_int_equal(harness_check(&h), 0);
}

/* What cannot be started is refused by --check. */
TEST(settings_of_the_domain_are_checked)
{
    assert_refused(ROS2, ", domain: 231",
                   "ros2.domain: '231' is not a whole number from 0 to 230, or environment");
    assert_refused(ROS2, ", static_peers: ['<x>']", "ros2.static_peers: '<x>' is not a host");
    setenv("ROS_DOMAIN_ID", "999", 1);
    assert_refused(ROS2, "", "ros2: ROS_DOMAIN_ID: '999' is not a whole number from 0 to 230");
    unsetenv("ROS_DOMAIN_ID");
}

/* The section without a robot, and the robot without the section. */
TEST(half_a_configuration_is_off)
{
    harness h;
    h = harness_make(ARM, "ros2: {enabled: yes}\n");
    harness_start(&h, "arm");
    assert_true(harness_logged(&h, "ros2: off: no robot has"));
    harness_remove(&h);
    h = harness_make(ROS2 "      tips: [nothing]\n", "");
    harness_start(&h, "arm");
    harness_remove(&h);
}

int main(void)
{
    (void)test_domain(); /* CYCLONEDDS_URI: loopback only */
    return test_run(NULL, NULL);
}
