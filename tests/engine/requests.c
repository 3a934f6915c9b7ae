/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bad requests: each gets its status and the name of the invalid field, and nothing is answered.
 */
#include "interface/fields.h"
#include "models.h"
#include "test.h"

#include <totalforce/totalforce.h>

#define STATES 3
#define NQ 9 /* revolute, floating, revolute */
#define NV 8

static const tfa_link solid = {.mass = 1.5,
                               .com = {0.1, 0.02, -0.03},
                               .quat = {0, 0, 0, 1},
                               .inertia = {0.02, 0.001, 0, 0.03, -0.001, 0.04}};

/* root, joint `a` revolute, `b` floating, `c` revolute, and a frame on the last link */
static tfa_model *build(const tfa_model_options *options)
{
    tfa_link links[5];
    tfa_joint joints[4];
    static const char *const link_names[] = {"root", "one", "two", "three", "frame"};
    static const char *const joint_names[] = {"a", "b", "c", "d"};
    static const tfa_joint_type types[] = {TFA_JOINT_REVOLUTE, TFA_JOINT_FLOATING,
                                           TFA_JOINT_REVOLUTE, TFA_JOINT_FIXED};
    for (int k = 0; k < 5; k++) {
        links[k] = solid;
        links[k].name = link_names[k];
    }
    links[4] = (tfa_link){.name = "frame", .quat = {0, 0, 0, 1}};
    for (uint32_t k = 0; k < 4; k++)
        joints[k] = (tfa_joint){.name = joint_names[k],
                                .type = types[k],
                                .parent = k,
                                .child = k + 1,
                                .xyz = {0.3, 0, 0.1},
                                .quat = {0, 0, 0, 1},
                                .axis = {0, k == 0, k != 0},
                                .mimic = -1};
    const tfa_description d = {
        .name = "bad", .links = links, .link_count = 5, .joints = joints, .joint_count = 4};
    return compiled(&d, options);
}

/* A request that is in order, on a floating base, and storage to spoil every part of it. */
struct scene {
    tfa_request r;
    double q[NQ * STATES], v[NV * STATES], tau[NV * STATES], qdd[NV * STATES];
    double pose[7 * STATES], twist[6 * STATES], wrench[6 * STATES], acceleration[6 * STATES];
    double gravity[3], wrenches[6 * STATES];
};

static void set_scene(struct scene *s)
{
    *s = (struct scene){.gravity = {0, 0, -9.81}};
    for (int k = 0; k < STATES; k++) {
        s->q[NQ * k] = 0.2 * k;
        s->q[NQ * k + 7] = 1;
        s->pose[7 * k + 6] = 1;
        s->v[NV * k + 1] = 0.5;
    }
    s->r = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = STATES,
                         .tip_count = 2,
                         .tips = {4, 1},
                         .wrench_count = 1,
                         .wrench_frames = {3},
                         .q = s->q,
                         .v = s->v,
                         .tau = s->tau,
                         .qdd = s->qdd,
                         .base_pose = s->pose,
                         .base_twist = s->twist,
                         .base_wrench = s->wrench,
                         .base_acceleration = s->acceleration,
                         .gravity = s->gravity,
                         .wrenches = s->wrenches};
}

/* What is spoilt: a member of the request, by its place in it. */
#define MEMBER(name) offsetof(tfa_request, name)
#define ARRAY(name) offsetof(struct scene, name)

