/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints in JSON lines: what is read, what is refused and how, and the layout of the answers;
 * with the library behind them the bits of the library.
 */
#include "jsonl_line.h"
#include "models.h"
#include "support/closed_dog.h"
#include "test.h"

#include <math.h>

#define CFD "\"op\":\"constrained_dynamics\""
#define IMPACT "\"op\":\"impact\""
#define CID "\"op\":\"constrained_inverse_dynamics\""
#define SIX "[1,2,3,4,5,6]"
#define ROBOT "the robot has 2 constraints (loop, foot)"

static const refusal refused[] = {
    {"{" CFD "," Q ",\"constraints\":\"loop\"}", TFA_E_ARGUMENT,
     "constraints: a string, must be an array of names of constraints"},
    {"{" CFD "," Q ",\"constraints\":[\"loop\",1]}", TFA_E_ARGUMENT,
     "constraints[1]: a number, must be the name of a constraint"},
    {"{" CFD "," Q ",\"constraints\":[\"loop\",\"fot\"]}", TFA_E_ARGUMENT,
     "constraints[1]: no constraint 'fot'; nearest: 'foot', 'loop'; " ROBOT},
    {"{" CFD "," Q ",\"constraints\":[\"foot\",\"foot\"]}", TFA_E_ARGUMENT,
     "constraints[1]: constraint 'foot' twice; name it once"},
    {"{" CFD "," Q ",\"constraint_acceleration\":" SIX "}", TFA_E_ARGUMENT,
     "constraint_acceleration: an array, must be an object {constraint: [6 numbers]}"},
    {"{" CFD "," Q ",\"constraint_acceleration\":{\"hand\":" SIX "}}", TFA_E_ARGUMENT,
     "constraint_acceleration: no constraint 'hand'; nearest: 'loop', 'foot'; " ROBOT},
    {"{" CFD "," Q ",\"constraint_acceleration\":{\"loop\":[1]}}", TFA_E_SIZE,
     "constraint_acceleration.loop: 1 values, must be 6"},
    {"{" CFD "," Q ",\"constraint_acceleration\":{\"loop\":" SIX "},\"constraints\":[\"foot\"]}",
     TFA_E_ARGUMENT, "constraint_acceleration: 'loop' is not active; name it in constraints"},
    {"{" CFD "," Q ",\"stabilisation\":100}", TFA_E_ARGUMENT,
     "stabilisation: a number, must be an array of 2 numbers"},
    {"{" CFD "," Q ",\"stabilisation\":[100]}", TFA_E_SIZE, "stabilisation: 1 values, must be 2"},
    {"{" CFD "," Q ",\"torque_weights\":[1,1,1]}", TFA_E_ARGUMENT,
     "torque_weights: constrained_dynamics does not use it"},
    {"{" CID "," Q ",\"torque_weights\":[1]}", TFA_E_SIZE,
     "torque_weights: 1 values, the robot has 3 joints (pan, lift, slide)"},
    {"{" CID "," Q ",\"want\":[\"delassus\"]}", TFA_E_ARGUMENT,
     "want: constrained_inverse_dynamics does not answer delassus; constrained_dynamics and impact "
     "do"},
    {"{" IMPACT "," Q ",\"constraint_acceleration\":{}}", TFA_E_ARGUMENT,
     "constraint_acceleration: impact does not use it"},
    {"{" FD "," Q ",\"constraints\":[\"loop\"]}", TFA_E_ARGUMENT,
     "constraints: forward_dynamics does not use it"},
};

TEST(refusals)
{
    REFUSE(&closed, refused);
    refuse(&arm, "{" CFD "," Q ",\"constraints\":[\"loop\"]}", TFA_E_ARGUMENT,
           "constraints[0]: no constraint 'loop'; the robot has no constraints; `constraints` of "
           "its scene give it some");
}

TEST(too_many)
{
    tfa_names names;
    tfa_client_info wrong = closed;
    wrong.constraint_count = TFA_MAX_CONSTRAINTS + 1;
    assert_int_equal(tfa_names_of_info(&names, "robot", &wrong), TFA_E_PROTOCOL);
}

