/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * max_state_us in the real daemon: refused by name without a pool, answered beside the worker with
 * one, by the same bits, whoever leaves meanwhile.
 */
#include "attacks.h"
#include "models.h"
#include "test.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <totalforce/text.h>

#define WALKER "  - name: walker\n    urdf: @/config/robots/humanoid.urdf\n    base: floating\n"
#define JOINTS 47
#define FREEDOMS (JOINTS + 6)
#define TIPS 8
#define ROWS (6 * TIPS)
#define LIMITED "max_state_us: 5\n" /* no machine takes the derivatives in 5 us */
#define BESIDE LIMITED "pool: {threads: 2}\n"
#define LEAVERS TEST_ROUNDS(12)

static double numbers[3 * FREEDOMS], pose[21];

static void fill_inputs(void)
{
    for (int i = 0; i < 3 * FREEDOMS; i++)
        numbers[i] = 0.3 - 0.01 * (i % 50);
    for (int i = 0; i < 3; i++)
        pose[7 * i + 6] = 1;
}

static tfa_request long_request(tfa_op op)
{
    tfa_request r = {.op = op,
                     .count = 1,
                     .refine = TFA_REFINE_DEFAULT,
                     .q = numbers,
                     .v = numbers,
                     .tau = numbers,
                     .base_pose = pose};
    if (op == TFA_OP_OPERATIONAL_INERTIA) { /* longer still */
        r.method = TFA_METHOD_HESSENBERG;
        r.tip_count = TIPS;
        for (uint32_t k = 0; k < TIPS; k++)
            r.tips[k] = 50 - 5 * k;
    }
    return r;
}

TEST(refused_by_name)
{
    SCOPED_HARNESS h = harness_serve(WALKER ARM, LIMITED);
    SCOPED_CLIENT *client = harness_connect(&h, "walker", TFA_WAIT_BLOCK);
    const tfa_request r = long_request(TFA_OP_DERIVATIVES);
    tfa_reply reply = {0};
    assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, NULL), TFA_E_REFUSED);
    assert_int_equal(reply.field, TFA_FIELD_COST);
    assert_true(reply.index > 5);
    assert_int_equal(reply.state, 5);
    char text[300];
    const tfa_names names = {.robot = "walker"};
    (void)tfa_explain(&names, &r, &reply, TFA_SYNTAX_C, text, sizeof text);
    assert_non_null(strstr(text, "the daemon admits 5 us"));
    assert_non_null(strstr(text, "max_state_us"));
    harness_reload(&h, WALKER ARM, "max_state_us: 0\n");
    assert_true(WAIT_FOR(tfa_client_call(client, &r, &reply, WAIT_NS, NULL) == TFA_OK));
    harness_reload(&h, WALKER ARM, LIMITED);
    assert_true(WAIT_FOR(tfa_client_call(client, &r, &reply, WAIT_NS, NULL) == TFA_E_REFUSED));
}

/* Two clients in turns, single states and a batch. */
TEST(answered_beside_the_worker)
{
    static double expected[3][FREEDOMS * FREEDOMS], found[3][FREEDOMS * FREEDOMS];
    SCOPED_HARNESS h = harness_serve(WALKER ARM, BESIDE);
    tfa_client_options options = harness_options(&h, "walker");
    options.max_batch = 3;
    SCOPED_CLIENT *one = harness_connect_with(&options);
    SCOPED_CLIENT *other = harness_connect_with(&options);
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    tfa_model *model = bundled_model("humanoid.urdf", &floating);
    tfa_workspace *workspace;
    tfa_request r = long_request(TFA_OP_DERIVATIVES);
    tfa_reply reply = {.dqdd_dq = expected[0]};
    r.count = 3;
    assert_int_equal(tfa_workspace_create(model, NULL, &workspace), TFA_OK);
    assert_int_equal(tfa_compute(workspace, &r, &reply), TFA_OK);
    for (int k = 0; k < 20; k++) {
        r.count = k % 2 ? 3 : 1;
        reply = (tfa_reply){.dqdd_dq = found[0]};
        const size_t bytes = r.count * sizeof *found;
        memset(found, 0, sizeof found);
        assert_int_equal(tfa_client_send(one, &r, NULL), TFA_OK);
        assert_int_equal(tfa_client_call(other, &r, &reply, WAIT_NS, NULL), TFA_OK);
        assert_memory_equal(found, expected, bytes);
        memset(found, 0, sizeof found);
        assert_int_equal(tfa_client_receive(one, &reply, WAIT_NS, NULL), TFA_OK);
        assert_memory_equal(found, expected, bytes);
    }
    tfa_workspace_free(workspace);
    tfa_model_free(model);
}

/* Asks for what takes a millisecond, again and again. */
static pid_t start_asking(const harness *h)
{
    const pid_t child = fork();
    if (child != 0)
        return child;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    const tfa_client_options options = harness_options(h, "walker");
    const tfa_request r = long_request(TFA_OP_OPERATIONAL_INERTIA);
    tfa_client *client;
    tfa_reply reply = {0};
    if (!WAIT_FOR(tfa_client_connect(&options, &client) == TFA_OK))
        _exit(1);
    for (;;)
        if (tfa_client_send(client, &r, NULL) != TFA_OK)
            (void)tfa_client_receive(client, &reply, WAIT_NS, NULL);
}

/* Clients are killed and solvers exchanged while the thread is at their requests; the daemon ends
 * while it is. */
TEST(meanwhile_others_leave)
{
    SCOPED_HARNESS h = harness_serve(WALKER ARM, BESIDE);
    SCOPED_CLIENT *arm = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    SCOPED_CLIENT *walker = harness_connect(&h, "walker", TFA_WAIT_BLOCK);
    const tfa_request r = long_request(TFA_OP_DERIVATIVES);
    double qdd[7];
    for (unsigned k = 0; k < LEAVERS; k++) {
        tfa_reply reply = {0};
        const pid_t children[2] = {start_asking(&h), start_asking(&h)};
        for (int i = 0; i < 10; i++)
            assert_int_equal(ask_arm(arm, i, qdd, WAIT_NS), TFA_OK);
        assert_int_equal(tfa_client_call(walker, &r, &reply, WAIT_NS, NULL), TFA_OK);
        attack_stop(children[k % 2]);
        harness_reload(&h, k % 2 ? WALKER ARM : WALKER "    estimate: always\n" ARM, BESIDE);
        assert_int_equal(tfa_client_call(walker, &r, &reply, WAIT_NS, NULL), TFA_OK);
        attack_stop(children[1 - k % 2]);
    }
    const pid_t child = start_asking(&h);
    usleep(100000);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    attack_stop(child);
}

int main(void)
{
    fill_inputs();
    return test_run(NULL, NULL);
}