/* A 32-bit member of the request set to `value`. */
static const struct {
    const char *what;
    size_t member;
    uint32_t value;
    int status;
    tfa_field field;
    uint32_t index;
} spoilt_members[] = {
    {"op 0", MEMBER(op), 0, TFA_E_ARGUMENT, TFA_FIELD_OP, 0},
    {"op 13", MEMBER(op), TFA_OP_LAST + 1, TFA_E_ARGUMENT, TFA_FIELD_OP, 0},
    {"op huge", MEMBER(op), UINT32_MAX, TFA_E_ARGUMENT, TFA_FIELD_OP, 0},
    {"method unknown", MEMBER(method), 999, TFA_E_METHOD, TFA_FIELD_METHOD, 999},
    {"method -1", MEMBER(method), UINT32_MAX, TFA_E_METHOD, TFA_FIELD_METHOD, UINT32_MAX},
    {"rnea for qdd", MEMBER(method), TFA_METHOD_RNEA, TFA_E_METHOD, TFA_FIELD_METHOD,
     TFA_METHOD_RNEA},
    {"propagation for qdd", MEMBER(method), TFA_METHOD_PROPAGATION, TFA_E_METHOD, TFA_FIELD_METHOD,
     TFA_METHOD_PROPAGATION},
    {"estimate 3", MEMBER(estimate), 3, TFA_E_ARGUMENT, TFA_FIELD_ESTIMATE, 0},
    {"frame 3", MEMBER(frame), 3, TFA_E_ARGUMENT, TFA_FIELD_FRAME, 0},
    {"frame -1", MEMBER(frame), UINT32_MAX, TFA_E_ARGUMENT, TFA_FIELD_FRAME, 0},
    {"refine 4", MEMBER(refine), 4, TFA_E_ARGUMENT, TFA_FIELD_REFINE, 0},
    {"no states", MEMBER(count), 0, TFA_E_SIZE, TFA_FIELD_COUNT, 0},
    {"33 tips", MEMBER(tip_count), 33, TFA_E_SIZE, TFA_FIELD_TIPS, 33},
    {"9 wrenches", MEMBER(wrench_count), 9, TFA_E_SIZE, TFA_FIELD_WRENCHES, 9},
    {"tip that is no frame", MEMBER(tips[1]), 5, TFA_E_LINK, TFA_FIELD_TIPS, 1},
    {"wrench on no frame", MEMBER(wrench_frames[0]), UINT32_MAX, TFA_E_LINK, TFA_FIELD_WRENCHES, 0},
};

/* One number of an array set to `value`. */
static const struct {
    const char *what;
    size_t array;
    uint32_t place;
    double value;
    int status;
    tfa_field field;
    uint32_t index, state;
    tfa_op op;
} spoilt_numbers[] = {
    {"q", ARRAY(q), NQ + 8, NAN, TFA_E_VALUE, TFA_FIELD_Q, 8, 1, TFA_OP_FORWARD_DYNAMICS},
    {"v", ARRAY(v), 2 * NV + 7, INFINITY, TFA_E_VALUE, TFA_FIELD_V, 7, 2, TFA_OP_FORWARD_DYNAMICS},
    {"tau", ARRAY(tau), 0, -INFINITY, TFA_E_VALUE, TFA_FIELD_TAU, 0, 0, TFA_OP_FORWARD_DYNAMICS},
    {"qdd", ARRAY(qdd), NV, NAN, TFA_E_VALUE, TFA_FIELD_QDD, 0, 1, TFA_OP_INVERSE_DYNAMICS},
    {"qdd of forward dynamics", ARRAY(qdd), NV, NAN, TFA_OK, TFA_FIELD_NONE, 0, 0,
     TFA_OP_FORWARD_DYNAMICS},
    {"tau of inverse dynamics", ARRAY(tau), NV, NAN, TFA_OK, TFA_FIELD_NONE, 0, 0,
     TFA_OP_INVERSE_DYNAMICS},
    {"v at rest", ARRAY(v), 1, NAN, TFA_OK, TFA_FIELD_NONE, 0, 0, TFA_OP_OPERATIONAL_INERTIA},
    {"v of inverse dynamics", ARRAY(v), 1, NAN, TFA_E_VALUE, TFA_FIELD_V, 1, 0,
     TFA_OP_INVERSE_DYNAMICS},
    {"q of Lambda^-1", ARRAY(q), 1, NAN, TFA_E_VALUE, TFA_FIELD_Q, 1, 0,
     TFA_OP_OPERATIONAL_INERTIA},
    {"base_twist of Lambda^-1", ARRAY(twist), 5, NAN, TFA_OK, TFA_FIELD_NONE, 0, 0,
     TFA_OP_OPERATIONAL_INERTIA},
    {"base_pose", ARRAY(pose), 7 * 2 + 1, NAN, TFA_E_VALUE, TFA_FIELD_BASE_POSE, 1, 2,
     TFA_OP_FORWARD_DYNAMICS},
    {"base_twist", ARRAY(twist), 5, NAN, TFA_E_VALUE, TFA_FIELD_BASE_TWIST, 5, 0,
     TFA_OP_FORWARD_DYNAMICS},
    {"base_wrench", ARRAY(wrench), 6 + 3, NAN, TFA_E_VALUE, TFA_FIELD_BASE_WRENCH, 3, 1,
     TFA_OP_FORWARD_DYNAMICS},
    {"base_acceleration", ARRAY(acceleration), 17, NAN, TFA_E_VALUE, TFA_FIELD_BASE_ACCELERATION, 5,
     2, TFA_OP_INVERSE_DYNAMICS},
    {"gravity", ARRAY(gravity), 1, INFINITY, TFA_E_VALUE, TFA_FIELD_GRAVITY, 1, 0,
     TFA_OP_FORWARD_DYNAMICS},
    {"wrenches", ARRAY(wrenches), 6 + 4, NAN, TFA_E_VALUE, TFA_FIELD_WRENCHES, 4, 1,
     TFA_OP_FORWARD_DYNAMICS},
    {"base quaternion", ARRAY(pose), 7 * 2 + 6, 1.002, TFA_E_QUATERNION, TFA_FIELD_BASE_POSE, 3, 2,
     TFA_OP_FORWARD_DYNAMICS},
    {"base quaternion of zeros", ARRAY(pose), 6, 0, TFA_E_QUATERNION, TFA_FIELD_BASE_POSE, 3, 0,
     TFA_OP_FORWARD_DYNAMICS},
    {"joint quaternion", ARRAY(q), NQ + 7, 0.9985, TFA_E_QUATERNION, TFA_FIELD_Q, 4, 1,
     TFA_OP_FORWARD_DYNAMICS},
    {"quaternion within 1e-3", ARRAY(pose), 7 + 6, 1.0009, TFA_OK, TFA_FIELD_NONE, 0, 0,
     TFA_OP_FORWARD_DYNAMICS},
};

