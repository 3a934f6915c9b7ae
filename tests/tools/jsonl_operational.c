/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operational space in JSON lines without a solver: wanted answers, rows, ranks, accelerations of
 * tips; the exact sentence for each line that is refused; the layout of every answer.
 */
#include "jsonl_line.h"
#include "test.h"

#include <math.h>

#define KIN "\"op\":\"kinematics\""
#define BIAS "\"op\":\"bias\""
#define TASK "\"op\":\"task_torques\""
#define DER "\"op\":\"derivatives\""
#define TOOL "\"tips\":[\"tool\"]"
#define SIX "[1,2,3,4,5,6]"
#define WORDS                                                                                      \
    "there are jacobian, bias_acceleration, twist, pose, poses, com, momentum, energy, "           \
    "generalised_momentum, lambda, "                                                               \
    "mu, p, spectrum, joint_forces, delassus"

static const refusal refused[] = {
    {"{" KIN "," Q ",\"want\":\"com\"}", TFA_E_ARGUMENT,
     "want: a string, must be an array of words, for instance [\"jacobian\"]"},
    {"{" KIN "," Q ",\"want\":[\"com\",7]}", TFA_E_ARGUMENT, "want[1]: a number, must be a string"},
    {"{" KIN "," Q ",\"want\":[\"com\",\"jacobain\"]}", TFA_E_ARGUMENT,
     "want[1]: no 'jacobain'; nearest: 'jacobian', 'com', 'lambda'; " WORDS},
    {"{" KIN "," Q ",\"want\":[\"twist\"]}", TFA_E_ARGUMENT, "tips: missing; 1 to 32 link names"},
    {"{" FD "," Q ",\"want\":[\"lambda\"]}", TFA_E_ARGUMENT, "tips: missing; 1 to 32 link names"},
    {"{" BIAS "," Q "," TOOL ",\"want\":[\"lambda\",\"mu\",\"p\"]}", TFA_E_ARGUMENT,
     "want: bias does not answer lambda, mu or p; forward_dynamics, operational_inertia and "
     "task_torques do"},
    {"{" KIN "," Q "," TOOL ",\"want\":[\"spectrum\"]}", TFA_E_ARGUMENT,
     "want: kinematics does not answer spectrum; forward_dynamics, operational_inertia and "
     "task_torques do"},
    {"{" KIN "," Q "," TOOL "}", TFA_E_ARGUMENT,
     "tips: kinematics does not use it unless want has jacobian, bias_acceleration, twist or pose"},
    {"{" OI "," Q "," TOOL ",\"want\":[\"lambda\"],\"wrench\":{}}", TFA_E_ARGUMENT,
     "wrench: operational_inertia does not use it unless want has "
     "generalised_momentum or mu"},
    {"{" KIN "," Q ",\"want\":[\"pose\"]," TOOL ",\"poses\":true}", TFA_E_ARGUMENT,
     "poses: kinematics does not use it"},
    {"{" FD "," Q ",\"want\":[\"poses\"]," TOOL ",\"poses\":true}", TFA_E_ARGUMENT,
     "poses: leave it out: want has \"pose\" for the tips and \"poses\" for all links"},
    {"{" OI "," Q "," TOOL ",\"rows\":\"line\"}", TFA_E_ARGUMENT,
     "rows: no 'line'; there are pose, point"},
    {"{" OI "," Q "," TOOL ",\"rows\":3}", TFA_E_ARGUMENT, "rows: a number, must be a string"},
    {"{" OI "," Q "," TOOL ",\"rank_loss\":\"damp\"}", TFA_E_ARGUMENT,
     "rank_loss: operational_inertia does not use it unless want has lambda, mu or p"},
    {"{" TASK "," Q ",\"rank_loss\":\"ignore\",\"acceleration\":{\"tool\":" SIX "}}",
     TFA_E_ARGUMENT, "rank_loss: no 'ignore'; there are default, truncate, damp, refuse"},
    {"{" TASK "," Q ",\"rank_threshold\":\"1e-6\",\"acceleration\":{\"tool\":" SIX "}}",
     TFA_E_ARGUMENT, "rank_threshold: a string, must be a number"},
    {"{" TASK "," Q ",\"rank_threshold\":1,\"acceleration\":{\"tool\":" SIX "}}", TFA_E_ARGUMENT,
     "rank_threshold: 1, must be above 0 and below 1: relative to the sum of the eigenvalues "
     "of lambda_inv"},
    {"{" TASK "," Q ",\"rank_threshold\":0,\"acceleration\":{\"tool\":" SIX "}}", TFA_E_ARGUMENT,
     "rank_threshold: 0, must be above 0 and below 1: relative to the sum of the eigenvalues "
     "of lambda_inv"},
    {"{" TASK "," Q "}", TFA_E_ARGUMENT,
     "acceleration: missing; an object {tip: [6 numbers, of a point 3]}"},
    {"{" TASK "," Q ",\"acceleration\":" SIX "}", TFA_E_ARGUMENT,
     "acceleration: an array, must be an object {tip: [6 or 3 numbers]}"},
    {"{" TASK "," Q ",\"acceleration\":{}}", TFA_E_SIZE, "acceleration: 0 tips, must be 1 to 32"},
    {"{" TASK "," Q ",\"acceleration\":{\"hand\":" SIX "}}", TFA_E_LINK,
     "acceleration: no link 'hand' in the robot; nearest: 'base', 'tool', 'upper'"},
    {"{" TASK "," Q ",\"acceleration\":{\"tool\":[1,2]}}", TFA_E_SIZE,
     "acceleration.tool: 2 values, must be 6"},
    {"{" TASK "," Q ",\"rows\":\"point\",\"acceleration\":{\"tool\":" SIX "}}", TFA_E_SIZE,
     "acceleration.tool: 6 values, must be 3"},
    {"{" TASK "," Q ",\"acceleration\":{\"tool\":[1,2,3],\"base\":" SIX "}}", TFA_E_SIZE,
     "acceleration.base: 6 values, must be 3"},
    {"{" TASK "," Q ",\"acceleration\":{\"tool\":[1,2,null]}}", TFA_E_ARGUMENT,
     "acceleration.tool[2]: null, must be a number"},
    {"{" TASK "," Q "," TOOL ",\"acceleration\":{\"lower\":" SIX "}}", TFA_E_LINK,
     "acceleration: 'lower' is not in tips; leave tips out, or name the same links in both"},
    {"{" TASK "," Q ",\"tips\":[\"tool\",\"tool\"],\"acceleration\":{\"tool\":" SIX "}}",
     TFA_E_SIZE,
     "acceleration: 1 links for 2 tips; leave tips out, or name the same links in both, each once"},
    {"{" TASK "," Q ",\"posture_torques\":[1],\"acceleration\":{\"tool\":" SIX "}}", TFA_E_SIZE,
     "posture_torques: 1 values, the robot has 3 joints (pan, lift, slide)"},
    {"{" TASK "," Q ",\"tau\":[1,2,3],\"acceleration\":{\"tool\":" SIX "}}", TFA_E_ARGUMENT,
     "tau: task_torques does not use it"},
    {"{" FD "," Q ",\"acceleration\":{\"tool\":" SIX "}}", TFA_E_ARGUMENT,
     "acceleration: forward_dynamics does not use it"},
};

