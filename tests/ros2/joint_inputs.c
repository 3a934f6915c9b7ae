/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Joint values merged from messages of several publishers; every refusal by the joint's name.
 */
#include "dds/ros2/joint_inputs.h"

#include "test.h"

enum {
    POSITION = 1 << TFA_JOINT_POSITION,
    VELOCITY = 1 << TFA_JOINT_VELOCITY,
    EFFORT = 1 << TFA_JOINT_EFFORT
};

static const char *const arm[] = {"shoulder", "elbow", "wrist"};

static tfa_joint_inputs *arm_inputs(void)
{
    tfa_joint_inputs *s = tfa_joint_inputs_create(arm, 3);
    assert_non_null(s);
    return s;
}

/* A message of positions alone */
static tfa_joint_message positions(const char *const *name, const double *q, uint32_t count)
{
    return (tfa_joint_message){
        .name = name, .name_count = count, .value = {q}, .value_count = {count}};
}

static void assert_fault(const tfa_joint_inputs *s, tfa_joint_fault fault, uint64_t count,
                         const char *joint)
{
    const tfa_joint_fault_record *f = tfa_joint_inputs_fault(s, fault);
    assert_int_equal(f->count, count);
    assert_string_equal(f->joint, joint);
}

static void assert_no_fault(const tfa_joint_inputs *s)
{
    for (int k = 0; k < TFA_JOINT_FAULT_COUNT; k++)
        assert_int_equal(tfa_joint_inputs_fault(s, (tfa_joint_fault)k)->count, 0);
}

TEST(values_come_in_the_order_of_the_robot)
{
    static const char *const orders[][3] = {{"shoulder", "elbow", "wrist"},
                                            {"wrist", "shoulder", "elbow"},
                                            {"elbow", "wrist", "shoulder"}};
    static const double numbers[][3] = {{1, 2, 3}, {6, 4, 5}, {8, 9, 7}};
    tfa_joint_inputs *s = arm_inputs();
    double q[3];
    for (int turn = 0; turn < 12; turn++) {
        const int k = turn / 2 % 3; /* each order twice */
        const tfa_joint_message m = positions(orders[k], numbers[k], 3);
        assert_true(tfa_joint_inputs_merge(s, &m, POSITION, turn));
        assert_true(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, turn, 0, q));
        for (int j = 0; j < 3; j++)
            assert_true(q[j] == 3 * k + j + 1);
    }
    assert_no_fault(s);
    tfa_joint_inputs_free(s);
}

TEST(publishers_with_some_of_the_joints_are_merged)
{
    static const char *const one[] = {"elbow"}, *const two[] = {"wrist", "finger", "shoulder"};
    static const double q_one[] = {2}, q_two[] = {3, 9, 1};
    tfa_joint_inputs *s = arm_inputs();
    const tfa_joint_message a = positions(one, q_one, 1), b = positions(two, q_two, 3);
    double q[3] = {-1, -1, -1};
    assert_true(tfa_joint_inputs_merge(s, &a, POSITION, 100));
    assert_false(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, 100, 1000, q));
    assert_fault(s, TFA_JOINT_FAULT_MISSING, 1, "shoulder");
    assert_true(q[0] == -1 && q[1] == -1 && q[2] == -1);
    assert_true(tfa_joint_inputs_merge(s, &b, POSITION, 150));
    assert_fault(s, TFA_JOINT_FAULT_UNKNOWN, 1, "finger");
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, 150, 50, q));
    assert_true(q[0] == 1 && q[1] == 2 && q[2] == 3);
    assert_int_equal(tfa_joint_inputs_age(s, 1, TFA_JOINT_POSITION, 150), 50);
    assert_int_equal(tfa_joint_inputs_age(s, 2, TFA_JOINT_POSITION, 150), 0);
    assert_int_equal(tfa_joint_inputs_age(s, 2, TFA_JOINT_VELOCITY, 150), -1);
    assert_false(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, 151, 50, q));
    assert_fault(s, TFA_JOINT_FAULT_STALE, 1, "elbow");
    assert_fault(s, TFA_JOINT_FAULT_MISSING, 1, "shoulder");
    tfa_joint_inputs_free(s);
}

