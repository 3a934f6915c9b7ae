/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Encodings of every kind of input that are cut short, damaged, or of another length than they say,
 * in great number, from publishers of many: the daemon lives, its memory is bounded, and robots
 * whose topics they are answer afterwards.
 */
#include "dds/dds_test.h"

#include "fuzz/random.h"
#include "messages.h"
#include "ros2_arm.h"

#include <idl/ros2_service.h>
#include <idl/unitree.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>

#define SAMPLES 6        /* valid encodings of each type */
#define ROUNDS 150       /* of messages from each writer */
#define GROWN_KIB 100000 /* 5 MiB were seen; queues and histories are bounded by numbers */

static harness running;
static arm_node node;

/* ---- what is written ---- */

/* Inputs of the robots below. */
static const struct input {
    const dds_topic_descriptor_t *type;
    const char *topic;
} inputs[] = {
    {&std_msgs_msg_dds__String__desc, "rt/arm/robot_description"},
    {&sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states"},
    {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/effort_controller/commands"},
    {&sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_efforts"},
    {&trajectory_msgs_msg_dds__JointTrajectory__desc, "rt/arm/trajectory"},
    {&nav_msgs_msg_dds__Odometry__desc, "rt/dog/odom"},
    {&geometry_msgs_msg_dds__WrenchStamped__desc, "rt/dog/ft"},
    {&std_msgs_msg_dds__String__desc, "rt/dog/contacts"},
    {&unitree_go_msg_dds__LowState__desc, "rt/lowstate"},
    {&unitree_hg_msg_dds__LowState__desc, "rt/man/lowstate"},
    {&totalforce_msgs_srv_dds__ForwardDynamics_Request__desc,
     "rq/arm/totalforce/forward_dynamicsRequest"},
};

#define INPUTS (sizeof inputs / sizeof *inputs)

/* Lengths of messages; those that are shorter than a type needs are cut. */
static const uint32_t sizes[] = {1, 4, 5, 8, 12, 16, 24, 41, 64, 100, 300, 1200, 4000};

#define SIZES (sizeof sizes / sizeof *sizes)
#define SIZE_MAX_WRITTEN 4000

static msg_bytes encoded[INPUTS][SAMPLES];

static void encode_samples(void)
{
    struct random_source seed = {1};
    for (size_t k = 0; k < INPUTS; k++) {
        const msg *m = msg_of_topic(inputs[k].type);
        void *sample = calloc(1, m->size);
        assert_non_null(sample);
        for (int i = 0; i < SAMPLES; i++) {
            msg_fill(m, sample, &seed);
            msg_encode(m, sample, &encoded[k][i]);
        }
        free(sample);
    }
}

/* So many bytes that pass for a message by the name of its type. */
typedef struct raw_writer {
    uint32_t ops[4];
    dds_topic_descriptor_t type;
    dds_entity_t writer;
} raw_writer;

static void open_writer(raw_writer *w, dds_entity_t participant, const struct input *in,
                        uint32_t size)
{
    const ros2_peer_qos qos =
        in->type == &std_msgs_msg_dds__String__desc ? PEER_TRANSIENT_LOCAL : PEER_DEFAULT;
    memcpy(w->ops, test_msg_dds__Bytes__desc.m_ops, sizeof w->ops);
    assert_int_equal(w->ops[2], sizeof((test_msg_dds__Bytes_ *)0)->data);
    w->ops[2] = size;
    memcpy(&w->type, &test_msg_dds__Bytes__desc, sizeof w->type);
    memcpy((void *)&w->type.m_size, &size, sizeof size);
    w->type.m_typename = in->type->m_typename;
    w->type.m_ops = w->ops;
    w->writer = ros2_peer_writer(participant, &w->type, in->topic, qos);
}

/* As it is, with bytes changed, or with a length that is much too great. */
static void damage(uint8_t *byte, uint32_t size, struct random_source *seed)
{
    static const uint32_t lengths[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x20000001, 1000};
    const uint32_t how = (uint32_t)random_below(seed, 4);
    for (uint32_t k = 0; how == 1 && k < 1 + size / 16; k++)
        byte[random_below(seed, size)] = (uint8_t)random_below(seed, 256);
    if (how >= 2 && size >= 4)
        memcpy(byte + random_below(seed, size / 4) * 4, &lengths[random_below(seed, 7)], 4);
}

static void write_damaged(const raw_writer *w, size_t input, uint32_t size,
                          struct random_source *seed)
{
    static uint8_t byte[SIZE_MAX_WRITTEN];
    const msg_bytes *from = &encoded[input][random_below(seed, SAMPLES)];
    const size_t body = from->size - 4; /* behind the header */
    memset(byte, 0, sizeof byte);
    memcpy(byte, from->byte + 4, body < size ? body : size);
    damage(byte, size, seed);
    assert_int_equal(dds_write(w->writer, byte), DDS_RETCODE_OK);
}

/* One participant for each size: there a topic has one type. */
static uint32_t flood(struct random_source *seed, uint32_t size)
{
    static raw_writer writers[INPUTS];
    uint32_t written = 0;
    const dds_entity_t p = ros2_peer_open(node.domain);
    for (size_t k = 0; k < INPUTS; k++)
        open_writer(&writers[k], p, &inputs[k], size);
    for (size_t k = 0; k < INPUTS; k++)
        ros2_peer_await_reader(writers[k].writer);
    for (int round = 0; round < ROUNDS; round++) {
        for (size_t k = 0; k < INPUTS; k++, written++)
            write_damaged(&writers[k], k, size, seed);
        dds_sleepfor(DDS_USECS(500)); /* the publishers take turns with the daemon */
    }
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
    return written;
}

TEST(damaged_messages_of_every_kind)
{
    struct random_source seed = {2};
    static arm_witness w;
    uint32_t written = 0;
    const long before = harness_resident_kib(&running);
    arm_witness_start(&w, &running, true);
    for (size_t k = 0; k < SIZES; k++)
        written += flood(&seed, sizes[k]);
    arm_assert_answered(&node);
    arm_witness_stop(&w);
    const long grown = harness_resident_kib(&running) - before;
    print_message("%u messages, %u requests over shared memory, grown %ld KiB\n", written, w.asked,
                  grown);
#ifndef TFA_INSTRUMENTED /* sanitizers keep memory that was freed */
    assert_true(grown < GROWN_KIB);
#endif
}

#define MOTORS                                                                                     \
    "[FR_hip_joint, FR_thigh_joint, FR_calf_joint, FL_hip_joint, FL_thigh_joint, FL_calf_joint, "  \
    "RR_hip_joint, RR_thigh_joint, RR_calf_joint, RL_hip_joint, RL_thigh_joint, RL_calf_joint]"

#define QUADRUPED(name, more)                                                                      \
    "  - name: " name "\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"           \
    "    ros2:\n      enabled: yes\n      namespace: /" name "\n" more

static int serve(void **state)
{
    static char yaml[4096];
    (void)state;
    encode_samples();
    snprintf(yaml, sizeof yaml,
             "%s" QUADRUPED("dog", "      odometry: odom\n"
                                   "      wrenches: [{topic: ft, link: FL_foot}]\n"
                                   "      op: constrained_dynamics\n      scene: stand\n"
                                   "      active_constraints: contacts\n    scenes:\n"
                                   "      - name: stand\n        constraints:\n"
                                   "          - {name: FL, second: {link: FL_foot}, hold: point}\n")
                 QUADRUPED("go", "      unitree: {type: go, motors: " MOTORS "}\n")
                     QUADRUPED("man", "      unitree: {type: hg, topic: /man/lowstate, "
                                      "motors: " MOTORS "}\n"),
             arm_yaml("      services: yes\n"));
    running = harness_serve(yaml, arm_settings(""));
    arm_node_open(&node);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    arm_node_close(&node);
    harness_remove(&running);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