TEST(test_refusals)
{
    REFUSE(&arm, refused);
}

TEST(test_wanted)
{
    reading r;
    read_good(
        &r, &arm,
        "{" FD "," Q ",\"tips\":[\"tool\",\"lower\"],\"rows\":\"point\",\"rank_loss\":\"damp\","
        "\"rank_threshold\":1e-3,\"want\":[\"jacobian\",\"bias_acceleration\",\"twist\",\"pose\","
        "\"poses\",\"com\",\"momentum\",\"energy\",\"generalised_momentum\",\"lambda\",\"mu\","
        "\"p\",\"spectrum\",\"joint_forces\",\"p\"]}");
    const tfa_request *q = &r.request;
    assert_int_equal(q->flags, TFA_WANT_ALL & ~TFA_WANT_DELASSUS);
    assert_int_equal(q->rows, TFA_ROWS_POINT);
    assert_int_equal(q->rank_loss, TFA_RANK_DAMP);
    assert_true(q->rank_threshold && *q->rank_threshold == 1e-3);
    const tfa_reply *reply = &r.reply;
    const double *const given[] = {
        reply->qdd,          reply->lambda_inv,  reply->lambda,
        reply->mu,           reply->p,           reply->poses,
        reply->twists,       reply->frame_poses, reply->jacobian,
        reply->com,          reply->mass,        reply->bias_acceleration,
        reply->com_velocity, reply->momentum,    reply->energy,
        reply->com_jacobian, reply->joint_forces};
    const double *const absent[] = {
        reply->tau,           reply->base_acceleration, reply->base_wrench,    reply->mass_matrix,
        reply->gravity_force, reply->velocity_force,    reply->armature_force, reply->dqdd_dq,
    };
    for (size_t i = 0; i < sizeof given / sizeof given[0]; i++)
        assert_non_null(given[i]);
    for (size_t i = 0; i < sizeof absent / sizeof absent[0]; i++)
        assert_null(absent[i]);
    assert_non_null(reply->rank);
    assert_non_null(reply->spectrum);
    forget(&r);
}

