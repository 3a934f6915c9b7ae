/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Through the daemon and in process: the same bits, the same refusals, for every op.
 */
#include "harness.h"
#include "models.h"
#include "support/any_request.h"
#include "support/closed_dog.h"
#include "test.h"

static const struct {
    const char *name, *file;
    tfa_model_options options;
    unsigned step; /* of the requests: large robots take every one so often */
} robots[] = {
    {"arm", "arm7.urdf", {.base = TFA_BASE_FIXED}, 1},
    {"dog", "quadruped.urdf", {.base = TFA_BASE_FLOATING}, 3},
    {"dog.closed", "quadruped.urdf", {.base = TFA_BASE_FLOATING, .scene = &closed_dog_scene}, 3},
    {"man", "humanoid.urdf", {.base = TFA_BASE_FLOATING}, 23},
    {"snake", "snake64.urdf", {.base = TFA_BASE_FIXED}, 23},
};

#define YAML                                                                                       \
    ARM "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n    base: "                      \
        "floating\n" CLOSED_DOG_YAML                                                               \
        "  - name: man\n    urdf: @/config/robots/humanoid.urdf\n    base: floating\n"             \
        "    wait: block\n"                                                                        \
        "  - name: snake\n    urdf: @/config/robots/snake64.urdf\n    wait: spin\n"

static int call(void *client, const tfa_request *request, tfa_reply *reply, uint64_t timeout_ns,
                tfa_exchange *x)
{
    const int status = tfa_client_call(client, request, reply, timeout_ns, x);
    assert_true(x->t_sent <= x->t_received && x->t_received <= x->t_start &&
                x->t_start <= x->t_done && x->t_done <= x->t_reply);
    assert_true((x->t_sent != 0) == (reply->model != 0));
    return status;
}

TEST(same_bits)
{
    static const char *const settings[] = {"", "backend: memfd\nworkers: 2\n"};
    for (int i = 0; i < 2; i++) {
        SCOPED_HARNESS h = harness_serve(YAML, settings[i]);
        for (size_t k = 0; k < sizeof robots / sizeof *robots; k++) {
            SCOPED_MODEL *model = bundled_model(robots[k].file, &robots[k].options);
            SCOPED_WORKSPACE *library = workspace_for(model, NULL);
            tfa_client_options options = harness_options(&h, robots[k].name);
            options.max_batch = ANY_BATCH;
            options.slots = 2;
            SCOPED_CLIENT *client = harness_connect_with(&options);
            const any_client c = {robots[k].name, call, client, tfa_client_get_info(client),
                                  library,        false};
            any_check_info(c.info, model);
            any_compare_all(&c, robots[k].step);
            any_compare_mistakes(&c);
        }
    }
}
