/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every op, flag, method and option of a request, about robots with every setting that shapes
 * answers: recorded and replayed, in process and by the daemon, to the same bits.
 */
#include "recorder.h"

#include "support/any_request.h"
#include "test.h"

#include <signal.h>

static const char robots[] = ARM
    "    estimate: sampled\n    estimate_every: 7\n    armature: [{joint: joint_3, value: 0.25}]\n"
    "    gravity: [0.1, 0, -9.7]\n    scenes:\n"
    "      - name: loaded\n        payload:\n"
    "          - {link: tool0, mass: 2, com: [0, 0, 0.05], inertia: [4e-3, 0, 0, 4e-3, 0, 2e-3]}\n"
    "      - name: stiff\n        locked: [{joint: joint_2, q: 0.3}]\n"
    "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"
    "    estimate: always\n    damping: true\n    friction: true\n    friction_velocity: 0.2\n"
    "    rotors: [{joint: FL_hip_joint, value: 1e-3}]\n"
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

/* Asks every kind. @return requests that were sent */
static unsigned ask_everything(const harness *h, const char *robot, unsigned step)
{
    tfa_client_options options = harness_options(h, robot);
    unsigned sent = 0, answered = 0;
    options.max_batch = ANY_BATCH;
    options.slots = 2;
    SCOPED_CLIENT *client = harness_connect_with(&options);
    const tfa_client_info *info = tfa_client_get_info(client);
    SCOPED(any_answers_free) any_answers a = any_answers_make(info);
    for (unsigned i = 0; i < ANY_REQUESTS; i += ANY_STEP(step)) {
        tfa_exchange times = {0};
        const tfa_request r = any_request(i, info);
        const int status = tfa_client_call(client, &r, &a.reply, WAIT_NS, &times);
        answered += status == TFA_OK;
        sent += times.t_sent != 0;
    }
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
    SCOPED_HARNESS h = harness_serve(robots, "workers: 2\n");
    for (size_t k = 0; k < SERVED; k++)
        record_and_replay(&h, served[k].name, served[k].step);
}
