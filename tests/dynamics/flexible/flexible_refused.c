/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What robots with flexible links refuse: at compilation, with a message that names it; of a
 * request, with a status and a field.
 */
#include "models.h"
#include "support/flexible_robot.h"
#include "support/small_robot.h"
#include "test.h"

enum { N = 2 };

/* root - l1 = l2 (fixed) - l3, l1 - l4; l1 has modes. Joint k carries link k + 1. */
typedef struct hand {
    small_robot r;
    double momentum[6 * N], mass[N * N], K[N * N], D[N * N], limit[N], shapes[2][6 * N];
    tfa_mode_shape shape[3];
    tfa_link_modes modes[2];
    tfa_scene scene;
    tfa_model_options options;
} hand;

static void make(hand *h)
{
    memset(h, 0, sizeof *h);
    small_robot_begin(&h->r);
    small_robot_add(&h->r, 0, TFA_JOINT_REVOLUTE, 0, 0, 1);
    small_robot_add(&h->r, 1, TFA_JOINT_FIXED, 1, 0, 0)->xyz[0] = 1;
    small_robot_add(&h->r, 2, TFA_JOINT_REVOLUTE, 0, 1, 0)->xyz[0] = 0.5;
    small_robot_add(&h->r, 1, TFA_JOINT_REVOLUTE, 1, 0, 0)->xyz[1] = 0.5;
    for (uint32_t k = 0; k < 5; k++)
        small_robot_load(&h->r, k, 1, 0.1, 0.1, 0.1);
    h->momentum[1] = h->momentum[5] = 0.3;
    h->momentum[6 + 2] = 0.2;
    for (int k = 0; k < N; k++) {
        h->mass[k * N + k] = 1;
        h->K[k * N + k] = 100;
        h->limit[k] = 0.1;
        h->shapes[0][6 * k + 1] = h->shapes[1][6 * k + 4] = 0.5;
        h->shape[k] = (tfa_mode_shape){h->r.joint[k ? 3 : 1].name, h->shapes[k]};
    }
    h->modes[0] = (tfa_link_modes){.link = h->r.link[1].name,
                                   .mode_count = N,
                                   .momentum = h->momentum,
                                   .mass = h->mass,
                                   .stiffness = h->K,
                                   .damping = h->D,
                                   .limit = h->limit,
                                   .shapes = h->shape,
                                   .shape_count = 2};
    h->scene = (tfa_scene){.modes = h->modes, .modes_count = 1};
    h->options = (tfa_model_options){.scene = &h->scene};
}

/* ---- compilation ---- */

static void as_it_is(hand *h)
{
    (void)h;
}
static void unknown_link(hand *h)
{
    h->modes[0].link = "nowhere";
}
static void unknown_joint(hand *h)
{
    h->shape[2] = (tfa_mode_shape){"nowhere", h->shapes[0]};
    h->modes[0].shape_count = 3;
}
static void joint_of_another_link(hand *h)
{
    h->shape[2] = (tfa_mode_shape){h->r.joint[2].name, h->shapes[0]};
    h->modes[0].shape_count = 3;
}
static void joint_without_shape(hand *h)
{
    h->modes[0].shape_count = 1;
}
static void no_modes(hand *h)
{
    h->modes[0].mode_count = 0;
}
static void too_many_modes(hand *h)
{
    h->modes[0].mode_count = TFA_MAX_LINK_MODES + 1;
}
static void twice(hand *h)
{
    h->modes[1] = h->modes[0];
    h->scene.modes_count = 2;
}
static void two_in_a_body(hand *h)
{
    static const double own[6 * N] = {0};
    static tfa_mode_shape shape;
    h->modes[1] = h->modes[0];
    h->modes[1].link = h->r.link[2].name;
    h->modes[1].momentum = own;
    shape = (tfa_mode_shape){h->r.joint[2].name, own};
    h->modes[1].shapes = &shape;
    h->modes[1].shape_count = 1;
    h->scene.modes_count = 2;
}
static void does_not_move(hand *h)
{
    h->r.joint[0].type = TFA_JOINT_FIXED;
}
static void negative_mass(hand *h)
{
    h->mass[0] = -1;
}
static void singular_mass(hand *h)
{
    for (int k = 0; k < N * N; k++)
        h->mass[k] = 1;
}
static void skew_mass(hand *h)
{
    h->mass[1] = 0.1;
}
static void skew_stiffness(hand *h)
{
    h->K[1] = 3;
}
static void skew_damping(hand *h)
{
    h->D[1] = 3;
}
static void momentum_beyond_the_mass(hand *h)
{
    h->momentum[1] = 2; /* l.l > m M */
}
static void no_limit(hand *h)
{
    h->limit[1] = 0;
}
static void not_finite(hand *h)
{
    h->momentum[3] = NAN;
}
static void projected_mimic(hand *h)
{
    h->r.joint[3].mimic = 2;
    h->r.joint[3].multiplier = 1;
    h->options.mimic = TFA_MIMIC_PROJECT;
}