/* A pointer that is needed set to NULL. */
static const struct {
    const char *what;
    size_t member;
    tfa_field field;
} missing[] = {
    {"q", MEMBER(q), TFA_FIELD_Q},
    {"base_pose", MEMBER(base_pose), TFA_FIELD_BASE_POSE},
    {"wrenches", MEMBER(wrenches), TFA_FIELD_WRENCHES},
};

static tfa_model *model;
static tfa_workspace *workspace;

static int setup(void **state)
{
    (void)state;
    const tfa_model_options options = {.base = TFA_BASE_FLOATING};
    model = build(&options);
    workspace = workspace_for(model, NULL);
    assert_int_equal(tfa_model_q_count(model), NQ);
    assert_int_equal(tfa_model_v_count(model), NV);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}

/* The request must fail alike in the check and in the computation, and write no answer. */
static void expect(const char *what, const tfa_request *r, int status, tfa_field field,
                   uint32_t index, uint32_t state)
{
    static double qdd[NV * STATES], base[6 * STATES], lambda[144 * STATES];
    for (int k = 0; k < NV * STATES; k++)
        qdd[k] = 42;
    for (int check = 0; check < 2; check++) {
        tfa_reply reply = {.qdd = qdd, .base_acceleration = base, .lambda_inv = lambda};
        int got = check ? tfa_request_check(model, r, &reply) : tfa_compute(workspace, r, &reply);
        if (got != status || reply.status != status || reply.field != field ||
            reply.index != index || reply.state != state)
            fail_msg("%s: %s (%s) at %s %u of state %u, expected %s at %s %u of state %u", what,
                     tfa_status_name(got), tfa_status_name(reply.status),
                     tfa_field_name(reply.field), (unsigned)reply.index, (unsigned)reply.state,
                     tfa_status_name(status), tfa_field_name(field), (unsigned)index,
                     (unsigned)state);
        for (int k = 0; status != TFA_OK && k < NV * STATES; k++)
            assert_true(qdd[k] == 42);
    }
}

