/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a JSON line changes about the robot - locked joints, payloads - and what is told of
 * it: requests, refusals, replies.
 */
#include "jsonl_line.h"
#include "test.h"

static const refusal refused[] = {
    {"{" FD "," Q ",\"locked\":\"pan\"}", TFA_E_ARGUMENT,
     "locked: a string, must be an array of joint names"},
    {"{" FD "," Q ",\"locked\":[\"pan\",2]}", TFA_E_ARGUMENT,
     "locked[1]: a number, must be a joint name"},
    {"{" FD "," Q ",\"locked\":[\"weld\"]}", TFA_E_JOINT,
     "locked[0]: no moving joint 'weld'; nearest: 'pan', 'lift', 'slide'; the robot has 3 joints "
     "(pan, lift, slide)"},
    {"{" FD "," Q ",\"locked\":[\"pan\",\"lift\",\"slide\",\"pan\"]}", TFA_E_JOINT,
     "locked[3]: joint 'pan' twice; name it once"},
    {"{" MM "," Q ",\"locked\":[\"pan\"]}", TFA_E_ARGUMENT, "locked: mass_matrix does not use it"},
    {"{" FD "," Q ",\"hold\":[\"pan\"]}", TFA_E_ARGUMENT,
     "unknown key 'hold'; nearest: 'id', 'op', 'qdd'"},
    {"{" FD "," Q ",\"poses\":true}", TFA_E_ARGUMENT, "tips: missing; 1 to 32 link names"},
    {"{" FD "," Q ",\"poses\":[\"tool\"]}", TFA_E_ARGUMENT,
     "poses: an array, must be true or false"},
    {"{" MM "," Q ",\"payload\":3}", TFA_E_ARGUMENT,
     "payload: a number, must be an object {link, mass, com, inertia}"},
    {"{" MM "," Q ",\"payload\":{\"mass\":1}}", TFA_E_ARGUMENT,
     "payload.link: missing, must be a link name"},
    {"{" MM "," Q ",\"payload\":{\"link\":7,\"mass\":1}}", TFA_E_ARGUMENT,
     "payload.link: a number, must be a link name"},
    {"{" MM "," Q ",\"payload\":{\"link\":\"hand\",\"mass\":1}}", TFA_E_LINK,
     "payload.link: no link 'hand' in the robot; nearest: 'base', 'tool', 'upper'"},
    {"{" MM "," Q ",\"payload\":{\"link\":\"tool\"}}", TFA_E_ARGUMENT,
     "payload.mass: missing, must be a number in kg"},
    {"{" MM "," Q ",\"payload\":{\"link\":\"tool\",\"mass\":\"1\"}}", TFA_E_ARGUMENT,
     "payload.mass: a string, must be a number in kg"},
    {"{" MM "," Q ",\"payload\":{\"link\":\"tool\",\"mass\":1,\"cog\":[0,0,0]}}", TFA_E_ARGUMENT,
     "payload: unknown key 'cog'; there are link, mass, com, inertia"},
    {"{" MM "," Q ",\"payload\":[{\"link\":\"tool\",\"mass\":1},{\"link\":\"tool\",\"mass\":1,"
     "\"com\":[0,0]}]}",
     TFA_E_SIZE, "payload[1].com: 2 values, must be 3"},
    {"{" MM "," Q ",\"payload\":[{\"link\":\"tool\",\"mass\":1,\"inertia\":[1,1,1]}]}", TFA_E_SIZE,
     "payload[0].inertia: 3 values, must be 6"},
    {"{" MM "," Q ",\"payload\":[1,2,3,4,5]}", TFA_E_SIZE, "payload: 5 of them, at most 4"},
    {"{" MM "," Q ",\"payload\":[[]]}", TFA_E_ARGUMENT,
     "payload[0]: an array, must be an object {link, mass, com, inertia}"},
};

TEST(test_refusals)
{
    REFUSE(&arm, refused);
}

