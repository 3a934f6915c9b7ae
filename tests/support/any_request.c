/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See any_request.h.
 */
#include "any_request.h"

#include "ipc/wire_blocks.h"
#include "test.h"
#include "wait.h"

double any_numbers[8][ANY_COUNT], any_pose[ANY_BATCH * 7];
static double weights[ANY_COUNT];

__attribute__((constructor)) static void fill_numbers(void)
{
    uint64_t s = 12345;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < ANY_COUNT; i++) {
            s = s * 6364136223846793005u + 1442695040888963407u;
            any_numbers[k][i] = (double)(int64_t)(s >> 11) / 4503599627370496.0 - 1;
        }
    for (size_t i = 0; i < ANY_BATCH; i++) {
        const double pose[7] = {0.1 * (double)i, 0.2, 0.3, 0.6, 0, 0, 0.8};
        memcpy(any_pose + 7 * i, pose, sizeof pose);
    }
    for (int i = 0; i < ANY_COUNT; i++)
        weights[i] = 0.5 + i % 7;
}

/* Flags that an op refuses */
static uint32_t unanswered(tfa_op op)
{
    return (TFA_OP_BIT(op) & TFA_OPS_MOTION ? 0 : TFA_WANT_JOINT_FORCES) |
           (TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED_SOLVE ? 0 : TFA_WANT_DELASSUS) |
           (TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED ? TFA_WANT_OF_SOLVE : 0);
}

static void set_constraints(tfa_request *r, unsigned i, unsigned choice,
                            const tfa_client_info *info)
{
    static const double gains[2] = {100, 20};
    const uint32_t all = tfa_all_constraints(info->constraint_count);
    r->constraints = choice % 8 == 7 ? 0 : i % 83 == 81 ? all + 1 : choice % 3 == 1 ? all & 1 : all;
    r->constraint_acceleration = choice % 5 == 1 ? NULL : any_numbers[6];
    r->stabilisation = choice % 4 == 3 ? gains : NULL;
    r->torque_weights = choice % 2 ? weights : NULL;
}

tfa_request any_request(unsigned i, const tfa_client_info *info)
{
    static const double loads[2 * TFA_PAYLOAD_NUMBERS] = {0.5, 0.1,  0, 0.2,  0.01, 0.001,
                                                          0,   0.02, 0, 0.03, 2},
                                  moon[3] = {0, 0.1, -1.62}, threshold[1] = {1e-4};
    static _Thread_local uint32_t joints[1];
    const unsigned op = i % 13, flag = i / 13 % 16, choice = i / 208;
    tfa_request r = {.op = (tfa_op)op, /* 0 is none */
                     .method = (tfa_method)(choice % 3 ? 0 : (i / 7) % 18),
                     .estimate = (tfa_estimate)(choice / 2 % 4),
                     .frame = (tfa_reference_frame)(choice % 3),
                     .refine = choice % 5 == 4 ? 2 : TFA_REFINE_DEFAULT,
                     .flags = flag == 0    ? 0
                              : flag == 15 ? TFA_WANT_ALL & ~unanswered((tfa_op)op)
                                           : 1u << (flag - 1),
                     .count = choice % 2 ? ANY_BATCH : 1,
                     .rows = (tfa_rows)(choice / 3 % 2),
                     .rank_loss = (tfa_rank_loss)(choice / 5 % 3),
                     .tip_count = choice / 2 % 3,
                     .wrench_count = choice % 4 == 1 ? 2 : 0,
                     .payload_count = choice % 4 == 2 ? 2 : 0,
                     .locked_count = choice % 7 == 3 ? 1 : 0,
                     .q = any_numbers[0],
                     .v = choice % 6 == 5 ? NULL : any_numbers[1],
                     .tau = any_numbers[2],
                     .qdd = any_numbers[3],
                     .base_pose = any_pose,
                     .base_twist = any_numbers[4],
                     .base_wrench = any_numbers[5],
                     .base_acceleration = any_numbers[6],
                     .gravity = choice % 5 == 2 ? moon : NULL,
                     .wrenches = any_numbers[7],
                     .payloads = loads,
                     .locked = joints,
                     .task_acceleration = any_numbers[4],
                     .rank_threshold = choice % 9 == 8 ? threshold : NULL};
    r.tips[0] = info->frame_count - 1;
    r.tips[1] = i % 83 == 82 ? info->frame_count : info->frame_count / 2; /* or none */
    r.wrench_frames[0] = info->frame_count - 1;
    r.wrench_frames[1] = info->frame_count / 3;
    r.payload_frames[0] = info->frame_count - 1;
    r.payload_frames[1] = info->frame_count / 2;
    joints[0] = info->joint_count / 2;
    if (choice % 4) /* one refusal of four is enough */
        r.flags &= ~unanswered((tfa_op)op);
    set_constraints(&r, i, choice, info);
    return r;
}

