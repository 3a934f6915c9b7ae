/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Messages of every input topic, as many, as long or as wrong as a publisher can make them.
 */
#include "floods.h"

#include "dds/dds_test.h"
#include "ros2_arm.h"

#include <idl/ros2_service.h>
#include <math.h>
#include <string.h>

#define PERIOD_US 100 /* 10 kHz */
#define MANY_NAMES 5000

static void write_state(dds_entity_t writer, char **name, uint32_t names, double *number,
                        uint32_t numbers)
{
    const sensor_msgs_msg_dds__JointState_ m = {.header = {{1, 2}, "x"},
                                                .name = PEER_SEQUENCE(names, name),
                                                .position = PEER_SEQUENCE(numbers, number),
                                                .velocity = PEER_SEQUENCE(numbers, number),
                                                .effort = PEER_SEQUENCE(numbers, number)};
    (void)dds_write(writer, &m);
}

void flood_states(dds_entity_t writer, uint64_t *seed)
{
    double q[JOINTS];
    for (int j = 0; j < JOINTS; j++)
        q[j] = test_random(seed);
    write_state(writer, arm_joints, JOINTS, q, JOINTS);
}

static void flood_nan(dds_entity_t writer, uint64_t *seed)
{
    double q[JOINTS] = {NAN, INFINITY, -INFINITY, 1e308, 1e308, 1e308, NAN};
    (void)seed;
    write_state(writer, arm_joints, JOINTS, q, JOINTS);
}

/* Thousands of names, none of the robot's; or a few that are very long; or empty ones. */
static void flood_names(dds_entity_t writer, uint64_t *seed)
{
    static char *name[MANY_NAMES], text[MANY_NAMES][12], longest[1000000];
    static double number[MANY_NAMES];
    char *few[] = {longest, longest + 950000, "", ""};
    if (name[0] == NULL)
        memset(longest, 'x', sizeof longest - 1);
    for (int k = 0; k < MANY_NAMES && name[MANY_NAMES - 1] == NULL; k++) {
        snprintf(text[k], sizeof text[k], "joint%d", k);
        name[k] = text[k];
    }
    if (test_random(seed) < 0)
        write_state(writer, name, MANY_NAMES, number, MANY_NAMES);
    else
        write_state(writer, few, 4, number, 4);
}

static void flood_efforts(dds_entity_t writer, uint64_t *seed)
{
    double tau[JOINTS];
    for (int j = 0; j < JOINTS; j++)
        tau[j] = test_random(seed);
    const std_msgs_msg_dds__Float64MultiArray_ m = {.data = PEER_SEQUENCE(JOINTS, tau)};
    (void)dds_write(writer, &m);
}

/* 80 kB, 0.8 MB, or 8 MB: more than the domain takes. */
static void flood_arrays(dds_entity_t writer, uint64_t *seed)
{
    static double numbers[1000000];
    const uint32_t sizes[] = {10000, 100000, 1000000};
    const uint32_t size = sizes[(uint32_t)(1.4 * (test_random(seed) + 1))];
    const std_msgs_msg_dds__Float64MultiArray_ m = {.data = PEER_SEQUENCE(size, numbers)};
    (void)dds_write(writer, &m);
}

/* Bytes that pass for a JointState by their type's name. */
static void flood_bytes(dds_entity_t writer, uint64_t *seed)
{
    test_msg_dds__Bytes_ m;
    for (size_t k = 0; k < sizeof m.data; k++)
        m.data[k] = k % 4 ? 0 : (uint8_t)(64 * (test_random(seed) + 1));
    (void)dds_write(writer, &m);
}

/* A state with a frame of 1 MB */
static void flood_frames(dds_entity_t writer, uint64_t *seed)
{
    static char text[1000000];
    double q[JOINTS] = {test_random(seed)};
    memset(text, 'x', sizeof text - 1);
    const sensor_msgs_msg_dds__JointState_ m = {.header = {{1, 2}, text},
                                                .name = PEER_SEQUENCE(JOINTS, arm_joints),
                                                .position = PEER_SEQUENCE(JOINTS, q)};
    (void)dds_write(writer, &m);
}

/* A trajectory of 1 MB, of points without anything or of one point */
static void flood_points(dds_entity_t writer, uint64_t *seed)
{
    static trajectory_msgs_msg_dds__JointTrajectoryPoint_ points[40000];
    static double numbers[120000];
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ one = {.velocities =
                                                              PEER_SEQUENCE(120000, numbers)};
    trajectory_msgs_msg_dds__JointTrajectory_ m = {.header = {{1, 2}, ""},
                                                   .points = PEER_SEQUENCE(40000, points)};
    if (test_random(seed) < 0)
        m.points =
            (dds_sequence_trajectory_msgs_msg_dds__JointTrajectoryPoint_)PEER_SEQUENCE(1, &one);
    (void)dds_write(writer, &m);
}