TEST(test_a_changed_robot)
{
    static const double payloads[] = {2, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0.5, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    reading r;
    read_good(
        &r, &arm,
        "{" FD "," Q ",\"locked\":[\"slide\",\"pan\"],"
        "\"payload\":[{\"link\":\"tool\",\"mass\":2,\"com\":[1,2,3],\"inertia\":[4,5,6,7,8,9]},"
        "{\"link\":\"upper\",\"mass\":0.5}]}");
    const tfa_request *q = &r.request;
    assert_int_equal(q->locked_count, 2);
    assert_int_equal(q->locked[0], 2);
    assert_int_equal(q->locked[1], 0);
    assert_int_equal(q->payload_count, 2);
    assert_int_equal(q->payload_frames[0], 3);
    assert_int_equal(q->payload_frames[1], 1);
    assert_memory_equal(q->payloads, payloads, sizeof payloads);
    assert_null(r.reply.poses);
    forget(&r);
}

/* Every op but mass_matrix, which the library refuses, too. */
TEST(ops_with_locked_joints)
{
    static const char *const lines[] = {"{" ID "," Q ",\"locked\":[\"pan\"]}",
                                        "{\"op\":\"bias\"," Q ",\"locked\":[\"pan\"]}",
                                        "{\"op\":\"kinematics\"," Q ",\"locked\":[\"pan\"]}",
                                        "{\"op\":\"derivatives\"," Q ",\"locked\":[\"pan\"]}"};
    for (size_t k = 0; k < sizeof lines / sizeof *lines; k++) {
        reading r;
        read_good(&r, &arm, lines[k]);
        assert_int_equal(r.request.locked_count, 1);
        forget(&r);
    }
}

TEST(test_what_is_wanted)
{
    reading r;
    read_good(&r, &arm, "{" OI "," Q ",\"tips\":[\"tool\"],\"poses\":true,\"locked\":[]}");
    assert_true(r.request.flags & TFA_WANT_POSES);
    assert_int_equal(r.request.locked_count, 0);
    assert_non_null(r.reply.poses);
    forget(&r);
    read_good(&r, &arm, "{" OI "," Q ",\"tips\":[\"tool\"],\"poses\":false}");
    assert_false(r.request.flags & TFA_WANT_POSES);
    assert_null(r.reply.poses);
    forget(&r);
}

#define LOAD "\"payload\":{\"link\":\"tool\",\"mass\":-1}"

TEST(test_explained_changes)
{
    explain(&arm, "{" FD "," Q "," LOAD "}",
            &(tfa_reply){.status = TFA_E_ARGUMENT, .field = TFA_FIELD_PAYLOADS},
            "payload.mass: -1: must not be negative");
    explain(&arm,
            "{" FD "," Q ",\"payload\":[{\"link\":\"tool\",\"mass\":1},{\"link\":\"lower\","
            "\"mass\":2,\"inertia\":[-1,0,0,1,0,1]}]}",
            &(tfa_reply){.status = TFA_E_ARGUMENT, .field = TFA_FIELD_PAYLOADS, .index = 1},
            "payload[1].inertia: no body of 2 kg has it; give ixx,ixy,ixz,iyy,iyz,izz about the "
            "centre of mass, with eigenvalues that are not negative");
    explain(&arm, "{" FD "," Q "," LOAD "}",
            &(tfa_reply){.status = TFA_E_UNSUPPORTED, .field = TFA_FIELD_PAYLOADS},
            "payload: link 'tool' moves with some joints of a body and not with others, without "
            "mass of its own; load a link at its end");
    explain(&arm, "{" FD "," Q ",\"locked\":[\"pan\"],\"method\":\"tfa\"}",
            &(tfa_reply){.status = TFA_E_METHOD, .field = TFA_FIELD_LOCKED},
            "method: tfa does not answer forward_dynamics with locked joints; aba does");
}

TEST(test_poses_reply_line)
{
    reading r;
    read_good(&r, &arm, "{" FD "," Q ",\"tips\":[\"tool\",\"upper\"],\"poses\":true}");
    r.reply.model = 0x0123456789abcdefu;
    r.reply.poses[13] = 1;
    r.reply.lambda_inv = NULL;
    r.reply.spectrum = NULL;
    prints(&r, "{\"status\":\"ok\",\"method\":\"auto\",\"qdd\":[0.0,0.0,0.0],"
               "\"poses\":[[0.0,0.0,0.0,0.0,0.0,0.0,0.0],[0.0,0.0,0.0,0.0,0.0,0.0,1.0]],"
               "\"model\":\"0123456789abcdef\"}\n");
}