any_answers any_answers_make(const tfa_client_info *info)
{
    const size_t n = info->v_count + info->base_freedoms, closed = 6 * info->constraint_count,
                 rows = closed > 12 ? closed : 12, wide = n > rows ? n : rows,
                 frames = 7 * info->frame_count;
    const size_t words = ANY_BATCH * (wide * wide > frames ? wide * wide : frames);
    any_answers a = {.bytes = TFA_WIRE_REPLY_BLOCKS * words * sizeof(double)};
    a.numbers = calloc(1, a.bytes);
    assert_non_null(a.numbers);
#define POINT_AT(name, field, ...) a.reply.field = (void *)(a.numbers + TFA_WIRE_##name * words);
    TFA_OUTPUT_LIST(POINT_AT)
#undef POINT_AT
    return a;
}

void any_answers_free(any_answers *a)
{
    free(a->numbers);
}

static void check_refusal(const any_client *c, const tfa_request *r, const tfa_reply *here,
                          const tfa_reply *there)
{
    if (here->status != there->status || here->field != there->field ||
        here->index != there->index || here->state != there->state)
        fail_msg("%s: op %d, method %d, flags %x, count %u: %s, %s %u, state %u, not %s, %s %u, %u",
                 c->name, r->op, r->method, r->flags, r->count, tfa_status_name(there->status),
                 tfa_field_name(there->field), there->index, there->state,
                 tfa_status_name(here->status), tfa_field_name(here->field), here->index,
                 here->state);
}

int any_compare(const any_client *c, const tfa_request *r)
{
    SCOPED(any_answers_free) any_answers here = any_answers_make(c->info);
    SCOPED(any_answers_free) any_answers there = any_answers_make(c->info);
    tfa_exchange times = {0};
    const int expected = tfa_compute(c->library, r, &here.reply);
    const int status = c->call(c->client, r, &there.reply, WAIT_NS, &times);
    if (!c->dds || there.reply.model != 0)
        check_refusal(c, r, &here.reply, &there.reply);
    if (status != expected)
        fail_msg("%s: op %d, method %d, flags %x, count %u: %s, not %s", c->name, r->op, r->method,
                 r->flags, r->count, tfa_status_name(status), tfa_status_name(expected));
    assert_true(times.t_sent != 0 || status != TFA_OK); /* the client refuses by itself, too */
    assert_true(there.reply.model == here.reply.model ||
                (there.reply.model == 0 && status != TFA_OK));
    if (memcmp(here.numbers, there.numbers, here.bytes) != 0)
        fail_msg("%s: op %d, method %d, flags %x, count %u: other bits", c->name, r->op, r->method,
                 r->flags, r->count);
    assert_true(times.t_sent <= times.t_reply);
    return status;
}

void any_compare_all(const any_client *c, unsigned step)
{
    unsigned answered = 0;
    for (unsigned i = 0; i < ANY_REQUESTS; i += ANY_STEP(step)) {
        tfa_request r = any_request(i, c->info);
        if (r.estimate == TFA_ESTIMATE_DEFAULT) /* a daemon has a policy */
            r.estimate = TFA_ESTIMATE_ALWAYS;
        answered += (!c->dds || (r.op != 0 && r.op <= TFA_OP_LAST)) && any_compare(c, &r) == TFA_OK;
    }
    assert_true(answered > ANY_REQUESTS / ANY_STEP(step) / 4);
}