static const struct {
    const char *what;
    void (*change)(hand *h);
    int status;
    const char *word; /* of the message */
} mistakes[] = {
    {"as it is", as_it_is, TFA_OK, NULL},
    {"unknown link", unknown_link, TFA_E_MODEL, "nowhere"},
    {"unknown joint", unknown_joint, TFA_E_MODEL, "nowhere"},
    {"joint of another link", joint_of_another_link, TFA_E_MODEL, "j2"},
    {"joint without shape", joint_without_shape, TFA_E_MODEL, "j3"},
    {"no modes", no_modes, TFA_E_MODEL, "l1"},
    {"too many modes", too_many_modes, TFA_E_MODEL, "l1"},
    {"a link twice", twice, TFA_E_MODEL, "l1"},
    {"two in a body", two_in_a_body, TFA_E_MODEL, "l2"},
    {"does not move", does_not_move, TFA_E_MODEL, "l1"},
    {"negative mass", negative_mass, TFA_E_MODEL, "l1"},
    {"singular mass", singular_mass, TFA_E_MODEL, "l1"},
    {"skew mass", skew_mass, TFA_E_MODEL, "l1"},
    {"skew stiffness", skew_stiffness, TFA_E_MODEL, "l1"},
    {"skew damping", skew_damping, TFA_E_MODEL, "l1"},
    {"momentum beyond the mass", momentum_beyond_the_mass, TFA_E_MODEL, "l1"},
    {"limit 0", no_limit, TFA_E_MODEL, "l1"},
    {"not finite", not_finite, TFA_E_MODEL, "l1"},
    {"projected mimic", projected_mimic, TFA_E_MODEL, "j3"},
};

TEST(compilation_refuses_by_name)
{
    int wrong = 0;
    for (size_t k = 0; k < sizeof mistakes / sizeof *mistakes; k++) {
        hand h;
        tfa_report report = {0};
        tfa_model *model = NULL;
        char text[500] = "";
        make(&h);
        mistakes[k].change(&h);
        const int status = tfa_model_create(&h.r.d, &h.options, &report, &model);
        for (size_t m = 0; m < report.count; m++)
            if (report.messages[m].severity == TFA_ERROR && !*text)
                tfa_report_format(&report, m, text, sizeof text);
        const bool good = status == mistakes[k].status &&
                          (!mistakes[k].word || strstr(text, mistakes[k].word));
        print_message("  %s%s: %s: %s\n", good ? "" : "WRONG: ", mistakes[k].what,
                      tfa_status_text(status), text);
        wrong += !good;
        tfa_report_free(&report);
        tfa_model_free(model);
    }
    assert_int_equal(wrong, 0);
}

/* ---- what a model says of its modes ---- */

TEST(modes_have_names_in_the_order_of_the_links)
{
    hand h;
    make(&h);
    SCOPED_MODEL *model = compiled(&h.r.d, &h.options);
    assert_int_equal(tfa_model_mode_count(model), N);
    for (uint32_t k = 0; k < N; k++) {
        const tfa_mode_info info = tfa_model_mode(model, k);
        assert_string_equal(info.link, "l1");
        assert_int_equal(info.index, k);
        assert_true(info.limit == 0.1);
    }
    assert_null(tfa_model_mode(model, N).link);
    h.modes[0].limit = NULL;
    SCOPED_MODEL *unlimited = compiled(&h.r.d, &h.options);
    assert_true(isinf(tfa_model_mode(unlimited, 0).limit));
}

/* ---- requests ---- */

static const double q[3] = {0.1, 0.2, 0.3}, eta[2 * N] = {0.01, 0.02, 0.03, 0.2},
                    beyond[N] = {0.01, -0.11}, nan_second[N] = {0, NAN};
static double payload[TFA_PAYLOAD_NUMBERS] = {1, 0, 0, 0, 1, 0, 0, 1, 0, 1};
static const uint32_t locked[1] = {1};

static tfa_request good(void)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = q,
                         .modes = eta,
                         .mode_velocities = eta};
}