TEST(good_request_passes)
{
    struct scene s;
    set_scene(&s);
    expect("good", &s.r, TFA_OK, TFA_FIELD_NONE, 0, 0);
    s.r.op = TFA_OP_OPERATIONAL_INERTIA;
    expect("good", &s.r, TFA_OK, TFA_FIELD_NONE, 0, 0);
}

TEST(bad_members_are_named)
{
    for (size_t k = 0; k < sizeof spoilt_members / sizeof *spoilt_members; k++) {
        struct scene s;
        set_scene(&s);
        memcpy((char *)&s.r + spoilt_members[k].member, &spoilt_members[k].value, 4);
        expect(spoilt_members[k].what, &s.r, spoilt_members[k].status, spoilt_members[k].field,
               spoilt_members[k].index, 0);
    }
}

TEST(bad_numbers_are_named)
{
    for (size_t k = 0; k < sizeof spoilt_numbers / sizeof *spoilt_numbers; k++) {
        struct scene s;
        set_scene(&s);
        s.r.op = spoilt_numbers[k].op;
        memcpy((char *)&s + spoilt_numbers[k].array + 8 * (size_t)spoilt_numbers[k].place,
               &spoilt_numbers[k].value, 8);
        expect(spoilt_numbers[k].what, &s.r, spoilt_numbers[k].status, spoilt_numbers[k].field,
               spoilt_numbers[k].index, spoilt_numbers[k].state);
    }
}

/* The same robot with two modes of link `two` */
static tfa_model *build_flexible(void)
{
    static const double momentum[12] = {0.1, 0, 0, 0, 0.02, 0, 0, 0.1}, mass[4] = {0.1, 0, 0, 0.1},
                        stiffness[4] = {90, 0, 0, 80}, shape[12] = {1, 0, 0, 0, 2, 0, 0, 1};
    const tfa_mode_shape shapes[] = {{"c", shape}};
    const tfa_link_modes modes[] = {{.link = "two",
                                     .mode_count = 2,
                                     .momentum = momentum,
                                     .mass = mass,
                                     .stiffness = stiffness,
                                     .shapes = shapes,
                                     .shape_count = 1}};
    const tfa_scene scene = {.modes = modes, .modes_count = 1};
    const tfa_model_options options = {.base = TFA_BASE_FLOATING, .scene = &scene};
    return build(&options);
}

static tfa_model *build_closed(void)
{
    static const tfa_constraint weld = {.name = "weld",
                                        .link = {NULL, "three"},
                                        .pose = {{0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1}},
                                        .rows = TFA_CONSTRAINT_WELD};
    static const tfa_scene scene = {.constraints = &weld, .constraint_count = 1};
    static const tfa_model_options options = {.base = TFA_BASE_FLOATING, .scene = &scene};
    return build(&options);
}

/* Every input of interface/fields.h: bits that are neither a number nor a joint are refused by some
 * op, and by each op that refuses them as that field; modes by ops that answer such a robot. */
TEST(every_input_is_checked)
{
    static const double payload[TFA_PAYLOAD_NUMBERS] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 1};
    double bad[12 * STATES], desired[12 * STATES] = {0};
    tfa_reply reply = {0};
    tfa_model *flexible = build_flexible(), *closed = build_closed();
    memset(bad, 0xff, sizeof bad);
