/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * JSON lines without a solver: what is read into a request, and the exact sentence for each line
 * that is refused.
 */
#include "jsonl_line.h"
#include "test.h"

#define ONE_LINE "; one request a line, as `jq -c .` writes it"

TEST(test_not_json)
{
    static const struct {
        const char *line, *text;
    } rows[] = {
        {"", "line 1: empty"},
        {"  \t", "line 1: empty"},
        {"hello", "line 1, column 5: invalid token near 'hello'" ONE_LINE},
        {"[1,2]", "line 1: not a JSON object" ONE_LINE},
        {"42", "line 1: not a JSON object" ONE_LINE},
        {"{", "line 1, column 1: string or '}' expected near end of file" ONE_LINE},
        {"  \"op\": \"bias\",", "line 1, column 7: end of file expected near ':'" ONE_LINE},
        {"}", "line 1, column 1: unexpected token near '}'" ONE_LINE},
        {"    0.5,", "line 1, column 8: end of file expected near ','" ONE_LINE},
        {"\xff\xfe{", "line 1: UTF-16, must be UTF-8"},
        {"\xfe\xff", "line 1: UTF-16, must be UTF-8"},
        {"\xef\xbb\xbf", "line 1: empty"},
        {"{\"op\":\"mass_matrix\",\"q\":[0,NaN,0]}", "line 1, column 30: invalid token near 'NaN'"},
        {"{\"q\":[Infinity]}", "line 1, column 14: invalid token near 'Infinity'"},
        {"{\"q\":[1e999]}", "line 1, column 11: real number overflow near '1e999'"},
        {"{\"q\":[0],\"q\":[1]}", "line 1, column 12: duplicate object key near '\"q\"'"},
        {"{\"q\":[0,1", "line 1, column 9: ']' expected near end of file" ONE_LINE},
        {"{} {}", "line 1, column 4: end of file expected near '{'"},
        {"{\"q\":[0x1p3]}", "line 1, column 8: ']' expected near 'x'"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        refuse(&arm, rows[i].line, TFA_E_PARSE, rows[i].text);
}

TEST(test_nul_byte)
{
    static const char line[] = "{\"op\":\"mass\0matrix\"}";
    reading r;
    read_line(&r, &arm, line, sizeof line - 1);
    assert_int_equal(r.status, TFA_E_PARSE);
    assert_string_equal(r.error.text, "line 1, column 11: control character 0x0 near '\"mass'");
    forget(&r);
}

TEST(test_deep_nesting)
{
    enum { DEPTH = 1000000 };
    char *line = malloc(DEPTH);
    reading r;
    assert_non_null(line);
    memset(line, '[', DEPTH);
    read_line(&r, &arm, line, DEPTH - 1);
    assert_int_equal(r.status, TFA_E_PARSE);
    assert_string_equal(r.error.text,
                        "line 1, column 2049: maximum parsing depth reached near '['" ONE_LINE);
    forget(&r);
    free(line);
}

#define EIGHT "\"tool\",\"tool\",\"tool\",\"tool\",\"tool\",\"tool\",\"tool\",\"tool\""

static const refusal refused_by_an_arm[] = {
    {"{" MM "}", TFA_E_ARGUMENT, "q: missing; the robot has 3 joints (pan, lift, slide)"},
    {"{" MM ",\"q\":[0,0]}", TFA_E_SIZE, "q: 2 values, the robot has 3 joints (pan, lift, slide)"},
    {"{" MM ",\"q\":7}", TFA_E_ARGUMENT,
     "q: a number, must be an array in joint order or an object {joint: value}"},
    {"{" MM ",\"q\":[0,\"1\",0]}", TFA_E_ARGUMENT, "q[1] (lift): a string, must be a number"},
    {"{" MM ",\"q\":[0,0,null]}", TFA_E_ARGUMENT, "q[2] (slide): null, must be a number"},
    {"{" MM ",\"q\":{\"pan\":1,\"twist\":2}}", TFA_E_JOINT,
     "q: no moving joint 'twist'; nearest: 'lift', 'slide', 'pan'; the robot has 3 joints (pan, "
     "lift, slide)"},
    {"{" MM ",\"q\":{\"pan\":[1]}}", TFA_E_ARGUMENT, "q.pan: an array, must be a number"},
    {"{" FD "," Q ",\"v\":[0]}", TFA_E_SIZE,
     "v: 1 values, the robot has 3 joints (pan, lift, slide)"},
    {"{" FD "," Q ",\"torque\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'torque'; nearest: 'tau'"},
    {"{" FD "," Q ",\"qd\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'qd'; nearest: 'v'"},
    {"{" FD "," Q ",\"Velocity\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'Velocity'; nearest: 'v'"},
    {"{" FD "," Q ",\"effort\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'effort'; nearest: 'tau'"},
    {"{" ID "," Q ",\"ddq\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'ddq'; nearest: 'qdd'"},
    {"{" ID "," Q ",\"acc\":[0,0,0]}", TFA_E_ARGUMENT,
     "unknown key 'acc'; nearest: 'qdd', 'acceleration'"},
    {"{" FD ",\"position\":[0,0,0]}", TFA_E_ARGUMENT, "unknown key 'position'; nearest: 'q'"},
    {"{" FD "," Q ",\"f_ext\":{}}", TFA_E_ARGUMENT, "unknown key 'f_ext'; nearest: 'wrench'"},
    {"{" MM ",\"q\":[0,0,0,0,0,0,1,0,0,0]}", TFA_E_SIZE,
     "q: 10 values, the robot has 3 joints (pan, lift, slide); a floating base has a field of its "
     "own, base_pose [x,y,z,qx,qy,qz,qw]; this robot's base is fixed"},
    {"{" FD "," Q ",\"count\":2}", TFA_E_ARGUMENT,
     "unknown key 'count'; nearest: 'want', 'op', 'tau'"},
    {"{" ID "," Q ",\"tau\":[0,0,0]}", TFA_E_ARGUMENT, "tau: inverse_dynamics does not use it"},
    {"{" MM "," Q ",\"wrench\":{}}", TFA_E_ARGUMENT, "wrench: mass_matrix does not use it"},
    {"{" FD "," Q ",\"base_pose\":[0,0,0,0,0,0,1]}", TFA_E_ARGUMENT,
     "base_pose: the robot's base is fixed"},
    {"{" OI "," Q "}", TFA_E_ARGUMENT, "tips: missing; 1 to 32 link names"},
    {"{" OI "," Q ",\"tips\":[]}", TFA_E_SIZE, "tips: 0 links, must be 1 to 32"},
    {"{" OI "," Q ",\"tips\":\"tool\"}", TFA_E_ARGUMENT,
     "tips: a string, must be an array of link names"},
    {"{" OI "," Q ",\"tips\":[\"tool\",3]}", TFA_E_ARGUMENT,
     "tips[1]: a number, must be a link name"},
    {"{" OI "," Q ",\"tips\":[\"tool\",\"hand\"]}", TFA_E_LINK,
     "tips[1]: no link 'hand' in the robot; nearest: 'base', 'tool', 'upper'"},
    {"{" OI "," Q ",\"tips\":[" EIGHT "," EIGHT "," EIGHT "," EIGHT ",\"tool\"]}", TFA_E_SIZE,
     "tips: 33 links, must be 1 to 32"},
    {"{" FD "," Q ",\"wrench\":{\"hand\":[0,0,0,0,0,0]}}", TFA_E_LINK,
     "wrench: no link 'hand' in the robot; nearest: 'base', 'tool', 'upper'"},
    {"{" FD "," Q ",\"wrench\":{\"tool\":[0,0,0]}}", TFA_E_SIZE,
     "wrench.tool: 3 values, must be 6"},
    {"{" FD "," Q ",\"wrench\":{\"tool\":[0,0,0,0,0,true]}}", TFA_E_ARGUMENT,
     "wrench.tool[5]: a boolean, must be a number"},
    {"{" FD "," Q ",\"wrench\":[0,0,0,0,0,0]}", TFA_E_ARGUMENT,
     "wrench: an array, must be an object {link: [fx,fy,fz,tx,ty,tz]}"},
    {"{" FD "," Q ",\"frame\":\"tool\"}", TFA_E_ARGUMENT,
     "frame: must be \"world\", \"local\" or \"local_world_aligned\""},
    {"{" FD "," Q ",\"method\":\"magic\"}", TFA_E_METHOD,
     "method: no 'magic'; nearest: 'auto', 'aba', 'rnea'; there are auto, rnea, crba, aba, tfa, "
     "tfa-one-sided, propagation, tfa-cr, hessenberg, cfa, cfa-cr, dca, scan, scan-two-pass, efpa, "
     "pv-osimr, hybrid"},
    {"{" FD "," Q ",\"method\":3}", TFA_E_ARGUMENT, "method: a number, must be a string"},
    {"{" FD "," Q ",\"refine\":4}", TFA_E_ARGUMENT, "refine: must be 0, 1, 2 or 3"},
    {"{" FD "," Q ",\"refine\":1.5}", TFA_E_ARGUMENT, "refine: must be 0, 1, 2 or 3"},
    {"{" FD "," Q ",\"refine\":-1}", TFA_E_ARGUMENT, "refine: must be 0, 1, 2 or 3"},
    {"{" FD "," Q ",\"estimate\":\"maybe\"}", TFA_E_ARGUMENT,
     "estimate: must be \"default\", \"always\" or \"never\""},
    {"{" FD "," Q ",\"gravity\":[0,0]}", TFA_E_SIZE, "gravity: 2 values, must be 3"},
    {"{" FD "," Q ",\"gravity\":-9.81}", TFA_E_ARGUMENT,
     "gravity: a number, must be an array of 3 numbers"},
};

TEST(test_refused_by_an_arm)
{
    static const char ops[] =
        "there are forward_dynamics, inverse_dynamics, operational_inertia, "
        "mass_matrix, kinematics, bias, task_torques, derivatives, inverse_dynamics_derivatives, "
        "constrained_dynamics, impact, constrained_inverse_dynamics, regressor";
    char text[512];
    REFUSE(&arm, refused_by_an_arm);
    snprintf(text, sizeof text, "op: missing; %s", ops);
    refuse(&arm, "{" Q "}", TFA_E_ARGUMENT, text);
    snprintf(text, sizeof text, "op: no 'jump'; nearest: 'bias', 'impact', 'kinematics'; %s", ops);
    refuse(&arm, "{\"op\":\"jump\"," Q "}", TFA_E_ARGUMENT, text);
    snprintf(text, sizeof text, "op: a number, must be a string; %s", ops);
    refuse(&arm, "{\"op\":1," Q "}", TFA_E_ARGUMENT, text);
    snprintf(text, sizeof text, "op: no 'crba'; nearest: 'mass_matrix'; %s", ops);
    refuse(&arm, "{\"op\":\"crba\"," Q "}", TFA_E_ARGUMENT, text);
}

TEST(test_refused_by_a_ship)
{
    refuse(&ship, "{" FD ",\"q\":{}}", TFA_E_ARGUMENT,
           "base_pose: missing; the base floats: [x,y,z,qx,qy,qz,qw]");
    refuse(&ship, "{" FD ",\"q\":[0]," POSE "}", TFA_E_SIZE,
           "q: 1 values, the robot has 11 coordinates in 3 joints (mast, deck, boat)");
    refuse(&ship, "{" FD ",\"q\":{},\"v\":[0]," POSE "}", TFA_E_SIZE,
           "v: 1 values, the robot has 10 freedoms in 3 joints (mast, deck, boat)");
    refuse(&ship, "{" FD ",\"q\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]}", TFA_E_SIZE,
           "q: 18 values, the robot has 11 coordinates in 3 joints (mast, deck, boat); a floating "
           "base has a field of its own, base_pose [x,y,z,qx,qy,qz,qw]");
    refuse(&ship, "{" FD ",\"q\":{},\"tau\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]," POSE "}",
           TFA_E_SIZE,
           "tau: 16 values, the robot has 10 freedoms in 3 joints (mast, deck, boat); a floating "
           "base has a field of its own, base_wrench");
    refuse(&ship, "{" FD ",\"q\":{\"boat\":[0,0,0]}," POSE "}", TFA_E_SIZE,
           "q.boat: 3 values, must be 7");
    refuse(&ship, "{" FD ",\"q\":{\"deck\":1}," POSE "}", TFA_E_ARGUMENT,
           "q.deck: a number, must be an array of 3 numbers");
    refuse(&ship, "{" FD ",\"q\":{},\"base_twist\":[1]," POSE "}", TFA_E_SIZE,
           "base_twist: 1 values, must be 6");
}

TEST(test_long_chain_names_a_few)
{
    enum { N = 100 };
    static char names[N][16];
    static const char *pointers[N];
    for (int i = 0; i < N; i++) {
        snprintf(names[i], sizeof names[i], "j%d", i);
        pointers[i] = names[i];
    }
    const tfa_client_info chain = {
        .q_count = N, .v_count = N, .joint_count = N, .joint_names = pointers};
    refuse(&chain, "{" MM ",\"q\":[]}", TFA_E_SIZE,
           "q: 0 values, the robot has 100 joints (j0, j1, j2, j3, j4, j5, j6, j7, ...)");
}

TEST(test_a_full_request)
{
    reading r;
    read_good(&r, &arm,
              "{\"id\":7," FD ",\"q\":[1,-2.5,3e-3],\"v\":{\"slide\":4},\"tau\":[7,8,9],"
              "\"gravity\":[0,1,2],\"wrench\":{\"tool\":[1,2,3,4,5,6],\"upper\":[6,5,4,3,2,1]},"
              "\"tips\":[\"tool\",\"lower\"],\"frame\":\"world\",\"method\":\"tfa\",\"refine\":2,"
              "\"estimate\":\"never\"}");
    const tfa_request *q = &r.request;
    assert_int_equal(q->op, TFA_OP_FORWARD_DYNAMICS);
    assert_int_equal(q->method, TFA_METHOD_TFA);
    assert_int_equal(q->estimate, TFA_ESTIMATE_NEVER);
    assert_int_equal(q->frame, TFA_FRAME_WORLD);
    assert_int_equal(q->refine, 2);
    assert_int_equal(q->count, 1);
    assert_true(q->flags & TFA_WANT_SPECTRUM);
    assert_true(q->q[0] == 1 && q->q[1] == -2.5 && q->q[2] == 3e-3);
    assert_true(q->v[0] == 0 && q->v[1] == 0 && q->v[2] == 4);
    assert_true(q->tau[0] == 7 && q->tau[2] == 9);
    assert_true(q->gravity[1] == 1);
    assert_int_equal(q->wrench_count, 2);
    assert_int_equal(q->wrench_frames[0], 3);
    assert_int_equal(q->wrench_frames[1], 1);
    assert_true(q->wrenches[0] == 1 && q->wrenches[11] == 1);
    assert_int_equal(q->tip_count, 2);
    assert_int_equal(q->tips[0], 3);
    assert_int_equal(q->tips[1], 2);
    assert_null(q->qdd);
    assert_null(q->base_pose);
    assert_non_null(r.reply.qdd);
    assert_non_null(r.reply.lambda_inv);
    assert_null(r.reply.base_acceleration);
    assert_null(r.reply.tau);
    forget(&r);
}

TEST(test_defaults)
{
    reading r;
    read_good(&r, &arm, "{" FD "," Q "}");
    assert_int_equal(r.request.method, TFA_METHOD_AUTO);
    assert_int_equal(r.request.estimate, TFA_ESTIMATE_DEFAULT);
    assert_int_equal(r.request.refine, TFA_REFINE_DEFAULT);
    assert_int_equal(r.request.frame, TFA_FRAME_LOCAL_WORLD_ALIGNED);
    assert_null(r.request.v);
    assert_null(r.request.tau);
    assert_null(r.request.gravity);
    assert_null(r.reply.lambda_inv);
    forget(&r);
}

TEST(test_joints_of_many_freedoms)
{
    static const double q[] = {0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 1};
    static const double v[] = {0, 0, 0, 0, 1, 2, 3, 4, 5, 6};
    reading r;
    read_good(&r, &ship,
              "{" FD ",\"q\":{\"deck\":[1,2,3]},"
              "\"v\":{\"boat\":[1,2,3,4,5,6]}," POSE "}");
    assert_memory_equal(r.request.q, q, sizeof q);
    assert_memory_equal(r.request.v, v, sizeof v);
    assert_true(r.request.base_pose[2] == 3 && r.request.base_pose[6] == 1);
    assert_non_null(r.reply.base_acceleration);
    assert_string_equal(tfa_names_owner(&r.names, 1, 10)->name, "boat");
    assert_string_equal(tfa_names_owner(&r.names, 0, 3)->name, "deck");
    assert_null(tfa_names_owner(&r.names, 0, 10));
    forget(&r);
}

#define MODES "\"modes\":[1,2,3]"

TEST(test_modes)
{
    static const double numbers[] = {1, 2, 3, 4, 5, 6};
    reading r;
    read_good(&r, &boom, "{" FD "," Q "," MODES ",\"mode_velocities\":[4,5,6]}");
    assert_memory_equal(r.request.modes, numbers, 3 * sizeof *numbers);
    assert_memory_equal(r.request.mode_velocities, numbers + 3, 3 * sizeof *numbers);
    assert_non_null(r.reply.modes);
    forget(&r);
    read_good(&r, &arm, "{" FD "," Q "}");
    assert_null(r.reply.modes);
    forget(&r);
    refuse(&arm, "{" FD "," Q "," MODES "}", TFA_E_ARGUMENT,
           "modes: the robot has no flexible links");
    refuse(&boom, "{" FD "," Q ",\"mode_velocities\":[1,2]}", TFA_E_SIZE,
           "mode_velocities: 2 values, must be 3");
}

TEST(test_refusals_of_modes)
{
    static const struct {
        const char *line;
        tfa_reply reply;
        const char *text;
    } rows[] = {
        {"{" FD "," Q "," MODES "}",
         {.status = TFA_E_VALUE, .field = TFA_FIELD_MODES, .index = 2},
         "modes[2] (lower): 3: not a finite number"},
        {"{" MM "," Q "}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_OP},
         "op: mass_matrix: the robot has flexible links; forward_dynamics, operational_inertia and "
         "kinematics answer"},
        {"{" FD "," Q ",\"locked\":[\"pan\"]}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_LOCKED},
         "locked: the robot has flexible links; a scene locks joints of such a robot"},
        {"{" FD "," Q ",\"want\":[\"joint_forces\"]}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_FLAGS},
         "want: the robot has flexible links; joint_forces, lambda, mu and p are not answered"},
        {"{" FD "," Q ",\"payload\":{\"link\":\"lower\",\"mass\":1}}",
         {.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_PAYLOADS},
         "payload: link 'lower' moves with some joints or modes of a body and not with others, "
         "without mass of its own; load a link at its end"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        explain(&boom, rows[k].line, &rows[k].reply, rows[k].text);
}

TEST(test_inconsistent_description)
{
    tfa_names names;
    tfa_client_info wrong = ship;
    wrong.joint_types = NULL;
    assert_int_equal(tfa_names_of_info(&names, "robot", &wrong), TFA_E_PROTOCOL);
}

/* Every double comes back from its text with the same bits and as a real. */
TEST(test_numbers_round_trip)
{
    static const double values[] = {0.0,
                                    -0.0,
                                    1.0,
                                    -3.0,
                                    0.1,
                                    1e22,
                                    1e300,
                                    5e-324,
                                    2.5e-9,
                                    1.0 / 3,
                                    0x1.fffffffffffffp+1023,
                                    12345678901234567890.0};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        char *text = NULL;
        size_t size = 0;
        FILE *out = open_memstream(&text, &size);
        assert_non_null(out);
        jsonl_print_number(out, values[i]);
        fclose(out);
        json_t *number = json_loads(text, JSON_DECODE_ANY, NULL);
        assert_true(json_is_real(number));
        double back = json_real_value(number);
        assert_memory_equal(&back, &values[i], sizeof back);
        json_decref(number);
        free(text);
    }
}

static void print_of(const char *text, const char *want)
{
    char *printed = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&printed, &size);
    assert_non_null(out);
    jsonl_print_string(out, text);
    fclose(out);
    assert_string_equal(printed, want);
    json_t *string = json_loads(printed, JSON_DECODE_ANY, NULL);
    assert_true(json_is_string(string));
    json_decref(string);
    free(printed);
}

TEST(test_strings)
{
    print_of("plain", "\"plain\"");
    print_of("a\"b\\c\n\x01", "\"a\\\"b\\\\c\\u000a\\u0001\"");
    print_of("\xc3\xa9 \xe2\x82\xac \xf0\x9f\xa4\x96",
             "\"\xc3\xa9 \xe2\x82\xac \xf0\x9f\xa4\x96\"");
    print_of("\xff", "\"\\ufffd\"");
    print_of("\xc3", "\"\\ufffd\"");
    print_of("\xc0\xaf", "\"\\ufffd\\ufffd\"");
    print_of("\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\"");
    print_of("\xf4\x90\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\"");
    print_of("\xe2\x82", "\"\\ufffd\\ufffd\"");
}

/* Limits of the robot's size: the index of the reply is the limit. */
TEST(test_limits)
{
    explain(&ship, "{\"op\":\"derivatives\",\"q\":{}," POSE "}",
            &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_OP, .index = 256},
            "op: derivatives of a robot of 16 freedoms: the limit is 256 freedoms; differences of "
            "forward_dynamics, or a scene with fewer joints, answer");
    explain(&arm, "{" MM "," Q "}",
            &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_OP, .index = 4 << 20},
            "op: mass_matrix of a robot of 3 freedoms: the limit is 4 Mi entries of M (a chain of "
            "2895 bodies); aba and rnea need no M");
    explain(&arm, "{" FD "," Q ",\"method\":\"hessenberg\"}",
            &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_METHOD, .index = 130},
            "method: hessenberg of a robot of 3 freedoms: the limit is a main chain of 130 bodies; "
            "tfa and auto answer");
    explain(&arm, "{" FD "," Q ",\"method\":\"tfa\"}",
            &(tfa_reply){
                .status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_METHOD, .index = TFA_METHOD_TFA},
            "method: no memory was reserved for tfa; in the daemon's configuration, methods: all "
            "of the robot reserves it");
    explain(
        &arm, "{" MM "," Q "}", &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_OP},
        "op: no memory was reserved for mass_matrix; in the daemon's configuration, methods: all "
        "of the robot reserves it");
}