/* The spectrum comes unasked where a request has no `want`. */
TEST(test_spectrum)
{
    static const struct {
        const char *line;
        uint32_t flags;
    } rows[] = {
        {"{" OI "," Q "," TOOL "}", TFA_WANT_SPECTRUM},
        {"{" FD "," Q "," TOOL "}", TFA_WANT_SPECTRUM},
        {"{" FD "," Q "," TOOL ",\"poses\":true}", TFA_WANT_SPECTRUM | TFA_WANT_POSES},
        {"{" FD "," Q "," TOOL ",\"want\":[]}", 0},
        {"{" FD "," Q "," TOOL ",\"want\":[\"com\"]}", TFA_WANT_COM},
        {"{" FD "," Q "}", 0},
        {"{" TASK "," Q ",\"acceleration\":{\"tool\":" SIX "}}", 0},
        {"{" ID "," Q "," TOOL ",\"want\":[\"pose\"]}", TFA_WANT_POSES},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        reading r;
        read_good(&r, &arm, rows[i].line);
        assert_int_equal(r.request.flags, rows[i].flags);
        assert_true(!r.reply.spectrum == !(rows[i].flags & TFA_WANT_SPECTRUM));
        forget(&r);
    }
}

TEST(test_task)
{
    static const double accelerations[] = {1, 2, 3, 4, 5, 6};
    reading r;
    read_good(&r, &ship,
              "{" TASK ",\"acceleration\":{\"crate\":[1,2,3],\"sail\":[4,5,6]},\"q\":{}," POSE
              ",\"posture_torques\":{\"mast\":7},\"base_wrench\":" SIX ",\"method\":\"crba\"}");
    assert_int_equal(r.request.op, TFA_OP_TASK_TORQUES);
    assert_int_equal(r.request.method, TFA_METHOD_CRBA);
    assert_int_equal(r.request.rows, TFA_ROWS_POINT);
    assert_int_equal(r.request.tip_count, 2);
    assert_int_equal(r.request.tips[0], 2);
    assert_int_equal(r.request.tips[1], 1);
    assert_memory_equal(r.request.task_acceleration, accelerations, sizeof accelerations);
    assert_true(r.request.tau[0] == 7 && r.request.tau[9] == 0);
    assert_true(r.request.base_wrench[5] == 6);
    assert_null(r.request.rank_threshold);
    assert_non_null(r.reply.tau);
    assert_non_null(r.reply.base_wrench);
    assert_non_null(r.reply.lambda_inv);
    assert_non_null(r.reply.rank);
    forget(&r);
}

/* With tips, their order holds. */
TEST(test_task_with_tips)
{
    static const double accelerations[] = {7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6};
    reading r;
    read_good(&r, &arm,
              "{" TASK "," Q ",\"tips\":[\"lower\",\"tool\"],"
              "\"acceleration\":{\"tool\":" SIX ",\"lower\":[7,8,9,10,11,12]}}");
    assert_int_equal(r.request.tips[0], 2);
    assert_int_equal(r.request.tips[1], 3);
    assert_memory_equal(r.request.task_acceleration, accelerations, sizeof accelerations);
    forget(&r);
}