#define SPOIL(name, member, ...)                                                                   \
    for (int op = TFA_OP_FORWARD_DYNAMICS, refused = 0; op <= TFA_OP_LAST; op++) {                 \
        const int modes =                                                                          \
            TFA_FIELD_##name == TFA_FIELD_MODES || TFA_FIELD_##name == TFA_FIELD_MODE_VELOCITIES;  \
        struct scene s;                                                                            \
        set_scene(&s);                                                                             \
        s.r.op = (tfa_op)op;                                                                       \
        s.r.flags = !modes && TFA_OP_BIT(op) & TFA_OPS_SOLVE ? TFA_WANT_LAMBDA : 0;                \
        s.r.payload_count = !modes;                                                                \
        s.r.payloads = payload;                                                                    \
        s.r.locked_count = TFA_FIELD_##name == TFA_FIELD_LOCKED;                                   \
        s.r.task_acceleration = desired;                                                           \
        s.r.constraints = 1;                                                                       \
        s.r.member = (const void *)bad;                                                            \
        if (tfa_request_check(modes ? flexible : closed, &s.r, &reply) != TFA_OK &&                \
            !(modes && reply.field == TFA_FIELD_OP)) {                                             \
            assert_int_equal(reply.field, TFA_FIELD_##name);                                       \
            refused++;                                                                             \
        }                                                                                          \
        if (op == TFA_OP_LAST && !refused)                                                         \
            fail_msg("no op refuses " #member);                                                    \
    }
    TFA_INPUT_LIST(SPOIL)
#undef SPOIL
    tfa_model_free(flexible);
    tfa_model_free(closed);
}

TEST(bad_modal_coordinates_are_named)
{
    tfa_model *flexible = build_flexible();
    double modes[2 * STATES] = {0}, velocities[2 * STATES] = {0};
    tfa_reply reply = {0};
    struct scene s;
    set_scene(&s);
    s.r.modes = modes;
    s.r.mode_velocities = velocities;
    assert_int_equal(tfa_request_check(flexible, &s.r, &reply), TFA_OK);
    velocities[2] = INFINITY;
    assert_int_equal(tfa_request_check(flexible, &s.r, &reply), TFA_E_VALUE);
    assert_int_equal(reply.field, TFA_FIELD_MODE_VELOCITIES);
    assert_int_equal(reply.index, 0);
    assert_int_equal(reply.state, 1);
    s.r.op = TFA_OP_KINEMATICS; /* nothing that reads velocities */
    assert_int_equal(tfa_request_check(flexible, &s.r, &reply), TFA_OK);
    modes[5] = NAN;
    assert_int_equal(tfa_request_check(flexible, &s.r, &reply), TFA_E_VALUE);
    assert_int_equal(reply.field, TFA_FIELD_MODES);
    assert_int_equal(reply.index, 1);
    assert_int_equal(reply.state, 2);
    tfa_model_free(flexible);
}

/* Also in a request of the form of the last one, of which less is checked */
TEST(bad_constraints_are_named)
{
    tfa_model *closed = build_closed();
    SCOPED_WORKSPACE *answers = workspace_for(closed, NULL);
    double gains[2] = {4, 4}, weights[NV], wanted[6 * STATES] = {0};
    for (int k = 0; k < NV; k++)
        weights[k] = 1;
    const struct {
        double *number, value;
        int status;
        tfa_field field;
        uint32_t index, state;
    } rows[] = {
        {&gains[1], -1, TFA_E_ARGUMENT, TFA_FIELD_STABILISATION, 1, 0},
        {&gains[0], NAN, TFA_E_VALUE, TFA_FIELD_STABILISATION, 0, 0},
        {&weights[2], 0, TFA_E_ARGUMENT, TFA_FIELD_TORQUE_WEIGHTS, 2, 0},
        {&weights[NV - 1], INFINITY, TFA_E_VALUE, TFA_FIELD_TORQUE_WEIGHTS, NV - 1, 0},
        {&wanted[6 + 4], NAN, TFA_E_VALUE, TFA_FIELD_CONSTRAINT_ACCELERATION, 4, 1},
    };
    struct scene s;
    tfa_reply reply = {0};
    set_scene(&s);
    s.r.op = TFA_OP_CONSTRAINED_INVERSE_DYNAMICS;
    assert_int_equal(tfa_compute(answers, &s.r, &reply), TFA_E_SIZE);
    assert_int_equal(reply.field, TFA_FIELD_CONSTRAINTS);
    s.r.constraints = 5;
    assert_int_equal(tfa_compute(answers, &s.r, &reply), TFA_E_ARGUMENT);
    assert_int_equal(reply.field, TFA_FIELD_CONSTRAINTS);
    assert_int_equal(reply.index, 2);
    s.r.constraints = 1;
    s.r.constraint_acceleration = wanted;
    s.r.stabilisation = gains;
    s.r.torque_weights = weights;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double good = *rows[k].number;
        assert_int_equal(tfa_compute(answers, &s.r, &reply), TFA_OK);
        *rows[k].number = rows[k].value;
        assert_int_equal(tfa_compute(answers, &s.r, &reply), rows[k].status);
        assert_int_equal(reply.field, rows[k].field);
        assert_int_equal(reply.index, rows[k].index);
        assert_int_equal(reply.state, rows[k].state);
        *rows[k].number = good;
    }
    tfa_model_free(closed);
}