TEST(test_explanations)
{
    explain(&ship, "{" FD ",\"q\":{},\"base_pose\":[0,0,0,0,0,0,2]}",
            &(tfa_reply){.status = TFA_E_QUATERNION, .field = TFA_FIELD_BASE_POSE, .index = 3},
            "base_pose[3]: quaternion of norm 2, must be 1 within 1e-3 (order x y z w)");
    explain(&ship, "{" FD ",\"q\":{\"boat\":[0,0,0,0.3,0.4,0,0]}," POSE "}",
            &(tfa_reply){.status = TFA_E_QUATERNION, .field = TFA_FIELD_Q, .index = 7},
            "q[7] (boat): quaternion of norm 0.5, must be 1 within 1e-3 (order x y z w)");
    explain(&arm, "{" FD "," Q ",\"method\":\"rnea\"}",
            &(tfa_reply){.status = TFA_E_METHOD, .field = TFA_FIELD_METHOD},
            "method: rnea does not answer forward_dynamics");
    explain(&arm, "{" FD "," Q ",\"method\":\"tfa\"}",
            &(tfa_reply){.status = TFA_E_SINGULAR, .field = TFA_FIELD_BODY, .index = 2},
            "tfa: body 'lower': singular inertia: the method needs the inverse of a body's "
            "inertia; use "
            "aba or give the body an inertia");
    explain(&arm, "{" FD "," Q "}", &(tfa_reply){.status = TFA_E_NOT_COMPUTED},
            "forward_dynamics: no reliable answer: the problem is singular at this "
            "configuration, or nearly, or a number overflows");
    explain(&arm, "{" FD "," Q ",\"v\":[-1e20,-2e150,1e150],\"gravity\":[0,0,1e30]}",
            &(tfa_reply){.status = TFA_E_NOT_COMPUTED},
            "v[1] (lift): -2e+150: no reliable answer: so large a number overflows");
    explain(&arm, "{" FD "," Q ",\"wrench\":{\"tool\":[0,1e200,0,0,0,0]}}",
            &(tfa_reply){.status = TFA_E_NOT_COMPUTED},
            "wrench[1] (tool): 1e+200: no reliable answer: so large a number overflows");
    explain(&arm, "{" FD "," Q "}",
            &(tfa_reply){.status = TFA_E_VALUE, .field = TFA_FIELD_Q, .index = 1},
            "q[1] (lift): 0: not a finite number");
    explain(&arm, "{" FD "," Q "}", &(tfa_reply){.status = TFA_E_DISCONNECTED},
            "forward_dynamics of robot 'robot': no daemon: none listens at the robot's "
            "socket, or it ended: start totalforced, then reconnect");
}

