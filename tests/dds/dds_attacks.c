/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile participants: each attack runs in a process of its own, until it is killed. They pause
 * between bursts: a test on two processors is about the daemon, not about who is scheduled.
 */
#include "dds_attacks.h"

#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "test.h"

#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <unistd.h>

#define JOINTS 7
#define BURST 32
#define HUGE_LENGTH 1000000u
#define ENDPOINTS 200

extern char **environ;

typedef struct attacker {
    dds_entity_t participant;
    dds_entity_t topics[TFA_DDS_TOPIC_COUNT];
} attacker;

static double zeros[JOINTS];

static dds_entity_t make_writer(const attacker *a, tfa_dds_topic topic)
{
    return tfa_dds_create_writer(a->participant, a->topics[topic], topic, NULL);
}

static totalforce_dds_Request good_request(const char *robot)
{
    totalforce_dds_Request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                      .refine = TFA_REFINE_DEFAULT,
                                      .count = 1,
                                      .q = {JOINTS, JOINTS, zeros, false}};
    (void)tfa_dds_set_robot(request.robot, robot);
    return request;
}

static void pause_after_burst(uint32_t k)
{
    if (k % BURST == 0)
        dds_sleepfor(DDS_MSECS(1));
}

/* Sizes, counts, ops and methods that the robot does not have. */
static void malformed_requests(const attacker *a)
{
    const dds_entity_t writer = make_writer(a, TFA_DDS_REQUEST);
    const dds_entity_t torques = make_writer(a, TFA_DDS_TORQUES);
    for (uint32_t k = 1;; k++, pause_after_burst(k)) {
        totalforce_dds_Request request = good_request("arm");
        totalforce_dds_JointTorques stream = {.q = {k % JOINTS, k % JOINTS, zeros, false}};
        request.q._length = k & 1 ? k % JOINTS : JOINTS;
        request.count = k & 2 ? k : 1;
        request.op = k & 4 ? k : TFA_OP_FORWARD_DYNAMICS;
        request.method = k & 8 ? k : 0;
        (void)tfa_dds_set_robot(stream.robot, "arm");
        (void)dds_write(writer, &request);
        (void)dds_write(torques, &stream);
    }
}

/* Each name once. */
static void unknown_robots(const attacker *a)
{
    const dds_entity_t writer = make_writer(a, TFA_DDS_REQUEST);
    for (uint32_t k = 1;; k++, pause_after_burst(k)) {
        char name[32];
        snprintf(name, sizeof name, "stranger%u", k);
        const totalforce_dds_Request request = good_request(name);
        (void)dds_write(writer, &request);
        (void)dds_unregister_instance(writer, &request);
    }
}

static void huge_sequences(const attacker *a)
{
    const dds_entity_t writer = make_writer(a, TFA_DDS_REQUEST);
    double *huge = calloc(HUGE_LENGTH, sizeof *huge);
    totalforce_dds_Request request = good_request("arm");
    request.tau = (dds_sequence_double){HUGE_LENGTH, HUGE_LENGTH, huge, false};
    if (huge == NULL)
        return;
    for (;; dds_sleepfor(DDS_MSECS(50)))
        (void)dds_write(writer, &request);
}

void dds_forge(dds_entity_t p, const dds_entity_t *topics, dds_forger *f)
{
    static totalforce_dds_Request request;
    double lies[JOINTS] = {DDS_LIE};
    const dds_entity_t requests =
        tfa_dds_create_reader(p, topics[TFA_DDS_REQUEST], TFA_DDS_REQUEST, NULL);
    const dds_entity_t replies =
        tfa_dds_create_writer(p, topics[TFA_DDS_REPLY], TFA_DDS_REPLY, NULL);
    const dds_entity_t infos =
        tfa_dds_create_writer(p, topics[TFA_DDS_ROBOT_INFO], TFA_DDS_ROBOT_INFO, NULL);
    while (!atomic_load(&f->stop)) {
        totalforce_dds_RobotInfo info = {.q_count = 1};
        dds_sample_info_t state;
        if (dds_take(requests, (void *[]){&request}, &state, 1, 1) != 1 || !state.valid_data) {
            dds_sleepfor(DDS_USECS(100));
            continue;
        }
        const uint32_t k = atomic_load(&f->forged);
        totalforce_dds_Reply reply = {.id = request.id,
                                      .epoch = k / 2 % 2 ? UINT64_MAX : 1,
                                      .qdd = {JOINTS, JOINTS, lies, false}};
        memcpy(reply.robot, request.robot, sizeof reply.robot);
        memcpy(reply.client, request.client, sizeof reply.client);
        memcpy(info.robot, request.robot, sizeof info.robot);
        (void)atomic_fetch_add(&f->forged, dds_write(replies, &reply) == DDS_RETCODE_OK);
        (void)(k % 2 ? dds_dispose(infos, &info) : dds_write(infos, &info));
    }
    totalforce_dds_Request_free(&request, DDS_FREE_CONTENTS);
}

static void forged_replies(const attacker *a)
{
    static dds_forger for_ever;
    dds_forge(a->participant, a->topics, &for_ever);
}

/* Readers that never read, writers that never write, again and again. */
static void endpoints(const attacker *a)
{
    for (;;) {
        dds_entity_t made[ENDPOINTS];
        for (uint32_t k = 0; k < ENDPOINTS; k++) {
            const tfa_dds_topic topic = k / 2 % TFA_DDS_TOPIC_COUNT;
            made[k] = k % 2 ? make_writer(a, topic)
                            : tfa_dds_create_reader(a->participant, a->topics[topic], topic, NULL);
        }
        dds_sleepfor(DDS_MSECS(100));
        for (uint32_t k = 0; k < ENDPOINTS; k++)
            (void)dds_delete(made[k]);
    }
}

static void (*const attacks[])(const attacker *a) = {
    malformed_requests, unknown_robots, huge_sequences, forged_replies, endpoints,
};

const size_t dds_attack_count = sizeof attacks / sizeof *attacks;

void dds_attack_main(int argc, char **argv)
{
    if (argc != 4 || strcmp(argv[1], "attack") != 0)
        return;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    attacker a = {dds_create_participant((uint32_t)atoi(argv[3]), NULL, NULL), {0}};
    if (a.participant < 0)
        _exit(1);
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i < TFA_DDS_TOPIC_COUNT; i++)
        a.topics[i] = tfa_dds_create_topic(a.participant, i);
    attacks[(size_t)atoi(argv[2]) % dds_attack_count](&a);
    _exit(1);
}

pid_t dds_attack_start(size_t index, uint32_t domain)
{
    char program[] = "/proc/self/exe", verb[] = "attack", numbers[2][16];
    char *argv[] = {program, verb, numbers[0], numbers[1], NULL};
    pid_t child;
    snprintf(numbers[0], sizeof numbers[0], "%zu", index);
    snprintf(numbers[1], sizeof numbers[1], "%u", domain);
    assert_int_equal(posix_spawn(&child, program, NULL, NULL, argv, environ), 0);
    return child;
}