void any_compare_mistakes(const any_client *c)
{
    static const uint32_t joints[4] = {2, 0, 1};
    static double q[ANY_COUNT], loads[2 * TFA_PAYLOAD_NUMBERS];
    const double bad_pose[14] = {0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 1};
    const uint32_t stranger = c->info->joint_count;
    tfa_request good = any_request(209, c->info), r; /* forward dynamics of a batch */
    good.estimate = TFA_ESTIMATE_ALWAYS;
    good.count = 2;
    good.tip_count = good.wrench_count = 0;
    good.payload_count = good.locked_count = 2;
    good.payloads = loads;
    good.locked = joints;
#define REFUSED(status, ...)                                                                       \
    do {                                                                                           \
        r = good;                                                                                  \
        memcpy(q, any_numbers[0], sizeof q);                                                       \
        memcpy(loads, any_request(0, c->info).payloads, sizeof loads);                             \
        __VA_ARGS__;                                                                               \
        assert_int_equal(any_compare(c, &r), status);                                              \
        memcpy(loads, any_request(0, c->info).payloads, sizeof loads);                             \
        assert_int_equal(any_compare(c, &good), TFA_OK);                                           \
    } while (0)
    REFUSED(TFA_OK, );
    if (!c->dds) {
        REFUSED(TFA_E_ARGUMENT, r.op = (tfa_op)0);
        REFUSED(TFA_E_ARGUMENT, r.op = (tfa_op)(TFA_OP_LAST + 1));
        REFUSED(TFA_E_ARGUMENT, r.locked = NULL); /* no joint, over DDS */
    }
    REFUSED(TFA_E_METHOD, r.method = (tfa_method)99);
    REFUSED(TFA_E_METHOD, r.method = TFA_METHOD_RNEA);
    REFUSED(TFA_E_ARGUMENT, r.frame = (tfa_reference_frame)3);
    REFUSED(TFA_E_ARGUMENT, r.frame = (tfa_reference_frame)7);
    REFUSED(TFA_E_ARGUMENT, r.estimate = (tfa_estimate)8);
    REFUSED(TFA_E_ARGUMENT, r.refine = TFA_MAX_REFINE + 1);
    REFUSED(TFA_E_SIZE, r.count = 0);
    REFUSED(TFA_E_ARGUMENT, r.q = NULL);
    REFUSED(TFA_E_SIZE, r.tip_count = TFA_MAX_TIPS + 1);
    REFUSED(TFA_E_LINK, r.tip_count = 1; r.tips[0] = 100000);
    REFUSED(TFA_E_SIZE, r.op = TFA_OP_OPERATIONAL_INERTIA);
    REFUSED(TFA_E_SIZE, r.wrench_count = 9);
    REFUSED(TFA_E_ARGUMENT, r.wrench_count = 1; r.wrenches = NULL);
    REFUSED(TFA_E_LINK, r.wrench_count = 1; r.wrench_frames[0] = 5000);
    REFUSED(TFA_E_VALUE, q[3] = NAN; r.q = q);
    REFUSED(TFA_E_VALUE, q[3] = NAN; r.v = q);
    REFUSED(TFA_E_VALUE, q[3] = INFINITY; r.tau = q);
    REFUSED(c->info->base_freedoms ? TFA_E_QUATERNION : TFA_OK, r.base_pose = bad_pose);
    REFUSED(c->info->base_freedoms ? TFA_E_ARGUMENT : TFA_OK, r.base_pose = NULL);
    REFUSED(TFA_E_SIZE, r.payload_count = TFA_MAX_PAYLOADS + 1);
    REFUSED(TFA_E_ARGUMENT, r.payloads = NULL);
    REFUSED(TFA_E_LINK, r.payload_frames[1] = c->info->frame_count);
    REFUSED(TFA_E_VALUE, loads[13] = NAN);
    REFUSED(TFA_E_ARGUMENT, loads[0] = -1);
    REFUSED(TFA_E_ARGUMENT, loads[14] = -1);
    REFUSED(TFA_E_SIZE, r.locked_count = c->info->v_count + 1);
    REFUSED(TFA_E_SIZE, r.locked_count = UINT32_MAX);
    REFUSED(TFA_E_JOINT, r.locked_count = 1; r.locked = &stranger);
    REFUSED(TFA_E_METHOD, r.method = TFA_METHOD_CRBA);
    REFUSED(TFA_E_UNSUPPORTED, r.op = TFA_OP_MASS_MATRIX);
    REFUSED(TFA_E_SIZE, r.op = TFA_OP_IMPACT; r.constraints = 0);
    REFUSED(TFA_E_ARGUMENT, r.op = TFA_OP_IMPACT; r.constraints = 1u << c->info->constraint_count);
#undef REFUSED
}

void any_check_info(const tfa_client_info *info, const tfa_model *model)
{
    assert_int_equal(info->q_count, tfa_model_q_count(model));
    assert_int_equal(info->v_count, tfa_model_v_count(model));
    assert_int_equal(info->base_freedoms, tfa_model_base_freedoms(model));
    assert_int_equal(info->joint_count, tfa_model_joint_count(model));
    assert_int_equal(info->frame_count, tfa_model_frame_count(model));
    assert_int_equal(info->constraint_count, tfa_model_constraint_count(model));
    assert_string_equal(info->model_hash, tfa_model_hash_text(model));
    for (uint32_t i = 0; i < info->joint_count; i++) {
        assert_string_equal(info->joint_names[i], tfa_model_joint(model, i).name);
        assert_int_equal(info->joint_types ? info->joint_types[i] : tfa_model_joint(model, i).type,
                         tfa_model_joint(model, i).type);
    }
    for (uint32_t i = 0; i < info->frame_count; i++)
        assert_string_equal(info->frame_names[i], tfa_model_frame(model, i).name);
    for (uint32_t i = 0; i < info->constraint_count; i++)
        assert_string_equal(info->constraint_names[i], tfa_model_constraint(model, i).name);
}