TEST(test_words_and_syntaxes)
{
    for (int of = TFA_WORDS_SEVERITY; of <= TFA_WORDS_ALGORITHM; of++) {
        uint32_t count;
        const char *const *words = tfa_word_list((tfa_words)of, &count);
        for (uint32_t k = of == TFA_WORDS_OP; k < count; k++) {
            assert_int_equal(tfa_word_find((tfa_words)of, words[k]), k);
            assert_ptr_equal(tfa_word((tfa_words)of, k), words[k]);
        }
        assert_int_equal(tfa_word_find((tfa_words)of, "no word"), -1);
        assert_string_equal(tfa_word((tfa_words)of, count), "unknown");
    }
    static const char *const policies[] = {
        "rank_loss = truncate or damp", "--rank-loss=truncate or damp",
        "rank_loss: truncate or damp", "\"rank_loss\":\"truncate\" or \"damp\"",
        "rank_loss='truncate' or 'damp'"};
    const tfa_request request = {.tip_count = 1};
    const tfa_reply reply = {.status = TFA_E_RANK, .field = TFA_FIELD_TIPS, .index = 3};
    char text[200], want[200];
    for (int syntax = TFA_SYNTAX_C; syntax <= TFA_SYNTAX_PYTHON; syntax++) {
        snprintf(want, sizeof want, "tips: lambda_inv has rank 3 of 6 here; %s answers",
                 policies[syntax]);
        assert_int_equal(tfa_explain(&(tfa_names){0}, &request, &reply, (tfa_option_syntax)syntax,
                                     text, sizeof text),
                         strlen(want));
        assert_string_equal(text, want);
    }
}

TEST(test_a_reply_line)
{
    reading r;
    read_good(&r, &arm, "{\"id\":\"a\"," OI "," Q ",\"tips\":[\"tool\"]}");
    r.reply.lambda_inv[1] = 0.5;
    *r.reply.spectrum = (tfa_spectrum){.rank = 6, .eig_min = 1e-3, .eig_max = 2};
    r.buffers.answer =
        (tfa_answer){.method = TFA_METHOD_PROPAGATION,
                     .flags = TFA_ANSWER_ESTIMATED | TFA_ANSWER_FALLBACK | TFA_ANSWER_STALLED,
                     .error_estimate = 3e-16};
#define ROW ",[0.0,0.0,0.0,0.0,0.0,0.0]"
    prints(&r,
           "{\"id\":\"a\",\"status\":\"ok\",\"method\":\"propagation\","
           "\"lambda_inv\":[[0.0,0.5,0.0,0.0,0.0,0.0]" ROW ROW ROW ROW ROW
           "],\"rank\":6,\"eig_min\":0.001,\"eig_max\":2.0,"
           "\"error_estimate\":2.9999999999999999e-16,\"fallback\":true,\"reason\":\"stalled\"}\n");
}
