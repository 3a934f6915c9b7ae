/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where a method fails, through the real daemon: its answer is that of the library to the bit,
 * comes from whom and for the reason that the table says, is right, and the daemon is well
 * afterwards.
 */
#include "failures_table.h"
#include "fixture.h"
#include "harness.h"
#include "models.h"
#include "test.h"

#include <signal.h>
#include <sys/wait.h>

/* The files and the configuration: a robot for each row. */
static char *write_robots(const char *directory)
{
    static const char *const precisions[] = {
        [TFA_F64] = "f64", [TFA_F128] = "f128", [TFA_F32] = "f32"};
    static const char *const residuals[] = {"same", "f64", "f128"};
    char *yaml = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&yaml, &size);
    assert_non_null(out);
    fputs(ARM, out);
    for (uint32_t k = 0; k < failure_count; k++) {
        char path[128];
        const mechanism_options o = failure_mechanism(&failures[k]);
        snprintf(path, sizeof path, "%s/r%u.urdf", directory, (unsigned)k);
        FILE *urdf = fopen(path, "w");
        assert_non_null(urdf);
        mechanism_write(&o, urdf);
        assert_int_equal(fclose(urdf), 0);
        fprintf(out, "  - name: r%u\n    urdf: %s\n    precision: %s\n    residual: %s\n",
                (unsigned)k, path, precisions[failures[k].precision],
                residuals[failures[k].residual]);
    }
    assert_int_equal(fclose(out), 0);
    return yaml;
}

static void in_process(const failure *row, const hard_robot *robot, tfa_reply *reply)
{
    const tfa_workspace_options options = {.precision = row->precision, .residual = row->residual};
    const tfa_request r = failure_by_default(row, robot);
    SCOPED_WORKSPACE *w = workspace_for(robot->model, &options);
    assert_int_equal(tfa_compute(w, &r, reply), TFA_OK);
}

static void compare(const harness *h, uint32_t k)
{
    static hard_robot robot;
    const failure *row = &failures[k];
    double want[HARD_ROBOT_FREEDOMS], got[HARD_ROBOT_FREEDOMS], own[HARD_ROBOT_FREEDOMS];
    tfa_answer answer, specialised_answer;
    tfa_reply reply = failure_reply(row, got, &answer);
    tfa_reply own_reply = failure_reply(row, own, &specialised_answer);
    char name[16];
    snprintf(name, sizeof name, "r%u", (unsigned)k);
    failure_open(row, &robot);
    const uint32_t count = failure_truth(row, &robot, want);
    in_process(row, &robot, &own_reply);
    tfa_client *client = harness_connect(h, name, TFA_WAIT_DEFAULT);
    const tfa_request r = failure_by_default(row, &robot);
    assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, NULL), TFA_OK);
    tfa_client_close(client);
    failure_check(row, &reply, got, want, count, tfa_method_name((uint32_t)row->method));
    assert_memory_equal(got, own, count * sizeof *got);
    assert_memory_equal(&answer, &specialised_answer, sizeof answer);
    assert_int_equal(reply.model, own_reply.model);
    hard_robot_close(&robot);
}

/* An ordinary request, as the library answers it. */
static void ordinary(const harness *h)
{
    double got[7];
    SCOPED_CLIENT *client = harness_connect(h, "arm", TFA_WAIT_DEFAULT);
    static double first[7];
    assert_int_equal(ask_arm(client, 0.3, got, WAIT_NS), TFA_OK);
    if (first[0] == 0)
        memcpy(first, got, sizeof first);
    assert_memory_equal(first, got, sizeof got);
}

TEST(the_daemon_answers_where_methods_fail)
{
    SCOPED_HARNESS h = harness_make(ARM, "");
    char *yaml = write_robots(h.directory);
    harness_configure(&h, yaml, "");
    free(yaml);
    harness_start(&h, "arm");
    ordinary(&h);
    for (uint32_t k = 0; k < failure_count; k++) {
        compare(&h, k);
        ordinary(&h);
    }
}

/* A tip without mass: the daemon does not start, and names the joint. */
TEST(a_massless_tip_is_refused)
{
    SCOPED_HARNESS h = harness_make(ARM "  - name: m\n    urdf: massless.urdf\n", "");
    harness_write(&h, "massless.urdf",
                  "<robot name=\"m\"><link name=\"base\"/><link name=\"tip\"/>"
                  "<joint name=\"wrist\" type=\"continuous\"><parent link=\"base\"/>"
                  "<child link=\"tip\"/><axis xyz=\"0 0 1\"/></joint></robot>");
    harness_assert_refused(&h, "joint 'wrist': nothing with mass moves with it");
}