TEST(missing_arrays_are_named)
{
    for (size_t k = 0; k < sizeof missing / sizeof *missing; k++) {
        struct scene s;
        const double *none = NULL;
        set_scene(&s);
        memcpy((char *)&s.r + missing[k].member, &none, sizeof none);
        expect(missing[k].what, &s.r, TFA_E_ARGUMENT, missing[k].field, 0, 0);
    }
    struct scene s;
    set_scene(&s);
    s.r.op = TFA_OP_OPERATIONAL_INERTIA;
    s.r.tip_count = 0;
    expect("no tips", &s.r, TFA_E_SIZE, TFA_FIELD_TIPS, 0, 0);
}

/* Which method answers which op is what the public list says. */
TEST(methods_answer_their_ops)
{
    static const struct {
        tfa_method method;
        const char *name;
        unsigned ops;
    } rows[] = {
#define ROW(name, number, text, ops, factors, cost, refuses, what) {TFA_METHOD_##name, text, ops},
        TFA_METHOD_LIST(ROW)
#undef ROW
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_method method = rows[k].method;
        struct scene s;
        set_scene(&s);
        assert_int_equal(tfa_method_find(rows[k].name), method);
        assert_string_equal(tfa_method_name(method), rows[k].name);
        s.r.method = method;
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++) {
            const int answers = (rows[k].ops & TFA_OP_BIT(op)) != 0;
            s.r.op = (tfa_op)op;
            if (answers && tfa_method_describe(method)->refuses & TFA_REFUSES_TIPS)
                s.r.tip_count = 0;
            expect(rows[k].name, &s.r, answers ? TFA_OK : TFA_E_METHOD,
                   answers ? TFA_FIELD_NONE : TFA_FIELD_METHOD, answers ? 0 : method, 0);
        }
    }
    assert_int_equal(tfa_method_find("no such method"), -1);
}

/* On a fixed base the fields of the base are not read. */
TEST(fixed_base_ignores_base_fields)
{
    struct scene s;
    double qdd[2][NV * STATES];
    tfa_model *fixed = build(NULL);
    tfa_workspace *w = workspace_for(fixed, NULL);
    set_scene(&s);
    tfa_reply reply = {.qdd = qdd[0]};
    s.pose[0] = s.twist[3] = s.wrench[1] = NAN;
    assert_int_equal(tfa_compute(w, &s.r, &reply), TFA_OK);
    s.r.base_pose = s.r.base_twist = s.r.base_wrench = s.r.base_acceleration = NULL;
    reply.qdd = qdd[1];
    assert_int_equal(tfa_compute(w, &s.r, &reply), TFA_OK);
    assert_memory_equal(qdd[0], qdd[1], sizeof qdd[0]);
    tfa_workspace_free(w);
    tfa_model_free(fixed);
}

TEST(workspace_wants_its_memory)
{
    size_t size = tfa_workspace_size(model, NULL);
    char *memory = aligned_alloc(64, (size + 127) / 64 * 64);
    tfa_workspace *w = NULL;
    assert_int_equal(tfa_workspace_init(memory, size - 1, model, NULL, &w), TFA_E_MEMORY);
    assert_null(w);
    assert_int_equal(tfa_workspace_init(memory + 8, size, model, NULL, &w), TFA_E_MEMORY);
    assert_int_equal(tfa_workspace_init(memory, size, model, NULL, &w), TFA_OK);
    struct scene s;
    double qdd[NV * STATES], again[NV * STATES];
    tfa_reply reply = {.qdd = qdd};
    set_scene(&s);
    assert_int_equal(tfa_compute(w, &s.r, &reply), TFA_OK);
    reply.qdd = again;
    assert_int_equal(tfa_compute(workspace, &s.r, &reply), TFA_OK);
    assert_memory_equal(qdd, again, sizeof qdd);
    free(memory);
}

int main(void)
{
    return test_run(setup, teardown);
}