/* A sample is complete once every joint has all values anew; NaN is none. */
TEST(the_last_value_completes_a_sample)
{
    static const double x[] = {1, 2, 3}, gone[] = {1, NAN, 3};
    tfa_joint_inputs *s = arm_inputs();
    tfa_joint_message m = {.name = arm, .name_count = 3, .value = {x, NULL, x}};
    m.value_count[TFA_JOINT_POSITION] = m.value_count[TFA_JOINT_EFFORT] = 3;
    assert_false(tfa_joint_inputs_renewed(s, POSITION | EFFORT));
    for (int k = 0; k < 3; k++) {
        m.value[TFA_JOINT_EFFORT] = gone;
        assert_true(tfa_joint_inputs_merge(s, &m, POSITION | EFFORT, 5));
        assert_false(tfa_joint_inputs_renewed(s, POSITION | EFFORT));
        m.value[TFA_JOINT_EFFORT] = x;
        assert_true(tfa_joint_inputs_merge(s, &m, POSITION | EFFORT, 5));
        assert_false(tfa_joint_inputs_renewed(s, POSITION | VELOCITY | EFFORT));
        assert_true(tfa_joint_inputs_renewed(s, POSITION | EFFORT));
        assert_false(tfa_joint_inputs_renewed(s, POSITION | EFFORT));
    }
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION, 6));
    assert_false(tfa_joint_inputs_renewed(s, POSITION | EFFORT));
    assert_true(tfa_joint_inputs_renewed(s, POSITION));
    tfa_joint_inputs_free(s);
}

/* Another model: joints of the same name keep values and ages, others have none. */
TEST(another_model_takes_over_what_was_received)
{
    static const char *const next[] = {"wrist", "finger", "shoulder"};
    static const double q[] = {1, 2, 3};
    tfa_joint_inputs *s = arm_inputs(), *t = tfa_joint_inputs_create(next, 3);
    const tfa_joint_message m = positions(arm, q, 3), few = positions(next + 1, q, 1);
    double x[3];
    assert_non_null(t);
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION, 100));
    assert_true(tfa_joint_inputs_merge(s, &few, POSITION, 110)); /* unknown */
    tfa_joint_inputs_adopt(t, s);
    assert_fault(t, TFA_JOINT_FAULT_UNKNOWN, 1, "finger");
    assert_int_equal(tfa_joint_inputs_age(t, 0, TFA_JOINT_POSITION, 120), 20);
    assert_int_equal(tfa_joint_inputs_age(t, 1, TFA_JOINT_POSITION, 120), -1);
    assert_true(tfa_joint_inputs_merge(t, &few, POSITION, 120));
    assert_true(tfa_joint_inputs_read(t, TFA_JOINT_POSITION, 120, 20, x));
    assert_true(x[0] == 3 && x[1] == 1 && x[2] == 1);
    tfa_joint_inputs_forget(t);
    assert_false(tfa_joint_inputs_read(t, TFA_JOINT_POSITION, 120, 20, x));
    assert_fault(t, TFA_JOINT_FAULT_MISSING, 1, "wrist");
    tfa_joint_inputs_free(t);
    tfa_joint_inputs_free(s);
}

TEST(each_value_is_of_its_own)
{
    static const double q[] = {1, 2, 3}, v[] = {4, 5, 6}, tau[] = {7, 8, 9};
    tfa_joint_inputs *s = arm_inputs();
    double x[3];
    const tfa_joint_message measured = {
        .name = arm, .name_count = 3, .value = {q, v, tau}, .value_count = {3, 3, 3}};
    const tfa_joint_message command = {
        .name = arm, .name_count = 3, .value = {NULL, NULL, q}, .value_count = {0, 0, 3}};
    assert_true(tfa_joint_inputs_merge(s, &measured, POSITION | VELOCITY, 1));
    assert_false(tfa_joint_inputs_read(s, TFA_JOINT_EFFORT, 1, 10, x)); /* measured: no command */
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_MISSING)->value, TFA_JOINT_EFFORT);
    assert_true(tfa_joint_inputs_merge(s, &command, EFFORT, 2));
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_EFFORT, 2, 0, x));
    assert_memory_equal(x, q, sizeof q);
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_VELOCITY, 2, 1, x));
    assert_memory_equal(x, v, sizeof v);
    tfa_joint_inputs_free(s);
}