static void assert_refused(const tfa_model *model, tfa_workspace *w, const tfa_request *r,
                           int status, tfa_field field)
{
    double numbers[800];
    tfa_reply reply = {.qdd = numbers, .lambda_inv = numbers, .mass_matrix = numbers},
              checked = {0};
    if (tfa_compute(w, r, &reply) != status || reply.field != field)
        fail_msg("op %d, method %s: %s, field %s; expected %s, %s", r->op,
                 tfa_method_name((uint32_t)r->method), tfa_status_text(reply.status),
                 tfa_field_name(reply.field), tfa_status_text(status), tfa_field_name(field));
    assert_int_equal(tfa_request_check(model, r, &checked), status);
    assert_int_equal(checked.field, field);
    assert_int_equal(checked.index, reply.index);
    if (status == TFA_E_VALUE)
        assert_int_equal(reply.index, 1);
}

TEST(requests_are_refused_by_field)
{
    static const unsigned served = TFA_OP_BIT(TFA_OP_FORWARD_DYNAMICS) |
                                   TFA_OP_BIT(TFA_OP_OPERATIONAL_INERTIA) |
                                   TFA_OP_BIT(TFA_OP_KINEMATICS);
    static const uint32_t flags[] = {TFA_WANT_LAMBDA, TFA_WANT_MU, TFA_WANT_P,
                                     TFA_WANT_JOINT_FORCES};
    hand h;
    make(&h);
    SCOPED_MODEL *model = compiled(&h.r.d, &h.options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    for (uint32_t op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        tfa_request r = good();
        r.op = (tfa_op)op;
        r.tip_count = 1;
        const double acceleration[6] = {0};
        r.task_acceleration = acceleration;
        const bool serves = served & TFA_OP_BIT(op);
        assert_refused(model, w, &r, serves ? TFA_OK : TFA_E_UNSUPPORTED,
                       serves ? TFA_FIELD_NONE : TFA_FIELD_OP);
    }
    for (size_t k = 0; k < 4; k++) {
        tfa_request r = good();
        r.flags = flags[k];
        r.tip_count = 1;
        assert_refused(model, w, &r, TFA_E_UNSUPPORTED, TFA_FIELD_FLAGS);
    }
    tfa_request r = good();
    r.locked = locked;
    r.locked_count = 1;
    assert_refused(model, w, &r, TFA_E_UNSUPPORTED, TFA_FIELD_LOCKED);
    for (uint32_t frame = 1; frame < 5; frame++) { /* 1 and 2 are the flexible body */
        r = good();
        r.payloads = payload;
        r.payload_count = 1;
        r.payload_frames[0] = frame;
        assert_refused(model, w, &r, frame < 3 ? TFA_E_UNSUPPORTED : TFA_OK,
                       frame < 3 ? TFA_FIELD_PAYLOADS : TFA_FIELD_NONE);
    }
    r = good();
    r.modes = nan_second;
    assert_refused(model, w, &r, TFA_E_VALUE, TFA_FIELD_MODES);
    r = good();
    r.mode_velocities = nan_second;
    assert_refused(model, w, &r, TFA_E_VALUE, TFA_FIELD_MODE_VELOCITIES);
}

TEST(methods_are_refused)
{
    static const tfa_method serve[] = {TFA_METHOD_AUTO,          TFA_METHOD_ABA,
                                       TFA_METHOD_PROPAGATION,   TFA_METHOD_SCAN,
                                       TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_DCA};
    static const tfa_op ops[] = {TFA_OP_FORWARD_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA};
    hand h;
    make(&h);
    SCOPED_MODEL *model = compiled(&h.r.d, &h.options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    for (int k = 0; k < 2; k++)
        for (uint32_t m = 0; tfa_method_describe(m); m++) {
            tfa_request r = good();
            bool serves = false;
            r.op = ops[k];
            r.method = (tfa_method)m;
            r.tip_count = k == 1;
            for (size_t s = 0; s < sizeof serve / sizeof *serve; s++)
                serves |= (uint32_t)serve[s] == m;
            if (!(tfa_method_describe(m)->ops & TFA_OP_BIT(ops[k])))
                continue;
            assert_refused(model, w, &r, serves ? TFA_OK : TFA_E_METHOD,
                           serves ? TFA_FIELD_NONE : TFA_FIELD_METHOD);
        }
}

/* A modal coordinate beyond its limit is answered, and flagged in its state alone. */
TEST(limits_are_flagged)
{
    hand h;
    make(&h);
    SCOPED_MODEL *model = compiled(&h.r.d, &h.options);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    const double twice[6] = {0};
    double qdd[6], modes[2 * N];
    tfa_answer answers[2];
    tfa_reply reply = {.qdd = qdd, .modes = modes, .answers = answers};
    tfa_request r = good();
    r.q = twice;
    r.count = 2;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    assert_false(answers[0].flags & TFA_ANSWER_MODE_LIMIT);
    assert_true(answers[1].flags & TFA_ANSWER_MODE_LIMIT);
    r.count = 1;
    r.modes = beyond;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    assert_true(answers[0].flags & TFA_ANSWER_MODE_LIMIT);
}
