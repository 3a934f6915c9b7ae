/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The models of a running totalforced change while it is asked over DDS.
 */
#include "dds_test.h"

#include "harness.h"
#include "herald.h"
#include "models.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>

#define SWAPS 20
#define SNAKE "  - name: arm\n    urdf: @/config/robots/snake64.urdf\n"

static const double gravities[2][3] = {{0, 0, -9.80665}, {0, 0, -1.5}};
static const char *const yaml[2] = {ARM, ARM "    gravity: [0, 0, -1.5]\n"};
static const double q[64] = {0.1, 0.4, -0.3, 0.2, 0.6, -0.5, 0.1};

/* Asks until it is told to stop; checks that each reply is that of the model it names. */
typedef struct asker {
    tfa_dds_client *client;
    double expected[2][7];
    uint64_t tags[2];
    _Atomic bool stop;
    _Atomic int model; /* that answered last */
    uint32_t asked;
    const char *error;
    pthread_t thread;
} asker;

static tfa_request make_request(void)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = q};
}

static void expect(asker *a)
{
    const tfa_request request = make_request();
    for (int i = 0; i < 2; i++) {
        const tfa_model_options options = {.gravity = gravities[i]};
        tfa_reply reply = {.qdd = a->expected[i]};
        SCOPED_MODEL *model = bundled_model("arm7.urdf", &options);
        SCOPED_WORKSPACE *workspace = workspace_for(model, NULL);
        assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
        a->tags[i] = tfa_model_tag(model);
    }
}

static void *ask(void *argument)
{
    asker *a = argument;
    const tfa_request request = make_request();
    double qdd[7];
    for (; !atomic_load(&a->stop) && a->error == NULL; a->asked++) {
        tfa_reply reply = {.qdd = qdd};
        if (tfa_dds_client_call(a->client, &request, &reply, WAIT_NS, NULL) != TFA_OK)
            a->error = "a request was not answered";
        const int model = reply.model == a->tags[0] ? 0 : reply.model == a->tags[1] ? 1 : -1;
        if (model < 0)
            a->error = "a reply names neither model";
        else if (memcmp(qdd, a->expected[model], sizeof qdd) != 0)
            a->error = "a reply is not that of the model it names";
        atomic_store(&a->model, model);
    }
    return NULL;
}

static harness serve(void)
{
    harness h = harness_serve(ARM, dds_yaml(test_domain(), TEST_LEASE_MS));
    dds_herald(test_domain(), "arm");
    return h;
}

static void reload(const harness *h, const char *robots, unsigned times)
{
    harness_reload(h, robots, dds_yaml(test_domain(), TEST_LEASE_MS));
    assert_true(harness_logged_times(h, "reload: done, 1 of 1", times));
}

TEST(same_shape)
{
    static asker a;
    expect(&a);
    SCOPED_HARNESS h = serve();
    a.client = dds_connect(test_domain(), "arm");
    assert_int_equal(pthread_create(&a.thread, NULL, ask, &a), 0);
    for (unsigned i = 1; i <= SWAPS; i++) {
        reload(&h, yaml[i % 2], i);
        assert_true(WAIT_FOR(atomic_load(&a.model) == (int)(i % 2)));
    }
    atomic_store(&a.stop, true);
    pthread_join(a.thread, NULL);
    if (a.error != NULL)
        fail_msg("request %u: %s", a.asked, a.error);
    tfa_dds_client_close(a.client);
}

/* Who connects after the exchange finds the new joints; the stream and calls fit them. */
TEST(other_shape)
{
    double qdd[64];
    const tfa_request request = make_request();
    SCOPED_HARNESS h = serve();
    for (unsigned i = 1; i <= 4; i++) {
        SCOPED_DDS_CLIENT *old = dds_connect(test_domain(), "arm");
        const uint32_t joints = tfa_dds_client_get_info(old)->v_count;
        tfa_reply reply = {.qdd = qdd};
        uint64_t id;
        assert_int_equal(joints, i % 2 ? 7 : 64);
        for (int k = 0; k < 8; k++) /* under way when the change comes */
            assert_int_equal(tfa_dds_client_send(old, &request, &id), TFA_OK);
        reload(&h, i % 2 ? SNAKE : ARM, i);
        for (int k = 0; k < 8; k++) { /* every one is answered, if only by a refusal */
            const int status = tfa_dds_client_receive(old, &reply, WAIT_NS, NULL);
            assert_true(status != TFA_E_TIMEOUT && status != TFA_E_DISCONNECTED);
        }
        SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
        assert_int_equal(tfa_dds_client_get_info(client)->v_count, i % 2 ? 64 : 7);
        assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    }
}