TEST(test_motion_reply)
{
    reading r;
    read_good(&r, &arm,
              "{" KIN "," Q "," TOOL
              ",\"rows\":\"point\",\"want\":[\"jacobian\",\"bias_acceleration\","
              "\"twist\",\"pose\",\"poses\",\"com\",\"momentum\",\"energy\"]}");
    count_up(r.reply.poses, 7);
    count_up(r.reply.twists, 6);
    count_up(r.reply.jacobian, 9);
    count_up(r.reply.bias_acceleration, 3);
    count_up(r.reply.frame_poses, 28);
    count_up(r.reply.com, 3);
    count_up(r.reply.com_jacobian, 9);
    count_up(r.reply.mass, 1);
    count_up(r.reply.momentum, 6);
    count_up(r.reply.energy, 2);
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\","
               "\"pose\":[[1.0,2.0,3.0,4.0,5.0,6.0,7.0]],"
               "\"twist\":[[1.0,2.0,3.0,4.0,5.0,6.0]],"
               "\"jacobian\":[[1.0,2.0,3.0],[4.0,5.0,6.0],[7.0,8.0,9.0]],"
               "\"bias_acceleration\":[1.0,2.0,3.0],"
               "\"poses\":{\"base\":[1.0,2.0,3.0,4.0,5.0,6.0,7.0],"
               "\"upper\":[8.0,9.0,10.0,11.0,12.0,13.0,14.0],"
               "\"lower\":[15.0,16.0,17.0,18.0,19.0,20.0,21.0],"
               "\"tool\":[22.0,23.0,24.0,25.0,26.0,27.0,28.0]},"
               "\"com\":[1.0,2.0,3.0],\"com_velocity\":[0.0,0.0,0.0],"
               "\"com_jacobian\":[[1.0,2.0,3.0],[4.0,5.0,6.0],[7.0,8.0,9.0]],\"mass\":1.0,"
               "\"momentum\":[1.0,2.0,3.0,4.0,5.0,6.0],"
               "\"energy\":{\"kinetic\":1.0,\"potential\":2.0}}\n");
}

#define TEN "[7.0,8.0,9.0,10.0,11.0,12.0,13.0,14.0,15.0,16.0]"
#define BASE_SIX "[1.0,2.0,3.0,4.0,5.0,6.0]"
#define ZEROS_TEN "[0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0]"
#define ZEROS_SIX "[0.0,0.0,0.0,0.0,0.0,0.0]"

/* Forces of a floating base have a key of their own. */
TEST(test_bias_reply)
{
    reading r;
    read_good(&r, &arm, "{" BIAS "," Q "}");
    count_up(r.reply.gravity_force, 3);
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\",\"gravity\":[1.0,2.0,3.0],"
               "\"velocity\":[0.0,0.0,0.0],\"damping\":[0.0,0.0,0.0],\"friction\":[0.0,0.0,0.0],"
               "\"external\":[0.0,0.0,0.0]}\n");
    read_good(&r, &ship, "{" BIAS ",\"q\":{},\"base_acceleration\":" SIX "," POSE "}");
    count_up(r.reply.gravity_force, 16);
    count_up(r.reply.armature_force, 16);
    prints(&r,
           "{\"status\":\"ok\",\"method\":\"auto\",\"gravity\":" TEN ",\"base_gravity\":" BASE_SIX
           ",\"velocity\":" ZEROS_TEN ",\"base_velocity\":" ZEROS_SIX ",\"damping\":" ZEROS_TEN
           ",\"base_damping\":" ZEROS_SIX ",\"friction\":" ZEROS_TEN ",\"base_friction\":" ZEROS_SIX
           ",\"external\":" ZEROS_TEN ",\"base_external\":" ZEROS_SIX ",\"armature\":" TEN
           ",\"base_armature\":" BASE_SIX "}\n");
}

