/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every op, flag, method and option of a request, about robots with every setting that shapes
 * answers: recorded and replayed, in process and by the daemon, to the same bits.
 */
#include "recorder.h"

#include "ipc/wire_blocks.h"
#include "test.h"

#include <signal.h>

#define BATCH 3
#define WORDS 20000 /* of the largest answer */
#define INPUTS 4096

static const char robots[] = ARM
    "    estimate: sampled\n    estimate_every: 7\n    armature: [{joint: joint_3, value: 0.25}]\n"
    "    gravity: [0.1, 0, -9.7]\n    scenes:\n"
    "      - name: loaded\n        payload:\n"
    "          - {link: tool0, mass: 2, com: [0, 0, 0.05], inertia: [4e-3, 0, 0, 4e-3, 0, 2e-3]}\n"
    "      - name: stiff\n        locked: [{joint: joint_2, q: 0.3}]\n"
    "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"
    "    estimate: always\n    damping: true\n"
    "  - name: man\n    urdf: @/config/robots/humanoid.urdf\n    base: floating\n"
    "    precision: f32\n    residual: f64\n    scenes:\n"
    "      - name: reach\n        base: fixed\n        root: torso_link\n"
    "        tips: [left_palm]\n"
    "  - name: hand\n    urdf: @/tests/tools/data/hand.urdf\n    mimic: project\n"
    "    methods: all\n    lock_massless_leaves: true\n    rotor_inertia: true\n"
    "  - name: snake\n    urdf: @/config/robots/snake64.urdf\n    residual: f128\n"
    "    max_batch: 8\n";

static const struct {
    const char *name;
    unsigned step; /* of the choices: large robots take every one so often */
} served[] = {{"arm", 1}, {"arm.loaded", 3}, {"arm.stiff", 3}, {"dog", 2},
              {"man", 7}, {"man.reach", 3},  {"hand", 3},      {"snake", 11}};
#define SERVED (sizeof served / sizeof *served)

static double numbers[8][INPUTS], base_pose[BATCH * 7];

static void fill_numbers(void)
{
    uint64_t s = 12345;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < INPUTS; i++) {
            s = s * 6364136223846793005u + 1442695040888963407u;
            numbers[k][i] = (double)(int64_t)(s >> 11) / 4503599627370496.0 - 1;
        }
    for (size_t i = 0; i < BATCH; i++) {
        const double pose[7] = {0.1, 0.2, 0.3, 0.6, 0, 0, 0.8};
        memcpy(base_pose + 7 * i, pose, sizeof pose);
    }
}

/* Request number `i`: each of its digits chooses something. */
static tfa_request request_of(unsigned i, const tfa_client_info *info, uint32_t *joints)
{
    static const double loads[2 * TFA_PAYLOAD_NUMBERS] = {0.5, 0.1,  0, 0.2,  0.01, 0.001,
                                                          0,   0.02, 0, 0.03, 2},
                                  moon[3] = {0, 0.1, -1.62}, threshold[1] = {1e-4};
    const unsigned op = i % 10, flag = i / 10 % 14, choice = i / 140;
    tfa_request r = {.op = (tfa_op)op, /* 0 and 9 are none */
                     .method = (tfa_method)(choice % 3 ? 0 : (i / 7) % 18),
                     .estimate = (tfa_estimate)(choice / 2 % 4),
                     .frame = (tfa_reference_frame)(choice % 3),
                     .refine = choice % 5 == 4 ? 2 : TFA_REFINE_DEFAULT,
                     .flags = flag == 0    ? 0
                              : flag == 13 ? TFA_WANT_ALL
                                           : 1u << (flag - 1),
                     .count = choice % 2 ? BATCH : 1,
                     .rows = (tfa_rows)(choice / 3 % 2),
                     .rank_loss = (tfa_rank_loss)(choice / 5 % 3),
                     .tip_count = choice / 2 % 3,
                     .wrench_count = choice % 4 == 1 ? 2 : 0,
                     .payload_count = choice % 4 == 2 ? 2 : 0,
                     .locked_count = choice % 7 == 3 ? 1 : 0,
                     .q = numbers[0],
                     .v = choice % 6 == 5 ? NULL : numbers[1],
                     .tau = numbers[2],
                     .qdd = numbers[3],
                     .base_pose = base_pose,
                     .base_twist = numbers[4],
                     .base_wrench = numbers[5],
                     .base_acceleration = numbers[6],
                     .gravity = choice % 5 == 2 ? moon : NULL,
                     .wrenches = numbers[7],
                     .payloads = loads,
                     .task_acceleration = numbers[4],
                     .rank_threshold = choice % 9 == 8 ? threshold : NULL};
    r.tips[0] = info->frame_count - 1;
    r.tips[1] = i % 83 == 82 ? info->frame_count : info->frame_count / 2; /* or none */
    r.wrench_frames[0] = info->frame_count - 1;
    r.wrench_frames[1] = info->frame_count / 3;
    r.payload_frames[0] = info->frame_count - 1;
    r.payload_frames[1] = info->frame_count / 2;
    joints[0] = info->joint_count / 2;
    r.locked = joints;
    return r;
}

/* Asks every kind. @return requests that were sent */
static unsigned ask_everything(const harness *h, const char *robot, unsigned step)
{
    static double blocks[TFA_WIRE_REPLY_BLOCKS][WORDS];
    tfa_reply reply = {0};
    tfa_client_options options = harness_options(h, robot);
    tfa_client *client;
    uint32_t joints[1];
    unsigned sent = 0, answered = 0;
    options.max_batch = BATCH;
    options.slots = 2;
#define POINT_AT(name, field, ...) reply.field = (void *)blocks[TFA_WIRE_##name];
    TFA_OUTPUT_LIST(POINT_AT)
#undef POINT_AT
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    for (unsigned i = 0; i < 140 * 42; i += step) {
        tfa_exchange times = {0};
        const tfa_request r = request_of(i, tfa_client_get_info(client), joints);
        const int status = tfa_client_call(client, &r, &reply, WAIT_NS, &times);
        answered += status == TFA_OK;
        sent += times.t_sent != 0;
    }
    tfa_client_close(client);
    assert_true(answered > sent / 4);
    return sent;
}

static void record_and_replay(const harness *h, const char *robot, unsigned step)
{
    static recorder r;
    char more[160];
    recorder_begin(h, &r, robot, "a.rec", "--buffer 64", 0);
    const unsigned sent = ask_everything(h, robot, step);
    assert_int_equal(recorder_end(&r), 0);
    assert_int_equal(recorder_number(&r, ".rec: "), sent);
    if (recorder_replay(h, &r, "a.rec", "") != 0)
        fail_msg("%s, in process: %s", robot, r.text);
    assert_int_equal(recorder_number(&r, "same bits "), sent);
    snprintf(more, sizeof more, "--robot %s --runtime-dir %s", robot, h->runtime_dir);
    if (recorder_replay(h, &r, "a.rec", more) != 0)
        fail_msg("%s, by the daemon: %s", robot, r.text);
    /* which open requests a daemon estimates is chance */
    const long chance = recorder_number(&r, "not played: ");
    assert_int_equal(recorder_number(&r, "same bits ") + (chance < 0 ? 0 : chance), sent);
    assert_true(chance < (long)sent / 2);
}

TEST(every_answer_again)
{
    harness h;
    fill_numbers();
    harness_serve(&h, robots, "workers: 2\n");
    for (size_t k = 0; k < SERVED; k++)
        record_and_replay(&h, served[k].name, served[k].step);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    harness_remove(&h);
}
