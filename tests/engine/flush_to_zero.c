/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Subnormal numbers count as zero in every method, state of a batch and thread of a pool, and the
 * caller's floating-point mode is as before.
 */
#include "models.h"
#include "random_robot.h"
#include "test.h"

#include <float.h>
#include <totalforce/totalforce.h>

enum { BODIES = 256, STATES = 9, THREADS = 3 };

static volatile double least_normal = DBL_MIN;

/* Torques below the normal numbers, without gravity: they accelerate nothing. */
static void assert_zero(tfa_workspace *w, tfa_batch_pool *pool, tfa_method method, uint32_t states)
{
    static double zeros[STATES * BODIES], tau[STATES * BODIES], qdd[STATES * BODIES];
    tfa_answer answers[STATES];
    const double none[3] = {0};
    for (int k = 0; k < STATES * BODIES; k++) {
        tau[k] = DBL_MIN / 4;
        qdd[k] = 1;
    }
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .method = method,
                           .count = states,
                           .refine = TFA_REFINE_DEFAULT,
                           .q = zeros,
                           .v = zeros,
                           .tau = tau,
                           .gravity = none};
    tfa_reply reply = {.qdd = qdd, .answers = answers};
    const int status = pool ? tfa_batch_pool_compute(pool, &r, &reply) : tfa_compute(w, &r, &reply);
    if (status == TFA_E_UNSUPPORTED && method == TFA_METHOD_HESSENBERG)
        return; /* of so long a chain */
    assert_int_equal(status, TFA_OK);
    for (uint32_t k = 0; k < states * BODIES; k++)
        assert_true(qdd[k] == 0);
    assert_true(least_normal / 2 > 0);
}

TEST(subnormal_numbers_count_as_zero)
{
    const random_robot_options chain = {.shape = RANDOM_CHAIN, .joints = BODIES};
    const tfa_batch_pool_options options = {.threads = THREADS};
    tfa_description *description = random_robot_create(1, &chain);
    SCOPED_MODEL *model = compiled(description, NULL);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    tfa_batch_pool *pool = NULL;
    assert_int_equal(tfa_batch_pool_create(model, &options, &pool), TFA_OK);
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        if (!(tfa_method_describe(m)->ops & TFA_OP_BIT(TFA_OP_FORWARD_DYNAMICS)))
            continue;
        for (uint32_t states = 1; states <= STATES; states += STATES - 1) {
            assert_zero(w, NULL, (tfa_method)m, states);
            assert_zero(w, NULL, (tfa_method)m, states); /* of the same form */
            assert_zero(w, pool, (tfa_method)m, states);
        }
    }
    tfa_batch_pool_free(pool);
    random_robot_free(description);
}

int main(void)
{
    return test_run(NULL, NULL);
}