/* What is infinite or no number is null. */
TEST(test_task_reply)
{
    reading r;
    read_good(&r, &arm,
              "{" TASK "," Q ",\"acceleration\":{\"tool\":[0,0,1]},"
              "\"want\":[\"lambda\",\"mu\",\"p\",\"spectrum\"]}");
    count_up(r.reply.tau, 3);
    count_up(r.reply.lambda_inv, 9);
    count_up(r.reply.mu, 3);
    *r.reply.rank = (tfa_rank){.rank = 2,
                                  .threshold = 0.5,
                                  .condition = (double)INFINITY,
                                  .length = 0.25,
                                  .error_estimate = 0.125};
    *r.reply.spectrum = (tfa_spectrum){.rank = 3, .eig_min = (double)NAN, .eig_max = 8};
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\",\"tau\":[1.0,2.0,3.0],"
               "\"lambda_inv\":[[1.0,2.0,3.0],[4.0,5.0,6.0],[7.0,8.0,9.0]],"
               "\"rank\":2,\"threshold\":0.5,\"condition\":null,\"length\":0.25,"
               "\"lambda_error_estimate\":0.125,\"eig_min\":null,\"eig_max\":8.0,"
               "\"lambda\":[[0.0,0.0,0.0],[0.0,0.0,0.0],[0.0,0.0,0.0]],"
               "\"mu\":[1.0,2.0,3.0],\"p\":[0.0,0.0,0.0]}\n");
}

TEST(test_derivatives_reply)
{
    reading r;
    read_good(&r, &arm, "{" DER "," Q ",\"tau\":[1,2,3]}");
    assert_true(r.request.tau[2] == 3);
    count_up(r.reply.dqdd_dq, 9);
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\","
               "\"dqdd_dq\":[[1.0,2.0,3.0],[4.0,5.0,6.0],[7.0,8.0,9.0]],"
               "\"dqdd_dv\":[[0.0,0.0,0.0],[0.0,0.0,0.0],[0.0,0.0,0.0]],"
               "\"dqdd_dtau\":[[0.0,0.0,0.0],[0.0,0.0,0.0],[0.0,0.0,0.0]]}\n");
}

/* Buffers grow with the request and serve smaller ones. */
TEST(test_buffers_grow)
{
    static const char small[] = "{" OI "," Q "," TOOL ",\"rows\":\"point\"}";
    static const char large[] = "{" OI "," Q ",\"tips\":[\"tool\",\"lower\",\"upper\"]}";
    const char *const lines[] = {small, large, small};
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    reading r;
    read_line(&r, &arm, small, sizeof small - 1);
    for (int i = 0; i < 3; i++) {
        json_decref(r.object);
        assert_int_equal(jsonl_load(lines[i], strlen(lines[i]), 1, &r.object, &r.error), TFA_OK);
        assert_int_equal(
            jsonl_read(r.object, &r.names, &defaults, &r.buffers, &r.request, &r.reply, &r.error),
            TFA_OK);
        count_up(r.reply.lambda_inv, i == 1 ? 18 * 18 : 9);
    }
    forget(&r);
}

TEST(test_explanations)
{
    explain(
        &arm, "{" TASK "," Q ",\"acceleration\":{\"tool\":" SIX "},\"rank_loss\":\"refuse\"}",
        &(tfa_reply){.status = TFA_E_RANK, .field = TFA_FIELD_TIPS, .index = 3},
        "tips: lambda_inv has rank 3 of 6 here; \"rank_loss\":\"truncate\" or \"damp\" answers");
    explain(&arm, "{" OI "," Q ",\"tips\":[\"tool\",\"lower\"]}",
            &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_TIPS, .index = 1},
            "tips: 2 links, there is memory for 1 (max_tips)");
    explain(&arm, "{" TASK "," Q ",\"acceleration\":{\"tool\":" SIX "}}",
            &(tfa_reply){.status = TFA_E_VALUE, .field = TFA_FIELD_TASK_ACCELERATION, .index = 4},
            "acceleration[4]: 5: not a finite number");
    explain(&arm,
            "{" TASK "," Q ",\"acceleration\":{\"tool\":" SIX "},\"posture_torques\":[7,8,9]}",
            &(tfa_reply){.status = TFA_E_VALUE, .field = TFA_FIELD_TAU, .index = 1},
            "posture_torques[1] (lift): 8: not a finite number");
    explain(&arm, "{" KIN "," Q ",\"method\":\"aba\"}",
            &(tfa_reply){.status = TFA_E_METHOD, .field = TFA_FIELD_METHOD},
            "method: aba does not answer kinematics");
}