/* A layout of 1 MB, of many dimensions or of one label */
static void flood_layouts(dds_entity_t writer, uint64_t *seed)
{
    static std_msgs_msg_dds__MultiArrayDimension_ dimensions[60000];
    static char text[1000000];
    double tau[JOINTS] = {0};
    const bool many = test_random(seed) < 0;
    const uint32_t count = many ? 60000 : 1;
    memset(text, 'x', sizeof text - 1);
    for (uint32_t k = 0; k < count; k++)
        dimensions[k].label = many ? "" : text;
    const std_msgs_msg_dds__Float64MultiArray_ m = {.layout = {PEER_SEQUENCE(count, dimensions), 0},
                                                    .data = PEER_SEQUENCE(JOINTS, tau)};
    (void)dds_write(writer, &m);
}

/* Each another one, all bad, of almost the length that is read. */
static void flood_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char text[1000000];
    memset(text, 'x', sizeof text - 1);
    snprintf(text, 64, "<robot name='%.17g'><link", test_random(seed));
    text[strlen(text)] = ' ';
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

/* Short ones, each with many errors. */
static void flood_short_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char text[8192];
    size_t used = (size_t)snprintf(text, sizeof text, "<robot name='%.17g'>", test_random(seed));
    for (int k = 0; k < 100; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "<link name='l%d' mass='x'/>", k);
    snprintf(text + used, sizeof text - used, "<joint name='j'/></robot>");
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

/* Each another one, all good: the model is exchanged as often as the daemon can. */
static void flood_good_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char file[65536], text[66000];
    static const char mass[] = "<mass value=\"2.8\"/>";
    if (file[0] == 0) {
        FILE *in = fopen(TFA_SOURCE_DIR "/config/robots/arm7.urdf", "r");
        assert_non_null(in);
        assert_true(fread(file, 1, sizeof file - 1, in) > 0);
        fclose(in);
    }
    const char *at = strstr(file, mass);
    assert_non_null(at);
    snprintf(text, sizeof text, "%.*s<mass value=\"%.17g\"/>%s", (int)(at - file), file,
             3 + test_random(seed), at + sizeof mass - 1);
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

static dds_topic_descriptor_t bytes_as_state;

/* The first one is no attack: what the publisher costs by itself, on the processors of all. */
const flood floods[] = {
    {"elsewhere at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/elsewhere", PEER_SENSOR,
     flood_states, PERIOD_US},
    {"states at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states", PEER_SENSOR,
     flood_states, PERIOD_US},
    {"efforts at 10 kHz", &std_msgs_msg_dds__Float64MultiArray__desc,
     "rt/arm/effort_controller/commands", PEER_DEFAULT, flood_efforts, PERIOD_US},
    {"NaN at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_efforts", PEER_DEFAULT,
     flood_nan, PERIOD_US},
    {"5000 names, long names", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states",
     PEER_SENSOR, flood_names, 1000},
    {"huge arrays", &std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/effort_controller/commands",
     PEER_SENSOR, flood_arrays, 10000},
    {"long frames", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states", PEER_SENSOR,
     flood_frames, 10000},
    {"many points", &trajectory_msgs_msg_dds__JointTrajectory__desc, "rt/arm/trajectory",
     PEER_DEFAULT, flood_points, 10000},
    {"long layouts", &std_msgs_msg_dds__Float64MultiArray__desc,
     "rt/arm/effort_controller/commands", PEER_DEFAULT, flood_layouts, 10000},
    {"bytes", &bytes_as_state, "rt/arm/joint_states", PEER_SENSOR, flood_bytes, PERIOD_US},
    {"bad descriptions", &std_msgs_msg_dds__String__desc, "rt/arm/robot_description",
     PEER_TRANSIENT_LOCAL, flood_descriptions, 10000},
    {"short bad descriptions", &std_msgs_msg_dds__String__desc, "rt/arm/robot_description",
     PEER_TRANSIENT_LOCAL, flood_short_descriptions, 1000},
    {"good descriptions", &std_msgs_msg_dds__String__desc, "rt/other/robot_description",
     PEER_TRANSIENT_LOCAL, flood_good_descriptions, 1000},
};

const size_t flood_count = sizeof floods / sizeof *floods;

static void *run_flooder(void *arg)
{
    flooder *f = arg;
    const struct sched_param ordinary = {0};
    uint64_t seed = 1;
    const dds_entity_t p = ros2_peer_open(f->domain);
    const dds_entity_t writer = ros2_peer_writer(p, f->how->type, f->how->topic, f->how->qos);
    uint64_t next = now_ns();
    (void)pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary); /* not as the starter */
    ros2_peer_await_reader(writer);
    while (!atomic_load(&f->stop)) {
        f->how->write(writer, &seed);
        f->written++;
        next += 1000u * f->how->period_us;
        const uint64_t now = now_ns();
        if (now < next)
            dds_sleepfor((dds_duration_t)(next - now));
        else
            next = now;
    }
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
    return NULL;
}

void flooder_start(flooder *f, const flood *how, uint32_t domain)
{
    memcpy(&bytes_as_state, &test_msg_dds__Bytes__desc, sizeof bytes_as_state); /* const members */
    bytes_as_state.m_typename = sensor_msgs_msg_dds__JointState__desc.m_typename;
    *f = (flooder){.how = how, .domain = domain};
    assert_int_equal(pthread_create(&f->thread, NULL, run_flooder, f), 0);
}

uint64_t flooder_stop(flooder *f)
{
    atomic_store(&f->stop, true);
    pthread_join(f->thread, NULL);
    return f->written;
}