/* Absent, all are active; accelerations and weights that an object leaves out are 0 and 1. */
TEST(defaults)
{
    static const double accelerations[12] = {0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6},
                        weights[] = {1, 3, 1}, gains[] = {7, 8};
    reading r;
    read_good(&r, &closed,
              "{" CID "," Q ",\"constraint_acceleration\":{\"foot\":" SIX "},"
              "\"torque_weights\":{\"lift\":3},\"stabilisation\":[7,8]}");
    assert_int_equal(r.request.op, TFA_OP_CONSTRAINED_INVERSE_DYNAMICS);
    assert_int_equal(r.request.constraints, 3);
    assert_memory_equal(r.request.constraint_acceleration, accelerations, sizeof accelerations);
    assert_memory_equal(r.request.torque_weights, weights, sizeof weights);
    assert_memory_equal(r.request.stabilisation, gains, sizeof gains);
    assert_non_null(r.reply.tau);
    assert_non_null(r.reply.constraint_wrenches);
    assert_non_null(r.reply.rank);
    assert_null(r.reply.lost);
    assert_null(r.reply.delassus);
    forget(&r);
    read_good(&r, &closed, "{" IMPACT "," Q "}");
    assert_int_equal(r.request.constraints, 3);
    assert_null(r.request.constraint_acceleration);
    assert_null(r.request.stabilisation);
    assert_null(r.request.torque_weights);
    assert_non_null(r.reply.v);
    assert_null(r.reply.base_twist);
    assert_non_null(r.reply.lost);
    forget(&r);
}

#define ONE "[1.0,2.0,3.0,4.0,5.0,6.0]"
#define NONE "[0.0,0.0,0.0,0.0,0.0,0.0]"

TEST(reply_of_active_constraints)
{
    reading r;
    read_good(&r, &closed, "{" CFD "," Q ",\"constraints\":[\"foot\"]}");
    assert_int_equal(r.request.constraints, 2);
    count_up(r.reply.qdd, 3);
    count_up(r.reply.constraint_wrenches, 6);
    *r.reply.rank = (tfa_rank){.rank = 5, .lost = 1, .condition = (double)INFINITY};
    count_up(r.reply.lost, 8);
    r.reply.answers->flags = TFA_ANSWER_PULLS | TFA_ANSWER_RANK_LOSS;
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\",\"qdd\":[1.0,2.0,3.0],\"rank\":5,"
               "\"threshold\":0.0,\"condition\":null,\"length\":0.0,\"lambda_error_estimate\":0.0,"
               "\"lost\":[{\"singular_value\":1.0,\"given_up\":2.0,"
               "\"direction\":{\"foot\":[3.0,4.0,5.0,6.0,7.0,8.0]}}],"
               "\"constraint_wrenches\":{\"foot\":" ONE "},\"constraint_residual\":{\"foot\":" NONE
               "},\"constraint_position\":{\"foot\":" NONE
               "},\"constraint_velocity\":{\"foot\":" NONE "},\"pulls\":true}\n");
}

/* Without directions that were lost, though some were */
TEST(reply_of_inverse_dynamics)
{
    reading r;
    read_good(&r, &closed, "{" CID "," Q "}");
    *r.reply.rank = (tfa_rank){.rank = 10, .lost = 2};
    char *text = print_line(&r);
    assert_non_null(strstr(text, "\"tau\":[0.0,0.0,0.0],\"rank\":10,"));
    assert_non_null(strstr(text, "\"constraint_wrenches\":{\"loop\":" NONE ",\"foot\":" NONE "}"));
    assert_null(strstr(text, "lost"));
    assert_null(strstr(text, "pulls"));
    free(text);
    forget(&r);
}