/* A broadcaster fills velocities that the hardware lacks with NaN: positions are taken. */
TEST(numbers_that_are_not_finite_leave_the_number_before)
{
    static const double q[] = {1, 2, 3}, worse[] = {4, 5, 6}, bad[] = {0, NAN, -INFINITY};
    tfa_joint_inputs *s = arm_inputs();
    double x[3];
    tfa_joint_message m = {.name = arm, .name_count = 3, .value = {q, q}, .value_count = {3, 3}};
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION | VELOCITY, 1));
    m.value[TFA_JOINT_POSITION] = worse;
    m.value[TFA_JOINT_VELOCITY] = bad;
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION | VELOCITY, 2));
    assert_fault(s, TFA_JOINT_FAULT_NOT_FINITE, 2, "wrist");
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_NOT_FINITE)->value,
                     TFA_JOINT_VELOCITY);
    assert_int_equal(tfa_joint_inputs_outcome(s).taken, 3);
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, 2, 0, x));
    assert_memory_equal(x, worse, sizeof worse);
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_VELOCITY, 2, 1, x));
    assert_true(x[0] == 0 && x[1] == 2 && x[2] == 3);
    assert_int_equal(tfa_joint_inputs_age(s, 1, TFA_JOINT_VELOCITY, 2), 1);
    assert_false(tfa_joint_inputs_read(s, TFA_JOINT_VELOCITY, 2, 0, x));
    assert_fault(s, TFA_JOINT_FAULT_STALE, 1, "elbow");
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_STALE)->value, TFA_JOINT_VELOCITY);
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION, 3)); /* velocities were not asked for */
    assert_fault(s, TFA_JOINT_FAULT_NOT_FINITE, 2, "wrist");
    tfa_joint_inputs_free(s);
}

TEST(messages_that_contradict_themselves_are_refused_whole)
{
    static const char *const twice[] = {"wrist", "elbow", "wrist"};
    static const double q[] = {1, 2, 3};
    tfa_joint_inputs *s = arm_inputs();
    tfa_joint_message m = positions(twice, q, 3);
    for (int turn = 1; turn <= 2; turn++) {
        assert_false(tfa_joint_inputs_merge(s, &m, POSITION, turn));
        assert_fault(s, TFA_JOINT_FAULT_TWICE, (uint64_t)turn, "wrist");
    }
    m = positions(arm, q, 3);
    m.value[TFA_JOINT_EFFORT] = q;
    for (uint32_t count = 1; count <= 4; count++) {
        m.value_count[TFA_JOINT_EFFORT] = count;
        assert_int_equal(tfa_joint_inputs_merge(s, &m, POSITION, 3), count == 3);
    }
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_LENGTH)->count, 3);
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_LENGTH)->value, TFA_JOINT_EFFORT);
    for (uint32_t j = 0; j < 3; j++)
        assert_int_equal(tfa_joint_inputs_age(s, j, TFA_JOINT_POSITION, 3), 0);
    tfa_joint_inputs_free(s);
}

/* Names without end, and more of them than the robot has joints */
TEST(hostile_names_cost_no_memory)
{
    enum { NAMES = 10000 };
    char *name[NAMES];
    double q[NAMES];
    tfa_joint_inputs *s = arm_inputs();
    for (int k = 0; k < NAMES; k++) {
        const size_t length = k == NAMES - 1 ? 100000 : 8;
        name[k] = malloc(length + 1);
        assert_non_null(name[k]);
        memset(name[k], 'x', length);
        snprintf(name[k], 9, "%08d", k);
        if (length > 8)
            name[k][8] = 'x';
        name[k][length] = '\0';
        q[k] = k;
    }
    snprintf(name[NAMES / 2], 9, "elbow");
    const tfa_joint_message m = positions((const char *const *)name, q, NAMES);
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION, 1));
    assert_int_equal(tfa_joint_inputs_age(s, 1, TFA_JOINT_POSITION, 1), 0);
    assert_int_equal(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_UNKNOWN)->count, NAMES - 1);
    assert_int_equal(strlen(tfa_joint_inputs_fault(s, TFA_JOINT_FAULT_UNKNOWN)->joint), 63);
    tfa_joint_inputs_free(s);
    for (int k = 0; k < NAMES; k++)
        free(name[k]);
}

TEST(a_robot_without_joints)
{
    static const double q[] = {1, 2, 3};
    tfa_joint_inputs *s = tfa_joint_inputs_create(NULL, 0);
    const tfa_joint_message m = positions(arm, q, 3), empty = {0};
    assert_non_null(s);
    assert_true(tfa_joint_inputs_merge(s, &m, POSITION, 1));
    assert_true(tfa_joint_inputs_merge(s, &empty, POSITION, 1));
    assert_true(tfa_joint_inputs_read(s, TFA_JOINT_POSITION, 1, 0, NULL));
    assert_fault(s, TFA_JOINT_FAULT_UNKNOWN, 3, "wrist");
    tfa_joint_inputs_free(s);
    tfa_joint_inputs_free(NULL);
}