TEST(explanations)
{
    static const struct {
        const char *line;
        tfa_reply reply;
        const char *text;
    } rows[] = {
        {"{" CFD "," Q ",\"constraints\":[]}",
         {.status = TFA_E_SIZE, .field = TFA_FIELD_CONSTRAINTS},
         "constraints: none active; " ROBOT},
        {"{" CFD "," Q "}",
         {.status = TFA_E_ARGUMENT, .field = TFA_FIELD_CONSTRAINTS, .index = 4},
         "constraints: bit 4 is set, " ROBOT},
        {"{" CFD "," Q ",\"rank_loss\":\"refuse\"}",
         {.status = TFA_E_RANK, .field = TFA_FIELD_CONSTRAINTS, .index = 7},
         "constraints: rows of loop, foot depend on each other, rank 7 here; "
         "\"rank_loss\":\"truncate\" or \"damp\" answers"},
        {"{" CFD "," Q "}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_CONSTRAINTS, .index = 1},
         "constraints: 2 active; of them, and of their links, there is memory for 1 (max_tips)"},
        {"{" CFD "," Q ",\"constraint_acceleration\":{\"foot\":" SIX "}}",
         {.status = TFA_E_VALUE, .field = TFA_FIELD_CONSTRAINT_ACCELERATION, .index = 8},
         "constraint_acceleration[2] (foot): 3: not a finite number"},
        {"{" CFD "," Q ",\"stabilisation\":[4,-1]}",
         {.status = TFA_E_ARGUMENT, .field = TFA_FIELD_STABILISATION, .index = 1},
         "stabilisation[1]: -1: must not be negative"},
        {"{" CID "," Q ",\"torque_weights\":[1,0,1]}",
         {.status = TFA_E_ARGUMENT, .field = TFA_FIELD_TORQUE_WEIGHTS, .index = 1},
         "torque_weights[1] (lift): 0: must be above 0"},
        {"{" CFD "," Q "}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_COST, .index = 900, .state = 100},
         "cost: a state of this kind (constrained_dynamics by auto with 2 constraints) takes about "
         "900 us, the daemon admits 100 us; ask for less, or raise max_state_us in its "
         "configuration"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        explain(&closed, rows[k].line, &rows[k].reply, rows[k].text);
}

/* ---- with the library ---- */

#define REST ",\"q\":[0,0.8,-1.6,0,0.8,-1.6,0,0.8,-1.6,0.1,0.7,-1.5]," POSE

/* Numbers of a vector, or of all in an object */
static size_t read_numbers(const json_t *value, double *out)
{
    const char *name;
    json_t *entry;
    size_t count = 0;
    if (json_is_array(value))
        for (size_t k = 0; k < json_array_size(value); k++)
            out[count++] = json_real_value(json_array_get(value, k));
    else
        json_object_foreach((json_t *)value, name, entry) count += read_numbers(entry, out + count);
    return count;
}

static void assert_bits(const json_t *answer, const char *key, const double *want, size_t count)
{
    double got[64];
    assert_int_equal(read_numbers(json_object_get(answer, key), got), count);
    assert_memory_equal(got, want, count * sizeof *want);
}

TEST(bits_of_the_library)
{
    static const char *const lines[] = {
        "{" CFD REST ",\"tau\":[1,2,3,4,5,6,7,8,9,10,11,12],\"stabilisation\":[100,20],"
        "\"constraint_acceleration\":{\"rod\":[0.1,0.2,0.3,0,0,0]}}",
        "{" IMPACT REST ",\"base_twist\":" SIX ",\"constraints\":[\"stand\"]}",
        "{" CID REST ",\"qdd\":{\"FL_calf_joint\":1}}",
    };
    SCOPED_MODEL *model = bundled_model("quadruped.urdf", &closed_dog);
    SCOPED_WORKSPACE *workspace = workspace_for(model, NULL);
    for (size_t k = 0; k < sizeof lines / sizeof *lines; k++) {
        const jsonl_defaults options = JSONL_DEFAULTS;
        reading r = {0};
        double wrenches[12], residual[12], joints[12];
        assert_int_equal(tfa_names_of_model(&r.names, model), TFA_OK);
        assert_int_equal(jsonl_buffers_init(&r.buffers, &r.names), TFA_OK);
        assert_int_equal(jsonl_load(lines[k], strlen(lines[k]), 1, &r.object, &r.error), TFA_OK);
        assert_int_equal(
            jsonl_read(r.object, &r.names, &options, &r.buffers, &r.request, &r.reply, &r.error),
            TFA_OK);
        assert_int_equal(tfa_compute(workspace, &r.request, &r.reply), TFA_OK);
        char *text = print_line(&r);
        json_t *answer = json_loads(text, 0, NULL);
        tfa_reply reply = {.constraint_wrenches = wrenches, .constraint_residual = residual};
        *(k == 0 ? &reply.qdd : k == 1 ? &reply.v : &reply.tau) = joints;
        assert_int_equal(tfa_compute(workspace, &r.request, &reply), TFA_OK);
        const size_t count = k == 1 ? 6 : 12;
        assert_bits(answer, "constraint_wrenches", wrenches, count);
        assert_bits(answer, "constraint_residual", residual, count);
        assert_bits(answer, k == 0 ? "qdd" : k == 1 ? "v" : "tau", joints, 12);
        json_decref(answer);
        free(text);
        forget(&r);
    }
}
